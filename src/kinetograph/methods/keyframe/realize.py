"""From a walk through recorded frames to a motion that meets every key."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.keys import Key
from kinetograph.learn.goals import Walk
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.search import SearchModel, pinned
from kinetograph.post.assemble import Part, PostSettings, edits, join_parts
from kinetograph.post.contacts import carry
from kinetograph.post.footskate import clean_feet
from kinetograph.post.meet import Waypoint, bend, meet_poses
from kinetograph.skeleton import same_shape
from kinetograph.synthesis import Piece, Synthesis

UNTOUCHED = 0.01
"""Metres of mean joint distance from the recording below which a frame counts as untouched."""


def realize_walk(
    model: SearchModel, keys: tuple[Key, ...], walk: Walk, post: PostSettings, notes: tuple[str, ...]
) -> Synthesis:
    """The motion of a walk: recordings joined, bent to the pinned places, met at the keys, feet held."""
    fps = model.fps
    pieces, examples = place_pieces(model, keys, walk)
    parts = [_part(piece, model.examples[number]) for piece, number in zip(pieces, examples, strict=True)]
    frames = round(walk.clocks[-1]) + 1
    motion = join_parts(parts, fps, frames, post)
    contacts = carry((part.piece, part.annotations) for part in parts)
    points = waypoints(model, keys, walk)
    motion = meet_poses(bend(motion, points), points, model.settings.decay)
    if post.footskate:
        # held feet move the keys' own poses a little: those are met again, over a shorter time
        motion = meet_poses(clean_feet(motion, contacts, ease=post.ease), points, 0.5 * model.settings.decay)
    edited = edits(motion, parts)
    return Synthesis(
        motion,
        pieces,
        cost=walk.cost,
        costs={"seams": sum(p.seam for p in pieces), "keys": walk.cost - sum(p.seam for p in pieces)},
        annotations=contacts,
        statistics={
            "frames": frames,
            "pieces": len(pieces),
            "examples": len(set(examples)),
            "untouched": float((edited < UNTOUCHED).mean()),
            "untouched below": UNTOUCHED,
            "mean edit": float(edited.mean()),
        },
        warnings=notes,
        edited=edited,
    )


def _part(piece: Piece, example: Example) -> Part:
    return Part(piece, example.motion, example.contacts)


def place_pieces(model: SearchModel, keys: tuple[Key, ...], walk: Walk) -> tuple[tuple[Piece, ...], list[int]]:
    """Pieces on the result's time line, each placed where the one before it leads, and their examples."""
    fps = model.fps
    borders = [*(stay.step for stay in walk.stays), walk.passed[-1]]
    times = np.interp(borders, walk.passed, np.array(walk.clocks) / fps)
    pieces: list[Piece] = []
    examples: list[int] = []
    place, heading = pinned(keys[0], first=True)
    assert place is not None
    assert heading is not None
    facing, ground = model.features.facing, model.features.ground
    turn = np.exp(1j * heading) / facing[walk.stays[0].frame]
    shift = place - turn * ground[walk.stays[0].frame]
    for i, stay in enumerate(walk.stays):
        length = borders[i + 1] - borders[i]
        if stay.edge >= 0:
            left = walk.stays[i - 1].frame + stay.step - walk.stays[i - 1].step
            at, turned = turn * ground[left] + shift, turn * facing[left]
            turn = turned / facing[stay.frame]
            shift = at - turn * ground[stay.frame]
        number, frame = model.locate(stay.frame)
        example = model.examples[number]
        w, x, y, z = (float(v) for v in rot.about("y", float(np.angle(turn))))
        pieces.append(
            Piece(
                example.take,
                example.track,
                frame / fps,
                (frame + length) / fps,
                float(times[i]),
                float(times[i + 1]),
                (w, x, y, z),
                (float(shift.imag), 0.0, float(shift.real)),
                example.mirrored,
                seam=float(model.graph.cost[stay.edge]) if stay.edge >= 0 else 0.0,
            )
        )
        examples.append(number)
    return tuple(pieces), examples


def waypoints(model: SearchModel, keys: tuple[Key, ...], walk: Walk) -> list[Waypoint]:
    """The keys as frames of the result, on the library's skeleton; a key of another one pins no more than its place."""
    skeleton = model.examples[0].motion.skeleton
    points = []
    for number, (key, clock) in enumerate(zip(keys, walk.clocks, strict=True)):
        place, heading = pinned(key, first=number == 0)
        pose = None
        joints = None
        if same_shape(key.clip.skeleton, skeleton, tolerance=0.02):
            pose = key.clip
            joints = None if key.roles is None else np.array([skeleton.landmark(r).joint for r in key.roles])
        points.append(Waypoint(round(clock), pose, key.frame, joints, place, heading))
    return points
