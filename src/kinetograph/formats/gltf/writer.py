"""Writing glTF 2.0 in one binary file (``.glb``).

Each character is a node named after its track, its joints below it, and a skinned mesh: that of the character it is
written with, or capsules made from the skeleton, the left limbs blue, the right ones vermilion. Joint nodes hold the
rest pose, placed where the motion starts; one animation moves every character.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.character import Character, Colour, Skin
from kinetograph.errors import RequestError
from kinetograph.formats.ancestors import placed_joints, with_ancestors_skinned
from kinetograph.formats.body import dressed, named_motions
from kinetograph.formats.capsules import rest_positions
from kinetograph.formats.options import WriteOptions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Take

_MAGIC, _VERSION, _JSON, _BIN = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
_COMPONENTS = {np.dtype(np.float32): 5126, np.dtype(np.uint16): 5123, np.dtype(np.uint32): 5125}
_KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
_VERTICES, _INDICES = 34962, 34963  # bufferView targets

Json = dict[str, Any]


def write(what: Take | Motion | Signal, path: str | Path, options: WriteOptions | None = None) -> None:
    """Write a motion, or every motion of a take, as a GLB file with bodies.

    Parameters
    ----------
    what : Take, Motion or Signal
    path : str or Path
        Written to exactly this path.
    options : WriteOptions, optional
        ``character`` is whose skin the motions wear; without one, capsules.

    Raises
    ------
    RequestError
        There is no motion, units or axis are not metres and Y up, or a motion is so long and dense that two of its
        frames would have the same time in single precision.
    """
    options = options or WriteOptions()
    _check_options(options)
    Path(path).write_bytes(encode(what, options.character, ancestors=True))


def encode(what: Take | Motion | Signal, character: Character | None = None, *, ancestors: bool = False) -> bytes:
    """The bytes of a GLB file.

    Parameters
    ----------
    what : Take, Motion or Signal
    character : Character, optional
        Whose skin the motions wear; without one, capsules.
    ancestors : bool
        Also write what skeletons have above their roots, as joints that never move.

    Returns
    -------
    bytes

    Raises
    ------
    RequestError
        As for `write`.
    """
    name, motions = named_motions(what, "GLB")
    document = _Document(name)
    for track, motion in motions.items():
        motion, skin = dressed(motion, character)
        if ancestors:
            motion, skin = with_ancestors_skinned(motion, skin)
        _add_character(document, track, motion, skin)
    return document.pack()


def _check_options(options: WriteOptions) -> None:
    if options.units != "metre" or options.up != "y":
        raise RequestError(
            f"GLB is always in metres, Y up; found units {options.units!r}, up {options.up!r}: leave them out"
        )


class _Document:
    """A glTF document under construction: JSON objects, and the bytes that their accessors point to."""

    def __init__(self, name: str) -> None:
        self.binary = bytearray()
        self.scene: list[int] = []
        self.parts: dict[str, list[Json]] = {
            key: [] for key in ("nodes", "meshes", "skins", "materials", "accessors", "bufferViews")
        }
        self.animation: Json = {"name": name, "channels": [], "samplers": []}

    def add(self, key: str, value: Json) -> int:
        """Append an object to one of the document's lists and return its index."""
        self.parts[key].append(value)
        return len(self.parts[key]) - 1

    def material(self, name: str, colour: Colour) -> int:
        """The index of a material of the body, which is made on first use."""
        surface = {"baseColorFactor": [*colour, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9}
        value = {"name": name, "pbrMetallicRoughness": surface}
        known = self.parts["materials"]
        return known.index(value) if value in known else self.add("materials", value)

    def accessor(self, values: npt.NDArray[Any], *, target: int | None = None, bounds: bool = False) -> int:
        """Store an array, one row per element, and return its accessor."""
        rows = values.reshape(len(values), -1)
        self.binary.extend(bytes(-len(self.binary) % 4))
        view: Json = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": rows.nbytes}
        if target is not None:
            view["target"] = target
        self.binary.extend(np.ascontiguousarray(rows).astype(rows.dtype.newbyteorder("<"), copy=False).tobytes())
        entry: Json = {
            "bufferView": self.add("bufferViews", view),
            "componentType": _COMPONENTS[rows.dtype],
            "count": len(rows),
            "type": _KINDS[rows.shape[1]],
        }
        if bounds:  # of the stored single-precision values, to the last bit, as the format asks
            entry |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return self.add("accessors", entry)

    def animate(self, node: int, what: str, times: int, values: npt.NDArray[np.float32]) -> None:
        """Move a node's translation or rotation."""
        self.animation["samplers"].append(
            {"input": times, "interpolation": "LINEAR", "output": self.accessor(values)},
        )
        sampler = len(self.animation["samplers"]) - 1
        self.animation["channels"].append({"sampler": sampler, "target": {"node": node, "path": what}})

    def pack(self) -> bytes:
        """The document as GLB bytes: a header, a JSON chunk and a binary chunk, each padded to four bytes."""
        document = {
            "asset": {"version": "2.0", "generator": "Kinetograph"},
            "scene": 0,
            "scenes": [{"nodes": self.scene}],
            **self.parts,
            "animations": [self.animation],
            "buffers": [{"byteLength": len(self.binary) + -len(self.binary) % 4}],
        }
        text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.binary) + bytes(-len(self.binary) % 4)
        size = 12 + 8 + len(text) + 8 + len(binary)
        return b"".join(
            [
                struct.pack("<3I", _MAGIC, _VERSION, size),
                struct.pack("<2I", len(text), _JSON) + text,
                struct.pack("<2I", len(binary), _BIN) + binary,
            ]
        )


