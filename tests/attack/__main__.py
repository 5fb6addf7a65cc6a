"""Run the attack for some minutes, and print what came of it; the exit status is 1 where a fault was found."""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from tests.attack.parts import Tally, all_parts, run


def until(end: float, count: int | None) -> Iterator[int]:
    """0, 1, 2, ... until a time, or a number of them."""
    for number in itertools.count():
        if time.monotonic() > end or number == count:
            return
        yield number


def show(name: str, tally: Tally) -> None:
    per_second = tally.runs / max(tally.seconds, 1e-9)
    print(
        f"{name}: {tally.runs} attempts, {len(tally.faults)} faults, {per_second:.0f} a second, "
        f"slowest {tally.slowest:.2f} s"
    )
    for title, counts in (("what was done", tally.kinds), ("what came of it", tally.answers)):
        print(f"  {title}: " + ", ".join(f"{word} {count}" for word, count in counts.most_common()))
    for number, kind, fault in tally.faults[:20]:
        print(f"  fault: attempt {number} ({kind}): {fault.strip().splitlines()[-1]}")
    sys.stdout.flush()


def main() -> int:
    parts = all_parts()
    parser = argparse.ArgumentParser(prog="python -m tests.attack", description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0, help="for all parts together")
    parser.add_argument("--part", action="append", choices=sorted(parts), help="repeatable; default all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, help="attempts of each part, if the time is enough")
    parser.add_argument("--only", type=int, help="one attempt's number")
    parser.add_argument("--kept", type=Path, default=Path("build/attack"), help="folder for the inputs of faults")
    parser.add_argument("--folder", type=Path, help="folder to work in, such as /dev/shm; default the system's own")
    asked = parser.parse_args()
    names = asked.part or sorted(parts)
    faults = 0
    with tempfile.TemporaryDirectory(dir=asked.folder) as folder:
        for name in names:
            end = time.monotonic() + 60 * asked.minutes / len(names)
            numbers = iter([asked.only]) if asked.only is not None else until(end, asked.count)
            tally = run(parts[name], asked.seed, Path(folder), asked.kept, numbers)
            show(name, tally)
            faults += len(tally.faults)
    if faults:
        print(f"{faults} faults, kept in {asked.kept}; repeat one: --part NAME --seed {asked.seed} --only NUMBER")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
