"""BVH: hand-computed answers, dialects, errors, round trips, another reader, and damaged files."""

from __future__ import annotations

import re
import time
import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import Loaded, ReadOptions, WriteOptions, _kernels, load, read, save
from kinetograph.formats.conventions import UNITS
from kinetograph.kinematics import end_positions, joint_positions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

KNOWN = ReadOptions(units="metre", up="y")

TINY = """HIERARCHY
ROOT Hips
{
	OFFSET 0 1 0
	CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
	JOINT Arm
	{
		OFFSET 1 0 0
		CHANNELS 3 Zrotation Xrotation Yrotation
		End Site
		{
			OFFSET 0.5 0 0
		}
	}
}
MOTION
Frames: 2
Frame Time: 0.033333
0 1 0 0 0 0 0 0 0
1 2 3 90 0 0 0 0 90
"""


def parse(tmp_path: Path, text: str | bytes, options: ReadOptions = KNOWN) -> Loaded:
    path = tmp_path / "take.bvh"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read(path, options)


def parsed(tmp_path: Path, text: str | bytes, options: ReadOptions = KNOWN) -> Motion:
    return parse(tmp_path, text, options).take.motion()


def assert_same(motion: Motion, other: Motion, tolerance: float = 1e-9) -> None:
    assert motion.skeleton.names == other.skeleton.names
    np.testing.assert_allclose(joint_positions(motion), joint_positions(other), atol=tolerance)
    np.testing.assert_allclose(end_positions(motion), end_positions(other), atol=tolerance)


def test_positions_of_a_turned_arm_by_hand(tmp_path: Path) -> None:
    motion = parsed(tmp_path, TINY)
    assert motion.skeleton.names == ("Hips", "Arm")
    assert motion.fps == 30.0
    # frame 1: the root rotates by 90 degrees about z, so the arm points up; its own about y moves the tip to -z
    np.testing.assert_allclose(joint_positions(motion)[1], [[1, 2, 3], [1, 3, 3]], atol=1e-12)
    np.testing.assert_allclose(end_positions(motion)[:, 0], [[1.5, 1, 0], [1, 3, 2.5]], atol=1e-12)


@pytest.mark.parametrize("order", ["zxy", "xyz", "yxz", "zyx", "yzx", "xzy"])
def test_channel_order_is_outermost_first(tmp_path: Path, order: str) -> None:
    channels = " ".join(f"{axis.upper()}rotation" for axis in order)
    text = TINY.replace("Zrotation Xrotation Yrotation", channels, 1).replace("90 0 0 0 0 90", "10 20 30 0 0 0")
    q = parsed(tmp_path, text).rotations[1, 0]
    expected = rot.IDENTITY
    for axis, angle in zip(order, (10, 20, 30), strict=True):
        expected = rot.multiply(expected, rot.about(axis, np.radians(angle)))
    np.testing.assert_allclose(q, expected, atol=1e-12)


def test_rotation_and_position_channels_may_be_interleaved(tmp_path: Path) -> None:
    text = TINY.replace(
        "Xposition Yposition Zposition Zrotation Xrotation Yrotation",
        "Yrotation Zposition Xrotation Yposition Zrotation Xposition",
    ).replace("1 2 3 90 0 0 0 0 90", "0 3 0 2 90 1 0 0 90")
    text = text.replace("0 1 0 0 0 0 0 0 0", "0 0 0 1 0 0 0 0 0")
    assert_same(parsed(tmp_path, text), parsed(tmp_path, TINY))


@pytest.mark.parametrize(
    ("channels", "numbers"),
    [("1 Yrotation", "90"), ("2 Zrotation Yrotation", "0 90"), ("3 yROTATION xrotation zrotation", "90 0 0")],
)
def test_joints_with_fewer_rotation_channels(tmp_path: Path, channels: str, numbers: str) -> None:
    zeros = " ".join("0" for _ in numbers.split())
    text = TINY.replace("CHANNELS 3 Zrotation Xrotation Yrotation", f"CHANNELS {channels}")
    text = text.replace("0 1 0 0 0 0 0 0 0", f"0 1 0 0 0 0 {zeros}").replace("90 0 0 0 0 90", f"90 0 0 {numbers}")
    assert_same(parsed(tmp_path, text), parsed(tmp_path, TINY))


