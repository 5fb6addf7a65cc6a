from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.formats.readings import read_layout, write_layout
from kinetograph.library import Library
from kinetograph.sensing import preset
from kinetograph.take import Take
from walkers import walk


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "kinetograph", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


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
    told = json.loads(done.stdout)
    assert told["frames"] == pytest.approx(120, abs=3)
    assert told["uncertainty_degrees"] > 0
    assert json.loads((folder / "out.json").read_text())["pieces"]
    assert kg.load(folder / "out.bvh").motion().fps == pytest.approx(60.0)


def worn(folder: Path) -> Path:
    """A layout of sensors that are turned on their bones, and readings of a walk by it."""
    layout = preset("wii")
    turns = rot.exp(np.random.default_rng(0).normal(size=(8, 3)))
    sensors = tuple(replace(s, rotation=q) for s, q in zip(layout.sensors, turns, strict=True))
    write_layout(replace(layout, sensors=sensors), folder / "worn.toml")
    done = run("simulate", folder / "walk.bvh", "--units", "metre", "--up", "y", "--layout", folder / "worn.toml",
               "-o", folder / "worn.csv", "--force")  # fmt: skip
    assert done.returncode == 0, done.stderr
    return folder / "worn.csv"


def test_sensors_are_calibrated_and_the_layout_goes_straight_into_sense(folder: Path):
    readings = worn(folder)
    done = run("calibrate", readings, "-l", folder / "lib", "--motion", folder / "walk.bvh", "--units", "metre",
               "--up", "y", "-o", folder / "mine.toml", "--json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert abs(told["clock_offset_ms"]) < 5
    assert len(told["sensors"]) == 8
    assert all(row["accepted"] and row["residual"] < 0.3 * row["before"] for row in told["sensors"])
    found, truth = read_layout(folder / "mine.toml"), read_layout(folder / "worn.toml")
    apart = [rot.angle_between(a.rotation, b.rotation) for a, b in zip(found.sensors, truth.sensors, strict=True)]
    assert np.degrees(apart).max() < 5.0
    done = run("sense", readings, "-l", folder / "lib", "--layout", folder / "mine.toml", "-o", folder / "mine.bvh")
    assert done.returncode == 0, done.stderr
    assert "calibrate the sensors" not in done.stderr


def test_sensors_that_are_worn_as_the_layout_says_need_no_calibration(folder: Path):
    readings = worn(folder)
    done = run("calibrate", readings, "-l", folder / "lib", "--motion", folder / "walk.bvh", "--units", "metre",
               "--up", "y", "--layout", folder / "worn.toml", "-o", folder / "again.toml")  # fmt: skip
    told = done.stderr.splitlines()[-1]
    assert done.returncode in (0, 1)
    assert "worse than none" in told
    done = run("calibrate", readings, "-l", folder / "lib", "--still", "3", "-o", folder / "no.toml")
    assert (done.returncode, "--still takes start:stop in seconds, as in 0:3; found '3'" in done.stderr) == (1, True)
    assert not (folder / "no.toml").exists()


def test_bad_requests_are_one_line(folder: Path):
    (folder / "g.csv").write_text("t,sensor,ax,ay,az\n0,left_forearm,0,1,0\n0.01,left_forearm,0,1,0\n")
    done = run("sense", folder / "g.csv", "-l", folder / "lib", "-o", folder / "g.bvh")
    assert done.returncode == 1
    assert "is it in g? multiply by 9.81" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (folder / "g.bvh").exists()
    done = run("simulate", folder / "walk.bvh", "--layout", "nintendo", "-o", folder / "n.csv")
    assert (done.returncode, "no layout 'nintendo'" in done.stderr) == (1, True)


def test_evaluating_prints_a_row_for_each_method(folder: Path):
    done = run("evaluate", "sensor", "-l", folder / "lib", "--synthesis", "continuity", "--only", "a", "--json")
    assert done.returncode == 0, done.stderr
    assert [row["method"] for row in json.loads(done.stdout)][-1] == "continuity"
