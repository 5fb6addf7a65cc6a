"""Models with so many segments, with another beam or k, and what their results cost when they are placed anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import control_error, joint_error
from kinetograph.evaluation.reproduce.hsu2004.data import held_out
from kinetograph.library import Library
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    Segment,
    at_rate,
    pieces_of,
    points_of,
)
from kinetograph.motion import Motion
from kinetograph.synthesis import Piece, Synthesis

FINE = 30.0
"""Rate in Hz at which durations are refined, and results are placed anew."""

Held = tuple[PerformanceModel, Motion]
"""A held-out walk, and a model of the other takes."""


def held_models(library: Library, method: PerformanceControl, quick: bool) -> list[Held]:
    """Each take and a model of the others; with ``quick`` only the longest take."""
    takes = held_out(library)[: 1 if quick else None]
    return [(method.fit(library, exclude=(name,)), motion) for name, motion in takes]


def clustered(
    method: PerformanceControl,
    library: Library,
    segments: int,
    *,
    exclude: tuple[str, ...] = (),
    track: str | None = None,
) -> PerformanceModel:
    """The model whose number of segments is nearest, by bisection of the clustering threshold.

    Parameters
    ----------
    method : PerformanceControl
    library : Library
    segments : int
        Where there are fewer, all are used.
    exclude : tuple of str
        Takes that are left out.
    track : str, optional
        The track to make.

    Returns
    -------
    PerformanceModel
    """
    best = method.fit(library, exclude=exclude, track=track)
    if segments_in(best) <= segments:
        return best
    low, high = 0.0, 1.0
    for _ in range(9):
        middle = 0.5 * (low + high)
        model = replace(method, cluster=middle).fit(library, exclude=exclude, track=track)
        count = segments_in(model)
        if abs(count - segments) < abs(segments_in(best) - segments):
            best = model
        low, high = (middle, high) if count > segments else (low, middle)
    return best


def segments_in(model: PerformanceModel) -> int:
    """The number of a model's segments."""
    return len(model.fitted.instances.segments)


def with_method(
    model: PerformanceModel, *, beam: float | None = None, continuity: float | None = None
) -> PerformanceModel:
    """The model with another beam or k, on which its instances do not depend."""
    k = model.method.continuity if continuity is None else continuity
    settings = replace(model.method, beam=beam, continuity=k)
    return PerformanceModel(replace(model.fitted, settings=settings))


def search_points(model: PerformanceModel, control: Motion) -> FloatArray:
    """The control points of a motion at the search's rate, shape ``(T + 1, P, 3)``."""
    return at_rate(points_of(model.method, control), control.fps, model.method.rate)


def errors(model: PerformanceModel, result: Synthesis, motion: Motion) -> tuple[float, float]:
    """Control and joint error in cm of a result that was made for a walk."""
    control = control_error(result.motion, points_of(model.method, motion), motion.fps)
    return 100 * control, 100 * joint_error(result.motion, motion)


def placed_again(model: PerformanceModel, result: Synthesis, x: FloatArray, rate: float) -> list[Piece]:
    """A result's pieces, placed and costed for control points at another rate: the terms of equation 4.5.

    Parameters
    ----------
    model : PerformanceModel
    result : Synthesis
    x : ndarray, shape (T + 1, P, 3)
        Control points, metres.
    rate : float
        Their rate, Hz.

    Returns
    -------
    list of Piece
    """
    known: dict[tuple[str, bool, float], Segment] = {}
    for segment in model.fitted.instances.segments:
        source = model.fitted.sources[segment.source]
        known[source.take, source.mirrored, segment.start] = segment
    segments = [known[piece.take, piece.mirrored, piece.source_start] for piece in result.pieces]
    borders = np.array([result.pieces[0].start, *(piece.stop for piece in result.pieces)])
    return pieces_of(model.fitted, x, rate, segments, np.round(borders * rate))


def seam_gap(model: PerformanceModel, result: Synthesis, motion: Motion) -> float:
    """Root mean square distance in cm of the target points across seams, before they are blended."""
    dense = at_rate(points_of(model.method, motion), motion.fps, FINE)
    pieces = placed_again(with_method(model, continuity=1.0), result, dense, FINE)
    weight = sum(model.method.targets.values())
    squares = [piece.seam / weight for piece in pieces[1:]]
    return 100 * float(np.sqrt(np.mean(squares))) if squares else 0.0
