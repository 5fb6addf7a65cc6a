"""Writing FBX 7.4: for each character a null, limbs below it, a skinned mesh, and one key per frame.

Centimetres, Y up, Euler angles in the order X Y Z without pre-rotations, which importers agree on. Limbs have no
rotation at rest, so that the bind pose is the skeleton's rest pose, placed where the motion starts.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.character import Skin
from kinetograph.errors import RequestError
from kinetograph.formats.ancestors import placed_joints, with_ancestors_skinned
from kinetograph.formats.body import dressed, named_motions
from kinetograph.formats.capsules import rest_positions
from kinetograph.formats.fbx.nodes import Node, Value, header_nodes, make, pack
from kinetograph.formats.fbx.times import CUSTOM_MODE, TICKS, TIME_MODES
from kinetograph.formats.names import unique
from kinetograph.formats.options import WriteOptions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Take

_CENTIMETRES = 100.0
_LINEAR = 1 << 2 | 1 << 8 | 1 << 13 | 1 << 14  # linear between keys, as Autodesk's own files write it


def write(what: Take | Motion | Signal, path: str | Path, options: WriteOptions | None = None) -> None:
    """Write a motion, or every motion of a take, as binary FBX.

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
        There is no motion, motions differ in rate, or units or axis are given.

    Notes
    -----
    Joints that share a name get numbers.
    """
    options = options or WriteOptions()
    if options.units != "metre" or options.up != "y":
        raise RequestError(
            f"FBX is written in its own units, Y up; found units {options.units!r}, up {options.up!r}: leave them out"
        )
    name, motions = named_motions(what, "FBX")
    rates = {motion.fps for motion in motions.values()}
    if len(rates) > 1:
        raise RequestError(f"FBX has one rate; found motions of {sorted(rates)} fps: resample them first")
    scene = _Scene(name, next(iter(motions.values())).fps, max(len(motion) for motion in motions.values()))
    for track, motion in motions.items():
        scene.add(track, *with_ancestors_skinned(*dressed(motion, options.character)))
    Path(path).write_bytes(pack(scene.nodes()))


class _Scene:
    """Objects and connections under construction."""

    def __init__(self, name: str, fps: float, frames: int) -> None:
        self.fps, self.stop = fps, _ticks(frames, fps)[-1]
        self.last = 1_000_000
        self.objects: list[Node] = []
        self.links: list[Node] = []
        self.names: list[str] = []  # joints' names so far: importers mix up two joints of one name
        span = [
            _property("LocalStop", "KTime", "Time", self.stop),
            _property("ReferenceStop", "KTime", "Time", self.stop),
        ]
        stack = self.object("AnimationStack", name, "AnimStack", "", _properties(*span))
        self.layer = self.object("AnimationLayer", "BaseLayer", "AnimLayer", "")
        self.link(self.layer, stack)

    def object(self, node: str, name: str, kind: str, subkind: str, *children: Node) -> np.int64:
        """Add an object and return its id."""
        self.last += 1
        key = np.int64(self.last)
        self.objects.append(make(node, key, f"{name}\x00\x01{kind}", subkind, children=children))
        return key

    def link(self, child: np.int64, parent: np.int64 | int, key: str = "") -> None:
        """Connect an object to another, or to one of its properties."""
        values: list[Value] = ["OP" if key else "OO", child, np.int64(parent), *([key] if key else [])]
        self.links.append(make("C", *values))

    def add(self, track: str, motion: Motion, skin: Skin) -> None:
        """Add a character: its null, limbs, curves and mesh."""
        null = self.object("NodeAttribute", track, "NodeAttribute", "Null", make("TypeFlags", "Null"))
        top = self.object("Model", track, "Model", "Null", *_model_parts())
        self.link(null, top)
        self.link(top, 0)
        limbs = self.limbs(motion, top)
        times = _ticks(len(motion), motion.fps)
        angles = np.degrees(np.unwrap(rot.to_euler(motion.rotations, "zyx"), axis=0))[..., ::-1]
        placed = placed_joints(motion)
        for joint, limb in enumerate(limbs):
            self.curves(limb, "R", "Lcl Rotation", times, angles[:, joint])
            if placed[joint]:
                places = motion.translation if joint == 0 or motion.bones is None else motion.bones[:, joint]
                self.curves(limb, "T", "Lcl Translation", times, places * _CENTIMETRES)
        rest = _CENTIMETRES * (rest_positions(motion.skeleton) + motion.translation[0])
        mesh = self.mesh(track, skin, _CENTIMETRES * motion.translation[0], limbs, rest)
        poses = [_pose(mesh, np.zeros(3)), *(_pose(limb, at) for limb, at in zip(limbs, rest, strict=True))]
        parts = [make("Type", "BindPose"), make("Version", 100), make("NbPoseNodes", len(poses)), *poses]
        self.object("Pose", track, "Pose", "BindPose", *parts)

    def limbs(self, motion: Motion, top: np.int64) -> list[np.int64]:
        """Add the joints; their ids."""
        skeleton = motion.skeleton
        before = len(self.names)
        self.names = unique([*self.names, *skeleton.names], "joint", [])
        offsets = skeleton.offsets.copy()
        offsets[0] = motion.translation[0]
        keys: list[np.int64] = []
        for joint, name in enumerate(self.names[before:]):
            attribute = self.object("NodeAttribute", name, "NodeAttribute", "LimbNode", make("TypeFlags", "Skeleton"))
            key = self.object("Model", name, "Model", "LimbNode", *_model_parts(offsets[joint] * _CENTIMETRES))
            self.link(attribute, key)
            self.link(key, keys[skeleton.parents[joint]] if joint else top)
            keys.append(key)
        return keys

    def curves(self, limb: np.int64, name: str, key: str, times: FloatArray, values: FloatArray) -> None:
        """Add three curves, shape ``(F, 3)``, that move a property of a limb."""
        first = [_property(f"d|{axis}", "Number", "", float(v)) for axis, v in zip("XYZ", values[0], strict=True)]
        group = self.object("AnimationCurveNode", name, "AnimCurveNode", "", _properties(*first))
        self.link(group, self.layer)
        self.link(group, limb, key)
        for axis, column in zip("XYZ", values.T, strict=True):
            parts = [
                make("Default", float(column[0])),
                make("KeyVer", 4009),
                make("KeyTime", times),
                make("KeyValueFloat", column.astype(np.float32)),
                make("KeyAttrFlags", np.array([_LINEAR], dtype=np.int32)),
                make("KeyAttrDataFloat", np.array([0, 0, 9.419963346924634e-30, 0], dtype=np.float32)),
                make("KeyAttrRefCount", np.array([len(times)], dtype=np.int32)),
            ]
            self.link(self.object("AnimationCurve", "", "AnimCurve", "", *parts), group, f"d|{axis}")

    def mesh(self, track: str, skin: Skin, origin: FloatArray, limbs: list[np.int64], rest: FloatArray) -> np.int64:
        """Add the skinned body, its vertices in the bind pose; its id."""
        model = self.object("Model", f"{track} body", "Model", "Mesh", *_model_parts())
        geometry = self.object("Geometry", f"{track} body", "Geometry", "Mesh", *_mesh_parts(skin, origin))
        deformer = self.object("Deformer", f"{track} body", "Deformer", "Skin", make("Version", 101))
        self.link(model, 0)
        self.link(geometry, model)
        self.link(deformer, geometry)
        for name, colour in skin.palette:
            row = make("P", "DiffuseColor", "Color", "", "A", *colour)
            parts = [make("Version", 102), make("ShadingModel", "lambert"), _properties(row)]
            self.link(self.object("Material", name, "Material", "", *parts), model)
        for joint, limb in enumerate(limbs):
            rows, columns = np.nonzero((skin.joints == joint) & (skin.weights > 0))
            parts = [
                make("Version", 100),
                make("Indexes", rows.astype(np.int32)),
                make("Weights", skin.weights[rows, columns].astype(np.float64)),
                make("Transform", _matrix(-rest[joint])),
                make("TransformLink", _matrix(rest[joint])),
            ]
            cluster = self.object("Deformer", self.names[joint], "SubDeformer", "Cluster", *parts)
            self.link(cluster, deformer)
            self.link(limb, cluster)
        return model

    def nodes(self) -> list[Node]:
        """The document's top nodes, in the order that readers expect them."""
        kinds = [node.name for node in self.objects]
        counts = [
            make("ObjectType", kind, children=[make("Count", kinds.count(kind))]) for kind in dict.fromkeys(kinds)
        ]
        version = [make("FBXHeaderVersion", 1003), make("FBXVersion", 7400), make("Creator", "Kinetograph")]
        document = make("Document", np.int64(1), "", "Scene", children=[make("RootNode", np.int64(0))])
        return [
            make("FBXHeaderExtension", children=version),
            *header_nodes(),
            make("GlobalSettings", children=[make("Version", 1000), self.settings()]),
            make("Documents", children=[make("Count", 1), document]),
            make("References"),
            make("Definitions", children=[make("Version", 100), make("Count", len(kinds)), *counts]),
            make("Objects", children=self.objects),
            make("Connections", children=self.links),
            make("Takes", children=[make("Current", "")]),
        ]

    def settings(self) -> Node:
        """The global settings: axes, units, rate and span."""
        mode = next((m for m, rate in TIME_MODES.items() if abs(rate / self.fps - 1) < 1e-9), CUSTOM_MODE)
        axes = {"UpAxis": 1, "FrontAxis": 2, "CoordAxis": 0}
        rows = [_property(k, "int", "Integer", v) for key, v in axes.items() for k, v in ((key, v), (f"{key}Sign", 1))]
        return _properties(
            *rows,
            _property("UnitScaleFactor", "double", "Number", 1.0),
            _property("OriginalUnitScaleFactor", "double", "Number", 1.0),
            _property("TimeMode", "enum", "", mode),
            _property("CustomFrameRate", "double", "Number", self.fps if mode == CUSTOM_MODE else -1.0),
            _property("TimeSpanStart", "KTime", "Time", np.int64(0)),
            _property("TimeSpanStop", "KTime", "Time", self.stop),
        )


