"""Trees of moving nodes, as in glTF, FBX and USD, converted to motions.

The nodes chosen as joints get axes that are aligned with the world in the bind pose: with B the world rotation of a
joint in the bind pose and G that of a frame, the joint's rotation is G B^-1. Positions are kept to the last digit. The
pose with all rotations zero is the bind pose, which becomes the skeleton's rest pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.formats.inheritance import FULL, Scales
from kinetograph.formats.timing import bracket_times
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_MOST_VALUES, _ROOM, _SWELL = 40_000_000, 250_000, 4
_BLOCK = 1024  # frames
_BLOCK_VALUES = 1_000_000  # nodes times frames
_RIGID = 1e-4  # of the body's size: bones that change by less are rigid, to the precision of single precision
_WHOLE = 0.5  # of the bones' lengths: the least that a rest pose has
_SAME = 1e-5  # of the body's size: bones that differ by less from those at rest are those, to the last bit


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes, parents before children, and their local transforms over time.

    Parameters
    ----------
    names : tuple of str
    parents : ndarray of int, shape (N,)
        -1 at the top.
    translations : ndarray, shape (F or 1, N, 3)
        Stretched and sheared by the scales of the ancestors.
    rotations : ndarray, shape (F or 1, N, 4)
    scales : ndarray, shape (F or 1, N, 3)
    inherits : ndarray of int, shape (N,), optional
        How each node inherits its parent's scale, of `kinetograph.formats.inheritance`; ``FULL`` without it.
    """

    names: tuple[str, ...]
    parents: IntArray
    translations: FloatArray
    rotations: FloatArray
    scales: FloatArray
    inherits: IntArray | None = None


@dataclass(frozen=True, eq=False)
class Rest:
    """A file's rest pose, whose bones are the skeleton's, so that all animations of a file have one skeleton.

    Parameters
    ----------
    positions, rotations : ndarray, shapes (N, 3) and (N, 4)
        Of all nodes, in the world.
    shared : bool
        Whether several animations share it: bones that have another length throughout one are then that motion's own,
        and else the skeleton's.
    """

    positions: FloatArray
    rotations: FloatArray
    shared: bool = False


def most_values(size: int) -> int:
    """Nodes times frames that a file of ``size`` bytes may ask for, as two keys a week apart are not a week of frames.

    At most half an hour at 120 Hz of a character with 180 joints.
    """
    return min(_MOST_VALUES, _ROOM + _SWELL * size)


def depth_first(parents: Sequence[int]) -> list[int] | None:
    """The indices with parents before children; ``None`` where the parents form a ring."""
    children: list[list[int]] = [[] for _ in parents]
    todo: list[int] = []
    for index, parent in enumerate(parents):
        (children[parent] if parent >= 0 else todo).append(index)
    todo.reverse()
    order = []
    while todo:
        order.append(todo.pop())
        todo.extend(reversed(children[order[-1]]))
    return order if len(order) == len(parents) else None


def world(nodes: Nodes) -> tuple[FloatArray, FloatArray]:
    """World positions ``(F, N, 3)`` and rotations ``(F, N, 4)`` of the nodes."""
    frames = max(len(nodes.translations), len(nodes.rotations), len(nodes.scales))
    count = len(nodes.names)
    positions = np.empty((frames, count, 3))
    rotations = np.empty((frames, count, 4))
    modes = [FULL] * count if nodes.inherits is None else nodes.inherits.tolist()
    scales = Scales(nodes.parents, nodes.scales, modes)
    for node, parent in enumerate(nodes.parents.tolist()):
        shift, rotation = nodes.translations[:, node], nodes.rotations[:, node]
        scales.add(node, rotation)
        if parent < 0:
            positions[:, node], rotations[:, node] = shift, rotation
        else:
            moved = scales.stretch(parent, shift)
            positions[:, node] = positions[:, parent] + rot.rotate(rotations[:, parent], moved)
            rotations[:, node] = rot.multiply(rotations[:, parent], rotation)
    return positions, rotations


