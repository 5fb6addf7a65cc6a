from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.post.inverse_kinematics import STRAIGHT, TURNED, reach

_SEEDS = st.integers(0, 2**32 - 1)


def _limbs(seed: int, count: int = 20) -> tuple[FloatArray, FloatArray, FloatArray, np.random.Generator]:
    """Bent limbs of two bones anywhere: hips, knees, ankles ``(count, 3)``."""
    rng = np.random.default_rng(seed)
    hip = rng.normal(size=(count, 3))
    thigh = _unit(rng.normal(size=(count, 3)))
    shin = rot.rotate(rot.exp(_square_to(thigh, rng) * rng.uniform(0.2, 2.5, (count, 1))), thigh)
    first, second = rng.uniform(0.2, 0.6, (2, count, 1))
    return hip, hip + first * thigh, hip + first * thigh + second * shin, rng


def _unit(v: FloatArray) -> FloatArray:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _square_to(v: FloatArray, rng: np.random.Generator) -> FloatArray:
    return _unit(np.cross(v, rng.normal(size=v.shape)))


def _length(v: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(v, axis=-1))


def _apply(hip: FloatArray, knee: FloatArray, ankle: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray]:
    upper, lower = reach(hip, knee, ankle, target)
    np.testing.assert_allclose(_length(upper), 1.0)
    np.testing.assert_allclose(_length(lower), 1.0)
    new_knee = hip + rot.rotate(upper, knee - hip)
    return new_knee, new_knee + rot.rotate(lower, ankle - knee)


def _targets(hip: FloatArray, knee: FloatArray, ankle: FloatArray, rng: np.random.Generator) -> FloatArray:
    first, second = _length(knee - hip), _length(ankle - knee)
    low, high = np.abs(first - second) + 2e-4, STRAIGHT * (first + second)
    distance = low + rng.uniform(0, 1, len(hip)) * (high - low)
    return np.asarray(hip + distance[:, None] * _unit(rng.normal(size=hip.shape)))


@given(_SEEDS)
def test_a_target_within_reach_is_reached(seed: int) -> None:
    hip, knee, ankle, rng = _limbs(seed)
    target = _targets(hip, knee, ankle, rng)
    _, new_end = _apply(hip, knee, ankle, target)
    np.testing.assert_allclose(new_end, target, atol=1e-9)


@given(_SEEDS)
def test_the_limb_bends_in_the_plane_it_bent_in(seed: int) -> None:
    hip, knee, ankle, rng = _limbs(seed)
    target = _targets(hip, knee, ankle, rng)
    new_knee, new_end = _apply(hip, knee, ankle, target)
    carried = rot.rotate(rot.between(ankle - hip, target - hip), _unit(np.cross(ankle - hip, knee - hip)))
    normal = np.cross(new_end - hip, new_knee - hip)
    np.testing.assert_allclose(np.sum(_unit(normal) * carried, axis=-1), 1.0, atol=1e-6)


def test_a_leg_that_is_lifted_bends_its_knee_forward() -> None:
    hip, knee, ankle = np.array([[0.0, 0.9, 0]]), np.array([[0.0, 0.46, 0.05]]), np.array([[0.0, 0.02, 0.0]])
    new_knee, new_end = _apply(hip, knee, ankle, ankle + np.array([0, 0.2, 0]))
    assert new_knee[0, 2] > 0.15
    np.testing.assert_allclose(new_end, [[0.0, 0.22, 0.0]], atol=1e-9)


@given(_SEEDS)
def test_staying_where_it_is_turns_nothing(seed: int) -> None:
    hip, knee, ankle, _ = _limbs(seed)
    for turn in reach(hip, knee, ankle, ankle):
        # where the limb is not bent as far as it may be
        within = _length(ankle - hip) > np.abs(_length(knee - hip) - _length(ankle - knee)) + 1e-4
        assert rot.angle_between(rot.identity(len(hip)), turn)[within].max() < 1e-6


