"""Agreement of cuts against every way to pair them, and of labels against times that were put in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import naive
from kinetograph.errors import RequestError
from kinetograph.segmentation import compare_cuts, compare_labels, even_cuts
from kinetograph.take import Annotation

_TIMES = st.lists(st.integers(0, 40), max_size=6, unique=True).map(lambda ticks: [0.05 * t for t in sorted(ticks)])


def _move(label: str, start: float, stop: float) -> Annotation:
    return Annotation("body", "move", label, start, stop)


@given(_TIMES, _TIMES.filter(bool), st.sampled_from([0.05, 0.1, 0.3]))
def test_as_many_cuts_are_paired_as_can_be_and_as_closely(
    detected: list[float], expected: list[float], tolerance: float
) -> None:
    result = compare_cuts(detected, expected, tolerance)
    inside = [t for t in detected if expected[0] - tolerance <= t <= expected[-1] + tolerance]
    matched, total = naive.most_pairs(inside, expected, tolerance)
    assert result.matched == matched
    assert result.detected >= matched
    if matched:
        assert result.offset == pytest.approx(total / matched)


def test_the_measures_of_a_case_done_by_hand() -> None:
    # 1.04 and 1.08 both are near 1; 5.0 lies after the last cut by hand
    result = compare_cuts([0.02, 1.04, 1.08, 1.5, 5.0], [0.0, 1.0, 2.0, 3.0])
    assert (result.detected, result.expected, result.matched) == (4, 4, 2)
    assert (result.precision, result.recall, result.f1) == (0.5, 0.5, 0.5)
    assert result.offset == pytest.approx(0.03)


def test_one_cut_gives_way_so_that_two_can_be_paired() -> None:
    assert compare_cuts([1.0, 1.09], [0.92, 1.0], 0.1).matched == 2


def test_cuts_that_agree_nowhere_or_are_not_there() -> None:
    none = compare_cuts([0.5], [0.0, 1.0])
    assert (none.f1, none.precision, none.recall) == (0.0, 0.0, 0.0)
    assert np.isnan(none.offset)
    assert compare_cuts([], [1.0]).f1 == 0.0
    with pytest.raises(RequestError, match=r"expected a cut or more and a tolerance above 0, found 0 and 0\.1"):
        compare_cuts([1.0], [])


def test_labels_agree_for_the_time_that_they_do() -> None:
    hand = [_move("walk", 0.0, 2.0), _move("turn", 2.0, 4.0)]
    grown = [_move("walk", 0.0, 2.5), _move("turn", 2.5, 3.5), _move("jump", 6.0, 9.0)]
    assert compare_labels(grown, hand) == pytest.approx(3.0 / 4.0)
    assert compare_labels(hand, hand) == 1.0
    assert compare_labels([*hand, _move("arms up", 0.0, 4.0)], hand) == 0.0
    assert np.isnan(compare_labels(grown, []))


def test_even_cuts_begin_within_the_first_length() -> None:
    np.testing.assert_allclose(even_cuts(2.0, 0.6, 0.5), [0.3, 0.9, 1.5])
