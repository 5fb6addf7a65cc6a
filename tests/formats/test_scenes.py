"""glTF and FBX: there and back, hostile files, and other programs' files."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import mutations
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import ReadOptions, WriteOptions, load, read, read_character, save
from kinetograph.formats.fbx.nodes import header_nodes, make, pack
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take


@pytest.mark.parametrize("suffix", ["glb", "fbx", "npz"])
def test_there_and_back(tmp_path: Path, suffix: str) -> None:
    motion = mutations.small_motion(frames=40)
    save(motion, tmp_path / f"a.{suffix}")
    loaded = read(tmp_path / f"a.{suffix}")
    back = loaded.take.motion()
    assert (len(back), back.fps, back.skeleton.names) == (40, 30.0, motion.skeleton.names)
    np.testing.assert_allclose(joint_positions(back), joint_positions(motion), atol=2e-6)
    assert np.degrees(rot.angle_between(back.rotations, motion.rotations)).max() < 1e-3
    assert back.bones is None


@settings(max_examples=25)
@given(st.integers(1, 6), st.floats(1.0, 240.0), st.integers(0, 2**31), st.booleans())
def test_any_tree_comes_back(
    tmp_path_factory: pytest.TempPathFactory, joints: int, fps: float, seed: int, bends: bool
) -> None:
    rng = np.random.default_rng(seed)
    parents = np.array([-1, *(int(rng.integers(0, i)) for i in range(1, joints))])
    skeleton = Skeleton(tuple(f"j {i}é" for i in range(joints)), parents, rng.normal(0, 1, (joints, 3)))
    bones = rng.normal(0, 1, (3, joints, 3)) if bends and joints > 1 else None
    motion = Motion(skeleton, rng.normal(0, 5, (3, 3)), rot.exp(rng.normal(0, 1, (3, joints, 3))), fps, bones)
    folder = tmp_path_factory.mktemp("trees")
    for suffix in ("glb", "fbx", "npz"):
        save(motion, folder / f"a.{suffix}")
        back = load(folder / f"a.{suffix}", up="y").motion()
        assert len(back) == 3
        assert back.fps == pytest.approx(fps, rel=1e-4)
        order = [back.skeleton.names.index(name) for name in skeleton.names]
        np.testing.assert_allclose(joint_positions(back)[:, order], joint_positions(motion), atol=1e-4)


def test_two_characters_keep_their_tracks(tmp_path: Path) -> None:
    a = mutations.small_motion()
    take = Take("pair", {"leader": a, "follower": Motion(a.skeleton, a.translation + np.eye(3)[0], a.rotations, a.fps)})
    save(take, tmp_path / "pair.glb")
    assert set(load(tmp_path / "pair.glb").tracks) == {"leader", "follower"}
    save(take, tmp_path / "pair.fbx")
    assert len(load(tmp_path / "pair.fbx").tracks) == 2


def document(**changes: Any) -> dict[str, Any]:
    """A glTF of one node that moves along x."""
    data = np.array([0, 1, 0, 0, 0, 1, 0, 0], dtype="<f4").tobytes()
    whole: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "nodes": [{"name": "a", "children": [1]}, {"name": "b", "translation": [0, 1, 0]}],
        "animations": [
            {
                "samplers": [{"input": 0, "output": 1}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            }
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 8},
            {"buffer": 0, "byteOffset": 8, "byteLength": 24},
        ],
        "buffers": [
            {"byteLength": 32, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}
        ],
    }
    return whole | changes


def written(folder: Path, content: dict[str, Any]) -> Path:
    path = folder / "a.gltf"
    path.write_text(json.dumps(content))
    return path


def test_a_node_that_moves_is_a_joint(tmp_path: Path) -> None:
    motion = read(written(tmp_path, document()), ReadOptions(fps=4.0)).take.motion()
    np.testing.assert_allclose(motion.translation, np.linspace([0, 0, 0], [1, 0, 0], 5), atol=1e-7)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"nodes": [{"children": [1]}, {"children": [0]}]}, "ring"),
        ({"nodes": [{"children": [1, 1]}, {}]}, "two parents"),
        ({"nodes": [{"children": [7]}]}, "expected child to be an index below 1, found 7"),
        ({"buffers": [{"byteLength": 32, "uri": "../secret.bin"}]}, "expected a file in its own folder"),
        ({"buffers": [{"byteLength": 32, "uri": "/etc/hostname"}]}, "expected a file in its own folder"),
        ({"buffers": [{"byteLength": 32, "uri": "file:///etc/hostname"}]}, "expected a file in its own folder"),
        ({"buffers": [{"byteLength": 32, "uri": "%2e%2e/secret.bin"}]}, "expected a file in its own folder"),
        ({"buffers": [{"byteLength": 10**12}]}, "has no bytes"),
        ({"animations": [], "skins": []}, "found neither"),
    ],
)
def test_hostile_gltf_is_refused(tmp_path: Path, changes: dict[str, Any], expected: str) -> None:
    (tmp_path / "secret.bin").write_bytes(bytes(32))
    folder = tmp_path / "inside"
    folder.mkdir()
    with pytest.raises(FormatError, match=expected):
        load(written(folder, document(**changes)))


def data_uri(*arrays: np.ndarray) -> list[dict[str, Any]]:
    data = b"".join(array.tobytes() for array in arrays)
    text = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return [{"byteLength": len(data), "uri": text}]


def test_cubic_splines_bend_as_their_tangents_say(tmp_path: Path) -> None:
    # x is t^3 between its keys at 0 and 2 s: values 0 and 8, slopes 0 and 12
    times = np.array([0, 2], dtype="<f4")
    values = np.zeros((2, 3, 3), dtype="<f4")
    values[:, 0, 0], values[:, 1, 0], values[:, 2, 0] = (0, 12), (0, 8), (0, 12)
    content = document(buffers=data_uri(times, values))
    content["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE"
    content["accessors"][1]["count"] = 6
    content["bufferViews"][1]["byteLength"] = 72
    motion = read(written(tmp_path, content), ReadOptions(fps=4.0, units="metre", up="y")).take.motion()
    np.testing.assert_allclose(motion.translation[:, 0], (np.arange(9) / 4) ** 3, atol=1e-5)


def test_cubic_splines_of_turns_stay_turns(tmp_path: Path) -> None:
    rotations = rot.about("y", np.array([0.0, 1.0]))[:, [1, 2, 3, 0]]
    values = np.zeros((2, 3, 4), dtype="<f4")
    values[:, 1] = rotations
    values[0, 2] = values[1, 0] = rotations[1] - rotations[0]
    content = document(buffers=data_uri(np.array([0, 1], dtype="<f4"), values))
    content["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE"
    content["animations"][0]["channels"][0]["target"]["path"] = "rotation"
    content["accessors"][1] |= {"count": 6, "type": "VEC4"}
    content["bufferViews"][1]["byteLength"] = 96
    motion = read(written(tmp_path, content), ReadOptions(fps=10.0, units="metre", up="y")).take.motion()
    spun = np.unwrap(rot.twist(motion.rotations[:, 0], "y"))
    np.testing.assert_allclose([spun[0], spun[5], spun[10]], [0.0, 0.5, 1.0], atol=1e-6)
    assert np.all(np.diff(spun) > 0)


@pytest.mark.parametrize("dense", [True, False])
def test_sparse_numbers_replace_rows(tmp_path: Path, dense: bool) -> None:
    times, base = np.array([0, 1], dtype="<f4"), np.array([[0, 0, 0], [1, 0, 0]], dtype="<f4")
    at, new = np.array([1], dtype="<u2"), np.array([[5, 6, 7]], dtype="<f4")
    content = document(buffers=data_uri(times, base, new, at))
    content["bufferViews"] += [
        {"buffer": 0, "byteOffset": 32, "byteLength": 12},
        {"buffer": 0, "byteOffset": 44, "byteLength": 2},
    ]
    sparse = {"count": 1, "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 2}}
    entry = content["accessors"][1] | {"sparse": sparse}
    content["accessors"][1] = entry if dense else {key: v for key, v in entry.items() if key != "bufferView"}
    motion = read(written(tmp_path, content), ReadOptions(fps=1.0, units="metre", up="y")).take.motion()
    np.testing.assert_allclose(motion.translation, [[0, 0, 0], [5, 6, 7]])
    for change, expected in (
        ({"count": 3}, "expected at most 2 sparse rows, found 3"),
        ({"indices": {"bufferView": 3, "componentType": 5126}}, "expected whole numbers as indices"),
        ({"indices": {"bufferView": 0, "componentType": 5123}, "count": 2}, "expected rising indices below 2"),
    ):
        content["accessors"][1] = entry | {"sparse": sparse | change}
        with pytest.raises(FormatError, match=expected):
            load(written(tmp_path, content))
    content["accessors"][1] = {"componentType": 5126, "count": 10**9, "type": "VEC3", "sparse": sparse}
    with pytest.raises(FormatError, match="numbers are too many for a file of its size"):
        load(written(tmp_path, content))


def test_claims_are_checked_by_arithmetic(tmp_path: Path) -> None:
    content = document()
    content["accessors"][0]["count"] = 10**9
    with pytest.raises(FormatError, match=r"1000000000 rows take 4000000000 bytes, there are 8"):
        load(written(tmp_path, content))
    with pytest.raises(FormatError, match="too many; give --fps"):
        load(written(tmp_path, document()), fps=1e9)


def test_a_tree_ten_thousand_deep_is_read(tmp_path: Path) -> None:
    nodes = [{"children": [i + 1]} for i in range(10_000)] + [{}]
    content = document(nodes=nodes)
    assert len(load(written(tmp_path, content), up="y").motion().skeleton) == 1
    (tmp_path / "deep.gltf").write_text('{"asset":' + "[" * 100_000)
    with pytest.raises(FormatError, match="expected the JSON of a glTF file"):
        load(tmp_path / "deep.gltf")


def fbx(folder: Path, *nodes: Any) -> Path:
    path = folder / "a.fbx"
    path.write_bytes(pack([*header_nodes(), *nodes]))
    return path


def test_an_array_that_unpacks_to_a_thousand_times_its_size_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="unpack to far more than the file's size"):
        load(fbx(tmp_path, make("Objects", children=[make("Bomb", np.zeros(40_000_000, dtype="<f8"))])))


def test_models_in_a_ring_are_refused(tmp_path: Path) -> None:
    keys = [np.int64(1), np.int64(2)]
    objects = [make("Model", key, "m\x00\x01Model", "LimbNode") for key in keys]
    links = [make("C", "OO", keys[0], keys[1]), make("C", "OO", keys[1], keys[0])]
    with pytest.raises(FormatError, match="form a ring"):
        load(fbx(tmp_path, make("Objects", children=objects), make("Connections", children=links)))


def test_other_bytes_and_versions_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.fbx").write_bytes(b"\x89PNG")
    with pytest.raises(FormatError, match="expected an FBX file, binary or in text"):
        load(tmp_path / "a.fbx")
    data = fbx(tmp_path, make("Objects", children=[make("Model", np.int64(1), "m", "LimbNode")])).read_bytes()
    (tmp_path / "b.fbx").write_bytes(data[:23] + struct.pack("<I", 5000) + data[27:])
    with pytest.raises(FormatError, match="expected FBX version 6000 to 8999, found 5000"):
        load(tmp_path / "b.fbx")


def limb(order: int, angles: tuple[float, float, float], before: tuple[float, float, float]) -> Any:
    rows = [
        make("P", "RotationActive", "bool", "", "", 1),
        make("P", "RotationOrder", "enum", "", "", order),
        make("P", "PreRotation", "Vector3D", "Vector", "", *before),
        make("P", "Lcl Rotation", "Lcl Rotation", "", "A", *angles),
    ]
    table = make("Properties70", children=rows)
    return make("Model", np.int64(1), "m\x00\x01Model", "LimbNode", children=[table])


@pytest.mark.parametrize(("order", "axes"), [(0, "xyz"), (1, "xzy"), (2, "yzx"), (3, "yxz"), (4, "zxy"), (5, "zyx")])
def test_every_order_of_turns_and_pre_rotations(tmp_path: Path, order: int, axes: str) -> None:
    angles = {"x": 10.0, "y": 20.0, "z": 30.0}
    path = fbx(tmp_path, make("Objects", children=[limb(order, (10.0, 20.0, 30.0), (0.0, 0.0, 90.0))]))
    rotation = rot.identity()
    for axis in axes:  # the first one named acts on the vector first
        rotation = rot.multiply(rot.about(axis, np.radians(angles[axis])), rotation)
    before = rot.about("z", np.pi / 2)
    # at rest the pre-rotation is applied, and it is part of the rest pose here
    wanted = rot.multiply(rot.multiply(before, rotation), rot.conjugate(before))
    read = load(path, up="y").motion().rotations[0, 0]
    assert float(rot.angle_between(read, wanted)) < 1e-7


def test_units_and_upward_axis_of_fbx(tmp_path: Path) -> None:
    rows = [make("P", "UnitScaleFactor", "double", "Number", "", 100.0), make("P", "UpAxis", "int", "Integer", "", 2)]
    place = make("Properties70", children=[make("P", "Lcl Translation", "", "", "A", 1.0, 2.0, 3.0)])
    model = make("Model", np.int64(1), "m\x00\x01Model", "LimbNode", children=[place])
    settings_ = make("GlobalSettings", children=[make("Properties70", children=rows)])
    motion = load(fbx(tmp_path, settings_, make("Objects", children=[model]))).motion()
    np.testing.assert_allclose(motion.translation, [[1, 3, -2]], atol=1e-12)


def test_a_character_comes_out_of_a_gltf_file(tmp_path: Path) -> None:
    motion = mutations.small_motion()
    save(motion, tmp_path / "a.glb")
    character = read_character(tmp_path / "a.glb")
    again = tmp_path / "b.glb"
    save(
        Motion(character.skeleton, motion.translation, motion.rotations, 30.0),
        again,
        options=WriteOptions(character=character),
    )
    other = read_character(again)
    np.testing.assert_allclose(other.skin.points, character.skin.points, atol=1e-6)
    np.testing.assert_array_equal(other.skin.triangles, character.skin.triangles)
    assert other.skin.palette == character.skin.palette
    bone = Skeleton(("a",), np.array([-1]), np.zeros((1, 3)))
    with pytest.raises(RequestError, match="retarget the motion first"):
        save(Motion(bone, np.zeros((1, 3)), rot.identity(1, 1), 30), again, options=WriteOptions(character=character))


def test_units_are_no_choice(tmp_path: Path) -> None:
    for suffix in ("fbx", "usdc"):
        with pytest.raises(RequestError, match="leave them out"):
            save(mutations.small_motion(), tmp_path / f"a.{suffix}", options=WriteOptions(units="inch"))


def test_usd_is_what_its_own_library_reads(tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.Usd", reason="usd-core is not installed")
    from pxr import Gf, UsdGeom, UsdSkel

    motion = mutations.small_motion()
    save(motion, tmp_path / "a.usda")
    stage = usd.Stage.Open(str(tmp_path / "a.usda"))
    assert (stage.GetTimeCodesPerSecond(), UsdGeom.GetStageUpAxis(stage)) == (30.0, "Y")
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    skeleton = UsdSkel.Skeleton(next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton)))
    query = UsdSkel.Cache().GetSkelQuery(skeleton)
    places = joint_positions(motion)
    for frame in range(len(motion)):
        transforms = query.ComputeJointSkelTransforms(frame)
        ours = [Gf.Matrix4d(matrix).ExtractTranslation() for matrix in transforms]
        np.testing.assert_allclose(np.array(ours), places[frame], atol=1e-5)


def test_usd_there_and_back(tmp_path: Path) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    motion = mutations.small_motion()
    moved = Motion(motion.skeleton, motion.translation + np.eye(3)[0], motion.rotations, motion.fps)
    save(Take("pair", {"a b": motion, "b": moved}), tmp_path / "a.usdc")
    take = load(tmp_path / "a.usdc")
    assert list(take.tracks) == ["a b", "b"]
    for track, wanted in (("a b", motion), ("b", moved)):
        back = take.motion(track)
        assert (back.fps, back.skeleton.names) == (30.0, motion.skeleton.names)
        np.testing.assert_allclose(joint_positions(back), joint_positions(wanted), atol=1e-5)


def test_usd_that_refers_to_other_files_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    (tmp_path / "a.usda").write_text("#usda 1.0\n(\n    subLayers = [@/etc/hostname@]\n)\n")
    with pytest.raises(FormatError, match="only files that stand alone are read"):
        load(tmp_path / "a.usda")
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    with pytest.raises(FormatError, match=r"expected a skeleton \(UsdSkel\), found none"):
        load(tmp_path / "a.usda")
    (tmp_path / "a.usdc").write_bytes(b"PXR-USDC" + bytes(100))
    with pytest.raises(FormatError, match=r"a\.usdc: usd-core cannot read it; is the file damaged"):
        load(tmp_path / "a.usdc")


def test_a_karate_kata_in_fbx(data_folder: Path) -> None:
    loaded = read(data_folder / "fbx" / "135_01.fbx")
    motion = loaded.take.motion()
    assert (len(motion), motion.fps, len(motion.skeleton)) == (1517, 30.0, 22)
    # where Blender 5.0.1 puts them 15 s in, by tests/clients/check.py
    assert 1.5 < motion.skeleton.height < 1.9
    assert joint_positions(motion)[:, :, 1].min() > -0.05