@given(_SEEDS, st.floats(1.0, 10.0))
def test_a_target_out_of_reach_is_pointed_at(seed: int, beyond: float) -> None:
    hip, knee, ankle, rng = _limbs(seed)
    full = _length(knee - hip) + _length(ankle - knee)
    direction = _unit(rng.normal(size=hip.shape))
    _, new_end = _apply(hip, knee, ankle, hip + (full * beyond)[:, None] * direction)
    np.testing.assert_allclose(_unit(new_end - hip), direction, atol=1e-9)
    furthest = np.maximum(STRAIGHT * full, _length(ankle - hip))
    np.testing.assert_allclose(_length(new_end - hip), furthest, atol=1e-9)
    assert (_length(new_end - hip) <= full + 1e-12).all()


@given(_SEEDS)
def test_a_target_too_near_is_approached(seed: int) -> None:
    hip, knee, ankle, rng = _limbs(seed)
    target = hip + 1e-6 * rng.normal(size=hip.shape)
    _, new_end = _apply(hip, knee, ankle, target)
    nearest = np.abs(_length(knee - hip) - _length(ankle - knee)) + 1e-4
    np.testing.assert_allclose(_length(new_end - hip), nearest, atol=1e-9)


def test_a_limb_stretched_further_than_usual_is_not_drawn_in() -> None:
    hip, knee, ankle = np.array([[0.0, 1.0, 0]]), np.array([[0.0, 0.5, 0.001]]), np.array([[0.0, 0.0, 0.0]])
    assert _length(ankle - hip) > STRAIGHT * 1.0
    _, new_end = _apply(hip, knee, ankle, np.array([[0.0, -1.0, 0.0]]))
    np.testing.assert_allclose(new_end, ankle, atol=1e-7)


@pytest.mark.parametrize("direction", [[0, -1, 0], [1, 0, 0], [0, -1, 1], [0, 0, 1], [0, 0, -1], [0.3, -1, 0.2]])
def test_a_straight_limb_can_bend(direction: list[float]) -> None:
    down = _unit(np.array([direction], dtype=np.float64))
    hip = np.array([[0.0, 1.0, 0.0]])
    knee, ankle = hip + 0.4 * down, hip + 0.8 * down
    target = hip + 0.6 * down
    new_knee, new_end = _apply(hip, knee, ankle, target)
    np.testing.assert_allclose(new_end, target, atol=1e-7)
    assert np.linalg.norm(np.cross(new_knee - hip, down)) > 0.2


def test_a_straight_leg_that_stands_bends_its_knee_towards_z() -> None:
    hip = np.array([[0.0, 1.0, 0.0]])
    new_knee, _ = _apply(hip, hip - [0, 0.4, 0], hip - [0, 0.8, 0], hip - [0, 0.7, 0])
    assert new_knee[0, 2] > 0.1


def test_a_straight_leg_bends_about_the_hinge_that_is_given():
    """Facing -z, the left hip is at -x: the knee of a straight leg must come out in front, towards -z."""
    hip, knee, ankle = (np.array([[0.0, y, 0.0]]) for y in (0.9, 0.5, 0.1))
    target = np.array([[0.0, 0.2, 0.0]])
    from_left_to_right = np.array([[0.2, 0.0, 0.0]])
    upper, _ = reach(hip, knee, ankle, target, from_left_to_right)
    placed = hip + rot.rotate(upper, knee - hip)
    assert placed[0, 2] < -0.05
    upper, _ = reach(hip, knee, ankle, target, -from_left_to_right)
    assert (hip + rot.rotate(upper, knee - hip))[0, 2] > 0.05


