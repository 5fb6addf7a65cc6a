from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.readings import read_layout, read_readings, write_layout, write_readings
from kinetograph.formats.sensor_recordings import merge_sensors, motion_of_points, read_xsens
from kinetograph.kinematics import joint_positions
from kinetograph.sensing import Device, channels, preset, simulate
from walkers import walk

HEADER = "t,sensor,ax,ay,az\n"


def written(tmp_path: Path, text: str, name: str = "r.csv") -> Path:
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("angular", [False, True])
def test_readings_come_back_as_they_were(tmp_path: Path, angular: bool):
    readings = simulate(walk(1.0), preset("wii"), angular=angular)
    write_readings(readings, tmp_path / "r.csv")
    back, notes = read_readings(tmp_path / "r.csv")
    assert notes == ()
    assert set(back.names) == set(readings.names)
    assert [back.names[i] for i in back.sensors] == [readings.names[i] for i in readings.sensors]
    np.testing.assert_allclose(back.times, readings.times, atol=1e-6)
    np.testing.assert_allclose(back.force, readings.force, rtol=1e-5, atol=1e-5)
    assert (back.angular is not None) == angular


def test_orientations_comments_and_blank_lines_are_read(tmp_path: Path):
    said = "# from a phone\n# orientation: y up, sensor to world\n"
    text = said + "t,sensor,ax,ay,az,qw,qx,qy,qz\n0,hand,0,9.8,0,1,0,0,0\n\n0.01,hand,0,9.8,0,1,0,0,0\n"
    readings, _ = read_readings(written(tmp_path, text))
    assert readings.orientation is not None
    assert len(readings) == 2


def test_a_clocks_times_are_counted_from_the_first(tmp_path: Path):
    readings, notes = read_readings(written(tmp_path, HEADER + "1700000000,a,0,9.8,0\n1700000000.5,a,0,9.8,0\n"))
    assert readings.times.tolist() == [0.0, 0.5]
    assert notes == ("times begin at 1.7e+09 s: counted from there",)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("0.2,a,0,9.8,0\n0.1,a,0,9.8,0\n", r"r.csv:3: sensor 'a': time runs backwards at 0.1 s"),
        ("0.1,a,0,9.8,0\n0.1,a,0,9.8,0\n", r"r.csv:3: sensor 'a': two rows at 0.1 s; drop one"),
        ("0.1,a,nan,9.8,0\n", r"r.csv:2: expected a finite number in column 'ax', found 'nan'"),
        ("0.1,a,0,9.8\n", r"r.csv:2: expected 5 cells, found 4"),
        ("0.1,,0,9.8,0\n", r"r.csv:2: expected a sensor's name, found an empty cell"),
        ("", r"expected rows of readings below the header, found none"),
    ],
)
def test_bad_rows_are_refused_with_their_line(tmp_path: Path, rows: str, message: str):
    with pytest.raises(FormatError, match=message):
        read_readings(written(tmp_path, HEADER + rows))


def test_other_files_are_refused(tmp_path: Path):
    with pytest.raises(FormatError, match=r"expected the header t,sensor,ax,ay,az.*found 't,x,z'"):
        read_readings(written(tmp_path, "t,x,z\n0,1,2\n"))
    with pytest.raises(FormatError, match="found an empty file"):
        read_readings(written(tmp_path, "\n"))
    with pytest.raises(FormatError, match="cannot open it"):
        read_readings(tmp_path / "none.csv")


def test_a_layout_says_where_each_sensor_is(tmp_path: Path):
    text = """
        name = "wrists"
        [device]
        span_g = 3
        bits = 8
        rate = 50
        [[sensor]]
        name = "left"
        joint = "left_elbow"
        towards = "left_hand"
        along = 0.8
        offset = [0, 0.02, 0]
        rotation = [0, 0, 1, 0]
    """
    layout = read_layout(written(tmp_path, text, "l.toml"))
    assert layout.name == "wrists"
    assert layout.names == ("left",)
    assert layout.device == Device(span=3 * 9.81, bits=8, rate=50)
    assert layout.sensors[0].offset.tolist() == [0, 0.02, 0]


def test_a_layout_may_begin_with_a_preset(tmp_path: Path):
    layout = read_layout(written(tmp_path, 'preset = "wii"\n[device]\nloss = 0.3\n', "l.toml"))
    assert layout.names == preset("wii").names
    assert layout.device.loss == 0.3
    assert layout.device.bits == 8
    assert read_layout("phone").names == ("hand", "pocket")


