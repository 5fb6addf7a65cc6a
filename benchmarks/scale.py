"""What a library of many hours would take in shards: unit costs measured on one library, and what follows from them.

``python -m benchmarks.scale LIBRARY`` reads and scores one library as a shard, and prints bytes, processor seconds and
messages per hour of recordings, then the totals for 10, 100, 1,000 and 10,000 hours and a control of a minute.
"""

from __future__ import annotations

import argparse
import pickle
import time
from pathlib import Path

import numpy as np

from kinetograph.library import Library, contents
from kinetograph.methods.performance import PerformanceControl
from kinetograph.methods.performance import shard as worker
from kinetograph.methods.performance.shard import Block, Shard

STEPS = 8
SECONDS = 60.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library", type=Path)
    library = Library.open(parser.parse_args().library)
    method = PerformanceControl()
    hours = sum(track.duration for track in contents(library)) / 3600
    skeleton = library.take(library.names()[0]).named_motion(None)[1].skeleton
    shard = Shard("scale", library, library.names(), method, None, skeleton)
    began = time.process_time()
    described = worker.describe(shard)
    read = time.process_time() - began
    states = worker.hold(shard)
    longest = int(states[:, 1].max())
    x = np.cumsum(np.full((STEPS, longest + 1, 2, 3), 0.1), axis=1)
    worker.score(Block(shard, x[:1], slice(None)))
    began = time.process_time()
    scored = worker.score(Block(shard, x, slice(None)))
    pairs = STEPS * len(states)
    nanoseconds = (time.process_time() - began) / pairs * 1e9
    sent = len(pickle.dumps(scored, 5)) / pairs
    told = len(pickle.dumps(described, 5)) / hours
    disk = sum(path.stat().st_size for path in library.path.iterdir() if path.is_file()) / hours
    per_hour = len(states) / hours
    print(f"{hours:.2f} h: {per_hour:,.0f} states, {disk / 1e6:.1f} MB on disk, {told / 1e6:.2f} MB told once an hour")
    print(f"read in {read / hours:.2f} s an hour; a state and step: {nanoseconds:.0f} ns, {sent:.0f} B sent")
    steps = SECONDS * method.rate
    print(f"{'hours':>7} {'states':>12} {'disk GB':>8} {'read h':>7} {'score h':>8} {'sent GB':>9} {'search GB':>9}")
    for total in (10, 100, 1_000, 10_000):
        count = per_hour * total
        ring = count * (longest + 1) * 130 + count * steps * 4
        row = (disk * total / 1e9, read / hours * total / 3600, nanoseconds * count * steps / 3.6e12)
        print(
            f"{total:>7,} {count:>12,.0f} {row[0]:>8.1f} {row[1]:>7.2f} {row[2]:>8.2f} "
            f"{sent * count * steps / 1e9:>9.1f} {ring / 1e9:>9.1f}"
        )


if __name__ == "__main__":
    main()
