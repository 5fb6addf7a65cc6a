"""Quaternions against the axioms of a group and against scipy's rotations."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError

_ORDERS = ["".join(order) for order in itertools.permutations("xyz")]
_SEEDS = st.integers(0, 2**32 - 1)
_ANGLES = st.floats(-7.0, 7.0)


def _random(seed: int, *shape: int) -> FloatArray:
    return rot.normalize(np.random.default_rng(seed).normal(size=(*shape, 4)))


def _scipy(q: FloatArray) -> Rotation:
    return Rotation.from_quat(q[..., [1, 2, 3, 0]])


def _same(a: FloatArray, b: FloatArray, atol: float = 1e-9) -> None:
    """Equal as turns: q and -q are one; by chord, which keeps its digits where an arc cosine does not."""
    sign = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -1.0, 1.0)
    np.testing.assert_allclose(a * sign, b, atol=atol)


# ---- a group that acts on vectors ----


@given(_SEEDS)
def test_group_axioms(seed: int) -> None:
    a, b, c = _random(seed, 3, 5)
    one = rot.identity(5)
    np.testing.assert_allclose(rot.multiply(rot.multiply(a, b), c), rot.multiply(a, rot.multiply(b, c)), atol=1e-12)
    np.testing.assert_array_equal(rot.multiply(a, one), a)
    np.testing.assert_array_equal(rot.multiply(one, a), a)
    np.testing.assert_allclose(rot.multiply(a, rot.conjugate(a)), one, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(rot.multiply(a, b), axis=-1), 1.0)


@given(_SEEDS)
def test_a_product_turns_by_its_second_factor_first(seed: int) -> None:
    a, b = _random(seed, 2, 5)
    v = np.random.default_rng(seed).normal(size=(5, 3))
    np.testing.assert_allclose(rot.rotate(rot.multiply(a, b), v), rot.rotate(a, rot.rotate(b, v)), atol=1e-12)
    np.testing.assert_allclose(rot.rotate(a, v), _scipy(a).apply(v), atol=1e-12)
    _same(rot.multiply(a, b), (_scipy(a) * _scipy(b)).as_quat()[:, [3, 0, 1, 2]])


def test_the_axes_turn_counter_clockwise() -> None:
    x, y, z = np.eye(3)
    for axis, before, after in (("x", y, z), ("y", z, x), ("z", x, y)):
        np.testing.assert_allclose(rot.rotate(rot.about(axis, np.pi / 2), before), after, atol=1e-12)


def test_leading_dimensions_broadcast() -> None:
    q, v = _random(0, 4, 1), np.ones((3, 3))
    assert rot.rotate(q, v).shape == (4, 3, 3)
    assert rot.multiply(q, _random(1, 3)).shape == (4, 3, 4)
    np.testing.assert_array_equal(rot.rotate(q, v)[2, 1], rot.rotate(q[2, 0], v[1]))
    assert rot.identity(2, 3).shape == (2, 3, 4)


# ---- matrices, rotation vectors ----


@given(_SEEDS)
def test_matrices_agree_with_scipy_and_come_back(seed: int) -> None:
    q = _random(seed, 6)
    m = rot.to_matrix(q)
    np.testing.assert_allclose(m, _scipy(q).as_matrix(), atol=1e-12)
    _same(rot.from_matrix(m), q)
    assert (rot.from_matrix(m)[:, 0] >= 0).all()


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, -1, 1], [1, 1, 1], [-1, 2, -3]])
def test_half_turns_survive_the_matrix(axis: list[int]) -> None:
    q = np.array([0.0, *axis]) / np.linalg.norm(axis)
    _same(rot.from_matrix(rot.to_matrix(q)), q)


@given(_SEEDS, st.floats(-12.0, 0.5))
def test_exp_and_log_agree_with_scipy_down_to_nothing(seed: int, magnitude: float) -> None:
    axis = np.random.default_rng(seed).normal(size=3)
    v = axis / np.linalg.norm(axis) * min(10**magnitude, 3.14159)
    np.testing.assert_allclose(rot.exp(v), Rotation.from_rotvec(v).as_quat()[[3, 0, 1, 2]], atol=1e-15)
    np.testing.assert_allclose(rot.log(rot.exp(v)), v, rtol=1e-9, atol=1e-16)


def test_nothing_is_the_identity() -> None:
    np.testing.assert_array_equal(rot.exp(np.zeros((2, 3))), rot.identity(2))
    np.testing.assert_array_equal(rot.log(rot.identity(2)), np.zeros((2, 3)))


@given(_SEEDS, st.floats(-12.0, -1.0), st.booleans())
def test_log_is_at_most_pi_long_and_right_near_it(seed: int, magnitude: float, beyond: bool) -> None:
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    angle = np.pi + 10**magnitude * (1 if beyond else -1)
    v = rot.log(rot.exp(angle * axis))
    assert np.linalg.norm(v) <= np.pi + 1e-12
    short = angle - 2 * np.pi if beyond else angle
    np.testing.assert_allclose(v, short * axis, atol=1e-9)


@given(_SEEDS)
def test_angle_between_is_the_geodesic(seed: int) -> None:
    a, b = _random(seed, 2, 5)
    np.testing.assert_allclose(rot.angle_between(a, b), (_scipy(a).inv() * _scipy(b)).magnitude(), atol=1e-9)
    np.testing.assert_allclose(rot.angle_between(a, -b), rot.angle_between(a, b), atol=1e-9)


# ---- Euler angles ----


@pytest.mark.parametrize("order", _ORDERS)
@given(st.tuples(_ANGLES, _ANGLES, _ANGLES))
def test_euler_angles_agree_with_scipy(order: str, angles: tuple[float, float, float]) -> None:
    q = rot.from_euler(np.array(angles), order)
    _same(q, Rotation.from_euler(order.upper(), angles).as_quat()[[3, 0, 1, 2]])
    angles_back = rot.to_euler(q, order)
    assert abs(angles_back[1]) <= np.pi / 2
    _same(rot.from_euler(angles_back, order), q, atol=2e-6)
    if abs(np.cos(angles[1])) > 1e-3:
        # pi and -pi are one angle
        np.testing.assert_allclose(np.sin((angles_back - _scipy(q).as_euler(order.upper())) / 2), 0.0, atol=1e-6)


@pytest.mark.parametrize("order", _ORDERS)
@pytest.mark.parametrize("pole", [np.pi / 2, -np.pi / 2])
@given(st.tuples(_ANGLES, _ANGLES), st.sampled_from([0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-3]))
def test_at_the_poles_the_turn_is_kept(order: str, pole: float, outer: tuple[float, float], off: float) -> None:
    q = rot.from_euler(np.array([outer[0], pole - np.sign(pole) * off, outer[1]]), order)
    angles_back = rot.to_euler(q, order)
    _same(rot.from_euler(angles_back, order), q, atol=2e-6)
    if off < 1e-7:
        assert angles_back[2] == 0.0


@pytest.mark.parametrize("order", ["y", "xy", "zx", "zxz"])
def test_an_order_may_name_any_axes_on_the_way_in(order: str) -> None:
    angles = np.array([0.3, -0.4, 1.2])[: len(order)]
    _same(rot.from_euler(angles, order), Rotation.from_euler(order.upper(), angles).as_quat()[..., [3, 0, 1, 2]])


@pytest.mark.parametrize("order", ["", "abc", "xyzx", "XQ"])
def test_an_order_is_letters_of_three_axes(order: str) -> None:
    with pytest.raises(RequestError, match=r"Euler order must be one to three letters of x, y, z, found .*name it"):
        rot.from_euler(np.zeros(3), order)


def test_angles_come_out_about_three_different_axes() -> None:
    with pytest.raises(RequestError, match="must name three different axes, found 'zxz'; try 'zxy' or 'zyx'"):
        rot.to_euler(rot.identity(), "zxz")


# ---- between turns ----


@given(_SEEDS, st.floats(0.0, 1.0))
def test_slerp_agrees_with_scipy(seed: int, u: float) -> None:
    a, b = _random(seed, 2)
    expected = Slerp([0, 1], _scipy(np.stack([a, b])))(u).as_quat()[[3, 0, 1, 2]]
    _same(rot.slerp(a, b, u), expected)
    _same(rot.slerp(a, -b, u), expected)


@given(_SEEDS, st.sampled_from([0.0, 1e-12, 1e-9, 1e-7, 1e-6, 3e-6, 1e-4]), st.floats(0.0, 1.0))
def test_slerp_between_turns_that_are_nearly_one(seed: int, angle: float, u: float) -> None:
    a = _random(seed)
    axis = _random(seed + 1)[1:] / np.linalg.norm(_random(seed + 1)[1:])
    between = rot.slerp(a, rot.multiply(rot.exp(angle * axis), a), u)
    _same(between, rot.multiply(rot.exp(u * angle * axis), a), atol=1e-12)
    assert np.linalg.norm(between) == pytest.approx(1.0, abs=1e-12)


def test_slerp_takes_a_batch_of_fractions() -> None:
    u = np.array([0.0, 0.25, 1.0])
    _same(rot.slerp(rot.about("z", 0.2), rot.about("z", 1.0), u), rot.about("z", 0.2 + 0.8 * u))


@given(_SEEDS)
def test_unrolled_quaternions_are_the_same_turns_without_jumps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    smooth = rot.exp(np.cumsum(rng.normal(scale=0.2, size=(40, 2, 3)), axis=0))
    flipped = smooth * rng.choice([-1.0, 1.0], size=(40, 2, 1))
    for axis in (0, 1):
        q = rot.unroll(flipped, axis)
        _same(q, smooth)
        assert (np.sum(np.diff(np.moveaxis(q, axis, 0), axis=0) ** 2, axis=-1) <= 2.0 + 1e-12).all()
    np.testing.assert_array_equal(rot.unroll(flipped)[0], flipped[0])


@given(_SEEDS)
def test_between_takes_one_direction_to_the_other_the_short_way(seed: int) -> None:
    a, b = np.random.default_rng(seed).normal(size=(2, 5, 3)) * 3
    q = rot.between(a, b)
    unit = b / np.linalg.norm(b, axis=-1, keepdims=True) * np.linalg.norm(a, axis=-1, keepdims=True)
    np.testing.assert_allclose(rot.rotate(q, a), unit, atol=1e-9)
    cosine = np.sum(a * b, axis=-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    np.testing.assert_allclose(rot.angle_between(rot.identity(5), q), np.arccos(cosine), atol=1e-7)


@given(_SEEDS, st.floats(-12.0, -1.0))
def test_between_is_sound_near_opposite_directions(seed: int, magnitude: float) -> None:
    rng = np.random.default_rng(seed)
    a = rng.normal(size=3)
    a /= np.linalg.norm(a)
    b = rot.rotate(rot.exp(10**magnitude * np.cross(a, rng.normal(size=3))), -a)
    q = rot.between(a, b)
    assert np.linalg.norm(q) == pytest.approx(1.0)
    np.testing.assert_allclose(rot.rotate(q, a), b, atol=1e-4)


@pytest.mark.parametrize("a", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [3, -2, 1], [0.95, 0.1, 0]])
def test_between_opposite_directions_is_half_a_turn(a: list[float]) -> None:
    q = rot.between(np.array(a), -np.array(a))
    np.testing.assert_allclose(rot.rotate(q, np.array(a)), -np.array(a), atol=1e-12)
    assert q[0] == 0.0


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@given(_SEEDS)
def test_twist_is_the_nearest_turn_about_an_axis(axis: str, seed: int) -> None:
    q = _random(seed)
    angle = float(rot.twist(q, axis))
    assert -np.pi <= angle < np.pi
    others = rot.angle_between(rot.about(axis, np.linspace(-np.pi, np.pi, 181)), q)
    assert rot.angle_between(rot.about(axis, angle), q) <= others.min() + 1e-9


@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1), st.floats(0.0, 2.0))
def test_twist_is_what_is_left_beside_the_swing(angle: float, direction: float, swing: float) -> None:
    level = np.array([np.cos(direction), 0.0, np.sin(direction)])
    q = rot.multiply(rot.exp(swing * level), rot.about("y", angle))
    assert rot.twist(q, "y") == pytest.approx(angle, abs=1e-9)
    assert rot.twist(-q, "y") == pytest.approx(angle, abs=1e-9)


@given(_SEEDS)
def test_without_heading_what_is_left_faces_ahead(seed: int) -> None:
    q = _random(seed, 5)
    level = rot.without_heading(q)
    np.testing.assert_allclose(rot.heading(level), 0.0, atol=1e-9)
    _same(rot.multiply(rot.about("y", rot.heading(q)), level), q)
    # whatever the heading was, the same is left
    _same(rot.without_heading(rot.multiply(rot.about("y", 1.3), q)), level)


@given(_SEEDS, _ANGLES)
def test_a_rotation_about_the_vertical_adds_to_the_heading(seed: int, angle: float) -> None:
    q = _random(seed)
    ahead = float(rot.heading(rot.multiply(rot.about("y", angle), q)) - rot.heading(q))
    assert np.exp(1j * ahead) == pytest.approx(np.exp(1j * angle), abs=1e-9)
