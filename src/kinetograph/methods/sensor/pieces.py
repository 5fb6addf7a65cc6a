"""Where the frames of a synthesis came from."""

from __future__ import annotations

import numpy as np

from kinetograph.methods.sensor.examples import Examples
from kinetograph.synthesis import Piece

FURTHEST = 2
"""Frames by which the nearest example may move on within one piece."""


def pieces_of(examples: Examples, frames: list[int]) -> tuple[Piece, ...]:
    """Runs of the nearest examples that follow one another in a take.

    Parameters
    ----------
    examples : Examples
    frames : list of int
        The nearest example of each frame of the result.

    Returns
    -------
    tuple of Piece
    """
    takes = np.searchsorted(examples.starts, frames, side="right") - 1
    pieces = []
    start = 0
    for i in range(1, len(frames) + 1):
        if i < len(frames) and 0 <= frames[i] - frames[i - 1] <= FURTHEST and takes[i] == takes[i - 1]:
            continue
        begin = int(examples.starts[takes[start]])
        first, last = frames[start] - begin, frames[i - 1] - begin
        name, track = examples.takes[takes[start]]
        rate = examples.fps
        # a run that stands still in its recording lasts one frame of it
        stop = max(last + 1, first + 1)
        pieces.append(Piece(name, track, first / rate, stop / rate, start / rate, i / rate))
        start = i
    return tuple(pieces)