@pytest.mark.parametrize("line", ["\t\tCHANNELS 0\n", ""])
def test_a_joint_without_channels_is_rigid(tmp_path: Path, line: str) -> None:
    text = TINY.replace("\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n", line)
    text = text.replace("0 1 0 0 0 0 0 0 0", "0 1 0 0 0 0").replace("90 0 0 0 0 90", "90 0 0")
    assert parsed(tmp_path, text).rotations[:, 1].tolist() == [[1, 0, 0, 0]] * 2


def _one_line(text: str) -> str:
    return " ".join(text.split("MOTION")[0].split()) + "\nMOTION" + text.split("MOTION")[1]


DIALECTS = {
    "spaces": lambda text: text.replace("\t", "    "),
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "CR alone": lambda text: text.replace("\n", "\r"),
    "byte-order mark": lambda text: "\ufeff" + text,
    "lower case": str.lower,
    "upper case": str.upper,
    "blank lines": lambda text: text.replace("\n", "\n \t \n\n"),
    "trailing lines": lambda text: text + "\n\n \n",
    "no newline at the end": str.rstrip,
    "trailing blanks": lambda text: text.replace("\n", " \t\n"),
    "tabs between numbers": lambda text: text.replace("0 0 0", "0\t0\t 0"),
    "scientific": lambda text: text.replace("90 0 0 0 0 90", "9e1 0.0E+00 -0.0 .0 0. +900000e-4"),
    "braces on one line": lambda text: re.sub(r"\s*\n\s*{", " {", text),
    "braces glued": lambda text: re.sub(r"\s*\n\s*{", "{", text),
    "one line": _one_line,
    "no HIERARCHY": lambda text: text.replace("HIERARCHY\n", ""),
    "no colons": lambda text: text.replace("Frames:", "Frames").replace("Time:", "Time"),
    "tab after colon": lambda text: text.replace("Frames: ", "Frames:\t").replace("Time: ", "Time:"),
    "EndSite": lambda text: text.replace("End Site", "EndSite"),
    "named End Site": lambda text: text.replace("End Site", "End Site tip of Arm"),
    "17 digits": lambda text: text.replace(
        "1 2 3 90", "1.00000000000000000 2.00000000000000000 3 90.0000000000000000001"
    ),
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_mean_the_same(tmp_path: Path, dialect: str) -> None:
    text = DIALECTS[dialect](TINY)
    motion, expected = parsed(tmp_path, text), parsed(tmp_path, TINY)
    assert [name.lower() for name in motion.skeleton.names] == ["hips", "arm"]
    np.testing.assert_allclose(end_positions(motion), end_positions(expected), atol=1e-12)
    assert motion.fps == expected.fps


def test_utf16_is_read(tmp_path: Path) -> None:
    assert_same(parsed(tmp_path, TINY.encode("utf-16")), parsed(tmp_path, TINY))


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("left  Arm", "left  Arm"),
        ("Bras_é_手", "Bras_é_手"),
        ("Character1:Arm", "Character1:Arm"),
        ("MOTION", "MOTION"),
    ],
)
def test_names_with_spaces_and_unicode(tmp_path: Path, written: str, expected: str) -> None:
    assert parsed(tmp_path, TINY.replace("JOINT Arm", f"JOINT {written} ")).skeleton.names[1] == expected


def test_names_that_are_not_utf8_are_read_as_latin1(tmp_path: Path) -> None:
    assert parsed(tmp_path, TINY.encode().replace(b"JOINT Arm", b"JOINT Bra\xe7o")).skeleton.names[1] == "Braço"


def test_duplicate_names_are_made_unique_with_a_note(tmp_path: Path) -> None:
    loaded = parse(tmp_path, TINY.replace("JOINT Arm", "JOINT Hips"))
    assert loaded.take.motion().skeleton.names == ("Hips", "Hips_2")
    assert any("'Hips' occurs again: named 'Hips_2'" in note for note in loaded.notes)


def test_several_and_missing_end_sites(tmp_path: Path) -> None:
    end = "\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0.5 0 0\n\t\t}\n"
    two = parsed(tmp_path, TINY.replace(end, end + end.replace("0.5 0 0", "0 0.25 0"))).skeleton
    assert two.end_parents.tolist() == [1, 1]
    assert two.end_offsets.tolist() == [[0.5, 0, 0], [0, 0.25, 0]]
    assert parsed(tmp_path, TINY.replace(end, "")).skeleton.end_parents.tolist() == []


