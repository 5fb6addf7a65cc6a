"""Poses of an armature become keys, and a motion goes through them."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np

from kinetograph.keys import Key, key_at
from kinetograph.library import Library
from kinetograph.methods.bodies import Bodies, skeleton_like
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel, TimedSearch
from kinetograph.motion import Motion, cut, heading_at, sample
from kinetograph.pipeline import fit_keyframe, inbetween_with
from kinetograph.post import Waypoint, bend, meet_poses, retarget
from kinetograph.service.bodies import Moving, motion_of
from kinetograph.service.job import Job
from kinetograph.service.recordings import Recordings
from kinetograph.service.results import Made, Output, made_of, own_body, worn
from kinetograph.synthesis import Synthesis

_DECAY = 0.5  # seconds over which what a body lacks of a key fades


class Pose(msgspec.Struct, forbid_unknown_fields=True):
    """A key: a pose of the motion that comes with it.

    Parameters
    ----------
    second : float
        Of the motion.
    time : float or (float, float), optional
        Seconds after the first key, exactly or between two; free unless given.
    placed : bool
        Whether the root's place on the ground is that of the pose.
    facing : bool
        Whether the root's heading is that of the pose.
    moving : bool
        Whether the pose is passed through as fast as in the motion.
    name : str
    """

    second: float
    time: float | tuple[float, float] | None = None
    placed: bool = True
    facing: bool = True
    moving: bool = False
    name: str = ""


class Held(msgspec.Struct, forbid_unknown_fields=True):
    """A span of an earlier result that stays as it is.

    Parameters
    ----------
    result : str
        What the result is called.
    start, stop : float
        Its seconds.
    """

    result: str
    start: float
    stop: float


class Inbetween(Output, forbid_unknown_fields=True, kw_only=True):
    """A motion through poses.

    Parameters
    ----------
    recordings : Recordings
    motion : Moving
        Holds the poses.
    keys : tuple of Pose
    alternatives : int
        How many motions.
    moves : tuple of str
        Go by way of these; see `TimedSearch`.
    force_timing : bool
        Make motion that is worse than the recordings, with a warning.
    held : Held, optional
    """

    recordings: Recordings
    motion: Moving
    keys: tuple[Pose, ...]
    alternatives: int = 1
    moves: tuple[str, ...] = ()
    force_timing: bool = False
    held: Held | None = None


class Results(msgspec.Struct):
    """Results, the best first.

    Parameters
    ----------
    made : tuple of Made
    """

    made: tuple[Made, ...]


def inbetween(asked: Inbetween, job: Job) -> Results:
    """Motions through the poses of an armature, exact on its own body."""
    library = asked.recordings.opened(job)
    theirs = motion_of(asked.motion)
    model = _model(asked, library, skeleton_like(library, theirs.skeleton), job)
    output = msgspec.structs.replace(asked, body=asked.body or asked.motion.body)
    own = model.examples[0].motion.skeleton
    body = own_body(output.body, own)
    poses = replace(theirs, skeleton=own) if body is None else retarget(theirs, own).motion
    keys = tuple(_key(pose, poses, number) for number, pose in enumerate(asked.keys, start=1))
    results = []
    for synthesis, met in _found(asked, model, keys, job):
        frames = _frames(asked.keys, met, asked.fps or synthesis.motion.fps)
        motion = worn(_timed(synthesis.motion, frames, met, asked.fps), body, None)
        motion = _exact(motion, _waypoints(asked, frames, motion.fps, theirs), theirs)
        results.append(made_of(replace(synthesis, met=met), motion, output, job.warm.keep(synthesis)))
    return Results(tuple(results))


def _model(asked: Inbetween, library: Library, like: str, job: Job) -> KeyframeModel:
    chosen = asked.recordings
    search = TimedSearch(moves=asked.moves, force_timing=asked.force_timing)
    method = KeyframeControl(solver=search, mirror=chosen.mirror, bodies=Bodies(like))
    return job.warm.fitted(library, method, lambda: fit_keyframe(method, library, note=job.note))


def _key(pose: Pose, poses: Motion, number: int) -> Key:
    """A key of the method: the pose of a motion on the library's body."""
    label = pose.name or f"key {number}"
    time = (pose.time, pose.time) if isinstance(pose.time, float | int) else pose.time
    key = key_at(poses, min(pose.second, poses.duration), time=time, label=label)
    x, _, z = key.clip.translation[key.frame].tolist()
    position = (x, z) if pose.placed else None
    heading = heading_at(key.clip, key.frame) if pose.facing else None
    key = replace(key, position=position, heading=heading)
    return key if pose.moving else replace(key, clip=cut(key.clip, key.frame, key.frame + 1), frame=0)


