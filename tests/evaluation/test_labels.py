"""Error rates of moves, on examples small enough to count by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.evaluation.labels import LabelErrors, label_errors, main_move, take_errors
from kinetograph.evaluation.protocol import leave_one_take_out
from kinetograph.methods.performance import PerformanceControl
from kinetograph.take import Annotation, Take
from walkers import walk


def _moves(names: str, length: float = 1.0, start: float = 0.0) -> tuple[Annotation, ...]:
    """One move per letter, each ``length`` seconds; a space names nothing."""
    return tuple(
        Annotation("body", "move", name, start + i * length, start + (i + 1) * length)
        for i, name in enumerate(names)
        if name != " "
    )


def _units(count: int, length: float = 1.0) -> list[tuple[float, float]]:
    return [(i * length, (i + 1) * length) for i in range(count)]


def test_one_wrong_segment_spoils_its_pattern_only() -> None:
    errors = label_errors(_moves("aabbccdd"), _moves("aabbcadd"), _units(8))
    assert errors == LabelErrors(segments=8, wrong=1, patterns=2, wrong_patterns=1)
    assert errors.segment_rate == 1 / 8
    assert errors.pattern_rate == 1 / 2


def test_two_wrong_segments_of_one_pattern_are_one_wrong_pattern() -> None:
    assert label_errors(_moves("abcdabcd"), _moves("abcdabab"), _units(8)) == LabelErrors(8, 2, 2, 1)


def test_the_thesis_own_counts_come_out() -> None:
    # section 6.2: 91 patterns of four segments, five of them wrong by one segment each
    names = "abcd" * 91
    made = list(names)
    for pattern in (3, 17, 40, 41, 90):
        made[4 * pattern + 2] = "x"
    errors = label_errors(_moves(names), _moves("".join(made)), _units(364))
    assert errors == LabelErrors(364, 5, 91, 5)
    assert errors.segment_rate < 0.02
    assert errors.pattern_rate == pytest.approx(0.055, abs=5e-4)


def test_what_nobody_named_is_not_judged() -> None:
    # the third segment has no name: it does not count, and the run of four begins anew after it
    errors = label_errors(_moves("ab cdabcd"), _moves("xxxcdabxx"), _units(9))
    assert errors == LabelErrors(segments=8, wrong=4, patterns=1, wrong_patterns=0)


def test_nothing_made_is_wrong_and_nothing_named_has_no_rate() -> None:
    assert label_errors(_moves("aaaa"), (), _units(4)) == LabelErrors(4, 4, 1, 1)
    none = label_errors((), _moves("aaaa"), _units(4))
    assert none == LabelErrors(0, 0, 0, 0)
    assert math.isnan(none.segment_rate)
    assert math.isnan(none.pattern_rate)


def test_patterns_may_be_named_on_the_recording() -> None:
    errors = label_errors(_moves("aabbbb"), _moves("aabbbx"), _units(6), patterns=[(0.0, 2.0), (2.0, 6.0), (9.0, 11.0)])
    assert errors == LabelErrors(6, 1, 2, 1)


def test_the_move_that_covers_most_counts() -> None:
    made = (*_moves("a", 0.4), *_moves("b", 0.6, 0.4))
    assert main_move(made, (0.0, 1.0)) == ("b", pytest.approx(0.6))
    assert label_errors(_moves("a"), made, _units(1)).wrong == 1
    # two halves of one move are one move, though a piece of another lies between them
    halves = (*_moves("a", 0.3), *_moves("b", 0.4, 0.3), *_moves("a", 0.3, 0.7))
    assert main_move(halves, (0.0, 1.0)) == ("a", pytest.approx(0.6))


def test_units_are_the_segments_that_the_search_uses() -> None:
    cuts = tuple(Annotation("body", "cut", "", t / 2, t / 2) for t in range(9))
    take = Take("t", {"body": walk(4.0)}, (*cuts, *_moves("ab", 2.0)))
    assert take_errors(take, "body", _moves("aa", 2.0)).segments == 8
    assert take_errors(take, "body", _moves("aa", 2.0), span=2) == LabelErrors(4, 2, 1, 1)
    without = Take("t", {"body": walk(4.0)}, _moves("ab", 2.0))
    assert take_errors(without, "body", _moves("aa", 2.0)) == LabelErrors(2, 1, 0, 0)


def test_rates_are_in_the_protocols_rows(tmp_path: Path) -> None:
    """Two walks straight ahead and two that turn left; a straight one that is called a turn is wrong throughout."""
    library = kg.Library.create(tmp_path / "library")
    for name, turn, move in (("a", 0.0, "s"), ("b", 0.0, "s"), ("c", 0.7, "l"), ("d", 0.7, "l"), ("e", 0.0, "l")):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(9) / 2)
        library.add(Take(name, {"body": walk(4.0, turn_rate=turn)}, (*cuts, *_moves(move, 4.0))))
    rows = {row.take: row for row in leave_one_take_out(PerformanceControl(stretch=0.0), library)}
    assert [rows[n].segment_errors for n in "cde"] == [0.0, 0.0, 1.0]
    assert [rows[n].pattern_errors for n in "cde"] == [0.0, 0.0, 1.0]
