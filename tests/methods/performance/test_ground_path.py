from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.performance import begin_facing, hips_on_ground, path_on_ground, path_speeds, smooth_path
from kinetograph.motion import place
from kinetograph.signal import Signal
from walkers import walk

_FPS = 60.0


def _path(points: FloatArray, fps: float = _FPS) -> Signal:
    return Signal(np.asarray(points, dtype=np.float64).reshape(len(points), -1, 3), ("p",), "m", fps)


def _line(frames: int = 61, speed: float = 1.0) -> FloatArray:
    return np.outer(np.arange(frames) / _FPS * speed, [0.0, 0.0, 1.0])


def _circle(radius: float = 2.0, speed: float = 1.0, frames: int = 361) -> FloatArray:
    """Anticlockwise seen from above (from +z to +x, a left turn): starts towards +z."""
    angle = np.arange(frames) / _FPS * speed / radius
    return radius * np.stack([1 - np.cos(angle), 0 * angle, np.sin(angle)], axis=1)


def test_left_of_a_walk_towards_z_is_x() -> None:
    points = path_on_ground(_path(_line()), 0.3)
    np.testing.assert_allclose(points[:, 0] - points[:, 1], [[0.3, 0, 0]] * 61, atol=1e-12)
    np.testing.assert_allclose(points.mean(axis=1), _line(), atol=1e-12)


def test_on_a_circle_left_and_right_lie_on_its_radius() -> None:
    points = path_on_ground(_path(_circle()), 0.4)
    centre = np.array([2.0, 0.0, 0.0])
    radii = np.linalg.norm(points - centre, axis=-1)[1:-1]
    np.testing.assert_allclose(radii[:, 0], 1.8, atol=1e-3)
    np.testing.assert_allclose(radii[:, 1], 2.2, atol=1e-3)


def test_the_ground_is_at_no_height() -> None:
    raised = _circle() + np.stack([np.zeros(361), 1 + np.sin(np.arange(361)), np.zeros(361)], axis=1)
    np.testing.assert_allclose(path_on_ground(_path(raised), 0.3), path_on_ground(_path(_circle()), 0.3), atol=1e-12)


def test_a_path_and_a_walker_upon_it_say_the_same() -> None:
    motion = walk(4.0, fps=_FPS, turn_rate=0.5)
    from_path = path_on_ground(_path(motion.translation), 0.3)
    np.testing.assert_allclose(hips_on_ground(motion, 0.3)[1:-1], from_path[1:-1], atol=1e-3)


@given(turn=st.floats(-3.0, 3.0), distance=st.floats(0.01, 2.0))
def test_hips_are_set_apart_by_the_distance_asked(turn: float, distance: float) -> None:
    points = hips_on_ground(place(walk(0.5), turn, (1, 2, 3)), distance)
    np.testing.assert_allclose(np.linalg.norm(points[:, 0] - points[:, 1], axis=-1), distance)
    np.testing.assert_array_equal(points[..., 1], 0.0)
    np.testing.assert_allclose((points[0, 0] - points[0, 1]) / distance, [np.cos(turn), 0, -np.sin(turn)], atol=1e-9)


def test_while_a_path_stands_its_facing_turns_from_before_to_after() -> None:
    # towards z, a stop of a second, towards x
    before, after = _line(31), _line(31)[:, [2, 1, 0]]
    stop = np.repeat(before[-1:], 60, axis=0)
    points = path_on_ground(_path(np.concatenate([before, stop, before[-1] + after])), 1.0)
    left = points[:, 0] - points[:, 1]
    np.testing.assert_allclose(left[10], [1, 0, 0], atol=1e-9)
    np.testing.assert_allclose(left[-10], [0, 0, -1], atol=1e-9)
    np.testing.assert_allclose(left[60], [np.sqrt(0.5), 0, -np.sqrt(0.5)], atol=0.02)
    turned = np.unwrap(np.arctan2(-left[:, 2], left[:, 0]))
    assert np.diff(turned).min() >= -1e-12
    assert np.diff(turned).max() < 0.05


def test_a_path_that_stands_while_it_faces_back_turns_the_short_way() -> None:
    # towards -z and a little to one side, a stop, and a little to the other: left is -x throughout
    step = np.array([0.001, 0.0, -0.02])
    before, after = np.arange(30)[:, None] * step, np.arange(30)[:, None] * step * [-1, 1, 1]
    values = np.concatenate([before, np.repeat(before[-1:], 30, axis=0), before[-1] + after])
    points = path_on_ground(_path(values), 1.0)
    assert (points[:, 0] - points[:, 1])[:, 0].max() < -0.99


