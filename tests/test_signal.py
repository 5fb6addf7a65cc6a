from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.errors import DataError, RequestError
from kinetograph.signal import Signal, resample_signal


def _channels(frames: int = 5, fps: float = 10.0, valid: Any = ()) -> Signal:
    times = np.arange(frames) / fps
    return Signal(np.stack([times, 1 - 2 * times], axis=1), ("a", "b"), "m/s", fps, np.asarray(valid, dtype=bool))


def test_points_move_with_a_transform_and_channels_do_not() -> None:
    assert Signal(np.zeros((4, 2, 3)), ("l", "r"), "m", 30.0).spatial
    assert not _channels().spatial


def test_duration_is_from_first_to_last_frame() -> None:
    assert _channels().duration == pytest.approx(0.4)
    assert len(_channels()) == 5


def test_everything_is_valid_unless_said_otherwise() -> None:
    assert _channels().valid.shape == (5, 2)
    assert _channels().valid.all()


def test_a_missing_value_is_nought_whatever_stood_there() -> None:
    values = np.array([[[1.0, 2, 3]], [[np.nan, np.inf, 0]]])
    signal = Signal(values, ("p",), "m", 1.0, np.array([[True], [False]]))
    np.testing.assert_array_equal(signal.values, [[[1, 2, 3]], [[0, 0, 0]]])


@given(fps=st.floats(3.0, 60.0))
def test_resampling_lines_is_exact(fps: float) -> None:
    changed = resample_signal(_channels(), fps)
    times = np.arange(len(changed)) / fps
    np.testing.assert_allclose(changed.values, np.stack([times, 1 - 2 * times], axis=1), atol=1e-12)
    assert changed.fps == fps
    assert times[-1] <= 0.4 + 1e-9 < times[-1] + 1 / fps + 1e-6
    assert (changed.names, changed.units) == (("a", "b"), "m/s")


def test_resampling_points() -> None:
    points = Signal(np.arange(6.0).reshape(2, 1, 3), ("p",), "m", 1.0)
    np.testing.assert_allclose(resample_signal(points, 2.0).values[:, 0], [[0, 1, 2], [1.5, 2.5, 3.5], [3, 4, 5]])


def test_resampling_to_the_same_rate_changes_nothing() -> None:
    signal = _channels()
    assert resample_signal(signal, 10.0) is signal


def test_a_sample_is_valid_where_those_it_is_made_of_are() -> None:
    valid = np.ones((5, 2), dtype=np.bool_)
    valid[3, 0] = False
    up = resample_signal(_channels(valid=valid), 20.0)
    assert np.flatnonzero(~up.valid[:, 0]).tolist() == [5, 6, 7]
    assert up.valid[:, 1].all()
    down = resample_signal(_channels(valid=valid), 5.0)  # frames 0, 2, 4 are taken as they are
    assert down.valid.all()
    np.testing.assert_allclose(down.values[:, 0], [0.0, 0.2, 0.4])


def test_a_signal_of_one_frame() -> None:
    single = _channels(frames=1)
    assert single.duration == 0.0
    np.testing.assert_array_equal(resample_signal(single, 60.0).values, [[0, 1]])


@pytest.mark.parametrize("fps", [0.0, -1.0, np.nan, np.inf])
def test_a_rate_is_positive_and_finite(fps: float) -> None:
    with pytest.raises(DataError, match="fps must be a positive number, found"):
        _channels(fps=30.0).__class__(np.zeros((2, 1)), ("a",), "m", fps)
    with pytest.raises(RequestError, match="fps must be a positive number, found"):
        resample_signal(_channels(), fps)


@pytest.mark.parametrize(
    ("values", "names", "message"),
    [
        (np.zeros(4), ("a",), r"a signal is points \(F, P, 3\) or channels \(F, C\), found shape \(4,\)"),
        (np.zeros((4, 2, 2)), ("a", "b"), r"found shape \(4, 2, 2\)"),
        (np.zeros((0, 1)), ("a",), r"expected at least one frame of 1 named columns, found \(0, 1\)"),
        (np.zeros((3, 2)), ("a",), r"expected at least one frame of 1 named columns, found \(3, 2\)"),
        (np.full((3, 1), np.nan), ("a",), "a signal's valid values must be finite; mark missing ones in the mask"),
    ],
)
def test_invariants(values: Any, names: tuple[str, ...], message: str) -> None:
    with pytest.raises(DataError, match=message):
        Signal(values, names, "m", 30.0)


def test_the_mask_has_a_column_a_name() -> None:
    with pytest.raises(DataError, match=r"expected a validity mask \(5, 2\), found \(5, 1\)"):
        _channels(valid=np.ones((5, 1)))
