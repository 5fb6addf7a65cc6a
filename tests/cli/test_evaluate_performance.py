"""evaluate performance: one table of every measure, for walks as for dances, and no number where there is none."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import answer

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.take import Annotation, Take
from walkers import walk

_UNIT = np.array([1.0, 0.0, 0.0, 0.0])
_METHODS = ["segments", "nearest segment", "5 nearest frames", "ridge regression", "constant pose"]


def _library(folder: Path, named: bool) -> Path:
    library = kg.Library.create(folder / "library")
    for name, turn in (("a", 0.0), ("b", 0.3)):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(11) / 2)
        moves = (Annotation("body", "move", "step", 0.0, 5.0),) if named else ()
        library.add(Take(name, {"body": walk(5.0, turn_rate=turn)}, (*cuts, *moves)))
    return library.path


def test_every_method_and_measure_is_in_the_table(tmp_path: Path) -> None:
    result = answer("evaluate", "performance", "-l", _library(tmp_path, named=False), "--json")
    assert "no moves are annotated: segment and pattern errors are left out" in result.stderr
    assert "NaN" not in result.stdout
    rows = json.loads(result.stdout)
    assert [(r["take"], r["method"]) for r in rows] == [(t, m) for t in ("a", "b", "mean") for m in _METHODS]
    ours, constant = rows[0], rows[4]
    for measure in ("control_cm", "joint_cm", "relative_cm", "slide", "jerk", "distinct", "times_real_time"):
        assert isinstance(ours[measure], float)
    assert ours["segment_errors"] is None
    assert constant["slide"] is None
    assert isinstance(constant["joint_cm"], float)
    assert rows[10]["joint_cm"] == pytest.approx(0.5 * (rows[0]["joint_cm"] + rows[5]["joint_cm"]))


def test_moves_give_error_rates(tmp_path: Path) -> None:
    result = answer("evaluate", "performance", "-l", _library(tmp_path, named=True), "--no-baselines")
    assert "no moves" not in result.stderr
    head, *lines = result.stdout.splitlines()
    assert "segment errors  pattern errors" in head
    assert len(lines) == 3
    at = head.index("segment errors")
    assert [line[at:].split()[:2] for line in lines] == [["0", "0"]] * 3


def test_a_signal_is_no_partner(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    ends = ("left_toe", "right_toe", "left_hand", "right_hand")
    for name in "ab":
        motion = walk(4.0)
        signal = kg.Signal(np.zeros((len(motion), 4, 3)), ends, "m", 30.0)
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(9) / 2)
        library.add(Take(name, {"body": motion, "markers": signal}, cuts))
    points = [text for role in ends for text in ("--control-point", f"{role}=1", "--target-point", f"{role}=1")]
    with pytest.raises(RequestError, match="expected a character to control 'body', found a signal of left_toe"):
        answer("evaluate", "performance", "-l", library.path, "--target", "body", *points)


def test_the_command_names_what_it_skips(tmp_path: Path) -> None:
    path = _library(tmp_path, named=False)
    still = walk(3.0)
    still = replace(
        still, translation=still.translation[:1].repeat(len(still), 0), rotations=still.rotations * 0 + _UNIT
    )
    kg.Library.open(path).add(Take("idle", {"body": still}))
    plain = ("evaluate", "performance", "-l", path, "--no-baselines", "--json")
    result = answer(*plain, "--keep-copies")
    assert [row["take"] for row in json.loads(result.stdout)] == ["a", "b", "mean"]
    assert "1 take not evaluated: idle" in result.stderr
    some = answer(*plain, "--keep-copies", "--only", "b", "--jobs", "2")
    assert [row["take"] for row in json.loads(some.stdout)] == ["b", "mean"]
    assert "not evaluated" not in some.stderr
    with pytest.raises(
        RequestError, match="2 takes left out: nothing is left to make it of: take 'idle' cannot be cut"
    ):
        answer(*plain)  # the other walk is a copy
