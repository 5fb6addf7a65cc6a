"""How hips sway within a stride and turn, what of that is left in a control, and which foot leads in a turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.phase import gait_phase
from kinetograph.kinematics import role_positions
from kinetograph.methods.performance import GroundPath
from kinetograph.motion import Motion
from kinetograph.signal import Signal

CALM = 0.6
"""Seconds (Gaussian) over which the sway of the hips is taken out of a control: at a stride a second, 99.9 % of it."""
SHARP, STRAIGHT = np.deg2rad(60.0), np.deg2rad(20.0)
"""Turning, radians per second: where a turn is sharp, and below which a walk is straight."""

Sway = tuple[FloatArray, FloatArray, FloatArray]
"""See `sway_by_phase`."""
Footwork = tuple[str, int, float, float, float]
"""See `turn_footwork`."""


@dataclass(frozen=True)
class CalmPath(GroundPath):
    """The hips on the ground without their sway.

    Parameters
    ----------
    seconds : float
        Over how long their middle and direction are smoothed (Gaussian).
    """

    seconds: float = CALM

    def points(self, control: Motion | Signal) -> FloatArray:
        """See `ControlPoints`."""
        pair, sigma = super().points(control), self.seconds * control.fps
        middle = gaussian_filter1d(pair.mean(axis=1), sigma, axis=0, mode="nearest")
        half = 0.5 * (pair[:, 0] - pair[:, 1])
        angle = gaussian_filter1d(np.unwrap(np.arctan2(half[:, 2], half[:, 0])), sigma, mode="nearest")
        half = 0.5 * self.hip_distance * np.stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)], axis=-1)
        return np.stack([middle + half, middle - half], axis=1)


def sway_by_phase(motion: Motion, bins: int = 24) -> Sway:
    """What the hips do within a stride where the walk is straight, relative to the smoothed path.

    Parameters
    ----------
    motion : Motion
    bins : int
        B, of the phase.

    Returns
    -------
    centres : ndarray, shape (B,)
        Phases, radians.
    mean, spread : ndarray, shape (B, 2)
        Mean and standard deviation of the sideways distance of the hips' middle, cm to the left, and of the rotation of
        their line, degrees to the left.
    """
    values, phase = _sideways(motion), gait_phase(motion)
    edges = np.linspace(-np.pi, np.pi, bins + 1)
    which = np.clip(np.digitize(phase.angle, edges) - 1, 0, bins - 1)
    straight = phase.walking & (np.abs(turning(motion)) < STRAIGHT)
    groups = [values[(which == b) & straight] for b in range(bins)]
    none = np.full(2, np.nan)
    mean = np.array([g.mean(axis=0) if len(g) else none for g in groups])
    spread = np.array([g.std(axis=0) if len(g) else none for g in groups])
    return 0.5 * (edges[1:] + edges[:-1]), mean, spread


def _sideways(motion: Motion) -> FloatArray:
    """How far the hips are left of the smoothed path, cm, and turned left of it, degrees; shape ``(F, 2)``."""
    ground, calm = GroundPath(), CalmPath()
    raw, path = ground.points(motion), calm.points(motion)
    left = (path[:, 0] - path[:, 1]) / ground.hip_distance
    aside = 100 * np.sum((raw.mean(axis=1) - path.mean(axis=1)) * left, axis=1)
    across = raw[:, 0] - raw[:, 1]
    rotation = np.arctan2(-across[:, 2], across[:, 0]) - np.arctan2(-left[:, 2], left[:, 0])
    return np.stack([aside, np.rad2deg(np.angle(np.exp(1j * rotation)))], axis=1)


def turning(motion: Motion) -> FloatArray:
    """How fast the smoothed line of the hips turns to the left, radians per second, shape ``(F,)``."""
    hips = role_positions(motion, ("left_hip", "right_hip"))
    across = hips[:, 0] - hips[:, 1]
    angle = np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))
    calm = gaussian_filter1d(angle, CALM * motion.fps, mode="nearest")
    return np.asarray(np.gradient(calm, 1 / motion.fps))


def turn_footwork(motions: Sequence[Motion]) -> list[Footwork]:
    """Real gait phase where a person turns most sharply, faster than 60 degrees per second.

    Parameters
    ----------
    motions : sequence of Motion

    Returns
    -------
    list of tuple
        Left turns, right turns, and both with the phase of right ones moved on by half a stride, which is the same
        footwork mirrored: the name, the number of turns, their mean phase in degrees, its resultant, and Rayleigh's p,
        the chance of phases so much alike if they were even.
    """
    phases: dict[str, list[float]] = {"left": [], "right": []}
    for motion in motions:
        if motion.duration < 2.0:
            continue
        phase = gait_phase(motion)
        rate = turning(motion)
        for side, signed in (("left", rate), ("right", -rate)):
            peaks, _ = find_peaks(signed, height=SHARP, distance=max(int(motion.fps), 1))
            phases[side] += [float(phase.angle[p]) for p in peaks if phase.walking[p]]
    phases["both, right mirrored"] = phases["left"] + [angle + np.pi for angle in phases["right"]]
    rows = []
    for side, angles in phases.items():
        vector = complex(np.exp(1j * np.array(angles)).mean()) if angles else 0j
        chance = float(np.exp(-len(angles) * abs(vector) ** 2)) if angles else float("nan")
        rows.append((side, len(angles), float(np.rad2deg(np.angle(vector))), abs(vector), chance))
    return rows
