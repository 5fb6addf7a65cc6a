"""Holding a span of a result while the rest is made anew: the span's two ends become keys of what is around it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import on_ground
from kinetograph.motion import Motion, concatenate, cut, headings, place
from kinetograph.post.contacts import merge
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation

Solve = Callable[[tuple[Key, ...]], Synthesis]


def solve_around(kept: Synthesis, span: tuple[float, float], keys: tuple[Key, ...], solve: Solve) -> Synthesis:
    """``kept`` from second ``span[0]`` to ``span[1]``, frame by frame, and new motion through the keys around it.

    Every key has a time, on the clock of ``kept``. A first key that is pinned nowhere stands where the way to the span
    begins, not where it does in its clip. Raises RequestError for a span outside it, and for keys without a
    time or within the span.
    """
    fps = kept.motion.fps
    low, high = round(span[0] * fps), round(span[1] * fps)
    if not 0 <= low < high < len(kept.motion):
        raise RequestError(
            f"a span to hold lies between 0 and {kept.motion.duration:.2f} s, found {span[0]:g} to {span[1]:g} s"
        )
    before, after = _around(keys, low / fps, high / fps)
    parts = [clip_synthesis(kept, low, high, 0.0)]
    if before:
        made = _lead_up(before, _end(kept.motion, low, low / fps), solve)
        parts.insert(0, clip_synthesis(made, 0, low - 1, 0.0))
        parts[1] = clip_synthesis(kept, low, high, low / fps)
    if after:
        later = tuple(replace(key, time=_shifted(key, -high / fps)) for key in after)
        made = solve((_end(kept.motion, high, 0.0), *later))
        begun = (high if before else high - low) / fps
        parts.append(clip_synthesis(made, 1, len(made.motion) - 1, begun + 1 / fps))
    return _joined(parts)


def _around(keys: tuple[Key, ...], start: float, stop: float) -> tuple[tuple[Key, ...], tuple[Key, ...]]:
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


def _end(motion: Motion, frame: int, time: float) -> Key:
    """A frame as a key that is pinned where it is."""
    x, _, z = motion.translation[frame]
    return Key(motion, frame, (time, time), (float(x), float(z)), float(headings(motion)[frame]), label="the held span")


def _lead_up(before: tuple[Key, ...], end: Key, solve: Solve) -> Synthesis:
    """Motion through keys to the span's beginning; where no key is pinned, it is made anywhere and then moved there."""
    if any(key.position is not None or key.heading is not None for key in before):
        return solve((*before, end))
    made = solve((*before, replace(end, position=None, heading=None)))
    turn = float(headings(end.clip)[end.frame] - headings(made.motion)[-1])
    shift = end.clip.translation[end.frame] - place(made.motion, turn, (0.0, 0.0, 0.0)).translation[-1]
    return _moved(made, turn, on_ground(shift))


def _moved(made: Synthesis, turn: float, shift: FloatArray) -> Synthesis:
    q = rot.about("y", turn)
    pieces = []
    for piece in made.pieces:
        w, x, y, z = (float(v) for v in rot.multiply(q, np.array(piece.rotation)))
        a, b, c = (float(v) for v in rot.rotate(q, np.array(piece.shift)) + shift)
        pieces.append(replace(piece, rotation=(w, x, y, z), shift=(a, b, c)))
    return replace(made, motion=place(made.motion, turn, shift), pieces=tuple(pieces))


def _shifted(key: Key, by: float) -> tuple[float, float]:
    assert key.time is not None
    return key.time[0] + by, key.time[1] + by


def clip_synthesis(made: Synthesis, first: int, last: int, begin: float) -> Synthesis:
    """Frames ``first`` to ``last`` of a synthesis, to begin at second ``begin``, with their pieces and contacts."""
    fps = made.motion.fps
    low, high, by = first / fps, last / fps, begin - first / fps
    pieces: list[Piece] = []
    for piece in made.pieces:
        start, stop = max(piece.start, low), min(piece.stop, high)
        if stop > start + 1e-9:
            source = piece.source_time(np.array([start, stop]))
            pieces.append(
                replace(
                    piece,
                    start=start + by,
                    stop=stop + by,
                    source_start=float(source[0]),
                    source_stop=float(source[1]),
                )
            )
    notes = [
        Annotation(n.track, n.kind, n.label, max(n.start, low) + by, min(n.stop, high) + by)
        for n in made.annotations
        if n.start < high and n.stop > low
    ]
    return replace(
        made,
        motion=cut(made.motion, first, last + 1),
        pieces=tuple(pieces),
        annotations=tuple(notes),
        edited=made.edited[first : last + 1],
    )


def _joined(parts: list[Synthesis]) -> Synthesis:
    edited = np.concatenate([part.edited for part in parts])
    pieces = _closed([piece for part in parts for piece in part.pieces])
    statistics = {
        "frames": len(edited),
        "pieces": len(pieces),
        "examples": len({(p.take, p.mirrored) for p in pieces}),
        "untouched": float((edited < parts[0].statistics["untouched below"]).mean()),
        "untouched below": parts[0].statistics["untouched below"],
        "mean edit": float(edited.mean()),
    }
    return Synthesis(
        concatenate([part.motion for part in parts]),
        pieces,
        cost=sum(part.cost for part in parts),
        annotations=merge(note for part in parts for note in part.annotations),
        statistics=statistics,
        warnings=tuple(dict.fromkeys(text for part in parts for text in part.warnings)),
        edited=edited,
    )


def _closed(pieces: list[Piece]) -> tuple[Piece, ...]:
    """Pieces without the gaps of a frame that clipping leaves: each is played on to where the next begins."""
    closed = []
    for piece, after in zip(pieces, [*pieces[1:], None], strict=True):
        stop = piece.stop if after is None else after.start
        source = float(piece.source_time(stop))
        closed.append(replace(piece, stop=stop, source_stop=source))
    return tuple(closed)
