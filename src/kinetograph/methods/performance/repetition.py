"""How much a result repeats itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from kinetograph.synthesis import Piece

STRIDE = 2
"""Pieces of a stride: left and right alternate."""


def most_used(pieces: Iterable[Piece]) -> float:
    """The share of the pieces that the one used most often has, mirrored or not; 0 without pieces.

    Examples
    --------
    >>> step, other = Piece("walk", "motion", 0.0, 0.6, 0.0, 0.6), Piece("walk", "motion", 0.6, 1.2, 0.6, 1.2)
    >>> most_used([step, other, step])
    0.6666666666666666
    """
    steps = _steps(pieces)
    return max(Counter(steps).values(), default=0) / max(len(steps), 1)


def times_running(pieces: Iterable[Piece]) -> int:
    """How many times running a piece, or a pair of pieces, is used at most, mirrored or not; 1 where none comes again.

    Examples
    --------
    >>> left, right = Piece("walk", "motion", 0.0, 0.6, 0.0, 0.6), Piece("walk", "motion", 0.6, 1.2, 0.6, 1.2)
    >>> times_running([left, right, left, right, left, right]), times_running([left, left]), times_running([left])
    (3, 2, 1)
    """
    steps = _steps(pieces)
    return 1 + max((_longest_run(steps, apart) // apart for apart in range(1, STRIDE + 1)), default=0)


def _steps(pieces: Iterable[Piece]) -> list[tuple[str, str, float, float]]:
    """What pieces are, whatever their place, stretch and side."""
    return [(p.take, p.track, round(p.source_start, 3), round(p.source_stop, 3)) for p in pieces]


def _longest_run(steps: Sequence[object], apart: int) -> int:
    """How many steps in a row are the same as the one so many before."""
    longest = run = 0
    for before, step in zip(steps, steps[apart:], strict=False):
        run = run + 1 if step == before else 0
        longest = max(longest, run)
    return longest
