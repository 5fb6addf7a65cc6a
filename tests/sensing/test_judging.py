"""How sensors are worn, in words, from calibrations that are made up and from readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.sensing import Calibration, calibrate, judged, preset, simulate, still_span, verdict_on
from walkers import walk


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


APART = np.full((4, 4), 3.0) - 2.0 * np.eye(4)
"""Each of four sensors reads like itself."""


@pytest.mark.parametrize(
    ("accepted", "rotated", "apart", "manner", "word", "passed"),
    [
        ([1, 1, 1, 1], 45, 2, "recorded", "good", 4),
        ([1, 1, 1, 1], 45, 20, "recorded", "fair", 4),
        ([1, 1, 1, 1], 45, 2, "stood", "fair", 4),
        ([1, 1, 0, 0], 45, 2, "recorded", "fair", 2),  # half of them
        ([1, 0, 0, 0], 45, 2, "recorded", "poor", 1),
        ([0, 0, 0, 0], 45, 2, "recorded", "poor", 0),
        ([1, 0, 0, 0], 5, 2, "recorded", "good", 4),  # the others are as their layout has them
        ([1, 0, 0, 0], 5, 60, "recorded", "poor", 1),  # which nobody knows where halves disagree
        ([1, 1, 1, 1], 45, 2, "moved", "fair", 4),
        ([1, 1, 1, 1], 45, 20, "moved", "poor", 0),
    ],
)
def test_a_calibration_is_worth_what_passes(accepted, rotated, apart, manner, word, passed):
    made = replace(
        calibration(APART.tolist(), apart),
        accepted=np.array(accepted, dtype=bool),
        rotated=np.full(4, np.radians(rotated)),
    )
    verdict = verdict_on(made, manner)
    assert (verdict.word, sum(verdict.passed)) == (word, passed)
    assert verdict.holds == (passed >= 2)
    assert f"calibration is {word}: {passed} of 4 sensors pass" in str(verdict)


def test_a_sensor_that_points_one_way_leaves_the_others_calibrated():
    measured = forces(3, seed=4)
    reference = measured.copy()
    reference[:, 1] = measured[:, 1] = [0.0, 9.81, 0.0]
    mount = rot.about("x", 0.7)
    found = calibrate(("a", "b", "c"), rot.rotate(rot.conjugate(mount), measured), reference)
    assert found.accepted.tolist() == [True, False, True]
    assert found.refused[0] == found.refused[2] == ""
    assert "point one way throughout" in found.refused[1]
    np.testing.assert_allclose(rot.angle_between(found.rotations[[0, 2]], mount), 0.0, atol=1e-6)
    assert found.rotated[[0, 2]] == pytest.approx(0.7)
    with pytest.raises(RequestError, match="sensor 'b': the readings point one way"):
        calibrate(("b",), measured[:, 1:2], reference[:, 1:2])


def test_seconds_of_standing_still_are_found():
    motion = walk(3.0)
    still = np.repeat(motion.rotations[:1], 60, axis=0)
    there = np.repeat(motion.translation[:1], 60, axis=0)
    stood = replace(
        motion,
        rotations=np.concatenate([motion.rotations, still]),
        translation=np.concatenate([motion.translation, there]),
    )
    first, last = still_span(simulate(stood, preset("wii")))
    assert first == pytest.approx(3.0, abs=0.2)
    assert last == pytest.approx(stood.duration, abs=0.1)
    assert still_span(simulate(motion, preset("wii"))) is None
    assert still_span(simulate(walk(0.5), preset("wii"))) is None
