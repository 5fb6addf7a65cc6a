"""The phase of gaits whose phase was put in."""

from __future__ import annotations

import numpy as np
import pytest

from kinetograph.errors import RequestError
from kinetograph.evaluation.phase import (
    Phase,
    ankles_apart,
    cadence_ratio,
    foot_agreement,
    gait_phase,
    locking,
    phase_difference,
    plant_phase,
    slips,
)
from kinetograph.motion import Motion, cut
from walkers import walk

_FPS = 30.0


def _walk(late: float = 0.0, seconds: float = 20.0, period: float = 1.0) -> Motion:
    """A walk that is ``late`` seconds into its stride when it begins."""
    whole = walk(seconds + 2.0, speed=1.0, period=period)
    first = round(late * _FPS)
    return cut(whole, first, first + round(seconds * _FPS) + 1)


def _apart(angle: float) -> float:
    return abs(float(np.angle(np.exp(1j * angle))))


def test_the_phase_goes_round_once_a_stride() -> None:
    phase = gait_phase(_walk(period=1.25))
    turned = np.diff(np.unwrap(phase.angle))[60:-60]
    assert phase.walking.mean() > 0.98
    assert turned.mean() * _FPS == pytest.approx(2 * np.pi / 1.25, rel=0.01)


def test_the_left_foot_is_ahead_at_phase_0() -> None:
    motion = _walk()
    phase = gait_phase(motion)
    ahead = ankles_apart(motion)
    at = np.flatnonzero(np.diff(np.signbit(phase.angle)) & (np.abs(phase.angle[1:]) < 1.0))
    assert len(at) > 15
    np.testing.assert_allclose(ahead[at[1:-1]], ahead.max(), rtol=0.15)


def test_cadences_are_compared_by_strides() -> None:
    fast, slow = gait_phase(_walk()), gait_phase(_walk(period=1.25))
    assert cadence_ratio(fast, slow) == pytest.approx(1.25, rel=0.02)
    assert cadence_ratio(slow, slow) == 1.0
    still = gait_phase(walk(20.0, speed=0.0))
    assert np.isnan(cadence_ratio(fast, still))


def test_a_quarter_of_a_stride_is_a_quarter_of_a_cycle() -> None:
    for share, angle in ((0.25, np.pi / 2), (0.5, np.pi), (0.0, 0.0)):
        # 1.2 s, so that a share of a stride is a whole number of frames
        made, real = gait_phase(_walk(1.2 * share, period=1.2)), gait_phase(_walk(period=1.2))
        difference, both = phase_difference(made, real)
        inside = difference[60:-60][both[60:-60]]
        assert _apart(float(np.angle(np.exp(1j * inside).mean())) - angle) < 0.05


def test_footplants_give_the_same_phase() -> None:
    motion = _walk()
    plants, other = plant_phase(motion), gait_phase(motion).angle
    known = ~np.isnan(plants)
    assert known.mean() > 0.8
    vector = np.exp(1j * (plants - other)[known]).mean()
    assert abs(vector) > 0.97
    assert _apart(float(np.angle(vector))) < 0.5  # the foot is furthest ahead shortly before it stands


def test_who_stands_has_no_phase() -> None:
    still = walk(4.0, speed=0.0)
    assert not gait_phase(still).walking.any()
    with pytest.raises(RequestError, match="nobody walks"):
        locking(gait_phase(still), gait_phase(still), np.random.default_rng(0))
    with pytest.raises(RequestError, match=r"needs 2 s of motion or more, found 1\.0 s"):
        gait_phase(walk(1.0))
    with pytest.raises(RequestError, match="compared at one rate, found 30 and 60 Hz"):
        locking(gait_phase(still), gait_phase(walk(4.0, fps=60.0)), np.random.default_rng(0))


def _wandering(seed: int, seconds: float = 60.0) -> Phase:
    """A phase whose cadence wanders, of its own accord."""
    rng = np.random.default_rng(seed)
    frames = round(seconds * _FPS)
    cadence = 1.0 + 0.15 * np.cumsum(rng.normal(size=frames)) / np.sqrt(_FPS * 8)
    angle = np.cumsum(2 * np.pi * cadence / _FPS)
    return Phase(np.angle(np.exp(1j * angle)), np.ones(frames, dtype=np.bool_), _FPS)


def test_one_that_follows_is_beyond_chance_and_one_that_does_not_is_not() -> None:
    real = _wandering(0)
    noise = 0.3 * np.random.default_rng(1).normal(size=len(real.angle))
    follows = locking(Phase(real.angle + 0.2 + noise, real.walking, _FPS), real, np.random.default_rng(0))
    assert follows.agreement == pytest.approx(np.cos(0.2) * np.exp(-0.045), abs=0.02)
    assert follows.mean == pytest.approx(0.2, abs=0.02)
    assert follows.in_phase == 1.0
    assert follows.p < 0.01
    strangers = [locking(_wandering(i), real, np.random.default_rng(0)).p for i in range(1, 21)]
    assert sum(p < 0.05 for p in strangers) <= 4


def test_a_lucky_start_at_constant_cadence_is_not_beyond_chance() -> None:
    angle = np.angle(np.exp(2j * np.pi * np.arange(1800) / _FPS))
    steady = Phase(angle, np.ones(1800, dtype=np.bool_), _FPS)
    kept = locking(steady, steady, np.random.default_rng(0))
    assert kept.agreement == pytest.approx(1.0)
    assert kept.null_p95 > 0.95
    short = Phase(angle[:300], steady.walking[:300], _FPS)
    assert np.isnan(locking(short, short, np.random.default_rng(0)).p)


def test_slips_are_changes_of_foot() -> None:
    assert slips(np.zeros(50)) == 0
    assert slips(np.linspace(0.0, 2 * np.pi, 200) - np.pi) == 2  # other foot, right foot, other foot
    assert slips(0.5 * np.pi + 0.2 * np.sin(np.arange(100))) == 0  # in between is neither


def test_feet_that_swing_alike_agree() -> None:
    real = _walk(seconds=3.0)
    assert foot_agreement(real, real) == pytest.approx(1.0)
    assert foot_agreement(_walk(0.5, 3.0), real) == pytest.approx(-1.0, abs=0.02)
