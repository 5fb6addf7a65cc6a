"""The moves that are seen in a control: transcription (Hsu 2004, chapter 7)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.interpretation import interpreter
from kinetograph.methods.performance.rules import Demand, Rule, moves_of
from kinetograph.methods.performance.segments import Source
from kinetograph.progress import Progress


@dataclass(frozen=True)
class Transcript:
    """A move seen in a control.

    Parameters
    ----------
    move : str
        The move's name; empty where pieces have none.
    start, stop : float
        Seconds of the control.
    margin : float
        What the best interpretation without the move there costs more, as a share of the best one's cost.
    """

    move: str
    start: float
    stop: float
    margin: float


def require_moves(fitted: Fitted) -> None:
    """Raise RequestError where the recordings name no moves."""
    if not any(note.kind == "move" for source in fitted.sources for note in source.annotations):
        raise RequestError("the library names no moves; annotate some of kind 'move' (library annotate --from CSV)")


def transcribe(
    fitted: Fitted, x: FloatArray, rules: Sequence[Demand] = (), progress: Progress | None = None
) -> list[Transcript]:
    """The moves of a control in order, each with its margin to the best interpretation that has another one there.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the search's rate.
    rules : sequence of Rule
        What is pinned or forbidden, as where the motion was made.
    progress : Progress, optional
        Called with the moves whose margins are known and their number.

    Raises
    ------
    RequestError
        Where the library has no moves annotated.
    """
    require_moves(fitted)
    best_under = interpreter(fitted, x)
    best = best_under(rules)
    runs = _runs(fitted, best)
    rows: list[Transcript] = []
    for move, start, stop in runs:
        if progress:
            progress(len(rows), len(runs))
        rows.append(Transcript(move, start, stop, _margin(best_under, (move, start, stop), best.score, rules)))
    return rows


def _margin(
    best_under: Callable[[Sequence[Demand]], SegmentalPath],
    run: tuple[str, float, float],
    best: float,
    rules: Sequence[Demand],
) -> float:
    """What the best interpretation costs more, as a share, that has another move in a run; infinite without one."""
    move, start, stop = run
    if not move:
        return 0.0
    try:
        other = best_under((*rules, Rule(start, stop, move=move, forbid=True))).score
    except DataError:  # nothing else covers it under the rules
        return float("inf")
    return other / max(best, 1e-12) - 1.0


def _runs(fitted: Fitted, path: SegmentalPath) -> list[tuple[str, float, float]]:
    """Consecutive pieces of one move as one, in seconds; the move of pieces without one is empty."""
    runs: list[tuple[str, float, float]] = []
    rate = fitted.settings.rate
    for state, start, stop in zip(path.states, path.starts, path.stops, strict=True):
        segment = fitted.segment_of(state)
        move = _move_of(fitted.sources[segment.source], segment.start, segment.stop)
        begin, end = max(float(start), 0.0) / rate, float(stop) / rate
        if runs and runs[-1][0] == move:
            runs[-1] = (move, runs[-1][1], end)
        else:
            runs.append((move, begin, end))
    return runs


def _move_of(source: Source, start: float, stop: float) -> str:
    """The move that fills most of an interval, half of it or more; of two halves, the first."""
    found = moves_of(source, start, stop)
    notes = [note for note in source.annotations if note.kind == "move" and note.label in found]
    shares = [(min(note.stop, stop) - max(note.start, start), -note.start, note.label) for note in notes]
    return max(shares)[2] if shares else ""