def test_several_roots_are_tracks_with_their_names(tmp_path: Path) -> None:
    tree = TINY.split("MOTION")[0]
    second = (
        tree.replace("HIERARCHY\n", "").replace("ROOT Hips", "ROOT Partner").replace("OFFSET 1 0 0", "OFFSET 2 0 0")
    )
    text = tree + second + "MOTION\nFrames: 1\nFrame Time: 0.01\n0 1 0 0 0 0 0 0 0 5 1 0 90 0 0 0 0 0\n"
    take = parse(tmp_path, text).take
    assert list(take.tracks) == ["Hips", "Partner"]
    np.testing.assert_allclose(joint_positions(take.motion("Partner"))[0], [[5, 1, 0], [5, 3, 0]], atol=1e-12)
    np.testing.assert_allclose(joint_positions(take.motion("Hips"))[0], [[0, 1, 0], [1, 1, 0]], atol=1e-12)
    twins = parse(tmp_path, text.replace("Partner", "Hips"))
    assert list(twins.take.tracks) == ["Hips", "Hips_2"]


PLACED = TINY.replace(
    "CHANNELS 3 Zrotation Xrotation Yrotation",
    "CHANNELS 6 Yposition Xposition Zposition Zrotation Xrotation Yrotation",
)


def test_constant_position_channels_replace_offsets(tmp_path: Path) -> None:
    text = PLACED.replace("0 1 0 0 0 0 0 0 0", "0 1 0 0 0 0 2 3 4 0 0 0").replace(
        "90 0 0 0 0 90", "90 0 0 2 3 4 0 0 90"
    )
    motion = parsed(tmp_path, text)
    assert motion.bones is None
    assert motion.skeleton.offsets[1].tolist() == [3, 2, 4]


def test_moving_position_channels_are_bones(tmp_path: Path) -> None:
    text = PLACED.replace("0 1 0 0 0 0 0 0 0", "0 1 0 0 0 0 2 3 4 0 0 0").replace(
        "90 0 0 0 0 90", "90 0 0 2 7 4 0 0 90"
    )
    motion = parsed(tmp_path, text)
    assert motion.bones is not None
    assert motion.bones[:, 1].tolist() == [[3, 2, 4], [7, 2, 4]]
    np.testing.assert_allclose(joint_positions(motion)[:, 1], [[3, 3, 4], [-1, 9, 7]], atol=1e-12)


def test_one_position_channel_replaces_one_axis(tmp_path: Path) -> None:
    text = PLACED.replace("6 Yposition Xposition Zposition", "4 Yposition")
    text = text.replace("0 1 0 0 0 0 0 0 0", "0 1 0 0 0 0 2 0 0 0").replace("90 0 0 0 0 90", "90 0 0 2 0 0 90")
    assert parsed(tmp_path, text).skeleton.offsets[1].tolist() == [1, 2, 0]


def test_position_channels_that_are_all_zero_leave_the_offsets(tmp_path: Path) -> None:
    text = PLACED.replace("0 1 0 0 0 0 0 0 0", "0 1 0 0 0 0 0 0 0 0 0 0").replace(
        "90 0 0 0 0 90", "90 0 0 0 0 0 0 0 90"
    )
    loaded = parse(tmp_path, text)
    assert_same(loaded.take.motion(), parsed(tmp_path, TINY))
    assert any("all 0" in note for note in loaded.notes)


def test_a_root_without_position_channels_stays_at_its_offset(tmp_path: Path) -> None:
    text = TINY.replace("6 Xposition Yposition Zposition", "4 Xposition")
    text = text.replace("0 1 0 0 0 0 0 0 0", "0 0 0 0 0 0 0").replace("1 2 3 90", "1 90")
    assert parsed(tmp_path, text).translation.tolist() == [[0, 1, 0], [1, 1, 0]]


@pytest.mark.parametrize("count", ["Frames: 0", "Frames: 0\n\n"])
def test_no_frames_give_the_rest_pose_with_a_note(tmp_path: Path, count: str) -> None:
    text = PLACED.split("Frames:")[0] + count + "\nFrame Time: 0.04\n"
    loaded = parse(tmp_path, text)
    motion = loaded.take.motion()
    np.testing.assert_allclose(joint_positions(motion), [[[0, 1, 0], [1, 1, 0]]])
    assert motion.fps == 25
    assert any("no frames" in note for note in loaded.notes)


