"""From pieces to a motion: joined, and then held to contacts and handholds (Hsu 2004, chapter 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.control import Control
from kinetograph.methods.performance.fitted import Fitted, preference_costs
from kinetograph.methods.performance.handholds import carried_holds
from kinetograph.methods.performance.making import Recorded, make
from kinetograph.methods.performance.moments import Moment
from kinetograph.methods.performance.own_cost import STRANGE
from kinetograph.methods.performance.pieces import pieces_at_full_rate
from kinetograph.methods.performance.repetition import most_used, times_running
from kinetograph.methods.performance.rules import Demand, paid
from kinetograph.methods.performance.standing import joined_holds, standing_warnings
from kinetograph.motion import Motion, sample
from kinetograph.post.assemble import UNTOUCHED, Part
from kinetograph.post.contacts import carry, merge
from kinetograph.post.on_path import hips_of
from kinetograph.sampling import interpolate
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation


def realize(fitted: Fitted, control: Control, path: SegmentalPath, demands: Sequence[Demand] = ()) -> Synthesis:
    """The synthesis of a sequence: pieces, then the motion they join to, then the motion that meets its constraints."""
    steps = int(np.floor(control.duration * fitted.settings.rate + 1e-6))
    preferred = {**preference_costs(fitted, path, steps), **_demanded(fitted, steps, path, demands)}
    path = joined_holds(fitted, path)
    moments = [demand for demand in demands if isinstance(demand, Moment)]
    pieces = pieces_at_full_rate(fitted, control.points, control.fps, path, moments)
    fps = fitted.sources[0].motion.fps
    frames = int(np.floor(control.duration * fps + 1e-6)) + 1
    made = make(fitted, _recorded(fitted, control, pieces, path, frames))
    statistics = {"pieces": len(pieces), "pairs": path.pairs, "states": len(fitted.instances.states)}
    statistics["optimal"] = int(path.proved)
    gap = {} if np.isnan(path.gap) else {"gap": path.gap}
    repetition = {"most_used": most_used(pieces), "times_running": times_running(pieces)}
    reuse = {"reuse": path.reuse} if fitted.reuse else {}
    late = {"late": control.late} if control.late else {}
    return Synthesis(
        made.motion,
        tuple(pieces),
        cost=path.score,
        costs={
            "interpretation": sum(p.cost for p in pieces),
            "continuity": sum(p.seam for p in pieces),
            **reuse,
            **preferred,
        },
        annotations=made.annotations,
        statistics={
            **statistics,
            **gap,
            **repetition,
            **late,
            "untouched": float((made.edited < UNTOUCHED).mean()),
            "constraints_moved_mean": float(made.moved[:, 0].mean()),
            "constraints_moved_most": float(made.moved[:, 1].max()),
            **_hold_statistics(made.residuals),
        },
        warnings=(*_warnings(fitted, control), *standing_warnings(fitted, pieces), *_strange(fitted, pieces)),
        edited=made.edited,
    )


def _demanded(fitted: Fitted, steps: int, path: SegmentalPath, demands: Sequence[Demand]) -> dict[str, float]:
    """The parts of a path's score that keys and moves asked for cost, where there are such."""
    costs: dict[str, float] = {}
    for demand, cost in zip(demands, paid(fitted, path, demands, steps), strict=True):
        if isinstance(demand, Moment):
            costs["keys"] = costs.get("keys", 0.0) + cost
        elif demand.weight is not None:
            costs["moves"] = costs.get("moves", 0.0) + cost
    return costs


def _recorded(fitted: Fitted, control: Control, pieces: list[Piece], path: SegmentalPath, frames: int) -> Recorded:
    """The recordings behind the pieces, their contacts and moves, and the handholds with the control's own hands."""
    sources = [fitted.sources[fitted.segment_of(s).source] for s in path.states]
    parts = [Part(piece, source.motion, source.annotations) for piece, source in zip(pieces, sources, strict=True)]
    carried = carry((piece, source.annotations) for piece, source in zip(pieces, sources, strict=True))
    annotations = _until(control.duration, merge((*carried, *control.contacts)) if control.contacts else carried)
    recorded = Recorded(parts, annotations, (), _body_in_the_way(fitted, control, frames), frames)
    recorded = replace(recorded, path=_path(fitted, control, frames))
    partner, fps = control.partner, fitted.sources[0].motion.fps
    if partner is None or not fitted.settings.post.handholds:
        return recorded
    given = control.handholds
    if given:
        others = (note for note in annotations if note.kind != "handhold")
        annotations = (*others, *(replace(note, track="motion") for note in given))
    taken = list(zip(pieces, sources, strict=True))
    holds = carried_holds(taken, annotations, partner, frames, fps, fitted.sources if given else ())
    return replace(recorded, annotations=annotations, holds=holds)


def _path(fitted: Fitted, control: Control, frames: int) -> FloatArray | None:
    """Where the hips are to be at the result's frames, where they are brought onto their path."""
    if fitted.settings.post.onto_path is None:
        return None
    middle = control.points.mean(axis=1) if control.partner is None else hips_of(control.partner)
    return interpolate(middle, np.arange(frames) * (control.fps / fitted.sources[0].motion.fps))


def _body_in_the_way(fitted: Fitted, control: Control, frames: int) -> Motion | None:
    """The control at the result's frames, where the recordings have partners: a walker's control is the walker."""
    if control.partner is None or fitted.limits.overlap is None:
        return None
    fps = fitted.sources[0].motion.fps
    return sample(control.partner, np.arange(frames) / fps, fps)


def _warnings(fitted: Fitted, control: Control) -> tuple[str, ...]:
    warnings = fitted.settings.control_points.warnings(control.points, control.fps, fitted.speeds)
    if not control.late:
        return warnings
    return (
        f"the path is faster than the library's people can hurry, {fitted.fastest:.2f} m/s: it is followed in "
        f"space and its end is reached {control.late:.1f} s late; keep_time (--keep-time) keeps its times",
        *warnings,
    )


def _strange(fitted: Fitted, pieces: list[Piece]) -> tuple[str, ...]:
    """A warning where a control is explained far worse than the library's recordings explain each other."""
    if not fitted.own_cost:
        return ()
    times = sum(piece.cost for piece in pieces) / (pieces[-1].stop - pieces[0].start) / fitted.own_cost
    if times <= STRANGE:
        return ()
    return (
        f"the library has nothing like parts of this control: it costs {times:.1f} times what the library's takes cost "
        "each other; the motion may do something else than is right there (add recordings of such moves)",
    )


def _until(end: float, annotations: tuple[Annotation, ...]) -> tuple[Annotation, ...]:
    """Annotations without what lies after ``end`` seconds: the last piece may go on longer than the control."""
    return tuple(replace(note, stop=min(note.stop, end)) for note in annotations if note.start < end)


def _hold_statistics(residuals: FloatArray) -> dict[str, float]:
    if len(residuals) == 0:
        return {}
    median, most = (float(np.quantile(residuals, q)) for q in (0.5, 0.95))
    return {"handhold_residual_median": median, "handhold_residual_p95": most}
