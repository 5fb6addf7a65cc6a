"""Print every table, one after another: ``python -m benchmarks [NAME ...]``."""

from __future__ import annotations

import importlib
import os
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # figures are for one thread
os.environ.setdefault("OMP_NUM_THREADS", "1")

TABLES = (
    "search",
    "walks",
    "dance",
    "growing",
    "keyframe",
    "sensor",
    "bvh",
    "markers",
    "retarget",
    "rests",
    "startup",
    "quality",
    "steering",
)
ON_REQUEST = (
    "stream",
    "large",
    "live",
    "sessions",
    "studio",
    "endless",
    "long",
)  # 800 MB on disk; some minutes each; a browser


def main() -> None:
    names = sys.argv[1:] or TABLES
    unknown = [name for name in names if name not in TABLES + ON_REQUEST]
    if unknown:
        sys.exit(f"no benchmark {unknown[0]!r}; there are {', '.join(TABLES + ON_REQUEST)}")
    for name in names:
        began = time.perf_counter()
        print(f"\n== {name}")
        importlib.import_module(f"benchmarks.{name}").main()
        print(f"   ({time.perf_counter() - began:.0f} s)")


main()
