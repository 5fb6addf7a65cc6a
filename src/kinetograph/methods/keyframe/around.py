"""Holding a span of a result while the rest is made anew: the span's two ends become keys of what is around it."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import on_ground
from kinetograph.methods.keyframe.realize import edit_statistics
from kinetograph.motion import Motion, concatenate, cut, heading_at, place
from kinetograph.post.contacts import merge
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation

Solve = Callable[[tuple[Key, ...]], Synthesis]
"""Makes a motion through keys."""

SolveAll = Callable[[tuple[Key, ...]], tuple[Synthesis, ...]]
"""Makes one or more different motions through keys, the best first."""


def solve_around(
    held: Synthesis, span: tuple[float, float], keys: tuple[Key, ...], solve: SolveAll
) -> tuple[Synthesis, ...]:
    """A span of a result, frame by frame, and new motions through the keys around it, the best first.

    Parameters
    ----------
    held : Synthesis
    span : tuple of float
        Seconds of ``held`` from which and to which it is held.
    keys : tuple of Key
        Each with a time, in seconds of ``held``. A first key that is pinned nowhere stands where the path to the span
        begins, not where it does in its clip.
    solve : callable
        Makes one or more motions through keys.

    Raises
    ------
    RequestError
        For a span outside the result, and for keys without a time or within the span.
    """
    fps = held.motion.fps
    low, high = round(span[0] * fps), round(span[1] * fps)
    if not 0 <= low < high < len(held.motion):
        raise RequestError(
            f"a span to hold lies between 0 and {held.motion.duration:.2f} s, found {span[0]:g} to {span[1]:g} s"
        )
    before, after = _divided(keys, low / fps, high / fps)
    begin = low if before else 0  # the held span's first frame in the result
    kept = clip_synthesis(held, low, high, begin / fps)
    leads, rests = [list[Synthesis]()], [list[Synthesis]()]
    if before:
        found = _lead_up(before, frame_as_key(held.motion, low, low / fps), solve)
        leads = [[clip_synthesis(lead, 0, low - 1, 0.0)] for lead in found]
    if after:
        later = tuple(replace(key, time=_shifted(key, -high / fps)) for key in after)
        found = solve((frame_as_key(held.motion, high, 0.0), *later))
        at = (begin + high - low) / fps + 1 / fps
        rests = [[clip_synthesis(rest, 1, len(rest.motion) - 1, at)] for rest in found]
    pairs = zip(_filled(leads, len(rests)), _filled(rests, len(leads)), strict=True)
    return tuple(joined([*lead, kept, *rest]) for lead, rest in pairs)


def _filled(parts: list[list[Synthesis]], length: int) -> list[list[Synthesis]]:
    """Parts repeated from the first on, where others are more."""
    return list(itertools.islice(itertools.cycle(parts), max(len(parts), length)))


def _divided(keys: tuple[Key, ...], start: float, stop: float) -> tuple[tuple[Key, ...], tuple[Key, ...]]:
    """The keys before and after a span of seconds."""
    before, after = [], []
    for number, key in enumerate(keys):
        time = (0.0, 0.0) if number == 0 and key.time is None else key.time
        if time is None:
            raise RequestError(f"{key.label}: around a span that is held every key has a time, and this one has none")
        if time[1] < start:
            before.append(replace(key, time=time))
        elif time[0] > stop:
            after.append(key)
        else:
            raise RequestError(f"{key.label}: its time is within the span that is held, {start:g} to {stop:g} s")
    return tuple(before), tuple(after)


def _heading(motion: Motion, frame: int) -> float:
    return heading_at(motion, frame)


def frame_as_key(motion: Motion, frame: int, time: float, label: str = "the held span") -> Key:
    """A frame of a motion as a key that is pinned where it is.

    Parameters
    ----------
    motion : Motion
    frame : int
    time : float
        Seconds at which it is to be met.
    label : str
        What messages call it.
    """
    x, _, z = motion.translation[frame]
    return Key(motion, frame, (time, time), (float(x), float(z)), _heading(motion, frame), label=label)


def _lead_up(before: tuple[Key, ...], end: Key, solve: SolveAll) -> tuple[Synthesis, ...]:
    """Motions through keys to the span's beginning; where no key is pinned, made anywhere and then moved there."""
    if any(key.position is not None or key.heading is not None for key in before):
        return solve((*before, end))
    leads = solve((*before, replace(end, position=None, heading=None)))
    return tuple(_moved_to(lead, end) for lead in leads)


