"""From a sequence of states to a motion: full-rate durations, pieces, postprocessing."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions, on_ground
from kinetograph.learn.alignment import Placement, align
from kinetograph.learn.retiming import Span, retime
from kinetograph.learn.segmental import SegmentalPath, padded_width
from kinetograph.methods.performance.handholds import carried_holds
from kinetograph.methods.performance.segments import Segment
from kinetograph.motion import Motion, sample
from kinetograph.post.assemble import Part, constrain, edits, join_parts
from kinetograph.post.constraints import Hold, hold_residuals
from kinetograph.post.contacts import carry
from kinetograph.sampling import interpolate
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation

if TYPE_CHECKING:
    from kinetograph.methods.performance.model import PerformanceModel


def realize(
    model: PerformanceModel,
    points: FloatArray,
    fps: float,
    path: SegmentalPath,
    partner: Motion | None = None,
    told: tuple[Annotation, ...] = (),
) -> Synthesis:
    """The synthesis of a path for control points ``points``, shape ``(F, P, 3)`` at ``fps``.

    partner: the control where it is a character, whose hands are held. told: the handholds with it, if a person says;
    otherwise they are the pieces'.
    """
    method = model.method
    rate = method.fine_rate or method.rate
    duration = (len(points) - 1) / fps
    x = interpolate(points, np.arange(int(np.floor(duration * rate + 1e-6)) + 1) / rate * fps)
    borders = fine_borders(model, x, rate, path) if method.fine_rate else _coarse_borders(path)
    segments = [model.instances.segments[model.instances.states[s, 0]] for s in path.states]
    pieces = pieces_of(model, x, rate, segments, borders)
    parts = []
    for piece, segment in zip(pieces, segments, strict=True):
        source = model.sources[segment.source]
        parts.append(Part(piece, _scaled(source.motion, piece.scale), source.marks))
    out_fps = model.sources[0].motion.fps
    frames = int(np.floor(duration * out_fps + 1e-6)) + 1
    marks = _until(duration, carry((part.piece, part.annotations) for part in parts))
    holds: tuple[Hold, ...] = ()
    if partner is not None and method.post.handholds:
        taken = [(p, model.sources[s.source]) for p, s in zip(pieces, segments, strict=True)]
        if told:
            marks = (*(n for n in marks if n.kind != "handhold"), *(replace(n, track="motion") for n in told))
        holds = carried_holds(taken, marks, partner, frames, out_fps, model.sources if told else ())
    joined = join_parts(parts, out_fps, frames, method.post)
    motion = constrain(joined, marks, holds, method.post, model.joint_ranges)
    statistics = {"pieces": len(pieces), "pairs": path.pairs, "states": len(model.instances.states)}
    statistics["optimal"] = int(path.proved)
    return Synthesis(
        motion,
        tuple(pieces),
        cost=path.score,
        costs={"interpretation": sum(p.cost for p in pieces), "continuity": sum(p.seam for p in pieces)},
        annotations=marks,
        statistics={**statistics, **_moved(joined, motion), **_hold_statistics(hold_residuals(motion, holds))},
        warnings=method.control.warnings(points, fps, model.speed_range()),
        edited=edits(motion, parts),
    )


def _until(end: float, marks: tuple[Annotation, ...]) -> tuple[Annotation, ...]:
    """Annotations without what lies after ``end`` seconds: the last piece may go on longer than the control."""
    return tuple(replace(note, stop=min(note.stop, end)) for note in marks if note.start < end)


def _scaled(motion: Motion, scale: float) -> Motion:
    """The motion with its way over the ground scaled; a body keeps its size."""
    return motion if scale == 1.0 else replace(motion, translation=motion.translation * [scale, 1.0, scale])


def _moved(before: Motion, after: Motion) -> dict[str, float]:
    """How far constraints have moved the joints, in metres: the mean of all, and the most that any was."""
    distances = np.linalg.norm(joint_positions(after) - joint_positions(before), axis=-1)
    return {"constraints_moved_mean": float(distances.mean()), "constraints_moved_most": float(distances.max())}


def _hold_statistics(residuals: FloatArray) -> dict[str, float]:
    if len(residuals) == 0:
        return {}
    median, most = (float(np.quantile(residuals, q)) for q in (0.5, 0.95))
    return {"handhold_residual_median": median, "handhold_residual_p95": most}


def _coarse_borders(path: SegmentalPath) -> FloatArray:
    return np.concatenate([path.starts[:1], path.stops]).astype(np.float64)


def fine_borders(model: PerformanceModel, x: FloatArray, rate: float, path: SegmentalPath) -> FloatArray:
    """Borders, shape ``(L + 1,)`` in steps of ``rate``, of the constrained search of section 4.4.3.

    Each border between two pieces may move by less than a step of the coarse rate; the control's two ends stay.
    """
    ratio = rate / model.method.rate
    slack = int(np.ceil(ratio)) - 1
    coarse = np.round(_coarse_borders(path) * ratio).astype(np.int64)
    around = np.arange(-slack, slack + 1)
    candidates = [coarse[:1], *(border + around for border in coarse[1:-1]), coarse[-1:]]
    spans = []
    for i, state in enumerate(path.states):
        segment = model.instances.segments[model.instances.states[state, 0]]
        spans.append(_span(model, x, rate, segment, candidates[i], candidates[i + 1]))
    chosen, score = retime(spans, model.method.continuity)
    if not np.isfinite(score):
        return coarse.astype(np.float64)
    return np.array([c[i] for c, i in zip(candidates, chosen, strict=True)], dtype=np.float64)


def _span(
    model: PerformanceModel, x: FloatArray, rate: float, segment: Segment, starts: FloatArray, stops: FloatArray
) -> Span:
    """D and the placed ends of one segment over all pairs of its candidate borders."""
    width = padded_width(3 * len(model.basis))
    shape = (len(starts), len(stops))
    span = Span(np.full(shape, np.inf), np.zeros((*shape, width)), np.zeros((*shape, width)))
    for a, start in enumerate(starts):
        for b, stop in enumerate(stops):
            if stop - start < 2 or abs((stop - start) / rate - segment.duration) > model.method.stretch + 1.01 / rate:
                continue
            if max(start, 0) >= min(stop, len(x) - 1):
                continue
            cost, placement = _place(model, x, rate, segment, int(start), int(stop))
            head, tail = _ends(model, segment)
            span.costs[a, b] = cost
            span.heads[a, b] = placement.ends(0, head, model.basis_sums, width)[0]
            span.tails[a, b] = placement.ends(0, tail, model.basis_sums, width)[0]
    return span


def _ends(model: PerformanceModel, segment: Segment) -> tuple[FloatArray, FloatArray]:
    index = model.instances.places[segment]
    heads, tails = model.mixed_ends
    return heads[index][None], tails[index][None]


def _place(
    model: PerformanceModel, x: FloatArray, rate: float, segment: Segment, start: int, stop: int
) -> tuple[float, Placement]:
    """D and M of a segment over steps ``start`` to ``stop``, of which only those within the control count."""
    source = model.sources[segment.source]
    first, last = max(start, 0), min(stop, len(x) - 1)
    times = segment.start + (np.arange(first, last + 1) - start) * (segment.duration / (stop - start))
    example = interpolate(source.control, times * source.motion.fps)
    weights = model.weights(last - first + 1, rate)
    method = model.method
    costs, placement = align(method.alignment, x[None, first : last + 1], example[None], weights, method.scales)
    return float(costs[0, 0]), placement


def pieces_of(
    model: PerformanceModel, x: FloatArray, rate: float, segments: list[Segment], borders: FloatArray
) -> list[Piece]:
    """The pieces that segments become between their borders in steps of ``rate``, placed by control points ``x``."""
    width = padded_width(3 * len(model.basis))
    pieces: list[Piece] = []
    tail: FloatArray | None = None
    left = model.sources[0].motion  # the recording of the piece before
    for segment, start, stop in zip(segments, borders[:-1], borders[1:], strict=True):
        source = model.sources[segment.source]
        cost, placement = _place(model, x, rate, segment, int(start), int(stop))
        head_points, tail_points = _ends(model, segment)
        head = placement.ends(0, head_points, model.basis_sums, width)[0]
        seam = 0.0 if tail is None else model.method.continuity * float(np.sum((tail - head).astype(np.float64) ** 2))
        tail = placement.ends(0, tail_points, model.basis_sums, width)[0]
        rotation, shift = placement.transform(0, 0)
        if pieces and model.method.placing == "continued":
            rotation, shift = _continued(pieces[-1], left, source.motion, segment.start)
        left = source.motion
        pieces.append(
            Piece(
                take=source.take,
                track=source.track,
                source_start=segment.start,
                source_stop=segment.stop,
                start=float(start) / rate,
                stop=float(stop) / rate,
                rotation=(float(rotation[0]), float(rotation[1]), float(rotation[2]), float(rotation[3])),
                shift=(float(shift[0]), float(shift[1]), float(shift[2])),
                mirrored=source.mirrored,
                cost=cost,
                seam=seam,
                scale=placement.scale(0, 0),
            )
        )
    return pieces


def _continued(before: Piece, left: Motion, motion: Motion, start: float) -> tuple[FloatArray, FloatArray]:
    """Rotation and shift by which a recording, from its second ``start``, goes on from where a piece leaves the body.

    left: the recording of that piece. Bodies stand on their own floor: nothing is lifted.
    """
    last, first = sample(left, [before.source_stop], left.fps), sample(motion, [start], motion.fps)
    heading = before.turn + rot.heading(last.rotations[0, 0]) - rot.heading(first.rotations[0, 0])
    rotation = rot.about("y", float(heading))
    place = rot.rotate(np.array(before.rotation), last.translation[0]) + before.shift
    shift = on_ground(place - rot.rotate(rotation, first.translation[0]))
    return rotation, shift
