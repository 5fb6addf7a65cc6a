"""Why something is at a moment of what was made of a request: pieces, spans that are filled, and layers."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

from kinetograph.errors import RequestError
from kinetograph.methods.performance import PerformanceModel, Reasons
from kinetograph.methods.together import explained
from kinetograph.pipeline.requesting import Rendered
from kinetograph.synthesis import DrivenPart, Piece, Synthesis


@dataclass(frozen=True, eq=False)
class Answer:
    """What is at a moment, and why.

    Parameters
    ----------
    second : float
        Of the result.
    reasons : Reasons, optional
        Why the piece is there, where the search for segments has chosen it.
    span : tuple of float, (start, stop), optional
        Seconds between which the timed search has gone instead: a span that is filled, or from one key to the next.
    pieces : tuple of Piece
        The recordings that play in the span.
    keys : tuple of float
        Seconds at which keys are met in the span.
    layers : tuple of DrivenPart
        What drives parts of the body at the moment; later ones are on top.
    edited : float, optional
        Metres by which joints are from the recording in the mean, where that is measured.
    """

    second: float
    reasons: Reasons | None = None
    span: tuple[float, float] | None = None
    pieces: tuple[Piece, ...] = ()
    keys: tuple[float, ...] = ()
    layers: tuple[DrivenPart, ...] = ()
    edited: float | None = None


def why_at(made: Rendered, second: float, count: int = 10) -> Answer:
    """What is at a moment of what was made of a request, and why.

    Parameters
    ----------
    made : Rendered
    second : float
        Of the result.
    count : int
        How many pieces are compared.

    Returns
    -------
    Answer

    Raises
    ------
    RequestError
        For a moment outside the result.
    """
    synthesis = made.synthesis
    if not 0 <= second <= synthesis.motion.duration + 1.0 / synthesis.motion.fps:
        raise RequestError(f"the result lasts {synthesis.motion.duration:.2f} s, found a time of {second:g} s")
    layers = tuple(each for each in synthesis.layers if each.start <= second <= each.stop)
    frame = min(round(second * synthesis.motion.fps), len(synthesis.motion) - 1)
    edited = float(synthesis.edited[frame]) if len(synthesis.edited) else None
    span = _span(made, second)
    if span is None:
        assert isinstance(made.model, PerformanceModel)
        assert made.control is not None
        at = synthesis.clock_at(frame) if len(synthesis.clock) else second
        reasons = explained(made.model, made.control, made.asked, at, count)
        return Answer(second, reasons, layers=layers, edited=edited)
    keys = tuple(time for time in synthesis.met if span[0] - 1e-6 <= time <= span[1] + 1e-6)
    return Answer(second, None, span, _played(synthesis, span), keys, layers, edited)


def _span(made: Rendered, second: float) -> tuple[float, float] | None:
    """Where the timed search has gone around a moment; None where the search for segments has."""
    synthesis = made.synthesis
    if made.control is not None:
        return next((span for span in synthesis.filled if span[0] <= second <= span[1]), None)
    after = min(max(bisect_right(synthesis.met, second), 1), len(synthesis.met) - 1)
    return (synthesis.met[after - 1], synthesis.met[after]) if after > 0 else (0.0, synthesis.motion.duration)


def _played(synthesis: Synthesis, span: tuple[float, float]) -> tuple[Piece, ...]:
    half = 0.5 / synthesis.motion.fps
    return tuple(piece for piece in synthesis.pieces if piece.start < span[1] - half and piece.stop > span[0] + half)
