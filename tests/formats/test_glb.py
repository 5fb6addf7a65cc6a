"""GLB files, read back by a small parser of their own and by Khronos' validator."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.formats import body_capsules, load, rest_positions, save
from kinetograph.formats.capsules import LEFT, RIGHT
from kinetograph.formats.gltf import writer as glb
from kinetograph.formats.options import WriteOptions
from kinetograph.formats.surface import body_surface
from kinetograph.kinematics import forward
from kinetograph.motion import Motion, cut
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark, Skeleton
from kinetograph.take import Take

CLIENTS = Path(__file__).resolve().parents[1] / "clients"
COMPONENTS = {5126: np.dtype("<f4"), 5123: np.dtype("<u2"), 5125: np.dtype("<u4")}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    """A GLB file taken apart by the letter of the glTF 2.0 specification, and no further."""

    def __init__(self, data: bytes) -> None:
        magic, version, size = struct.unpack_from("<3I", data)
        assert (magic, version, size) == (0x46546C67, 2, len(data))
        length, kind = struct.unpack_from("<2I", data, 12)
        assert kind == 0x4E4F534A
        assert length % 4 == 0
        self.json: dict[str, Any] = json.loads(data[20 : 20 + length])
        size, kind = struct.unpack_from("<2I", data, 20 + length)
        assert kind == 0x004E4942
        assert 28 + length + size == len(data)
        self.binary = data[28 + length :]
        assert self.json["buffers"] == [{"byteLength": size}]

    def accessor(self, index: int) -> np.ndarray:
        entry = self.json["accessors"][index]
        view = self.json["bufferViews"][entry["bufferView"]]
        dtype, width = COMPONENTS[entry["componentType"]], WIDTHS[entry["type"]]
        offset = view["byteOffset"] + entry.get("byteOffset", 0)
        length = entry["count"] * width * dtype.itemsize
        assert offset % 4 == 0
        assert length <= view["byteLength"]
        assert view["byteOffset"] + view["byteLength"] <= len(self.binary)
        values = np.frombuffer(self.binary, dtype, entry["count"] * width, offset).reshape(-1, width)
        if "min" in entry:
            assert values.min(axis=0).tolist() == entry["min"]
            assert values.max(axis=0).tolist() == entry["max"]
        return values

    def world(self, frame: int | None) -> np.ndarray:
        """Matrices ``(N, 4, 4)`` of all nodes at a key of the animation, or at rest."""
        nodes = [dict(node) for node in self.json["nodes"]]
        for channel in self.json["animations"][0]["channels"] if frame is not None else []:
            sampler = self.json["animations"][0]["samplers"][channel["sampler"]]
            output = self.accessor(sampler["output"])
            assert len(output) == len(self.accessor(sampler["input"]))
            nodes[channel["target"]["node"]][channel["target"]["path"]] = output[frame]
        world = np.tile(np.eye(4), (len(nodes), 1, 1))
        todo = [(i, np.eye(4)) for i in self.json["scenes"][0]["nodes"]]
        while todo:
            index, above = todo.pop()
            world[index] = above @ matrix(nodes[index])
            todo += [(child, world[index]) for child in nodes[index].get("children", [])]
        return world


def matrix(node: dict[str, Any]) -> np.ndarray:
    out = np.eye(4)
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    out[:3, :3] = rot.to_matrix(np.array([w, x, y, z], dtype=np.float64))
    out[:3, 3] = node.get("translation", (0, 0, 0))
    return out


def random_motion(skeleton: Skeleton, frames: int, seed: int = 0, fps: float = 30.0) -> Motion:
    """Smooth rotations of every joint, some beyond 180 degrees, along a wandering root path."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None, None] / fps
    swing = rng.uniform(-2.5, 2.5, (1, len(skeleton), 3)) * np.sin(t * rng.uniform(1, 4, (1, len(skeleton), 3)))
    path = np.cumsum(rng.normal(0, 0.01, (frames, 3)), axis=0) + np.array([0.5, 1.0, -2.0])
    return Motion(skeleton, path, rot.exp(swing), fps)


