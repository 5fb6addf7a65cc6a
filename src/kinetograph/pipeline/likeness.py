"""What of a library is like an example: spans of its recordings that a request asks for, or rules out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.formats import ReadOptions
from kinetograph.library import Library
from kinetograph.methods.performance import RecordedSpan
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion
from kinetograph.pipeline.finding import RATE, ExampleIndex, Group, distances_from, example_in, index_of

SHARE = 0.5
"""The share of the median distance of a library's windows within which they are like an example."""


def spans_like(
    text: str,
    library: Library,
    within: float | None = None,
    *,
    mirrored: bool = False,
    options: ReadOptions | None = None,
) -> tuple[RecordedSpan, ...]:
    """The spans of a library's recordings that are like an example, itself among them.

    Parameters
    ----------
    text : str
        The example, as `example_in` reads it.
    library : Library
    within : float, optional
        Metres, as distances of `find_alike`; half the median of all windows of the library unless given.
    mirrored : bool
        Whether recordings with left and right exchanged are looked through as well.
    options : ReadOptions, optional
        For a motion file.

    Returns
    -------
    tuple of RecordedSpan

    Raises
    ------
    RequestError
        For an example that is none, and where nothing is like it, with what comes nearest.
    """
    example, _ = example_in(text, library, options)
    index = index_of(library)
    found = [*distances_from(index, example)]
    near = _threshold(found) if within is None else within
    if not (np.isfinite(near) and near > 0):
        raise RequestError(f"like {text}: what is like an example is within more than 0 m of it, found {near:g}")
    spans = [*_spans(index, example, near, False)]
    if mirrored:
        spans += _spans(index, mirror(example), near, True)
    if not spans:
        raise RequestError(f"nothing in the library is within {near:.2f} m of {text}; {_nearest(found)}")
    return tuple(spans)


_Distances = tuple[Group, FloatArray, int]


def _threshold(found: list[_Distances]) -> float:
    distances = [each[np.isfinite(each)] for _, each, _ in found]
    every = np.concatenate(distances) if distances else np.zeros(0)
    return SHARE * float(np.median(every)) if len(every) else float("nan")


def _spans(index: ExampleIndex, example: Motion, within: float, mirrored: bool) -> Iterator[RecordedSpan]:
    """The unions of near windows, by motion."""
    for group, distances, width in distances_from(index, example):
        for i, (take, track) in enumerate(group.tracks):
            first, last = group.windows.offsets[i : i + 2]
            for start, stop in _covered(distances[first:last] <= within, width):
                yield RecordedSpan(take, track, start / RATE, stop / RATE, mirrored)


def _covered(near: BoolArray, width: int) -> Iterator[tuple[int, int]]:
    """The first and the last row of each span that windows cover which begin where it is near."""
    starts = np.flatnonzero(near)
    if len(starts) == 0:
        return
    for run in np.split(starts, np.flatnonzero(np.diff(starts) >= width) + 1):
        yield int(run[0]), int(run[-1]) + width - 1


def _nearest(found: list[_Distances]) -> str:
    """What comes nearest, for messages."""
    best = min(found, key=lambda each: float(each[1].min()), default=None)
    if best is None or not np.isfinite(best[1]).any():
        return "it has nothing as long, with the same parts of a body"
    group, distances, width = best
    row = int(np.argmin(distances))
    motion = int(np.searchsorted(group.windows.offsets, row, side="right")) - 1
    start = (row - int(group.windows.offsets[motion])) / RATE
    stop = start + (width - 1) / RATE
    least = float(distances[row])
    return (
        f"the nearest is {group.tracks[motion][0]} from {start:.1f} to {stop:.1f} s, {least:.2f} m: ask for what is "
        f"within {np.ceil(100 * least) / 100:.2f} m"
    )
