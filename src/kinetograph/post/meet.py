"""Meeting poses and places exactly, by edits that fade away from them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion, heading_at
from kinetograph.post.blend import quintic_decay


@dataclass(frozen=True, eq=False)
class Waypoint:
    """The pose, place and heading that a frame of a motion is to have.

    Parameters
    ----------
    frame : int
        The frame of the motion.
    clip : Motion or None
        Holds the pose; None leaves the pose as it is.
    source : int
        The frame of the pose in the clip.
    place : complex, optional
        z + i x on the ground in metres; left as it is unless given.
    heading : float, optional
        Radians; left as it is unless given.
    offset : complex
        What is to be at the place, in metres from the root, in the frame of its heading.
    """

    frame: int
    clip: Motion | None
    source: int
    place: complex | None = None
    heading: float | None = None
    offset: complex = 0j


def bend(motion: Motion, points: list[Waypoint]) -> Motion:
    """A motion with its root path bent so that places and headings are met.

    Between two waypoints the change of heading and the shift grow with the distance that the root has moved along the
    ground, so that feet which stand still stay where they are. A waypoint without a place or heading keeps those that
    the waypoint before it leads to.

    Parameters
    ----------
    motion : Motion
    points : list of Waypoint
        In order of their frames; nothing before the first is changed.

    Returns
    -------
    Motion
    """
    for before, after in itertools.pairwise(points):
        motion = _bend_between(motion, before.frame, after)
    return motion


def _bend_between(motion: Motion, start: int, goal: Waypoint) -> Motion:
    stop = goal.frame
    done = path_share(motion, start, stop)
    root, rotations = motion.translation.copy(), motion.rotations.copy()
    if goal.heading is not None:
        now = heading_at(motion, stop)
        missing = float(np.angle(np.exp(1j * (goal.heading - now))))
        about = rot.about("y", missing * done)
        steps = np.zeros((0, 3))
        if len(root) > 1:
            steps = rot.rotate(0.5 * (about[1:] + about[:-1]), np.diff(root, axis=0))
        path = np.concatenate([root[:1], root[:1] + np.cumsum(steps, axis=0)])
        path += root[start] - path[start]
        root[start:] = np.stack([path[start:, 0], root[start:, 1], path[start:, 2]], axis=1)
        rotations[:, 0] = rot.multiply(about, rotations[:, 0])
    if goal.place is not None:
        aside = np.exp(1j * heading_at(replace(motion, rotations=rotations), stop)) * goal.offset
        gap = goal.place - aside - complex(root[stop, 2], root[stop, 0])
        root[:, 2] += gap.real * done
        root[:, 0] += gap.imag * done
    return replace(motion, translation=root, rotations=rot.normalize(rotations))


def path_share(motion: Motion, start: int, stop: int) -> FloatArray:
    """Share of the root's path on the ground from one frame to another that lies before each frame, 0 to 1 ``(F,)``.

    Parameters
    ----------
    motion : Motion
    start, stop : int
        The frames; where the root stands between them, it is the share of time.
    """
    steps = np.linalg.norm(np.diff(motion.translation[start : stop + 1, [0, 2]], axis=0), axis=1)
    if steps.sum() < 1e-3:  # it stands: there is no path to spread the edit over, only time
        steps = np.ones(stop - start)
    done = np.zeros(len(motion))
    done[start + 1 : stop + 1] = np.cumsum(steps) / steps.sum()
    done[stop:] = 1.0
    return done


def meet_poses(motion: Motion, points: list[Waypoint], decay: float) -> Motion:
    """A motion changed to meet the poses of waypoints.

    Parameters
    ----------
    motion : Motion
    points : list of Waypoint
        In order of their frames.
    decay : float
        Seconds before and after a waypoint over which its change fades; less where the next waypoint is nearer.

    Returns
    -------
    Motion
    """
    root, rotations = motion.translation.copy(), motion.rotations.copy()
    frames = np.arange(len(motion))
    stops = [point.frame for point in points]
    for i, point in enumerate(points):
        if point.clip is None:
            continue
        height, gap = _missing(motion, point)
        room_before = point.frame - stops[i - 1] if i > 0 else np.inf
        room_after = stops[i + 1] - point.frame if i + 1 < len(stops) else np.inf
        room = np.where(frames < point.frame, room_before, room_after)
        reach = np.maximum(np.minimum(decay * motion.fps, room), 1.0)
        weight, _ = quintic_decay(np.clip(abs(frames - point.frame) / reach, 0.0, 1.0))
        root[:, 1] += weight * height
        rotations = rot.multiply(rotations, rot.exp(weight[:, None, None] * gap))
    return replace(motion, translation=root, rotations=rot.normalize(rotations))


def _missing(motion: Motion, point: Waypoint) -> tuple[float, FloatArray]:
    """The height and the rotation vectors of joints, ``(J, 3)`` in their own frames, that a frame lacks.

    The heading is kept.
    """
    assert point.clip is not None
    wanted = point.clip.rotations[point.source].copy()
    now = motion.rotations[point.frame]
    angle = heading_at(motion, point.frame) - heading_at(point.clip, point.source)
    wanted[0] = rot.multiply(rot.about("y", angle), wanted[0])
    gap = rot.log(rot.multiply(rot.conjugate(now), wanted))
    height = float(point.clip.translation[point.source, 1] - motion.translation[point.frame, 1])
    return height, gap