@pytest.mark.parametrize(
    ("frame_time", "fps"),
    [
        ("0.033333", 30.0),
        ("0.0333333", 30.0),
        ("0.033", 30.0),
        ("0.008333", 120.0),
        ("0.008342", 120_000 / 1001),
        ("0.0333667", 30_000 / 1001),
        ("0.041708", 24_000 / 1001),
        ("0.01", 100.0),
        ("1e-2", 100.0),
        (".016667", 60.0),
        ("0.0341296928", 29.3),
        ("0.4", 2.5),
        ("2", 0.5),
    ],
)
def test_rate_is_the_usual_one_that_would_be_written_so(tmp_path: Path, frame_time: str, fps: float) -> None:
    assert parsed(tmp_path, TINY.replace("0.033333", frame_time)).fps == pytest.approx(fps, rel=1e-9)


def test_frame_time_0_needs_a_rate(tmp_path: Path) -> None:
    text = TINY.replace("0.033333", "0")
    with pytest.raises(FormatError, match=r"take.bvh:18: expected Frame Time: and seconds, found '0'; .*--fps"):
        parse(tmp_path, text)
    assert parsed(tmp_path, text, ReadOptions("metre", "y", fps=50)).fps == 50
    with pytest.raises(FormatError, match="fps must be a positive number, found -1"):
        parse(tmp_path, text, ReadOptions("metre", "y", fps=-1))


