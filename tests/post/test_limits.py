"""Limits on joints whose turns were put in, one angle at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.post.assemble import Body, PostSettings, constrain
from kinetograph.post.constraints import Hold
from kinetograph.post.limbs import ARM, LEG
from kinetograph.post.limits import JointLimits, JointRange, beyond, limbs_of, limit_limbs, seen_ranges
from walkers import stick_figure, walk

_KNEE = stick_figure().index("left_knee")
_ELBOW = stick_figure().index("left_elbow")
_FREE = JointLimits(margin=0.0, rotation=10.0, ease=0.0)


def _bent(angles: FloatArray | float, joint: int = _KNEE, axis: str = "x", frames: int = 50) -> Motion:
    """A body that stands still but for one joint."""
    angles = np.broadcast_to(np.radians(angles), (frames,))
    rotations = rot.identity(frames, len(stick_figure()))
    rotations[:, joint] = rot.about(axis, angles)
    return Motion(stick_figure(), np.zeros((frames, 3)), rotations, 30.0)


def _angle(motion: Motion, joint: int = _KNEE) -> FloatArray:
    return np.degrees(rot.angle_between(motion.rotations[:, joint], rot.IDENTITY))


_SEEN = seen_ranges([_bent(np.linspace(0, 90, 50))], [_KNEE])


def test_a_hinge_that_was_seen_has_one_range() -> None:
    (knee,) = _SEEN
    np.testing.assert_allclose(np.abs(knee.axes[0]), [1.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(knee.high - knee.low, [np.pi / 2, 0.0, 0.0], atol=1e-6)


def test_a_joint_that_never_moved_has_none() -> None:
    (elbow,) = seen_ranges([walk(1.0)], [_ELBOW])
    np.testing.assert_allclose(elbow.high - elbow.low, 0.0, atol=1e-6)


def test_motions_are_seen_together_whatever_the_signs_of_their_quaternions() -> None:
    low, high = _bent(np.linspace(0, 30, 50)), _bent(np.linspace(60, 90, 50))
    (knee,) = seen_ranges([low, replace(high, rotations=-high.rotations)], [_KNEE])
    assert (knee.high - knee.low)[0] == pytest.approx(np.pi / 2)


@pytest.mark.parametrize(
    ("angle", "axis", "expected"),
    [
        (80.0, "x", [0, 0, 80]),
        (100.0, "x", [0, 0, 100]),
        (120.0, "x", [20, 0, 120]),
        (-10.0, "x", [10, 0, 10]),
        (30.0, "y", [30, 0, 30]),
    ],
)
def test_how_far_a_joint_is_beyond(angle: float, axis: str, expected: list[float]) -> None:
    (knee,) = _SEEN
    wide = JointRange(knee.joint, knee.mean, knee.axes, knee.low - np.radians(10), knee.high + np.radians(10))
    over = np.degrees(beyond(_bent(angle, axis=axis), [knee, wide]))[0]
    if axis == "x":
        beyond_seen = max(angle - 90, -angle, 0)
        np.testing.assert_allclose(over, [beyond_seen, max(beyond_seen - 10, 0)], atol=1e-3)
    else:
        assert over[0] > over[1] > 0  # a knee does not twist


def test_a_knee_goes_back_to_what_is_allowed_in_eighths() -> None:
    # from 40 to 140 degrees: 90 is half the way there and 100, with a margin of 10, six tenths
    before, after = _bent(40.0), _bent(140.0)
    np.testing.assert_allclose(_angle(limit_limbs(after, _SEEN, before, _FREE)), 90.0, atol=1e-3)
    wider = replace(_FREE, margin=np.radians(13))
    np.testing.assert_allclose(_angle(limit_limbs(after, _SEEN, before, wider)), 102.5, atol=1e-3)


def test_the_whole_limb_goes_back_by_one_share() -> None:
    before, after = _bent(40.0), _bent(140.0)
    hip = stick_figure().index("left_hip")
    turned = after.rotations.copy()
    turned[:, hip] = rot.about("x", -0.8)
    turned[:, _ELBOW] = rot.about("x", -0.8)
    limited = limit_limbs(replace(after, rotations=turned), _SEEN, before, _FREE)
    np.testing.assert_allclose(_angle(limited, hip), np.degrees(0.4), atol=1e-3)
    np.testing.assert_allclose(_angle(limited, _ELBOW), np.degrees(0.8), atol=1e-3)  # of another limb


def test_what_is_within_its_range_stays_as_it_is() -> None:
    before, after = _bent(10.0), _bent(np.linspace(0, 90, 50))
    np.testing.assert_array_equal(limit_limbs(after, _SEEN, before, _FREE).rotations, after.rotations)


def test_what_was_recorded_stays_even_beyond_its_range() -> None:
    odd = _bent(130.0)
    np.testing.assert_array_equal(limit_limbs(odd, _SEEN, odd, _FREE).rotations, odd.rotations)
    # and a constraint may not make it worse
    np.testing.assert_allclose(_angle(limit_limbs(_bent(150.0), _SEEN, odd, _FREE)), 130.0, atol=1e-3)


def test_a_joint_is_turned_no_further_than_allowed() -> None:
    limits = replace(_FREE, rotation=np.radians(26))
    np.testing.assert_allclose(_angle(limit_limbs(_bent(80.0), _SEEN, _bent(0.0), limits)), 20.0, atol=1e-3)


def test_a_limb_is_held_back_and_let_go_smoothly() -> None:
    wanted = np.full(90, 80.0)
    wanted[45] = 180.0  # it would leap there for a frame
    before, after = _bent(60.0, frames=90), _bent(wanted, frames=90)
    angle = _angle(limit_limbs(after, _SEEN, before, replace(_FREE, ease=0.3)))
    assert angle.max() <= 90.0 + 1e-3
    assert np.abs(np.diff(angle)).max() < 40.0  # of 100
    np.testing.assert_allclose(angle[:20], 80.0, atol=1e-3)
    np.testing.assert_allclose(angle[70:], 80.0, atol=1e-3)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_no_joint_that_was_within_is_led_beyond(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints = sum(limbs_of(stick_figure()), ())
    turns = rot.exp(0.5 * rng.normal(size=(40, 15, 3)))
    seen = Motion(stick_figure(), np.zeros((40, 3)), turns, 30.0)
    ranges = seen_ranges([seen], joints)
    after = replace(seen, rotations=rot.exp(rng.normal(size=(40, 15, 3))))
    limits = JointLimits(margin=0.1, rotation=1.0, ease=0.0)
    limited = limit_limbs(after, ranges, seen, limits)
    assert beyond(limited, ranges).max() <= np.sqrt(3) * 0.1 + 1e-6
    assert rot.angle_between(limited.rotations, seen.rotations)[:, list(joints)].max() <= 1.0 + 1e-6


def test_a_hand_beyond_the_range_of_its_arm_falls_short() -> None:
    motion = walk(2.0)
    hand = role_positions(motion, ("left_hand",))[:, 0]
    hold = Hold("left_hand", hand + np.array([0.0, 0.25, 0.0]), np.ones(61, dtype=bool))
    ranges = seen_ranges([motion], sum(limbs_of(motion.skeleton), ()))
    free = PostSettings(footskate=False, limits=None)
    settings = (free, replace(free, limits=JointLimits()))
    met, kept = (constrain(motion, (), (hold,), s, Body(ranges))[0] for s in settings)
    missed = [np.linalg.norm(role_positions(m, ("left_hand",))[:, 0] - hold.target, axis=1).max() for m in (met, kept)]
    assert missed[0] < 1e-6
    assert missed[1] > 0.1  # the elbow of the stick figure never bends
    assert beyond(met, ranges).max() > 0.5
    assert beyond(kept, ranges).max() < np.sqrt(3) * JointLimits().margin


def test_limbs_are_those_there_are() -> None:
    names = [[stick_figure().names[joint] for joint in limb] for limb in limbs_of(stick_figure())]
    sides = ("left", "right")
    expected = [[f"{s}_{part}" for part in limb] for limb in (ARM, LEG) for s in sides]
    assert names == expected


def test_limits_that_make_no_sense() -> None:
    with pytest.raises(RequestError, match=r"margin, rotation and ease must be 0 or more, found -1, 2, 0\.15"):
        JointLimits(margin=-1)