def _ticks(frames: int, fps: float) -> FloatArray:
    return np.round(np.arange(frames) * (TICKS / fps)).astype(np.int64)


def _property(name: str, kind: str, label: str, value: Value) -> Node:
    return make("P", name, kind, label, "", value)


def _properties(*rows: Node) -> Node:
    return make("Properties70", children=rows)


def _model_parts(at: FloatArray | None = None) -> list[Node]:
    place = np.zeros(3) if at is None else at
    rows = [
        make("P", "Lcl Translation", "Lcl Translation", "", "A", *map(float, place)),
        make("P", "Lcl Rotation", "Lcl Rotation", "", "A", 0.0, 0.0, 0.0),
        make("P", "Lcl Scaling", "Lcl Scaling", "", "A", 1.0, 1.0, 1.0),
        _property("InheritType", "enum", "", 1),
    ]
    return [make("Version", 232), _properties(*rows), make("Shading", True), make("Culling", "CullingOff")]


def _mesh_parts(skin: Skin, origin: FloatArray) -> list[Node]:
    corners = skin.triangles.astype(np.int32).copy()
    corners[:, 2] = -1 - corners[:, 2]  # the last corner of a face is marked by its complement
    normals = [
        make("Version", 101),
        make("Name", ""),
        make("MappingInformationType", "ByVertice"),
        make("ReferenceInformationType", "Direct"),
        make("Normals", skin.normals.reshape(-1)),
    ]
    tints = [
        make("Version", 101),
        make("Name", ""),
        make("MappingInformationType", "ByPolygon"),
        make("ReferenceInformationType", "IndexToDirect"),
        make("Materials", skin.tints.astype(np.int32)),
    ]
    kinds = ("LayerElementNormal", "LayerElementMaterial")
    layers = [make("LayerElement", children=[make("Type", kind), make("TypedIndex", 0)]) for kind in kinds]
    return [
        make("GeometryVersion", 124),
        make("Vertices", (skin.points * _CENTIMETRES + origin).reshape(-1)),
        make("PolygonVertexIndex", corners.reshape(-1)),
        make("LayerElementNormal", 0, children=normals),
        make("LayerElementMaterial", 0, children=tints),
        make("Layer", 0, children=[make("Version", 100), *layers]),
    ]


def _matrix(shift: FloatArray) -> FloatArray:
    matrix = np.eye(4)
    matrix[3, :3] = shift  # rows are columns here
    return matrix.reshape(-1)


def _pose(key: np.int64, at: FloatArray) -> Node:
    return make("PoseNode", children=[make("Node", key), make("Matrix", _matrix(at))])
