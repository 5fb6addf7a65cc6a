"""How sensors are worn, in words, from calibrations that are made up and from readings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from kinetograph import rotations as rot
from kinetograph.sensing import Calibration, calibrate, judged


def calibration(as_others: list[list[float]], apart: float = 0.0) -> Calibration:
    count = len(as_others)
    return Calibration(
        tuple("abcdefgh"[:count]),
        rot.identity(count),
        np.zeros((count, 3)),
        np.ones(count),
        np.ones(count),
        np.full(count, np.radians(apart)),
        np.ones(count, dtype=np.bool_),
        np.array(as_others),
    )


def forces(count: int, seed: int, frames: int = 900) -> np.ndarray:
    """Specific force of limbs that swing, each in its own way."""
    rng = np.random.default_rng(seed)
    rotation = rot.exp(gaussian_filter1d(rng.normal(size=(frames, count, 3)), 12, axis=0) * 4)
    return rot.rotate(rotation, np.array([0, 9.81, 0]))


@pytest.mark.parametrize(
    ("as_others", "apart", "words"),
    [
        ([[1, 3], [3, 1]], 0, ("good", "good")),
        ([[1, 3], [3, 1]], 40, ("fair", "fair")),
        ([[1, 1], [3, 1]], 0, ("fair", "good")),  # movement does not tell a from b
        ([[2, 1], [3, 1]], 0, ("put it on again", "good")),
        ([[2, 1, 5], [1.0, 0.95, 5], [5, 5, 1]], 0, ("put it on again", "put it on again", "good")),  # changed places
        ([[2]], 0, ("good",)),
    ],
)
def test_words_follow_from_whose_readings_a_sensor_s_are_like(as_others, apart, words) -> None:
    assert judged(calibration(as_others, apart)) == words


def test_two_that_have_changed_places_are_found_whatever_their_rotations() -> None:
    truth, rng = forces(4, 0), np.random.default_rng(1)
    noise = rng.normal(scale=1.5, size=truth.shape)
    worn = rot.rotate(rot.exp(rng.normal(size=(4, 3))), truth + noise)
    right = calibrate(("a", "b", "c", "d"), worn, truth)
    assert judged(right) == ("good",) * 4
    wrong = calibrate(("a", "b", "c", "d"), worn[:, [0, 2, 1, 3]], truth)
    assert judged(wrong) == ("good", "put it on again", "put it on again", "good")
    likeness, others = wrong.elsewhere
    assert others[1:3] == ("c", "b")
    assert likeness[1] > 1.5
    assert (right.elsewhere[0] < 0.7).all()
    # against the obvious: the error of the known rotation
    expected = np.sqrt((noise[:, 0] ** 2).sum(axis=1).mean())
    assert right.as_others[0, 0] == pytest.approx(expected, rel=0.02)