def motions(
    nodes: Nodes,
    joints: Sequence[int],
    bind: tuple[FloatArray, FloatArray],
    fps: float,
    still: Rest | None = None,
) -> list[Motion]:
    """A motion for every tree among the joints.

    Parameters
    ----------
    nodes : Nodes
    joints : sequence of int
        The nodes that are joints; a joint's parent is its nearest ancestor among them.
    bind : tuple of ndarray, shapes (N, 3) and (N, 4)
        World positions and rotations of all nodes in the bind pose.
    fps : float
    still : Rest, optional
        Whose bones are the skeleton's; without it they are the mean over the frames.

    Returns
    -------
    list of Motion
    """
    chosen = set(joints)
    above = {joint: _above(nodes.parents, chosen, joint) for joint in sorted(chosen)}
    trees: dict[int, list[int]] = {}
    top: dict[int, int] = {}
    for joint in sorted(chosen):
        top[joint] = joint if above[joint] < 0 else top[above[joint]]
        trees.setdefault(top[joint], []).append(joint)
    frames = max(len(nodes.translations), len(nodes.rotations), len(nodes.scales))
    characters = [_Tree(tree, above, frames) for tree in trees.values()]
    size = max(min(_BLOCK, _BLOCK_VALUES // len(nodes.names)), 1)
    for start in range(0, frames, size):  # all frames in the world at once would take many times the file
        block = slice(start, min(start + size, frames))
        positions, rotations = world(_cut(nodes, block))
        for character in characters:
            character.fill(block, positions, rotations, bind[1])
    if still is not None:
        for character in characters:
            character.rest(still, bind[1])
    return [character.motion(nodes.names, bind[0], fps) for character in characters]


def _cut(nodes: Nodes, block: slice) -> Nodes:
    parts = (nodes.translations, nodes.rotations, nodes.scales)
    shifts, rotations, scales = (part[block] if len(part) > 1 else part for part in parts)
    return Nodes(nodes.names, nodes.parents, shifts, rotations, scales, nodes.inherits)


def _above(parents: IntArray, chosen: set[int], joint: int) -> int:
    parent = int(parents[joint])
    while parent >= 0 and parent not in chosen:
        parent = int(parents[parent])
    return parent


class _Tree:
    """The joints of one character, filled in blocks of frames."""

    def __init__(self, joints: list[int], above: dict[int, int], frames: int) -> None:
        index = {joint: i for i, joint in enumerate(joints)}
        self.joints = joints
        self.parents = np.array([index.get(above[joint], -1) for joint in joints])
        self.translation = np.empty((frames, 3))
        self.local = np.empty((frames, len(joints), 4))
        self.bones = np.empty((frames, len(joints), 3))
        self.still: FloatArray | None = None
        self.shared = False

    def fill(self, block: slice, positions: FloatArray, rotations: FloatArray, bind: FloatArray) -> None:
        """Take a block of frames in the world, relative to the bind pose."""
        up = np.maximum(self.parents, 0)
        at = positions[:, self.joints]
        rotation = rot.multiply(rotations[:, self.joints], rot.conjugate(bind[self.joints]))
        local = rot.multiply(rot.conjugate(rotation[:, up]), rotation)
        local[:, 0] = rotation[:, 0]
        self.translation[block], self.local[block] = at[:, 0], rot.normalize(local)
        self.bones[block] = rot.rotate(rot.conjugate(rotation[:, up]), at - at[:, up])

    def rest(self, still: Rest, bind: FloatArray) -> None:
        """Take the bones of a rest pose in the world."""
        up = np.maximum(self.parents, 0)
        at = still.positions[self.joints]
        rotation = rot.multiply(still.rotations[self.joints], rot.conjugate(bind[self.joints]))
        self.still, self.shared = rot.rotate(rot.conjugate(rotation[up]), at - at[up]), still.shared

    def motion(self, names: tuple[str, ...], bind: FloatArray, fps: float) -> Motion:
        """The motion; its bones are rigid unless they change."""
        middle = self.bones.mean(axis=0)
        size = max(float(np.abs(middle).max()), 1e-9)
        changes = (float(np.abs(self.bones[:, j] - middle[j]).max()) for j in range(1, len(self.joints)))
        loose = max(changes, default=0.0) > _RIGID * size
        offsets = middle.copy()
        if self.still is not None:
            apart = float(np.abs(self.still - middle)[1:].max(initial=0.0))
            whole = np.abs(self.still[1:]).sum() > _WHOLE * np.abs(middle[1:]).sum()  # some files have no rest pose
            if loose or apart < _SAME * size or (self.shared and whole):
                offsets, loose = self.still.copy(), loose or apart >= _SAME * size
        offsets[0] = bind[self.joints[0]]
        for joint in range(len(self.joints)):
            self.local[:, joint] = rot.unroll(self.local[:, joint])
        skeleton = Skeleton(tuple(names[joint] for joint in self.joints), self.parents, offsets)
        return Motion(skeleton, self.translation, self.local, fps, self.bones if loose else None)


def interpolate(times: FloatArray, keys: FloatArray, values: FloatArray, kind: str) -> FloatArray:
    """Values between keys.

    Parameters
    ----------
    times : ndarray, shape (F,)
    keys : ndarray, shape (K,)
        Times of the keys, increasing.
    values : ndarray, shape (K, n)
    kind : {"STEP", "LINEAR", "SLERP"}
        ``"SLERP"`` is for quaternions.

    Returns
    -------
    ndarray, shape (F, n)
    """
    if len(keys) == 1:
        return np.repeat(values, len(times), axis=0)
    lower, upper, u = bracket_times(times, keys)
    if kind == "STEP":
        return values[np.where(u >= 1.0, upper, lower)]
    if kind == "SLERP":
        return rot.slerp(values[lower], values[upper], u)
    return np.asarray((1 - u[:, None]) * values[lower] + u[:, None] * values[upper])


def spline(times: FloatArray, keys: FloatArray, values: FloatArray) -> FloatArray:
    """Values of glTF's cubic splines.

    Parameters
    ----------
    times : ndarray, shape (F,)
    keys : ndarray, shape (K,)
        Times of the keys, increasing.
    values : ndarray, shape (K, 3, n)
        For each key the tangent in, the value and the tangent out.

    Returns
    -------
    ndarray, shape (F, n)
    """
    if len(keys) == 1:
        return np.repeat(values[:, 1], len(times), axis=0)
    lower, upper, share = bracket_times(times, keys)
    u, span = share[:, None], (keys[upper] - keys[lower])[:, None]
    begin, end = (2 * u**3 - 3 * u**2 + 1) * values[lower, 1], (3 * u**2 - 2 * u**3) * values[upper, 1]
    leave, arrive = (u**3 - 2 * u**2 + u) * values[lower, 2], (u**3 - u**2) * values[upper, 0]
    return np.asarray(begin + end + span * (leave + arrive))
