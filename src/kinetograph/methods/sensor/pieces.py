"""Where the frames of a synthesis came from, and what a person should know about it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinetograph.methods.sensor.examples import Examples
from kinetograph.synthesis import Piece


def pieces_of(examples: Examples, frames: list[int]) -> tuple[Piece, ...]:
    """Runs of the nearest examples, one a frame of the result, that follow one another in a take."""
    pieces = []
    start = 0
    for i in range(1, len(frames) + 1):
        if i < len(frames) and 0 <= frames[i] - frames[i - 1] <= 2 and _take(examples, frames[i]) == _take(
            examples, frames[i - 1]
        ):  # fmt: skip
            continue
        take = _take(examples, frames[start])
        begin = int(examples.starts[take])
        first, last = frames[start] - begin, frames[i - 1] - begin
        name, track = examples.takes[take]
        rate = examples.fps
        # a run that stands still in its recording lasts one frame of it
        stop = max(last + 1, first + 1)
        pieces.append(Piece(name, track, first / rate, stop / rate, start / rate, i / rate))
        start = i
    return tuple(pieces)


def _take(examples: Examples, frame: int) -> int:
    return int(np.searchsorted(examples.starts, frame, side="right")) - 1


def warnings_of(
    statistics: Mapping[str, float], names: tuple[str, ...], heard: set[str], rate: float
) -> tuple[str, ...]:
    """One line each: silent sensors, too few of them, gaps, and readings unlike any in the library."""
    lines = []
    silent = [name for name in names if name not in heard]
    if silent:
        lines.append(f"no readings from {', '.join(silent)}: left out of account")
    if len(heard) == 1:
        lines.append(f"one sensor, {min(heard)}, tells little of the rest of the body: poses are guesses")
    if statistics["held"] > 0:
        lines.append(f"no readings at all for {statistics['held']:.2f} s: the pose was held, with growing uncertainty")
    elif statistics["missing"] > 0.05 and not silent:
        lines.append(f"{statistics['missing']:.0%} of the readings were missing for longer than the gap allowed")
    if statistics["far"] > 0.2:
        lines.append(
            f"{statistics['far']:.0%} of the frames read unlike anything in the library; add recordings of such "
            "movement, or calibrate the sensors"
        )
    return tuple(lines)
