"""The command line from outside: exit statuses, one-line errors, JSON, nothing overwritten."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import run

import kinetograph as kg
from kinetograph.pipeline import winding_path


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Path:
    library = tmp_path_factory.mktemp("cli") / "walks"
    names = ("0walk_forward", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
    done = run("library", "create", library, *(clips_folder / f"{name}.txt" for name in names))
    assert done.returncode == 0, done.stderr
    return library


@pytest.fixture
def path_csv(tmp_path: Path) -> Path:
    kg.save(winding_path(), tmp_path / "path.csv")
    return tmp_path / "path.csv"


def test_help_and_version():
    assert "perform" in run("--help").stdout
    assert run("--version").stdout.split() == ["kinetograph", kg.__version__]


def test_wrong_usage_exits_with_2():
    assert run("perform").returncode == 2
    assert run("dance").returncode == 2


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("info", "missing.bvh"), "missing.bvh"),
        (("info", "file.xyz"), "expected one of"),
        (("library", "info", "nowhere"), "nowhere"),
        (("data", "fetch", "unknown"), "deepmimic-clips"),
        (("view", "missing.bvh", "-o", "a.png"), "missing.bvh"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_exits_with_1(arguments, says, tmp_path):
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 1
    assert says in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert "Traceback" not in done.stderr


def test_perform_writes_motion_picture_and_report(walks: Path, path_csv: Path, tmp_path: Path):
    names = ("walk.bvh", "walk.glb", "walk.png", "walk.json")
    bvh, glb, png, report = (tmp_path / name for name in names)
    options = ("-l", walks, "-o", bvh, "-o", glb, "--picture", png, "--report", report, "--mirror", "--json")
    done = run("perform", path_csv, *options)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    motion = kg.load(bvh).motion()
    assert len(motion) == summary["frames"]
    assert glb.read_bytes()[:4] == b"glTF"
    assert png.read_bytes()[:4] == b"\x89PNG"
    pieces = json.loads(report.read_text())["pieces"]
    assert pieces[0]["start"] <= 0 <= pieces[0]["stop"]
    assert {piece["take"] for piece in pieces} <= set(kg.Library.open(walks).names())
    path = winding_path().values[:, 0]
    reach = np.linalg.norm(motion.translation[:, None, [0, 2]] - path[None, :, [0, 2]], axis=-1).min(axis=1)
    assert np.quantile(reach, 0.95) < 0.06


def test_nothing_is_overwritten_without_force(walks: Path, path_csv: Path, tmp_path: Path):
    precious = tmp_path / "walk.bvh"
    precious.write_text("mine")
    done = run("perform", path_csv, "-l", walks, "-o", precious)
    assert done.returncode == 1
    assert "--force" in done.stderr
    assert precious.read_text() == "mine"
    assert run("perform", path_csv, "-l", walks, "-o", precious, "--force").returncode == 0
    assert precious.read_text().startswith("HIERARCHY")


def test_a_path_too_fast_is_performed_with_a_warning(walks: Path, tmp_path: Path):
    kg.save(winding_path(speed=4.0), tmp_path / "fast.csv")
    done = run("perform", tmp_path / "fast.csv", "-l", walks, "-o", tmp_path / "fast.bvh", "--mirror")
    assert done.returncode == 0, done.stderr
    assert "m/s" in done.stderr
    assert kg.load(tmp_path / "fast.bvh").motion().duration > 3


def test_a_folder_of_recordings_is_not_a_library(tmp_path: Path, path_csv: Path, clips_folder: Path):
    done = run("perform", path_csv, "-l", clips_folder, "-o", tmp_path / "a.bvh")
    assert done.returncode == 1
    assert "kinetograph library create" in done.stderr


def test_segment_annotate_check(tmp_path: Path, clips_folder: Path):
    library, table = tmp_path / "walks", tmp_path / "cuts.csv"
    assert run("library", "create", library, clips_folder / "humanoid3d_getup_facedown.txt").returncode == 0
    assert run("library", "segment", library, "--by", "fixed", "--length", "0.5").returncode == 0
    assert run("library", "annotate", library, "--export", table, "--kind", "cut").returncode == 0
    rows = table.read_text().splitlines()
    assert rows[0] == "take,track,kind,label,start,stop"
    table.write_text("\n".join(rows[:3]) + "\n")
    assert run("library", "annotate", library, "--from", table).returncode == 0
    info = json.loads(run("library", "info", library, "--json").stdout)
    assert info["annotations"]["cut"] == 2
    assert json.loads(run("library", "check", library, "--json").stdout)["sound"] is True


def test_convert_changes_rate_span_and_format(tmp_path: Path, clips_folder: Path):
    source = clips_folder / "humanoid3d_getup_facedown.txt"
    target = tmp_path / "part.bvh"
    done = run("convert", source, target, "--fps", 30, "--start", 0.5, "--end", 1.5, "--json")
    assert done.returncode == 0, done.stderr
    motion = kg.load(target).motion()
    assert (len(motion), motion.fps) == (31, 30.0)


def test_an_output_of_no_known_format_is_refused_before_anything_is_written(
    walks: Path, path_csv: Path, tmp_path: Path
):
    done = run("perform", path_csv, "-l", walks, "-o", tmp_path / "walk.bvh", "-o", tmp_path / "walk.xyz")
    assert done.returncode == 1
    assert "cannot write files of kind '.xyz'; expected one of" in done.stderr
    assert not (tmp_path / "walk.bvh").exists()


def test_why_a_clip_that_loops_has_no_cuts_is_said(tmp_path: Path, clips_folder: Path):
    library = tmp_path / "walks"
    assert run("library", "create", library, clips_folder / "0walk_forward.txt").returncode == 0
    done = run("library", "segment", library, "--by", "footplants")
    assert done.returncode == 0
    assert "1 not cut: clips that loop are cut when they are used, over several cycles: 0walk_forward" in done.stderr
