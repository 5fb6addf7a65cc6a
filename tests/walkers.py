"""A stick figure that walks on sinusoids: motion whose plants, speeds and headings are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark, Skeleton

HIP_HEIGHT, THIGH, SHIN, ANKLE = 0.86, 0.44, 0.44, 0.08
_LEG = (
    ("hip", (0.1, 0.0, 0.0)),
    ("knee", (0.0, -THIGH, 0.0)),
    ("foot", (0.0, -SHIN, 0.0)),
    ("toe", (0.0, -0.05, 0.14)),
)
_ARM = (("shoulder", (0.2, 0.5, 0.0)), ("elbow", (0.0, -0.3, 0.0)), ("hand", (0.0, -0.25, 0.0)))


def stick_figure(scale: float = 1.0) -> Skeleton:
    """Fifteen joints that face +z, with a role each."""
    names, parents, offsets = ["hips"], [-1], [(0.0, 0.0, 0.0)]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for limb in (_LEG, _ARM):
            parent = 0
            for part, (x, y, z) in limb:
                names.append(f"{side}_{part}")
                parents.append(parent)
                offsets.append((sign * x, y, z))
                parent = len(names) - 1
    roles = {name: Landmark(joint) for joint, name in enumerate(names)}
    return Skeleton(tuple(names), np.array(parents), scale * np.array(offsets), roles=roles)


def walk(
    duration: float = 4.0,
    *,
    fps: float = 30.0,
    speed: npt.ArrayLike = 1.0,
    turn_rate: npt.ArrayLike = 0.0,
    period: float = 1.0,
    plant: float = 0.6,
) -> Motion:
    """A walk from the origin towards +z at ``speed`` m/s, turning left at ``turn_rate`` rad/s, both may vary, ``(F,)``.

    The left foot is planted while the phase t / period is within [0, plant) of a cycle, the right one half a cycle
    later. On a straight walk at a constant speed a planted foot stands still.
    """
    times = np.arange(round(duration * fps) + 1) / fps
    speed, turn_rate = np.broadcast_to(speed, times.shape), np.broadcast_to(turn_rate, times.shape)
    heading = _integrate(turn_rate, fps)
    forward = np.stack([np.sin(heading), np.zeros_like(heading), np.cos(heading)], axis=1)
    translation = _integrate(speed[:, None] * forward, fps) + np.array([0.0, HIP_HEIGHT, 0.0])
    skeleton = stick_figure()
    rotations = rot.identity(len(times), len(skeleton))
    rotations[:, 0] = rot.about("y", heading)
    for side, later in (("left", 0.0), ("right", 0.5)):
        phase = (times / period + later) % 1.0
        hip, knee, foot, shoulder = (skeleton.index(f"{side}_{part}") for part in ("hip", "knee", "foot", "shoulder"))
        bend_hip, bend_knee = _leg_angles(*_ankle(phase, speed * period, plant))
        rotations[:, hip] = rot.about("x", bend_hip)
        rotations[:, knee] = rot.about("x", bend_knee)
        rotations[:, foot] = rot.about("x", -bend_hip - bend_knee)
        rotations[:, shoulder] = rot.about("x", 0.4 * np.sin(2 * np.pi * phase))
    return Motion(skeleton, translation, rotations, fps)


def slide(motion: Motion, joint: str, path: FloatArray) -> Motion:
    """The motion with one joint moved by ``path``, shape ``(F, 3)`` metres in the frame of its parent."""
    bones = np.broadcast_to(motion.skeleton.offsets, (len(motion), len(motion.skeleton), 3)).copy()
    bones[:, motion.skeleton.index(joint)] += path
    return replace(motion, bones=bones)


def _integrate(rate: FloatArray, fps: float) -> FloatArray:
    steps = 0.5 * (rate[1:] + rate[:-1]) / fps
    return np.concatenate([np.zeros((1, *rate.shape[1:])), np.cumsum(steps, axis=0)])


def _ankle(phase: FloatArray, stride: FloatArray, plant: float) -> tuple[FloatArray, FloatArray]:
    """Forward and downward distance in metres of the ankle from the hip: back evenly on the ground, forth through air.

    The swing leaves and meets the ground at the speed of the ground.
    """
    u = np.clip((phase - plant) / (1 - plant), 0.0, 1.0)
    slope = -(1 - plant) / plant  # of the stance, in the swing's own time and in units of its length
    hermite = -0.5 + u**2 * (3 - 2 * u) + slope * u * (1 - u) * (1 - 2 * u)
    forth = np.where(phase < plant, 0.5 - phase / plant, hermite)
    lift = 0.12 * np.sin(np.pi * u) ** 2
    return forth * stride * plant, HIP_HEIGHT - ANKLE - lift


def _leg_angles(forth: FloatArray, down: FloatArray) -> tuple[FloatArray, FloatArray]:
    reach = np.hypot(forth, down)
    knee = np.pi - np.arccos((THIGH**2 + SHIN**2 - reach**2) / (2 * THIGH * SHIN))
    hip = np.arccos((THIGH**2 + reach**2 - SHIN**2) / (2 * THIGH * reach))
    return -np.arctan2(forth, down) - hip, knee