ERRORS = {
    "empty": ("", "", r"take.bvh:1: the file ends where MOTION was expected"),
    "frame count": ("Frames: 2", "Frames: 3", r"Frames: 3, but there are 2 rows of numbers; .*--lenient"),
    "frames nonsense": ("Frames: 2", "Frames: many", r"take.bvh:17: expected Frames: and a whole number, found 'many'"),
    "frames negative": ("Frames: 2", "Frames: -2", r":17: expected Frames: and a whole number, found '-2'"),
    "frames absurd": ("Frames: 2", "Frames: 1000000000000", r"Frames: 1000000000000, but there are 2 rows"),
    "frames missing": ("Frames: 2\n", "", r":17: expected Frames: and a whole number, found 'Frame'"),
    "frame time missing": ("Frame Time: 0.033333\n", "", r":18: expected Frame Time: and seconds, found '0'"),
    "frame time text": ("0.033333", "fast", r":18: expected Frame Time: and seconds, found 'fast'"),
    "short row": ("0 0 0 0 0 0\n", "0 0 0 0 0\n", r":19:16: expected 9 numbers, one per channel, found 8"),
    "long row": ("90 0 0 0 0 90", "90 0 0 0 0 90 7", r":20:21: expected 9 numbers, one per channel, found 10"),
    "nan": ("90 0 0 0 0 90", "90 0 nan 0 0 90", r":20:12: expected a finite number, found 'nan'"),
    "inf": ("90 0 0 0 0 90", "90 0 -inf 0 0 90", r":20:12: expected a finite number, found '-inf'"),
    "overflow": ("90 0 0 0 0 90", "90 0 1e999 0 0 90", r":20:12: expected numbers up to 1e\+09, found a larger one"),
    "word": ("90 0 0 0 0 90", "90 0 1.#QNAN 0 0 90", r":20:12: expected a finite number, found '1.#QNAN'"),
    "two points": ("90 0 0 0 0 90", "90 0 1.2.3 0 0 90", r":20:12: expected a finite number, found '1.2.3'"),
    "decimal comma": ("90 0 0 0 0 90", "90,5,1 0 0 0 0 90", r":20:7: expected a finite number, found '90,5,1'"),
    "lone sign": ("90 0 0 0 0 90", "90 - 0 0 0 90", r":20:10: expected a finite number, found '-'"),
    "bare exponent": ("90 0 0 0 0 90", "90 1e 0 0 0 90", r":20:10: expected a finite number, found '1e'"),
    "offset text": ("OFFSET 1 0 0", "OFFSET 1 x 0", r":8:12: expected an offset, a finite number, found 'x'"),
    "offset nan": ("OFFSET 1 0 0", "OFFSET 1 nan 0", r":8:12: expected an offset, a finite number, found 'nan'"),
    "offset absurd": ("OFFSET 1 0 0", "OFFSET 1 1e200 0", r":8:12: expected an offset, a finite number, found '1e200'"),
    "offset short": ("OFFSET 1 0 0", "OFFSET 1 0", r":9:3: expected an offset, a finite number, found 'CHANNELS'"),
    "offset missing": ("\t\tOFFSET 1 0 0\n", "", r":6: joint 'Arm' has no OFFSET"),
    "channel count": ("CHANNELS 3", "CHANNELS 4", r":9:3: expected 4 channels .*, found 3, then 'End'"),
    "channel count absurd": ("CHANNELS 3", "CHANNELS 1e18", r":9:12: expected the number of channels, .* found '1e18'"),
    "channel name": (
        "Arm\n\t{\n\t\tOFFSET 1 0 0\n\t\tCHANNELS 3 Zr",
        "Arm\n\t{\n\t\tOFFSET 1 0 0\n\t\tCHANNELS 3 Wr",
        ":9:3: .*'Wrot",
    ),
    "channel twice": (
        "Xposition Yposition",
        "Xposition Xposition",
        r":5:2: expected at most 3 rotations and one position",
    ),
    "channels twice": (
        "\t\tEnd Site",
        "\t\tCHANNELS 1 Xrotation\n\t\tEnd Site",
        r":10:3: joint 'Arm' has CHANNELS twice",
    ),
    "no brace": ("Arm\n\t{", "Arm\n", r"expected { after 'JOINT', found 'OFFSET'"),
    "stray brace": ("MOTION", "}\nMOTION", r":16:1: expected ROOT or MOTION, found '}'"),
    "missing brace": ("\t}\n}\nMOTION", "\t}\nMOTION", r":15:1: expected OFFSET, CHANNELS, JOINT, .* found 'MOTION'"),
    "joint first": ("ROOT Hips", "JOINT Hips", r":2:1: expected HIERARCHY or ROOT, found 'JOINT'"),
    "no root": (TINY.split("MOTION")[0], "HIERARCHY\n", r":2:1: expected a ROOT before MOTION, found none"),
    "root inside": ("JOINT Arm", "ROOT Arm", r":6:2: expected OFFSET, CHANNELS, JOINT, End Site or }, found 'ROOT'"),
    "joint in end": ("0.5 0 0", "0.5 0 0\nJOINT tip {", r":13:1: expected OFFSET or }, found 'JOINT'"),
    "truncated tree": (
        TINY[TINY.index("JOINT") :],
        "",
        r":5: the file ends where .* was expected \(open braces: 1\); is it cut short",
    ),
    "truncated": (
        TINY[TINY.index("Frames") :],
        "",
        r":16: expected Frames: and a whole number, found the end of the file",
    ),
    "binary": (TINY, "\x00\x01\x02 Kaydara FBX Binary", r":1: expected HIERARCHY or ROOT, found"),
}


