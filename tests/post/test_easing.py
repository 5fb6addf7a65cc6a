from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.post import smoothstep


@given(st.lists(st.floats(-3.0, 4.0), min_size=1, max_size=20))
def test_the_smooth_step_rises_and_is_symmetric(u: list[float]) -> None:
    at = np.sort(u)
    step = smoothstep(at)
    assert step.min() >= 0
    assert step.max() <= 1
    assert (np.diff(step) >= -1e-15).all()
    np.testing.assert_allclose(smoothstep(1 - at), 1 - step, atol=1e-12)


def test_the_smooth_step_is_level_at_both_ends() -> None:
    np.testing.assert_array_equal(smoothstep(np.array([-1.0, 0.0, 0.5, 1.0, 2.0])), [0, 0, 0.5, 1, 1])
    step = 1e-4
    low, high = smoothstep(np.array([step, 1 - step]))
    assert low < 4 * step**2
    assert 1 - high < 4 * step**2
    slopes = np.diff(smoothstep(np.linspace(0, 1, 1001))) * 1000
    assert abs(slopes.max() - 1.5) < 1e-3
