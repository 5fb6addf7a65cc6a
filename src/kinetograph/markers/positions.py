"""A skeleton's motion from the positions of its joints, by the inverse kinematics that markers use."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import forward, joint_positions
from kinetograph.markers.alignment import aligned
from kinetograph.markers.solver import Solver
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_ROUNDS = 4  # how often the shape of segments with several bones is measured
_HINGES = {"elbow": (9.0, 9.0, 0.3), "ankle": (9.0, 0.6, 0.6)}  # radians, about x, y, z; see the solver's


@dataclass(frozen=True, eq=False)
class PositionsFit:
    """A motion fitted to positions of joints.

    Parameters
    ----------
    motion : Motion
        With constant bones.
    misses : ndarray, shape (F, J)
        Metres from the positions given to those of the motion; NaN where none is given.
    """

    motion: Motion
    misses: FloatArray


def fit_positions(positions: FloatArray, template: Skeleton, fps: float) -> PositionsFit:
    """The motion of a skeleton whose joints are at given positions, as near as constant bones allow.

    Parameters
    ----------
    positions : ndarray, shape (F, J, 3)
        Metres; NaN where one is not known.
    template : Skeleton
        Its rest pose gives the bones' directions; their lengths are the positions' own.
    fps : float

    Returns
    -------
    PositionsFit

    Raises
    ------
    RequestError
        Hips are never seen with the joints next to them.

    Notes
    -----
    Bones are as long as in the median frame. A bone's own twist, which positions do not show, is that of the bone above
    and, at knees and elbows, what makes them hinges.
    """
    every = np.arange(len(template))
    nowhere = np.zeros((len(template), 3))
    skeleton = Skeleton(template.names, template.parents, _sized(template.offsets, template, positions))
    for _ in range(_ROUNDS):
        guess = aligned(skeleton, every, nowhere, positions)
        skeleton = replace(skeleton, offsets=_shaped(skeleton, guess, positions))
    seen = np.isfinite(positions[..., 0])
    solver = Solver(skeleton, np.nan_to_num(positions), seen, every, guess, _HINGES)
    motion = solver.motion(nowhere, fps)
    misses = np.where(seen, np.linalg.norm(joint_positions(motion) - positions, axis=-1), np.nan)
    return PositionsFit(motion, misses)


def _sized(offsets: FloatArray, skeleton: Skeleton, positions: FloatArray) -> FloatArray:
    """Offsets ``(J, 3)`` as long as the bones are in the median frame."""
    out = offsets.copy()
    for joint in range(1, len(skeleton)):
        bones = np.linalg.norm(positions[:, joint] - positions[:, skeleton.parents[joint]], axis=-1)
        long, known = np.linalg.norm(offsets[joint]), bones[np.isfinite(bones)]
        out[joint] *= float(np.median(known)) / long if len(known) and long > 0 else 1.0
    return out


def _shaped(skeleton: Skeleton, guess: tuple[FloatArray, FloatArray], positions: FloatArray) -> FloatArray:
    """Offsets ``(J, 3)`` with the directions that bones have on segments with several of them."""
    world = rot.to_matrix(forward(Motion(skeleton, *guess, 1.0))[1])
    out = skeleton.offsets.copy()
    for parent, children in enumerate(skeleton.children):
        for child in children if len(children) > 1 else ():
            bones = np.einsum("fba,fb->fa", world[:, parent], positions[:, child] - positions[:, parent])
            known = bones[np.isfinite(bones[:, 0])]
            if len(known):
                out[child] = np.mean(known, axis=0)
    return _sized(out, skeleton, positions)