@pytest.mark.parametrize("case", ERRORS)
def test_errors_are_one_line_with_the_place(tmp_path: Path, case: str) -> None:
    old, new, message = ERRORS[case]
    text = TINY.replace(old, new, 1) if old else ""
    assert text != TINY
    with pytest.raises(FormatError, match=message) as caught:
        parse(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_a_missing_file_and_a_folder_are_format_errors(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"none\.bvh: cannot open it: No such file"):
        load(tmp_path / "none.bvh")
    (tmp_path / "folder.bvh").mkdir()
    with pytest.raises(FormatError, match=r"folder.bvh: cannot open it: Is a directory"):
        load(tmp_path / "folder.bvh")


@pytest.mark.parametrize(
    ("text", "frames", "note"),
    [
        (TINY.replace("Frames: 2", "Frames: 5"), 2, "Frames: 5, but there are 2 rows"),
        (TINY[:-8], 1, "line 20: expected 9 numbers, one per channel, found 6"),
        (TINY.replace("1 2 3 90", "1 2 3 oops"), 1, "line 20: expected a finite number, found 'oops'"),
    ],
)
def test_lenient_takes_the_whole_rows_that_are_there(tmp_path: Path, text: str, frames: int, note: str) -> None:
    loaded = parse(tmp_path, text, ReadOptions("metre", "y", lenient=True))
    assert len(loaded.take.motion()) == frames
    assert any(note in line for line in loaded.notes)


def test_deep_nesting_neither_recurses_nor_is_slow(tmp_path: Path) -> None:
    depth = 10_000
    text = "HIERARCHY\n" + "".join(
        f"{'JOINT' if i else 'ROOT'} j{i}\n{{\nOFFSET 0 0 0.001\nCHANNELS 1 Xrotation\n" for i in range(depth)
    )
    rows = "}\n" * depth + "MOTION\nFrames: 1\nFrame Time: 0.1\n" + "0 " * depth
    start = time.perf_counter()
    assert len(parsed(tmp_path, text + rows).skeleton) == depth
    assert time.perf_counter() - start < 5
    with pytest.raises(FormatError, match=r"the file ends where .* \(open braces: 10000\)"):
        parse(tmp_path, text)


def test_more_joints_than_any_character_has_are_refused(tmp_path: Path) -> None:
    text = "ROOT a{OFFSET 0 0 0\n" + "JOINT b{OFFSET 0 0 1}\n" * 20_000 + "}MOTION\n"
    with pytest.raises(FormatError, match="more than 20000 joints"):
        parse(tmp_path, text)


def test_small_files_do_not_ask_for_all_memory(tmp_path: Path) -> None:
    tree = "ROOT a{OFFSET 0 0 0 CHANNELS 1 Xrotation\n" + "JOINT b{OFFSET 0 0 1}\n" * 5_000 + "}MOTION\n"
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="found 5001 joints but 1 channels"):
            parse(tmp_path, tree + "Frames: 100000\nFrame Time: 0.1\n" + "0\n" * 100_000)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()


# --- kernels against their naive twins


def naive_turns(values: np.ndarray, columns: np.ndarray, axes: np.ndarray) -> np.ndarray:
    out = rot.identity(len(values), len(columns))
    for joint, (row, letters) in enumerate(zip(columns, axes, strict=True)):
        for column, axis in zip(row, letters, strict=True):
            if column >= 0:
                out[:, joint] = rot.multiply(out[:, joint], rot.about("xyz"[axis], np.radians(values[:, column])))
    return out


def test_turns_match_the_naive_twin() -> None:
    rng = np.random.default_rng(3)
    values = rng.uniform(-400, 400, (5, 12))
    columns = np.array([[0, 1, 2], [3, -1, -1], [4, 5, -1], [-1, -1, -1], [9, 10, 11]])
    axes = rng.integers(0, 3, columns.shape)
    got = _kernels.rotations_of_channels(values, columns, axes)
    np.testing.assert_allclose(got, naive_turns(values, columns, axes), atol=1e-14)


number_texts = st.one_of(
    st.floats(-1e300, 1e300).map(repr),
    st.floats(-1e6, 1e6).map(lambda x: f"{x:.6f}"),
    st.integers(-(10**30), 10**30).map(str),
    st.from_regex(r"[+-]?([0-9]{1,25}\.?[0-9]{0,25}|\.[0-9]{1,25})([eE][+-]?[0-9]{1,2})?", fullmatch=True),
)


@given(rows=st.lists(st.lists(number_texts, min_size=3, max_size=3), min_size=1, max_size=5))
def test_numbers_match_pythons_own(rows: list[list[str]]) -> None:
    text = "\n".join(" ".join(row) for row in rows).encode()
    values = np.empty((len(rows), 3))
    read_rows, status, _, _ = _kernels.parse_rows(np.frombuffer(text, np.uint8), 0, 1, values, np.inf)
    assert (read_rows, status) == (len(rows), _kernels.DONE)
    np.testing.assert_allclose(values, np.array(rows, dtype=float), rtol=1e-15 * 20, atol=1e-300)


# --- writing


@st.composite
def motions(draw: st.DrawFn, bones: bool = False) -> Motion:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    joints, frames = draw(st.integers(1, 8)), draw(st.integers(1, 5))
    parents = np.array([-1, *(int(rng.integers(0, i)) for i in range(1, joints))])
    offsets = rng.uniform(-0.5, 0.5, (joints, 3))
    ends = np.flatnonzero(rng.random(joints) < 0.5)
    skeleton = Skeleton(
        tuple(f"joint {i}é" for i in range(joints)), parents, offsets, ends, rng.uniform(-0.2, 0.2, (len(ends), 3))
    )
    return Motion(
        skeleton,
        rng.uniform(-3, 3, (frames, 3)),
        rot.normalize(rng.normal(size=(frames, joints, 4))),
        draw(st.sampled_from([24.0, 30.0, 120_000 / 1001, 60.0, 29.3, 1000.0])),
        rng.uniform(-0.5, 0.5, (frames, joints, 3)) if bones else None,
    )


