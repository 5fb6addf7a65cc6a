"""The commands live, record and devices, on files that are replayed."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from command_line import run

import kinetograph as kg
from kinetograph.formats.readings import read_readings, write_readings
from kinetograph.library import Library
from kinetograph.sensing import preset, simulate
from kinetograph.take import Take
from walkers import walk


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("live")
    library = Library.create(made / "lib")
    for name, speed in (("a", 0.8), ("b", 1.2)):
        library.add(Take(name, {"motion": walk(3.0, speed=speed)}))
    write_readings(simulate(walk(2.0), preset("wii"), np.random.default_rng(0)), made / "r.csv")
    return made


def test_replayed_sensors_drive_a_body_in_a_file(folder: Path) -> None:
    done = run("live", "sense", "-l", folder / "lib", "--from", f"replay:{folder}/r.csv@4", "--to", folder / "o.bvh",
               "--json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["frames"] >= 118
    assert len(answer["sensors"]) == 8
    assert len(kg.load(folder / "o.bvh").motion()) == answer["frames"]
    again = run("live", "sense", "-l", folder / "lib", "--from", f"replay:{folder}/r.csv", "--to", folder / "o.bvh")
    assert again.returncode == 1
    assert "--force" in again.stderr


def test_sensors_are_recorded_under_the_layout_s_names(folder: Path) -> None:
    done = run("record", "--from", f"replay:{folder}/r.csv@10", "--sensor", "left_wrist=left_forearm", "-o",
               folder / "recorded.csv", "--json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    recorded, _ = read_readings(folder / "recorded.csv")
    assert "left_wrist" in recorded.names
    assert "left_forearm" not in recorded.names
    assert json.loads(done.stdout)["rows"] == len(recorded)


def test_devices_lists_rates_and_what_is_lost(folder: Path) -> None:
    done = run("devices", "--from", f"replay:{folder}/r.csv@5", "--seconds", "1.5", "--json")
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)
    assert len(rows) == 8
    assert all(90 < row["Hz"] < 110 for row in rows)


def test_a_stopped_session_leaves_a_whole_file(folder: Path) -> None:
    command = [sys.executable, "-m", "kinetograph", "live", "sense", "-l", str(folder / "lib")]
    command += ["--from", f"replay:{folder}/r.csv@0.2", "--to", str(folder / "stopped.bvh")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if "heard" in line:
                break
        time.sleep(2.0)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=20)
    assert process.returncode == 0
    frames = int(out.split("frames")[1].split()[0])
    assert frames == len(kg.load(folder / "stopped.bvh").motion())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("devices", "--from", "replay:nowhere.csv"), "nowhere.csv"),
        (("devices", "--from", "mind://reading"), "expected a source"),
        (("record", "--from", "mvn://", "-o", "x.csv", "--seconds", "0.3"), "nothing was heard"),
        (("record", "--from", "mvn://", "-o", "no/such/x.csv"), "expected a folder"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tmp_path: Path, monkeypatch, arguments, said: str) -> None:
    monkeypatch.chdir(tmp_path)
    done = run(*arguments)
    assert done.returncode == 1
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
