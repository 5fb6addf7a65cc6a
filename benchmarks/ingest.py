"""What reading a corpus into a library takes, and that it survives being killed.

``python -m benchmarks.ingest FILES`` reads a folder of folders (``python -m benchmarks.varied FILES --files FILES``
makes one) and prints wall clock and processor time, without what other programs made it wait for a processor (Linux).
With ``--kills 100`` it reads the same again while it is killed at random moments, and compares the two libraries.
"""

from __future__ import annotations

import argparse
import os
import signal
import sqlite3
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph.library import Library
from kinetograph.pipeline import find_recordings, ingest, open_or_create


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", type=Path)
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--every", type=int, default=1, help="read every so many files only")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    recordings = find_recordings([asked.files]).recordings[:: asked.every]
    with tempfile.TemporaryDirectory() as folder:
        whole = Library.create(Path(folder) / "whole")
        ingest(Library.create(Path(folder) / "first"), recordings[:2])  # loads and compiles
        wall, work, waited = time.perf_counter(), time.process_time(), _waited()
        ingest(whole, recordings)
        wall, work, waited = time.perf_counter() - wall, time.process_time() - work, _waited() - waited
        info = whole.info()
        print(
            f"{info.takes} takes, {info.frames} frames: {wall:.1f} s, of which {waited:.1f} s waiting for a processor; "
            f"{work:.1f} s of processor time; wall clock without waiting / processor time {(wall - waited) / work:.2f}",
            flush=True,
        )
        if asked.kills:
            print(_killed(whole, recordings, asked.kills, np.random.default_rng(asked.seed)), flush=True)


def _waited() -> float:
    """Seconds that this thread was ready to run and others ran."""
    return int(Path("/proc/self/schedstat").read_text().split()[1]) / 1e9


def _killed(whole: Library, recordings: Any, kills: int, rng: np.random.Generator) -> str:
    folder, done, longest, progress = whole.path.with_name("killed"), 0, 0.3, 0
    stages = set()
    while done < kills:
        child = os.fork()
        if child == 0:
            try:
                ingest(open_or_create(folder), recordings)
            finally:
                os._exit(0)
        time.sleep(float(rng.uniform(0.0, longest)))
        os.kill(child, signal.SIGKILL)
        if os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != -signal.SIGKILL:
            return f"read to its end after {done} kills: {_compared(whole, open_or_create(folder))}"
        done += 1
        here = len(open_or_create(folder).names())
        longest *= 1.1 if here == progress else 0.8
        progress = here
        stages.add(here)
    library = open_or_create(folder)
    damaged = library.check().damaged
    ingest(library, recordings)
    return (
        f"{done} kills, {len(stages)} states on the way, the last of {progress} takes, damaged then: {list(damaged)}; "
        f"{_compared(whole, library)}"
    )


def _compared(whole: Library, library: Library) -> str:
    same = _rows(whole) == _rows(library)
    return f"the same library at the end: {same}; sound after a repair: {_sound(library)}"


def _sound(library: Library) -> bool:
    library.check(repair=True)
    return library.check().sound


def _rows(library: Library) -> list[Any]:
    """Takes and the digests of all that is theirs, frames included."""
    db = sqlite3.connect(library.path / "catalogue.sqlite")
    try:
        return db.execute("SELECT id, name, digest, notes FROM takes ORDER BY id").fetchall()
    finally:
        db.close()


if __name__ == "__main__":
    main()