def _found(
    asked: Inbetween, model: KeyframeModel, keys: tuple[Key, ...], job: Job
) -> list[tuple[Synthesis, tuple[float, ...]]]:
    """Motions through keys, and when each key is met."""
    if asked.held is None:
        found = inbetween_with(model, keys, asked.alternatives)
        return [(synthesis, synthesis.met) for synthesis in found]
    earlier, low, high = job.warm.result(asked.held.result), asked.held.start, asked.held.stop
    times = [None if key.time is None else 0.5 * sum(key.time) for key in keys]
    inside = [time is not None and low - 1e-6 <= time <= high + 1e-6 for time in times]
    free = [key for key, within in zip(keys, inside, strict=True) if not within]
    found = model.alternatives_around(earlier, (low, high), free, asked.alternatives)
    out = []
    for synthesis in found:
        rest = iter([t for t in synthesis.met if not low - 1e-6 <= t <= high + 1e-6])
        met = [time if within else next(rest) for time, within in zip(times, inside, strict=True)]
        out.append((synthesis, tuple(float(time or 0.0) for time in met)))
    return out


def _frames(keys: tuple[Pose, ...], met: tuple[float, ...], fps: float) -> list[int]:
    """The frame of the result at which each key is met: as asked for, or nearest to when it was met."""
    frames: list[int] = []
    for key, time in zip(keys, met, strict=True):
        asked = key.time if isinstance(key.time, float | int) else time
        frames.append(max(round(asked * fps), frames[-1] + 1 if frames else 0))
    return frames


def _timed(motion: Motion, frames: list[int], met: tuple[float, ...], fps: float | None) -> Motion:
    """A motion at another rate, in which keys are met at whole frames: its times change by half a frame at most."""
    rate = fps or motion.fps
    times = np.interp(np.arange(frames[-1] + 1) / rate, np.array(frames) / rate, met)
    return sample(motion, np.clip(times, 0.0, motion.duration), rate)


def _waypoints(asked: Inbetween, frames: list[int], fps: float, poses: Motion) -> list[Waypoint]:
    """What a result is to meet exactly: its keys, and every frame of a span that is held."""
    wanted = {frame: (key.second, key.placed, key.facing) for frame, key in zip(frames, asked.keys, strict=True)}
    if asked.held is not None:
        first, last = round(asked.held.start * fps), round(asked.held.stop * fps)
        wanted |= {f: (asked.keys[0].second + f / fps, True, True) for f in range(max(first, 0), last + 1)}
    points = []
    for frame, (second, placed, facing) in sorted(wanted.items()):
        source = min(round(second * poses.fps), len(poses) - 1)
        x, _, z = poses.translation[source].tolist()
        place = complex(z, x) if placed else None
        points.append(Waypoint(frame, poses, source, place, heading_at(poses, source) if facing else None))
    return [point for point in points if point.frame <= frames[-1]]


def _exact(motion: Motion, points: list[Waypoint], poses: Motion) -> Motion:
    """A motion that meets poses of its own body exactly, by edits that fade away from them."""
    return meet_poses(bend(replace(motion, skeleton=poses.skeleton), points), points, _DECAY)
