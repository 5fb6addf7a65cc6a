"""Where excerpts are cut, by brute force, and how far the least time between two keys is looked for."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinetograph.errors import RequestError, TooSoonError
from kinetograph.methods.keyframe import cluster_motion, key_goals
from kinetograph.methods.keyframe.motion_segments import Excerpt


def _naive(x: np.ndarray, y: np.ndarray, a: Excerpt, b: Excerpt, reach: int) -> float:
    """The least distance of a frame at which ``a`` may be left and one at which ``b`` may be entered."""
    last = len(x) - 1
    left = [i for i in range(len(x)) if a.stop - reach <= i <= a.stop + reach and i > a.start] or [last]
    right = [j for j in range(len(y)) if b.start - reach <= j <= b.start + reach and j < b.stop] or [b.stop - 1]
    return min(float(((x[i] - y[j]) ** 2).sum()) for i, j in itertools.product(left, right))


@pytest.mark.parametrize("seed", range(30))
def test_neighbours_are_cut_at_the_closest_pair_of_frames_in_reach(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(12, 3)), rng.normal(size=(9, 3))
    start, other = int(rng.integers(0, 12)), int(rng.integers(0, 9))
    a = Excerpt(0, start, int(rng.integers(start + 1, 13)))
    b = Excerpt(1, other, int(rng.integers(other + 1, 10)))
    reach = int(rng.integers(0, 5))
    model: Any = SimpleNamespace(coordinates=[x, y])
    left, entered = cluster_motion._closest(model, a, b, reach)
    assert min(a.start + 1, len(x) - 1) <= left <= min(a.stop + reach, len(x) - 1)
    assert max(b.start - reach, 0) <= entered <= min(b.start + reach, b.stop - 1)
    assert float(((x[left] - y[entered]) ** 2).sum()) == pytest.approx(_naive(x, y, a, b, reach))


def test_an_excerpt_that_begins_at_the_last_frame_is_left_there() -> None:
    model: Any = SimpleNamespace(coordinates=[np.zeros((5, 1)), np.zeros((5, 1))])
    assert cluster_motion._closest(model, Excerpt(0, 4, 5), Excerpt(1, 1, 4), 2)[0] == 4


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
