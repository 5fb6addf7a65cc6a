"""What a step of a stream costs as it goes on: time and memory after so many steps, ``python -m benchmarks endless``.

Prints, for each part of live control that looks back, microseconds a step and the bytes that it holds.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from kinetograph.learn import Arrivals, SegmentalSearch, segmental
from kinetograph.rows import KeptRows, LatestRows

STEPS = (2_000, 20_000, 200_000, 1_000_000)
_DURATIONS = np.array([2, 2, 3, 3, 4])


def main(steps: tuple[int, ...] = STEPS) -> None:
    for name, run in (("search, and a look ahead", _search), ("rows that are kept", _rows)):
        for count, micros, held in run(steps):
            print(f"{name:26s} {count:9,d} steps {micros:8.1f} us a step {held / 1000:10.1f} kB held")


def _measured(
    steps: tuple[int, ...], step: Callable[[int], None], held: Callable[[], int]
) -> Iterator[tuple[int, float, int]]:
    """Steps, microseconds of each of the last thousand, and bytes, at some numbers of steps."""
    began = 0.0
    for i in range(steps[-1]):
        if i + 1_000 in steps:
            began = time.thread_time()
        step(i)
        if i + 1 in steps:
            yield i + 1, 1e3 * (time.thread_time() - began), held()


def _search(steps: tuple[int, ...]) -> Iterator[tuple[int, float, int]]:
    rng, search = np.random.default_rng(0), SegmentalSearch(_DURATIONS, 0.5)
    ends = rng.normal(size=(64, 2, len(_DURATIONS), 8)).astype(np.float32)
    costs = rng.random((64, len(_DURATIONS)))
    made = [Arrivals(c, *e) for c, e in zip(costs, ends, strict=True)]
    state = segmental.init(search)

    def step(i: int) -> None:
        nonlocal state
        state = segmental.step(search, state, made[int(rng.integers(64))])
        ahead = segmental.copied(state)
        segmental.step(search, ahead, made[i % 64])

    return _measured(steps, step, lambda: state.back.nbytes)


def _rows(steps: tuple[int, ...]) -> Iterator[tuple[int, float, int]]:
    kept, latest, row = KeptRows((2, 3)), LatestRows(64), np.zeros((2, 3))

    def step(i: int) -> None:
        kept.add(row)
        latest.add(row)
        latest.branch().last(20)

    return _measured(steps, step, lambda: kept.nbytes + latest.since(0).nbytes)


if __name__ == "__main__":
    main()