@settings(max_examples=60)
@given(
    motion=st.one_of(motions(), motions(bones=True)),
    order=st.sampled_from(["zxy", "xyz", "yxz", "zyx", "yzx", "xzy"]),
    units=st.sampled_from(list(UNITS)),
    up=st.sampled_from("xyz"),
)
def test_what_is_written_reads_back(
    tmp_path_factory: pytest.TempPathFactory, motion: Motion, order: str, units: str, up: str
) -> None:
    path = tmp_path_factory.mktemp("bvh") / "take.bvh"
    save(motion, path, options=WriteOptions(order, units, up))
    back = load(path, units=units, up=up).motion()
    assert back.fps == pytest.approx(motion.fps, rel=1e-12)
    order_of = [back.skeleton.names.index(name) for name in motion.skeleton.names]
    np.testing.assert_allclose(joint_positions(back)[:, order_of], joint_positions(motion), atol=1e-6)
    assert np.degrees(rot.angle_between(back.rotations[:, order_of], motion.rotations)).max() < 2e-4
    ends = {tuple(end.round(5)) for end in end_positions(motion)[0]}
    written = end_positions(back)[0]
    assert all(np.abs(written - end).max(axis=1).min() < 2e-5 for end in ends)


def test_the_written_file_by_hand(tmp_path: Path) -> None:
    skeleton = Skeleton(("Hips", "Arm"), np.array([-1, 0]), np.array([[0, 1, 0], [1.0, 0, 0]]))
    rotations = rot.identity(1, 2)
    rotations[0, 1] = rot.about("z", np.pi / 2)
    save(
        Motion(skeleton, np.array([[0, 1.0, 2]]), rotations, 25),
        tmp_path / "a.bvh",
        options=WriteOptions("zxy", "centimetre"),
    )
    assert (tmp_path / "a.bvh").read_text() == (
        "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0.00000 0.00000 0.00000\n"
        "\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
        "\tJOINT Arm\n\t{\n\t\tOFFSET 100.00000 0.00000 0.00000\n\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n"
        "\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0.00000 0.00000 0.00000\n\t\t}\n\t}\n}\n"
        "MOTION\nFrames: 1\nFrame Time: 0.04000000000086142273\n"  # 8614, centimetres, y, 73
        "0.00000 100.00000 200.00000 0.0000000 0.0000000 0.0000000 90.0000000 0.0000000 0.0000000\n"
    )


def test_a_take_of_two_motions_has_two_roots(tmp_path: Path) -> None:
    one = parsed(tmp_path, TINY)
    two = parsed(tmp_path, TINY.replace("Hips", "Partner").replace("OFFSET 1 0 0", "OFFSET 0 1 0"))
    save(Take("pair", {"a": one, "b": two}), tmp_path / "pair.bvh")
    back = load(tmp_path / "pair.bvh", units="metre", up="y")
    assert_same(back.motion("Hips"), one, 1e-6)
    assert_same(back.motion("Partner"), two, 1e-6)


def test_names_that_would_break_the_file_are_changed(tmp_path: Path) -> None:
    motion = parsed(tmp_path, TINY)
    odd = Skeleton(("a{b}", "c\nd"), motion.skeleton.parents, motion.skeleton.offsets)
    save(Motion(odd, motion.translation, motion.rotations, 30), tmp_path / "odd.bvh")
    assert load(tmp_path / "odd.bvh").motion().skeleton.names == ("a_b_", "c d")


