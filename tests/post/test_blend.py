"""Seams of synthetic motion at a high rate, where a jump in position or velocity cannot hide."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import angular_velocities
from kinetograph.motion import Motion, cut, sample, transform
from kinetograph.post.blend import Clip, join, measure_gap, quintic_decay
from kinetograph.skeleton import Skeleton
from walkers import slide, walk

_FPS = 500.0
_POINT = Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))


def _source(velocity: tuple[float, float, float], spin: FloatArray, start: FloatArray, duration: float = 6.0) -> Motion:
    """A body that flies at a steady velocity and turns at a steady rate, with a little sway on top."""
    times = np.arange(round(duration * _FPS) + 1) / _FPS
    sway = 0.02 * np.sin(2 * np.pi * times)[:, None]
    rotations = rot.multiply(rot.exp(np.outer(times, spin)), rot.exp(start))
    return Motion(_POINT, np.outer(times, velocity) + sway, rotations[:, None], _FPS)


def _clip(motion: Motion, start: float, stop: float, *, shift: tuple[float, float, float] = (0, 0, 0)) -> Clip:
    return Clip(motion, rot.identity(), np.array(shift, dtype=np.float64), start, stop, 2.0, 1.0)


def _two(spin: FloatArray, start: FloatArray) -> list[Clip]:
    """A seam at 1 s with a gap of 0.3 m, of 1.5 m/s, and in the turn and its rate."""
    before = _source((1.0, 0.0, 0.0), np.array([0.0, 0.5, 0.0]), np.zeros(3))
    after = _source((0.0, 0.5, 1.0), spin, start)
    shift = tuple((before.translation[1500] - after.translation[1000] + [0.3, 0.0, 0.0]).tolist())
    return [_clip(before, 0.0, 1.0), _clip(after, 1.0, 2.0, shift=shift)]


def _about_y(a: float) -> FloatArray:
    return np.array([0.0, a, 0.0])


def _jumps(values: FloatArray, seam: int, fps: float = _FPS) -> tuple[float, float]:
    """What a row of samples jumps by at a seam, in value (beside going on evenly) and in velocity."""
    speed = np.diff(values, axis=0) * fps
    before, across, after = speed[seam - 2], speed[seam - 1], speed[seam]
    return float(np.linalg.norm(across - before) / fps), float(np.linalg.norm(after - before))


@pytest.fixture
def clips() -> list[Clip]:
    return _two(_about_y(-0.7), _about_y(1.4))


def test_the_gap_is_what_was_put_in(clips: list[Clip]) -> None:
    gap = measure_gap(*clips)
    np.testing.assert_allclose(gap.translation, [0.3, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(gap.velocity, [-1.0, 0.5, 1.0], atol=5e-3)
    np.testing.assert_allclose(gap.rotations, [_about_y(1.4 - 0.7 * 2 - 0.5 * 3)], atol=1e-9)
    np.testing.assert_allclose(gap.angular, [_about_y(-1.2)], atol=1e-9)


def test_the_gap_is_the_same_where_recordings_end_at_the_seam(clips: list[Clip]) -> None:
    before, after = clips
    ended = dataclasses.replace(before, motion=cut(before.motion, 0, 1501))
    begun = dataclasses.replace(after, motion=cut(after.motion, 1000, 3001), source_start=0.0)
    gap, whole = measure_gap(ended, begun), measure_gap(before, after)
    np.testing.assert_allclose(gap.translation, whole.translation, atol=1e-9)
    np.testing.assert_allclose(gap.velocity, whole.velocity, atol=5e-3)
    np.testing.assert_allclose(gap.angular, whole.angular, atol=1e-6)


def test_without_a_blend_frames_are_the_sources_own(clips: list[Clip]) -> None:
    motion = join(clips, _FPS, 1001, "none")
    placed = clips[1].motion.translation[1000:1501] + clips[1].shift
    np.testing.assert_allclose(motion.translation, [*clips[0].motion.translation[1000:1500], *placed], atol=1e-12)
    position, velocity = _jumps(motion.translation, 500)
    assert position == pytest.approx(0.3, abs=5e-3)
    assert velocity == pytest.approx(1.5, abs=5e-3)


def test_linear_makes_positions_meet_and_leaves_velocities(clips: list[Clip]) -> None:
    motion = join(clips, _FPS, 1001, "linear")
    position, velocity = _jumps(motion.translation, 500)
    assert position < 1e-4
    assert velocity > 1.0
    assert rot.angle_between(motion.rotations[499], motion.rotations[500]).max() < 0.01


def test_linear_is_a_straight_ramp_along_the_whole_piece(clips: list[Clip]) -> None:
    linear, plain = join(clips, _FPS, 1001, "linear"), join(clips, _FPS, 1001, "none")
    moved = (linear.translation - plain.translation)[:, 0]
    np.testing.assert_allclose(moved[:500], 0.15 * np.arange(500) / 500, atol=1e-9)
    np.testing.assert_allclose(moved[500:], -0.15 * (1 - np.arange(501) / 500), atol=1e-9)


def test_inertialised_makes_positions_and_velocities_meet(clips: list[Clip]) -> None:
    motion = join(clips, _FPS, 1001, "inertialised", 0.4)
    position, velocity = _jumps(motion.translation, 500)
    assert position < 1e-4
    assert velocity < 0.05
    assert rot.angle_between(motion.rotations[499], motion.rotations[500]).max() < 0.01
    spins = angular_velocities(motion.rotations, _FPS)[:, 0]
    assert np.linalg.norm(spins[502] - spins[497]) < 0.05


def test_the_velocity_at_the_seam_is_the_mean_of_both_sides(clips: list[Clip]) -> None:
    motion = join(clips, _FPS, 1001, "inertialised", 0.4)
    velocity = (motion.translation[501] - motion.translation[499]) * _FPS / 2
    sway = 0.02 * 2 * np.pi
    np.testing.assert_allclose(velocity, np.array([0.5, 0.25, 0.5]) + sway, atol=0.02)


def test_turns_about_unlike_axes_meet_as_well() -> None:
    clips = _two(np.array([0.5, -0.3, 0.4]), np.array([-0.8, 2.1, -0.6]))
    motion = join(clips, _FPS, 1001)
    assert rot.angle_between(motion.rotations[499], motion.rotations[500]).max() < 0.01
    spins = angular_velocities(motion.rotations, _FPS)[:, 0]
    jump = np.linalg.norm(measure_gap(*clips).angular)
    assert jump > 1.0
    assert np.linalg.norm(spins[502] - spins[497]) < 0.03 * jump


def test_a_seam_is_felt_for_its_duration_only(clips: list[Clip]) -> None:
    blended, plain = join(clips, _FPS, 1001, "inertialised", 0.2), join(clips, _FPS, 1001, "none")
    moved = np.linalg.norm(blended.translation - plain.translation, axis=1)
    assert moved[:401].max() < 1e-12
    assert moved[600:].max() < 1e-12
    assert moved[410:590].min() > 1e-5


@pytest.mark.parametrize("length", [0.1, 0.02])
@pytest.mark.parametrize(("blend", "meets"), [("inertialised", True), ("linear", False)])
def test_a_piece_shorter_than_the_blend_meets_both_its_neighbours(length: float, blend: str, meets: bool) -> None:
    first, last = _two(_about_y(0.0), _about_y(0.5))
    short = _clip(_source((-1.0, 0.2, 0.0), _about_y(2.0), _about_y(-4.0)), 1.0, 1.0 + length, shift=(0.9, 0.1, 0.2))
    last = dataclasses.replace(last, start=1.0 + length)
    fine = 20000.0  # within a frame of the source, to see the seam and not the bend beside it
    motion = join([first, short, last], fine, 24001, blend, 0.4)
    for time in (1.0, 1.0 + length):
        position, velocity = _jumps(motion.translation, round(time * fine), fine)
        assert position < 1e-5
        assert (velocity < 0.02) == meets


def test_a_single_clip_is_left_alone(clips: list[Clip]) -> None:
    motion = join(clips[:1], _FPS, 501)
    np.testing.assert_allclose(motion.translation, clips[0].motion.translation[1000:1501], atol=1e-12)


@pytest.mark.parametrize("blend", ["inertialised", "linear"])
def test_clips_that_meet_are_left_alone(blend: str) -> None:
    source = walk(6.0, fps=120.0, turn_rate=0.3)
    clips = [_clip(source, i * 0.5, i * 0.5 + 0.5) for i in range(4)]
    clips = [dataclasses.replace(c, source_start=1.0 + c.start) for c in clips]
    motion = join(clips, 120.0, 241, blend)
    expected = cut(source, 120, 361)
    np.testing.assert_allclose(motion.translation, expected.translation, atol=1e-9)
    assert rot.angle_between(motion.rotations, expected.rotations).max() < 1e-6


def test_a_clip_is_stretched_and_placed() -> None:
    source = walk(4.0)
    q, shift = rot.about("y", 0.8), np.array([1.0, 0.0, -2.0])
    clip = Clip(source, q, shift, start=0.5, stop=2.5, source_start=1.0, stretch=2.0)
    got = clip.at(np.array([0.5, 1.5, 2.5]), 30.0)
    expected = transform(sample(source, [1.0, 1.5, 2.0], 30.0), q, shift)
    np.testing.assert_allclose(got.translation, expected.translation)
    np.testing.assert_allclose(got.rotations, expected.rotations)


def test_bones_that_change_their_length_come_along() -> None:
    source = slide(walk(3.0), "left_hand", np.outer(np.arange(91), [0.0, 0.001, 0.0]))
    clips = [Clip(source, rot.identity(), np.zeros(3), t, t + 1.0, t, 1.0) for t in (0.0, 1.0)]
    motion = join(clips, 30.0, 61)
    assert motion.bones is not None
    assert source.bones is not None
    np.testing.assert_allclose(motion.bones, source.bones[:61], atol=1e-12)


def test_quaternions_do_not_flip_at_a_seam(clips: list[Clip]) -> None:
    flipped = dataclasses.replace(clips[1].motion, rotations=-clips[1].motion.rotations)
    motion = join([clips[0], dataclasses.replace(clips[1], motion=flipped)], _FPS, 1001)
    assert (np.sum(motion.rotations[1:] * motion.rotations[:-1], axis=-1) > 0).all()


def test_an_unknown_blend_is_named(clips: list[Clip]) -> None:
    with pytest.raises(RequestError, match="blend must be one of inertialised, linear, none, found 'cubic'"):
        join(clips, _FPS, 10, "cubic")


# ---- the quintics ----


def test_quintics_begin_and_end_as_promised() -> None:
    step = 1e-4
    for start, values in ((0.0, ((1, 0, 0), (0, 1, 0))), (1.0 - 4 * step, ((0, 0, 0), (0, 0, 0)))):
        u = start + step * np.arange(5)
        at = 0 if start == 0 else 4
        for curve, (value, slope, curvature) in zip(quintic_decay(u), values, strict=True):
            assert curve[at] == pytest.approx(value, abs=1e-12)
            edge = curve if at == 0 else curve[::-1]
            one_sided = (-25 * edge[0] + 48 * edge[1] - 36 * edge[2] + 16 * edge[3] - 3 * edge[4]) / (12 * step)
            assert one_sided * (1 if at == 0 else -1) == pytest.approx(slope, abs=1e-6)
            second = (2 * edge[0] - 5 * edge[1] + 4 * edge[2] - edge[3]) / step**2
            assert second == pytest.approx(curvature, abs=1e-3)


@given(st.floats(0.0, 1.0))
def test_quintics_stay_within_bounds(u: float) -> None:
    place, rate = quintic_decay(np.array([u]))
    assert -1e-12 <= place[0] <= 1 + 1e-12
    assert -1e-12 <= rate[0] <= 0.25