def test_a_leg_that_is_nearly_straight_bends_where_its_hinge_says_whatever_its_noise() -> None:
    """The knee lies a millimetre off the line, here and there: the plane it bends in says nothing."""
    rng = np.random.default_rng(0)
    hip, ankle = np.array([[0.0, 0.9, 0.0]]).repeat(50, axis=0), np.array([[0.0, 0.1, 0.0]]).repeat(50, axis=0)
    knee = np.array([0.0, 0.5, 0.0]) + 0.002 * rng.normal(size=(50, 3)) * [1, 0, 1]
    target = ankle + np.array([0.0, 0.008, 0.01])
    hinge = np.array([[0.2, 0.0, 0.0]]).repeat(50, axis=0)
    upper, lower = reach(hip, knee, ankle, target, hinge, steady=True)
    new_knee = hip + rot.rotate(upper, knee - hip)
    np.testing.assert_allclose(new_knee + rot.rotate(lower, ankle - knee), target, atol=0.007)
    assert np.ptp(new_knee, axis=0).max() < 0.02  # in its own plane it would be anywhere on a circle of 8 cm
    assert new_knee[:, 2].max() < -0.01  # in front


def test_a_bent_leg_that_stays_is_left_as_it_is_with_a_hinge_too() -> None:
    hip, knee, ankle, rng = _limbs(4)
    upper, lower = reach(hip, knee, ankle, ankle, rng.normal(size=hip.shape), steady=True)
    np.testing.assert_allclose(rot.rotate(upper, knee - hip), knee - hip, atol=1e-6)
    np.testing.assert_allclose(rot.rotate(lower, ankle - knee), ankle - knee, atol=1e-6)


def test_a_knee_that_goes_through_straight_does_not_snap() -> None:
    """From 12 degrees to the wrong side to 12 to the right one, while the foot is asked 4 mm nearer."""
    bends = np.radians(np.linspace(-12, 12, 400))[:, None]
    hip, hinge = np.zeros((400, 3)), np.tile([1.0, 0.0, 0.0], (400, 1))
    knee = hip + 0.4 * np.concatenate([0 * bends, -np.cos(bends / 2), -np.sin(bends / 2)], axis=1)
    ankle = hip + 0.8 * np.cos(bends / 2) * [0.0, -1.0, 0.0]
    target = ankle + np.array([0.0, 0.004, 0.0])
    for steady, fastest in ((True, 0.003), (False, 0.2)):
        upper, lower = reach(hip, knee, ankle, target, hinge, steady=steady)
        new_knee = hip + rot.rotate(upper, knee - hip)
        missed = np.linalg.norm(new_knee + rot.rotate(lower, ankle - knee) - target, axis=1)
        speed = np.linalg.norm(np.diff(new_knee, axis=0), axis=1).max()
        assert speed < fastest
        assert missed.max() < (0.005 if steady else 1e-6)
        assert missed[bends[:, 0] > TURNED].max() < 1e-6
        if not steady:
            assert speed > 0.03


@pytest.mark.parametrize("hinge", [None, np.array([0.3, 0.2, 1.0])])
def test_where_a_straight_limb_stands_does_not_matter_to_how_it_folds(hinge: FloatArray | None) -> None:
    rng = np.random.default_rng(4)
    hip, along = rng.normal(size=(20, 3)), _unit(rng.normal(size=(20, 3)))
    knee, ankle, target = hip + 0.4 * along, hip + 0.8 * along, hip + 0.5 * along
    here = reach(hip, knee, ankle, target, hinge)
    away = np.array([5.0, -3.0, 7.0])
    for a, b in zip(here, reach(hip + away, knee + away, ankle + away, target + away, hinge), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-7)


def test_a_straight_limb_folds_about_the_part_of_its_hinge_that_is_square_to_it() -> None:
    hip, hinge = np.array([[2.0, 1.0, -3.0]]), np.array([1.0, 1.0, 0.0])
    down = np.array([0.0, -1.0, 0.0])
    upper, _ = reach(hip, hip + 0.4 * down, hip + 0.8 * down, hip + 0.6 * down, hinge)
    axis = rot.log(upper)[0]
    assert np.linalg.norm(axis) > 0.1
    np.testing.assert_allclose(np.abs(axis) / np.linalg.norm(axis), [1.0, 0.0, 0.0], atol=1e-7)
