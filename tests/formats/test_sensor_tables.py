"""Tables of sensors as vendors and phones write them; inputs of our own, in their layouts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.readings import read_readings
from kinetograph.formats.sensor_tables import read_sensor_table
from kinetograph.sensing import GRAVITY

_HALF = 0.70710678

_TABLES = {
    "mt manager": (
        "// Start Time: Unknown\n// Update Rate: 100.0Hz\n"
        "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Mag_X,Quat_q0,Quat_q1,Quat_q2,Quat_q3\n"
        f"1,,9.81,0.5,-1,0.1,0.2,-0.3,1,{_HALF},{_HALF},0,0\n2,,9.81,0.5,-1,0.1,0.2,-0.3,1,{_HALF},{_HALF},0,0\n",
        0.01,
        True,
    ),
    "movella dot": (
        "sep=,\nDeviceTag:,Xsens DOT\nFirmwareVersion:,2.0.0\n\n"
        "PacketCounter,SampleTimeFine,Quat_W,Quat_X,Quat_Y,Quat_Z,FreeAcc_X,FreeAcc_Y,FreeAcc_Z,"
        "Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n"
        f"1,4294960000,{_HALF},{_HALF},0,0,0,0,0,9.81,0.5,-1,5.7295780,11.459156,-17.188734\n"
        f"2,9371,{_HALF},{_HALF},0,0,0,0,0,9.81,0.5,-1,5.7295780,11.459156,-17.188734\n",  # its counter begins anew
        0.016667,
        True,
    ),
    "x-io": (
        "Timestamp (us),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),"
        "Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)\n"
        f"1000000,5.7295780,11.459156,-17.188734,1,{0.5 / GRAVITY},{-1 / GRAVITY}\n"
        f"1002500,5.7295780,11.459156,-17.188734,1,{0.5 / GRAVITY},{-1 / GRAVITY}\n",
        0.0025,
        False,
    ),
    "phyphox": (
        '"Time (s)";"Acceleration x (m/s^2)";"Acceleration y (m/s^2)";"Acceleration z (m/s^2)"\n'
        "0.5;9.81;0.5;-1\n0.51;9.81;0.5;-1\n",
        0.01,
        None,
    ),
    "sensor logger": (
        "time,seconds_elapsed,z,y,x\n1700000000000000000,0.1,-1,0.5,9.81\n1700000000010000000,0.11,-1,0.5,9.81\n",
        0.01,
        None,
    ),
    "physics toolbox": (
        f"time,gFx,gFy,gFz\n0.1,1,{0.5 / GRAVITY},{-1 / GRAVITY}\n0.12,1,{0.5 / GRAVITY},{-1 / GRAVITY}\n",
        0.02,
        None,
    ),
}


@pytest.mark.parametrize("name", _TABLES)
def test_tables_of_vendors_say_the_same(tmp_path: Path, name: str) -> None:
    text, step, orientation = _TABLES[name]
    path = tmp_path / "left_wrist.csv"
    path.write_text(text)
    readings, notes = read_readings(path)
    assert readings.names == ("left_wrist",)
    assert np.allclose(readings.times, [0.0, step], atol=1e-9)
    assert np.allclose(readings.force, [[9.81, 0.5, -1.0]] * 2, atol=1e-6)
    if orientation is None:
        assert readings.angular is None
    else:
        assert readings.angular is not None
        assert np.allclose(readings.angular, [[0.1, 0.2, -0.3]] * 2, atol=1e-6)
        assert (readings.orientation is not None) == orientation
    assert notes  # what was assumed is said


def test_columns_that_cannot_be_guessed_are_named(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("clock;one;two;three\n0;1000;0;0\n10;1000;0;0\n")
    with pytest.raises(FormatError, match="--columns"):
        read_sensor_table(path)
    named = {"t": "clock [ms]", "ax": "one [mg]", "ay": "two [mg]", "az": "three [mg]"}
    readings, _ = read_sensor_table(path, "hip", named)
    assert readings.names == ("hip",)
    assert np.allclose(readings.force, [[GRAVITY, 0, 0]] * 2)
    assert np.allclose(readings.times, [0.0, 0.01])
    with pytest.raises(RequestError, match="no column 'four'"):
        read_sensor_table(path, None, {"ax": "four"})
    with pytest.raises(FormatError, match="unknown unit 'furlong'"):
        read_sensor_table(path, None, {"ax": "one [furlong]"})


def test_acceleration_without_gravity_is_not_taken_for_force(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(
        "Time (s),Linear Acceleration x (m/s^2),Linear Acceleration y (m/s^2),Linear Acceleration z (m/s^2)\n"
        "0,0,0,0\n0.1,0,0,0\n"
    )
    with pytest.raises(FormatError, match="with gravity"):
        read_readings(path)


def test_rows_that_are_damaged_or_out_of_order_are_left_out_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("time,Acc_X,Acc_Y,Acc_Z\n0,1,2,3\n0.1,1,x,3\n0.2,1,2,3\n0.15,1,2,3\n0.3,1,2\n0.4,1,2,3\n")
    readings, notes = read_readings(path)
    assert readings.times.tolist() == [0.0, 0.2, 0.4]
    assert any(note.startswith("2 rows with cells") for note in notes)
    assert any(note.startswith("1 rows left out, whose times") for note in notes)


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "\0\0\0", "t,sensor,ax\n", "time,Acc_X,Acc_Y,Acc_Z\n"])
def test_what_is_no_table_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(FormatError, match="expected"):
        read_readings(path)


def test_real_xsens_text_is_read_by_the_same_door(data_folder: Path) -> None:
    path = sorted((data_folder / "sensors" / "neura").glob("*_00B4*.txt"))[0]
    readings, notes = read_readings(path)
    assert len(readings) > 1000
    assert 0.9 < np.median(np.linalg.norm(readings.force, axis=1)) / GRAVITY < 1.1
    assert any("100 rows per second" in note for note in notes)