def test_what_bvh_cannot_hold_is_refused(tmp_path: Path) -> None:
    motion = parsed(tmp_path, TINY)
    signal = Signal(np.zeros((2, 1)), ("a",), "", 30)
    path = tmp_path / "no.bvh"
    with pytest.raises(RequestError, match=r"found a signal; save it as \.csv"):
        save(signal, path)
    with pytest.raises(RequestError, match="take 't' has only s"):
        save(Take("t", {"s": signal}), path)
    slow = Motion(motion.skeleton, motion.translation, motion.rotations, 15)
    with pytest.raises(RequestError, match="differ in rate or length"):
        save(Take("t", {"a": motion, "b": slow}), path)
    with pytest.raises(RequestError, match=r"Euler order must name x, y and z once each, .* found 'zxz'"):
        save(motion, path, options=WriteOptions(order="zxz"))
    with pytest.raises(RequestError, match="unknown units 'parsec'; expected one of metre"):
        save(motion, path, options=WriteOptions(units="parsec"))
    assert not path.exists()


# --- another reader


def _bvh_files(folder: Path) -> list[Path]:
    return sorted(folder.glob("**/*.bvh"))


def test_positions_match_pybvh_on_every_recording(data_folder: Path) -> None:
    pybvh = pytest.importorskip("pybvh")
    refused = []
    files = _bvh_files(data_folder)
    for path in files:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                theirs = pybvh.read_bvh_file(str(path))
        except Exception as error:
            refused.append(f"{path.name}: {error}")
            continue
        ours = load(path, units="metre", up="y").motion()
        frames = np.unique(np.linspace(0, len(ours) - 1, 50).astype(int))
        names = [node.name for node in theirs.nodes]
        order = [names.index(name) for name in ours.skeleton.names]
        expected = theirs.node_positions()[frames][:, order]
        size = max(1.0, float(np.abs(expected).max()))
        got = joint_positions(ours)[frames]
        assert np.abs(got - expected).max() <= 1e-9 * size, path.name
    assert refused == []
    assert files


# --- damaged files

SEEDS = (TINY, PLACED, DIALECTS["CRLF"](TINY), _one_line(TINY))
FRAGMENTS = (
    *(b"{", b"}", b"\n", b"\r", b"\0", b"\xff\xfe", b"-", b"1e308", b"1e-400", b"nan", b"9" * 400, b" " * 50, b"\t"),
    *(b"JOINT x\n{\n", b"ROOT", b"End Site", b"CHANNELS 3 ", b"OFFSET", b"MOTION\n", b"Frames: 99999999999999999999\n"),
    *(b"Frame Time: 1e-300\n", b"Xposition", b"\xef\xbb\xbf", b"CHANNELS -1", b"0 0 0 0 0 0 0 0 0\n"),
)


def damaged(rng: np.random.Generator) -> bytes:
    data = bytearray(SEEDS[rng.integers(len(SEEDS))].encode())
    for _ in range(int(rng.integers(1, 4))):
        start = int(rng.choice([0, data.rfind(b"Time:") + 1]))  # the numbers are as worth damaging as the tree
        at = int(rng.integers(start, len(data) + 1))
        kind = rng.integers(6)
        if kind == 0 and at < len(data):
            data[at] = int(rng.integers(256))
        elif kind == 1:
            data[at : at + int(rng.integers(1, 30))] = b""
        elif kind == 2:
            data[at:at] = FRAGMENTS[rng.integers(len(FRAGMENTS))]
        elif kind == 3:
            other = int(rng.integers(len(data) + 1))
            data[at:at] = data[min(at, other) : max(at, other)][:200]
        elif kind == 4:
            del data[at:]
        else:
            data[at : at + 1] = str(int(rng.integers(-(10**6), 10**6))).encode()
    return bytes(data)


def fuzz(folder: Path, seed: int, cases: int) -> int:
    """How many of the damaged files were read all the same; anything but a FormatError of one line escapes."""
    readable = 0
    for case in range(cases):
        rng = np.random.default_rng([seed, case])
        path = folder / "damaged.bvh"
        path.write_bytes(damaged(rng))
        options = ReadOptions(fps=float(rng.choice([30.0, 0.0])) if case % 3 else None, lenient=bool(case % 2))
        start = time.perf_counter()
        try:
            read(path, options)
            readable += 1
        except FormatError as error:
            if "\n" in str(error):
                raise
        assert time.perf_counter() - start < 5, (seed, case)
    return readable


def test_damaged_files_give_format_errors_and_nothing_else(tmp_path: Path) -> None:
    readable = fuzz(tmp_path, 2026, 400)
    assert 20 < readable < 380  # both outcomes were tried
