from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, RequestError
from kinetograph.kinematics import joint_positions
from kinetograph.motion import (
    Motion,
    close_loop,
    concatenate,
    cut,
    loop_step,
    place,
    repeat,
    resample,
    sample,
    transform,
    unwrapped_headings,
)
from kinetograph.skeleton import Skeleton
from walkers import slide, stick_figure, walk

_UP = np.array([0.0, 1.0, 0.0])
_BONES = Skeleton(("root", "tip"), np.array([-1, 0]), np.array([[0, 0, 0], [0, 1, 0]]))


def _steady(frames: int = 9, fps: float = 8.0) -> Motion:
    """Constant velocity, constant angular velocities, a bone that grows evenly: exact under interpolation."""
    return _steady_at(np.arange(frames) / fps, fps)


def _steady_at(times: FloatArray, fps: float) -> Motion:
    rotations = np.stack([rot.about("y", 1.5 * times), rot.exp(np.outer(times, [0.4, -0.3, 2.0]))], axis=1)
    bones = np.zeros((len(times), 2, 3))
    bones[:, 1, 1] = 1 + 0.25 * times
    return Motion(_BONES, np.outer(times, [1.0, -0.5, 2.0]) + _UP, rotations, fps, bones)


def _random(seed: int, frames: int = 6) -> Motion:
    rng = np.random.default_rng(seed)
    rotations = rot.normalize(rng.normal(size=(frames, 2, 4)))
    return Motion(_BONES, rng.normal(size=(frames, 3)), rotations, 30.0)


def _same(a: Motion, b: Motion, atol: float = 1e-9) -> None:
    assert (len(a), a.fps) == (len(b), b.fps)
    np.testing.assert_allclose(a.translation, b.translation, atol=atol)
    dots = np.abs(np.sum(a.rotations * b.rotations, axis=-1))
    np.testing.assert_allclose(dots, 1.0, atol=atol)
    np.testing.assert_allclose(joint_positions(a), joint_positions(b), atol=max(atol, 1e-9))


# ---- frames ----


def test_cut_takes_half_open_frames() -> None:
    part = cut(_steady(), 2, 5)
    _same(part, _steady_at(np.arange(2, 5) / 8, 8.0))
    assert part.duration == pytest.approx(0.25)


@pytest.mark.parametrize(("start", "stop"), [(-1, 3), (3, 3), (4, 2), (0, 10)])
def test_cut_stays_within_the_motion(start: int, stop: int) -> None:
    with pytest.raises(RequestError, match=rf"frames {start} to {stop} are not within this motion's 0 to 9"):
        cut(_steady(), start, stop)


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
def test_sampling_steady_motion_is_exact(times: list[float]) -> None:
    _same(sample(_steady(), times, 50.0), _steady_at(np.array(times), 50.0))


def test_times_beyond_the_ends_hold_the_end_pose() -> None:
    held = sample(_steady(), [-1.0, 0.0, 1.0, 7.0], 8.0)
    _same(held, sample(_steady(), [0.0, 0.0, 1.0, 1.0], 8.0))


def test_a_motion_of_one_frame_can_be_sampled() -> None:
    single = cut(_steady(), 3, 4)
    assert single.duration == 0.0
    _same(sample(single, [0.0, 0.5], 8.0), concatenate([single, single]))
    assert len(resample(single, 60.0)) == 1


@pytest.mark.parametrize(("fps", "frames"), [(16.0, 17), (24.0, 25), (4.0, 5), (7.0, 8), (3.0, 4), (59.94, 60)])
def test_resampling_steady_motion_is_exact(fps: float, frames: int) -> None:
    changed = resample(_steady(), fps)
    assert len(changed) == frames
    _same(changed, _steady_at(np.arange(frames) / fps, fps))


def test_the_last_frame_is_met_whatever_the_rounding() -> None:
    assert (30 - 1) / 25.0 * 50.0 < 58  # in floating point
    assert len(resample(_steady(30, 25.0), 50.0)) == 59


def test_resampling_to_the_same_rate_changes_nothing() -> None:
    motion = _steady()
    assert resample(motion, 8.0) is motion


@given(seed=st.integers(0, 2**32 - 1), factor=st.integers(2, 5))
def test_resampling_up_and_down_again_is_the_identity(seed: int, factor: int) -> None:
    motion = _random(seed)
    _same(resample(resample(motion, 30.0 * factor), 30.0), motion)


