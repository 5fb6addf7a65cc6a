"""Bodies with more above and beside their hips than bodies have, whose motion in the world is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bodies import person, walk
from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton


def walker(frames: int = 60) -> Motion:
    """Someone who walks 0.6 m/s along a bend, with the names of a usual skeleton and no roles."""
    motion = walk(person(), frames=frames)
    time = np.arange(frames) / motion.fps
    heading = 0.4 * time
    way = np.stack([0.6 * time * np.sin(heading), motion.translation[:, 1], 0.6 * time * np.cos(heading)], axis=1)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.about("y", heading)
    bare = replace(motion.skeleton, roles={})
    return replace(motion, skeleton=bare, translation=way, rotations=rotations)


def under(
    motion: Motion,
    name: str,
    places: FloatArray,
    rotations: FloatArray,
    beside: tuple[str, ...] = (),
    rest: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Motion:
    """The same motion in the world with one more joint above its root, and leaves beside the root.

    Parameters
    ----------
    motion : Motion
    name : str
    places : ndarray, shape (3,) or (F, 3)
        Where the new root is in the world.
    rotations : ndarray, shape (4,) or (F, 4)
    beside : tuple of str
        Joints 1 m in front of the new root, which move with it.
    rest : tuple of float
        Where the new root rests.
    """
    frames, skeleton = len(motion), motion.skeleton
    places, rotations = np.broadcast_to(places, (frames, 3)), np.broadcast_to(rotations, (frames, 4))
    body = len(skeleton)
    tree = Skeleton(
        (name, *skeleton.names, *beside),
        np.concatenate([[-1, 0], skeleton.parents[1:] + 1, np.zeros(len(beside), int)]),
        np.concatenate(
            [[rest], skeleton.offsets[:1] - rest, skeleton.offsets[1:], np.tile([0.0, 0.0, 1.0], (len(beside), 1))]
        ),
        skeleton.end_parents + 1,
        skeleton.end_offsets,
    )
    back = rot.conjugate(rotations)
    local = rot.identity(frames, body + 1 + len(beside))
    local[:, 0], local[:, 1 : body + 1] = rotations, motion.rotations
    local[:, 1] = rot.multiply(back, motion.rotations[:, 0])
    bones = np.tile(tree.offsets, (frames, 1, 1))
    if motion.bones is not None:
        bones[:, 1 : body + 1] = motion.bones
    bones[:, 1] = rot.rotate(back, motion.translation - places)
    return Motion(tree, places.copy(), local, motion.fps, bones)


def on_the_ground(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Where a game's root goes: on the ground under the hips, facing as they do."""
    return motion.translation * [1.0, 0.0, 1.0], motion.rotations[:, 0]


def controller(name: str, frames: int = 60) -> Motion:
    """A lone joint that moves."""
    path = np.linspace([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], frames)
    return Motion(Skeleton((name,), np.array([-1]), np.zeros((1, 3))), path, rot.identity(frames, 1), 30.0)
