"""Damaged files: bytes of a good file changed as disks, mailers and malice change them, and what readers do with them.

By hand, for as many as one likes of every reader, or of those named:

    PYTHONPATH=tests python tests/formats/mutations.py 10000 [small.usdc ...]
    PYTHONPATH=tests python tests/formats/mutations.py memory

Every file is read in this process, which may take 2 GB of address space more than it has; a reader must give a take
or raise FormatError, within 5 seconds. USD's native code runs in a process of its own for each file, as always, which
is forked from one that has usd-core loaded, or else ten thousand files would take an hour.

The second prints how much memory reading takes, by Python's and NumPy's own account: of good files of some megabytes as
a multiple of the file, and of damaged small ones the most of all beyond ten times the file.
"""

from __future__ import annotations

import base64
import contextlib
import importlib.util
import io
import json
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time
import tracemalloc
import warnings
import zipfile
from pathlib import Path
from types import SimpleNamespace

import fbx_files
import numpy as np

import gltf_files
from kinetograph import rotations as rot
from kinetograph.errors import KinetographError
from kinetograph.formats import read, read_character, save
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

SLOW = 5.0  # seconds
CHARACTERS = (".glb", ".vrm")
"""Suffixes of files that are read as characters too."""

_SPECIAL = (
    *(b"\x00" * 4, b"\xff" * 4, b"\x7f\xff\xff\xff", b"\xff\xff\xff\x7f"),
    *(b"1e999", b"nan", b"-1", b"{", b"}", b"\n"),
)


def mutate(data: bytes, rng: np.random.Generator) -> bytes:
    """One to eight changes to the bytes of a file."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 9))):
        at = int(rng.integers(0, max(len(out), 1)))
        size = int(rng.integers(1, 32))
        kind = int(rng.integers(0, 9))
        if kind == 0:
            out[at : at + 1] = bytes([int(rng.integers(0, 256))])
        elif kind == 1:
            del out[at : at + size]
        elif kind == 2:
            out[at:at] = bytes(rng.integers(0, 256, size, dtype=np.uint8))
        elif kind == 3:
            out[at:at] = out[at : at + size * 8]
        elif kind == 4:
            del out[at:]
        elif kind == 5:
            special = _SPECIAL[int(rng.integers(0, len(_SPECIAL)))]
            out[at : at + len(special)] = special
        elif kind == 6 and at + 8 <= len(out):
            struct.pack_into("<I", out, at, int(rng.choice([0, 1, 255, 2**16, 10**9, 2**31, 2**32 - 1])))
        elif kind == 7:  # another number where a number is
            digits = [i for i in range(at, min(at + 200, len(out))) if 48 <= out[i] < 58]
            if digits:
                out[digits[0] : digits[0] + 1] = bytes(rng.choice([b"9" * 9, b"-0", b"1e9", b"0", b"."]))
        elif kind == 8:
            other = int(rng.integers(0, max(len(out), 1)))
            out[at : at + size], out[other : other + size] = out[other : other + size], out[at : at + size]
    return bytes(out)


def mutate_archive(data: bytes, rng: np.random.Generator) -> bytes:
    """One member of a zip archive changed, with a checksum that fits."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    chosen = list(members)[int(rng.integers(0, len(members)))]
    members[chosen] = mutate(members[chosen], rng)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, member in members.items():
            archive.writestr(name, member)
    return out.getvalue()


_ODD: tuple[object, ...] = (
    *(None, True, False, -1, 0, 1, 2, 3, 255, 10**6, 2**31, 2**63, 10**30, 1e300, 0.5, "", "x", "1", "MAT4", [], [[]]),
    *({}, {"a": []}, [-1], [1, "a", None], [[1.0] * 16] * 3, ["a"] * 4, [1e300] * 4, [0] * 3, [0] * 16, [None] * 16),
)


