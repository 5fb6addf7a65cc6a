"""A body pushed into the floor is lifted out of it; falls are measured against gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion
from kinetograph.post.assemble import Part
from kinetograph.post.falling import GRAVITY, MASSES, accelerated, centre_height
from kinetograph.post.floor import SLACK, SPEED, gentle, keep_above, point_heights, recorded_lows
from kinetograph.synthesis import Piece
from walkers import walk


@pytest.fixture(scope="module")
def motion() -> Motion:
    above = walk(4.0)
    lowest = joint_positions(above)[..., 1].min()
    return replace(above, translation=above.translation - [0.0, lowest, 0.0])


def pushed_down(motion: Motion, depth: float, frames: slice) -> Motion:
    """The body as a whole lower by a depth that comes and goes smoothly."""
    root = motion.translation.copy()
    count = frames.stop - frames.start
    root[frames, 1] -= depth * np.hanning(count)
    return replace(motion, translation=root)


def piece(motion: Motion) -> Part:
    return Part(Piece("walk", "motion", 0.0, motion.duration, 0.0, motion.duration), motion, ())


@pytest.mark.parametrize("depth", [0.03, 0.1, 0.2])
def test_feet_pushed_into_the_floor_come_out_of_it(motion: Motion, depth: float):
    low = pushed_down(motion, depth, slice(30, 90))
    lowest = recorded_lows(low, [piece(motion)])
    before, after = (lowest - point_heights(one) for one in (low, keep_above(low, lowest)))
    assert before.max() > 0.9 * depth
    assert after.max() <= SLACK + 1e-3
    fixed = keep_above(low, lowest)
    outside = np.r_[0:10, 110 : len(motion)]
    assert np.allclose(fixed.rotations[outside], low.rotations[outside], atol=1e-9)


def test_what_the_recordings_do_is_left_alone(motion: Motion):
    sunk = replace(motion, translation=motion.translation - [0.0, 0.05, 0.0])
    assert point_heights(sunk).min() < -0.03
    kept = keep_above(sunk, recorded_lows(sunk, [piece(sunk)]))
    assert kept is sunk


def test_pinned_frames_stay_exactly(motion: Motion):
    low = pushed_down(motion, 0.1, slice(30, 90))
    kept = keep_above(low, recorded_lows(low, [piece(motion)]), pinned=[60])
    assert np.array_equal(kept.translation[60], low.translation[60])
    assert np.allclose(joint_positions(kept)[60], joint_positions(low)[60], atol=1e-9)
    assert not np.allclose(joint_positions(kept)[50], joint_positions(low)[50], atol=1e-3)


@settings(max_examples=40)
@given(st.lists(st.floats(0.0, 0.3), min_size=1, max_size=60), st.sampled_from([30.0, 60.0, 120.0]))
def test_a_lift_covers_its_depth_at_a_bounded_speed(depths: list[float], fps: float):
    depth = np.array(depths)
    lift = gentle(depth, fps)
    assert lift.shape == depth.shape
    assert (lift >= depth - 1e-9).all()
    assert np.abs(np.diff(lift)).max(initial=0.0) * fps <= SPEED + 1e-9
    assert lift.max() <= depth.max() + 1e-9


def test_masses_add_up_and_lie_between_the_joints(motion: Motion):
    assert sum(MASSES.values()) == pytest.approx(1.0, abs=0.02)
    heights, centre = joint_positions(motion)[..., 1], centre_height(motion)
    assert (centre > heights.min(axis=1)).all()
    assert (centre < heights.max(axis=1)).all()


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_free_fall_accelerates_by_gravity_at_any_rate(fps: float):
    seconds = np.arange(round(fps)) / fps
    heights = 3.0 + 1.5 * seconds - 0.5 * GRAVITY * seconds**2
    found = accelerated(heights, fps)
    assert np.nanmin(found) == pytest.approx(-GRAVITY)
    assert np.nanmax(found) == pytest.approx(-GRAVITY)
    assert np.isnan(accelerated(heights[:3], fps)).all()
