"""Runs of frames, and hysteresis, against a state that is followed frame by frame."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.segmentation.intervals import runs, with_hysteresis

_MASKS = st.lists(st.booleans(), max_size=30)


@given(_MASKS)
def test_runs_are_what_grouping_gives(mask: list[bool]) -> None:
    expected, frame = [], 0
    for value, group in itertools.groupby(mask):
        length = len(list(group))
        if value:
            expected.append((frame, frame + length))
        frame += length
    assert runs(np.array(mask, dtype=bool)) == expected


@given(st.lists(st.sampled_from([(False, False), (False, True), (True, True)]), max_size=30))
def test_without_breaks_to_close_a_run_of_the_looser_criterion_holds_if_the_strict_one_is_ever_met(
    frames: list[tuple[bool, bool]],
) -> None:
    begin, stay = (np.array([pair[i] for pair in frames], dtype=bool) for i in (0, 1))
    expected = np.zeros(len(frames), dtype=bool)
    for first in np.flatnonzero(begin):
        for step in (-1, 1):
            frame = int(first)
            while 0 <= frame < len(frames) and stay[frame]:
                expected[frame] = True
                frame += step
    np.testing.assert_array_equal(with_hysteresis(begin, stay, 30.0, 0.0, 0.0), expected)
    np.testing.assert_array_equal(stay, [pair[1] for pair in frames])  # is not written to


def test_brief_breaks_are_closed_before_brief_runs_are_dropped() -> None:
    mask = np.array([int(c) for c in "0110111000100000110"], dtype=bool)
    closed = with_hysteresis(mask, mask, 10.0, 0.25, 0.15)
    assert "".join(str(int(x)) for x in closed) == "0111111000000000000"