def _add_character(document: _Document, track: str, motion: Motion, skin: Skin) -> None:
    """Nodes, body and animation of one character."""
    first = len(document.parts["nodes"]) + 1  # the character's own node comes before its joints
    skeleton = motion.skeleton
    noted = {"fps": motion.fps, "frames": len(motion)}
    document.scene.append(document.add("nodes", {"name": track, "children": [first], "extras": noted}))
    locals_ = skeleton.offsets.copy()
    locals_[0] = motion.translation[0]
    for joint, name in enumerate(skeleton.names):
        node: Json = {"name": name, "translation": locals_[joint].tolist(), "rotation": [0.0, 0.0, 0.0, 1.0]}
        if skeleton.children[joint]:
            node["children"] = [first + child for child in skeleton.children[joint]]
        document.add("nodes", node)
    _add_body(document, track, motion, first, skin)
    _add_animation(document, motion, first)


def _add_body(document: _Document, track: str, motion: Motion, first: int, worn: Skin) -> None:
    skeleton = motion.skeleton
    origin = motion.translation[0]
    inverse = np.tile(np.eye(4), (len(skeleton), 1, 1))
    inverse[:, 3, :3] = -(rest_positions(skeleton) + origin)  # columns first: the last row is the last column
    skin = {
        "name": track,
        "inverseBindMatrices": document.accessor(inverse.astype(np.float32)),
        "joints": list(range(first, first + len(skeleton))),
        "skeleton": first,
    }
    mesh = {"name": f"{track} body", "primitives": _primitives(document, worn, origin)}
    node = {"name": f"{track} body", "mesh": document.add("meshes", mesh), "skin": document.add("skins", skin)}
    # at the top of the scene: a skinned mesh ignores the transforms above it
    document.scene.append(document.add("nodes", node))


def _primitives(document: _Document, skin: Skin, origin: FloatArray) -> list[Json]:
    """The body's triangles, one primitive per tint, with shared vertices."""
    count = len(skin.points)
    weights = skin.weights.astype(np.float32)
    # a joint without weight must be joint 0, as validators demand
    joints = np.where(weights > 0, skin.joints, 0).astype(np.uint16)
    attributes = {
        "POSITION": document.accessor((skin.points + origin).astype(np.float32), target=_VERTICES, bounds=True),
        "NORMAL": document.accessor(skin.normals.astype(np.float32), target=_VERTICES),
        "JOINTS_0": document.accessor(joints, target=_VERTICES),
        "WEIGHTS_0": document.accessor(weights, target=_VERTICES),
    }
    width = np.uint16 if count < 2**16 - 1 else np.uint32
    primitives = []
    for tint in np.unique(skin.tints).tolist():
        corners = skin.triangles[skin.tints == tint].reshape(-1, 1).astype(width)
        indices = document.accessor(corners, target=_INDICES)
        primitives.append(
            {
                "attributes": attributes,
                "indices": indices,
                "material": document.material(*skin.palette[tint]),
                "mode": 4,
            }
        )
    return primitives


def _add_animation(document: _Document, motion: Motion, first: int) -> None:
    seconds = (np.arange(len(motion)) / motion.fps).astype(np.float32)
    if np.any(np.diff(seconds) <= 0):
        raise RequestError(
            f"{len(motion)} frames at {motion.fps:g} fps are too long and dense for the single-precision times of "
            "GLB; write it in parts or at a lower rate"
        )
    times = document.accessor(seconds, bounds=True)
    document.animate(first, "translation", times, motion.translation.astype(np.float32))
    placed = placed_joints(motion)
    for joint in range(len(motion.skeleton)):
        rotations = rot.unroll(rot.normalize(motion.rotations[:, joint]))  # joint by joint: a motion may be long
        document.animate(first + joint, "rotation", times, rotations[:, [1, 2, 3, 0]].astype(np.float32))
        if joint and motion.bones is not None and placed[joint]:
            document.animate(first + joint, "translation", times, motion.bones[:, joint].astype(np.float32))
