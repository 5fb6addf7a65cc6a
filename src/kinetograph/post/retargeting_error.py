"""What it costs to bring a motion over to another skeleton: how far joints are from where they were, and how feet hold.

Places are compared on the new skeleton's scale: the source's, along the ground by the factor of the root path and in
height by that of the legs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.post.rest_pose import leg_length
from kinetograph.post.retargeting import Retargeted
from kinetograph.segmentation import CONTACT_ROLES, detect_contacts

COMPARED = tuple(f"{side}_{part}" for part in ("elbow", "hand", "knee", "foot") for side in ("left", "right"))
"""The roles whose places are compared, where both skeletons have them: joints that all skeletons have at one place."""


@dataclass(frozen=True)
class RetargetingError:
    """What it cost to bring motions over.

    Parameters
    ----------
    joints : mapping of str to float
        By role, metres that joints are from where they were in the mean.
    feet, feet_before : float
        Metres per second that planted feet move in the mean, and did before; not a number where none is planted.
    frames : int
    """

    joints: Mapping[str, float]
    feet: float
    feet_before: float
    frames: int

    @property
    def mean(self) -> float:
        """Metres, the mean of all roles."""
        return float(np.mean(list(self.joints.values())))


def retargeting_error(source: Motion, made: Retargeted) -> RetargetingError:
    """What it cost to bring a motion over.

    Parameters
    ----------
    source : Motion
    made : Retargeted
        The same motion on another skeleton.

    Returns
    -------
    RetargetingError
    """
    roles = [role for role in COMPARED if role in source.skeleton.roles and role in made.motion.skeleton.roles]
    rise = leg_length(made.motion.skeleton) / leg_length(source.skeleton)
    before, after = role_positions(source, roles), role_positions(made.motion, roles)
    before = before * np.array([made.scale, rise, made.scale])
    before[..., 1] += made.floor * (1.0 - rise)
    off = np.linalg.norm(before - after, axis=-1).mean(axis=0)
    planted = _planted(source)
    return RetargetingError(
        dict(zip(roles, off.tolist(), strict=True)),
        _speed(made.motion, planted),
        _speed(source, planted),
        len(source),
    )


def pooled(errors: Iterable[RetargetingError]) -> RetargetingError:
    """Several as one, in which each counts as it has frames."""
    errors = tuple(errors)
    roles = [role for role in COMPARED if all(role in error.joints for error in errors)]
    frames = np.array([error.frames for error in errors], dtype=np.float64)
    return RetargetingError(
        {role: _mean([error.joints[role] for error in errors], frames) for role in roles},
        _mean([error.feet for error in errors], frames),
        _mean([error.feet_before for error in errors], frames),
        int(frames.sum()),
    )


def _mean(values: list[float], frames: FloatArray) -> float:
    known = np.isfinite(values)
    return float(np.average(np.array(values)[known], weights=frames[known])) if known.any() else float("nan")


def _planted(motion: Motion) -> list[tuple[str, int, int]]:
    """Points of feet that are planted, and from which frame up to which."""
    fps = motion.fps
    return [(note.label, round(note.start * fps), round(note.stop * fps) + 1) for note in detect_contacts(motion)]


def _speed(motion: Motion, planted: list[tuple[str, int, int]]) -> float:
    """Metres per second that planted points of feet move along the ground in the mean."""
    roles = [role for role in CONTACT_ROLES if role in motion.skeleton.roles]
    places = dict(zip(roles, np.moveaxis(on_ground(role_positions(motion, roles)), 1, 0), strict=True))
    moved = [
        np.linalg.norm(np.diff(places[role][start:stop], axis=0), axis=-1) * motion.fps
        for role, start, stop in planted
        if role in places
    ]
    speeds = np.concatenate([np.zeros(0), *moved])
    return float(speeds.mean()) if len(speeds) else float("nan")
