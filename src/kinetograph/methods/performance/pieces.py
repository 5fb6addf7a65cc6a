"""From a sequence of states to pieces: durations at full rate, and where each piece is placed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.kinematics import on_ground
from kinetograph.learn import Placement, SegmentalPath, Span, padded_width, retime
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.moments import Moment
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.methods.performance.segments import Segment
from kinetograph.methods.performance.weights import weights
from kinetograph.motion import Motion, heading_at, sample
from kinetograph.sampling import interpolate
from kinetograph.synthesis import Piece


def pieces_at_full_rate(
    fitted: Fitted, points: FloatArray, fps: float, path: SegmentalPath, moments: Sequence[Moment] = ()
) -> list[Piece]:
    """The pieces of a sequence, their durations adjusted at ``fine_rate`` (section 4.4.3) where there is one.

    Parameters
    ----------
    fitted : Fitted
    points : ndarray, shape (F, P, 3)
        Control points at ``fps``.
    fps : float
    path : SegmentalPath
        The sequence, at the search's rate.
    moments : sequence of Moment
        What is to be shown at single times.
    """
    settings = fitted.settings
    rate = settings.fine_rate or settings.rate
    x = at_rate(points, fps, rate)
    borders = fine_borders(fitted, x, rate, path, moments) if settings.fine_rate else _coarse_borders(path)
    return pieces_of(fitted, x, rate, [fitted.segment_of(s) for s in path.states], borders)


def _coarse_borders(path: SegmentalPath) -> FloatArray:
    return np.concatenate([path.starts[:1], path.stops]).astype(np.float64)


def fine_borders(
    fitted: Fitted, x: FloatArray, rate: float, path: SegmentalPath, moments: Sequence[Moment] = ()
) -> FloatArray:
    """Borders of the constrained search of section 4.4.3.

    Each border between two pieces may move by less than a step of the coarse rate; the control's two ends stay.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the fine rate, metres.
    rate : float
        The fine rate, Hz.
    path : SegmentalPath
        The sequence that was found at the coarse rate.
    moments : sequence of Moment
        What is to be shown at single times.

    Returns
    -------
    ndarray, shape (L + 1,)
        In steps of the fine rate.
    """
    ratio = rate / fitted.settings.rate
    slack = int(np.ceil(ratio)) - 1
    coarse = np.round(_coarse_borders(path) * ratio).astype(np.int64)
    around = np.arange(-slack, slack + 1)
    candidates = [coarse[:1], *(border + around for border in coarse[1:-1]), coarse[-1:]]
    spans = [
        _span(fitted, x, rate, fitted.segment_of(state), candidates[i], candidates[i + 1])
        for i, state in enumerate(path.states)
    ]
    for moment in moments:
        _ask(fitted, moment, rate, path, candidates, spans)
    chosen, score = retime(spans, fitted.settings.continuity)
    if not np.isfinite(score):
        return coarse.astype(np.float64)
    return np.array([c[i] for c, i in zip(candidates, chosen, strict=True)], dtype=np.float64)


def _ask(
    fitted: Fitted,
    moment: Moment,
    rate: float,
    path: SegmentalPath,
    candidates: Sequence[FloatArray],
    spans: Sequence[Span],
) -> None:
    """Add what a moment costs to the spans that may show it."""
    at, last = moment.window[0] * rate, len(spans) - 1
    for i, (state, span) in enumerate(zip(path.states, spans, strict=True)):
        if candidates[i][0] > at or (candidates[i + 1][-1] <= at and i < last):
            continue
        segment = fitted.segment_of(state)
        for a, start in enumerate(candidates[i]):
            for b, stop in enumerate(candidates[i + 1]):
                if start <= at and (at < stop or i == last):
                    second = segment.start + segment.duration * (at - start) / (stop - start)
                    span.costs[a, b] += moment.cost_of(fitted, segment, second)


def _span(fitted: Fitted, x: FloatArray, rate: float, segment: Segment, starts: FloatArray, stops: FloatArray) -> Span:
    """D and the placed ends of one segment over all pairs of its candidate borders."""
    width = padded_width(3 * len(fitted.basis))
    shape = (len(starts), len(stops))
    span = Span(np.full(shape, np.inf), np.zeros((*shape, width)), np.zeros((*shape, width)))
    most = fitted.settings.stretch + 1.01 / rate
    for a, start in enumerate(starts):
        for b, stop in enumerate(stops):
            if stop - start < 2 or (not segment.held and abs((stop - start) / rate - segment.duration) > most):
                continue
            if max(start, 0) >= min(stop, len(x) - 1):
                continue
            cost, placement = _place(fitted, x, rate, segment, int(start), int(stop))
            span.costs[a, b] = cost
            span.heads[a, b], span.tails[a, b] = _placed_ends(fitted, segment, placement)
    return span


def _place(
    fitted: Fitted, x: FloatArray, rate: float, segment: Segment, start: int, stop: int
) -> tuple[float, Placement]:
    """D and M of a segment over steps ``start`` to ``stop``, of which only those within the control count."""
    source = fitted.sources[segment.source]
    first, last = max(start, 0), min(stop, len(x) - 1)
    times = segment.start + (np.arange(first, last + 1) - start) * (segment.duration / (stop - start))
    example = interpolate(source.control_points, times * source.motion.fps)
    w = weights(fitted.settings, last - first + 1, rate)
    costs, placement = fitted.settings.alignment.align(x[None, first : last + 1], example[None], w)
    return float(costs[0, 0]), placement


def _placed_ends(fitted: Fitted, segment: Segment, placement: Placement) -> tuple[SingleArray, SingleArray]:
    """The head and the tail ``(K,)`` of one placed segment."""
    index, width = fitted.instances.places[segment], padded_width(3 * len(fitted.basis))
    head, tail = (placement.ends(0, ends[index][None], fitted.basis_sums, width)[0] for ends in fitted.segment_ends)
    return head, tail


def pieces_of(
    fitted: Fitted, x: FloatArray, rate: float, segments: Sequence[Segment], borders: FloatArray
) -> list[Piece]:
    """The pieces that segments become between their borders in steps of ``rate``, placed by control points ``x``."""
    pieces: list[Piece] = []
    tail: SingleArray | None = None
    for i, segment in enumerate(segments):
        start, stop = float(borders[i]), float(borders[i + 1])
        cost, placement = _place(fitted, x, rate, segment, int(start), int(stop))
        head, next_tail = _placed_ends(fitted, segment, placement)
        gap = 0.0 if tail is None else float(np.sum((tail - head).astype(np.float64) ** 2))
        tail = next_tail
        rotation, shift = placement.transform(0, 0)
        if pieces and fitted.settings.alignment.continues:
            before = fitted.sources[segments[i - 1].source].motion
            rotation, shift = _continued(pieces[-1], before, fitted.sources[segment.source].motion, segment.start)
        source = fitted.sources[segment.source]
        pieces.append(
            Piece(
                take=source.take,
                track=source.track,
                source_start=segment.start,
                source_stop=segment.stop,
                start=start / rate,
                stop=stop / rate,
                rotation=(float(rotation[0]), float(rotation[1]), float(rotation[2]), float(rotation[3])),
                shift=(float(shift[0]), float(shift[1]), float(shift[2])),
                mirrored=source.mirrored,
                cost=cost,
                seam=fitted.settings.continuity * gap,
                scale=placement.scale(0, 0),
            )
        )
    return pieces


def _continued(piece: Piece, before: Motion, motion: Motion, start: float) -> tuple[FloatArray, FloatArray]:
    """Rotation and shift by which a recording, from its second ``start``, goes on from where a piece leaves the body.

    ``before`` is the recording of that piece. Bodies stand on their own floor: nothing is lifted.
    """
    last, first = sample(before, [piece.source_stop], before.fps), sample(motion, [start], motion.fps)
    heading = piece.turn + heading_at(last, 0) - heading_at(first, 0)
    rotation = rot.about("y", heading)
    place = rot.rotate(np.array(piece.rotation), last.translation[0]) + piece.shift
    return rotation, on_ground(place - rot.rotate(rotation, first.translation[0]))