@pytest.mark.parametrize("fps", [0.0, -1.0, np.nan, np.inf])
def test_a_rate_is_positive_and_finite(fps: float) -> None:
    with pytest.raises(RequestError, match="fps must be a positive number, found"):
        resample(_steady(), fps)
    with pytest.raises(DataError, match="fps must be a positive number, found"):
        dataclasses.replace(_steady(), fps=fps)


# ---- in the world ----


@given(seed=st.integers(0, 2**32 - 1))
def test_transform_moves_every_joint_rigidly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, shift = rot.normalize(rng.normal(size=4)), rng.normal(size=3)
    motion = _random(seed)
    expected = rot.rotate(q, joint_positions(motion)) + shift
    np.testing.assert_allclose(joint_positions(transform(motion, q, shift)), expected, atol=1e-9)
    back = transform(transform(motion, q, shift), rot.conjugate(q), -rot.rotate(rot.conjugate(q), shift))
    _same(back, motion)


def test_place_turns_about_the_vertical_and_then_moves() -> None:
    motion = _random(0)
    _same(place(motion, 0.7, (1, 2, 3)), transform(motion, rot.about("y", 0.7), (1, 2, 3)))
    placed = unwrapped_headings(place(walk(), 0.7, (0, 0, 0)))
    np.testing.assert_allclose(placed, unwrapped_headings(walk()) + 0.7, atol=1e-9)


def test_headings_can_be_unwrapped() -> None:
    circling, angles = walk(8.0, turn_rate=1.5), 1.5 * np.arange(241) / 30
    np.testing.assert_allclose(unwrapped_headings(circling), angles, atol=1e-9)
    wrapped = rot.heading(circling.rotations[:, 0])
    assert np.abs(wrapped).max() <= np.pi
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angles), atol=1e-9)
    assert np.abs(np.diff(wrapped)).max() > 6.0  # a full rotation back, which unwrapping takes out


def test_concatenate_puts_frames_one_after_another() -> None:
    motion = _steady()
    _same(concatenate([cut(motion, 0, 4), cut(motion, 4, 9)]), motion)


def test_concatenate_gives_rigid_parts_their_rest_bones() -> None:
    rigid, growing = _random(0), _steady(fps=30.0)
    both = concatenate([rigid, growing])
    np.testing.assert_allclose(joint_positions(both)[:6], joint_positions(rigid), atol=1e-12)
    np.testing.assert_allclose(joint_positions(both)[6:], joint_positions(growing), atol=1e-12)
    assert concatenate([rigid, rigid]).bones is None


def test_concatenate_needs_one_skeleton_and_one_rate() -> None:
    other = Motion(Skeleton(("a", "b"), np.array([-1, 0]), np.zeros((2, 3))), np.zeros((1, 3)), rot.identity(1, 2), 30)
    for second in (other, _steady(fps=29.0)):
        with pytest.raises(RequestError, match="only motions of one skeleton and one rate can be joined; resample or"):
            concatenate([_random(0), second])


# ---- loops ----


def _nearly_looping(turn_rate: float = 0.4) -> Motion:
    """A cycle that does not quite close: the pose, the root's lean and its height are off at the end."""
    motion = walk(1.0, turn_rate=turn_rate)
    u = np.linspace(0, 1, len(motion))
    drift = rot.exp(np.einsum("f,ji->fji", u, np.random.default_rng(0).normal(scale=0.1, size=(15, 3))))
    drift[:, 0] = rot.exp(np.outer(u, [0.05, 0.0, -0.08]))
    translation = motion.translation + np.outer(u, [0, 0.03, 0])
    return dataclasses.replace(motion, translation=translation, rotations=rot.multiply(motion.rotations, drift))


def test_a_loop_steps_by_its_turn_and_shift() -> None:
    motion = walk(1.0, speed=1.2, turn_rate=0.6)
    turn, shift = loop_step(motion)
    assert turn == pytest.approx(0.6)
    np.testing.assert_allclose(place(motion, turn, shift).translation[0], motion.translation[-1], atol=1e-9)


@pytest.mark.parametrize("turn_rate", [0.0, 0.4, -2.5])
def test_a_closed_loop_ends_in_the_pose_it_began_with(turn_rate: float) -> None:
    motion = _nearly_looping(turn_rate)
    closed = close_loop(motion)
    again = place(closed, *loop_step(motion))
    _same(cut(again, 0, 1), cut(closed, 30, 31))
    with pytest.raises(AssertionError):  # it did not before
        _same(cut(place(motion, *loop_step(motion)), 0, 1), cut(motion, 30, 31))


