"""The human body of the sample ``character``.

It is MakeHuman's base mesh (CC0) with the bones of Carnegie Mellon's skeleton, in a suit: the mesh's own helper group
of tights. The mesh is in decimetres, the rig in metres with Z up.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.character import Character, Skin
from kinetograph.errors import FetchError
from kinetograph.progress import Progress
from kinetograph.roles import with_found_roles
from kinetograph.samples.fetching import fetch, where
from kinetograph.skeleton import Skeleton

CHARACTER = "character"
"""The name of the sample with the human body."""

_DECIMETRE = 0.1
_DRAWN = {"body": 0, "helper-tights": 1, "helper-l-eye": 2, "helper-r-eye": 2}  # groups of the mesh, and their tints
_PALETTE = (("skin", (0.52, 0.33, 0.24)), ("suit", (0.05, 0.10, 0.20)), ("eyes", (0.6, 0.6, 0.6)))
_UNDER, _HEM = 0.03, 0.04  # metres: within this of the suit, and further than this from its edges, is covered
_MOST_JOINTS = 4  # that may move one point


def human(*, progress: Progress | None = None) -> Character:
    """A human body, which is downloaded first where this machine has none.

    Parameters
    ----------
    progress : Progress, optional
        Called with bytes that have arrived and their total.

    Returns
    -------
    Character
        With the joints of Carnegie Mellon's skeleton.

    Raises
    ------
    FetchError
        The download failed.
    """
    folder = where(CHARACTER) or fetch(CHARACTER, progress=progress)
    rig: dict[str, Any] = json.loads((folder / "rig.cmu_mb.json").read_text())
    names = _parents_first({name: str(bone["parent"]) for name, bone in rig.items()})
    vertices, faces, tints = _mesh(folder / "base.obj")
    kept = ~_covered(vertices, faces, tints)
    faces, tints = faces[kept], tints[kept]
    triangles = faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    used, corners = np.unique(triangles, return_inverse=True)
    heads = np.array([_place(rig[name], "head") for name in names])
    floor = np.array([0.0, vertices[used, 1].min(), 0.0])
    skeleton = _skeleton(names, rig, heads, floor)
    joints, weights = _weights(folder / "weights.cmu_mb.json", names, len(vertices))
    triangles = corners.reshape(-1, 3)
    points = vertices[used] - heads[0]
    normals = _normals(points, triangles)
    skin = Skin(points, normals, triangles, joints[used], weights[used], np.repeat(tints, 2), _PALETTE)
    return Character("human", skeleton, skin)


def _parents_first(parents: dict[str, str]) -> list[str]:
    names = [name for name, parent in parents.items() if not parent]
    for name in names:
        names.extend(child for child, parent in parents.items() if parent == name)
    return names


def _place(bone: dict[str, Any], end: str) -> FloatArray:
    """An end of a bone in metres, Y up."""
    x, y, z = bone[end]["default_position"]
    return np.array([x, z, -y], dtype=np.float64)


def _skeleton(names: list[str], rig: dict[str, Any], heads: FloatArray, floor: FloatArray) -> Skeleton:
    parents = np.array([names.index(rig[name]["parent"]) if rig[name]["parent"] else -1 for name in names])
    offsets = heads - np.where(parents[:, None] >= 0, heads[parents], floor)
    leaves = [joint for joint in range(len(names)) if joint not in set(parents.tolist())]
    ends = np.array([_place(rig[names[joint]], "tail") - heads[joint] for joint in leaves])
    return with_found_roles(Skeleton(tuple(names), parents, offsets, np.array(leaves), ends))


def _mesh(path: Path) -> tuple[FloatArray, IntArray, IntArray]:
    """All points, and the four corners and the tint of the faces that are drawn."""
    points: list[list[float]] = []
    faces: list[list[int]] = []
    tints: list[int] = []
    tint: int | None = None
    for line in path.read_text().splitlines():
        kind, _, rest = line.partition(" ")
        if kind == "v":
            points.append([float(word) for word in rest.split()])
        elif kind == "g":
            tint = _DRAWN.get(rest.strip())
        elif kind == "f" and tint is not None:
            faces.append([int(word.partition("/")[0]) - 1 for word in rest.split()])
            tints.append(tint)
    if not faces or any(len(face) != 4 for face in faces):
        raise FetchError(f"{path}: expected a mesh of four-cornered faces; fetch the sample {CHARACTER!r} again")
    return np.array(points) * _DECIMETRE, np.array(faces), np.array(tints)


def _covered(vertices: FloatArray, faces: IntArray, tints: IntArray) -> BoolArray:
    """The faces of the body, ``(T,)``, that lie well under the suit; where joints bend they would come through it."""
    from scipy.spatial import cKDTree

    suit = faces[tints == 1]
    edges = np.sort(np.stack([suit, np.roll(suit, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    borders, counts = np.unique(edges, axis=0, return_counts=True)
    hem = cKDTree(vertices[np.unique(borders[counts == 1])])
    cloth = cKDTree(vertices[np.unique(suit)])
    under = (np.asarray(cloth.query(vertices)[0]) < _UNDER) & (np.asarray(hem.query(vertices)[0]) > _HEM)
    return np.asarray((tints == 0) & under[faces].all(axis=1), dtype=np.bool_)


def _weights(path: Path, names: list[str], count: int) -> tuple[IntArray, FloatArray]:
    """The joints, ``(V, 4)``, that move each point most, and their weights, which sum to 1."""
    table: dict[str, list[list[float]]] = json.loads(path.read_text())["weights"]
    dense = np.zeros((count, len(names)))
    for joint, name in enumerate(names):
        rows = np.array(table.get(name, []), dtype=np.float64).reshape(-1, 2)
        dense[rows[:, 0].astype(np.int64), joint] = rows[:, 1]
    dense[dense.sum(axis=1) <= 0, 0] = 1.0
    joints = np.argsort(-dense, axis=1, kind="stable")[:, :_MOST_JOINTS]
    weights = np.take_along_axis(dense, joints, axis=1)
    return joints, weights / weights.sum(axis=1, keepdims=True)


def _normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Unit normals of the points: means of those of the triangles around, weighted by area."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    faces = np.cross(b - a, c - a)
    out = np.zeros_like(points)
    for corner in range(3):
        np.add.at(out, triangles[:, corner], faces)
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return np.where(length > 1e-12, out / np.maximum(length, 1e-12), np.array([0.0, 1.0, 0.0]))
