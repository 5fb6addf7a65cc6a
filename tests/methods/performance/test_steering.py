"""Steering: springs against an ODE solver, bodies that go where they are wished, flat time and memory."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.arrays import ComplexArray
from kinetograph.errors import RequestError
from kinetograph.evaluation import MotionMatching, score_steering, steer_by, sticks
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, Steering, SteeringFrames
from kinetograph.methods.performance.steering_frames import ROWS, UNIT, make_states
from kinetograph.methods.performance.wishes import Goal, PathRest, Stick, WishedPath, ahead
from kinetograph.post import Pose
from kinetograph.take import Take
from walkers import walk

FPS = 60.0


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> PerformanceModel:
    """Walks that go straight, turn either way, and slow down and stand."""
    library = kg.Library.create(Path(tmp_path_factory.mktemp("steering")) / "walks")
    t = np.arange((20 * 30) + 1) / 30
    library.add(Take("turns", {"body": walk(20.0, speed=1.0, turn_rate=1.2 * np.sin(0.5 * t))}))
    speed = np.clip(0.6 + 0.8 * np.sin(0.8 * t), 0.0, 1.1)
    library.add(Take("stops", {"body": walk(20.0, speed=speed, turn_rate=0.3 * np.cos(t) * speed)}))
    return PerformanceControl(mirror=True).fit(library)


def _place(pose: Pose) -> complex:
    return complex(pose.translation[2], pose.translation[0])


def _drive(steering: Steering, velocity: complex, seconds: float) -> ComplexArray:
    return np.array(
        [_place(steering.step((velocity.imag, velocity.real), None, 1 / FPS)) for _ in range(round(seconds * FPS))]
    )


# ---- wishes ----


def test_the_wished_point_is_a_critically_damped_spring() -> None:
    path = WishedPath(0.2, 1 + 2j, 0.5 - 1j, 3j, 0.4, -0.7)
    goal, facing = 1.2 + 0.3j, 1.9
    y = 2 * np.log(2) / 0.2

    def slope(_: float, s: np.ndarray) -> np.ndarray:
        return np.array(
            [s[1], s[2], -2 * y * s[2] - y**2 * (s[1] - goal), s[4], -2 * y * s[4] - y**2 * (s[3] - facing)]
        )

    start = np.array([path.place, path.velocity, path.acceleration, path.facing, path.turning])
    exact = solve_ivp(slope, (0, 0.37), start, rtol=1e-10, atol=1e-12).y[:, -1]
    after = path.after(goal, facing, 0.37)
    got = np.array([after.place, after.velocity, after.acceleration, after.facing, after.turning])
    assert np.allclose(got, exact, atol=1e-8)
    twice = path.after(goal, facing, 0.2).after(goal, facing, 0.17)
    assert np.allclose(twice.place, after.place)


def test_facings_are_approached_the_shorter_way_round() -> None:
    path = WishedPath(facing=3.0)
    assert path.after(0j, -3.0, 5.0).facing == pytest.approx(-3.0, abs=1e-6)
    assert path.after(0j, -3.0, 0.05).facing < -3.0  # through pi, not through 0


def test_a_wish_is_looked_at_ahead() -> None:
    rows = ahead(Stick(1.0 + 0j), WishedPath(velocity=1.0 + 0j), 0.1, 15)
    assert np.allclose(rows, np.column_stack([0.1 * np.arange(1, 16), np.zeros((15, 2))]), atol=1e-9)
    stays = ahead(Goal(0.5 + 0j, 1.0), WishedPath(velocity=1.0 + 0j), 0.1, 60)
    assert stays[-1, 0] == pytest.approx(0.5, abs=0.01)
    rest = ahead(PathRest(np.array([0j, 1j, 2j]), 10.0), WishedPath(), 0.1, 4)
    assert np.allclose(rest[:, 1], [1.0, 2.0, 2.0, 2.0])


# ---- bodies ----


def test_a_body_follows_a_stick_turns_and_stops(model: PerformanceModel) -> None:
    steering = model.steer(place=(1.0, -2.0), facing=0.0)
    first = _drive(steering, 1.0 + 0j, 4.0)
    assert abs(first[0] - complex(-2.0, 1.0)) < 0.1
    velocity = (first[-1] - first[-60]) * FPS / 59
    assert abs(velocity - 1.0) < 0.15
    turned = _drive(steering, 1.0j, 4.0)
    velocity = (turned[-1] - turned[-60]) * FPS / 59
    assert abs(velocity - 1.0j) < 0.2
    assert abs(steering.path.place - turned[-1]) < 0.1
    stood = _drive(steering, 0j, 4.0)
    assert np.ptp(np.abs(stood[-60:] - stood[-60])) < 0.1


def test_a_body_goes_to_a_goal_and_stays(model: PerformanceModel) -> None:
    steering = model.steer()
    poses = [steering.step_to((2.0, 2.0), 1 / FPS, speed=1.0) for _ in range(round(8 * FPS))]
    assert abs(_place(poses[-1]) - (2 + 2j)) < 0.2


def test_a_body_follows_the_rest_of_a_path(model: PerformanceModel) -> None:
    t = np.arange(0, 12, 1 / FPS)
    path = np.stack([1.5 * (1 - np.cos(0.6 * t)), 1.5 * np.sin(0.6 * t)], axis=1)  # 0.9 m/s along a circle, from z
    steering = model.steer()
    off = []
    for frame in range(1, len(t) - 100):
        pose = steering.step_along(path[frame - 1 :], FPS, 1 / FPS)
        off.append(abs(_place(pose) - complex(path[frame, 1], path[frame, 0])))
    assert np.mean(off[120:]) < 0.1


def test_the_same_input_gives_the_same_poses(model: PerformanceModel) -> None:
    runs = []
    for _ in range(2):
        steering = model.steer()
        runs.append(np.concatenate([_drive(steering, v, 1.5) for v in (1.0 + 0j, 1.0j, -0.8 + 0j, 0j)]))
    assert np.array_equal(*runs)


def test_jumps_are_joined_and_no_pose_leaps(model: PerformanceModel) -> None:
    steering = model.steer()
    poses = [steering.step((1.0 * np.sin(k / 120), 1.0 * np.cos(k / 90)), None, 1 / FPS) for k in range(900)]
    assert steering.jumps > 3
    places, rotations = np.stack([p.translation for p in poses]), np.stack([p.rotations for p in poses])
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() * FPS < 2.0
    assert rot.angle_between(rotations[1:], rotations[:-1]).max() * FPS < 15.0
    assert np.allclose(np.linalg.norm(rotations, axis=-1), 1.0, atol=1e-6)


def test_a_placed_body_is_the_same_body_elsewhere(model: PerformanceModel) -> None:
    here, there = model.steer(), model.steer(place=(3.0, -1.0), facing=0.8)
    turn = np.exp(0.8j)
    a = _drive(here, 1.0 + 0.2j, 3.0)
    b = _drive(there, (1.0 + 0.2j) * turn, 3.0)
    assert np.allclose(a * turn + complex(-1.0, 3.0), b, atol=1e-6)


def test_long_and_uneven_steps_are_taken_unit_by_unit(model: PerformanceModel) -> None:
    steering = model.steer()
    for dt in (0.004, 1.0, 0.31, 1 / 60, 0.1, 1e-9, 0.25):
        pose = steering.step((0.0, 0.8), 0.0, dt)
        assert np.isfinite(pose.translation).all()
        assert np.isfinite(pose.rotations).all()


def test_what_cannot_be_wished_is_refused(model: PerformanceModel) -> None:
    steering = model.steer()
    for velocity in ((np.nan, 0.0), (1.0,), (120.0, 0.0), "ab"):
        with pytest.raises((RequestError, ValueError), match=r"velocity|could not"):
            steering.step(velocity, None, 1 / FPS)
    with pytest.raises(RequestError, match="a facing is a finite number of radians"):
        steering.step((0, 1), np.inf, 1 / FPS)
    for dt in (0.0, -1.0, np.nan, 2.0):
        with pytest.raises(RequestError, match="a step is more than 0 and 1 s at most"):
            steering.step((0, 1), None, dt)
    with pytest.raises(RequestError, match="speed must be"):
        steering.step_to((0, 1), 1 / FPS, speed=0)
    with pytest.raises(RequestError, match="a path is finite metres"):
        steering.step_along([[0.0, np.inf]], 60, 1 / FPS)


def test_an_impossible_wish_is_held_on_a_leash(model: PerformanceModel) -> None:
    steering = model.steer()
    places = _drive(steering, 15.0 + 0j, 5.0)
    assert abs(steering.path.place - places[-1]) < 0.7


def test_memory_and_work_are_flat(model: PerformanceModel) -> None:
    steering = model.steer()
    _drive(steering, 1.0 + 0j, 2.0)
    tracemalloc.start()
    grown = []
    for k in range(6):
        for j in range(600):
            v = np.exp(1j * (k + j // 150))
            steering.step((v.imag, v.real), None, 1 / FPS)
        grown.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert grown[-1] - grown[1] < 50_000  # bytes, over 2,400 steps


def test_motion_matching_steers_too_and_is_scored_alike(model: PerformanceModel) -> None:
    frames = SteeringFrames.of(model.fitted.sources)
    for made in (sticks(3, 4.0), sticks(3, 4.0)):
        results = [steer_by(Steering(frames, MotionMatching(frames)), stick) for stick in made[:2]]
        scores = score_steering(results)
    assert 0.0 < scores.path < 0.5
    assert scores.jumps > 0
    matching = MotionMatching(frames)
    assert matching.units == 10
    assert all(np.array_equal(a.velocity, b.velocity) for a, b in zip(sticks(3, 4.0), made, strict=True))


def test_frames_are_found_by_recording_and_time(model: PerformanceModel) -> None:
    frames = SteeringFrames.of(model.fitted.sources)
    row = frames.row(1, 2.0)
    assert frames.source[row] == 1
    assert frames.second[row] == pytest.approx(2.0, abs=0.5 * UNIT / ROWS)
    assert frames.between(frames.place, 1, 2.0) == pytest.approx(frames.place[row], abs=0.02)


def test_states_are_a_unit_apart_from_the_beginning_of_each_recording(model: PerformanceModel) -> None:
    frames = SteeringFrames.of(model.fitted.sources)
    states = make_states(frames, 4.0, 1e-3, count=8)
    assert states.first[0] == 0
    assert states.first[-1] == len(states.rows)
    assert states.rows[states.first[:-1]].tolist() == frames.starts[:-1].tolist()
    for recording in range(len(states.first) - 1):
        own = slice(states.first[recording], states.first[recording + 1])
        assert np.all(np.diff(states.rows[own]) == ROWS)
        assert states.near(recording, 0.0) == states.first[recording]