def chain(joints: int) -> Skeleton:
    names = tuple(f"joint {i}" for i in range(joints))
    return Skeleton(names, np.arange(-1, joints - 1), np.tile([0.0, 0.1, 0.02], (joints, 1)))


def humanoid() -> Skeleton:
    """Fifteen joints with roles, no end sites, a toe and a head that are points on other joints."""
    names = ["root", "chest", "neck"]
    parents, offsets = [-1, 0, 1], [(0.0, 0.9, 0), (0, 0.24, 0), (0, 0.22, 0)]
    roles = {"hips": Landmark(0), "chest": Landmark(1), "neck": Landmark(2), "head": Landmark(2, np.array([0, 0.2, 0]))}
    for side, x in (("left", 1), ("right", -1)):
        for part, parent, offset in (
            ("hip", 0, (0.085 * x, 0, 0)),
            ("knee", len(names), (0, -0.42, 0)),
            ("foot", len(names) + 1, (0, -0.41, 0)),
            ("shoulder", 1, (0.18 * x, 0.24, 0)),
            ("elbow", len(names) + 3, (0, -0.27, 0)),
            ("hand", len(names) + 4, (0, -0.26, 0)),
        ):
            roles[f"{side}_{part}"] = Landmark(len(names))
            names.append(f"{side}_{part}")
            parents.append(parent)
            offsets.append(offset)
        roles[f"{side}_toe"] = Landmark(len(names) - 4, np.array([0, -0.05, 0.15]))
    return Skeleton(tuple(names), np.array(parents), np.array(offsets), roles=roles)


def stretchy() -> Motion:
    motion = random_motion(humanoid(), 20, seed=3)
    wobble = 1 + 0.1 * np.sin(np.arange(20))[:, None, None]
    return replace(motion, bones=motion.skeleton.offsets * wobble)


def pair() -> Take:
    leader, follower = random_motion(humanoid(), 12, seed=1), random_motion(chain(5), 30, seed=2, fps=120.0)
    beat = Signal(np.zeros((3, 1)), ("beat",), "1", 10.0)
    return Take("dance", {"leader": leader, "beat": beat, "follower": follower})


CASES: dict[str, Motion | Take] = {
    "humanoid": random_motion(humanoid(), 40),
    "single frame": random_motion(humanoid(), 1),
    "lone joint": random_motion(chain(1), 5),
    "no roles": random_motion(chain(7), 25, fps=119.88),
    "joints in one place": random_motion(replace(chain(3), offsets=np.zeros((3, 3))), 4),
    "stretching bones": stretchy(),
    "two characters": pair(),
    "ten thousand frames": random_motion(chain(3), 10_000, fps=120.0),
}


def characters(what: Motion | Take) -> dict[str, Motion]:
    tracks = {"motion": what} if isinstance(what, Motion) else dict(what.tracks)
    return {name: track for name, track in tracks.items() if isinstance(track, Motion)}


@pytest.mark.parametrize("case", CASES)
def test_the_animation_through_node_matrices_is_forward_kinematics(case: str) -> None:
    file = Glb(glb.encode(CASES[case]))
    for track, motion in characters(CASES[case]).items():
        top = next(i for i, node in enumerate(file.json["nodes"]) if node["name"] == track)
        joints = slice(top + 1, top + 1 + len(motion.skeleton))
        assert tuple(node["name"] for node in file.json["nodes"][joints]) == motion.skeleton.names
        positions, rotations = forward(motion)
        for frame in {0, min(len(c) for c in characters(CASES[case]).values()) - 1}:
            world = file.world(frame)[joints]
            assert np.abs(world[:, :3, 3] - positions[frame]).max() < 1e-5
            assert np.abs(world[:, :3, :3] - rot.to_matrix(rotations[frame])).max() < 1e-5


