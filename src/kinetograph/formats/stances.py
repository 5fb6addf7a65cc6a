"""The standing reference of motions that are read: chosen by a person, or found where the rest pose does not stand."""

from __future__ import annotations

from dataclasses import replace

from kinetograph.formats.options import Loaded
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.stance import FoundStance, find_stance, stance_at, stands


def with_stances(loaded: Loaded, rest: int | None = None) -> Loaded:
    """What a reader returned, with a stance for every skeleton that needs one, and notes.

    Parameters
    ----------
    loaded : Loaded
        In metres, Y up, with roles.
    rest : int, optional
        The frame in which the bodies stand; without one, a stance is found where a rest pose does not stand.

    Returns
    -------
    Loaded

    Raises
    ------
    RequestError
        If there is no such frame.
    """
    tracks: dict[str, Motion | Signal] = {}
    notes: list[str] = []
    for name, track in loaded.take.tracks.items():
        found = _stance(track, rest) if isinstance(track, Motion) else None
        if found is None or not isinstance(track, Motion):
            tracks[name] = track
            continue
        tracks[name] = replace(track, skeleton=replace(track.skeleton, stance=found.rotations))
        notes += [note for note in (found.note,) if note not in notes]
    if not notes:
        return loaded
    return replace(loaded, take=replace(loaded.take, tracks=tracks), notes=(*loaded.notes, *notes))


def _stance(motion: Motion, rest: int | None) -> FoundStance | None:
    if rest is not None:
        return stance_at(motion, rest)
    sizeless = not motion.skeleton.offsets[1:].any()
    if sizeless or motion.skeleton.stance is not None or stands(motion.skeleton):
        return None
    return find_stance(motion)