@pytest.mark.parametrize("name", ["ideal", "wii", "phone", "imu"])
def test_a_layout_comes_back_as_it_was(tmp_path: Path, name: str):
    layout = preset(name)
    first = replace(layout.sensors[0], rotation=np.array([0.6, 0.0, 0.8, 0.0]), bias=np.array([0.1, 0.0, -0.2]))
    layout = replace(layout, sensors=(first, *layout.sensors[1:]))
    write_layout(layout, tmp_path / "l.toml", notes={first.name: "residual 0.3 m/s^2"})
    back = read_layout(tmp_path / "l.toml")
    assert back.device == layout.device
    assert [vars(s).keys() for s in back.sensors] == [vars(s).keys() for s in layout.sensors]
    for ours, theirs in zip(back.sensors, layout.sensors, strict=True):
        for field, value in vars(theirs).items():
            np.testing.assert_array_equal(getattr(ours, field), value)
    with pytest.raises(FormatError, match=r"a layout is written as .toml, found '.json'"):
        write_layout(layout, tmp_path / "l.json")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sensr = 1", r"expected a layout, found: Object contains unknown field `sensr`"),
        ('[[sensor]]\nname = "a"', r"Object missing required field `joint` - at `\$.sensor\[0\]`"),
        (
            '[[sensor]]\nname = "a"\njoint = "hips"\noffset = [1, 2]',
            r"an offset is three finite metres, found \[1.0, 2.0\]",
        ),
        ('[[sensor]]\nname = "a"\njoint = "hips"\nrotation = [0, 0, 0, 0]', r"a rotation is a quaternion w, x, y, z"),
        ("[device]\nloss = 2", r"loss is a share of packets from 0 up to 1, found 2"),
        ("name = ", r"expected TOML"),
        ('name = "empty"', r"expected sensors with names of their own"),
    ],
)
def test_a_bad_layout_is_refused(tmp_path: Path, text: str, message: str):
    with pytest.raises(FormatError, match=message):
        read_layout(written(tmp_path, text, "l.toml"))


def test_an_unknown_preset_is_refused_with_those_there_are():
    with pytest.raises(RequestError, match="no layout 'wi'"):
        read_layout("wi")


def test_an_xsens_text_is_read_by_its_column_names(tmp_path: Path):
    header = "// Update Rate: 100.0Hz\nPacketCounter,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n"
    text = header + "1,0,9.8,0,.1,.2,.3\n2,0,9.9,0,.1,.2,.3\n"
    readings = read_xsens(written(tmp_path, text, "x.txt"), "pelvis")
    assert readings.times.tolist() == [0.0, 0.01]
    assert readings.angular is not None
    assert readings.angular[0].tolist() == [0.1, 0.2, 0.3]
    assert readings.orientation is None
    with pytest.raises(FormatError, match="found none called Acc_X"):
        read_xsens(written(tmp_path, "// nothing\nPacketCounter\n1\n", "y.txt"), "pelvis")


def test_an_xsens_orientation_has_y_up(tmp_path: Path):
    header = "Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Quat_q0,Quat_q1,Quat_q2,Quat_q3\n"
    # at rest: lying, its z up; and rotated a quarter about x, its y up
    text = header + f"0,0,9.81,0,0,0,1,0,0,0\n0,9.81,0,0,0,0,{np.sqrt(0.5)},{np.sqrt(0.5)},0,0\n"
    one = read_xsens(written(tmp_path, text, "x.txt"), "pelvis")
    assert one.orientation is not None
    assert np.allclose(rot.rotate(one.orientation, one.force), [0, 9.81, 0], atol=1e-9)
    both = merge_sensors({"pelvis": one, "other": one})
    assert both.orientation is not None
    assert len(both.orientation) == 4
    assert merge_sensors({"pelvis": one, "other": replace(one, orientation=None)}).orientation is None


def test_points_become_a_motion_whose_joints_are_where_they_were():
    skeleton = motion_of_points(np.random.default_rng(0).normal(size=(3, 20, 3)), 30.0).skeleton
    parents, frames = skeleton.parents, 12
    rng = np.random.default_rng(1)
    lengths = rng.uniform(0.1, 0.4, 20)
    points = np.zeros((frames, 20, 3))
    direction = rng.normal(size=(20, 3)) + 0.2 * rng.normal(size=(frames, 20, 3))
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    for joint in range(1, 20):
        points[:, joint] = points[:, parents[joint]] + lengths[joint] * direction[:, joint]
    got = joint_positions(motion_of_points(points, 30.0))
    for joint in (5, 6, 7, 9, 10, 11, 13, 14, 15):  # below joints of one bone every rotation is possible
        bone = got[:, joint] - got[:, parents[joint]]
        np.testing.assert_allclose(bone, lengths[joint] * direction[:, joint], atol=1e-6)


@pytest.mark.parametrize("words", ["z up, from world to sensor", "Z-up world to sensor", "z up, world to sensor"])
def test_a_file_says_which_world_its_orientations_are_in(tmp_path: Path, words: str) -> None:
    path = tmp_path / "worn.csv"
    rows = "".join(f"{t / 100},s,0,9.81,0,0.7071068,-0.7071068,0,0\n" for t in range(5))
    path.write_text(f"# orientation: {words}\nt,sensor,ax,ay,az,qw,qx,qy,qz\n{rows}")
    readings, said = read_readings(path)
    assert said == ()
    # this quarter about x takes the world's z, which is up, to the sensor's y
    np.testing.assert_allclose(channels(readings, ("force", "tilt"))[:, 3:], [[0.0, 1.0, 0.0]] * 5, atol=1e-6)
    write_readings(readings, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text().startswith("# orientation: y up, from sensor to world\nt,sensor,")
    again, said = read_readings(tmp_path / "again.csv")
    assert said == ()
    np.testing.assert_allclose(again.orientation, readings.orientation, atol=1e-5)
    assert read_readings(path, oriented=False)[0].orientation is None


def test_a_world_that_cannot_be_read_is_refused_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "worn.csv"
    path.write_text("# from a suit\n# orientation: ENU\nt,sensor,ax,ay,az,qw,qx,qy,qz\n0,s,0,9.8,0,1,0,0,0\n")
    with pytest.raises(FormatError, match=r"worn.csv:2: expected '# orientation: y up, .*found '# orientation: ENU'"):
        read_readings(path)
