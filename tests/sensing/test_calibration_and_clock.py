from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.sensing import Readings, calibrate, clock_offset
from kinetograph.sensing.calibration import calibrate_freely, wahba


def swings(seed: int = 0, frames: int = 600) -> np.ndarray:
    """Specific force of a limb that swings: gravity turning to and fro, and some acceleration."""
    rng = np.random.default_rng(seed)
    turn = rot.exp(gaussian_filter1d(rng.normal(size=(frames, 3)), 15, axis=0) * 4)
    return rot.rotate(turn, np.array([0, 9.81, 0])) + gaussian_filter1d(rng.normal(size=(frames, 3)), 4, axis=0) * 5


@given(st.integers(0, 10_000))
def test_wahba_recovers_a_rotation_exactly(seed):
    rng = np.random.default_rng(seed)
    turn = rot.exp(rng.normal(size=3))
    vectors = rng.normal(size=(12, 3))
    assert rot.angle_between(wahba(vectors, rot.rotate(turn, vectors)), turn) < 1e-7


def test_wahba_never_mirrors():
    mirrored = np.eye(3) * [1.0, 1.0, -1.0]
    assert np.linalg.det(rot.to_matrix(wahba(np.eye(3), mirrored))) == pytest.approx(1.0)


@given(st.integers(0, 1000))
def test_calibration_recovers_rotation_and_offset(seed):
    rng = np.random.default_rng(seed)
    truth = swings(seed % 7)
    mount, offset = rot.exp(rng.normal(size=3)), rng.uniform(-0.4, 0.4, 3)
    measured = rot.rotate(rot.conjugate(mount), truth) + offset + rng.normal(scale=0.05, size=truth.shape)
    found = calibrate(("a",), measured[:, None], truth[:, None])
    assert found.accepted.all()
    assert np.degrees(rot.angle_between(found.rotations[0], mount)) < 0.5
    np.testing.assert_allclose(found.offsets[0], offset, atol=0.05)
    assert found.residuals[0] < 0.2 < found.before[0]
    raw = Readings(("a",), np.arange(len(measured)) / 60, np.zeros(len(measured)), measured)
    np.testing.assert_allclose(found.apply(raw).force, truth, atol=0.5)


def test_a_calibration_that_is_worse_than_none_is_refused():
    truth = swings(1)
    measured = truth.copy()
    measured[:400] = rot.rotate(rot.about("z", 2.0), truth[:400])  # slipped, and put back for the last third
    found = calibrate(("a",), measured[:, None], truth[:, None])
    assert not found.accepted[0]
    assert found.rotations[0].tolist() == [1, 0, 0, 0]


def test_a_still_pose_alone_cannot_calibrate():
    still = np.broadcast_to([0.0, 9.81, 0.0], (100, 1, 3))
    with pytest.raises(RequestError, match="sensor 'a': the readings point one way throughout"):
        calibrate(("a",), still, still)
    with pytest.raises(RequestError, match="needs 30 valid frames or more, found 10"):
        calibrate(("a",), still[:10], still[:10])


def test_free_movement_finds_how_a_sensor_is_mounted():
    rng = np.random.default_rng(3)
    times = np.arange(3000) / 60
    # a limb that swings forward and back, further forward: what tells front from side and from back
    angle = 0.6 * np.sin(3 * times) + 0.3 * np.sin(6 * times + 0.5) + 0.2
    library = rot.rotate(rot.about("x", angle), np.array([0, 9.81, 0])) + rng.normal(scale=0.3, size=(3000, 3))
    mount = rot.multiply(rot.about("y", 1.3), rot.about("x", 0.4))
    found = calibrate_freely(("a",), rot.rotate(rot.conjugate(mount), library[:1200])[:, None], library[:, None])
    assert np.degrees(rot.angle_between(found.rotations[0], mount)) < 8.0
    assert found.residuals[0] < 0.3 * found.before[0]


@given(st.floats(-0.2, 0.2))
def test_a_clock_offset_is_found_to_a_fraction_of_a_frame(shift):
    times = np.arange(0, 12, 0.01)

    def wave(t):
        return np.sin(5 * t) + np.sin(11.3 * t + 1) + 0.5 * np.sin(23 * t)

    found = clock_offset(wave(times - shift), wave(times), 100.0, 0.25)
    assert found.seconds == pytest.approx(shift, abs=0.002)
    assert found.correlation > 0.99


def test_clocks_need_signals_that_are_long_enough_and_vary():
    with pytest.raises(RequestError, match=r"expected 1.6 s of both signals or more, found 0.5"):
        clock_offset(np.zeros(50), np.zeros(50), 100.0)
    with pytest.raises(RequestError, match="do not vary together at any offset"):
        clock_offset(np.ones(500), np.ones(500), 100.0)
