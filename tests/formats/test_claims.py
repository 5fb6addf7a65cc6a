"""Small files that claim much: refused by arithmetic, before memory is taken; USD that would read other files."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import mutations
import numpy as np
import pytest

from gltf_files import Json, Numbers, animated, spun, turned, written
from kinetograph.errors import FormatError
from kinetograph.formats import read, save

KINDS = ("overlapping accessors", "keys far apart", "zeros that are not there", "a million nodes", "compressed doubles",
         "compressed bytes")  # fmt: skip
MOST = 120  # MB beyond what importing the package and reading a good file take

MEASURE = """
import resource, sys, time
from pathlib import Path
from kinetograph.errors import KinetographError
from kinetograph.formats import read
read(sys.argv[1])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
start = time.perf_counter()
try:
    read(sys.argv[2])
    said = "read"
except KinetographError as error:
    said = str(error)
took = time.perf_counter() - start
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024, took, said)
"""


def measured(good: Path, path: Path) -> tuple[float, float, str]:
    """Megabytes and seconds that reading a file takes in a process of its own, and what came of it."""
    ran = subprocess.run([sys.executable, "-c", MEASURE, good, path], capture_output=True, text=True, check=True)
    megabytes, seconds, said = ran.stdout.split(maxsplit=2)
    return float(megabytes), float(seconds), said


def overlapping() -> Json:
    """A thousand samplers whose keys are all of one buffer."""
    nodes = [{"name": "a"}]
    document = animated(nodes, [("all", [spun(90)])])
    numbers = Numbers()
    numbers.add(np.arange(50_000))
    document |= numbers.document()
    entry = document["accessors"][0]
    document["accessors"] = [dict(entry) for _ in range(1000)]
    channel = {"target": {"node": 0, "path": "translation"}}
    animation = {
        "samplers": [{"input": i, "output": i} for i in range(1000)],
        "channels": [channel | {"sampler": i} for i in range(1000)],
    }
    return document | {"animations": [animation]}


def far_apart() -> Json:
    keys = (0, "rotation", [0.0, 20_000.0], [turned(0), turned(90)])
    return animated([{"name": f"n{i}"} for i in range(60)], [("slow", [keys])])


def zeros() -> Json:
    document = animated([{"name": "a"}], [("turn", [spun(90)])])
    for accessor in document["accessors"]:
        accessor["count"] = 2_000_000
        del accessor["bufferView"]
    return document


def packed(path: Path, rotations: np.ndarray, **more: np.ndarray) -> Path:
    motion = mutations.small_motion()
    skeleton = motion.skeleton
    arrays = {
        "names": np.array(skeleton.names), "parents": skeleton.parents, "offsets": skeleton.offsets,
        "end_parents": skeleton.end_parents, "end_offsets": skeleton.end_offsets, "fps": np.array(30.0),
        "translation": np.zeros((len(rotations), 3)), "rotations": rotations, **more,
    }  # fmt: skip
    np.savez_compressed(path, **{f"motion/{name}": value for name, value in arrays.items()})
    return path


def claims(folder: Path) -> dict[str, tuple[Path, str]]:
    """Files by what they do, with what must be said of them."""
    many = folder / "many.gltf"
    many.write_text('{"nodes":[' + "{}," * 1_000_000 + "{}]}")
    ones = np.ones((60_000, 10, 4))
    small = np.zeros((400_000, 10, 4), dtype=np.int8)
    return {
        "overlapping accessors": (written(folder / "a.gltf", overlapping()), "numbers are too many for a file of its"),
        "keys far apart": (written(folder / "b.gltf", far_apart()), "are too many; give --fps"),
        "zeros that are not there": (written(folder / "c.gltf", zeros()), "numbers are too many for a file of its"),
        "a million nodes": (many, "1000002 objects in 3000014 bytes of JSON are too many"),
        "compressed doubles": (packed(folder / "d.npz", ones), "too many for a file of"),
        "compressed bytes": (packed(folder / "e.npz", small), "too many for a file of"),
    }


@pytest.mark.parametrize("kind", KINDS)
def test_claims_are_refused_before_memory_is_taken(tmp_path: Path, kind: str) -> None:
    path, expected = claims(tmp_path)[kind]
    save(mutations.small_motion(), tmp_path / f"good{path.suffix.replace('gltf', 'glb')}")
    megabytes, seconds, said = measured(tmp_path / f"good{path.suffix.replace('gltf', 'glb')}", path)
    assert expected in said
    assert megabytes < MOST
    assert seconds < 5


def test_still_motions_that_compress_well_are_read(tmp_path: Path) -> None:
    still = np.zeros((10_000, 10, 4))
    still[..., 0] = 1.0
    path = packed(tmp_path / "still.npz", still)
    assert path.stat().st_size < 100_000
    assert len(read(path).take.motion()) == 10_000


def test_an_archive_whose_member_is_longer_than_its_header_says(tmp_path: Path) -> None:
    path = packed(tmp_path / "a.npz", mutations.small_motion().rotations)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["motion/rotations.npy"] += bytes(1000)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    with pytest.raises(FormatError, match=r"motion/rotations\.npy: expected .* numbers or names, found"):
        read(path)


def test_external_buffers_that_many_entries_name_are_read_once(tmp_path: Path) -> None:
    document = animated([{"name": "a"}], [("turn", [spun(90)])])
    (tmp_path / "data.bin").write_bytes(bytes(1_000_000))
    names = ["data.bin", "./data.bin", "%64ata.bin"]
    document["buffers"] = [{"byteLength": 1_000_000, "uri": names[i % 3]} for i in range(3000)]
    document["bufferViews"] = [{"buffer": i, "byteLength": 1_000_000} for i in range(3000)]
    good = written(tmp_path / "good.gltf", animated([{"name": "a"}], [("turn", [spun(90)])]))
    megabytes, seconds, _ = measured(good, written(tmp_path / "a.gltf", document))
    assert megabytes < MOST
    assert seconds < 5
    document["buffers"][0]["byteLength"] = 10**12
    with pytest.raises(FormatError, match="expected 1000000000000 bytes, found 1000000"):
        read(written(tmp_path / "a.gltf", document))


# ---- USD ----

USDA = """#usda 1.0
(
    metersPerUnit = 1
    timeCodesPerSecond = 30
    upAxis = "Y"
    %s
)
def SkelRoot "Person" (
    %s
) {
    def Skeleton "Rig" (prepend apiSchemas = ["SkelBindingAPI"]) {
        uniform token[] joints = ["a"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))]
        rel skel:animationSource = </Person/Walk>
    }
    def SkelAnimation "Walk" {
        uniform token[] joints = ["a"]
        float3[] translations.timeSamples = { 0: [(0, 0, 0)], %d: [(0, 0, 1)] }
        quatf[] rotations = [(1, 0, 0, 0)]
        half3[] scales = [(1, 1, 1)]
    }
    %s
}
class "Other" {
}
"""


def usd(path: Path, layer: str = "", prim: str = "", last: int = 10, inside: str = "") -> Path:
    path.write_text(USDA % (layer, prim, last, inside))
    return path


CLIPS = """clips = {
        dictionary default = {
            asset[] assetPaths = [@other.usda@]
            string primPath = "/Person"
            double2[] active = [(0, 0)]
            double2[] times = [(0, 0), (10, 10)]
            asset manifestAssetPath = @other.usda@
        }
    }"""
TEMPLATE = """clips = {
        dictionary default = {
            string templateAssetPath = "other.##.usda"
            string primPath = "/Person"
            double templateStartTime = 0
            double templateEndTime = 10
            double templateStride = 1
        }
    }"""
ARCS = {
    "sublayers": {"layer": "subLayers = [@other.usda@]"},
    "a reference": {"prim": "references = @other.usda@"},
    "a reference within": {"prim": "references = </Other>"},
    "a payload": {"prim": "payload = @other.usda@"},
    "a payload within": {"prim": "payload = </Other>"},
    "inherits": {"prim": "inherits = </Other>"},
    "specializes": {"prim": "specializes = </Other>"},
    "value clips": {"prim": CLIPS},
    "value clips of a template": {"prim": TEMPLATE},
    "relocates": {"layer": "relocates = { </Person/Rig> : </Person/Moved> }"},
    "variants": {
        "prim": 'variants = { string size = "big" }\n    prepend variantSets = "size"',
        "inside": 'variantSet "size" = {\n "big" (\n references = @other.usda@\n ) {\n }\n }',
    },
    "a variant that is not chosen": {
        "prim": 'prepend variantSets = "size"',
        "inside": 'variantSet "size" = {\n "big" {\n over "Rig" (\n payload = @other.usda@\n ) {\n }\n }\n }',
    },
}


@pytest.mark.parametrize("arc", list(ARCS))
def test_usd_with_composition_is_refused(tmp_path: Path, arc: str) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    usd(tmp_path / "other.usda")
    assert len(read(usd(tmp_path / "plain.usda")).take.motion()) == 11
    with pytest.raises(FormatError, match=r"(refers to|has) .*only files that stand alone are read: flatten it"):
        read(usd(tmp_path / "a.usda", **ARCS[arc]))


def test_usd_with_samples_far_apart_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    path = usd(tmp_path / "a.usda", last=900_000)
    assert path.stat().st_size < 1500
    megabytes, seconds, said = measured(usd(tmp_path / "good.usda"), path)
    assert "frames of joints are too many for a file of its size" in said
    assert megabytes < MOST
    assert seconds < 20  # most of it importing usd-core
