"""Cuts at labels and at fixed lengths."""

from __future__ import annotations

import numpy as np

from kinetograph.segmentation.uncut import UncutError
from kinetograph.take import Take


def cuts_by_length(take: Take, track: str, length: float) -> tuple[float, ...]:
    """Cuts at equal distances from the start of a track; a shorter rest is left over.

    Parameters
    ----------
    take : Take
    track : str
    length : float
        Seconds between cuts.

    Returns
    -------
    tuple of float
        Seconds.

    Raises
    ------
    UncutError
        If the track is shorter than one length.
    """
    duration = take.tracks[track].duration
    if not (np.isfinite(length) and 0 < length <= duration):
        message = f"take {take.name!r} lasts {duration:.2f} s, found a segment length of {length} s"
        raise UncutError(message, "shorter than a segment")
    return tuple(float(t) for t in np.arange(int(duration / length + 1e-9) + 1) * length)


def cuts_at_labels(take: Take, track: str, kind: str) -> tuple[float, ...]:
    """Cuts where annotations of one kind start or stop.

    Parameters
    ----------
    take : Take
    track, kind : str

    Returns
    -------
    tuple of float
        Seconds.

    Raises
    ------
    UncutError
        If the track has no such annotation; the message names the kinds there are.
    """
    times = {t for note in take.annotated(track, kind) for t in (note.start, note.stop)}
    if not times:
        kinds = ", ".join(sorted({note.kind for note in take.annotations})) or "none"
        message = f"take {take.name!r} has no annotations of kind {kind!r} on {track!r}; its kinds: {kinds}"
        raise UncutError(message, f"no annotations of kind {kind!r}")
    return tuple(sorted(times))
