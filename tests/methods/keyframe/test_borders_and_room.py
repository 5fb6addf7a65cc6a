"""Where excerpts are cut, by brute force, and how far the least time between two keys is looked for."""

from __future__ import annotations

import itertools
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinetograph.errors import RequestError, TooSoonError
from kinetograph.methods.keyframe import cluster_motion, key_goals
from kinetograph.methods.keyframe.motion_segments import Excerpt


def _naive(x: np.ndarray, y: np.ndarray, a: Excerpt, b: Excerpt, reach: int, half: int) -> float:
    """The least distance of a frame at which ``a`` may be left and one at which ``b`` may be entered."""
    last, away = len(x) - 1, half if a.keys else 0
    earliest = max([a.start, *a.keys]) + away + 1
    latest = max(min(b.keys) - half, 0) if b.keys else b.stop - 1
    left = [i for i in range(len(x)) if a.stop - reach <= i <= a.stop + reach and i >= earliest]
    right = [j for j in range(len(y)) if b.start - reach <= j <= b.start + reach and j <= latest]
    left = left or [last if earliest <= a.stop + reach else min(earliest, last)]
    right = right or [latest]
    return min(float(((x[i] - y[j]) ** 2).sum()) for i, j in itertools.product(left, right))


@pytest.mark.parametrize("seed", range(60))
def test_neighbours_are_cut_at_the_closest_pair_of_frames_in_reach(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(12, 3)), rng.normal(size=(9, 3))
    start, other = int(rng.integers(0, 12)), int(rng.integers(0, 9))
    a = Excerpt(0, start, int(rng.integers(start + 1, 13)), (start,) if seed % 2 else ())
    stop = int(rng.integers(other + 1, 10))
    b = Excerpt(1, other, stop, (stop - 1,) if seed % 3 else ())
    reach, half = int(rng.integers(0, 5)), int(rng.integers(0, 3))
    model: Any = SimpleNamespace(coordinates=[x, y])
    left, entered = cluster_motion._closest(model, a, b, reach, half)
    assert left > max([a.start, *a.keys])
    assert entered <= min([b.stop - 1, *b.keys])
    gap = float(((x[min(left, len(x) - 1)] - y[entered]) ** 2).sum())
    assert gap == pytest.approx(_naive(x, y, a, b, reach, half))


def test_an_excerpt_that_begins_at_the_last_frame_plays_it() -> None:
    model: Any = SimpleNamespace(coordinates=[np.zeros((5, 1)), np.zeros((5, 1))])
    assert cluster_motion._closest(model, Excerpt(0, 4, 5), Excerpt(1, 1, 4), 2, 2)[0] == 5


@pytest.mark.parametrize("seed", range(60))
def test_blends_leave_the_frames_of_keys_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    excerpts, lengths = [], []
    for number in range(int(rng.integers(2, 6))):
        length = int(rng.integers(1, 40))
        start = int(rng.integers(0, length))
        stop = int(rng.integers(start + 1, length + 1))
        keys = (int(rng.integers(start, stop)),) if rng.random() < 0.4 or number == 0 else ()
        excerpts.append(Excerpt(number, start, stop, keys))
        lengths.append(length)
    excerpts[-1] = replace(excerpts[-1], keys=(excerpts[-1].stop - 1,))
    half = int(rng.integers(1, 6))
    blends = cluster_motion.overlaps(excerpts, lengths, half)
    seams = np.cumsum([len(excerpt) for excerpt in excerpts])[:-1]
    keys = cluster_motion.frames_of_keys(excerpts)
    blended = {f for s, (head, tail) in zip(seams, blends, strict=True) for f in range(s - head, s + tail)}
    assert not blended & set(keys)
    for number, (seam, (head, tail)) in enumerate(zip(seams, blends, strict=True)):
        assert 0 <= head <= len(excerpts[number])
        assert tail >= 0
        assert head + tail <= 2 * half
        room = min(seam - 1 - max([k for k in keys if k < seam], default=-1), len(excerpts[number]))
        after = blends[number + 1][1] if number + 1 < len(blends) else 0
        room += min(min(k for k in keys if k >= seam) - seam, len(excerpts[number + 1]) + after)
        assert head + tail >= min(half, room)  # a blend is short only where a key is near


def _asked(monkeypatch: pytest.MonkeyPatch, answers: list[float]) -> list[float]:
    """Have the least interval answered so; the room that it is asked for is in the list that comes back."""
    rooms: list[float] = []

    def least(graph: object, start: object, stop: object, most: float = np.inf) -> float:
        rooms.append(most)
        return answers[len(rooms) - 1]

    monkeypatch.setattr(key_goals, "least_interval", least)
    return rooms


def _require(latest: float, warp: float) -> None:
    index: Any = SimpleNamespace(graph=None, fps=10.0)
    keys: Any = (SimpleNamespace(label="one"), SimpleNamespace(label="two"))
    goals: Any = [SimpleNamespace(window=(0.0, 0.0)), SimpleNamespace(window=(5.0, latest))]
    key_goals.require_time(index, keys, goals, warp=warp, longest=100.0, meet=0.1)


def test_the_least_time_is_looked_for_within_what_a_squeezed_interval_may_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    rooms = _asked(monkeypatch, [38.0])
    _require(40.0, 0.1)
    assert rooms == pytest.approx([44.0])  # 40 steps, of an interval that is 10 % longer


def test_where_there_is_no_room_the_error_says_how_much_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    rooms = _asked(monkeypatch, [np.inf, 60.0])
    with pytest.raises(
        TooSoonError, match=r"5.40 s at least \(6.00 s of recordings, 10% faster\), and 4.00 s are given"
    ):
        _require(40.0, 0.1)
    assert rooms == pytest.approx([44.0, np.inf])
    _asked(monkeypatch, [np.inf, np.inf])
    with pytest.raises(RequestError, match="no recordings lead from one to two"):
        _require(40.0, 0.1)
