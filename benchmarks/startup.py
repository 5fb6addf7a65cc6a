"""How long the command line takes to answer."""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np


def main() -> None:
    times = []
    for _ in range(7):
        began = time.perf_counter()
        subprocess.run([sys.executable, "-m", "kinetograph", "--help"], check=True, capture_output=True)
        times.append(time.perf_counter() - began)
    print(f"kinetograph --help: {np.median(times):.2f} s")