def test_a_path_that_stands_at_its_ends_faces_as_it_goes() -> None:
    line = _line(31)
    held = np.concatenate([np.repeat(line[:1], 20, axis=0), line, np.repeat(line[-1:], 20, axis=0)])
    points = path_on_ground(_path(held), 1.0)
    np.testing.assert_allclose(points[:, 0] - points[:, 1], [[1.0, 0, 0]] * 71, atol=1e-9)


def test_two_points_give_the_facing_themselves() -> None:
    pair = np.zeros((5, 2, 3))
    pair[:, 0, 2], pair[:, 1, 2] = 1.0, -1.0
    points = path_on_ground(Signal(pair, ("l", "r"), "m", 30.0), 0.5)
    np.testing.assert_allclose(points, pair / 4, atol=1e-12)


@pytest.mark.parametrize("values", [np.zeros((30, 3)), np.zeros((1, 3)), _line(30, speed=0.04)])
def test_a_path_that_stays_on_the_spot_faces_along_z(values: FloatArray) -> None:
    points = path_on_ground(_path(values), 0.3)
    np.testing.assert_allclose(points[:, 0] - points[:, 1], np.tile([0.3, 0.0, 0.0], (len(values), 1)), atol=1e-12)


def test_a_slow_path_that_goes_somewhere_has_its_own_direction() -> None:
    along_x = np.outer(np.arange(600) / _FPS * 0.04, [1.0, 0.0, 0.0])
    points = path_on_ground(_path(along_x), 0.3)
    np.testing.assert_allclose(points[300, 0] - points[300, 1], [0.0, 0.0, -0.3], atol=1e-9)


def test_people_turn_at_the_end_of_a_long_pause() -> None:
    fps, pause = round(_FPS), 8.0
    there = np.arange(2 * fps)[:, None] / fps * [0.0, 0.0, 1.0]
    back = there[-1] + np.arange(1, 2 * fps)[:, None] / fps * [1.0, 0.0, 0.0]
    path = np.concatenate([there, np.repeat(there[-1:], round(pause * fps), axis=0), back])
    points = path_on_ground(_path(path), 0.3)
    across = points[:, 0] - points[:, 1]
    facing = np.rad2deg(np.unwrap(np.arctan2(-across[:, 2], across[:, 0])))  # left is along x where it faces z
    start, stop = 2 * fps, 2 * fps + round(pause * fps)
    np.testing.assert_allclose(facing[start : stop - round(2.0 * fps)], 0.0, atol=1e-6)
    assert facing[-1] == pytest.approx(90.0, abs=1e-6)
    assert np.abs(np.diff(facing)).max() * fps < 150.0


def test_a_signal_that_is_not_a_path_is_an_error() -> None:
    three = Signal(np.zeros((5, 3, 3)), ("a", "b", "c"), "m", 30.0)
    with pytest.raises(RequestError, match=r"a walk follows one point .*, found 3 points: a, b, c"):
        path_on_ground(three, 0.3)
    with pytest.raises(RequestError, match="found 1 channels: force"):
        path_on_ground(Signal(np.zeros((5, 1)), ("force",), "N", 30.0), 0.3)


def test_speeds_are_those_of_the_midpoint_on_the_ground() -> None:
    points = path_on_ground(_path(_circle(speed=1.3)), 0.3)
    np.testing.assert_allclose(path_speeds(points, _FPS), 1.3, atol=1e-3)
    np.testing.assert_array_equal(path_speeds(points[:1], _FPS), [0.0])


# ---- smoothing ----


@pytest.mark.parametrize(("time", "space"), [(0.3, 0.0), (0.0, 0.5), (0.2, 0.3), (5.0, 0.0), (0.0, 50.0)])
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_smoothing_keeps_both_ends(time: float, space: float, seed: int) -> None:
    walked = np.cumsum(np.random.default_rng(seed).normal(scale=0.02, size=(90, 3)), axis=0)
    calm = smooth_path(_path(walked), time, space)
    np.testing.assert_allclose(calm.values[[0, -1], 0], walked[[0, -1]], atol=1e-9)
    assert (len(calm), calm.fps, calm.names) == (90, _FPS, ("p",))


@pytest.mark.parametrize(("time", "space"), [(0.3, 0.0), (0.0, 0.5), (0.2, 0.3)])
def test_a_straight_even_path_is_calm_already(time: float, space: float) -> None:
    np.testing.assert_allclose(smooth_path(_path(_line(121)), time, space).values[:, 0], _line(121), atol=1e-6)


