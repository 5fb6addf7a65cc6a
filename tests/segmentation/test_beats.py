"""Beats of a walk whose steps are known, and the dynamic programme against every row of beats there is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.errors import RequestError
from kinetograph.motion import cut
from kinetograph.segmentation.beats import BeatSettings, detect_beats, subdivide, tempo, track_beats
from naive import best_beats
from walkers import walk


@pytest.mark.parametrize("period", [0.7, 0.85, 1.0])
def test_a_walk_has_a_beat_a_step(period: float) -> None:
    beats = np.array(detect_beats([walk(10.0, period=period)]))
    np.testing.assert_allclose(np.diff(beats), period / 2, atol=0.04)
    assert len(beats) >= 10.0 / (period / 2) - 4


def test_partners_have_their_beats_together() -> None:
    one, other = walk(8.0, period=0.9), walk(8.0, period=0.9, speed=0.7)
    np.testing.assert_allclose(detect_beats([one, other]), detect_beats([one]), atol=0.04)


@given(st.lists(st.floats(0, 3), min_size=6, max_size=12), st.floats(1.5, 4.0), st.floats(0.1, 20))
def test_beats_are_the_best_there_are(pulse: list[float], period: float, evenness: float) -> None:
    beats = track_beats(np.array(pulse), period, evenness)
    score, last = best_beats(np.array(pulse), period, evenness)
    gaps = np.diff(beats)
    total = np.array(pulse)[beats].sum() - evenness * (np.log(gaps / period) ** 2).sum()
    assert total == pytest.approx(score)
    assert beats[-1] >= last


def test_the_tempo_of_a_pulse_lies_between_frames() -> None:
    frames = np.arange(600)
    assert tempo(np.cos(2 * np.pi * frames / 21.4), 15, 36) == pytest.approx(21.4, abs=0.05)


def test_beats_are_divided_evenly() -> None:
    assert subdivide([0.0, 1.0, 3.0], 2) == (0.0, 0.5, 1.0, 2.0, 3.0)
    with pytest.raises(RequestError, match="divided into 1 part or more, found 0"):
        subdivide([0.0, 1.0], 0)


def test_motion_without_a_rhythm_to_find_says_so() -> None:
    with pytest.raises(RequestError, match=r"found 1\.0 s of motion; shorter than 2\.4 s, which beats need"):
        detect_beats([walk(1.0)])
    still = cut(walk(1.0), 0, 1)
    frozen = type(still)(still.skeleton, np.repeat(still.translation, 200, 0), np.repeat(still.rotations, 200, 0), 30.0)
    with pytest.raises(RequestError, match="no foot ever moves, so there is no beat"):
        detect_beats([frozen])
    with pytest.raises(RequestError, match="from a shorter to a longer time"):
        BeatSettings(period=(0.6, 0.3))
