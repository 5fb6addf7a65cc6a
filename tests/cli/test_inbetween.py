"""The commands inbetween, evaluate keyframe and reproduce, from outside."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import answer, invoke, run

import kinetograph as kg
from kinetograph.evaluation.reproduce import molina_tanco2000


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Path:
    library = tmp_path_factory.mktemp("inbetween") / "clips"
    names = ("humanoid3d_getup_facedown", "humanoid3d_jump", "humanoid3d_punch", "humanoid3d_run", "humanoid3d_walk")
    done = run("library", "create", library, *(clips_folder / f"{name}.txt" for name in names))
    assert done.returncode == 0, done.stderr
    return library


def test_from_pose_to_pose(clips: Path, tmp_path: Path):
    ends = ("--from", "take:humanoid3d_getup_facedown@0", "--to", "take:humanoid3d_run@0.4")
    motion, report = tmp_path / "rise.bvh", tmp_path / "rise.json"
    done = run("inbetween", *ends, "--seconds", 5, "-l", clips, "-o", motion, "--report", report, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["seconds"] == pytest.approx(5)
    assert kg.load(motion).motion().duration == pytest.approx(5)
    frames = json.loads(report.read_text())["frames"]
    assert len(frames) == 151
    assert frames[0]["take"] == "humanoid3d_getup_facedown"
    assert frames[0]["edited"] < 0.05
    done = run("inbetween", *ends, "--seconds", 1, "-l", clips, "-o", tmp_path / "no.bvh")
    assert done.returncode == 1
    assert "takes" in done.stderr
    assert "s at least" in done.stderr
    assert not (tmp_path / "no.bvh").exists()


def test_keys_from_a_file_and_what_contradicts_them(clips: Path, tmp_path: Path):
    keys = tmp_path / "keys.json"
    keys.write_text('{"keys": [{"pose": "take:humanoid3d_walk@0.2"}, {"pose": "take:humanoid3d_walk@0.9", "time": 3}]}')
    answer("inbetween", keys, "-l", clips, "-o", tmp_path / "walk.bvh")
    for arguments, wanted in (
        ((keys, "--to", "take:humanoid3d_walk@1"), "not both"),
        (("--to", "take:humanoid3d_walk@1"), "give --from and --to"),
        (("--from", "take:humanoid3d_walk@9", "--to", "take:humanoid3d_walk@1"), "9 s is outside its clip"),
    ):
        refused = invoke("inbetween", *arguments, "-l", clips, "-o", tmp_path / "no.bvh").exception
        assert wanted in str(refused)


def test_moves_are_named_or_refused(clips: Path, tmp_path: Path):
    made = json.loads(answer("inbetween", *_ENDS, "-l", clips, "-o", tmp_path / "walked.bvh", "--json").stdout)
    assert not any("jump" in piece or "punch" in piece for piece in made["pieces"])
    named = ("--move", "jump", "--without", "walk", "--json")
    made = json.loads(answer("inbetween", *_ENDS, "-l", clips, "-o", tmp_path / "jumped.bvh", *named).stdout)
    assert any("jump" in piece for piece in made["pieces"])
    assert not any("walk" in piece for piece in made["pieces"])
    refused = invoke("inbetween", *_ENDS, "-l", clips, "-o", tmp_path / "no.bvh", "--move", "tango").exception
    assert "nothing is called 'tango'; there are humanoid3d_getup_facedown, humanoid3d_jump" in str(refused)
    refused = invoke(
        "inbetween", *_ENDS, "-l", clips, "-o", tmp_path / "no.bvh", "--move", "walk", "--mode", "paper"
    ).exception
    assert "the paper's mode knows no names of moves" in str(refused)


def test_held_out_takes_are_named_or_refused(clips: Path):
    refused = invoke("evaluate", "keyframe", "-l", clips, "--held-out", "*subject5").exception
    assert "no take is called *subject5; there are humanoid3d_getup_facedown" in str(refused)


def test_the_papers_figures_are_drawn(tmp_path: Path, clips_folder: Path):
    found = molina_tanco2000.reproduce(tmp_path / "paper", effort=molina_tanco2000.Effort(2, 8, 10))
    numbers = json.loads((tmp_path / "paper" / "numbers.json").read_text())["section 4"]
    assert numbers["examples_used"][0] == "getup_facedown"
    assert numbers["examples_used"][-1] == "run"
    assert numbers["share"] > 0.97
    assert set(found) == {"section 4", "figure 6", "own frames as keys"}
    assert found["figure 6"]["runs"] == 8
    assert found["own frames as keys"][2]["pairs"] == 20
    assert found["own frames as keys"][2]["worst_mm"] < 1e-3
    page = (tmp_path / "paper" / "index.html").read_text()
    assert "interrupted" not in page
    for figure in range(2, 10):
        assert f"Figure {figure}: " in page
        assert (tmp_path / "paper" / f"figure{figure}.png").stat().st_size > 5_000


_ENDS = ("--from", "take:humanoid3d_getup_facedown@0", "--to", "take:humanoid3d_run@0.4")


def test_alternatives_get_files_of_their_own(clips: Path, tmp_path: Path):
    done = run("inbetween", *_ENDS, "-l", clips, "-o", tmp_path / "rise.bvh", "--alternatives", 2, "--json")
    assert done.returncode == 0, done.stderr
    written = [Path(path) for path in json.loads(done.stdout)["wrote"]]
    assert [path.name for path in written] == ["rise.bvh", "rise_2.bvh"]
    one, two = (kg.load(path).motion() for path in written)
    assert len(one) != len(two) or not np.allclose(one.rotations, two.rotations)


@pytest.mark.parametrize("mode", ["search", "paper"])
def test_the_report_tells_each_frames_share(clips: Path, tmp_path: Path, mode: str):
    report, motion = tmp_path / "rise.json", tmp_path / "rise.bvh"
    options = ("--mode", mode, "--clusters", 5, "-o", motion, "--report", report)
    done = run("inbetween", *_ENDS, "-l", clips, *options)
    assert done.returncode == 0, done.stderr
    frames = json.loads(report.read_text())["frames"]
    assert len(frames) == len(kg.load(motion).motion())
    shares = np.array([frame["weight"] for frame in frames])
    if mode == "search":  # nothing is mixed: pieces give way by offsets, which "edited" tells
        np.testing.assert_array_equal(shares, 1.0)
    else:  # around a seam the piece that a frame belongs to has the greater share
        assert 0.4 < shares.min() < 0.6
        assert np.mean(shares == 1.0) > 0.5


def test_a_part_is_met_and_the_result_says_how_good_it_is(clips: Path, tmp_path: Path):
    ends = ("--from", "take:humanoid3d_walk@0.2", "--to", "take:humanoid3d_punch@0.5; roles=right_hand; time=2")
    report = tmp_path / "reach.json"
    made = answer("inbetween", *ends, "-l", clips, "-o", tmp_path / "reach.bvh", "--json", "--report", report)
    summary = json.loads(made.stdout)
    assert summary["jump"] <= summary["jump_in_recordings"]
    assert summary["skate"] <= summary["skate_in_recordings"]
    statistics = json.loads(report.read_text())["statistics"]
    assert statistics["furthest edit"] == pytest.approx(summary["furthest_edit"])
    refused = invoke("inbetween", *ends[:3], f"{ends[3]}; right_hand=0,3,0", "-l", clips, "-o", tmp_path / "no.bvh")
    assert "the right hand is out of reach: it comes within" in str(refused.exception)
    refused = invoke("evaluate", "keyframe", "-l", clips).exception
    assert "a number of requests (--requests 100)" in str(refused)
