from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.errors import RequestError
from kinetograph.segmentation import cuts_at_labels, cuts_by_length
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take


def _take(duration: float = 3.0, *notes: Annotation) -> Take:
    return Take("day", {"beat": Signal(np.zeros((round(10 * duration) + 1, 1)), ("b",), "", 10.0)}, notes)


def test_cuts_by_length_leave_a_shorter_rest_over() -> None:
    np.testing.assert_allclose(cuts_by_length(_take(3.0), "beat", 0.8), [0.0, 0.8, 1.6, 2.4])


def test_a_length_that_divides_the_track_reaches_its_end() -> None:
    np.testing.assert_allclose(cuts_by_length(_take(3.0), "beat", 0.1), np.arange(31) / 10)
    assert cuts_by_length(_take(3.0), "beat", 3.0) == (0.0, 3.0)
    assert 0.6 / 0.2 < 3  # in floating point
    assert len(cuts_by_length(_take(0.6), "beat", 0.2)) == 4


@given(st.floats(0.01, 3.0))
def test_cuts_are_evenly_spaced_within_the_track(length: float) -> None:
    cuts = cuts_by_length(_take(3.0), "beat", length)
    np.testing.assert_allclose(np.diff(cuts), length)
    assert cuts[0] == 0.0
    assert cuts[-1] <= 3.0 + 1e-6
    assert 3.0 - cuts[-1] < length + 1e-6


@pytest.mark.parametrize("length", [0.0, -1.0, 3.1, np.nan, np.inf])
def test_a_length_fits_into_the_track(length: float) -> None:
    with pytest.raises(RequestError, match=r"take 'day' lasts 3.00 s, found a segment length of .* s"):
        cuts_by_length(_take(3.0), "beat", length)


def test_cuts_at_labels_are_where_they_start_and_stop_once_each() -> None:
    moves = [Annotation("beat", "move", name, *span) for name, *span in (("swing", 1.0, 2.0), ("spin", 0.5, 1.0))]
    other = Annotation("beat", "cut", "", 0.2, 0.2)
    assert cuts_at_labels(_take(3.0, *moves, other), "beat", "move") == (0.5, 1.0, 2.0)
    assert cuts_at_labels(_take(3.0, *moves, other), "beat", "cut") == (0.2,)


def test_labels_that_are_not_there_are_an_error() -> None:
    take = _take(3.0, Annotation("beat", "move", "spin", 0.0, 1.0), Annotation("beat", "cut", "", 0.5, 0.5))
    with pytest.raises(RequestError, match="no annotations of kind 'handhold' on 'beat'; its kinds: cut, move"):
        cuts_at_labels(take, "beat", "handhold")
    with pytest.raises(RequestError, match="its kinds: none"):
        cuts_at_labels(_take(), "beat", "move")
