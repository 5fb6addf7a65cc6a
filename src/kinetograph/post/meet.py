"""Meeting poses and places exactly, by edits that fade away from them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.motion import Motion
from kinetograph.post.blend import quintic_decay


@dataclass(frozen=True, eq=False)
class Waypoint:
    """What a frame of a motion is to be. clip, source: the pose is frame ``source`` of ``clip``, or None; joints: the
    indices of those that count, None for all and the root's height. place: z + i x on the ground in metres; heading:
    radians; None leaves them as they are.
    """

    frame: int
    clip: Motion | None
    source: int
    joints: IntArray | None = None
    place: complex | None = None
    heading: float | None = None


def bend(motion: Motion, points: list[Waypoint]) -> Motion:
    """The motion's path on the ground bent so that places and headings are met.

    Between two waypoints the turn grows as the root has got on along the ground, and so does the shift: feet that
    stand still stay where they are. A waypoint without a place or heading follows the one before.
    """
    for before, after in itertools.pairwise(points):
        motion = _bend_leg(motion, before.frame, after)
    return motion


def _bend_leg(motion: Motion, start: int, goal: Waypoint) -> Motion:
    stop = goal.frame
    done = _progress(motion, start, stop)
    root, turns = motion.translation.copy(), motion.rotations.copy()
    if goal.heading is not None:
        now = float(rot.heading(turns[stop, 0]))
        missing = float(np.angle(np.exp(1j * (goal.heading - now))))
        turn = rot.about("y", missing * done)
        steps = rot.rotate(0.5 * (turn[1:] + turn[:-1]), np.diff(root, axis=0)) if len(root) > 1 else np.zeros((0, 3))
        path = np.concatenate([root[:1], root[:1] + np.cumsum(steps, axis=0)])
        path += root[start] - path[start]
        root[start:] = np.stack([path[start:, 0], root[start:, 1], path[start:, 2]], axis=1)
        turns[:, 0] = rot.multiply(turn, turns[:, 0])
    if goal.place is not None:
        gap = goal.place - complex(root[stop, 2], root[stop, 0])
        root[:, 2] += gap.real * done
        root[:, 0] += gap.imag * done
    return replace(motion, translation=root, rotations=rot.normalize(turns))


def _progress(motion: Motion, start: int, stop: int) -> FloatArray:
    """How far every frame has got on the way from ``start`` to ``stop``, 0 to 1 by the root's path on the ground."""
    steps = np.linalg.norm(np.diff(motion.translation[start : stop + 1, [0, 2]], axis=0), axis=1)
    if steps.sum() < 1e-3:  # it stands: there is no path to spread the edit over, only time
        steps = np.ones(stop - start)
    done = np.zeros(len(motion))
    done[start + 1 : stop + 1] = np.cumsum(steps) / steps.sum()
    done[stop:] = 1.0
    return done


def meet_poses(motion: Motion, points: list[Waypoint], decay: float) -> Motion:
    """The motion with the waypoints' poses met; what is missing fades in ``decay`` seconds or at the next one."""
    root, turns = motion.translation.copy(), motion.rotations.copy()
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
        turns = rot.multiply(turns, rot.exp(weight[:, None, None] * gap))
    return replace(motion, translation=root, rotations=rot.normalize(turns))


def _missing(motion: Motion, point: Waypoint) -> tuple[float, FloatArray]:
    """The height and the joints' turns, ``(J, 3)`` in their own frames, that a frame lacks; the heading stays."""
    assert point.clip is not None
    wanted = point.clip.rotations[point.source].copy()
    now = motion.rotations[point.frame]
    turn = float(rot.heading(now[0])) - float(rot.heading(wanted[0]))
    wanted[0] = rot.multiply(rot.about("y", turn), wanted[0])
    gap = rot.log(rot.multiply(rot.conjugate(now), wanted))
    height = float(point.clip.translation[point.source, 1] - motion.translation[point.frame, 1])
    if point.joints is not None:
        kept = np.zeros((len(gap), 1))
        kept[point.joints] = 1.0
        return 0.0, gap * kept
    return height, gap
