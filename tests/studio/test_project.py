"""Projects: read, written, and what undo takes back."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.errors import FormatError
from kinetograph.studio import Project, read_project, write_project
from kinetograph.studio.desk.history import KEPT, History
from kinetograph.studio.project import KeyRow, Keys, Lock, RuleRow, Walk

numbers = st.floats(-1e6, 1e6)
rules = st.builds(
    RuleRow, start=numbers, stop=numbers, take=st.none() | st.text(), source=st.none() | numbers, forbid=st.booleans()
)
walks = st.builds(
    Walk,
    path=st.lists(st.tuples(numbers, numbers, numbers)).map(tuple),
    smooth_time=numbers,
    mirror=st.booleans(),
    facing=st.none() | numbers,
    rules=st.lists(rules).map(tuple),
)
rows = st.builds(
    KeyRow,
    pose=st.text(),
    time=st.none() | numbers | st.tuples(numbers, numbers),
    position=st.none() | st.tuples(numbers, numbers),
    roles=st.none() | st.lists(st.text()).map(tuple),
    moved=st.dictionaries(st.text(), st.tuples(numbers, numbers, numbers)),
)
keys = st.builds(Keys, rows=st.lists(rows, max_size=3).map(tuple), moves=st.lists(st.text()).map(tuple))
locked = st.builds(Keys, lock=st.builds(Lock, span=st.tuples(numbers, numbers), of=keys))
projects = st.builds(Project, walk=walks, keys=keys | locked, libraries=st.dictionaries(st.text(), st.text()))


@given(project=projects)
def test_what_is_written_is_read(project: Project, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("project") / "project.json"
    write_project(project, path)
    assert read_project(path) == project


@pytest.mark.parametrize(
    "text",
    ["", "[]", '{"version": 2}', '{"walk": {"paths": []}}', '{"walk": {"path": [[0, 1]]}}', '{"mode": "fly"}', "\xff"],
)
def test_what_is_no_project_is_refused_in_one_line(text: str, tmp_path: Path) -> None:
    path = tmp_path / "project.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(FormatError, match="expected a project of the studio, found") as caught:
        read_project(path)
    assert "\n" not in str(caught.value)


def test_a_project_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"nowhere\.json: cannot open it"):
        read_project(tmp_path / "nowhere.json")


def _named(text: str) -> Project:
    return Project(character=text)


def test_undo_and_redo_go_back_and_forth() -> None:
    history = History(_named("a"))
    history.edit(_named("b"), "first")
    history.edit(_named("c"), "second")
    assert (history.undo_label, history.redo_label) == ("second", None)
    assert history.undo()
    assert (history.project, history.undo_label, history.redo_label) == (_named("b"), "first", "second")
    assert history.redo()
    assert history.project == _named("c")
    assert not history.redo()


def test_a_new_edit_forgets_what_was_taken_back() -> None:
    history = History(_named("a"))
    history.edit(_named("b"), "first")
    history.undo()
    history.edit(_named("c"), "second")
    assert history.redo_label is None
    assert history.undo()
    assert history.project == _named("a")


def test_a_slider_is_taken_back_as_one() -> None:
    history = History(_named("a"))
    for step in "bcd":
        history.edit(_named(step), "smooth", merge=True)
    history.edit(_named("e"), "draw", merge=True)
    history.undo()
    assert history.project == _named("d")
    history.undo()
    assert history.project == _named("a")


def test_an_edit_that_changes_nothing_is_none() -> None:
    history = History(_named("a"))
    assert not history.edit(_named("a"), "nothing")
    assert history.undo_label is None
    assert history.revision == 0


def test_the_past_is_bounded() -> None:
    history = History(_named("start"))
    for step in range(3 * KEPT):
        history.edit(_named(str(step)), "edit")
    steps = 0
    while history.undo():
        steps += 1
    assert steps == KEPT


def test_defaults_are_left_out() -> None:
    assert msgspec.json.encode(Project()) == b"{}"
