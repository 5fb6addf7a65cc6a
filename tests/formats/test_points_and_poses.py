"""C3D and NumPy archives: independent readers, textbook bytes, malicious archives."""

from __future__ import annotations

import io
import struct
import zipfile
from pathlib import Path

import mutations
import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import FormatError
from kinetograph.formats import ReadOptions, load, read
from kinetograph.formats.c3d.parameters import Parameter, Parameters
from kinetograph.kinematics import joint_positions


def test_a_small_c3d_file(tmp_path: Path) -> None:
    (tmp_path / "a.c3d").write_bytes(mutations.c3d_bytes())
    loaded = read(tmp_path / "a.c3d", ReadOptions(up="y"))
    markers = loaded.take.signal("markers")
    assert (markers.names, markers.fps, markers.values.shape) == (("HEAD", "HIP", "FOOT"), 50.0, (4, 3, 3))
    np.testing.assert_allclose(markers.values[1, 0], [1.401] * 3, atol=1e-7)
    assert loaded.notes == ()


@pytest.mark.parametrize("frames", [1, 2])
def test_a_c3d_file_of_a_frame_or_two(tmp_path: Path, frames: int) -> None:
    (tmp_path / "a.c3d").write_bytes(mutations.c3d_bytes(frames))
    assert len(load(tmp_path / "a.c3d", up="y").signal()) == frames


@pytest.mark.parametrize(("processor", "order"), [(1, "<"), (3, ">")])
def test_more_frames_than_a_c3d_header_counts_are_in_two_words(processor: int, order: str) -> None:
    words = {"ACTUAL_START_FIELD": (1, 0), "ACTUAL_END_FIELD": (5, 2)}
    values = {("TRIAL", name): Parameter(2, (2,), struct.pack(f"{order}2H", *pair)) for name, pair in words.items()}
    parameters = Parameters(processor, 3, 0, 1, 65535, -1.0, 50.0, 3, values)
    assert parameters.long_frames() == 2 * 65536 + 5


def test_a_marker_at_the_very_origin_is_missing(tmp_path: Path) -> None:
    data = mutations.c3d_bytes()
    foot = data.rindex(np.array([3, 3, 3, 0], dtype="<f4").tobytes())
    (tmp_path / "a.c3d").write_bytes(data[:foot] + bytes(16) + data[foot + 16 :])
    loaded = read(tmp_path / "a.c3d", ReadOptions(up="y"))
    assert loaded.take.signal("markers").valid.tolist() == [[True] * 3] * 3 + [[True, True, False]]
    assert loaded.notes == ("1 markers are at the very origin at times: taken as not seen there",)


def test_data_begin_where_the_header_says_if_the_parameter_is_zero(tmp_path: Path) -> None:
    data = bytearray(mutations.c3d_bytes())
    end = data.index(b"HEADHIP FOOT") + 12 + 1
    start = struct.pack("bb", 10, 1) + b"DATA_START" + struct.pack("<hbBh", 5, 2, 0, 0) + b"\0"
    data[end : end + len(start)] = start
    (tmp_path / "a.c3d").write_bytes(bytes(data))
    np.testing.assert_allclose(load(tmp_path / "a.c3d", up="y").signal().values[1, 0], [1.401] * 3, atol=1e-7)


def test_units_filled_up_with_zeros(tmp_path: Path) -> None:
    data = mutations.c3d_bytes().replace(b"mm", b"m\0", 1)
    (tmp_path / "a.c3d").write_bytes(data)
    loaded = read(tmp_path / "a.c3d", ReadOptions(up="y"))
    assert loaded.notes == ()
    np.testing.assert_allclose(loaded.take.signal("markers").values[1, 0], [1401.0] * 3)


@pytest.mark.parametrize(
    ("at", "value", "expected"),
    [
        (8, struct.pack("<H", 60000), "60000 frames of 3 markers take 2880000 bytes, there are 192"),
        (2, struct.pack("<H", 0), "expected markers and frames"),
        (1, b"\x51", "second byte is not 0x50"),
        (0, b"\xff", "parameters would begin at byte"),
        (515, b"\x01", "expected a processor of type 84 to 86"),
    ],
)
def test_damaged_c3d_is_refused(tmp_path: Path, at: int, value: bytes, expected: str) -> None:
    data = bytearray(mutations.c3d_bytes())
    data[at : at + len(value)] = value
    (tmp_path / "a.c3d").write_bytes(bytes(data))
    with pytest.raises(FormatError, match=expected):
        load(tmp_path / "a.c3d")


def test_c3d_of_every_encoding_as_ezc3d_reads_it(data_folder: Path) -> None:
    ezc3d = pytest.importorskip("ezc3d", reason="ezc3d is not installed")
    for path in sorted((data_folder / "c3d").glob("*.c3d")):
        theirs = ezc3d.c3d(str(path))
        points = theirs["data"]["points"][:3].transpose(2, 1, 0)
        unit = {"mm": 0.001, "m": 1.0}[theirs["parameters"]["POINT"]["UNITS"]["value"][0]]
        markers = read(path, ReadOptions(up="y")).take.signal()
        assert list(markers.names) == theirs["parameters"]["POINT"]["LABELS"]["value"][: len(markers.names)]
        assert markers.fps == theirs["parameters"]["POINT"]["RATE"]["value"][0]
        np.testing.assert_array_equal(~markers.valid, np.isnan(points[..., 0]))
        np.testing.assert_allclose(markers.values[markers.valid], points[markers.valid] * unit, atol=1e-9)