def test_closing_spreads_the_gap_and_keeps_path_and_heading() -> None:
    motion = _nearly_looping()
    closed = close_loop(motion)
    np.testing.assert_allclose(closed.translation[:, [0, 2]], motion.translation[:, [0, 2]], atol=1e-12)
    np.testing.assert_allclose(closed.translation[:, 1] - motion.translation[:, 1], np.linspace(0.015, -0.015, 31))
    moved = rot.angle_between(closed.rotations, motion.rotations)
    np.testing.assert_allclose(moved[0], moved[-1], atol=1e-6)
    assert np.all(moved <= moved[0] + 1e-6)
    assert moved[15].max() < 1e-6
    assert np.abs(unwrapped_headings(closed) - unwrapped_headings(motion)).max() < 0.01


def test_closing_a_loop_that_is_closed_changes_nothing() -> None:
    _same(close_loop(walk(1.0, turn_rate=0.6)), walk(1.0, turn_rate=0.6), atol=1e-7)


def test_a_repeated_walk_is_the_long_walk() -> None:
    # the recording is one period long, so the truth is known
    _same(repeat(walk(1.0, turn_rate=0.6), 4), walk(4.0, turn_rate=0.6), atol=1e-6)


@given(turn_rate=st.floats(-3.0, 3.0))
@settings(max_examples=20)
def test_cycles_go_on_where_the_last_one_ended(turn_rate: float) -> None:
    motion = _nearly_looping(turn_rate)
    long = repeat(motion, 3)
    assert len(long) == 3 * 30 + 1
    turn, shift = loop_step(motion)
    for cycle in (1, 2):
        _same(cut(long, 30 * cycle, 30 * cycle + 31), place(cut(long, 30 * (cycle - 1), 30 * cycle + 1), turn, shift))
    # nothing jumps at a border: a step there is no longer than the steps within a cycle
    steps = np.linalg.norm(np.diff(joint_positions(long), axis=0), axis=-1).max(axis=1)
    assert steps[29:31].max() < 1.5 * np.delete(steps, [29, 30, 59, 60]).max()
    faced = unwrapped_headings(long)
    np.testing.assert_allclose(faced[[30, 60, 90]] - faced[0], turn * np.arange(1, 4), atol=1e-6)


def test_a_clip_is_repeated_once_or_more() -> None:
    motion = _nearly_looping()
    _same(repeat(motion, 1), close_loop(motion))
    with pytest.raises(RequestError, match="a clip can be repeated 1 time or more, found 0"):
        repeat(motion, 0)


def test_bones_of_a_loop_are_kept() -> None:
    stretched = slide(walk(1.0), "left_hand", np.full((31, 3), 0.01))
    np.testing.assert_allclose(repeat(stretched, 2).bones, np.broadcast_to(stretched.bones[0], (61, 15, 3)))  # type: ignore[index]


# ---- invariants ----


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"translation": np.zeros((9, 2))}, r"expected translation \(F, 3\) and rotations \(F, 2, 4\), found \(9, 2\)"),
        ({"translation": np.zeros((8, 3))}, r"found \(8, 3\) and \(9, 2, 4\)"),
        ({"rotations": rot.identity(9, 3)}, r"found \(9, 3\) and \(9, 3, 4\)"),
        ({"bones": np.zeros((9, 1, 3))}, r"expected bones \(9, 2, 3\), found \(9, 1, 3\)"),
        ({"bones": np.full((9, 2, 3), np.nan)}, "bones must be finite; look for NaN or inf in its source"),
        ({"translation": np.full((9, 3), np.inf)}, "values must be finite; look for NaN or inf in its source"),
        ({"rotations": np.full((9, 2, 4), np.nan)}, "values must be finite"),
    ],
)
def test_shapes_and_values(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(DataError, match=message):
        dataclasses.replace(_steady(), **changes)


def test_a_motion_has_a_frame() -> None:
    with pytest.raises(DataError, match="a motion needs at least one frame, found none"):
        Motion(_BONES, np.zeros((0, 3)), np.zeros((0, 2, 4)), 30.0)


def test_a_rotation_off_unit_length_is_located() -> None:
    rotations = rot.identity(4, 2)
    rotations[2, 1] *= 1.01
    message = "rotations must be unit quaternions, found length 1.01 at frame 2, joint 'tip'; normalize them first"
    with pytest.raises(DataError, match=message):
        Motion(_BONES, np.zeros((4, 3)), rotations, 30.0)
    rotations[2, 1] /= 1.0095  # the rounding of a file is let through
    Motion(_BONES, np.zeros((4, 3)), rotations, 30.0)


def test_the_walker_has_all_its_joints() -> None:
    assert len(walk(1.0).skeleton) == len(stick_figure()) == 15
