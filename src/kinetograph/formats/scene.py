"""Trees of moving nodes, as glTF, FBX and USD have them, made into motions.

The nodes chosen as joints get frames that are aligned with the world in the bind pose: with B the world rotation of a
joint in the bind pose and G that of a frame, the joint's rotation is G B^-1. Positions are kept to the last digit, and
the pose without turns is the bind pose, which is what this package takes a skeleton's rest pose to be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_MOST_VALUES, _ROOM, _SWELL = 40_000_000, 1_000_000, 4
_BLOCK = 1024  # frames
_RIGID = 1e-4  # of the body's size: bones that change by less are rigid, as single precision has them


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes, parents before children: names, parents ``(N,)`` with -1 at the top, and local transforms over time.

    translations ``(F or 1, N, 3)``, rotations ``(F or 1, N, 4)`` and scales ``(F or 1, N, 3)``; a child's translation
    is stretched by its ancestors' scales.
    """

    names: tuple[str, ...]
    parents: IntArray
    translations: FloatArray
    rotations: FloatArray
    scales: FloatArray


def most_values(size: int) -> int:
    """Nodes times frames that a file of ``size`` bytes may ask for: two keys a week apart are no week of frames.

    At most half an hour at 120 Hz of a character with 180 joints.
    """
    return min(_MOST_VALUES, _ROOM + _SWELL * size)


def depth_first(parents: Sequence[int]) -> list[int] | None:
    """The indices with parents before children, or None where parents go round in a ring."""
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
    turns = np.empty((frames, count, 4))
    scales = np.empty((max(len(nodes.scales), 1), count, 3))
    for node, parent in enumerate(nodes.parents.tolist()):
        shift, turn, scale = nodes.translations[:, node], nodes.rotations[:, node], nodes.scales[:, node]
        if parent < 0:
            positions[:, node], turns[:, node], scales[:, node] = shift, turn, scale
        else:
            positions[:, node] = positions[:, parent] + rot.rotate(turns[:, parent], shift * scales[:, parent])
            turns[:, node] = rot.multiply(turns[:, parent], turn)
            scales[:, node] = scales[:, parent] * scale
    return positions, turns


def motions(nodes: Nodes, joints: Sequence[int], bind: tuple[FloatArray, FloatArray], fps: float) -> list[Motion]:
    """A motion for every tree among ``joints``: nodes whose nearest ancestor among them is their parent.

    bind: world positions ``(N, 3)`` and rotations ``(N, 4)`` of all nodes in the bind pose.
    """
    chosen = set(joints)
    above = {joint: _above(nodes.parents, chosen, joint) for joint in sorted(chosen)}
    trees: dict[int, list[int]] = {}
    top: dict[int, int] = {}
    for joint in sorted(chosen):
        top[joint] = joint if above[joint] < 0 else top[above[joint]]
        trees.setdefault(top[joint], []).append(joint)
    frames = max(len(nodes.translations), len(nodes.rotations), len(nodes.scales))
    made = [_Tree(tree, above, frames) for tree in trees.values()]
    for start in range(0, frames, _BLOCK):  # the world of every frame at once would take many times the file
        block = slice(start, min(start + _BLOCK, frames))
        positions, turns = world(_cut(nodes, block))
        for tree in made:
            tree.fill(block, positions, turns, bind[1])
    return [tree.motion(nodes.names, bind[0], fps) for tree in made]


def _cut(nodes: Nodes, block: slice) -> Nodes:
    parts = (nodes.translations, nodes.rotations, nodes.scales)
    return Nodes(nodes.names, nodes.parents, *(part[block] if len(part) > 1 else part for part in parts))


def _above(parents: IntArray, chosen: set[int], joint: int) -> int:
    parent = int(parents[joint])
    while parent >= 0 and parent not in chosen:
        parent = int(parents[parent])
    return parent


class _Tree:
    """The joints of one character, as blocks of frames fill them."""

    def __init__(self, joints: list[int], above: dict[int, int], frames: int) -> None:
        index = {joint: i for i, joint in enumerate(joints)}
        self.joints = joints
        self.parents = np.array([index.get(above[joint], -1) for joint in joints])
        self.translation = np.empty((frames, 3))
        self.local = np.empty((frames, len(joints), 4))
        self.bones = np.empty((frames, len(joints), 3))

    def fill(self, block: slice, positions: FloatArray, turns: FloatArray, bind: FloatArray) -> None:
        """Take a block of frames of the world, aligned with it in the bind pose."""
        up = np.maximum(self.parents, 0)
        at = positions[:, self.joints]
        turn = rot.multiply(turns[:, self.joints], rot.conjugate(bind[self.joints]))
        local = rot.multiply(rot.conjugate(turn[:, up]), turn)
        local[:, 0] = turn[:, 0]
        self.translation[block], self.local[block] = at[:, 0], rot.normalize(local)
        self.bones[block] = rot.rotate(rot.conjugate(turn[:, up]), at - at[:, up])

    def motion(self, names: tuple[str, ...], bind: FloatArray, fps: float) -> Motion:
        """The motion, whose bones are rigid unless they change."""
        middle = self.bones.mean(axis=0)
        offsets = middle.copy()
        offsets[0] = bind[self.joints[0]]
        size = max(float(np.abs(middle).max()), 1e-9)
        strays = (float(np.abs(self.bones[:, j] - middle[j]).max()) for j in range(1, len(self.joints)))
        loose = max(strays, default=0.0) > _RIGID * size
        for joint in range(len(self.joints)):
            self.local[:, joint] = rot.unroll(self.local[:, joint])
        skeleton = Skeleton(tuple(names[joint] for joint in self.joints), self.parents, offsets)
        return Motion(skeleton, self.translation, self.local, fps, self.bones if loose else None)


def interpolate(times: FloatArray, keys: FloatArray, values: FloatArray, kind: str) -> FloatArray:
    """Values at ``times`` ``(F,)`` of keys ``(K,)``.

    kind: ``"STEP"``, ``"LINEAR"`` or, for turns, ``"SLERP"``.
    """
    upper = np.clip(np.searchsorted(keys, times, side="right"), 1, max(len(keys) - 1, 1))
    if len(keys) == 1:
        return np.repeat(values, len(times), axis=0)
    lower = upper - 1
    u = np.clip((times - keys[lower]) / np.maximum(keys[upper] - keys[lower], 1e-12), 0.0, 1.0)
    if kind == "STEP":
        return values[np.where(u >= 1.0, upper, lower)]
    if kind == "SLERP":
        return rot.slerp(values[lower], values[upper], u)
    return np.asarray((1 - u[:, None]) * values[lower] + u[:, None] * values[upper])


def spline(times: FloatArray, keys: FloatArray, values: FloatArray) -> FloatArray:
    """Values at ``times`` ``(F,)`` of glTF's splines, ``(K, 3, n)``: a tangent in, a value and a tangent out a key."""
    if len(keys) == 1:
        return np.repeat(values[:, 1], len(times), axis=0)
    upper = np.clip(np.searchsorted(keys, times, side="right"), 1, len(keys) - 1)
    lower = upper - 1
    span = keys[upper] - keys[lower]
    u = np.clip((times - keys[lower]) / np.maximum(span, 1e-12), 0.0, 1.0)
    u, span = u[:, None], span[:, None]
    begin, end = (2 * u**3 - 3 * u**2 + 1) * values[lower, 1], (3 * u**2 - 2 * u**3) * values[upper, 1]
    leave, arrive = (u**3 - 2 * u**2 + u) * values[lower, 2], (u**3 - u**2) * values[upper, 0]
    return np.asarray(begin + end + span * (leave + arrive))