def test_smoothing_takes_jitter_away() -> None:
    jitter = 0.02 * np.random.default_rng(0).normal(size=(361, 3)) * [1, 0, 1]
    rough = _circle() + jitter
    for calm in (smooth_path(_path(rough), time=0.15), smooth_path(_path(rough), space=0.3)):
        off = np.abs(np.linalg.norm(calm.values[20:-20, 0] - [2.0, 0, 0], axis=1) - 2.0)
        assert off.mean() < 0.5 * np.abs(np.linalg.norm(rough[20:-20] - [2.0, 0, 0], axis=1) - 2.0).mean()


def test_smoothing_in_space_keeps_the_timing() -> None:
    # a quick half and a slow half of one line: in time the corner of the speed would blur, in space it does not
    distance = np.concatenate([np.arange(60) / 30, 2.0 + np.arange(60) / 120])
    line = np.outer(distance, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(smooth_path(_path(line), space=0.4).values[:, 0], line, atol=1e-6)
    assert np.abs(smooth_path(_path(line), time=0.2).values[:, 0] - line).max() > 0.05


def test_a_path_that_stands_or_is_one_sample_can_be_smoothed() -> None:
    for values in (np.ones((10, 3)), np.ones((1, 3))):
        np.testing.assert_allclose(smooth_path(_path(values), 0.5, 0.5).values[:, 0], values)


def test_no_smoothing_changes_nothing() -> None:
    np.testing.assert_array_equal(smooth_path(_path(_circle())).values[:, 0], _circle())


# ---- paths as hands draw them ----


def _facing(points: FloatArray) -> FloatArray:
    across = points[:, 0] - points[:, 1]
    return np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_a_trembling_pause_does_not_spin(seed: int) -> None:
    line = np.concatenate([_line(121), np.repeat(_line(121)[-1:], 180, axis=0), _line(121)[-1] + _line(121)])
    jitter = 0.004 * np.random.default_rng(seed).normal(size=line.shape) * [1, 0, 1]
    facing = _facing(path_on_ground(_path(line + jitter), 0.3))
    assert np.abs(facing).max() < np.deg2rad(25)


@pytest.mark.parametrize("corner", [90.0, 135.0, 180.0])
def test_corners_and_reversals_are_turned_as_people_turn(corner: float) -> None:
    to = np.deg2rad(corner) - 1e-3
    after = _line(181)[:, [2]] * np.array([[np.sin(to), 0.0, np.cos(to)]])
    facing = _facing(path_on_ground(_path(np.concatenate([_line(181), _line(181)[-1] + after])), 0.3))
    assert np.abs(np.diff(facing)).max() * _FPS <= np.deg2rad(151)
    assert facing[-1] - facing[0] == pytest.approx(to, abs=0.02)


def test_a_slow_path_has_a_direction_too() -> None:
    np.testing.assert_allclose(_facing(path_on_ground(_path(_line(301, speed=0.1)), 0.3)), 0.0, atol=1e-9)


@pytest.mark.parametrize("degrees", [-180.0, -90.0, -30.0, 0.0, 45.0, 170.0])
def test_a_path_that_begins_facing_away_is_turned_into(degrees: float) -> None:
    path = _path(_line(301, 1.0))
    begun = begin_facing(path, np.deg2rad(degrees))
    across = begun.values[:, 0] - begun.values[:, 1]
    facing = np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))
    assert abs((facing[0] - np.deg2rad(degrees) + np.pi) % (2 * np.pi) - np.pi) < 1e-6
    assert abs(np.sin(facing[-1])) < 1e-6  # in the end it faces as it goes
    assert np.abs(np.diff(facing)).max() * _FPS <= np.deg2rad(150) * 1.01
    middle = begun.values.mean(axis=1)
    np.testing.assert_allclose(middle[[0, -1]], path.values[[0, -1], 0], atol=1.1 / _FPS)  # the same way
    np.testing.assert_allclose(middle[:, 0], 0.0, atol=1e-9)
    speed = np.diff(middle[:, 2]) * _FPS
    assert speed.min() > -1e-9
    assert speed.max() < 1.0 + 1e-9
    away = np.abs(facing[:-1]) > np.pi / 2 + 0.05
    assert np.all(speed[away] < 1e-9)  # nobody walks backwards meanwhile
    assert begun.duration >= path.duration - 1e-9
