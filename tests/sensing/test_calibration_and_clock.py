from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.sensing import (
    Layout,
    Readings,
    calibrate,
    calibrate_on_library,
    calibrate_on_motion,
    clock_offset,
    mounted,
    preset,
    simulate,
)
from kinetograph.sensing.rotation_fit import wahba
from walkers import walk


def swings(seed: int = 0, frames: int = 600) -> np.ndarray:
    """Specific force of a limb that swings: gravity rotating to and fro, and some acceleration."""
    rng = np.random.default_rng(seed)
    rotation = rot.exp(gaussian_filter1d(rng.normal(size=(frames, 3)), 15, axis=0) * 4)
    return rot.rotate(rotation, np.array([0, 9.81, 0])) + gaussian_filter1d(rng.normal(size=(frames, 3)), 4, axis=0) * 5


@given(st.integers(0, 10_000))
def test_wahba_recovers_a_rotation_exactly(seed):
    rng = np.random.default_rng(seed)
    rotation = rot.exp(rng.normal(size=3))
    vectors = rng.normal(size=(12, 3))
    assert rot.angle_between(wahba(vectors, rot.rotate(rotation, vectors)), rotation) < 1e-7


def test_wahba_never_mirrors():
    mirrored = np.eye(3) * [1.0, 1.0, -1.0]
    assert np.linalg.det(rot.to_matrix(wahba(np.eye(3), mirrored))) == pytest.approx(1.0)


@given(st.integers(0, 1000))
def test_calibration_recovers_rotation_and_offset(seed):
    rng = np.random.default_rng(seed)
    truth = swings(seed % 7)
    mount, offset = rot.exp(rng.normal(size=3)), rng.uniform(-0.4, 0.4, 3)
    measured = rot.rotate(rot.conjugate(mount), truth) + offset + rng.normal(scale=0.05, size=truth.shape)
    calibration = calibrate(("a",), measured[:, None], truth[:, None])
    assert calibration.accepted.all()
    assert np.degrees(rot.angle_between(calibration.rotations[0], mount)) < 0.5
    np.testing.assert_allclose(calibration.offsets[0], offset, atol=0.05)
    assert calibration.residuals[0] < 0.2 < calibration.before[0]
    raw = Readings(("a",), np.arange(len(measured)) / 60, np.zeros(len(measured)), measured)
    np.testing.assert_allclose(calibration.apply(raw).force, truth, atol=0.5)


def test_a_calibration_that_is_worse_than_none_is_refused():
    truth = swings(1)
    measured = truth.copy()
    measured[:400] = rot.rotate(rot.about("z", 2.0), truth[:400])  # slipped, and put back for the last third
    calibration = calibrate(("a",), measured[:, None], truth[:, None])
    assert not calibration.accepted[0]
    assert calibration.rotations[0].tolist() == [1, 0, 0, 0]


def test_a_still_pose_alone_cannot_calibrate():
    still = np.broadcast_to([0.0, 9.81, 0.0], (100, 1, 3))
    with pytest.raises(RequestError, match="sensor 'a': the readings point one way throughout"):
        calibrate(("a",), still, still)
    with pytest.raises(RequestError, match="needs 30 valid frames or more, found 10"):
        calibrate(("a",), still[:10], still[:10])


LIBRARY = [walk(6.0, speed=0.9), walk(6.0, speed=1.2, turn_rate=0.6), walk(6.0, speed=1.4, period=0.85)]


def misworn(seed: int, bias: float = 0.0) -> tuple[Layout, np.ndarray]:
    """The eight sensors, each rotated on its bone at random, and the rotations."""
    rng = np.random.default_rng(seed)
    layout = preset("wii")
    mounts = rot.exp(rng.normal(size=(8, 3)))
    sensors = [
        replace(s, rotation=m, bias=rng.uniform(-bias, bias, 3)) for s, m in zip(layout.sensors, mounts, strict=True)
    ]
    return replace(layout, sensors=tuple(sensors)), mounts


def stand_then(motion: Motion, seconds: float) -> Motion:
    """The motion after its first frame's root has stood for a while, arms and legs hanging."""
    count = round(seconds * motion.fps)
    still = np.repeat(motion.translation[:1], count, axis=0)
    return replace(
        motion,
        translation=np.concatenate([still, motion.translation]),
        rotations=np.concatenate([rot.identity(count, len(motion.skeleton)), motion.rotations]),
    )


