"""Takes: what was recorded at one time, and what is known about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from kinetograph.errors import DataError, RequestError
from kinetograph.motion import Motion
from kinetograph.signal import Signal

Track = Motion | Signal


@dataclass(frozen=True)
class Annotation:
    """A labelled interval of a track, in seconds from the take's start.

    kind: what sort of thing it is (``"cut"``, ``"contact"``, ``"handhold"``, ``"move"``, ``"loop"``). label: which one
    (``"left_toe"``, a move's name). A cut is an instant: ``start == stop``.
    """

    track: str
    kind: str
    label: str
    start: float
    stop: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", float(self.start))
        object.__setattr__(self, "stop", float(self.stop))
        if not (np.isfinite(self.start) and np.isfinite(self.stop) and 0 <= self.start <= self.stop):
            raise DataError(
                f"an annotation runs from 0 <= start to stop >= start seconds, found {self.start}, {self.stop}"
            )


@dataclass(frozen=True, eq=False)
class Take:
    """Synchronised named tracks of one recording and their annotations; every track starts at time 0."""

    name: str
    tracks: Mapping[str, Track]
    annotations: tuple[Annotation, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "tracks", MappingProxyType(dict(self.tracks)))
        object.__setattr__(self, "annotations", tuple(self.annotations))
        if not self.tracks:
            raise DataError(f"take {self.name!r} needs at least one track, found none")
        for note in self.annotations:
            if note.track not in self.tracks:
                raise DataError(
                    f"annotation on track {note.track!r}, but take {self.name!r} has {', '.join(self.tracks)}"
                )

    def __reduce__(self) -> tuple[Any, ...]:
        return Take, (self.name, dict(self.tracks), self.annotations)  # a read-only view of a dict does not pickle

    @property
    def duration(self) -> float:
        """Seconds of the longest track."""
        return max(track.duration for track in self.tracks.values())

    def motion(self, track: str | None = None) -> Motion:
        """The motion on ``track``, or the only motion. Raises RequestError, naming the motions there are."""
        motions = {name: t for name, t in self.tracks.items() if isinstance(t, Motion)}
        if track is None and len(motions) == 1:
            return next(iter(motions.values()))
        if track is None or track not in motions:
            found = ", ".join(motions) or "none"
            raise RequestError(f"take {self.name!r}: name one of its motions ({found}), found {track!r}")
        return motions[track]

    def named_motion(self, track: str | None = None) -> tuple[str, Motion]:
        """The name and the motion of ``track``, or of the only motion. Raises RequestError as `motion`."""
        motion = self.motion(track)
        return track or next(name for name, value in self.tracks.items() if value is motion), motion

    def signal(self, track: str | None = None) -> Signal:
        """The signal on ``track``, or the only signal. Raises RequestError, naming the signals there are."""
        signals = {name: t for name, t in self.tracks.items() if isinstance(t, Signal)}
        if track is None and len(signals) == 1:
            return next(iter(signals.values()))
        if track is None or track not in signals:
            found = ", ".join(signals) or "none"
            raise RequestError(f"take {self.name!r}: name one of its signals ({found}), found {track!r}")
        return signals[track]

    def annotated(self, track: str, kind: str) -> tuple[Annotation, ...]:
        """The annotations of one kind on one track, by start."""
        found = (note for note in self.annotations if note.track == track and note.kind == kind)
        return tuple(sorted(found, key=lambda note: (note.start, note.stop, note.label)))
