"""From a route through recorded frames to a motion that meets every key."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import UnmetError
from kinetograph.keys import Key
from kinetograph.learn import Route, RouteSegment
from kinetograph.methods.keyframe.index import PoseIndex
from kinetograph.methods.keyframe.key_goals import pinned
from kinetograph.methods.keyframe.key_parts import Aim, out_of_reach
from kinetograph.methods.keyframe.quality import Quality, quality_of
from kinetograph.motion import Motion, cut
from kinetograph.post.assemble import UNTOUCHED, Part, PostSettings, edits, join_parts
from kinetograph.post.contacts import carry
from kinetograph.post.floor import keep_above, recorded_lows
from kinetograph.post.footskate import clean_feet
from kinetograph.post.meet import Waypoint, bend, meet_poses
from kinetograph.post.meet_parts import Room, meet_parts, stand_at
from kinetograph.post.part_targets import are_met, misses
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation


def realize_route(
    index: PoseIndex,
    aims: tuple[Aim, ...],
    route: Route,
    post: PostSettings,
    *,
    decay: float,
    warnings: tuple[str, ...] = (),
) -> tuple[Synthesis, Quality]:
    """The motion of a route: recordings joined, bent to the pinned places, met at the keys, feet held.

    Parameters
    ----------
    index : PoseIndex
    aims : tuple of Aim
        What is to be met at each key.
    route : Route
    post : PostSettings
        How the pieces are joined.
    decay : float
        Seconds over which the edit that meets a key fades.
    warnings : tuple of str
        Those of the result.

    Raises
    ------
    RequestError
        Where the body does not bring a part to its place after all.
    """
    pieces = place_pieces(index, aims[0].key, route)
    owners = [index.locate(segment.frame)[0] for segment in route.segments]
    examples = [index.examples[owner] for owner in owners]
    parts = [Part(p, e.motion, e.contacts) for p, e in zip(pieces, examples, strict=True)]
    contacts = carry((p, e.contacts) for p, e in zip(pieces, examples, strict=True))
    points = waypoints(aims, route.clocks)
    motion = join_parts(parts, index.fps, round(route.clocks[-1]) + 1, post)
    motion = _through(motion, aims, points, contacts, post, decay)
    if post.floor:
        motion = keep_above(motion, recorded_lows(motion, parts), [point.frame for point in points])
    require_met(motion, aims, points)
    edited = edits(motion, parts)
    seams = sum(piece.seam for piece in pieces)
    quality = quality_of(motion, contacts, list(zip(pieces, owners, strict=True)), index.examples, index.ordinary)
    statistics = {**edit_statistics(edited, len(pieces), len(set(owners))), **quality.statistics()}
    result = Synthesis(
        motion,
        pieces,
        cost=route.cost,
        costs={"seams": seams, "keys": route.cost - seams},
        annotations=contacts,
        statistics=statistics,
        warnings=warnings,
        edited=edited,
        met=tuple(point.frame / index.fps for point in points),
    )
    return result, quality


def _through(
    motion: Motion,
    aims: tuple[Aim, ...],
    points: list[Waypoint],
    contacts: tuple[Annotation, ...],
    post: PostSettings,
    decay: float,
) -> Motion:
    """A motion bent to the places of keys, and changed to meet their poses and parts, feet held."""
    motion = meet_poses(bend(motion, points), points, decay)
    if post.footskate:
        # held feet move the keys' own poses a little: those are met again, over a shorter time
        around = rooms(points, len(motion))
        motion = meet_poses(stood_at(motion, contacts, points, around, post.ease), points, 0.5 * decay)
    for aim, room in zip(aims, rooms(points, len(motion)), strict=True):
        if aim.targets and not aim.whole:
            motion = meet_parts(motion, room, aim.targets, contacts, decay)
    return motion


def stood_at(
    motion: Motion, contacts: tuple[Annotation, ...], points: Sequence[Waypoint], around: Sequence[Room], ease: float
) -> Motion:
    """A motion with planted feet that stand still, at keys where the keys have them.

    Parameters
    ----------
    motion : Motion
        That meets the keys' poses.
    contacts : tuple of Annotation
    points : sequence of Waypoint
        The keys.
    around : sequence of Room
        The frames around each of them that may change.
    ease : float
        Seconds over which the correction of a foot grows and fades.
    """
    cleaned = clean_feet(motion, contacts, ease=ease)
    for point, room in zip(points, around, strict=True):
        if point.clip is not None:
            pose = cut(motion, point.frame, point.frame + 1)
            cleaned = stand_at(cleaned, room, pose, contacts, ease)
    return cleaned


def rooms(points: list[Waypoint], frames: int) -> list[Room]:
    """The frames around each waypoint up to its neighbours, or beyond the ends of the motion."""
    stops = [-frames, *(point.frame for point in points), 2 * frames]
    return [Room(point.frame, stops[i], stops[i + 2]) for i, point in enumerate(points)]


def require_met(motion: Motion, aims: Sequence[Aim], points: Sequence[Waypoint]) -> None:
    """Raise RequestError where a part is not where it is to be at a key.

    Parameters
    ----------
    motion : Motion
    aims : sequence of Aim
    points : sequence of Waypoint
        The frames of the keys.
    """
    for aim, point in zip(aims, points, strict=True):
        if aim.targets:
            apart, twisted = misses(cut(motion, point.frame, point.frame + 1), aim.targets)
            if not are_met(apart, twisted).all():
                what = out_of_reach(aim.key.label, motion.skeleton, aim.targets, apart[0], twisted[0])
                raise UnmetError(what, aim.key.label)


def edit_statistics(edited: FloatArray, pieces: int, examples: int) -> dict[str, float]:
    """Figures of a result.

    Parameters
    ----------
    edited : ndarray, shape (F,)
        Metres, see `kinetograph.synthesis.Synthesis`.
    pieces, examples : int
        How many there are.
    """
    return {
        "frames": len(edited),
        "pieces": pieces,
        "examples": examples,
        "untouched": float((edited < UNTOUCHED).mean()),
        "untouched below": UNTOUCHED,
        "mean edit": float(edited.mean()),
        "furthest edit": float(edited.max()),
    }


def place_pieces(index: PoseIndex, first: Key, route: Route) -> tuple[Piece, ...]:
    """Pieces on the result's time line, one per segment of the route, each placed where the one before leads.

    Parameters
    ----------
    index : PoseIndex
    first : Key
        The first key, where the result begins.
    route : Route
    """
    borders = [*(segment.step for segment in route.segments), route.passed[-1]]
    times = np.interp(borders, route.passed, np.array(route.clocks) / index.fps)
    spans = list(itertools.pairwise(times.tolist()))
    lengths = np.diff(borders).tolist()
    placed = zip(route.segments, lengths, spans, _placements(index, first, route), strict=True)
    return tuple(_piece(index, segment, length, span, placement) for segment, length, span, placement in placed)


def _placements(index: PoseIndex, first: Key, route: Route) -> list[tuple[complex, complex]]:
    """For each segment the rotation and shift from its recording's ground to that of the result."""
    facing, ground = index.features.facing, index.features.ground
    place, heading = pinned(first, first=True)
    assert place is not None
    assert heading is not None
    start = route.segments[0].frame
    rotation = np.exp(1j * heading) / facing[start]
    shift = place - rotation * ground[start]
    placements = [(rotation, shift)]
    for before, after in itertools.pairwise(route.segments):
        if after.edge >= 0:
            left = before.frame + after.step - before.step
            at = rotation * ground[left] + shift
            rotation = rotation * facing[left] / facing[after.frame]
            shift = at - rotation * ground[after.frame]
        placements.append((rotation, shift))
    return placements


