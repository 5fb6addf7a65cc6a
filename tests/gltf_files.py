"""Small glTF documents: a table of nodes, and animations of them, with their numbers in the text."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

Json = dict[str, Any]
Keys = tuple[int, str, list[float], Any]
"""A node, what is moved, times and values."""


class Numbers:
    """Accessors, views and one buffer for arrays."""

    def __init__(self) -> None:
        self.data = b""
        self.parts: dict[str, list[Json]] = {"accessors": [], "bufferViews": []}

    def add(self, values: np.ndarray) -> int:
        """The accessor of rows of single-precision numbers, or of bytes."""
        rows = np.asarray(values)
        rows = rows.astype("<f4") if rows.dtype != np.uint8 else rows
        rows = rows.reshape(len(rows), -1)
        kind = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[rows.shape[1]]
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": rows.nbytes}
        self.data += rows.tobytes() + bytes(-rows.nbytes % 4)
        self.parts["bufferViews"].append(view)
        entry = {"bufferView": len(self.parts["bufferViews"]) - 1, "count": len(rows), "type": kind}
        self.parts["accessors"].append(entry | {"componentType": 5121 if rows.dtype == np.uint8 else 5126})
        return len(self.parts["accessors"]) - 1

    def document(self, **more: Any) -> Json:
        """A document with the arrays."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        buffers = [{"byteLength": len(self.data), "uri": uri}]
        return {"asset": {"version": "2.0"}, "buffers": buffers, **self.parts, **more}


def animated(nodes: list[Json], animations: list[tuple[str | None, list[Keys]]], **more: Any) -> Json:
    """A document of nodes and animations, by name."""
    numbers = Numbers()
    made: list[Json] = []
    for name, moves in animations:
        channels, samplers = [], []
        for node, path, times, values in moves:
            samplers.append({"input": numbers.add(np.array(times)), "output": numbers.add(np.array(values))})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": path}})
        made.append({"channels": channels, "samplers": samplers} | ({} if name is None else {"name": name}))
    return numbers.document(nodes=nodes, animations=made, **more)


def written(path: Path, document: Json) -> Path:
    """The path, with the document in it."""
    path.write_text(json.dumps(document))
    return path


def turned(degrees: float) -> list[float]:
    """A rotation about y, x y z w."""
    half = np.radians(degrees) / 2
    return [0.0, float(np.sin(half)), 0.0, float(np.cos(half))]


def spun(degrees: float) -> Keys:
    """Keys that rotate the first node about y, within a second."""
    return (0, "rotation", [0.0, 1.0], [turned(0), turned(degrees)])


HUMANOID: dict[str, tuple[str | None, tuple[float, float, float]]] = {
    "hips": (None, (0, 0.9, 0)),
    "spine": ("hips", (0, 0.1, 0)),
    "chest": ("spine", (0, 0.15, 0)),
    "upperChest": ("chest", (0, 0.1, 0)),
    "neck": ("upperChest", (0, 0.15, 0)),
    "head": ("neck", (0, 0.1, 0)),
    **{
        f"{side}{part}": (f"{side}{above}" if above[0].isupper() else above, (x * sign, y, z))
        for side, sign in (("left", 1), ("right", -1))
        for part, above, (x, y, z) in (
            ("Shoulder", "upperChest", (0.05, 0.1, 0)),
            ("UpperArm", "Shoulder", (0.1, 0, 0)),
            ("LowerArm", "UpperArm", (0.28, 0, 0)),
            ("Hand", "LowerArm", (0.25, 0, 0)),
            ("UpperLeg", "hips", (0.1, -0.05, 0)),
            ("LowerLeg", "UpperLeg", (0, -0.4, 0)),
            ("Foot", "LowerLeg", (0, -0.4, 0)),
            ("Toes", "Foot", (0, -0.05, 0.12)),
        )
    },
}
"""The bones of a VRM humanoid in a T pose that faces z: above which each hangs, and where."""


def humanoid_nodes(facing: float = 1.0) -> list[Json]:
    """Nodes of `HUMANOID` with names that say nothing; -1 faces against z."""
    names = list(HUMANOID)
    nodes: list[Json] = [{"name": f"n{i}"} for i in range(len(names))]
    for i, (above, (x, y, z)) in enumerate(HUMANOID.values()):
        nodes[i]["translation"] = [x * facing, y, z * facing]
        if above is not None:
            nodes[names.index(above)].setdefault("children", []).append(i)
    return nodes


NODE = {name: index for index, name in enumerate(HUMANOID)}
VRM1 = {"VRMC_vrm": {"specVersion": "1.0", "humanoid": {"humanBones": {n: {"node": i} for n, i in NODE.items()}}}}
VRM0 = {"VRM": {"humanoid": {"humanBones": [{"bone": n, "node": i} for n, i in NODE.items()]}}}
VRMA = {"VRMC_vrm_animation": {"specVersion": "1.0", "humanoid": VRM1["VRMC_vrm"]["humanoid"]}}


def avatar(extensions: Json, facing: float = 1.0, **more: Any) -> Json:
    """A body of one triangle on its right hand and one on its left toe, in a skin each; hair hangs on nothing."""
    numbers, nodes = Numbers(), humanoid_nodes(facing)
    world: dict[str, np.ndarray] = {}
    for name, (above, at) in HUMANOID.items():
        world[name] = np.array(at) * [facing, 1, facing] + (0 if above is None else world[above])
    meshes, skins = [], []
    for joints, corner in ((list(HUMANOID), "rightHand"), (["head", "leftToes"], "leftToes")):
        matrices = np.tile(np.eye(4), (len(joints), 1, 1))
        matrices[:, 3, :3] = [-world[name] for name in joints]
        points = world[corner] + np.array([[0, 0, 0], [0.1, 0, 0], [0, 0, 0.1]])
        slots = np.zeros((3, 4), dtype=np.uint8)
        slots[:, 0] = joints.index(corner)
        attributes = {
            "POSITION": numbers.add(points),
            "JOINTS_0": numbers.add(slots),
            "WEIGHTS_0": numbers.add(np.eye(4)[[0, 0, 0]]),
        }
        skin = {"joints": [NODE[name] for name in joints], "inverseBindMatrices": numbers.add(matrices.reshape(-1, 16))}
        skins.append(skin)
        meshes.append({"primitives": [{"attributes": attributes}]})
        nodes.append({"name": f"mesh {corner}", "mesh": len(meshes) - 1, "skin": len(skins) - 1})
    nodes.append({"name": "hair"})
    skins.append({"joints": [len(nodes) - 1]})
    return numbers.document(nodes=nodes, meshes=meshes, skins=skins, extensions=extensions, **more)


def two_animations() -> Json:
    """Two nodes that two animations move, one of them bent by a matrix."""
    flat = np.eye(4)
    flat[3, :3] = [0, 1, 0]
    nodes: list[Json] = [{"name": "a", "children": [1]}, {"matrix": flat.reshape(-1).tolist(), "extras": {"fps": 30}}]
    moved = (1, "translation", [0.0, 0.5, 1.0], [[0, 1, 0], [0, 2, 0], [0, 1, 1]])
    return animated(nodes, [("Turn", [spun(90), moved]), (None, [spun(10)])])
