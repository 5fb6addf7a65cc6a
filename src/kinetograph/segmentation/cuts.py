"""Cuts at labels and at fixed lengths."""

from __future__ import annotations

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.take import Take


def cuts_by_length(take: Take, track: str, length: float) -> tuple[float, ...]:
    """Seconds of cuts ``length`` seconds apart, from the start of the track; a shorter rest is left over.

    Raises RequestError unless the track holds at least one such length.
    """
    duration = take.tracks[track].duration
    if not (np.isfinite(length) and 0 < length <= duration):
        raise RequestError(f"take {take.name!r} lasts {duration:.2f} s, found a segment length of {length} s")
    return tuple(float(t) for t in np.arange(int(duration / length + 1e-9) + 1) * length)


def cuts_at_labels(take: Take, track: str, kind: str) -> tuple[float, ...]:
    """Seconds at which annotations of one kind start or stop. Raises RequestError where there are none."""
    times = {t for note in take.annotated(track, kind) for t in (note.start, note.stop)}
    if not times:
        kinds = ", ".join(sorted({note.kind for note in take.annotations})) or "none"
        raise RequestError(f"take {take.name!r} has no annotations of kind {kind!r} on {track!r}; its kinds: {kinds}")
    return tuple(sorted(times))
