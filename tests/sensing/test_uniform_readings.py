from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import naive_sensor
from kinetograph.errors import DataError, RequestError
from kinetograph.sensing import LiveUniform, Readings, Resampling, select_rows, uniform


def stream(times, values, names=("a",), sensors=None):
    sensors = np.zeros(len(times), dtype=int) if sensors is None else sensors
    return Readings(names, times, sensors, np.stack([values, 0 * values, 0 * values], axis=1))


def noisy(seed: int = 0, seconds: float = 3.0, sensors: int = 2, loss: float = 0.2) -> Readings:
    rng = np.random.default_rng(seed)
    parts = []
    for s in range(sensors):
        times = np.arange(0, seconds, 1 / (80 + 30 * s)) + rng.uniform(0, 0.002)
        times = times[rng.uniform(size=len(times)) > loss]
        parts.append((times, np.full(len(times), s), rng.normal(size=(len(times), 3)) + np.array([0, 9.8, 0])))
    times, which, force = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Readings(tuple(f"s{s}" for s in range(sensors)), times, which, force)


def test_a_straight_line_comes_back_as_it_was_at_any_rate():
    rng = np.random.default_rng(1)
    times = np.sort(rng.uniform(0, 2, 160))
    signal = uniform(stream(times, 3.0 * times - 1.0), 50.0)
    inside = signal.valid[:, 0]
    at = np.arange(len(signal)) / 50.0
    inside[:2] = inside[-2:] = False
    assert inside.mean() > 0.9
    np.testing.assert_allclose(signal.values[inside, 0], (3.0 * at - 1.0)[inside], atol=1e-9)


def test_each_value_is_the_local_least_squares_line():
    readings = noisy(sensors=1, loss=0.0)
    how = Resampling(smooth=0.04)
    signal = uniform(readings, 30.0, resampling=how)
    at = 1.0
    low = np.searchsorted(readings.times, at - how.smooth)
    high = np.searchsorted(readings.times, at + how.smooth, side="right")
    part = slice(low, high)
    expected = naive_sensor.line_fit(readings.times[part], readings.force[part, 1], at, 0.04 * 1.05)
    assert signal.values[30, 1] == pytest.approx(expected, abs=1e-9)


def test_gaps_are_missing_and_only_they():
    times = np.concatenate([np.arange(0, 1, 0.01), np.arange(1.5, 2.5, 0.01)])
    signal = uniform(stream(times, np.sin(times)), 100.0)
    at = np.arange(len(signal)) / 100.0
    assert not signal.valid[(at > 1.05) & (at < 1.45)].any()
    assert signal.valid[(at < 0.99) | ((at > 1.51) & (at < 2.48))].all()


def test_a_spike_is_replaced_and_a_steep_slope_kept():
    times = np.arange(0, 2, 0.01)
    smooth = 15 * np.sin(6 * times)
    spiked = smooth.copy()
    spiked[100] += 200.0
    clean = uniform(stream(times, smooth), 100.0)
    repaired = uniform(stream(times, spiked), 100.0)
    np.testing.assert_allclose(repaired.values[:, 0], clean.values[:, 0], atol=0.6)


@given(st.integers(0, 1000), st.lists(st.floats(0.05, 2.95), max_size=8))
def test_live_is_offline_however_rows_are_divided(seed, cuts):
    readings = noisy(seed)
    whole = uniform(readings, 60.0)
    live = LiveUniform(2, 60.0)
    values, valid = [], []
    edges = [0.0, *sorted(cuts), 10.0]
    for low, high in itertools.pairwise(edges):
        live.add(select_rows(readings, (readings.times >= low) & (readings.times < high)))
        ready = live.ready()
        values.append(ready[0])
        valid.append(ready[1])
    rest = live.rest(readings.duration)
    got = np.concatenate([*values, rest[0]]).reshape(len(whole), -1)
    mask = np.concatenate([*valid, rest[1]])
    np.testing.assert_array_equal(np.repeat(mask, 3, axis=1), whole.valid)
    np.testing.assert_allclose(np.where(np.repeat(mask, 3, axis=1), got, 0.0), whole.values, atol=1e-12)


def test_a_silent_sensor_is_waited_for_no_longer_than_patience():
    readings = noisy(sensors=2, loss=0.0)
    live = LiveUniform(2, 60.0)
    live.add(select_rows(readings, (readings.sensors == 0) | (readings.times < 1.0)))
    _, valid = live.ready()
    assert len(valid) / 60.0 == pytest.approx(readings.duration - 0.12, abs=0.05)
    assert valid[:, 0].all()
    assert not valid[80:, 1].any()


def test_what_cannot_be_sampled_is_refused():
    empty = Readings(("a",), np.zeros(0), np.zeros(0), np.zeros((0, 3)))
    with pytest.raises(DataError, match="expected readings, found no rows"):
        uniform(empty, 60.0)
    with pytest.raises(RequestError, match="expected 0 < smooth, gap <= patience"):
        Resampling(gap=1.0)
    live = LiveUniform(1, 60.0)
    live.add(stream(np.array([0.5]), np.array([1.0])))
    with pytest.raises(DataError, match=r"sensor 'a': time runs backwards at 0.4 s \(after 0.5 s\)"):
        live.add(stream(np.array([0.4]), np.array([1.0])))
