"""BVH as other programs misspell it: read where there is one reading, refused with the place where there is none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.errors import FormatError
from kinetograph.formats import Loaded, ReadOptions, read, stream
from kinetograph.formats.bvh import stream as streams
from kinetograph.formats.bvh.spellings import only_reading
from kinetograph.library import Library, add_stream

TREE = """HIERARCHY
ROOT Hips
{
	OFFSET 0.0 0.0 0.0
	CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
	JOINT Arm
	{
		OFFSET 1.0 0.5 0.0
		CHANNELS 3 Zrotation Xrotation Yrotation
		End Site
		{
			OFFSET 0.5 0.0 0.0
		}
	}
}
MOTION
"""
HEAD = "Frames: 4\nFrame Time: 0.04\n"
ROWS = """0.0 90.5 0.0 -7.5 1.0 2.0 0.0 0.25 -0.5
0.5 91.5 3.0 -8.5 1.5 2.5 0.0 0.25 -1.5
1.0 92.5 6.0 -9.5 2.0 3.0 0.0 0.25 -2.5
1.5 93.5 9.0 -9.0 2.5 3.5 0.0 0.25 -3.5
"""
FIRST = len(TREE.splitlines()) + 3
"""The line of the first row."""


def parse(
    folder: Path, rows: str = ROWS, head: str = HEAD, *, lenient: bool = False, fps: float | None = None
) -> Loaded:
    path = folder / "take.bvh"
    path.write_bytes((TREE + head + rows).encode())
    return read(path, ReadOptions("metre", "y", lenient=lenient, fps=fps))


def said(loaded: Loaded) -> str:
    return " | ".join(loaded.notes)


def assert_the_motion(loaded: Loaded, frames: int = 4) -> None:
    """The motion of `ROWS`."""
    expected = np.array([row.split() for row in ROWS.splitlines()], dtype=float)
    motion = loaded.take.motion()
    assert len(motion) == frames
    np.testing.assert_array_equal(motion.translation[:4], expected[: min(frames, 4), :3])
    half = np.radians(expected[: min(frames, 4), 8]) / 2  # of the arm, about Y
    expected_y = np.cos(np.radians(0.25) / 2) * np.sin(half)
    np.testing.assert_allclose(np.abs(motion.rotations[:4, 1, 2]), np.abs(expected_y), atol=1e-12)


def columns(rows: str, form: str, between: str = "") -> str:
    """Rows of a writer with columns of its own."""
    return "".join(between.join(form % float(word) for word in row.split()) + "\n" for row in rows.splitlines())


SPELT: dict[str, tuple[Callable[[str], str], str]] = {
    "a sign without a blank": (lambda rows: rows.replace(" -", "-"), "numbers that run together, read so in 4 rows"),
    "one row of four": (lambda rows: rows.replace("3.0 -8.5", "3.0-8.5"), "read so in 1 rows"),
    "decimal commas": (lambda rows: rows.replace(".", ","), "decimal commas, read so in 4 rows"),
    "decimal commas glued": (lambda rows: rows.replace(".", ",").replace(" -", "-"), "decimal commas"),
    "commas between": (lambda rows: rows.replace(" ", ","), "commas between numbers, read so in 4"),
    "commas and blanks": (lambda rows: rows.replace(" ", ", "), "commas between numbers"),
    "a comma at the end": (lambda rows: rows.replace(" ", ",").replace("\n", ",\n"), "commas between numbers"),
    "both commas": (lambda rows: rows.replace(".", ",").replace(" ", ", "), "commas in and between numbers"),
    "semicolons": (lambda rows: rows.replace(" ", ";"), "semicolons between numbers"),
    "semicolons and commas": (lambda rows: rows.replace(".", ",").replace(" ", ";"), "decimal commas"),
    "exponents with D": (lambda rows: rows.replace("93.5", "9.35D+01"), "exponents with D, read so in 1 rows"),
    "columns of 8": (lambda rows: columns(rows, "%8.4f"), ""),
    "columns of 6": (lambda rows: columns(rows, "%6.3f").replace(" ", ""), "columns that run together"),
    "rows on two lines": (lambda rows: rows.replace(" 1.0 2.0", "\n1.0 2.0"), "rows over several lines, read so in 1"),
    "a number a line": (lambda rows: rows.replace(" ", "\n"), "rows over several lines, read so in 4 rows"),
    "all on one line": (lambda rows: rows.replace("\n", " "), "several rows on a line"),
    "two rows a line": (lambda rows: rows.replace("-0.5\n", "-0.5 ").replace("-2.5\n", "-2.5\t"), "several rows"),
    "blank lines amid rows": (lambda rows: rows.replace("\n", "\n\n \t\n"), ""),
    "CRLF, glued": (lambda rows: rows.replace(" -", "-").replace("\n", "\r\n"), "run together"),
    "tabs, glued": (lambda rows: rows.replace(" -", "-").replace(" ", "\t"), "run together"),
    "no newline at the end, glued": (lambda rows: rows.replace(" -", "-").rstrip(), "run together"),
}


@pytest.mark.parametrize("case", SPELT)
@pytest.mark.parametrize("lenient", [False, True])
def test_rows_with_one_reading_are_read_with_a_note(tmp_path: Path, case: str, lenient: bool) -> None:
    spell, note = SPELT[case]
    assert spell(ROWS) != ROWS
    loaded = parse(tmp_path, spell(ROWS), lenient=lenient)
    assert_the_motion(loaded)
    assert note in said(loaded)
    assert "cannot be read" not in said(loaded)


def test_numbers_that_run_together_say_where(tmp_path: Path) -> None:
    loaded = parse(tmp_path, ROWS.replace("3.0 -8.5", "3.0-8.5"))
    assert f"line {FIRST + 1}: numbers that run together" in said(loaded)


REFUSED = {
    "two points": ("-8.5 1.5", "-8.5.1 1.5", r":{1}:14: expected a finite number, found '-8\.5\.1'"),
    "1.2.3": ("91.5 3.0", "1.2.3", r":{1}:5: expected a finite number, found '1\.2\.3'"),
    "decimals that differ": ("91.5 3.0", "91.253.0", r":{1}:5: expected a finite number, found '91\.253\.0'"),
    "a sign too many": ("3.0 -8.5", "3.0--8.5", r":{1}:\d+: expected a finite number, found '3\.0--8\.5'"),
    "glued, one missing": ("3.0 -8.5 1.5", "3.0-8.5", r":{1}:\d+: expected a finite number, found '3\.0-8\.5'"),
    "one more": ("0.25 -1.5", "0.25 -1.5 7", r":{1}:\d+: expected 9 numbers, one per channel, found 10"),
    "one fewer": ("0.25 -1.5", "-1.5", r":{1}:\d+: expected 9 numbers, one per channel, found 8; is the line cut"),
    "nan": ("91.5", "nan", r":{1}:5: expected a finite number, found 'nan'; --lenient repeats the row before"),
    "Microsoft's indefinite": ("91.5", "-1.#IND", r":{1}:5: expected a finite number, found '-1\.#IND'"),
    "Microsoft's quiet": ("91.5", "1.#QNAN00", r":{1}:5: expected a finite number, found '1\.#QNAN00'"),
    "hexadecimal": ("91.5", "0x5B", r":{1}:5: expected a finite number, found '0x5B'"),
    "a word": ("91.5", "oops", r":{1}:5: expected a finite number, found 'oops'"),
    "underscores": ("91.5", "9_1.5", r":{1}:5: expected a finite number, found '9_1\.5'"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_rows_without_one_reading_are_refused_with_line_and_column(tmp_path: Path, case: str) -> None:
    old, new, message = REFUSED[case]
    assert old in ROWS
    with pytest.raises(FormatError, match=r"take\.bvh" + message.replace("{1}", str(FIRST + 1))) as caught:
        parse(tmp_path, ROWS.replace(old, new, 1))
    assert "\n" not in str(caught.value)
    assert caught.value.column is not None


@pytest.mark.parametrize("case", REFUSED)
def test_lenient_repeats_the_row_before_one_that_is_damaged(tmp_path: Path, case: str) -> None:
    old, new, _ = REFUSED[case]
    loaded = parse(tmp_path, ROWS.replace(old, new, 1), lenient=True)
    assert loaded.take.motion().translation[:, 0].tolist() == [0.0, 0.0, 1.0, 1.5]
    assert f"line {FIRST + 1}: expected" in said(loaded)
    assert "1 rows cannot be read: 1 repeat the row before" in said(loaded)


@pytest.mark.parametrize("lenient", [False, True])
def test_rows_of_a_tree_with_twice_the_joints_are_refused(tmp_path: Path, lenient: bool) -> None:
    with pytest.raises(
        FormatError, match=rf"line {FIRST}: several rows on a line would make 8 rows where Frames: says 4; is the tree"
    ):
        parse(tmp_path, "".join(f"{row} {row}\n" for row in ROWS.splitlines()), lenient=lenient)


def test_lenient_leaves_out_damaged_rows_at_the_ends(tmp_path: Path) -> None:
    loaded = parse(tmp_path, "x\n" + ROWS + "y\n", head=HEAD.replace("4", "6", 1), lenient=True)
    assert_the_motion(loaded)
    assert "2 rows cannot be read: 2 at an end are left out" in said(loaded)


def test_lenient_never_gives_the_rest_pose_for_rows_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=rf":{FIRST}:1: expected a finite number, found 'nan'; no row can be read"):
        parse(tmp_path, "nan nan nan\n" * 4, lenient=True)


def test_lenient_refuses_more_damage_than_rows(tmp_path: Path) -> None:
    rows = ROWS.splitlines(keepends=True)
    with pytest.raises(FormatError, match="more rows are damaged than the 1 whole ones"):
        parse(tmp_path, rows[0] + "x\n" * 2 + rows[3], lenient=True)


@pytest.mark.parametrize("frames", [0, 1, 3])
def test_more_rows_than_said_are_all_read_with_a_note(tmp_path: Path, frames: int) -> None:
    loaded = parse(tmp_path, head=HEAD.replace("4", str(frames), 1))
    assert_the_motion(loaded)
    assert f"Frames: {frames}, but there are 4 rows of numbers: took these" in said(loaded)


def test_fewer_rows_than_said_are_read_leniently_only(tmp_path: Path) -> None:
    head = HEAD.replace("4", "5", 1)
    with pytest.raises(FormatError, match=r"Frames: 5, but there are 4 rows of numbers; is the file cut short\?"):
        parse(tmp_path, head=head)
    assert_the_motion(parse(tmp_path, head=head, lenient=True))


@pytest.mark.parametrize(
    ("more", "note"),
    [
        ("}\n", "found '}' after the 4 frames"),
        ("End of file\nend\n", "found 'End' after the 4 frames: what follows is not read"),
        ("\x1a", ""),
        ("\0\0\0\0", ""),
        (TREE + HEAD + ROWS, "another HIERARCHY begins after the 4 frames"),
        ("MOTION\n" + HEAD + ROWS, "another MOTION begins after the 4 frames: what follows is not read"),
        ("0.0 1.0", "found '0.0' after the 4 frames"),
    ],
)
def test_what_follows_all_frames_is_not_read(tmp_path: Path, more: str, note: str) -> None:
    loaded = parse(tmp_path, ROWS + more)
    assert_the_motion(loaded)
    assert note in said(loaded)
    assert not note or f"line {FIRST + 4}: " in said(loaded)


@pytest.mark.parametrize(
    ("head", "fps", "note"),
    [
        ("Frames: 4 frames\nFrame Time: 0.0333 s\n", 30.0, "Frame Time: '0.0333 s', read as 0.0333 s"),
        ("Frames: 4\nFrame Time: 0.0333333 seconds\n", 30.0, "read as 0.0333333 s"),
        ("Frames: 4\nFrame Time: 0.0333333s\n", 30.0, "read as 0.0333333 s"),
        ("Frames: 4\nFrame Time: 33.3 ms\n", 30.0, "read as 33.3 ms"),
        ("Frames: 4\nFrame Time: 33.3667 msec\n", 30_000 / 1001, "read as 33.3667 ms"),
        ("Frames: 4\nFrame Time: 8,333 ms\n", 120.0, "read as 8.333 ms"),
        ("Frames: 4\nFrame Time: 30 fps\n", 30.0, "read as 30 fps"),
        ("Frames: 4\nFrame Time: 29.97 Hz\n", 29.97, "read as 29.97 fps"),
        ("Frames: 4\nFrame Time: 0,0333333\n", 30.0, "read as 0.0333333 s"),
        ("Frames: 4\nFrame Time: 0.0333333 (30 fps)\n", 30.0, "read as 0.0333333 s"),
        ("Frames: 4\nFrame Time: 0.0333333 # thirty\n", 30.0, "read as 0.0333333 s"),
        ("Frames = 4\nFrameTime = .0333333\n", 30.0, ""),
        ("Number of frames: 4\nFrame Time: 0.04\n", 25.0, ""),
        ("Frames:\t4   \nFrame Time:\t0.04   \n", 25.0, ""),
    ],
)
def test_headers_with_words(tmp_path: Path, head: str, fps: float, note: str) -> None:
    loaded = parse(tmp_path, head=head)
    assert_the_motion(loaded)
    assert loaded.take.motion().fps == pytest.approx(fps, rel=1e-12)
    assert note in said(loaded)


@pytest.mark.parametrize(
    ("head", "message"),
    [
        (
            "Frames: 4\nFrame Time: 0.04 parsecs\n",
            rf":{FIRST - 1}: expected Frame Time: and seconds, found '0.04 parse",
        ),
        ("Frames: 4\nFrame Time: 0.04 0.0 90.5\n", "expected Frame Time: and seconds, found '0.04 0.0 90.5'"),
        ("Frames: 4\nFrame Time: 0 fps\n", "expected Frame Time: and seconds, found '0 fps'; give the rate with --fps"),
        ("Frames: 4\nFrame Time: 0.0.4\n", "expected Frame Time: and seconds, found '0.0.4'"),
        ("Frames: 4\nFrame Time: nan\n", "expected Frame Time: and seconds, found 'nan'"),
        ("Frames: 4\nFrame Time: \n", "expected Frame Time: and seconds, found ''; give the rate with --fps"),
        ("Frames: 4 5\nFrame Time: 0.04\n", rf":{FIRST - 2}: expected Frames: and a whole number, found '4 5'"),
        ("Frames: 4.5\nFrame Time: 0.04\n", "expected Frames: and a whole number, found '4.5'"),
        ("Frames: four\nFrame Time: 0.04\n", "expected Frames: and a whole number, found 'four'"),
    ],
)
def test_headers_that_say_nothing_are_refused(tmp_path: Path, head: str, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        parse(tmp_path, head=head)


def test_a_rate_that_is_given_is_taken_whatever_the_file_says(tmp_path: Path) -> None:
    assert parse(tmp_path, head="Frames: 4\nFrame Time: soon\n", fps=50.0).take.motion().fps == 50.0


@pytest.mark.parametrize(
    "offset", ["1.0, 0.5, 0.0", "1,0 0,5 0,0", "1.0;0.5;0.0", "1,0;0,5;0,0", "1.0D0 5.0D-01 0.0", "+1.0+0.5+0.0"]
)
def test_offsets_with_one_reading(tmp_path: Path, offset: str) -> None:
    path = tmp_path / "take.bvh"
    path.write_text(TREE.replace("1.0 0.5 0.0", offset) + HEAD + ROWS)
    loaded = read(path, ReadOptions("metre", "y"))
    assert loaded.take.motion().skeleton.offsets[1].tolist() == [1.0, 0.5, 0.0]
    assert "line 8: " in said(loaded)
    assert "is read as an OFFSET" in said(loaded)


@pytest.mark.parametrize("offset", ["1.0 0.5", "1.0 0.5 0.0.0", "1,0,0,5 0,0", "1.0 nan 0.0", "1.0 1e12 0"])
def test_offsets_without_one_reading_are_refused(tmp_path: Path, offset: str) -> None:
    path = tmp_path / "take.bvh"
    path.write_text(TREE.replace("1.0 0.5 0.0", offset) + HEAD + ROWS)
    with pytest.raises(FormatError, match=r"take\.bvh:[89]:\d+: expected an offset, a finite number, found"):
        read(path)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig"])
@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends_of_glued_rows(tmp_path: Path, encoding: str, ends: str) -> None:
    mark = {"utf-16-le": b"\xff\xfe", "utf-16-be": b"\xfe\xff"}.get(encoding, b"")
    text = (TREE + HEAD + ROWS.replace(" -", "-")).replace("MOTION", "MOTION:").replace("\n", ends)
    (tmp_path / "take.bvh").write_bytes(mark + text.encode(encoding))
    assert_the_motion(read(tmp_path / "take.bvh", ReadOptions("metre", "y")))


NUMBERS = st.lists(st.floats(-999, 999, allow_nan=False), min_size=1, max_size=12)


@given(NUMBERS, st.integers(1, 8))
def test_columns_of_one_width_are_read_or_refused_but_never_misread(numbers: list[float], decimals: int) -> None:
    words = [f"{number:.{decimals}f}" for number in numbers]
    expected = [float(word) for word in words]
    found = only_reading("".join(words).encode(), len(words))
    assert found is None or found[1].tolist() == expected
    assert found is not None or "." in "".join(words[1:])


@given(NUMBERS, st.sampled_from([",", ";", ", ", "; ", " "]), st.sampled_from([".", ","]))
def test_separators_are_read_or_refused_but_never_misread(numbers: list[float], between: str, point: str) -> None:
    words = [repr(number).replace(".", point) for number in numbers]
    found = only_reading(between.join(words).encode(), len(words))
    if (between, point) != (",", ","):  # 1,2,3 may be anything
        assert found is not None
        np.testing.assert_allclose(found[1], numbers, rtol=1e-15, atol=1e-300)


# --- files too long to be read at once


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streams, "BLOCK", 100)  # bytes: two rows


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("case", [case for case in SPELT if case not in ("all on one line",)])
def test_a_stream_reads_the_same_rows(tmp_path: Path, case: str) -> None:
    text = SPELT[case][0](ROWS)
    expected = parse(tmp_path, text).take.motion()
    opened = stream(tmp_path / "take.bvh", ReadOptions("metre", "y"))
    blocks = list(opened.blocks())
    assert opened.frames == 4
    np.testing.assert_array_equal(np.concatenate([block.translation for block in blocks]), expected.translation)
    np.testing.assert_array_equal(np.concatenate([block.rotations for block in blocks]), expected.rotations)
    assert SPELT[case][1].partition(",")[0] in " ".join(opened.late_notes)


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("more", ["", "}\n", "MOTION\n" + HEAD + ROWS])
@pytest.mark.parametrize("frames", [1, 3, 4])
def test_a_stream_of_more_rows_than_said_is_whole_in_a_library(tmp_path: Path, frames: int, more: str) -> None:
    expected = parse(tmp_path, ROWS + more, head=HEAD.replace("4", str(frames), 1))
    opened = stream(tmp_path / "take.bvh", ReadOptions("metre", "y"))
    library = Library.create(tmp_path / "library")
    add_stream(library, "take", opened)
    stored = library.take("take").motion()
    np.testing.assert_array_equal(stored.translation, expected.take.motion().translation)
    if frames != 4:
        assert f"Frames: {frames}, but there are 4 rows" in " ".join(opened.notes)


@pytest.mark.usefixtures("small_blocks")
def test_a_lenient_stream_repeats_the_row_before(tmp_path: Path) -> None:
    parse(tmp_path, ROWS.replace("91.5", "nan"), lenient=True)
    opened = stream(tmp_path / "take.bvh", ReadOptions("metre", "y", lenient=True))
    translation = np.concatenate([block.translation for block in opened.blocks()])
    assert translation[:, 0].tolist() == [0.0, 0.0, 1.0, 1.5]
    assert "1 repeat the row before" in " ".join(opened.late_notes)
    with pytest.raises(FormatError, match=rf":{FIRST + 1}:5: expected a finite number, found 'nan'"):
        list(stream(tmp_path / "take.bvh", ReadOptions("metre", "y")).blocks())