def mutate_json(data: bytes, rng: np.random.Generator) -> bytes:
    """JSON with one or two values, anywhere in it, of another type or size, taken out, or put elsewhere."""
    document = json.loads(data)
    for _ in range(int(rng.integers(1, 3))):
        holders = [document]
        for holder in holders:  # which grows meanwhile
            inside = holder.values() if isinstance(holder, dict) else holder
            holders += [value for value in inside if isinstance(value, dict | list) and value]
        holder = holders[int(rng.integers(len(holders)))]
        keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        if not keys:
            continue
        key, pick = keys[int(rng.integers(len(keys)))], int(rng.integers(len(_ODD) + 8))
        if pick < len(_ODD):
            holder[key] = json.loads(json.dumps(_ODD[pick]))
        elif pick < len(_ODD) + 4:
            del holder[key]
        else:
            holder[key] = json.loads(json.dumps(holders[int(rng.integers(len(holders)))]))
    return json.dumps(document).encode()


def mutate_glb(data: bytes, rng: np.random.Generator) -> bytes:
    """A GLB file with its JSON chunk changed as by `mutate_json`."""
    length = struct.unpack_from("<I", data, 12)[0]
    text = mutate_json(data[20 : 20 + length], rng)
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    return data[:8] + struct.pack("<3I", 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest


def mutant(good: bytes, rng: np.random.Generator) -> bytes:
    """A damaged file: its bytes changed or, of archives and of glTF, mostly what is in them."""
    inside = rng.random() < 0.7
    if inside and good[:2] == b"PK":
        return mutate_archive(good, rng)
    if inside and good[:4] == b"glTF":
        return mutate_glb(good, rng)
    if inside and good[:1] == b"{":
        return mutate_json(good, rng)
    return mutate(good, rng)


def fuzz(name: str, good: bytes, count: int, seed: int, folder: Path) -> tuple[int, int, float]:
    """Read ``count`` damaged files: how many were still motions, how many were refused, and the slowest in seconds."""
    rng = np.random.default_rng(seed)
    fine = refused = 0
    slowest, one_line = 0.0, True
    path = folder / name
    for number in range(count):
        data = mutant(good, rng)
        path.write_bytes(data)
        start = time.perf_counter()
        try:
            read(path)
            if path.suffix in CHARACTERS:
                read_character(path)
            fine += 1
        except KinetographError as error:
            refused += 1
            one_line = one_line and "\n" not in str(error)
        except BaseException:
            (folder / f"failed-{name}").write_bytes(data)
            sys.stderr.write(f"{name}: file {number} of seed {seed} is kept in {folder}\n")
            raise
        took = time.perf_counter() - start
        assert took < SLOW, f"{name} {number}: {took:.1f} s"
        slowest = max(slowest, took)
    assert one_line, f"{name}: an error of more than one line"
    return fine, refused, slowest


def small_motion(frames: int = 5) -> Motion:
    """A small person who turns while walking."""
    names = ("Hips", "Chest", "Head", "LeftArm", "RightArm")
    names += ("LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg")
    parents = np.array([-1, 0, 1, 1, 1, 0, 5, 6, 0, 8])
    offsets = np.array(
        [[0, 0.9, 0], [0, 0.4, 0], [0, 0.2, 0], [0.2, 0, 0], [-0.2, 0, 0], [0.1, 0, 0], [0, -0.4, 0], [0, -0.4, 0],
         [-0.1, 0, 0], [0, -0.4, 0]]
    )  # fmt: skip
    rotations = rot.exp(np.random.default_rng(5).normal(0, 0.2, (frames, len(names), 3)))
    path = np.column_stack([np.zeros(frames), np.full(frames, 0.9), np.linspace(0, 0.1, frames)])
    return Motion(Skeleton(names, parents, offsets), path, rotations, 30.0)


def rng_places() -> np.ndarray:
    """Positions of 22 joints in three frames."""
    return np.random.default_rng(6).normal(0, 0.4, (3, 22, 3))


ASF = """:version 1.10
:units
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name leg
    direction 0 -1 0
    length 7
    axis 0 0 20 XYZ
    dof rx ry rz
  end
  begin
    id 2
    name shin
    direction 0 -1 0
    length 6
    axis 10 0 0 XYZ
    dof rx
  end
:hierarchy
  begin
    root leg
    leg shin
  end
"""
AMC = """:FULLY-SPECIFIED
:DEGREES
1
root 1 17 2 10 20 30
leg 5 6 7
shin 20
2
root 1 17.5 2.5 11 21 31
leg 5.5 6.5 7.5
shin 25
"""
CSV = b"# units: m\nt,hand.x,hand.y,hand.z\n0,1,2,3\n0.1,1,,3\n0.2,1.5,2,3\n"


def c3d_bytes(frames: int = 4, points: int = 3) -> bytes:
    """A small C3D file: Intel, reals, millimetres."""

    def parameter(group: int, name: bytes, kind: int, sides: bytes, data: bytes) -> bytes:
        body = struct.pack("bB", kind, len(sides)) + sides + data + b"\x00"
        return struct.pack("bb", len(name), group) + name + struct.pack("<h", len(body) + 2) + body

    rate = struct.pack("<f", 50.0)
    header = struct.pack("<BB5H f HH f", 2, 0x50, points, 0, 1, frames, 10, -1.0, 3, 0, 50.0).ljust(512, b"\x00")
    body = b"\x01\x50\x01\x54" + struct.pack("bb", 5, -1) + b"POINT" + struct.pack("<h", 3) + b"\x00"
    body += parameter(1, b"SCALE", 4, b"", struct.pack("<f", -1.0)) + parameter(1, b"RATE", 4, b"", rate)
    body += parameter(1, b"UNITS", -1, b"\x02", b"mm") + parameter(1, b"LABELS", -1, b"\x04\x03", b"HEADHIP FOOT")
    rows = np.zeros((frames, points, 4), dtype="<f4")
    rows[..., :3] = np.arange(points)[::-1, None] * 700.0 + np.arange(frames)[:, None, None]
    rows[0, -1, 0] = 0.5  # not at the very origin, where a marker is taken as missing
    return header + body.ljust(512, b"\x00") + rows.tobytes()


def gltf_text() -> str:
    """A small glTF file in text: a spline, and numbers some of which are replaced."""
    times, tangents = np.array([0, 2], dtype="<f4"), np.zeros((2, 3, 3), dtype="<f4")
    replaced, at = np.array([[8, 0, 0], [12, 0, 0]], dtype="<f4"), np.array([4, 5], dtype="<u2")
    parts = [array.tobytes() for array in (times, tangents, replaced, at)]
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    data = b"".join(parts)
    numbers = {"componentType": 5126, "count": 2}
    sparse = {"count": 2, "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 2}}
    sampler = {"input": 0, "output": 1, "interpolation": "CUBICSPLINE"}
    document = {
        "asset": {"version": "2.0"},
        "nodes": [{"name": "a", "children": [1]}, {"name": "b", "translation": [0, 1, 0]}],
        "animations": [
            {"samplers": [sampler], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}
        ],
        "accessors": [
            numbers | {"bufferView": 0, "type": "SCALAR"},
            numbers | {"bufferView": 1, "type": "VEC3", "count": 6, "sparse": sparse},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part)}
            for start, part in zip(starts, parts, strict=False)
        ],
        "buffers": [
            {"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}
        ],
    }
    return json.dumps(document, indent=1)


def fbx_scenes() -> dict[str, bytes]:
    """A small scene with layers and curves of every kind, in text and of version 6, in text and binary."""
    cubic = [fbx_files.CUBIC | fbx_files.USER | 0x3000000, fbx_files.CUBIC | fbx_files.AUTO | 0x4000, 0x208, 0x102]
    data = [[1.0, -1.0, fbx_files.weights(0.5, 0.2), 0.0]] * 4
    soft = fbx_files.Keys([0.0, 0.1, 0.3, 0.4], [0.0, 20.0, 10.0, 5.0], cubic, data, "M")
    layers = [
        fbx_files.Layer({(bone, "Lcl Rotation", axis): soft for bone in (0, 1) for axis in "XYZ"}, {"Weight": 100.0}),
        fbx_files.Layer({(1, "Lcl Scaling", "X"): fbx_files.Keys([0.0, 1.0], [1.0, 2.0])}, {"BlendMode": 2}),
    ]
    arm = {"Lcl Translation": (0.0, 1.0, 0.0), "InheritType": 2, "RotationOrder": 3, "RotationActive": 1}
    bones = [
        fbx_files.Bone("hips", -1, {"PreRotation": (0.0, 10.0, 90.0), "Lcl Scaling": (1.0, 2.0, 1.5)}),
        *(fbx_files.Bone(f"bone{i}", i, arm) for i in range(3)),
    ]
    stacks = [fbx_files.Stack("walk", layers), fbx_files.Stack("run", layers[:1])]
    scene = fbx_files.scene(bones, stacks, {"UnitScaleFactor": 2.54, "UpAxis": 2, "FrontAxis": 1, "FrontAxisSign": -1})
    old = fbx_files.as_version_6(scene)
    return {
        "layers.fbx": fbx_files.binary(scene, 7500),
        "text.fbx": fbx_files.text(scene),
        "text6.fbx": fbx_files.text(old, 6100),
        "binary6.fbx": fbx_files.binary(old, 6100),
    }


def good_files(folder: Path) -> dict[str, bytes]:
    """A good file a reader, by the name to give it; an ``.asf`` lies in the folder for the ``.amc``."""
    (folder / "small.asf").write_text(ASF)
    files = {"small.amc": AMC.encode(), "skeleton.asf": ASF.encode(), "path.csv": CSV, "markers.c3d": c3d_bytes()}
    for suffix in ("bvh", "glb", "fbx", "npz"):
        path = folder / f"good.{suffix}"
        save(small_motion(), path)
        files[f"small.{suffix}"] = path.read_bytes()
    files |= fbx_scenes()
    side = [1, 0, 0, 0, 0.1, 1, 0, 0, 0, 1, 0, 0, 0, 0.1]
    rows = [[0.1, 0, 0.9, 0, 1, 0, 0, 0, *[1, 0, 0, 0] * 2, *side, *side]] * 3
    files["clip.json"] = ('{"Loop": "none", "Frames": ' + str(rows) + "}").encode()
    files["sparse.gltf"] = gltf_text().encode()
    files["avatar.vrm"] = json.dumps(gltf_files.avatar(gltf_files.VRM1)).encode()
    files["old_avatar.vrm"] = json.dumps(gltf_files.avatar(gltf_files.VRM0, -1.0)).encode()
    files["two.gltf"] = json.dumps(gltf_files.two_animations()).encode()
    pose = folder / "pose.npz"
    np.savez_compressed(pose, poses=np.full((4, 66), 0.1), trans=np.zeros((4, 3)), mocap_framerate=np.array(30.0))
    files["pose.npz"] = pose.read_bytes()
    positions = folder / "positions.npy"
    np.save(positions, rng_places())
    files["positions.npy"] = positions.read_bytes()
    aist = {"smpl_poses": np.full((3, 72), 0.1), "smpl_trans": np.full((3, 3), 90.0), "smpl_scaling": np.full(1, 93.0)}
    np.savez(folder / "aist.npz", **aist)
    files["aist.npz"] = (folder / "aist.npz").read_bytes()
    return files


def forked(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
    """What `subprocess.run` does for the reader of USD, without starting Python anew."""
    from kinetograph.formats.usd import child as usd_child

    with tempfile.TemporaryFile("w+", errors="replace") as said:
        child = os.fork()
        if child == 0:
            os.dup2(said.fileno(), 2)
            code = 0
            try:
                usd_child.main(*command[-2:])
            except SystemExit as end:
                os.write(2, f"{end}\n".encode(errors="replace"))
                code = 1
            except BaseException:
                code = 1
            os._exit(code)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        said.seek(0)
        return subprocess.CompletedProcess(command, status, "", said.read())


def read_usd_in_forks() -> None:
    """Load usd-core, once for all processes that read USD from now on; it must not have begun any threads before."""
    os.environ["PXR_WORK_THREAD_LIMIT"] = "1"  # a fork has none of them, and would wait for them for ever
    with contextlib.suppress(ImportError):
        from pxr import Sdf, Usd, UsdGeom, UsdSkel  # noqa: F401

        from kinetograph.formats.usd import reader as usd_read

        usd_read.subprocess = SimpleNamespace(run=forked, TimeoutExpired=subprocess.TimeoutExpired)  # type: ignore


def usd_files(folder: Path) -> dict[str, bytes]:
    """Good USD files; none where usd-core is not installed."""
    if importlib.util.find_spec("pxr") is None:
        return {}
    files = {}
    for suffix in ("usda", "usdc"):
        save(small_motion(), folder / f"good.{suffix}")
        files[f"small.{suffix}"] = (folder / f"good.{suffix}").read_bytes()
    return files


def peak(path: Path) -> int:
    """The most bytes that Python and NumPy held while a file was read; a file that is refused counts too."""
    tracemalloc.reset_peak()
    before = tracemalloc.get_traced_memory()[0]
    with contextlib.suppress(KinetographError):
        read(path)
    return tracemalloc.get_traced_memory()[1] - before


def long_files(folder: Path) -> dict[str, bytes]:
    """Good files of some megabytes."""
    files = {}
    for suffix in ("bvh", "glb", "fbx", "npz"):
        save(small_motion(20_000), folder / f"long.{suffix}")
        files[f"long.{suffix}"] = (folder / f"long.{suffix}").read_bytes()
    head, _, frame = AMC.partition("2\n")
    files["small_long.amc"] = (head + "".join(f"{i}\n{frame}" for i in range(2, 30_000))).encode()
    files["long.csv"] = CSV + b"".join(b"%.2f,1,2,3\n" % (i / 10) for i in range(3, 200_000))
    files["long.c3d"] = c3d_bytes(60_000)
    side = [1, 0, 0, 0, 0.1, 1, 0, 0, 0, 1, 0, 0, 0, 0.1]
    rows = [[0.1, 0, 0.9, 0, 1, 0, 0, 0, *[1, 0, 0, 0] * 2, *side, *side]] * 20_000
    files["terse.json"] = ('{"Loop": "none", "Frames": ' + str(rows) + "}").encode()
    numbers = "[" + ", ".join("[" + ", ".join(f"{value:.6f}" for value in row) + "]" for row in rows) + "]"
    files["long.json"] = ('{"Loop": "none", "Frames": ' + numbers + "}").encode()
    return files


def memory(count: int = 300) -> None:
    """Print what reading takes."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        small, long = good_files(folder), long_files(folder)
        for file, good in small.items():  # what is imported is not what is read
            (folder / file).write_bytes(good)
            read(folder / file)
        tracemalloc.start()
        for file, good in long.items():
            (folder / file).write_bytes(good)
            taken = peak(folder / file)
            print(
                f"{file:16} {len(good) / 1e6:6.1f} MB takes {taken / 1e6:6.1f} MB: {taken / len(good):4.1f} x the file"
            )
        rng = np.random.default_rng(1)
        for file, good in small.items():
            most = 0
            for _ in range(count):
                data = mutant(good, rng)
                (folder / file).write_bytes(data)
                most = max(most, peak(folder / file) - 10 * len(data))
            size = f"{len(good)} bytes"
            print(f"{file:16} {count} damaged files of {size}: at most 10 x the file and {most / 1e6:.1f} MB")


def main(count: int, only: list[str]) -> None:
    warnings.simplefilter("error")
    limit = 2 * 2**30
    read_usd_in_forks()
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + limit, resource.getrlimit(resource.RLIMIT_AS)[1]))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = good_files(folder) | usd_files(folder)
        for file, good in files.items():
            if only and file not in only:
                continue
            (folder / file).write_bytes(good)
            read(folder / file)
            fine, refused, slowest = fuzz(file, good, count, 1, folder)
            print(f"{file:14} {count} files: {fine} read, {refused} refused, slowest {slowest:.3f} s", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["memory"]:
        memory()
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000, sys.argv[2:])