def _moved_to(lead: Synthesis, end: Key) -> Synthesis:
    """A result moved to end where a key is."""
    angle = _heading(end.clip, end.frame) - _heading(lead.motion, -1)
    shift = end.clip.translation[end.frame] - place(lead.motion, angle, (0.0, 0.0, 0.0)).translation[-1]
    return _moved(lead, angle, on_ground(shift))


def _moved(result: Synthesis, angle: float, shift: FloatArray) -> Synthesis:
    """A result rotated about the vertical, radians, and then shifted, metres."""
    q = rot.about("y", angle)
    pieces = []
    for piece in result.pieces:
        w, x, y, z = (float(v) for v in rot.multiply(q, np.array(piece.rotation)))
        a, b, c = (float(v) for v in rot.rotate(q, np.array(piece.shift)) + shift)
        pieces.append(replace(piece, rotation=(w, x, y, z), shift=(a, b, c)))
    return replace(result, motion=place(result.motion, angle, shift), pieces=tuple(pieces))


def _shifted(key: Key, by: float) -> tuple[float, float]:
    assert key.time is not None
    return key.time[0] + by, key.time[1] + by


def clip_synthesis(result: Synthesis, first: int, last: int, begin: float) -> Synthesis:
    """Some frames of a result with their pieces and contacts.

    Parameters
    ----------
    result : Synthesis
    first, last : int
        Frames ``first`` to ``last``, both included.
    begin : float
        Seconds at which they begin in the clipped result.
    """
    fps = result.motion.fps
    low, high, by = first / fps, last / fps, begin - first / fps
    pieces = [_clipped(piece, low, high, by) for piece in result.pieces]
    notes = [
        Annotation(n.track, n.kind, n.label, max(n.start, low) + by, min(n.stop, high) + by)
        for n in result.annotations
        if n.start < high and n.stop > low
    ]
    return replace(
        result,
        motion=cut(result.motion, first, last + 1),
        pieces=tuple(piece for piece in pieces if piece is not None),
        annotations=tuple(notes),
        edited=result.edited[first : last + 1],
        met=tuple(time + by for time in result.met if low - 1e-9 <= time <= high + 1e-9),
    )


def _clipped(piece: Piece, low: float, high: float, by: float) -> Piece | None:
    """A piece between two seconds, moved ``by`` seconds; None where nothing is left."""
    start, stop = max(piece.start, low), min(piece.stop, high)
    if stop <= start + 1e-9:
        return None
    a, b = (float(second) for second in piece.source_time(np.array([start, stop])))
    return replace(piece, start=start + by, stop=stop + by, source_start=a, source_stop=b)


def joined(parts: list[Synthesis]) -> Synthesis:
    """Results one after another; every one begins where the one before ends."""
    edited = np.concatenate([part.edited for part in parts])
    pieces = _closed([piece for part in parts for piece in part.pieces])
    return Synthesis(
        concatenate([part.motion for part in parts]),
        pieces,
        cost=sum(part.cost for part in parts),
        annotations=merge(note for part in parts for note in part.annotations),
        statistics={
            **edit_statistics(edited, len(pieces), len({(p.take, p.mirrored) for p in pieces})),
            **_worst(parts),
        },
        warnings=tuple(dict.fromkeys(text for part in parts for text in part.warnings)),
        edited=edited,
        met=tuple(time for part in parts for time in part.met),
    )


def _worst(parts: list[Synthesis]) -> dict[str, float]:
    """The figures of quality of several results: the worst of each."""
    names = [n for n in ("jump", "jump in recordings", "skate", "skate in recordings") if n in parts[0].statistics]
    return {name: max(part.statistics.get(name, 0.0) for part in parts) for name in names}


def _closed(pieces: list[Piece]) -> tuple[Piece, ...]:
    """Pieces without the gaps of a frame that clipping leaves: each is played on to where the next begins."""
    closed = []
    for piece, after in zip(pieces, [*pieces[1:], None], strict=True):
        stop = piece.stop if after is None else after.start
        source = float(piece.source_time(stop))
        closed.append(replace(piece, stop=stop, source_stop=source))
    return tuple(closed)
