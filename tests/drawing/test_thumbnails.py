"""Moving thumbnails: what is seen of a motion whose size and direction are known."""

from __future__ import annotations

import numpy as np
import pytest

from kinetograph.drawing.thumbnails import FRAMES, SPAN, thumbnail
from kinetograph.errors import RequestError
from kinetograph.motion import Motion, concatenate, place
from walkers import walk


def test_a_thumbnail_is_the_same_wherever_the_motion_is() -> None:
    motion = walk(2.0)
    here, there = thumbnail([motion]), thumbnail([place(motion, 1.3, (20.0, 0.0, -7.0))])
    assert np.abs(here.ends.astype(int) - there.ends).max() <= 1  # of rounding, millimetres
    assert here.ends.shape == (FRAMES, len(here.sides), 2, 2)
    assert (here.start, here.seconds) == (0.0, 2.0)


def test_it_is_in_millimetres_above_the_floor_and_sides_are_told_apart() -> None:
    drawn = thumbnail([walk(1.0)])
    heights = drawn.ends[..., 1]
    assert heights.min() == pytest.approx(0, abs=60)  # soles
    assert 1300 < heights.max() < 1700  # the shoulders of a figure without a head are at 1.36 m
    left = drawn.ends[:, np.array(drawn.sides) == 1, :, 0].mean()
    right = drawn.ends[:, np.array(drawn.sides) == 2, :, 0].mean()
    assert left > right + 50  # the person faces us: its left is on our right


def test_the_liveliest_part_of_a_long_motion_is_shown() -> None:
    step = walk(4.0)
    still = Motion(
        step.skeleton, np.repeat(step.translation[:1], 180, axis=0), np.repeat(step.rotations[:1], 180, axis=0), 30.0
    )
    drawn = thumbnail([concatenate([still, step])])
    assert drawn.seconds == SPAN
    assert drawn.start >= 5.5


def test_signals_alone_have_no_thumbnail() -> None:
    with pytest.raises(RequestError, match="found only signals"):
        thumbnail([])
