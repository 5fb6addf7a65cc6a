"""One fit for all held-out takes: the same rows as a fit for each, in any number of processes, whatever is skipped."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetograph.errors import RequestError
from kinetograph.evaluation import Run, WalkRow, held_out_motion, leave_one_take_out, walk_row
from kinetograph.evaluation import protocol as rooms
from kinetograph.library import Library
from kinetograph.library.keeping import keeping_folder
from kinetograph.methods.performance import PerformanceControl
from kinetograph.motion import Motion
from kinetograph.take import Annotation, Take
from kinetograph.work import Workers
from walkers import walk

_METHOD = PerformanceControl(stretch=0.1)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    """Three walks, one of nobody stepping, and one of a few frames."""
    made = Library.create(tmp_path / "library")
    for name, turn in (("a", 0.0), ("b", 0.3), ("c", -0.2)):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(11) / 2)
        made.add(Take(name, {"body": walk(5.0, turn_rate=turn)}, cuts))
    still = walk(3.0)
    still = Motion(still.skeleton, still.translation[:1].repeat(len(still), 0), still.rotations * 0 + [1, 0, 0, 0], 30)
    made.add(Take("idle", {"body": still}))
    short = walk(0.2)
    made.add(Take("short", {"body": short}, tuple(Annotation("body", "cut", "", t, t) for t in (0.0, 0.2))))
    return made


def _timeless(rows: list[WalkRow]) -> list[str]:
    return [repr(replace(row, times_real_time=0.0)) for row in rows]


def test_rows_are_those_of_a_fit_for_each_take(library: Library) -> None:
    told: list[str] = []
    rows = leave_one_take_out(_METHOD, library, run=Run(note=told.append))
    assert [row.take for row in rows] == ["a", "b", "c"]
    for row in rows:
        model, truth = _METHOD.fit(library, exclude=[row.take]), held_out_motion(library.take(row.take))
        expected = walk_row(row.take, model, truth, model.synthesize(truth), 1.0)
        figures = {name: (value, vars(row)[name]) for name, value in vars(expected).items()}
        differing = {name for name, (one, other) in figures.items() if repr(one) != repr(other)}
        assert differing <= {"times_real_time", "segment_errors", "pattern_errors"}
    assert len(told) == 2
    assert any("1 take not evaluated: idle" in line and "(idle)" in line for line in told)
    assert any("1 take not evaluated: the control is too short" in line for line in told)


def test_any_number_of_processes_gives_the_same_rows(library: Library) -> None:
    here = leave_one_take_out(_METHOD, library, baselines=True)
    two = leave_one_take_out(_METHOD, library, baselines=True, run=Run(workers=Workers(2)))
    assert _timeless(here) == _timeless(two)
    assert len(here) == 15


def test_only_some_are_held_out(library: Library) -> None:
    every = leave_one_take_out(_METHOD, library)
    (one,) = leave_one_take_out(_METHOD, library, run=Run(only=("b",)))
    assert _timeless([one]) == _timeless([row for row in every if row.take == "b"])
    with pytest.raises(RequestError, match="no take 'z'"):
        leave_one_take_out(_METHOD, library, run=Run(only=("z",)))
    with pytest.raises(RequestError, match="no take can be evaluated; 1 take left out: idle"):
        leave_one_take_out(_METHOD, library, run=Run(only=("idle",)))


def test_an_evaluation_that_was_stopped_goes_on(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    rows_of = rooms._rows_of

    def stopping(held: Any) -> Any:
        asked.append(held.take)
        if len(asked) == 2:
            raise KeyboardInterrupt
        return rows_of(held)

    monkeypatch.setattr(rooms, "_rows_of", stopping)
    with pytest.raises(KeyboardInterrupt):
        leave_one_take_out(_METHOD, library, run=Run(goes_on=True))
    again = leave_one_take_out(_METHOD, library, run=Run(goes_on=True))
    assert asked == ["a", "b", "b", "c", "short"]
    assert _timeless(again) == _timeless(leave_one_take_out(_METHOD, library))
    folder = keeping_folder(library)
    assert folder is not None
    assert not list((folder / "evaluating").iterdir())


def test_takes_that_are_left_out_by_held_out_take(library: Library) -> None:
    (row,) = leave_one_take_out(_METHOD, library, without={"a": ("b",)}, run=Run(only=("a",)))
    model, truth = _METHOD.fit(library, exclude=["a", "b"]), held_out_motion(library.take("a"))
    assert row.joint_cm == walk_row("a", model, truth, model.synthesize(truth), 1.0).joint_cm
