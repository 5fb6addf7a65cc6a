"""Foot contacts, carried from the recordings to the result."""

from __future__ import annotations

from collections.abc import Iterable

from kinetograph.synthesis import Piece
from kinetograph.take import Annotation

TOUCH = 0.05
"""Seconds; contacts of one role that are closer than this, as two pieces' halves of one contact are, become one."""


def carry(pieces: Iterable[tuple[Piece, tuple[Annotation, ...]]], track: str = "motion") -> tuple[Annotation, ...]:
    """The contacts of each piece's source, clipped to the piece and to the result's start, in the result's time."""
    moved: list[Annotation] = []
    for piece, contacts in pieces:
        for note in contacts:
            start, stop = max(note.start, piece.source_start), min(note.stop, piece.source_stop)
            if start < stop:
                begin = piece.start + (start - piece.source_start) * piece.stretch
                end = piece.start + (stop - piece.source_start) * piece.stretch
                if end > 0:
                    moved.append(Annotation(track, "contact", note.label, max(begin, 0.0), end))
    return merge(moved)


def merge(contacts: Iterable[Annotation], touch: float = TOUCH) -> tuple[Annotation, ...]:
    """Contacts with those of one role that overlap or nearly touch made into one, by start."""
    merged: list[Annotation] = []
    last: dict[str, int] = {}
    for note in sorted(contacts, key=lambda n: (n.label, n.start)):
        index = last.get(note.label)
        if index is not None and note.start <= merged[index].stop + touch:
            old = merged[index]
            merged[index] = Annotation(old.track, old.kind, old.label, old.start, max(old.stop, note.stop))
        else:
            last[note.label] = len(merged)
            merged.append(note)
    return tuple(sorted(merged, key=lambda n: (n.start, n.label)))
