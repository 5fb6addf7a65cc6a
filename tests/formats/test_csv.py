"""Paths and signals as CSV: small files with known contents, dialects, errors, round trips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import Loaded, ReadOptions, WriteOptions, load, read, save
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

PATH = "t,x,z\n0,1,2\n0.5,3,4\n1.0,5,7\n"


def parse(tmp_path: Path, text: str | bytes, options: ReadOptions | None = None) -> Loaded:
    path = tmp_path / "file.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read(path, options)


def test_a_path_by_hand(tmp_path: Path) -> None:
    loaded = parse(tmp_path, PATH)
    path = loaded.take.signal("path")
    assert (path.names, path.units, path.fps, path.spatial) == (("path",), "m", 2.0, True)
    assert path.values[:, 0].tolist() == [[1, 0, 2], [3, 0, 4], [5, 0, 7]]
    assert path.valid.all()
    assert loaded.notes == ()


def test_columns_may_come_in_any_order_with_heights(tmp_path: Path) -> None:
    path = parse(tmp_path, "T, Z, Y, X\n0,3,2,1\n1,6,5,4\n").take.signal("path")
    assert path.values[:, 0].tolist() == [[1, 2, 3], [4, 5, 6]]


def test_units_and_up_of_a_path(tmp_path: Path) -> None:
    path = parse(tmp_path, "t,x,y\n0,100,200\n1,300,400\n", ReadOptions(units="centimetre", up="z")).take.signal("path")
    np.testing.assert_allclose(path.values[:, 0], [[1, 0, -2], [3, 0, -4]], atol=1e-12)


DIALECTS = {
    "CRLF": PATH.replace("\n", "\r\n").encode(),
    "byte-order mark": b"\xef\xbb\xbf" + PATH.encode(),
    "utf-16": PATH.encode("utf-16"),
    "semicolons": PATH.replace(",", ";").encode(),
    "decimal commas": PATH.replace(",", ";").replace(".", ",").encode(),
    "tabs": PATH.replace(",", "\t").encode(),
    "comments": ("# drawn by hand\n" + PATH.replace("0.5", "# half way\n0.5")).encode(),
    "blank lines": PATH.replace("\n", "\n\n").encode(),
    "spaces": PATH.replace(",", " , ").encode(),
    "quotes": PATH.replace("t,x,z", '"t","x","z"').encode(),
    "time": PATH.replace("t,", "Time,").encode(),
    "no newline at the end": PATH.rstrip().encode(),
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_mean_the_same(tmp_path: Path, dialect: str) -> None:
    path = parse(tmp_path, DIALECTS[dialect]).take.signal("path")
    assert path.values[:, 0].tolist() == [[1, 0, 2], [3, 0, 4], [5, 0, 7]]
    assert path.fps == 2


def test_uneven_rows_are_interpolated_at_the_median_rate(tmp_path: Path) -> None:
    loaded = parse(tmp_path, "t,x,z\n0,0,0\n1,1,0\n2,2,0\n4,4,8\n5,5,8\n")
    path = loaded.take.signal("path")
    assert path.fps == 1
    assert path.values[:, 0, 0].tolist() == [0, 1, 2, 3, 4, 5]
    assert path.values[:, 0, 2].tolist() == [0, 0, 0, 4, 8, 8]
    assert loaded.notes == ("rows are not at an even 1 Hz: interpolated",)


@pytest.mark.parametrize("fps", [30.0, 100.0, 120.0, 120_000 / 1001, 29.3])
@pytest.mark.parametrize("decimals", [3, 4, 6])
def test_rounded_times_are_an_even_rate(tmp_path: Path, fps: float, decimals: int) -> None:
    rows = [f"{i / fps:.{decimals}f},{i},0" for i in range(600)]
    loaded = parse(tmp_path, "t,x,z\n" + "\n".join(rows))
    assert loaded.take.signal("path").fps == pytest.approx(fps, rel=1e-12)
    assert loaded.take.signal("path").values[:, 0, 0].tolist() == list(range(600))


def test_a_rate_that_is_asked_for(tmp_path: Path) -> None:
    path = parse(tmp_path, PATH, ReadOptions(fps=4)).take.signal("path")
    assert path.values[:, 0].tolist() == [[1, 0, 2], [2, 0, 3], [3, 0, 4], [4, 0, 5.5], [5, 0, 7]]


def test_times_count_from_the_first_row(tmp_path: Path) -> None:
    loaded = parse(tmp_path, "t,x,z\n7,0,0\n7.5,1,0\n")
    assert loaded.take.signal("path").fps == 2
    assert loaded.notes == ("times begin at 7 s: counted from there",)


def test_channels_with_gaps(tmp_path: Path) -> None:
    signal = parse(tmp_path, "# units: m/s^2\nt,pitch,loud ness\n0,1,2\n1,,4\n2,5,\n").take.signal("signal")
    assert (signal.names, signal.units, signal.spatial) == (("pitch", "loud ness"), "m/s^2", False)
    assert signal.values.tolist() == [[1, 2], [0, 4], [5, 0]]
    assert signal.valid.tolist() == [[True, True], [False, True], [True, False]]


def test_gaps_stay_gaps_when_rows_are_interpolated(tmp_path: Path) -> None:
    signal = parse(tmp_path, "t,a\n0,0\n1,\n2,2\n3,3\n", ReadOptions(fps=2)).take.signal()
    assert signal.valid[:, 0].tolist() == [True, False, False, False, True, True, True]


def test_points(tmp_path: Path) -> None:
    text = "t,hand.x,hand.y,hand.z,toe.x,toe.y,toe.z\n0,1,2,3,4,5,6\n1,1,2,3,4,,6\n"
    signal = parse(tmp_path, text).take.signal("signal")
    assert (signal.names, signal.units) == (("hand", "toe"), "m")
    assert signal.values[0].tolist() == [[1, 2, 3], [4, 5, 6]]
    assert signal.valid.tolist() == [[True, True], [True, False]]
    channels = parse(tmp_path, text.replace("toe.z", "toe.w")).take.signal()
    assert not channels.spatial


ERRORS = {
    "empty": ("", r"file\.csv: expected a header t,x,z .*, found an empty file"),
    "no header": ("0,1,2\n1,2,3\n", r":1: expected a header t,x,z \(a path, .*\), .* found '0,1,2'"),
    "no z": ("t,x\n0,1\n1,2\n", r"expected a header t,x,z .*, found t,x"),
    "only t": ("t\n0\n1\n", r":1: expected a header t,x,z .*, found 't'"),
    "columns twice": ("t,x,x\n0,1,1\n", r":1: every column needs a name of its own, found 't,x,x'"),
    "readings": (
        "t,sensor,ax,ay,az\n0,hip,1,2,3\n",
        r":1: expected .*, found readings of sensors; `kinetograph sense`",
    ),
    "no rows": ("t,x,z\n", r"expected rows of numbers below the header, found none"),
    "repeated": (
        "t,x,z\n0,1,2\n0.5,3,4\n0.5,3,4\n",
        r":4: times must increase, found 0\.5 after 0\.5; is a row there twice",
    ),
    "backwards": ("t,x,z\n0,1,2\n\n-1,3,4\n", r":4: times must increase, found -1 after 0"),
    "nan": ("t,x,z\n0,1,2\n1,nan,4\n", r":3: expected a finite number in column 'x', found 'nan'"),
    "text": ("t,x,z\n0,1,2\n1,east,4\n", r":3: expected a finite number in column 'x', found 'east'"),
    "text in t": ("t,x,z\nnow,1,2\n", r":2: expected a finite number in column 't', found 'now'"),
    "no t": ("t,x,z\n,1,2\n", r":2: expected a time in the first column, found an empty cell"),
    "short row": ("t,x,z\n0,1,2\n1,2\n", r":3: expected 3 cells, found 2"),
    "gap in a path": ("t,x,z\n0,1,\n1,2,3\n", r"a path has no gaps, found an empty cell"),
    "one row": ("t,x,z\n0,1,2\n", r"one row gives no rate; add rows or give --fps"),
    "absurd times": (
        "t,x,z\n0,1,2\n1e-9,1,2\n2e-9,1,2\n1e9,1,2\n",
        r"4 rows over 1e\+09 s would become \d+ at 1e\+09 Hz",
    ),
    "binary": ("\0\1\2", r"expected comma-separated text, found bytes that are not text"),
    "huge cell": ("t,x,z\n0,1," + "9" * 200_000 + "\n", r":2: expected "),
}


@pytest.mark.parametrize("case", ERRORS)
def test_errors_are_one_line_with_the_place(tmp_path: Path, case: str) -> None:
    text, message = ERRORS[case]
    with pytest.raises(FormatError, match=message) as caught:
        parse(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_lenient_leaves_out_an_unfinished_last_row(tmp_path: Path) -> None:
    assert len(parse(tmp_path, PATH + "1.5,3", ReadOptions(lenient=True)).take.signal()) == 3


@st.composite
def signals(draw: st.DrawFn) -> Signal:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    frames, columns = draw(st.integers(1, 6)), draw(st.integers(1, 4))
    spatial = draw(st.booleans())
    values = rng.normal(0, 10.0 ** draw(st.integers(-6, 6)), (frames, columns, 3) if spatial else (frames, columns))
    names = tuple(
        draw(
            st.lists(st.sampled_from(["a", "hand", "é x", "p,q", "x"]), min_size=columns, max_size=columns, unique=True)
        )
    )
    if names in (("x",), ("path",)) and not spatial:
        names = ("other",)
    fps = draw(st.sampled_from([30.0, 120_000 / 1001, 7.0, 1000.0, 12.345]))
    return Signal(values, names, "m" if spatial else "g", fps, rng.random((frames, columns)) < 0.8)


@settings(max_examples=80)
@given(signal=signals())
def test_what_is_written_reads_back(tmp_path_factory: pytest.TempPathFactory, signal: Signal) -> None:
    path = tmp_path_factory.mktemp("csv") / "signal.csv"
    save(signal, path)
    back = load(path).signal("signal")
    assert (back.names, back.units, back.spatial) == (signal.names, signal.units, signal.spatial)
    assert back.fps == pytest.approx(signal.fps, rel=1e-12)
    np.testing.assert_array_equal(back.valid, signal.valid)
    np.testing.assert_array_equal(back.values, signal.values)


@pytest.mark.parametrize(("height", "header"), [(0.0, "t,x,z"), (1.0, "t,x,y,z")])
def test_a_path_is_written_as_a_path(tmp_path: Path, height: float, header: str) -> None:
    path = Signal(np.array([[[1.0, height, 2]], [[3, height, 4]]]), ("path",), "m", 2)
    save(Take("walk", {"path": path}), tmp_path / "path.csv")
    text = (tmp_path / "path.csv").read_text()
    assert text.startswith(header + "\n0.0,1.0,")
    np.testing.assert_array_equal(load(tmp_path / "path.csv").signal("path").values, path.values)


def test_a_motion_becomes_a_table_of_positions_or_of_angles(tmp_path: Path) -> None:
    bone = Skeleton(("a", "b c"), np.array([-1, 0]), np.array([[0.0, 0, 0], [0, 1, 0]]))
    rotations = rot.from_euler(np.radians([[[10.0, 20, 30], [0, 0, 0]], [[12.0, 22, 32], [0, 0, 0]]]), "zxy")
    motion = Motion(bone, np.array([[0.0, 1, 2], [0, 1, 3]]), rotations, 30)
    save(motion, tmp_path / "places.csv")
    places = load(tmp_path / "places.csv").signal()
    np.testing.assert_allclose(places.values, joint_positions(motion), atol=1e-8)
    assert (places.names, places.fps) == (("a", "b c"), 30.0)
    save(Take("t", {"motion": motion}), tmp_path / "angles.csv", options=WriteOptions(table="angles"))
    rows = (tmp_path / "angles.csv").read_text().splitlines()
    assert rows[0] == "# angles: degrees, intrinsic ZXY, outermost first; root in m, Y up"
    assert rows[1] == "t,a.tx,a.ty,a.tz,a.rz,a.rx,a.ry,b c.rz,b c.rx,b c.ry"
    np.testing.assert_allclose([float(cell) for cell in rows[2].split(",")], [0, 0, 1, 2, 10, 20, 30, 0, 0, 0])
    with pytest.raises(RequestError, match="holds one of positions, angles, found 'speeds'"):
        save(motion, tmp_path / "a.csv", options=WriteOptions(table="speeds"))


ALPHABET = "t,xz.;\n\r\t 0159-+e#\"'nai\0é"


@settings(max_examples=200)
@given(
    text=st.one_of(st.text(ALPHABET, max_size=60), st.text(ALPHABET, max_size=40).map(lambda s: "t,x,z\n0,1,2\n" + s))
)
def test_damaged_files_give_format_errors_and_nothing_else(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.csv"
    path.write_bytes(text.encode())
    try:
        load(path)
    except FormatError as error:
        if "\n" in str(error):
            raise


def test_times_of_points_are_rounded_as_their_own_decimals_say() -> None:
    from kinetograph.formats.csv import path_of

    rows = [(round(i / 30, 3), float(i), 2.0 * i) for i in range(7)]
    path = path_of(rows)
    assert path.fps == 30.0
    assert path.values[:, 0].tolist() == [[float(i), 0.0, 2.0 * i] for i in range(7)]
