"""Keys are met: a motion is moved, posed and held around them, and is as it was elsewhere."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import joint_positions, on_ground
from kinetograph.methods.keyframe.key_parts import Aim, aim_of
from kinetograph.methods.keyframe.realize import require_met, stood_at
from kinetograph.motion import Motion, cut, heading_at
from kinetograph.post.assemble import PostSettings
from kinetograph.post.blend import quintic_decay
from kinetograph.post.contacts import contacts_of
from kinetograph.post.meet import Waypoint, meet_poses, path_share
from kinetograph.post.meet_parts import Room, meet_parts
from kinetograph.post.reaching import held_feet, reach_limbs
from kinetograph.post.stepping import where_feet_stand, with_steps
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation

SHORT, LONG = 0.6, 1.0
"""Seconds before and after a key over which its edit fades: more for a larger one."""
FEET = 0.3
"""Seconds before and after a key over which its feet pass into those that stand."""
CALM = 12.0
"""m/s^2 that an edit adds at most, where there is room."""
_PEAK = 5.78  # the largest curvature of the quintic that fades
FAST = 60.0
"""m/s^2 that a hand or a foot is accelerated by at most between two keys."""


@dataclass(frozen=True, eq=False)
class Met:
    """A key of a motion.

    Parameters
    ----------
    frame : int
        The frame of the motion that meets it.
    aim : Aim
        What is met.
    """

    frame: int
    aim: Aim


def aims_of(keys: Sequence[Key], skeleton: Skeleton, fps: float) -> tuple[Met, ...]:
    """The keys as what is met by a body, at which frames.

    Parameters
    ----------
    keys : sequence of Key
        With single times, in order.
    skeleton : Skeleton
    fps : float
        Of the motion.

    Raises
    ------
    RequestError
        For a part that is out of reach, and for two keys that are too close in time, with the nearest time.
    """
    met = tuple(Met(_frame(key, fps), aim_of(key, skeleton, first=False)) for key in keys)
    for before, after in itertools.pairwise(met):
        _require_apart(before, after, fps)
    return met


def _frame(key: Key, fps: float) -> int:
    assert key.time is not None
    return round(key.time[0] * fps)


def _require_apart(before: Met, after: Met, fps: float) -> None:
    """Raise RequestError where the poses of two keys are too different for the time between them."""
    if not (before.aim.whole and after.aim.whole):
        least = 1.0 / fps
    else:
        one, other = (seen_from_root(met.aim.key) for met in (before, after))
        furthest = float(np.linalg.norm(one - other, axis=-1).max())
        least = max(float(np.sqrt(_PEAK * furthest / FAST)), 1.0 / fps)
    apart = (after.frame - before.frame) / fps
    if apart < least - 0.5 / fps:
        raise RequestError(
            f"{after.aim.key.label} is {apart:.2f} s after {before.aim.key.label}, and their poses take {least:.2f} s: "
            f"put it at {before.frame / fps + least:.2f} s or later"
        )


def seen_from_root(key: Key) -> FloatArray:
    """The joints of a key's pose as seen from the root, metres ``(J, 3)``.

    Parameters
    ----------
    key : Key
    """
    clip = cut(key.clip, key.frame, key.frame + 1)
    joints = joint_positions(clip)[0] - on_ground(clip.translation[0])
    return np.asarray(rot.rotate(rot.about("y", -heading_at(clip, 0)), joints))


def meet(
    motion: Motion, met: Sequence[Met], annotations: tuple[Annotation, ...], post: PostSettings
) -> tuple[Motion, tuple[Annotation, ...]]:
    """A motion that meets keys, and its annotations: contacts only as long as feet stand.

    Parameters
    ----------
    motion : Motion
    met : sequence of Met
        In order of their frames.
    annotations : tuple of Annotation
        Those of the motion; contacts say when feet are planted.
    post : PostSettings

    Raises
    ------
    RequestError
        Where the body does not bring a part to its place after all.
    """
    points = [_point(each) for each in met]
    rooms = _rooms(motion, met)
    motion = _placed(motion, points, rooms)
    decays = [_decay(motion, point) for point in points]
    posed = _posed(motion, points, rooms, decays)
    if post.footskate:
        annotations = with_steps(posed, annotations)
        cleaned = stood_at(posed, contacts_of(annotations), points, rooms, post.ease)
        # held feet move the keys' own poses a little: those are met again, and the feet stay
        posed = _with_feet_of(cleaned, _posed(cleaned, points, rooms, decays), points)
    for each, room in zip(met, rooms, strict=True):
        if each.aim.targets and not each.aim.whole:
            posed = meet_parts(posed, room, each.aim.targets, contacts_of(annotations), SHORT)
    require_met(posed, [each.aim for each in met], points)
    return posed, where_feet_stand(posed, annotations) if post.footskate else annotations


def _with_feet_of(held: Motion, posed: Motion, points: Sequence[Waypoint]) -> Motion:
    """A posed motion whose feet are where they are in another, and at keys where they are in their poses."""
    whole = [point.frame for point in points if point.clip is not None]
    limbs, own = held_feet(held, [], []), held_feet(posed, [], [])
    frames = np.arange(len(held))
    weights = [quintic_decay(np.minimum(np.abs(frames - at) / (FEET * held.fps), 1.0))[0] for at in whole]
    targets = []
    for limb, mine in zip(limbs, own, strict=True):
        assert limb.position is not None and limb.rotation is not None  # noqa: PT018
        assert mine.position is not None and mine.rotation is not None  # noqa: PT018
        position, rotation = limb.position.copy(), limb.rotation
        for at, weight in zip(whole, weights, strict=True):
            position += weight[:, None] * (mine.position[at] - limb.position[at])
            twist = rot.log(rot.multiply(mine.rotation[at], rot.conjugate(limb.rotation[at])))
            rotation = rot.multiply(rot.exp(weight[:, None] * twist), rotation)
        targets.append(replace(limb, position=position, rotation=rotation))
    rotations = reach_limbs(posed, targets).rotations.copy()
    rotations[whole] = posed.rotations[whole]
    return replace(posed, rotations=rotations)


def _point(met: Met) -> Waypoint:
    key, aim = met.aim.key, met.aim
    place = None if key.position is None else complex(key.position[1], key.position[0])
    return Waypoint(met.frame, key.clip if aim.whole else None, key.frame, place, key.heading, aim.offset)


def _rooms(motion: Motion, met: Sequence[Met]) -> list[Room]:
    """The frames around each key that may change: as far as its neighbours, or beyond the ends of the motion."""
    reach = round(LONG * motion.fps)
    stops = [-len(motion), *(each.frame for each in met), 2 * len(motion)]
    return [
        Room(each.frame, max(stops[i], each.frame - reach), min(stops[i + 2], each.frame + reach))
        for i, each in enumerate(met)
    ]


def _placed(motion: Motion, points: Sequence[Waypoint], rooms: Sequence[Room]) -> Motion:
    """A motion that passes through the places and headings of keys, and is where it was before and after."""
    for point, room in zip(points, rooms, strict=True):
        if point.place is None and point.heading is None:
            continue
        weight = _share(motion, point.frame, room)
        root, rotations = motion.translation.copy(), motion.rotations.copy()
        now = heading_at(motion, point.frame)
        if point.heading is not None:
            missing = float(np.angle(np.exp(1j * (point.heading - now))))
            rotations[:, 0] = rot.multiply(rot.about("y", missing * weight), rotations[:, 0])
            now = point.heading
        if point.place is not None:
            gap = point.place - np.exp(1j * now) * point.offset - complex(root[point.frame, 2], root[point.frame, 0])
            root[:, 2] += weight * gap.real
            root[:, 0] += weight * gap.imag
        motion = replace(motion, translation=root, rotations=rot.normalize(rotations))
    return motion


def _share(motion: Motion, frame: int, room: Room) -> FloatArray:
    """How much of an edit of the root each frame has: it grows and fades with the distance that the root moves."""
    last = len(motion) - 1
    first, stop = max(room.before, 0), min(room.after, last)
    weight = np.zeros(len(motion))
    if first < frame:
        weight[: frame + 1] = path_share(motion, first, frame)[: frame + 1]
    elif room.before < frame:
        weight[: frame + 1] = 1.0
    weight[frame] = 1.0
    if frame < stop:
        weight[frame:] = 1.0 - path_share(motion, frame, stop)[frame:]
    return weight


def _decay(motion: Motion, point: Waypoint) -> float:
    """Seconds over which the edit that meets a pose fades, so that it adds no more than `CALM`."""
    if point.clip is None:
        return SHORT
    now = seen_from_root(Key(motion, point.frame))
    furthest = float(np.linalg.norm(now - seen_from_root(Key(point.clip, point.source)), axis=-1).max())
    return float(np.clip(np.sqrt(_PEAK * furthest / CALM), SHORT, LONG))


def _posed(motion: Motion, points: Sequence[Waypoint], rooms: Sequence[Room], decays: Sequence[float]) -> Motion:
    """A motion with the poses of keys, each met over its own time."""
    for point, room, decay in zip(points, rooms, decays, strict=True):
        if point.clip is not None:
            ends = [Waypoint(frame, None, 0) for frame in (room.before, room.after)]
            motion = meet_poses(motion, [ends[0], point, ends[1]], decay)
    return motion
