"""Takes: what was recorded at one time, and its annotations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from kinetograph.display import notebook_html
from kinetograph.errors import DataError, RequestError
from kinetograph.motion import Motion
from kinetograph.readings import Readings
from kinetograph.signal import Signal

_T = TypeVar("_T", Motion, Signal, Readings)
Track = Motion | Signal | Readings
"""What a take holds under a name."""


@dataclass(frozen=True)
class Annotation:
    """A labelled interval of a track.

    Parameters
    ----------
    track : str
    kind : str
        ``"cut"``, ``"contact"``, ``"handhold"``, ``"move"``, ``"loop"`` or another word.
    label : str
        Which one: ``"left_toe"``, the name of a move.
    start, stop : float
        Seconds from the start of the take. A cut is an instant, with both equal.

    Raises
    ------
    DataError
        Unless ``0 <= start <= stop`` and both are finite.
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
    """Synchronised named tracks of one recording and their annotations; every track starts at time 0.

    Parameters
    ----------
    name : str
    tracks : mapping of str to Motion, Signal or Readings
        At least one. The times of readings are on the clock of the motions.
    annotations : tuple of Annotation, optional
        Each on one of the tracks.
    animation : str, optional
        What the animation is called in the file that the take was read from; empty where it has no name.

    Raises
    ------
    DataError
        If there is no track, an annotation names none of them, or readings have no rows.
    """

    name: str
    tracks: Mapping[str, Track]
    annotations: tuple[Annotation, ...] = field(default=())
    animation: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "tracks", MappingProxyType(dict(self.tracks)))
        object.__setattr__(self, "annotations", tuple(self.annotations))
        if not self.tracks:
            raise DataError(f"take {self.name!r} needs at least one track, found none")
        for name, track in self.tracks.items():
            if isinstance(track, Readings) and len(track) == 0:
                raise DataError(f"take {self.name!r}: expected rows in the readings of track {name!r}, found none")
        for note in self.annotations:
            if note.track not in self.tracks:
                raise DataError(
                    f"annotation on track {note.track!r}, but take {self.name!r} has {', '.join(self.tracks)}"
                )

    def __reduce__(self) -> tuple[Any, ...]:
        # a read-only view of a dict does not pickle
        return Take, (self.name, dict(self.tracks), self.annotations, self.animation)

    def _repr_html_(self) -> str:
        return notebook_html(self)

    @property
    def duration(self) -> float:
        """Seconds of the longest track."""
        return max(track.duration for track in self.tracks.values())

    def motion(self, track: str | None = None) -> Motion:
        """The motion of a track.

        Parameters
        ----------
        track : str, optional
            May be left out where the take has only one motion.

        Returns
        -------
        Motion

        Raises
        ------
        RequestError
            If the take has no such motion; the message names those it has.
        """
        return self.named_motion(track)[1]

    def named_motion(self, track: str | None = None) -> tuple[str, Motion]:
        """The motion of a track with the name of the track.

        Parameters
        ----------
        track : str, optional
            May be left out where the take has only one motion.

        Returns
        -------
        name : str
        motion : Motion

        Raises
        ------
        RequestError
            If the take has no such motion; the message names those it has.
        """
        return _pick(self.name, "motions", {n: t for n, t in self.tracks.items() if isinstance(t, Motion)}, track)

    def signal(self, track: str | None = None) -> Signal:
        """The signal of a track.

        Parameters
        ----------
        track : str, optional
            May be left out where the take has only one signal.

        Returns
        -------
        Signal

        Raises
        ------
        RequestError
            If the take has no such signal; the message names those it has.
        """
        signals = {n: t for n, t in self.tracks.items() if isinstance(t, Signal)}
        return _pick(self.name, "signals", signals, track)[1]

    def readings(self, track: str | None = None) -> Readings:
        """The readings of a track.

        Parameters
        ----------
        track : str, optional
            May be left out where the take has only one track of readings.

        Returns
        -------
        Readings

        Raises
        ------
        RequestError
            If the take has no such readings; the message names those it has.
        """
        captured = {n: t for n, t in self.tracks.items() if isinstance(t, Readings)}
        return _pick(self.name, "readings", captured, track)[1]

    def readings_of(self, motion: str) -> Readings | None:
        """The readings that were captured during a motion.

        Of a take with several motions, they are on the track whose name begins with the motion's, as
        ``leader.readings`` does. Of several such tracks the first is meant.

        Parameters
        ----------
        motion : str
            The motion's track.

        Returns
        -------
        Readings or None
        """
        several = sum(isinstance(track, Motion) for track in self.tracks.values()) > 1
        found = (t for n, t in self.tracks.items() if isinstance(t, Readings) and (not several or n.startswith(motion)))
        return next(found, None)

    def annotated(self, track: str, kind: str) -> tuple[Annotation, ...]:
        """The annotations of one kind on one track, sorted by start.

        Parameters
        ----------
        track, kind : str

        Returns
        -------
        tuple of Annotation
        """
        chosen = (note for note in self.annotations if note.track == track and note.kind == kind)
        return tuple(sorted(chosen, key=lambda note: (note.start, note.stop, note.label)))


def _pick(take: str, kind: str, tracks: Mapping[str, _T], name: str | None) -> tuple[str, _T]:
    """The named one of some tracks, or the only one."""
    if name is None and len(tracks) == 1:
        return next(iter(tracks.items()))
    if name is None or name not in tracks:
        known = ", ".join(tracks) or "none"
        raise RequestError(f"take {take!r}: name one of its {kind} ({known}), found {name!r}")
    return name, tracks[name]
