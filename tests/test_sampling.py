"""Samples between samples: against numpy's interpolation, column by column."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.sampling import bracket, interpolate, sample_times

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
