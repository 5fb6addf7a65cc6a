from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.errors import DataError, RequestError
from kinetograph.motion import Motion
from kinetograph.sensing import (
    PRESETS,
    Device,
    Layout,
    Readings,
    Sensor,
    attach,
    channels,
    check_units,
    keep_sensors,
    preset,
    renumbered,
    select_sensors,
    simulate,
    specific_force,
)
from kinetograph.sensing.device import measure
from kinetograph.skeleton import Skeleton
from walkers import walk

ROD = Skeleton(("rod",), np.array([-1]), np.zeros((1, 3)))


def rod(rate: float, axis: str = "y", fps: float = 120.0, seconds: float = 2.0) -> Motion:
    """A rod about the origin that rotates at ``rate`` rad/s."""
    times = np.arange(round(fps * seconds) + 1) / fps
    return Motion(ROD, np.zeros((len(times), 3)), rot.about(axis, rate * times)[:, None], fps)


def on_rod(at: tuple[float, float, float], **more: object) -> Layout:
    return Layout("rod", (Sensor("tip", "rod", offset=np.array(at)),), Device(width=0.02, **more))  # type: ignore[arg-type]


def test_a_sensor_at_rest_reads_gravity_upwards():
    force = specific_force(rod(0.0), on_rod((0.5, 0, 0)))
    np.testing.assert_allclose(force[:, 0], np.broadcast_to([0, 9.81, 0], force[:, 0].shape), atol=1e-9)


def test_a_sensor_at_rest_on_its_side_reads_gravity_along_its_own_axis():
    mounted = Layout("rod", (Sensor("tip", "rod", rotation=rot.about("z", np.pi / 2)),))
    np.testing.assert_allclose(specific_force(rod(0.0), mounted)[5, 0], [9.81, 0, 0], atol=1e-9)


@pytest.mark.parametrize("rate", [1.0, 5.0])
def test_a_sensor_on_a_rotating_rod_has_the_centripetal_acceleration(rate):
    force = specific_force(rod(rate), on_rod((0.7, 0, 0)))[10:-10, 0]
    np.testing.assert_allclose(force, np.broadcast_to([-(rate**2) * 0.7, 9.81, 0], force.shape), rtol=0.002, atol=0.02)


def test_an_upright_rotating_rod_reads_gravity_and_rotation_in_its_own_frame():
    rate = 3.0
    motion = rod(rate, axis="z")
    angle = rate * np.arange(len(motion)) / motion.fps
    expected = np.stack([9.81 * np.sin(angle) - rate**2 * 0.4, 9.81 * np.cos(angle), 0 * angle], axis=1)
    np.testing.assert_allclose(specific_force(motion, on_rod((0.4, 0, 0)))[10:-10, 0], expected[10:-10], atol=0.02)


def test_a_falling_sensor_reads_nothing():
    times = np.arange(121) / 120.0
    fall = np.stack([0 * times, -0.5 * 9.81 * times**2, 0 * times], axis=1)
    motion = Motion(ROD, fall, rot.identity(len(times), 1), 120.0)
    np.testing.assert_allclose(specific_force(motion, on_rod((0, 0, 0)))[:, 0], 0.0, atol=1e-6)


def test_the_window_is_in_seconds_whatever_the_frame_rate():
    slow, fast = (specific_force(rod(4.0, fps=fps), on_rod((0.5, 0, 0)))[:: int(fps / 60), 0] for fps in (60.0, 240.0))
    np.testing.assert_allclose(slow[5:-5], fast[5:-5], atol=0.05)


def test_a_gyroscope_reads_the_rate_of_the_rod():
    readings = simulate(rod(2.5, axis="z"), on_rod((0.5, 0, 0)), angular=True)
    assert readings.angular is not None
    np.testing.assert_allclose(readings.angular, np.broadcast_to([0, 0, 2.5], readings.angular.shape), atol=1e-6)


def test_tilt_is_up_in_the_sensors_frame_whatever_the_heading():
    tipped = rod(0.0)
    rotation = rot.multiply(rot.about("y", 1.1), rot.about("z", 0.5))
    still = replace(tipped, rotations=np.broadcast_to(rotation, tipped.rotations.shape).copy())
    values = channels(simulate(still, on_rod((0, 0, 0)), tilt=True), ("force", "tilt"))
    up = np.array([np.sin(0.5), np.cos(0.5), 0.0])
    np.testing.assert_allclose(values[:, 3:], np.broadcast_to(up, (len(values), 3)), atol=1e-9)
    np.testing.assert_allclose(values[:, :3], 9.81 * values[:, 3:], atol=1e-6)


def test_a_noisy_gyroscope_and_compass_are_as_noisy_as_the_device_says():
    layout = on_rod((0.5, 0, 0), turn_noise=0.1, tilt_noise=0.05)
    readings = simulate(rod(1.0, seconds=20.0), layout, np.random.default_rng(0), angular=True, tilt=True)
    assert readings.angular is not None
    assert (readings.angular - [0, 1.0, 0]).std() == pytest.approx(0.1, rel=0.05)
    assert channels(readings, ("tilt",))[:, [0, 2]].std() == pytest.approx(0.05, rel=0.05)


@given(st.floats(-200, 200), st.integers(4, 16))
def test_a_device_clips_and_rounds_to_its_steps(value, bits):
    device = Device(span=30.0, bits=bits)
    got = float(measure(device, np.array([value]), np.random.default_rng(0))[0])
    step = 60.0 / 2**bits
    assert abs(got / step - round(got / step)) < 1e-9
    assert -30.0 <= got <= 30.0 - step + 1e-9
    if abs(value) < 30.0 - step:
        assert abs(got - value) <= step / 2 + 1e-9


