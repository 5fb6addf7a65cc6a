"""Takes of a library chosen by name and tag, on the command line."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import answer, invoke

from kinetograph.cli.options import expanded
from kinetograph.errors import RequestError
from kinetograph.library import Facts, Library, Selection, contents, describe_takes, labels, skeletons
from kinetograph.pipeline import open_library, open_without_labels
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take
from walkers import walk


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    made = Library.create(tmp_path_factory.mktemp("some") / "library")
    for number, name in enumerate(("01/walk_1", "01/run_1", "02/walk_1")):
        notes = (Annotation("motion", "move", f"turn {number}", 0, 1),)
        made.add(Take(name, {"motion": walk(2.0)}, notes))
    made.add(Take("speeds", {"speed": Signal(np.ones((4, 1)), ("speed",), "m/s", 1.0)}))
    describe_takes(made, {"01/run_1": Facts(frozenset({"fast"})), "02/walk_1": Facts(frozenset({"calm"}))})
    return made


@pytest.mark.parametrize(
    ("options", "takes"),
    [
        (("--takes", "walk*"), {"01/walk_1", "02/walk_1"}),
        (("--takes", "01/*", "--without", "fast"), {"01/walk_1"}),
        (("--tagged", "calm", "--tagged", "fast"), {"01/run_1", "02/walk_1"}),
        (("--without", "walk_1", "--exclude", "speeds"), {"01/run_1"}),
        (("--takes", "01/run_1"), {"01/run_1"}),
    ],
)
def test_export_writes_the_chosen_takes(
    options: tuple[str, ...], takes: set[str], library: Library, tmp_path: Path
) -> None:
    answer("library", "annotate", library.path, "--export", tmp_path / "a.csv", *options)
    rows = (tmp_path / "a.csv").read_text().splitlines()[1:]
    assert {row.split(",")[0] for row in rows} == takes


def test_a_library_without_tags_says_so(library: Library, tmp_path: Path) -> None:
    bare = Library.create(tmp_path / "bare")
    bare.add(library.take("01/walk_1"))
    with pytest.raises(RequestError, match="there are no tags yet, which kinetograph library label gives"):
        open_library(bare.path, Selection(tagged=("calm",)))


def test_info_counts_the_chosen_takes(library: Library) -> None:
    one = json.loads(answer("library", "info", library.path, "--tagged", "fast", "--json").stdout)
    assert (one["takes"], one["tracks"], one["frames"], one["skeletons"]) == (1, 1, 61, 1)
    assert one["annotations"] == {"move": 1}
    every = json.loads(answer("library", "info", library.path, "--json").stdout)
    assert (every["takes"], every["annotations"]) == (4, {"move": 3})


def test_what_a_library_lists_heeds_the_selection(library: Library) -> None:
    some = library.only(Selection(("01/*",)))
    assert [track.take for track in contents(some)] == ["01/walk_1", "01/run_1"]
    assert list(labels(some)) == ["01/walk_1", "01/run_1"]
    assert [takes for _, takes in skeletons(some)["motion"]] == [["01/walk_1", "01/run_1"]]
    assert skeletons(library.only(Selection(("speeds",)))) == {}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--takes", "jump*"), r"no take is called jump\*; there are 01/walk_1, .*; tags are calm, fast"),
        (("--takes", "01/*", "--tagged", "calm"), r"no take is called 01/\* and tagged calm; there are"),
        (("--without", "nobody"), "no take or tag 'nobody' to leave out; there are 01/walk_1"),
        (("--without", "*"), r"no take is not \*"),
    ],
)
def test_a_selection_of_nothing_is_refused(options: tuple[str, ...], message: str, library: Library) -> None:
    refused = invoke("library", "info", library.path, *options)
    assert re.search(message, str(refused.exception))


def test_a_table_names_its_takes_itself(library: Library) -> None:
    refused = invoke("library", "annotate", library.path, "--from", "a.csv", "--takes", "01/*")
    assert "choose what is exported" in str(refused.exception)


def test_a_search_leaves_out_takes_and_moves_by_one_option(library: Library) -> None:
    some, without = open_without_labels(library.path, Selection(without=("fast", "turn 2")))
    assert some.names() == ("01/walk_1", "02/walk_1", "speeds")
    assert without == ("turn 2",)
    everything, words = open_without_labels(library.path, Selection(without=("run",)))
    assert len(everything.names()) == 4  # a word of a take's name is left to the search
    assert words == ("run",)


def test_every_command_that_reads_a_library_chooses_takes() -> None:
    from kinetograph.cli import calibrate, evaluate, inbetween, live, perform, reproduce, sense
    from kinetograph.cli import library as libraries
    from kinetograph.cli.segment import segment

    commands = [
        *(perform.perform, inbetween.inbetween, sense.sense, live.sense, live.perform, calibrate.calibrate),
        *(evaluate.performance, evaluate.keyframe, evaluate.sensor, reproduce.xie2009),
        *(libraries.info, libraries.annotate, segment),
    ]
    for command in commands:
        assert {"takes", "tagged", "without"} <= set(expanded(command).__annotations__), command.__name__
