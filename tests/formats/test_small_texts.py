"""Small texts that people write, damaged: `small_texts` reads as many as one likes; and what their errors say."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import small_texts

from kinetograph.errors import FormatError
from kinetograph.formats import (
    read_keys,
    read_kinect,
    read_layout,
    read_qmt,
    read_readings,
    read_utd,
    read_vicon_rotations,
    read_xsens,
)
from kinetograph.library import read_annotations
from kinetograph.post import read_table
from kinetograph.studio.project import read_project

Texts = dict[str, tuple[bytes, small_texts.Reader]]
NAMES = (
    *("keys.json", "layout.toml", "readings.csv", "annotations.csv", "notes.csv", "beats.txt", "joints.tsv"),
    *("project.json", "xsens.txt", "vicon.csv", "path.csv"),
    *(f"{name}.csv" for name in small_texts.VENDORS),
)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Texts]:
    folder = tmp_path_factory.mktemp("texts")
    return folder, small_texts.texts(folder)


def test_every_text_is_named(good: tuple[Path, Texts]) -> None:
    assert set(good[1]) == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_damaged_texts_are_read_or_refused_in_one_line(good: tuple[Path, Texts], name: str) -> None:
    folder, texts = good
    text, reader = texts[name]
    (folder / name).write_bytes(text)
    reader(folder / name)
    fine, refused = small_texts.fuzz(name, text, reader, folder, 60, seed=7)
    assert fine + refused == 60
    assert refused > 10


LATIN = (
    ("keys.json", read_keys, b'{"keys": [{"pose": "\xe9t\xe9.bvh@0"}]}', ":1: expected .*byte 0xe9.*save it as UTF-8"),
    ("l.toml", read_layout, b'name = "a"\n# \xe9t\xe9\n', ":2: expected a layout, found byte 0xe9"),
    ("r.csv", read_readings, b"t,sensor,ax,ay,az\n0,\xe9t\xe9,0,9.8,0\n", ":2: expected the header .*byte 0xe9"),
    (
        "n.csv",
        lambda path: read_annotations(path, "a"),
        b"take,track,kind,label,start,stop\na,\xe9,x,y,0,1\n",
        ":2: .*0xe9",
    ),
    ("j.tsv", read_table, b"Hips\tpelvis\nBra\xe7o\tarm\n", ":2: expected a table of joints, found byte 0xe7"),
    ("p.json", read_project, b'{"mode": "\xe9"}', ":1: expected a project of the studio, found byte 0xe9"),
)


@pytest.mark.parametrize(("name", "reader", "data", "message"), LATIN, ids=[row[0] for row in LATIN])
def test_latin_1_is_named_with_its_line(
    tmp_path: Path, name: str, reader: small_texts.Reader, data: bytes, message: str
) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(FormatError, match=message):
        reader(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "reader", "data", "message"),
    [
        ("keys.json", read_keys, b"[" * 50_000, "expected .*keys.*, found"),
        ("keys.json", read_keys, b'{"keys": {"pose": ' * 50_000, "expected .*keys.*, found"),
        ("keys.json", read_keys, b'{"keys": [{"pose": 1}]}', r"Expected `str`, got `int` - at `\$.keys\[0\].pose`"),
        ("l.toml", read_layout, b"a = " + b"[" * 50_000, "expected a layout, found: brackets in brackets without end"),
        ("l.toml", read_layout, b"a = " + b"1" * 5_000, "expected a layout, found: "),
        ("l.toml", read_layout, b"sensor = 3", r"Expected `array`, got `int` - at `\$.sensor`"),
        ("l.toml", read_layout, b"[[device]]", r"Expected `object`, got `array` - at `\$.device`"),
        ("l.toml", read_layout, b"[device]\nrate = 'fast'", r"Expected `float`, got `str` - at `\$.device.rate`"),
        ("l.toml", read_layout, b"[device]\nbits = 1.5", r"Expected `int`, got `float`|Expected `int`"),
        (
            "l.toml",
            read_layout,
            b"[[sensor]]\nname='a'\njoint='b'\noffset=[[1],[2,3],4]",
            r"Expected `float`, got `array` - at `\$.sensor\[0\].offset\[0\]`",
        ),
        (
            "l.toml",
            read_layout,
            b"[[sensor]]\nname='a'\njoint='b'\nrotation=['1',0,0,0]",
            r"Expected `float`, got `str` - at `\$.sensor\[0\].rotation\[0\]`",
        ),
        ("p.json", read_project, b'{"walk": ' * 50_000, "expected a project of the studio, found"),
        (
            "x.txt",
            lambda path: read_xsens(path, "a"),
            small_texts.XSENS + b"3,0,x,0,0,0,0,1,0,0,0\n",
            ":5: .*found 'x'",
        ),
        ("x.txt", lambda path: read_xsens(path, "a"), small_texts.XSENS + b"3,0,1\n", ":5: .*'Acc_Z', found ''"),
        ("v.csv", read_vicon_rotations, small_texts.VICON + b"0,0,0,0\n", "unit quaternions, found one of length 0"),
        ("v.csv", read_vicon_rotations, b"// idx=one,2\n", "expected a line '// idx=first,last'"),
        ("v.csv", read_vicon_rotations, b"// idx=1,2\nqa_1,qa_2\n1,2\n", "found none called qa_3"),
    ],
)
def test_what_errors_say(tmp_path: Path, name: str, reader: small_texts.Reader, data: bytes, message: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(FormatError, match=message) as caught:
        reader(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 1500


SENSOR = {"acc": np.ones((5, 3)), "gyr": np.zeros((5, 3))}


@pytest.mark.parametrize(
    ("reader", "arrays", "message"),
    [
        (partial(read_utd, name="w"), {"d_iner": np.ones((5, 4))}, r"expected any x 6 finite numbers in 'd_iner'"),
        (partial(read_utd, name="w"), {"d_iner": np.full((5, 6), np.nan)}, "finite numbers in 'd_iner'"),
        (partial(read_utd, name="w"), {"d_iner": "text"}, "finite numbers in 'd_iner'"),
        (partial(read_utd, name="w"), {"other": 1}, "expected a matrix d_iner of 6 columns"),
        (read_kinect, {"d_skel": np.ones((20, 3))}, "expected 20 x 3 x any finite numbers in 'd_skel'"),
        (read_kinect, {"d_skel": np.ones((3, 20, 5))}, "expected 20 x 3 x any finite numbers in 'd_skel'"),
        (partial(read_qmt, names={"hip": "pelvis"}), {"t": 1, "hip": SENSOR}, "finite numbers in 't'"),
        (partial(read_qmt, names={"hip": "pelvis"}), {"t": np.arange(4), "hip": SENSOR}, "expected 4 x 3 .*'hip.acc'"),
        (partial(read_qmt, names={"hip": "pelvis"}), {"t": np.arange(5), "hip": {"acc": 1}}, "fields acc and gyr of"),
        (partial(read_qmt, names={"hip": "pelvis"}), {"t": np.arange(5), "hip": 3}, "fields acc and gyr of 'hip'"),
    ],
)
def test_matlab_files_of_another_form_are_refused(
    tmp_path: Path, reader: small_texts.Reader, arrays: dict[str, object], message: str
) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", arrays)
    with pytest.raises(FormatError, match=message):
        reader(tmp_path / "a.mat")
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file" + b"x" * 200)
    with pytest.raises(FormatError, match="expected a MATLAB file, found"):
        reader(tmp_path / "a.mat")
    with pytest.raises(FormatError, match="cannot open it"):
        reader(tmp_path / "none.mat")
