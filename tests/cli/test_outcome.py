"""What commands say when they end: what is good and bad about the result, with units."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import answer

import kinetograph as kg
from kinetograph.cli.outcome import in_words
from kinetograph.cli.output import result, table
from kinetograph.errors import KinetographError
from kinetograph.formats import load
from kinetograph.kinematics import role_positions
from kinetograph.take import Take
from walkers import walk


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A library of a walker, cut at footplants."""
    folder = tmp_path_factory.mktemp("outcome") / "walks"
    kg.Library.create(folder).add(Take("walk", {"body": walk(12.0, turn_rate=0.1)}))
    answer("library", "segment", folder, "--by", "footplants")
    return folder


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "path.csv"
    rows = [f"{t:.2f},{0.8 * t:.4f},{0.3 * np.sin(t):.4f}" for t in np.arange(0, 5, 0.1)]
    file.write_text("\n".join(["t,x,z", *rows]) + "\n")
    return file


def test_perform_says_first_how_far_the_hips_are_and_how_still_the_feet(
    path: Path, walks: Path, tmp_path: Path
) -> None:
    out = tmp_path / "walk.bvh"
    words = answer("perform", path, "-l", walks, "-o", out).stdout.splitlines()
    assert words[0].split("  ")[1].strip() == "hips from the path"
    assert words[1].strip().startswith("planted feet")
    assert "cm/s" in words[1]


def test_the_distance_from_the_path_is_that_of_what_was_written(path: Path, walks: Path, tmp_path: Path) -> None:
    out = tmp_path / "walk.bvh"
    summary = json.loads(answer("perform", path, "-l", walks, "-o", out, "--json").stdout)
    motion = load(out, units="metre", up="y").motion()
    hips = role_positions(motion, ("left_hip", "right_hip")).mean(axis=1)
    t = np.arange(len(motion)) / motion.fps
    away = np.hypot(hips[:, 0] - 0.8 * t, hips[:, 2] - 0.3 * np.sin(t))
    assert summary["hips_off_mean"] == pytest.approx(float(away.mean()), abs=0.01)
    assert summary["hips_off_most"] == pytest.approx(float(away.max()), abs=0.03)


def test_an_exact_search_is_said_to_be_and_a_varied_one_what_it_gives_up() -> None:
    summary = {"seconds": 1.0, "frames": 30, "pieces": 2, "takes_used": 1, "cost": 0.5}
    assert in_words({**summary, "optimal": True})["search"] == "no sequence of these segments costs less"
    assert "17 %" in in_words({**summary, "optimal": False, "gap": 0.17})["search"]
    assert "search" not in in_words(summary)


def test_a_path_of_x_and_y_is_refused_with_the_axis_that_is_up(tmp_path: Path, walks: Path) -> None:
    file = tmp_path / "xy.csv"
    file.write_text("t,x,y\n0,0,0\n1,1,0\n2,2,0\n")
    with pytest.raises(KinetographError, match=r"with y up, the ground is x,z.*--up"):
        answer("perform", file, "-l", walks, "-o", tmp_path / "walk.bvh")


def test_a_picture_of_an_unknown_kind_is_refused_with_all_kinds(path: Path, tmp_path: Path) -> None:
    with pytest.raises(KinetographError, match=r"\.png .*\.gif or \.mp4 .*\.html .*found '\.jpg'"):
        answer("view", path, "-o", tmp_path / "walk.jpg")


@pytest.mark.parametrize("write", [lambda rows: result(rows[0], True), lambda rows: table(rows, True)])
def test_numbers_that_are_not_finite_are_null_in_json(write, capsys):
    row = {"a": float("nan"), "b": np.float64("inf"), "parts": [1.5, {"deep": (float("-inf"), 2)}], "c": "NaN"}
    write([row])
    text = capsys.readouterr().out
    found = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    found = found[0] if isinstance(found, list) else found
    assert found == {"a": None, "b": None, "parts": [1.5, {"deep": [None, 2]}], "c": "NaN"}
