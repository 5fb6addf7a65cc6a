"""The moves that are seen in a control: transcription (Hsu 2004, chapter 7)."""

from __future__ import annotations

from dataclasses import dataclass

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.interpretation import interpret
from kinetograph.methods.performance.rules import Rule, moves_of


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


def transcribe(fitted: Fitted, x: FloatArray) -> list[Transcript]:
    """The moves of a control in order, each with its margin to the best interpretation that has another one there.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the search's rate.

    Raises
    ------
    RequestError
        Where the library has no moves annotated.
    """
    require_moves(fitted)
    best = interpret(fitted, x)
    rows = []
    for move, start, stop in _runs(fitted, best):
        rules = (Rule(start, stop, move=move, forbid=True),)
        other = interpret(fitted, x, rules=rules).score if move else best.score
        rows.append(Transcript(move, start, stop, other / max(best.score, 1e-12) - 1.0))
    return rows


def _runs(fitted: Fitted, path: SegmentalPath) -> list[tuple[str, float, float]]:
    """Consecutive pieces of one move as one, in seconds; the move of pieces without one is empty."""
    runs: list[tuple[str, float, float]] = []
    rate = fitted.settings.rate
    for state, start, stop in zip(path.states, path.starts, path.stops, strict=True):
        segment = fitted.segment_of(state)
        move = min(moves_of(fitted.sources[segment.source], segment.start, segment.stop), default="")
        begin, end = max(float(start), 0.0) / rate, float(stop) / rate
        if runs and runs[-1][0] == move:
            runs[-1] = (move, runs[-1][1], end)
        else:
            runs.append((move, begin, end))
    return runs
