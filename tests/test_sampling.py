"""Samples between samples: against numpy's interpolation, column by column."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.sampling import bracket, interpolate, sample_times, spline

_POSITIONS = st.lists(st.floats(-2.0, 12.0), min_size=1, max_size=8)


@given(_POSITIONS, st.integers(1, 10))
def test_neighbours_lie_on_either_side_of_a_position(positions: list[float], count: int) -> None:
    lower, upper, share = bracket(positions, count)
    held = np.clip(positions, 0, count - 1)
    assert lower.min() >= 0
    assert upper.max() <= count - 1
    assert set((upper - lower).tolist()) == ({1} if count > 1 else {0})
    assert share.min() >= 0
    assert share.max() <= 1
    np.testing.assert_allclose(lower + share, held, atol=1e-12)


@given(_POSITIONS, st.integers(1, 10), st.integers(0, 2**32 - 1))
def test_interpolation_agrees_with_numpys_on_every_column(positions: list[float], count: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(count, 2, 3))
    between = interpolate(values, positions)
    assert between.shape == (len(positions), 2, 3)
    for i, j in np.ndindex(2, 3):
        expected = np.interp(positions, np.arange(count), values[:, i, j])
        np.testing.assert_allclose(between[:, i, j], expected, atol=1e-12)


def test_samples_are_met_exactly() -> None:
    values = np.random.default_rng(0).normal(size=(7, 3))
    np.testing.assert_array_equal(interpolate(values, np.arange(7)), values)
    np.testing.assert_array_equal(interpolate(values, [-5.0, 99.0]), values[[0, -1]])


@given(st.integers(0, 500), st.sampled_from([24.0, 25.0, 29.97, 30.0, 59.94, 60.0, 120.0]))
def test_times_of_a_rate_come_back_from_their_duration(last: int, fps: float) -> None:
    times = sample_times(last / fps, fps)
    assert len(times) == last + 1
    np.testing.assert_allclose(times * fps, np.arange(last + 1), atol=1e-9)


@pytest.mark.parametrize(("duration", "count"), [(0.0, 1), (0.09, 1), (0.1, 2), (0.99, 10), (1.0, 11)])
def test_times_go_no_further_than_the_duration(duration: float, count: int) -> None:
    np.testing.assert_allclose(sample_times(duration, 10.0), np.arange(count) / 10)


# ---- splines ----


def test_a_spline_goes_through_its_samples_and_is_held_beyond_them() -> None:
    values = np.random.default_rng(0).normal(size=(50, 3, 2))
    np.testing.assert_array_equal(spline(values, np.arange(50)), values)
    near = spline(values, np.arange(50) + 1e-9)
    np.testing.assert_allclose(near, values, atol=1e-6)
    np.testing.assert_allclose(spline(values, [-3.0, 60.0, 0.5])[:2], values[[0, -1]], atol=1e-12)


def test_a_spline_agrees_with_another_library() -> None:
    from scipy.interpolate import CubicSpline

    values = np.cumsum(np.random.default_rng(1).normal(size=(80, 4)), axis=0)
    at = np.random.default_rng(2).uniform(0, 79, 200)
    np.testing.assert_allclose(spline(values, at), CubicSpline(np.arange(80), values, bc_type="natural")(at), atol=1e-9)


def test_a_part_of_a_spline_is_that_of_the_whole() -> None:
    values = np.cumsum(np.random.default_rng(3).normal(size=(400, 2)), axis=0)
    at = np.linspace(180.2, 190.7, 31)
    np.testing.assert_allclose(spline(values, at), spline(values, np.append(at, [0.5, 398.5]))[:31], atol=1e-9)


def test_a_spline_has_no_kinks_where_straight_lines_have() -> None:
    wave = np.sin(0.7 * np.arange(60.0))
    at = np.arange(10, 50, 0.25)
    smooth, lines = (np.abs(np.diff(f(wave, at), n=3)).max() for f in (spline, interpolate))
    assert smooth < 0.2 * lines
