from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, run

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.cli.configurations import Estimation, Sensors, Tuning, sensor_control
from kinetograph.errors import KinetographError
from kinetograph.formats.readings import read_layout, write_layout, write_readings
from kinetograph.library import Library
from kinetograph.methods.sensor import ByMean
from kinetograph.sensing import preset, simulate
from kinetograph.take import Take
from walkers import walk


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("sense")
    library = Library.create(made / "lib")
    for name, speed in (("a", 0.8), ("b", 1.2)):
        library.add(Take(name, {"motion": walk(3.0, speed=speed)}))
    kg.save(walk(2.0), made / "walk.bvh")
    return made


def test_a_motion_becomes_readings_and_readings_a_motion(folder: Path):
    done = run("simulate", folder / "walk.bvh", "--units", "metre", "--up", "y", "-o", folder / "r.csv", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["sensors"] == 8
    done = run("sense", folder / "r.csv", "-l", folder / "lib", "-o", folder / "out.bvh", "--json",
               "--report", folder / "out.json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["frames"] == pytest.approx(120, abs=3)
    assert answer["uncertainty_degrees"] > 0
    assert json.loads((folder / "out.json").read_text())["pieces"]
    assert kg.load(folder / "out.bvh").motion().fps == pytest.approx(60.0)


def worn(folder: Path) -> Path:
    """A layout of sensors that are rotated on their bones, and readings of a walk by it."""
    layout = preset("wii")
    rotations = rot.exp(np.random.default_rng(0).normal(size=(8, 3)))
    sensors = tuple(replace(s, rotation=q) for s, q in zip(layout.sensors, rotations, strict=True))
    write_layout(replace(layout, sensors=sensors), folder / "worn.toml")
    write_readings(simulate(walk(2.0), read_layout(folder / "worn.toml")), folder / "worn.csv")
    return folder / "worn.csv"


def test_sensors_are_calibrated_and_the_layout_goes_straight_into_sense(folder: Path):
    readings = worn(folder)
    done = invoke("calibrate", readings, "-l", folder / "lib", "--motion", folder / "walk.bvh", "--units", "metre",
                  "--up", "y", "-o", folder / "mine.toml", "--json")  # fmt: skip
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    assert abs(answer["clock_offset_ms"]) < 5
    assert len(answer["sensors"]) == 8
    assert (answer["verdict"], answer["passed"]) == ("good", 8)
    assert answer["residual"] < 1.0
    assert answer["pose_error_degrees"] < 15.0
    assert all(row["accepted"] and row["residual"] < 0.3 * row["before"] for row in answer["sensors"])
    calibrated, truth = read_layout(folder / "mine.toml"), read_layout(folder / "worn.toml")
    apart = [rot.angle_between(a.rotation, b.rotation) for a, b in zip(calibrated.sensors, truth.sensors, strict=True)]
    assert np.degrees(apart).max() < 5.0
    done = invoke("sense", readings, "-l", folder / "lib", "--layout", folder / "mine.toml", "-o", folder / "mine.bvh")
    assert done.exit_code == 0, done.stderr
    assert "calibrate the sensors" not in done.stderr


def test_sensors_that_are_worn_as_the_layout_says_need_no_calibration(folder: Path):
    readings = worn(folder)
    done = invoke("calibrate", readings, "-l", folder / "lib", "--motion", folder / "walk.bvh", "--units", "metre",
                  "--up", "y", "--layout", folder / "worn.toml", "-o", folder / "again.toml")  # fmt: skip
    assert "no better than none" in done.stderr + str(done.exception)
    done = invoke("calibrate", readings, "-l", folder / "lib", "--still", "3", "-o", folder / "no.toml")
    assert "--still takes start:stop in seconds, as in 0:3; found '3'" in str(done.exception)
    assert not (folder / "no.toml").exists()


def test_a_calibration_that_most_sensors_fail_is_not_written(folder: Path):
    readings = simulate(walk(3.0), preset("wii"))
    wild = np.random.default_rng(3).normal(size=(len(readings), 3)) * 6 + [0.0, 9.8, 0.0]
    write_readings(replace(readings, force=wild), folder / "wild.csv")
    done = invoke("calibrate", folder / "wild.csv", "-l", folder / "lib", "-o", folder / "wild.toml")
    assert not (folder / "wild.toml").exists()
    said = str(done.exception)
    assert "calibration is poor: " in said
    assert "of 8 sensors pass" in said
    assert "no layout is made of it; stand upright and still for 3 s, arms hanging (--still 0:3)" in said
    assert "without --motion and --still rotations about the vertical are guessed" in done.stderr


def test_what_a_calibration_is_worth_is_said(folder: Path):
    done = invoke("calibrate", worn(folder), "-l", folder / "lib", "--motion", folder / "walk.bvh", "--units", "metre",
                  "--up", "y", "-o", folder / "said.toml")  # fmt: skip
    assert "calibration is good: 8 of 8 sensors pass, residual" in done.stderr
    assert "degrees at a joint, measured on the motion" in done.stderr


def test_settings_of_syntheses_are_options(folder: Path):
    worn(folder)
    made = Tuning(ahead=0.0, choice="mean", control_weight=0.5)
    method = sensor_control(Sensors(), Estimation(), "optimisation", ("force",), 60.0, made)
    assert (method.synthesis.ahead, method.synthesis.control_weight) == (0.0, 0.5)
    assert method.synthesis.local.choice == ByMean()
    slow = sensor_control(Sensors(), Estimation(), "continuity", ("force",), 60.0, Tuning(memory=0.6, cautious=False))
    assert (slow.synthesis.memory, slow.synthesis.cautious, slow.synthesis.jump) == (0.6, False, 2.0)
    done = invoke("sense", folder / "worn.csv", "-l", folder / "lib", "-o", folder / "no.bvh", "--ahead", "0")
    assert "guided has no setting 'ahead'; it has path, ridge" in str(done.exception)
    done = invoke("sense", folder / "worn.csv", "-l", folder / "lib", "-o", folder / "no.bvh",
                  "--synthesis", "interpolation", "--choice", "nearest")  # fmt: skip
    assert "choice must be one of density, mean, found 'nearest'" in str(done.exception)


def test_bad_requests_are_one_line(folder: Path):
    (folder / "g.csv").write_text("t,sensor,ax,ay,az\n0,left_forearm,0,1,0\n0.01,left_forearm,0,1,0\n")
    done = run("sense", folder / "g.csv", "-l", folder / "lib", "-o", folder / "g.bvh")
    assert done.returncode == 1
    assert "is it in g? multiply by 9.81" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (folder / "g.bvh").exists()
    done = run("simulate", folder / "walk.bvh", "--layout", "nintendo", "-o", folder / "n.csv")
    assert (done.returncode, "no layout 'nintendo'" in done.stderr) == (1, True)


UP = "left_forearm,0.1,9.8,0"


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (f"0,{UP}\n0.02,{UP}\n0.01,{UP}\n", "bad.csv:4: sensor 'left_forearm': time runs backwards at 0.01 s"),
        (f"0,{UP}\n0,{UP}\n", "bad.csv:3: sensor 'left_forearm': two rows at 0 s; drop one"),
        ("0,left_forearm,nan,9.8,0\n", "bad.csv:2: expected a finite number in column 'ax', found 'nan'"),
        (f"0,{UP}\n0.01,left_forarm,0,9.8,0\n", "unknown sensor 'left_forarm'"),
        (f"0,{UP}\n900000,{UP}\n", "readings leap from 0 s to 900000 s"),
        ("0,left_forearm,980,0,0\n", "is it in counts or milli-g?"),
    ],
)
def test_bad_rows_are_one_line_and_nothing_is_written(folder: Path, rows: str, message: str):
    (folder / "bad.csv").write_text("t,sensor,ax,ay,az\n" + rows)
    done = invoke("sense", folder / "bad.csv", "-l", folder / "lib", "-o", folder / "bad.bvh")
    assert isinstance(done.exception, KinetographError)
    assert message in str(done.exception)
    assert not (folder / "bad.bvh").exists()


