"""The nested protocol: what is chosen for a take is chosen without it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.evaluation import (
    Candidate,
    WalkRow,
    candidates_around,
    leave_one_take_out,
    means_with_and_without,
    nested_walks,
)
from kinetograph.methods.performance import PerformanceControl
from kinetograph.take import Annotation, Take
from walkers import walk

_METHOD = PerformanceControl(stretch=0.1)


def _library(folder: Path, count: int = 3) -> kg.Library:
    library = kg.Library.create(folder / "library")
    for name, rate in zip("abcd"[:count], (0.0, 0.3, -0.2, 0.5), strict=False):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(11) / 2)
        library.add(Take(name, {"body": walk(5.0, turn_rate=rate)}, cuts))
    return library


def test_takes_that_are_left_out_are_neither_held_out_nor_in_the_library(tmp_path: Path) -> None:
    library = _library(tmp_path, 4)
    rows = leave_one_take_out(_METHOD, library, without=("d",))
    assert [row.take for row in rows] == ["a", "b", "c"]
    library.remove("d")
    assert [row.joint_cm for row in leave_one_take_out(_METHOD, library)] == [row.joint_cm for row in rows]


def test_the_best_on_the_other_takes_is_judged_on_the_held_out_one(tmp_path: Path) -> None:
    library = _library(tmp_path)
    candidates = (Candidate(0.1, 0.0), Candidate(0.01, 0.2))
    nested = nested_walks(_METHOD, library, candidates=candidates)
    assert [one.row.take for one in nested] == ["a", "b", "c"]
    for one in nested:
        prices = []
        for candidate in candidates:
            method = candidate.set(_METHOD)
            rows = leave_one_take_out(method, library, without=(one.row.take,))
            jumps = [max(row.seam / row.seam_recorded, 1.0) for row in rows]
            prices.append(np.mean([row.joint_cm * jump for row, jump in zip(rows, jumps, strict=True)]))
        best = candidates[int(np.argmin(prices))]
        assert one.settings == best
        judged = next(r for r in leave_one_take_out(best.set(_METHOD), library) if r.take == one.row.take)
        assert (one.row.joint_cm, one.row.control_cm) == (judged.joint_cm, judged.control_cm)
        assert one.row.method == "segments, nested"


def test_a_held_out_take_has_no_part_in_its_choice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[str, ...]] = []

    def spied(method: PerformanceControl, library: kg.Library, **options: Any) -> list[WalkRow]:
        seen.append(options["without"])
        return leave_one_take_out(method, library, **options)

    monkeypatch.setattr("kinetograph.evaluation.nested.leave_one_take_out", spied)
    nested_walks(_METHOD, _library(tmp_path), candidates=(Candidate(0.1, 0.1),))
    assert seen == [("a",), ("b",), ("c",), ()]


def test_candidates_lie_around_the_configuration() -> None:
    found = candidates_around(PerformanceControl(continuity=0.3, stretch=0.2))
    assert len(found) == 9
    assert Candidate(0.3, 0.2) in found
    assert min(c.continuity for c in found) == pytest.approx(0.1)
    assert max(c.stretch for c in found) == pytest.approx(0.3)


def test_two_takes_are_too_few(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="a nested protocol needs 3 takes or more, found 2"):
        nested_walks(_METHOD, _library(tmp_path, 2))


def test_means_with_and_without_repeats(tmp_path: Path) -> None:
    rows = leave_one_take_out(_METHOD, _library(tmp_path))
    both = means_with_and_without(rows, ("a",), summed=("seconds",))
    assert [row.take for row in both] == ["mean", "mean without repeats"]
    assert both[0].joint_cm == pytest.approx(np.mean([row.joint_cm for row in rows]))
    assert both[1].joint_cm == pytest.approx(np.mean([row.joint_cm for row in rows[1:]]))
    assert math.isclose(both[1].seconds, 10.0)
    assert len(means_with_and_without(rows, ())) == 1
