"""Hands that hold: within reach they are met exactly, and nothing else is asked of the body than was allowed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.post.constraints import (
    Hold,
    HoldSettings,
    comfort,
    ease_weights,
    follow_hands,
    hold_hands,
    hold_residuals,
)
from kinetograph.post.limbs import LEG, usual_hinge
from walkers import walk

_STILL = HoldSettings(share=0.0)


def _hold(offset: tuple[float, float, float], start: int = 20, stop: int = 40) -> Hold:
    hand = role_positions(walk(2.0), ("right_hand",))[:, 0]
    held = np.zeros(61, dtype=bool)
    held[start:stop] = True
    return Hold("right_hand", hand + offset, held)


def test_a_hand_within_reach_meets_what_it_holds() -> None:
    hold = _hold((0.0, 0.12, 0.05))
    motion = hold_hands(walk(2.0), [hold])
    assert hold_residuals(motion, [hold]).max() < 1e-6
    before, after = joint_positions(walk(2.0)), joint_positions(motion)
    moved = np.abs(before - after).max(axis=(0, 2)) > 1e-9
    assert {motion.skeleton.names[i] for i in np.flatnonzero(moved)} == {"right_elbow", "right_hand"}


def test_bones_keep_their_length_and_far_frames_their_pose() -> None:
    motion = hold_hands(walk(2.0), [_hold((0.0, 0.3, 0.1))])
    arm = role_positions(motion, ("right_shoulder", "right_elbow", "right_hand"))
    np.testing.assert_allclose(np.linalg.norm(arm[:, 2] - arm[:, 1], axis=1), 0.25, atol=1e-9)
    np.testing.assert_allclose(motion.rotations[:12], walk(2.0).rotations[:12])
    np.testing.assert_allclose(motion.rotations[48:], walk(2.0).rotations[48:])


def test_a_hand_is_moved_no_further_than_allowed() -> None:
    hold = _hold((0.0, 0.2, 0.0))
    motion = hold_hands(walk(2.0), [hold], HoldSettings(furthest=0.05))
    assert hold_residuals(motion, [hold]) == pytest.approx(0.15, abs=1e-6)


def test_a_hold_comes_and_goes_smoothly() -> None:
    motion = hold_hands(walk(2.0), [_hold((0.0, 0.15, 0.0))])
    lift = role_positions(motion, ("right_hand",))[:, 0, 1] - role_positions(walk(2.0), ("right_hand",))[:, 0, 1]
    assert np.abs(np.diff(lift)).max() < 0.04
    assert lift[25] == pytest.approx(0.15, abs=1e-6)


def test_the_body_follows_its_hands_on_the_ground_only() -> None:
    motion = walk(2.0)
    hold = _hold((0.3, 0.3, 0.0), 0, 61)
    moved = follow_hands(motion, [hold], HoldSettings(share=0.5))
    np.testing.assert_allclose(moved.translation - motion.translation, np.tile([0.15, 0.0, 0.0], (61, 1)), atol=1e-9)
    assert follow_hands(motion, [hold], _STILL) is motion
    assert follow_hands(motion, []) is motion


@given(st.lists(st.booleans(), min_size=1, max_size=30), st.floats(0, 8))
def test_weights_are_one_where_held_and_fall_to_nothing(held: list[bool], ease: float) -> None:
    weights = ease_weights(np.array(held), ease)
    assert ((weights >= 0) & (weights <= 1)).all()
    assert (weights[np.array(held)] == 1).all()
    for i, w in enumerate(weights):
        near = any(held[j] for j in range(len(held)) if abs(i - j) < max(ease, 1e-9))
        assert (w > 0) <= near or held[i]


def test_settings_that_make_no_sense() -> None:
    with pytest.raises(RequestError, match="ease and furthest must be 0 or more, found -1"):
        HoldSettings(ease=-1)


def test_an_arm_is_not_whirled_round_its_shoulder() -> None:
    arm = np.tile(np.array([[[0.0, 1.4, 0.0], [0.3, 1.4, 0.0], [0.6, 1.4, 0.0]]]), (3, 1, 1))
    beside, through, onto = [0.0, -0.3, 0.0], [-1.0, 0.0, 0.0], [-0.6, 0.02, 0.0]
    np.testing.assert_allclose(comfort(arm, np.array([beside, through, onto])), [1.0, 0.0, 0.0], atol=1e-12)
    path = np.linspace([0.0, 0.0, 0.0], [-1.0, 0.1, 0.0], 400)
    shares = comfort(np.repeat(arm[:1], 400, axis=0), path)
    assert shares[0] == 1.0
    assert shares[-1] == 0.0
    assert np.abs(np.diff(shares)).max() < 0.05


def test_a_limb_bends_about_its_usual_axis() -> None:
    motion = walk(2.0)
    for part, expected in ((LEG, True), (("hips", "hips", "hips"), False)):
        joints = [motion.skeleton.landmark(f"left_{p}" if expected else p).joint for p in part]
        hinge = usual_hinge(motion, joints)
        assert (hinge is not None) == expected
        if hinge is not None:
            positions = joint_positions(motion)
            normal = np.cross(
                positions[:, joints[2]] - positions[:, joints[0]], positions[:, joints[1]] - positions[:, joints[0]]
            )
            bent = np.linalg.norm(normal, axis=1) > 1e-3
            assert bent.any()
            unit = normal[bent] / np.linalg.norm(normal[bent], axis=1, keepdims=True)
            np.testing.assert_allclose(unit, hinge[bent], atol=1e-6)
