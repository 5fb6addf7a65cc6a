"""What the page asks about a walk, and about the pieces of a duet: what else one could be, and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.studio.made import bodies, clip, piece_row
from kinetograph.studio.messages import (
    AskPace,
    AskWhy,
    CandidateClip,
    CandidateRow,
    Candidates,
    ClipHeader,
    Message,
    NextBest,
    Pace,
    PieceSource,
    PlayTake,
    TakePace,
    Why,
    WhyRow,
    WithoutRow,
    blob,
)
from kinetograph.studio.project import Project, RuleRow
from kinetograph.studio.room import Room
from kinetograph.studio.searched import searched
from kinetograph.studio.sections import Answer
from kinetograph.studio.walk.model import direction, model_of

if TYPE_CHECKING:
    from kinetograph.motion import Motion


def _pace(room: Room, project: Project, message: AskPace) -> Message:
    from kinetograph.methods.performance import recorded_speeds

    fitted = model_of(project, room).fitted
    low, middle, high = np.quantile(recorded_speeds(fitted), (0.05, 0.5, 0.95)).tolist()
    takes = {source.take: source.motion for source in fitted.sources if not source.mirrored}
    rows = tuple(TakePace(name, motion.duration, _mean_speed(motion)) for name, motion in takes.items())
    stands = bool(fitted.instances.held.any())
    return Pace(message.id, fitted.speeds[0], fitted.fastest, (low, middle, high), stands, rows)


def _mean_speed(motion: Motion) -> float:
    way = np.linalg.norm(np.diff(motion.translation[:, [0, 2]], axis=0), axis=1).sum()
    return float(way / max(motion.duration, 1e-9))


def _next_best(room: Room, project: Project, message: NextBest) -> Message:
    from kinetograph.methods.performance import Rule, next_best
    from kinetograph.methods.together import settled_demands

    search = searched(project, room)
    piece, model = search.piece_at(message.time), search.model
    control, own = settled_demands(model, search.control, search.asked)
    middle = 0.5 * (max(piece.start, 0.0) + min(piece.stop, search.synthesis.motion.duration))
    second = search.synthesis.clock_at(round(middle * search.synthesis.motion.fps))
    found = next_best(model.fitted, control, second, min(max(message.count, 1), 8), own)
    rows = tuple(
        CandidateRow(
            take=each.piece.take,
            mirrored=each.piece.mirrored,
            source_start=each.piece.source_start,
            source_stop=each.piece.source_stop,
            start=each.piece.start,
            stop=each.piece.stop,
            cost=each.cost,
            interpretation=each.interpretation,
            continuity=each.continuity,
            reuse=each.reuse,
            more=each.cost - found[0].cost,
            rules=tuple(
                RuleRow(rule.start, rule.stop, rule.take, rule.source, rule.forbid)
                for rule in each.rules[len(own) :]
                if isinstance(rule, Rule)
            ),
        )
        for each in (found[0], *sorted(found[1:], key=lambda each: each.cost))
    )
    return Candidates(message.id, second, rows)


def _why(room: Room, project: Project, message: AskWhy) -> Message:
    """What else could be at a time, as ``kinetograph perform --why`` has it."""
    from kinetograph.pipeline import why_at

    answer = why_at(searched(project, room).rendered, message.time)
    drive = tuple(f"{each.name} drives {', '.join(each.joints)}" for each in answer.layers)
    reasons = answer.reasons
    if reasons is None:
        played = tuple(piece_row(piece) for piece in answer.pieces)
        return Why(message.id, message.time, (), (), answer.span, played, drive)
    rows = tuple(
        WhyRow(
            take=each.piece.take,
            mirrored=each.piece.mirrored,
            chosen=each.chosen,
            source_start=each.piece.source_start,
            source_stop=each.piece.source_stop,
            start=each.piece.start,
            stop=each.piece.stop,
            margin=each.margin,
            terms=asdict(each.terms),
            without=each.without,
        )
        for each in reasons.contenders
    )
    pieces = ((other, other.piece) for other in reasons.reversals)
    without = tuple(
        WithoutRow(other.constraint, p.take, p.mirrored, p.source_start, p.source_stop, other.saved)
        for other, p in pieces
    )
    return Why(message.id, message.time, rows, without, layers=drive)


def _candidate_clip(room: Room, project: Project, message: CandidateClip) -> bytes:
    return _clip(message.id, "candidate", searched(project, room).under(message.rules).motion)


def _piece_source(room: Room, project: Project, message: PieceSource) -> bytes:
    """The recording of a piece as it was, at the times and the place of the piece."""
    from kinetograph.motion import sample, transform

    search = searched(project, room)
    piece, fitted = search.piece_at(message.time), search.model.fitted
    mine = (s for s in fitted.sources if (s.take, s.track, s.mirrored) == (piece.take, piece.track, piece.mirrored))
    source = next(mine, None)
    if source is None:
        raise RequestError(f"the library has no take {piece.take!r} any more")
    fps = source.motion.fps
    times = piece.start + np.arange(max(round((piece.stop - piece.start) * fps), 1) + 1) / fps
    seconds = np.full(len(times), piece.source_start) if piece.held else piece.source_time(times)
    scaled = replace(source.motion, translation=source.motion.translation * [piece.scale, 1.0, piece.scale])
    ghost = transform(sample(scaled, seconds, fps), piece.rotation, piece.shift)
    return _clip(message.id, f"{piece.take}{', mirrored' if piece.mirrored else ''}", ghost, piece.start)


def _play_take(room: Room, project: Project, message: PlayTake) -> bytes:
    """A take, moved so that it begins where the path does, and facing as it goes there."""
    from kinetograph.motion import place

    sources = [s for s in model_of(project, room).fitted.sources if s.take == message.take and not s.mirrored]
    if not sources:
        raise RequestError(f"the library has no take {message.take!r}")
    motion, path = sources[0].motion, np.asarray(project.walk.path, dtype=np.float64).reshape(-1, 3)
    begin, wanted = (path[0, 1:], direction(path[:, 1:])) if len(path) > 1 else (np.zeros(2), 0.0)
    turned = place(motion, wanted - direction(motion.translation[:, [0, 2]]), np.zeros(3))
    off = begin - turned.translation[0, [0, 2]]
    return _clip(message.id, message.take, place(turned, 0.0, [off[0], 0.0, off[1]]))


def _clip(number: int, name: str, motion: Motion, start: float = 0.0) -> bytes:
    return blob(ClipHeader(number, name, start=start), clip(bodies({"motion": motion}, None), None))


ANSWERS: Mapping[type[Message], Answer] = {
    AskPace: _pace,
    NextBest: _next_best,
    AskWhy: _why,
    CandidateClip: _candidate_clip,
    PieceSource: _piece_source,
    PlayTake: _play_take,
}
"""What is answered about a walk."""