def test_a_stream_that_stops_is_held_and_a_missing_joint_is_named(folder: Path):
    rows = "".join(f"{t:.2f},{UP}\n" for t in np.concatenate([np.arange(0, 1, 0.02), np.arange(3, 4, 0.02)]))
    (folder / "stop.csv").write_text("t,sensor,ax,ay,az\n" + rows)
    command = ["sense", folder / "stop.csv", "-l", folder / "lib", "-o", folder / "stop.bvh", "--force"]
    done = invoke(*command)
    assert done.exit_code == 0
    assert "no readings at all for" in done.stderr
    assert "the pose was held, with growing uncertainty" in done.stderr
    (folder / "cat.toml").write_text('[[sensor]]\nname = "left_forearm"\njoint = "tail"\n')
    done = invoke(*command, "--layout", folder / "cat.toml")
    assert "sensor 'left_forearm': the skeleton has no joint or role 'tail'; it has" in str(done.exception)


def test_evaluating_prints_a_row_for_each_method(folder: Path):
    done = run("evaluate", "sensor", "-l", folder / "lib", "--synthesis", "continuity", "--only", "a", "--json")
    assert done.returncode == 0, done.stderr
    numbers = json.loads(done.stdout)
    assert [row["method"] for row in numbers["means"]][-1] == "continuity"
    assert {row["take"] for row in numbers["takes"]} == {"a"}