@pytest.mark.parametrize("case", CASES)
def test_the_skin_moves_each_capsule_with_its_joint(case: str) -> None:
    file = Glb(glb.encode(CASES[case]))
    world = file.world(0)
    for skin, mesh, motion in zip(
        file.json["skins"], file.json["meshes"], characters(CASES[case]).values(), strict=True
    ):
        attributes = mesh["primitives"][0]["attributes"]
        points = file.accessor(attributes["POSITION"]).astype(np.float64)
        joints = file.accessor(attributes["JOINTS_0"])
        weights = file.accessor(attributes["WEIGHTS_0"])
        assert joints[:, 1:].max() == 0
        assert weights[0].tolist() == [1, 0, 0, 0]
        assert np.ptp(weights, axis=0).max() == 0
        bind = file.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        move = world[skin["joints"]] @ bind
        skinned = np.einsum("vij,vj->vi", move[joints[:, 0]], np.c_[points, np.ones(len(points))])[:, :3]
        body = body_surface(motion.skeleton)
        local = body.points - rest_positions(motion.skeleton)[body.joints]
        positions, rotations = forward(cut(motion, 0, 1))
        expected = positions[0, body.joints] + rot.rotate(rotations[0, body.joints], local)
        assert np.abs(skinned - expected).max() < 1e-5


@pytest.mark.parametrize("case", CASES)
def test_keys_start_at_zero_and_rise_and_quaternions_are_unit_and_continuous(case: str) -> None:
    file = Glb(glb.encode(CASES[case]))
    animation = file.json["animations"][0]
    for sampler in animation["samplers"]:
        times = file.accessor(sampler["input"])[:, 0]
        assert times[0] == 0
        assert np.all(np.diff(times) > 0)
    for channel in animation["channels"]:
        if channel["target"]["path"] == "rotation":
            q = file.accessor(animation["samplers"][channel["sampler"]]["output"])
            assert np.abs(np.linalg.norm(q, axis=1) - 1).max() < 1e-6
            assert np.all(np.sum(q[1:] * q[:-1], axis=1) > 0)


@pytest.mark.parametrize("skeleton", [humanoid(), chain(1), chain(4)], ids=["humanoid", "lone joint", "chain"])
def test_the_body_is_closed_and_faces_outward(skeleton: Skeleton) -> None:
    body = body_surface(skeleton)
    assert np.abs(np.linalg.norm(body.normals, axis=1) - 1).max() < 1e-9
    a, b, c = (body.points[body.triangles[:, i]] for i in range(3))
    faces = np.cross(b - a, c - a)
    assert np.linalg.norm(faces, axis=1).min() > 0
    for corner in range(3):
        assert np.all(np.sum(faces * body.normals[body.triangles[:, corner]], axis=1) > 0)
    edges = {(int(t[i]), int(t[(i + 1) % 3])) for t in body.triangles for i in range(3)}
    assert len(edges) == 3 * len(body.triangles)
    assert all((stop, start) in edges for start, stop in edges)


def test_the_body_of_a_person_has_sides_and_human_proportions() -> None:
    skeleton = humanoid()
    parts = {(bone.part, bone.side): bone for bone in body_capsules(skeleton)}
    assert {part for part, _ in parts} >= {"torso", "pelvis", "thigh", "shin", "foot", "upper arm", "forearm", "hand"}
    assert {side for part, side in parts if part == "thigh"} == {LEFT, RIGHT}
    assert parts["torso", 0].radii[0] > parts["thigh", 1].radii[0] > parts["hand", 1].radii[0]
    body = body_surface(skeleton)
    extent = np.ptp(body.points, axis=0)
    assert 1.5 < extent[1] < 1.9
    assert np.all(body.points[body.joints == skeleton.names.index("left_hand")][:, 0] > 0)
    assert body.points[np.isin(body.joints, [5, 11]), 2].max() > 0.15  # the feet reach the toes' landmarks


