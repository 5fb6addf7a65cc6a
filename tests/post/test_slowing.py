"""Turns and elbows that are no faster than they may be, and otherwise as they were."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.motion import Motion
from kinetograph.post.elbows import elbow_speed, limit_elbows
from kinetograph.post.slowing import fastest_change, slowed
from kinetograph.post.turning import facings, limit_turning, turning_speed
from kinetograph.skeleton import Skeleton
from walkers import walk

_FPS = 60.0


@given(seed=st.integers(0, 2**32 - 1), fastest=st.floats(0.5, 20.0))
@settings(max_examples=40)
def test_a_curve_is_slowed_to_what_is_asked(seed: int, fastest: float) -> None:
    rng = np.random.default_rng(seed)
    curve = np.cumsum(rng.normal(scale=0.05, size=240)) + 2.0 * (np.arange(240) > rng.integers(40, 200))
    assert fastest_change(slowed(curve, fastest, _FPS), _FPS) <= 1.05 * fastest


def test_what_is_slow_enough_stays_to_the_bit() -> None:
    curve = np.sin(np.arange(200) / 20.0)
    assert slowed(curve, 3.1, _FPS) is curve
    assert slowed(np.zeros(1), 1.0, _FPS).tolist() == [0.0]


def test_a_jump_begins_earlier_and_ends_later_by_as_much() -> None:
    slow = slowed(np.repeat([0.0, 1.0], 120), 2.0, _FPS)
    np.testing.assert_allclose(slow + slow[::-1], 1.0, atol=1e-6)
    assert slow[60] == pytest.approx(0.0, abs=1e-9)
    assert slow[-60] == pytest.approx(1.0, abs=1e-9)


def _whirled(motion: Motion) -> Motion:
    """A walk that whirls round by a third of a turn within a tenth of a second, at its middle."""
    angle = 2.1 * np.clip((np.arange(len(motion)) - len(motion) / 2) / (0.1 * motion.fps), 0.0, 1.0)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(rot.about("y", angle), rotations[:, 0])
    return Motion(motion.skeleton, motion.translation, rotations, motion.fps)


def test_a_body_turns_no_faster_and_ends_as_it_faced() -> None:
    motion = _whirled(walk(6.0, fps=_FPS))
    assert turning_speed(motion) > 10.0
    calm = limit_turning(motion, 2.5)
    assert turning_speed(calm) <= 2.5 * 1.05
    np.testing.assert_allclose(facings(calm)[[0, -1]], facings(motion)[[0, -1]], atol=1e-6)
    np.testing.assert_array_equal(calm.translation, motion.translation)
    np.testing.assert_array_equal(calm.rotations[:, 1:], motion.rotations[:, 1:])


def test_an_elbow_snaps_no_more_and_no_bone_is_lengthened() -> None:
    motion = walk(4.0, fps=_FPS)
    elbow = motion.skeleton.landmark("left_elbow").joint
    rotations = motion.rotations.copy()
    bend = np.where(np.arange(len(motion)) < len(motion) // 2, -1.2, -0.2)
    rotations[:, elbow] = rot.about("x", bend)
    snapping = Motion(motion.skeleton, motion.translation, rotations, motion.fps)
    assert elbow_speed(snapping) > 20.0
    calm = limit_elbows(snapping, 5.0)
    assert elbow_speed(calm) <= 5.0 * 1.1
    arm = [motion.skeleton.landmark(f"left_{part}").joint for part in ("shoulder", "elbow", "hand")]
    bones = np.linalg.norm(np.diff(joint_positions(calm)[:, arm], axis=1), axis=-1)
    np.testing.assert_allclose(bones, np.broadcast_to(bones[0], bones.shape), atol=1e-9)
    far = np.abs(np.arange(len(motion)) - len(motion) // 2) > _FPS
    hands = (role_positions(m, ("left_hand",))[far] for m in (calm, snapping))
    np.testing.assert_allclose(next(hands), next(hands), atol=1e-6)


def test_a_body_without_arms_or_hips_is_left_alone() -> None:
    stick = Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))
    motion = Motion(stick, np.zeros((3, 3)), rot.identity(3, 1), 30.0)
    assert limit_elbows(motion, 1.0) is motion
    assert limit_turning(motion, 1.0) is motion
    assert elbow_speed(motion) == turning_speed(motion) == 0.0
