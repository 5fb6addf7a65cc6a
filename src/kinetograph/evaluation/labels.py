"""Error rates of moves (Hsu 2004, section 6.2): segments performed as another move, and the patterns with any of them.

In the thesis an observer named the pattern that each dancer performed: eight beats, four two-beat segments. The
synthetic follower differed from the real one in 5 of 91 patterns, by one segment each: 5 of 364 segments. Here moves
are annotations of kind ``"move"``, on the recording and carried from the pieces to the result.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from kinetograph.evaluation.rows import NOT_A_NUMBER
from kinetograph.take import Annotation, Take

Interval = tuple[float, float]
"""First and last second."""
PATTERN = 4
"""Segments in a pattern, where the recording does not say which belong together."""


@dataclass(frozen=True)
class LabelErrors:
    """How many of the labelled segments, and of the patterns they make up, come out as another move.

    Parameters
    ----------
    segments, wrong : int
        Labelled segments, and those of them that come out as another move.
    patterns, wrong_patterns : int
        Patterns, and those of them with any wrong segment.
    """

    segments: int
    wrong: int
    patterns: int
    wrong_patterns: int

    @property
    def segment_rate(self) -> float:
        """Share of the segments that are wrong, not a number where none is labelled."""
        return self.wrong / self.segments if self.segments else NOT_A_NUMBER

    @property
    def pattern_rate(self) -> float:
        """Share of the patterns that are wrong, not a number where there is none."""
        return self.wrong_patterns / self.patterns if self.patterns else NOT_A_NUMBER

    def __add__(self, other: LabelErrors) -> LabelErrors:
        return LabelErrors(
            self.segments + other.segments,
            self.wrong + other.wrong,
            self.patterns + other.patterns,
            self.wrong_patterns + other.wrong_patterns,
        )


def label_errors(
    recorded: Iterable[Annotation],
    made: Iterable[Annotation],
    units: Sequence[Interval],
    patterns: Sequence[Interval] | None = None,
) -> LabelErrors:
    """Compare the moves of a recording with those of a result.

    A unit counts if one recorded move fills half of it; it is wrong unless the same move fills most of it in the
    result. A pattern is wrong if any of its units is.

    Parameters
    ----------
    recorded, made : iterable of Annotation
        The moves of the recording and of the result.
    units : sequence of tuple of float
        The segments that are compared: first and last second, in order.
    patterns : sequence of tuple of float, optional
        Intervals that hold their units' middles, seconds. Without it every four counted units that follow one another
        without a gap are a pattern.

    Returns
    -------
    LabelErrors
    """
    truth, result = list(recorded), list(made)
    judged: list[tuple[Interval, bool]] = []
    for unit in units:
        wanted, share = main_move(truth, unit)
        if share >= 0.5:
            judged.append((unit, main_move(result, unit)[0] != wanted))
    groups = _in_runs(judged) if patterns is None else [_within(judged, pattern) for pattern in patterns]
    groups = [group for group in groups if group]
    return LabelErrors(len(judged), sum(wrong for _, wrong in judged), len(groups), sum(any(g) for g in groups))


def main_move(notes: Iterable[Annotation], unit: Interval) -> tuple[str, float]:
    """The label that covers most of an interval.

    Parameters
    ----------
    notes : iterable of Annotation
    unit : tuple of float
        First and last second.

    Returns
    -------
    label : str
        Empty where no label covers any of it.
    share : float
        The share that it covers.
    """
    covered: dict[str, float] = {}
    for note in notes:
        overlap = min(note.stop, unit[1]) - max(note.start, unit[0])
        if overlap > 0:
            covered[note.label] = covered.get(note.label, 0.0) + overlap
    if not covered:
        return "", 0.0
    label = max(sorted(covered), key=lambda name: covered[name])
    return label, covered[label] / (unit[1] - unit[0])


def take_errors(take: Take, track: str, made: Iterable[Annotation], span: int = 1) -> LabelErrors:
    """The errors of a result that was made in place of a held-out track.

    Units run from every ``span``-th cut of the track to the next, from the first within a move; without cuts the moves
    themselves are the units. Annotations of kind ``"pattern"`` say which units belong together.

    Parameters
    ----------
    take : Take
        The held-out take.
    track : str
        Name of the track.
    made : iterable of Annotation
        The annotations of the result.
    span : int
        Cuts that a segment of the method goes on for.

    Returns
    -------
    LabelErrors
    """
    moves = take.annotated(track, "move")
    cuts = sorted({note.start for note in take.annotated(track, "cut")})
    patterns = [(note.start, note.stop) for note in take.annotated(track, "pattern")]
    units = [(note.start, note.stop) for note in moves if note.stop > note.start]
    if cuts and moves:
        within = [cut for cut in cuts if cut >= moves[0].start - 1e-6][::span]
        units = list(pairwise(within))
    return label_errors(moves, (note for note in made if note.kind == "move"), units, patterns or None)


def _in_runs(judged: list[tuple[Interval, bool]]) -> list[list[bool]]:
    """Whole groups of `PATTERN` units; after a gap a new group begins."""
    groups: list[list[bool]] = []
    run: list[bool] = []
    last = NOT_A_NUMBER
    for (start, stop), wrong in judged:
        run = [*run, wrong] if abs(start - last) < 1e-6 else [wrong]
        last = stop
        if len(run) == PATTERN:
            groups.append(run)
            run = []
    return groups


def _within(judged: list[tuple[Interval, bool]], pattern: Interval) -> list[bool]:
    return [wrong for (start, stop), wrong in judged if pattern[0] <= 0.5 * (start + stop) < pattern[1]]
