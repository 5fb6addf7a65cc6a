"""Running extremes and spline weights are those of SciPy, which they do not load."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d, spline_filter1d

from kinetograph.filters import running_max, running_min, smoothed
from kinetograph.sampling import REACH, spline_weights


@given(st.integers(0, 2**32 - 1), st.integers(1, 90), st.integers(0, 60))
def test_running_extremes_are_scipys(seed: int, count: int, half: int) -> None:
    values = np.random.default_rng(seed).normal(size=count)
    assert np.array_equal(running_max(values, 2 * half + 1), maximum_filter1d(values, 2 * half + 1, mode="nearest"))
    assert np.array_equal(running_min(values, 2 * half + 1), minimum_filter1d(values, 2 * half + 1, mode="nearest"))
    fine = values > 0.5
    around = [fine[max(i - half, 0) : i + half + 1].any() for i in range(count)]
    assert running_max(fine, 2 * half + 1).tolist() == around


def test_smoothing_is_scipys() -> None:
    values = np.random.default_rng(2).normal(size=(40, 3))
    expected = gaussian_filter1d(values, 2.5, axis=0, mode="nearest", truncate=3.0)
    assert np.array_equal(smoothed(values, 2.5, axis=0, truncate=3.0), expected)


@pytest.mark.parametrize("count", [2, 3, 5, 33, 400])
def test_spline_weights_are_scipys(count: int) -> None:
    values = np.random.default_rng(count).normal(size=(count, 4))
    padded = np.pad(values, [(REACH, REACH), (0, 0)], mode="reflect", reflect_type="odd")
    expected = spline_filter1d(padded, order=3, axis=0, mode="mirror")[REACH - 1 : REACH + count + 1]
    assert spline_weights(values) == pytest.approx(expected, abs=1e-13)


def test_keyframe_control_and_what_follows_it_are_imported_without_much_of_scipy() -> None:
    code = "import sys, kinetograph.post, kinetograph.pipeline.inbetweening; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "kinetograph.methods.keyframe.timed_search" in loaded
    assert not {"scipy.ndimage", "scipy.spatial", "scipy.special", "scipy.interpolate"} & set(loaded)