def test_a_wii_remote_clips_a_swing_at_three_g():
    fast = rod(20.0)
    layout = Layout("rod", (Sensor("tip", "rod", offset=np.array([0.7, 0, 0])),), preset("wii").device)
    assert np.abs(simulate(fast, layout).force).max() <= 3 * 9.81 + 1e-9
    assert np.abs(specific_force(fast, layout)).max() > 200


def test_packets_are_lost_clocks_are_ahead_and_times_increase():
    motion = rod(1.0, seconds=10.0)
    layout = on_rod((0.5, 0, 0), loss=0.3, offset=0.25, jitter=0.003, rate=100.0)
    readings = simulate(motion, layout, np.random.default_rng(3))
    assert 0.6 < len(readings) / 1000 < 0.8
    assert readings.times.min() >= 0.25
    assert np.all(np.diff(readings.times) > 0)


@pytest.mark.parametrize("name", list(PRESETS))
def test_every_preset_fits_a_body_with_roles(name):
    layout = preset(name)
    wanted = [s for s in layout.sensors if s.place in walk(0.5).skeleton.roles]
    joints, offsets, rotations = attach(replace(layout, sensors=tuple(wanted)), walk(0.5).skeleton)
    assert len(joints) == len(offsets) == len(rotations) == len(wanted)


def test_the_thesis_has_eight_sensors():
    limbs = {f"{side}_{limb}" for side in ("left", "right") for limb in ("forearm", "upper_arm", "shank", "thigh")}
    assert set(preset("wii").names) == limbs


def test_unknown_names_are_refused_with_what_there_is():
    with pytest.raises(RequestError, match=r"no layout 'wiii'; expected a .toml file or one of ideal, wii"):
        preset("wiii")
    with pytest.raises(RequestError, match=r"unknown sensor 'left_forarm'.*did you mean left_forearm"):
        keep_sensors(preset("wii"), ("left_forarm",))
    with pytest.raises(RequestError, match="sensor 'tail': the skeleton has no joint or role 'tail_tip'; it has hips"):
        attach(Layout("cat", (Sensor("tail", "tail_tip"),)), walk(0.5).skeleton)
    with pytest.raises(RequestError, match="'left_hand' does not hang on 'right_elbow'"):
        attach(Layout("x", (Sensor("a", "right_elbow", "left_hand", 0.5),)), walk(0.5).skeleton)


def test_devices_that_cannot_be_are_refused():
    with pytest.raises(RequestError, match="loss is a share of packets from 0 up to 1, found 1"):
        Device(loss=1.0)
    with pytest.raises(RequestError, match="bits must be 1 to 32 and need a finite span"):
        Device(bits=8)
    with pytest.raises(RequestError, match="rate must be positive, found 0"):
        Device(rate=0.0)


def rows(times, force, names=("a",), sensors=None):
    return Readings(names, np.array(times), np.array(sensors or [0] * len(times)), np.array(force))


def test_bad_rows_are_refused_with_sensor_and_time():
    up = [0.0, 9.8, 0.0]
    with pytest.raises(DataError, match=r"sensor 'a': time runs backwards at 0.1 s \(after 0.2 s\)"):
        rows([0.2, 0.1], [up, up])
    with pytest.raises(DataError, match=r"sensor 'a': two rows for the time 0.1 s"):
        rows([0.1, 0.1], [up, up])
    with pytest.raises(DataError, match=r"sensor 'a' at 0.2 s: force must be finite"):
        rows([0.1, 0.2], [up, [np.nan, 0, 0]])
    with pytest.raises(DataError, match="sensor numbers must be 0 to 0, found 1"):
        rows([0.1], [up], sensors=[1])


def test_angular_velocities_and_orientations_that_cannot_be_are_refused():
    readings = simulate(walk(2.0), preset("ideal"), angular=True, tilt=True)
    check_units(readings)
    with pytest.raises(RequestError, match=r"expected angular velocity in rad/s, .*degrees per second. divide by 57.3"):
        check_units(replace(readings, angular=np.degrees(readings.angular)))
    assert readings.orientation is not None
    zeros = readings.orientation.copy()
    zeros[5] = 0.0
    with pytest.raises(DataError, match=r"orientation must be a quaternion, not zero; leave such rows out"):
        replace(readings, orientation=zeros)


def test_sensors_may_interleave_in_any_order():
    readings = rows([0.0, 0.1, 0.05], [[0, 1, 0], [0, 2, 0], [0, 3, 0]], ("a", "b"), [0, 0, 1])
    assert readings.times.tolist() == [0.0, 0.05, 0.1]
    assert select_sensors(readings, ("b",)).force.tolist() == [[0, 3, 0]]


def test_sensors_are_renumbered_among_more():
    readings = renumbered(rows([0.0, 0.1], [[0, 1, 0], [0, 2, 0]], ("b",)), ("a", "b"))
    assert (readings.names, readings.sensors.tolist()) == (("a", "b"), [1, 1])
    with pytest.raises(RequestError, match="unknown sensor 'b'; expected some of a, c"):
        renumbered(readings, ("a", "c"))
    with pytest.raises(DataError, match="force must be finite"):  # what is made of it is checked again
        replace(readings, force=np.full((2, 3), np.nan))


@pytest.mark.parametrize(
    ("scale", "hint"), [(1 / 9.81, "is it in g"), (102.0, "counts or milli-g"), (0.03, "has gravity been taken out")]
)
def test_units_that_cannot_be_specific_force_are_refused(scale, hint):
    readings = simulate(walk(2.0), preset("ideal"))
    check_units(readings)
    with pytest.raises(RequestError, match=f"about 9.8 at rest.*{hint}"):
        check_units(replace(readings, force=readings.force * scale))
