"""From a route through recorded frames to a motion that meets every key."""

from __future__ import annotations

import itertools

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.keys import Key
from kinetograph.learn import Route, RouteSegment
from kinetograph.methods.keyframe.index import PoseIndex
from kinetograph.methods.keyframe.key_goals import pinned
from kinetograph.post.assemble import UNTOUCHED, Part, PostSettings, edits, join_parts
from kinetograph.post.contacts import carry
from kinetograph.post.floor import keep_above, recorded_lows
from kinetograph.post.footskate import clean_feet
from kinetograph.post.meet import Waypoint, bend, meet_poses
from kinetograph.skeleton import Skeleton, same_shape
from kinetograph.synthesis import Piece, Synthesis

SHAPE = 0.02
"""Metres by which the bones of a key and of the library may differ for the key's pose to be met exactly."""


def realize_route(
    index: PoseIndex,
    keys: tuple[Key, ...],
    route: Route,
    post: PostSettings,
    *,
    decay: float,
    warnings: tuple[str, ...] = (),
) -> Synthesis:
    """The motion of a route: recordings joined, bent to the pinned places, met at the keys, feet held.

    Parameters
    ----------
    index : PoseIndex
    keys : tuple of Key
    route : Route
    post : PostSettings
        How the pieces are joined.
    decay : float
        Seconds over which the edit that meets a key fades.
    warnings : tuple of str
        Those of the result.
    """
    pieces = place_pieces(index, keys[0], route)
    owners = [index.locate(segment.frame)[0] for segment in route.segments]
    examples = [index.examples[owner] for owner in owners]
    parts = [Part(p, e.motion, e.contacts) for p, e in zip(pieces, examples, strict=True)]
    motion = join_parts(parts, index.fps, round(route.clocks[-1]) + 1, post)
    contacts = carry((p, e.contacts) for p, e in zip(pieces, examples, strict=True))
    points = waypoints(keys, route.clocks, index.skeleton)
    motion = meet_poses(bend(motion, points), points, decay)
    if post.footskate:
        # held feet move the keys' own poses a little: those are met again, over a shorter time
        motion = meet_poses(clean_feet(motion, contacts, ease=post.ease), points, 0.5 * decay)
    if post.floor:
        motion = keep_above(motion, recorded_lows(motion, parts), [point.frame for point in points])
    edited = edits(motion, parts)
    seams = sum(piece.seam for piece in pieces)
    return Synthesis(
        motion,
        pieces,
        cost=route.cost,
        costs={"seams": seams, "keys": route.cost - seams},
        annotations=contacts,
        statistics=edit_statistics(edited, len(pieces), len(set(owners))),
        warnings=warnings,
        edited=edited,
        met=tuple(point.frame / index.fps for point in points),
    )


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


def waypoints(keys: tuple[Key, ...], clocks: tuple[float, ...], skeleton: Skeleton) -> list[Waypoint]:
    """The keys as frames of the result; a key of another skeleton pins no more than its place and heading.

    Parameters
    ----------
    keys : tuple of Key
    clocks : tuple of float
        The frame at which each is met.
    skeleton : Skeleton
        That of the result.
    """
    points = []
    for number, (key, clock) in enumerate(zip(keys, clocks, strict=True)):
        place, heading = pinned(key, first=number == 0)
        pose, joints = None, None
        if same_shape(key.clip.skeleton, skeleton, tolerance=SHAPE):
            pose = key.clip
            joints = None if key.roles is None else np.array([skeleton.landmark(r).joint for r in key.roles])
        points.append(Waypoint(round(clock), pose, key.frame, joints, place, heading))
    return points