def poses(folder: Path, **changes: np.ndarray) -> Path:
    rng = np.random.default_rng(3)
    arrays = {
        "poses": rng.normal(0, 0.2, (5, 156)),
        "trans": rng.normal(0, 1, (5, 3)),
        "mocap_framerate": np.array(60.0),
    }
    np.savez(folder / "a.npz", **(arrays | changes))
    return folder / "a.npz"


def test_amass_poses(tmp_path: Path) -> None:
    loaded = read(poses(tmp_path))
    motion = loaded.take.motion()
    given = np.load(tmp_path / "a.npz")
    assert (len(motion), motion.fps, len(motion.skeleton)) == (5, 60.0, 22)
    assert len(motion.skeleton.roles) == 21
    rotation = rot.multiply(rot.about("x", -np.pi / 2), rot.exp(given["poses"][2, :3]))  # Z up becomes Y up
    assert float(rot.angle_between(motion.rotations[2, 0], rotation)) < 1e-9
    assert float(rot.angle_between(motion.rotations[2, 4], rot.exp(given["poses"][2, 12:15]))) < 1e-9
    np.testing.assert_allclose(motion.translation[2], given["trans"][2][[0, 2, 1]] * [1, 1, -1], atol=1e-12)
    assert any("joint offsets not given" in note for note in loaded.notes)


def test_smpl_x_names_and_given_offsets(tmp_path: Path) -> None:
    whole = np.load(poses(tmp_path))
    offsets = np.random.default_rng(4).normal(0, 0.2, (22, 3))
    np.savez(
        tmp_path / "b.npz",
        root_orient=whole["poses"][:, :3],
        pose_body=whole["poses"][:, 3:66],
        trans=whole["trans"],
        mocap_frame_rate=np.array(60.0),
        joint_offsets=offsets,
    )
    a, b = load(tmp_path / "a.npz").motion(), read(tmp_path / "b.npz")
    np.testing.assert_allclose(b.take.motion().rotations, a.rotations, atol=1e-12)
    np.testing.assert_allclose(b.take.motion().skeleton.offsets[1:], offsets[1:], atol=1e-12)
    assert not any("offsets" in note for note in b.notes)


def test_a_member_longer_than_its_archive_is_refused(tmp_path: Path) -> None:
    path = poses(tmp_path)
    data = bytearray(path.read_bytes())
    at = data.index(b"PK\x01\x02")  # the first member's entry in the archive's table
    data[at + 20 : at + 24] = struct.pack("<I", 2**31)
    path.write_bytes(bytes(data))
    with pytest.raises(FormatError, match="an array is longer than the file; is it cut short"):
        load(path)


def test_the_bones_of_another_file(tmp_path: Path, data_folder: Path) -> None:
    walk = sorted((data_folder / "walks").glob("15_*.bvh"))[0]
    motion = read(poses(tmp_path), ReadOptions(skeleton=walk)).take.motion()
    theirs = load(walk).motion().skeleton
    knee = motion.skeleton.names.index("left_knee")
    np.testing.assert_allclose(motion.skeleton.offsets[knee], theirs.offsets[theirs.landmark("left_knee").joint])
    assert joint_positions(motion).shape == (5, 22, 3)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"poses": np.zeros((5, 60))}, r"expected poses of 22 joints or more, found 20 in \(5, 60\)"),
        ({"trans": np.zeros((4, 3))}, r"expected trans \(5, 3\), found \(4, 3\)"),
        ({"trans": np.full((5, 3), np.nan)}, "expected finite numbers"),
        ({"mocap_framerate": np.array(0.0)}, "gives no rate"),
        ({"poses": np.array([["a"]])}, "do not make a motion|could not convert|expected"),
    ],
)
def test_odd_poses_are_refused(tmp_path: Path, changes: dict[str, np.ndarray], expected: str) -> None:
    with pytest.raises(FormatError, match=expected):
        load(poses(tmp_path, **changes))


def archive(folder: Path, name: str, data: bytes) -> Path:
    with zipfile.ZipFile(folder / "a.npz", "w", zipfile.ZIP_DEFLATED) as out:
        out.writestr(name, data)
    return folder / "a.npz"


def npy(header: str, body: bytes = b"") -> bytes:
    text = header.encode().ljust(118) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + body


def test_an_array_of_a_billion_frames_is_refused_before_there_is_room_for_it(tmp_path: Path) -> None:
    header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000, 66)}"
    with pytest.raises(FormatError, match=r"expected \(1000000000, 66\) numbers or names, found 0 bytes"):
        load(archive(tmp_path, "poses.npy", npy(header)))


def test_zip_bombs_and_objects_are_refused(tmp_path: Path) -> None:
    header = "{'descr': '<f8', 'fortran_order': False, 'shape': (25000000,)}"
    with pytest.raises(FormatError, match="unpack to 200000000 bytes, too many for a file of"):
        load(archive(tmp_path, "poses.npy", npy(header, bytes(200_000_000))))
    buffer = io.BytesIO()
    np.save(buffer, np.array([{}], dtype=object), allow_pickle=True)
    with pytest.raises(FormatError, match=r"expected .* numbers or names"):
        load(archive(tmp_path, "poses.npy", buffer.getvalue()))


def test_a_file_that_is_no_archive(tmp_path: Path) -> None:
    (tmp_path / "a.npz").write_bytes(b"PK\x03\x04nothing")
    with pytest.raises(FormatError, match="expected a NumPy archive"):
        load(tmp_path / "a.npz")
