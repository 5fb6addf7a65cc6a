"""What a BVH file of this package says of its units and axes, and that other readers do not mind."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.formats import ReadOptions, WriteOptions, read, save, stream
from kinetograph.formats.bvh.stamp import meaning, read_stamp, stamped
from kinetograph.formats.conventions import UNITS, UPS
from kinetograph.kinematics import joint_positions
from trees import walker


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("units", UNITS)
def test_a_file_says_its_units_and_axis(tmp_path: Path, units: str, up: str) -> None:
    save(walker(), tmp_path / "a.bvh", options=WriteOptions(units=units, up=up))
    loaded = read(tmp_path / "a.bvh")
    assert loaded.notes == ()
    assert loaded.take.motion().fps == 30.0
    places = joint_positions(loaded.take.motion())[:, 0]
    np.testing.assert_allclose(places, walker().translation, atol=1e-6)
    opened = stream(tmp_path / "a.bvh")
    assert opened.notes == ()
    np.testing.assert_allclose(next(opened.blocks()).translation, walker().translation, atol=1e-6)


def test_what_a_person_says_goes_before_what_the_file_says(tmp_path: Path) -> None:
    save(walker(), tmp_path / "a.bvh")
    loaded = read(tmp_path / "a.bvh", ReadOptions(units="inch"))
    np.testing.assert_allclose(loaded.take.motion().translation, 0.0254 * walker().translation, atol=1e-6)


@pytest.mark.parametrize("fps", [24.0, 30000 / 1001, 30.0, 59.94, 60000 / 1001, 100.0, 119.88, 120.0, 240.0, 97.3, 0.5])
def test_rates_come_back(fps: float) -> None:
    time, said = read_stamp(stamped(fps, "inch", "z").encode())
    assert said == ("inch", "z")
    assert abs(float(time) - 1.0 / fps) <= 0.5e-12
    assert abs(float(stamped(fps, "inch", "z")) - 1.0 / fps) <= 1.5e-12  # what another program reads


@given(st.floats(1e-5, 1.0))
def test_times_of_others_say_nothing(step: float) -> None:
    for text in (repr(step), f"{step:.6f}", f"{step:.10g}", f"{step:.17f}", f"{step:.20f}"):
        _, said = read_stamp(text.encode())
        assert said is None or "8614" in text


@pytest.mark.parametrize(
    "text",
    ["0.03333333333386149973", "0.03333333333386140173", "0.0333333333338614127", "8614", "", "0.03333333333386141274"],
)
def test_digits_that_are_no_stamp_are_a_time(text: str) -> None:
    assert read_stamp(text.encode()) == (text.encode(), None)


def test_the_stamp_is_found_after_the_frames() -> None:
    data = b"HIERARCHY\nMOTION\r\nFrames:\t  12\r\nframe time:  0.03333333333386144373\r\n"
    assert meaning(data, data.index(b"MOTION") + 6) == ("inch", "z")
    assert meaning(b"MOTION\nFrames: 1\n", 6) == (None, None)


@pytest.mark.filterwarnings("ignore")
def test_an_independent_reader_reads_the_rate(tmp_path: Path) -> None:
    pybvh = pytest.importorskip("pybvh")
    save(walker(), tmp_path / "a.bvh")
    assert pybvh.read_bvh_file(str(tmp_path / "a.bvh")).frame_time == pytest.approx(1 / 30, abs=1e-11)
