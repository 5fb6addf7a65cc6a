"""Places to walk to, at random: how many are reached by motion that is no worse than recordings.

``python -m benchmarks.places LIBRARY [--count 27] [--seed 0]``

Both keys are frames of takes in which somebody walks. The place is 1.5 to 9 m from the first key, in any direction; its
time is free, a window, or given, at 1.1 m/s with time to turn; its heading is free, that of the way there, or any. The
first motion that is found counts; a request that a person makes is answered by better ones, or refused.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections import defaultdict

import numpy as np

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.keyframe import KeyframeControl
from kinetograph.methods.keyframe.timed_search import FittedTimedSearch
from kinetograph.motion import Motion, heading_at
from kinetograph.post import PostSettings

TIMES, HEADINGS = ("free", "window", "given"), ("free", "along", "any")


def walks(motion: Motion) -> bool:
    """Whether somebody walks in most of a motion."""
    speed = np.linalg.norm(np.diff(motion.translation[:, [0, 2]], axis=0), axis=1) * motion.fps
    return motion.duration > 3 and float((speed > 0.6).mean()) > 0.6 and float(np.median(speed)) < 1.8


def request(takes: list[Motion], times: str, headings: str, rng: np.random.Generator) -> tuple[Key, Key]:
    """Two keys, the second at a place."""
    one, other = (takes[i] for i in rng.integers(0, len(takes), 2))
    first = int(rng.integers(10, len(one) - 40))
    far, aside = rng.uniform(1.5, 9.0), rng.uniform(-np.pi, np.pi)
    way = heading_at(one, first) + aside
    x, _, z = one.translation[first]
    seconds = float(far / 1.1 + 1.0 + abs(aside) / 1.5)
    when = {"free": None, "window": (0.7 * seconds, 1.3 * seconds), "given": (round(seconds, 1), round(seconds, 1))}
    facing = {"free": None, "along": float(way), "any": float(rng.uniform(-np.pi, np.pi))}
    last = Key(
        other,
        int(rng.integers(10, len(other) - 10)),
        time=when[times],
        position=(float(x + far * np.sin(way)), float(z + far * np.cos(way))),
        heading=facing[headings],
        label="last",
    )
    return Key(one, first, label="first"), last


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library")
    parser.add_argument("--count", type=int, default=27)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    model = KeyframeControl().fit(kg.Library.open(options.library))
    search = model.fitted
    assert isinstance(search, FittedTimedSearch)
    takes = [example.motion for example in model.examples if walks(example.motion)]
    rng, rows, spent = np.random.default_rng(options.seed), defaultdict(list), []
    for _, (times, headings) in zip(
        range(options.count), itertools.cycle(itertools.product(TIMES, HEADINGS)), strict=False
    ):
        keys = request(takes, times, headings, rng)
        began = time.process_time()
        try:
            _, quality = next(search.motions(keys, PostSettings()))
            found, good = True, quality.good
        except RequestError:
            found = good = False
        spent.append(time.process_time() - began)
        for name in (f"time {times}", f"heading {headings}", "all"):
            rows[name].append((found, good))
    print(f"{len(model.examples)} takes, {len(takes)} of walking; processor time of a search: {np.median(spent):.1f} s")
    for name, each in sorted(rows.items()):
        found, good = (sum(column) for column in zip(*each, strict=True))
        print(f"{name:16s} found {found}, no worse than recorded {good} of {len(each)}")


if __name__ == "__main__":
    main()
