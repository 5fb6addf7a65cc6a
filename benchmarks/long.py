"""A control of two hours: ``python -m benchmarks long``. Prints time and memory over that of the fitted model."""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path

import numpy as np

import kinetograph as kg
from benchmarks._recordings import walker
from kinetograph.methods.performance import realize
from kinetograph.signal import Signal

HOURS = 2.0
FPS = 30.0


def winding(seconds: float) -> Signal:
    """A path that turns left and right for as long as is asked for."""
    t = np.arange(round(seconds * FPS) + 1) / FPS
    heading = np.cumsum(0.8 * np.sin(2 * np.pi * t / 13.7) + 0.5 * np.sin(2 * np.pi * t / 5.1 + 1)) / FPS
    speed = 1.0 + 0.2 * np.sin(2 * np.pi * t / 17)
    steps = np.stack([speed * np.sin(heading), 0 * t, speed * np.cos(heading)], axis=1) / FPS
    return Signal(np.cumsum(steps, axis=0)[:, None], ("path",), "m", FPS)


def main(hours: float = HOURS) -> None:
    model = walker()
    model.synthesize(winding(30.0))  # compiles
    base, began = _peak(), time.process_time()
    read = model.read(winding(3600.0 * hours))
    path = model.interpret(read)
    print(f"{hours:g} h, {len(model.fitted.instances.states)} states")
    print(f"interpreted {time.process_time() - began:6.0f} s {_peak() - base:+7.0f} MB")
    result = realize(model.fitted, read, path)
    size = (result.motion.rotations.nbytes + result.motion.translation.nbytes) / 1e6
    print(f"made        {time.process_time() - began:6.0f} s {_peak() - base:+7.0f} MB, of which the motion {size:.0f}")
    with tempfile.TemporaryDirectory() as folder:
        kg.save(result.motion, Path(folder) / "long.bvh")
    print(f"written     {time.process_time() - began:6.0f} s {_peak() - base:+7.0f} MB")


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
