"""Paths of 20 seconds with three keys at times: how long they take once the library is fitted.

``python -m benchmarks.keys_on_paths LIBRARY WALKS [--mirror] [--count 7] [--seed 77]``

The paths are stretches of the walks of WALKS, the keys what `kinetograph evaluate request` asks for of LIBRARY, at 4,
10 and 16 s. For one processor, put ``taskset -c 0`` before it.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.evaluation.along_paths import hips_path, moments_in
from kinetograph.keys import key_at
from kinetograph.methods.together import Asked, AskedKey, performed

SECONDS, TIMES = 20.0, (4.0, 10.0, 16.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library")
    parser.add_argument("walks")
    parser.add_argument("--mirror", action="store_true")
    parser.add_argument("--count", type=int, default=7)
    parser.add_argument("--seed", type=int, default=77)
    asked = parser.parse_args()
    library, walks = kg.Library.open(asked.library), kg.Library.open(asked.walks)
    model = kg.PerformanceControl(mirror=asked.mirror).fit(library)
    rng, moments = np.random.default_rng(asked.seed), moments_in(library)
    long = [m for m in (walks.take(name).motion() for name in walks.names()) if m.duration > SECONDS]
    spent = []
    while len(spent) < asked.count:
        motion = long[int(rng.integers(len(long)))]
        path = hips_path(motion, float(rng.uniform(0.0, motion.duration - SECONDS)), SECONDS)
        shown = [moments[int(rng.integers(len(moments)))] for _ in TIMES]
        keys = tuple(
            AskedKey(key_at(library.take(each.take).motion(), each.second, time=(second, second)))
            for each, second in zip(shown, TIMES, strict=True)
        )
        began = time.process_time()
        try:
            performed(model, path, Asked(keys))
        except RequestError as error:
            print(f"refused: {error}")
            continue
        spent.append(time.process_time() - began)
    states = len(model.fitted.instances.states)
    print(
        f"{states} states: {statistics.median(spent):.2f} s of processor time in the median, "
        f"{min(spent):.2f} to {max(spent):.2f}"
    )


if __name__ == "__main__":
    main()