def test_a_recorded_motion_gives_mounts_and_clock_offset():
    worn, mounts = misworn(0, bias=0.3)
    motion = walk(8.0, speed=1.1, turn_rate=0.3 * np.sin(np.arange(241) / 40))
    readings = simulate(motion, replace(worn, device=replace(worn.device, offset=0.137)), np.random.default_rng(1))
    calibration, clock = calibrate_on_motion(readings, preset("wii"), motion)
    assert clock.seconds == pytest.approx(0.137, abs=0.005)
    assert np.degrees(rot.angle_between(calibration.rotations, mounts)).max() < 3.0
    # a straight swing, which rotates little, hardly separates a sideways offset from a slight tilt
    np.testing.assert_allclose(calibration.offsets, [s.bias for s in worn.sensors], atol=0.2)
    back = mounted(preset("wii"), calibration)
    apart = [rot.angle_between(a.rotation, b.rotation) for a, b in zip(back.sensors, worn.sensors, strict=True)]
    assert np.degrees(apart).max() < 3.0
    assert np.degrees(calibration.apart).max() < 5.0


def test_standing_still_and_moving_freely_give_mounts():
    worn, mounts = misworn(1)
    motion = stand_then(walk(8.0, speed=1.1, turn_rate=0.3), 2.0)
    readings = simulate(motion, worn, np.random.default_rng(1))
    calibration = calibrate_on_library(readings, preset("wii"), LIBRARY, still=(0.2, 1.8))
    assert calibration.accepted.all()
    assert np.degrees(rot.angle_between(calibration.rotations, mounts)).mean() < 8.0
    assert np.degrees(rot.angle_between(calibration.rotations, mounts)).max() < 20.0
    assert (calibration.residuals < 0.5 * calibration.before).all()


def test_movement_that_the_library_does_not_have_is_no_calibration():
    worn, _ = misworn(2)
    rng = np.random.default_rng(0)
    wild = walk(6.0)
    rotations = rot.exp(gaussian_filter1d(rng.normal(size=(*wild.rotations.shape[:2], 3)), 8, axis=0) * 6)
    readings = simulate(replace(wild, rotations=rotations), worn)
    calibration = calibrate_on_library(readings, preset("wii"), LIBRARY)
    assert calibration.accepted.sum() <= 2


def test_a_wearer_who_does_not_stand_still_is_refused():
    readings = simulate(walk(4.0), misworn(1)[0])
    with pytest.raises(RequestError, match=r"moved between 1 and 3 s .*arms hanging"):
        calibrate_on_library(readings, preset("wii"), LIBRARY, still=(1.0, 3.0))
    with pytest.raises(RequestError, match=r"expected readings between 8 and 9 s, found 0; they last until 4.0 s"):
        calibrate_on_library(readings, preset("wii"), LIBRARY, still=(8.0, 9.0))


def test_another_motion_is_not_taken_for_the_one_performed():
    rng = np.random.default_rng(0)
    wild = walk(6.0)
    rotations = rot.exp(gaussian_filter1d(rng.normal(size=(*wild.rotations.shape[:2], 3)), 8, axis=0) * 6)
    readings = simulate(replace(wild, rotations=rotations), preset("wii"))
    with pytest.raises(RequestError, match=r"agree at no clock offset .*give the motion that was performed"):
        calibrate_on_motion(readings, preset("wii"), walk(6.0))


@given(st.floats(-0.2, 0.2))
def test_a_clock_offset_is_found_to_a_fraction_of_a_frame(shift):
    times = np.arange(0, 12, 0.01)

    def wave(t):
        return np.sin(5 * t) + np.sin(11.3 * t + 1) + 0.5 * np.sin(23 * t)

    offset = clock_offset(wave(times - shift), wave(times), 100.0, 0.25)
    assert offset.seconds == pytest.approx(shift, abs=0.002)
    assert offset.correlation > 0.99


def test_clocks_need_signals_that_are_long_enough_and_vary():
    with pytest.raises(RequestError, match=r"expected 1.6 s of both signals or more, found 0.5"):
        clock_offset(np.zeros(50), np.zeros(50), 100.0)
    with pytest.raises(RequestError, match="do not vary together at any offset"):
        clock_offset(np.ones(500), np.ones(500), 100.0)
