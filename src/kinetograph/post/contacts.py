"""Annotations, carried from the recordings to the result: contacts of the feet, handholds, names of moves."""

from __future__ import annotations

from collections.abc import Iterable

from kinetograph.synthesis import Piece
from kinetograph.take import Annotation

TOUCH = 0.05
"""Seconds; intervals of one label that are closer than this, such as the halves of a contact in two pieces, become
one."""


def carry(pieces: Iterable[tuple[Piece, tuple[Annotation, ...]]], track: str = "motion") -> tuple[Annotation, ...]:
    """The annotations of the recordings that pieces are taken from, in the time of the result.

    Parameters
    ----------
    pieces : iterable of (Piece, tuple of Annotation)
        Each piece with the annotations of its recording, in the recording's seconds.
    track : str
        The track of the result.

    Returns
    -------
    tuple of Annotation
        Clipped to their piece and to the start of the result, and merged, see `merge`.
    """
    moved: list[Annotation] = []
    for piece, notes in pieces:
        for note in notes:
            if piece.held and note.start <= piece.source_start <= note.stop and piece.stop > 0:
                moved.append(Annotation(track, note.kind, note.label, max(piece.start, 0.0), piece.stop))
                continue
            start, stop = max(note.start, piece.source_start), min(note.stop, piece.source_stop)
            if start < stop:
                begin = piece.start + (start - piece.source_start) * piece.stretch
                end = piece.start + (stop - piece.source_start) * piece.stretch
                if end > 0:
                    moved.append(Annotation(track, note.kind, note.label, max(begin, 0.0), end))
    return merge(moved)


def contacts_of(annotations: Iterable[Annotation], kind: str = "contact") -> tuple[Annotation, ...]:
    """The annotations of one kind, by default the contacts.

    Parameters
    ----------
    annotations : iterable of Annotation
    kind : str

    Returns
    -------
    tuple of Annotation
    """
    return tuple(note for note in annotations if note.kind == kind)


def merge(annotations: Iterable[Annotation], touch: float = TOUCH) -> tuple[Annotation, ...]:
    """Annotations, with those of one kind and label that overlap or nearly touch made into one.

    Parameters
    ----------
    annotations : iterable of Annotation
        Of one track.
    touch : float
        Seconds between two that are made into one.

    Returns
    -------
    tuple of Annotation
        Sorted by start.

    Examples
    --------
    >>> halves = [Annotation("motion", "contact", "left_toe", 0.0, 0.5), Annotation("motion", "contact", "left_toe",
    ...           0.52, 1.0)]
    >>> [(note.start, note.stop) for note in merge(halves)]
    [(0.0, 1.0)]
    """
    merged: list[Annotation] = []
    last: dict[tuple[str, str], int] = {}
    for note in sorted(annotations, key=lambda n: (n.kind, n.label, n.start)):
        index = last.get((note.kind, note.label))
        if index is not None and note.start <= merged[index].stop + touch:
            old = merged[index]
            merged[index] = Annotation(old.track, old.kind, old.label, old.start, max(old.stop, note.stop))
        else:
            last[note.kind, note.label] = len(merged)
            merged.append(note)
    return tuple(sorted(merged, key=lambda n: (n.start, n.label)))
