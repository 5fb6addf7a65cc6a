"""Annotations, carried from the recordings to the result: contacts of the feet, handholds, names of moves."""

from __future__ import annotations

from collections.abc import Iterable

from kinetograph.synthesis import Piece
from kinetograph.take import Annotation

TOUCH = 0.05
"""Seconds; intervals of one label that are closer than this, as two pieces' halves of one contact are, become one."""


def carry(pieces: Iterable[tuple[Piece, tuple[Annotation, ...]]], track: str = "motion") -> tuple[Annotation, ...]:
    """The annotations of each piece's source, clipped to the piece and to the result's start, in the result's time."""
    moved: list[Annotation] = []
    for piece, marks in pieces:
        for note in marks:
            start, stop = max(note.start, piece.source_start), min(note.stop, piece.source_stop)
            if start < stop:
                begin = piece.start + (start - piece.source_start) * piece.stretch
                end = piece.start + (stop - piece.source_start) * piece.stretch
                if end > 0:
                    moved.append(Annotation(track, note.kind, note.label, max(begin, 0.0), end))
    return merge(moved)


def contacts_of(marks: Iterable[Annotation], kind: str = "contact") -> tuple[Annotation, ...]:
    """The annotations of one kind, by default the contacts."""
    return tuple(note for note in marks if note.kind == kind)


def merge(marks: Iterable[Annotation], touch: float = TOUCH) -> tuple[Annotation, ...]:
    """Annotations with those of one kind and label that overlap or nearly touch made into one, by start."""
    merged: list[Annotation] = []
    last: dict[tuple[str, str], int] = {}
    for note in sorted(marks, key=lambda n: (n.kind, n.label, n.start)):
        index = last.get((note.kind, note.label))
        if index is not None and note.start <= merged[index].stop + touch:
            old = merged[index]
            merged[index] = Annotation(old.track, old.kind, old.label, old.start, max(old.stop, note.stop))
        else:
            last[note.kind, note.label] = len(merged)
            merged.append(note)
    return tuple(sorted(merged, key=lambda n: (n.start, n.label)))