def path_ends(index: PoseIndex, aims: tuple[Aim, ...], route: Route) -> list[complex]:
    """Where a route is at each key before it is bent to that key's place, but bent to those before, z + i x in metres.

    Parameters
    ----------
    index : PoseIndex
    aims : tuple of Aim
        What is to be met at each key.
    route : Route
    """
    facing, ground = index.features.facing, index.features.ground
    placements = _placements(index, aims[0].key, route)
    ends, rotation, shift = list[complex](), 1.0 + 0j, 0j  # what bending has done so far
    for step, aim in zip(route.passed, aims, strict=True):
        owner = max(i for i, segment in enumerate(route.segments) if segment.step <= max(step - 1, 0))
        segment, placement = route.segments[owner], placements[owner]
        frame = segment.frame + step - segment.step
        own = placement[0] * ground[frame] + placement[1]
        ahead = rotation * placement[0] * facing[frame]
        end = rotation * own + shift + ahead * aim.offset
        ends.append(end)
        place, heading = pinned(aim.key, first=len(ends) == 1)
        if heading is not None:
            rotation = np.exp(1j * heading) / (placement[0] * facing[frame])
        root = end if place is None else place
        root -= rotation * placement[0] * facing[frame] * aim.offset
        shift = root - rotation * own
    return ends


def _piece(
    index: PoseIndex,
    segment: RouteSegment,
    length: int,
    span: tuple[float, float],
    placement: tuple[complex, complex],
) -> Piece:
    """A segment of ``length`` frames as a piece of the result, from second to second."""
    owner, frame = index.locate(segment.frame)
    example, (rotation, shift) = index.examples[owner], placement
    w, x, y, z = (float(v) for v in rot.about("y", float(np.angle(rotation))))
    return Piece(
        example.take,
        example.track,
        frame / index.fps,
        (frame + length) / index.fps,
        *span,
        (w, x, y, z),
        (float(shift.imag), 0.0, float(shift.real)),
        example.mirrored,
        seam=float(index.graph.cost[segment.edge]) if segment.edge >= 0 else 0.0,
    )


def waypoints(aims: tuple[Aim, ...], clocks: tuple[float, ...]) -> list[Waypoint]:
    """The keys as frames of the result; a key of another skeleton pins no more than its place and heading.

    Parameters
    ----------
    aims : tuple of Aim
        What is to be met at each key.
    clocks : tuple of float
        The frame at which each is met.
    """
    points = []
    for number, (aim, clock) in enumerate(zip(aims, clocks, strict=True)):
        place, heading = pinned(aim.key, first=number == 0)
        pose = aim.key.clip if aim.whole else None
        points.append(Waypoint(round(clock), pose, aim.key.frame, place, heading, aim.offset))
    return points
