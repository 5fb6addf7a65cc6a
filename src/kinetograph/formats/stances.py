"""The standing reference of motions that are read: chosen by a person, or found where the rest pose does not stand."""

from __future__ import annotations

from dataclasses import replace

from kinetograph.formats.options import Loaded
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.stance import find_stance, stance_at, stands
from kinetograph.take import Track


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
    tracks: dict[str, Track] = {}
    notes: list[str] = []
    for name, track in loaded.take.tracks.items():
        if not isinstance(track, Motion):
            tracks[name] = track
            continue
        skeleton, said = with_stance(track, rest)
        tracks[name] = replace(track, skeleton=skeleton)
        notes += [note for note in said if note not in notes]
    if not notes:
        return loaded
    return replace(loaded, take=replace(loaded.take, tracks=tracks), notes=(*loaded.notes, *notes))


def with_stance(motion: Motion, rest: int | None = None) -> tuple[Skeleton, tuple[str, ...]]:
    """The skeleton of a motion, with a stance if it needs one, and what was done; ``rest`` as for `with_stances`."""
    skeleton = motion.skeleton
    sizeless = not skeleton.offsets[1:].any()
    if rest is None and (sizeless or skeleton.stance is not None or stands(skeleton)):
        return skeleton, ()
    found = find_stance(motion) if rest is None else stance_at(motion, rest)
    return (skeleton, ()) if found is None else (replace(skeleton, stance=found.rotations), (found.note,))