def test_only_the_tints_in_use_are_written_and_sides_differ() -> None:
    file = Glb(glb.encode(CASES["humanoid"]))
    assert sorted(m["name"] for m in file.json["materials"]) == ["left", "middle", "right"]
    colours = {tuple(m["pbrMetallicRoughness"]["baseColorFactor"]) for m in file.json["materials"]}
    assert len(colours) == 3
    assert len(Glb(glb.encode(CASES["no roles"])).json["materials"]) == 1


def test_quaternions_off_unit_length_are_written_at_unit_length() -> None:
    motion = CASES["humanoid"]
    assert isinstance(motion, Motion)
    long = Glb(glb.encode(replace(motion, rotations=motion.rotations * 1.0009)))
    for channel in long.json["animations"][0]["channels"][1:]:
        q = long.accessor(long.json["animations"][0]["samplers"][channel["sampler"]]["output"])
        assert np.abs(np.linalg.norm(q, axis=1) - 1).max() < 1e-6


def test_save_writes_what_encode_gives(tmp_path: Path) -> None:
    save(CASES["humanoid"], tmp_path / "person.glb")
    assert (tmp_path / "person.glb").read_bytes() == glb.encode(CASES["humanoid"])


def test_requests_that_glb_cannot_meet(tmp_path: Path) -> None:
    beat = Signal(np.zeros((3, 1)), ("beat",), "1", 10.0)
    with pytest.raises(RequestError, match=r"found a signal; save it as \.csv"):
        glb.encode(beat)
    with pytest.raises(RequestError, match="take 'drum' has only the signals beat"):
        glb.encode(Take("drum", {"beat": beat}))
    with pytest.raises(RequestError, match="always in metres, Y up; found units 'inch'"):
        glb.write(CASES["humanoid"], tmp_path / "a.glb", WriteOptions(units="inch"))
    with pytest.raises(RequestError, match="2 frames at 1e\\+50 fps are too long and dense"):
        glb.encode(random_motion(chain(1), 2, fps=1e50))


def validate(paths: list[Path]) -> None:
    """Run Khronos' validator, which must find no error, no warning, and nothing else either."""
    if shutil.which("node") is None or not (CLIENTS / "node_modules" / "gltf-validator").is_dir():
        pytest.skip("gltf-validator is not installed: run npm ci in tests/clients")
    command = ["node", "validate_glb.mjs", *map(str, paths)]
    done = subprocess.run(command, cwd=CLIENTS, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    reports = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(reports) == len(paths)
    assert [r["messages"] for r in reports] == [[]] * len(paths)


def test_the_validator_accepts_every_case(tmp_path: Path) -> None:
    paths = [tmp_path / f"{case}.glb" for case in CASES]
    for path, what in zip(paths, CASES.values(), strict=True):
        glb.write(what, path)
    validate(paths)


def test_the_validator_accepts_recorded_skeletons(data_folder: Path, tmp_path: Path) -> None:
    recordings = ["walks/15_01.bvh", "salsa/Easy_03_leader.bvh", "walks/humanoid3d_long_walk3.txt"]
    paths = []
    for recording, joints in zip(recordings, (22, 27, 15), strict=True):
        take = load(data_folder / recording)
        motion = next(iter(characters(take).values()))
        assert len(motion.skeleton) == joints
        paths.append(tmp_path / f"{joints}.glb")
        glb.write(take, paths[-1])
    validate(paths)


def test_the_validator_refuses_a_damaged_file(tmp_path: Path) -> None:
    data = glb.encode(CASES["humanoid"])
    (tmp_path / "damaged.glb").write_bytes(data.replace(b'"count":40', b'"count":41', 1))
    with pytest.raises(AssertionError, match="ACCESSOR"):
        validate([tmp_path / "damaged.glb"])
