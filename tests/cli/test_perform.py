"""Performing from the command line: what is refused, in one line and with nothing written; what the report tells."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import KinetographError
from kinetograph.formats.readings import write_readings
from kinetograph.kinematics import role_positions
from kinetograph.motion import place
from kinetograph.sensing import preset, simulate
from kinetograph.take import Annotation, Take
from walkers import walk

_ROLES = ("left_toe", "right_toe", "hips")  # the stick figure has no chest
_TARGETS = tuple(text for role in _ROLES for text in ("--target-point", role))
_CONTROLS = tuple(text for role in _ROLES for text in ("--control-point", role))


def _cuts(track: str) -> tuple[Annotation, ...]:
    return tuple(Annotation(track, "cut", "", t, t) for t in np.arange(13) / 2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Libraries of walks, of pairs and of talks, and controls for them."""
    root = tmp_path_factory.mktemp("perform")
    leader = walk(6.0, turn_rate=0.3)
    pair = {"leader": leader, "follower": place(leader, 0.0, (0.1, 0.0, 0.3))}
    marks = (
        Annotation("follower", "move", "basic", 0.0, 3.0),
        Annotation("follower", "style", "calm", 0.0, 6.0),
        Annotation("follower", "handhold", "left_hand:right_hand", 1.0, 5.0),
    )
    times = np.arange(181) / 30
    speech = kg.Signal(np.stack([np.sin(times), times], axis=1), ("loudness", "pitch"), "", 30.0)
    takes = {
        "walks": Take("walk", {"body": leader}, _cuts("body")),
        "pairs": Take("pair", pair, _cuts("follower")),
        "danced": Take("pair", pair, (*_cuts("follower"), *marks)),
        "talks": Take("talk", {"speech": speech, "body": leader}, _cuts("body")),
    }
    for name, take in takes.items():
        kg.Library.create(root / name).add(take)
    kg.save(kg.Signal(leader.translation[:, None], ("path",), "m", 30.0), root / "path.csv")
    kg.save(leader, root / "leader.bvh")
    kg.save(speech, root / "speech.csv")
    rows = (root / "speech.csv").read_text().splitlines()
    (root / "short.csv").write_text("t,x,z\n" + "".join(f"{i / 30},0,{i / 30}\n" for i in range(5)))
    (root / "nan.csv").write_text("t,x,z\n0,0,0\n0.1,nan,0.1\n0.2,0,0.2\n")
    (root / "gap.csv").write_text("\n".join([*rows[:40], rows[40].rpartition(",")[0] + ",", *rows[41:]]))
    return root


Run = Callable[..., dict[str, Any]]


@pytest.fixture
def run(folder: Path, tmp_path: Path) -> Run:
    """The command on a control and a library; its answer."""

    def performed(control: str, library: str, *options: object) -> dict[str, Any]:
        files = (folder / control, "-l", folder / library, "-o", tmp_path / "out.bvh")
        values: dict[str, Any] = json.loads(answer("perform", *files, "--json", *options).stdout)
        return values

    return performed


@pytest.mark.parametrize(
    ("control", "library", "options", "says"),
    [
        ("short.csv", "walks", (), r"the control is too short: it lasts 0\.10 s, the library's shortest segment"),
        ("nan.csv", "walks", (), r"nan\.csv:3: expected a finite number in column 'x', found 'nan'"),
        ("path.csv", "walks", ("--target", "singer"), "no take has a track 'singer'; their tracks are body"),
        (
            "leader.bvh",
            "pairs",
            ("--target", "singer"),
            "no take has a track 'singer'; their tracks are follower, leader",
        ),
        ("leader.bvh", "pairs", (), r"several motions \(follower, leader\); name the one to make \(--target\)"),
        ("path.csv", "walks", ("--exclude", "run"), "no take or tag 'run' to leave out; there are walk"),
        ("path.csv", "walks", ("--alignment", "round"), "similarity, affine, rigid, fixed or none, found 'round'"),
        (
            "gap.csv",
            "talks",
            ("--target", "body"),
            r"the control misses 1 samples, the first at 1\.\d+ s; fill them in",
        ),
        ("speech.csv", "walks", (), r"a walk follows one point .* found 2 channels: loudness, pitch"),
        (
            "speech.csv",
            "talks",
            ("--target", "body", "--alignment", "ground"),
            r"\(on the command line: none\), found Ground",
        ),
        ("leader.bvh", "walks", ("--facing", "90"), "--facing is for a drawn path"),
        ("path.csv", "walks", ("--layer", "wings=a.bvh"), r"as in arms=wave.bvh@2.5, with parts among arms, .*'wings"),
        ("path.csv", "walks", ("--layer", "arms=a.bvh@2"), "--layer: there is no file a.bvh"),
        ("path.csv", "walks", ("--why", "7"), r"--why: the control lasts 6\.00 s, found a time of 7 s"),
        (
            "leader.bvh",
            "talks",
            ("--target", "body"),
            "take 'talk': the control has no point left_toe, .* its columns are loudness, pitch",
        ),
        (
            "leader.bvh",
            "pairs",
            ("--target", "follower", "--transcript", "moves.csv", *_CONTROLS),
            "the library names no moves",
        ),
    ],
)
def test_what_is_refused(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    control: str,
    library: str,
    options: tuple[str, ...],
    says: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(KinetographError, match=says) as caught:
        run(control, library, *_TARGETS, *options)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_path_begins_facing_as_it_is_asked(run: Run, tmp_path: Path) -> None:
    run("path.csv", "walks", "--facing", "60")
    motion = kg.load(tmp_path / "out.bvh").motion()
    first = np.degrees(rot.heading(motion.rotations[0, 0]))
    assert abs((first - 60.0 + 180.0) % 360.0 - 180.0) < 25.0
    run("path.csv", "walks", "--force")
    plain = kg.load(tmp_path / "out.bvh").motion()
    assert abs(np.degrees(rot.heading(plain.rotations[0, 0]))) < 25.0


def test_channels_are_followed_without_a_transform(run: Run, tmp_path: Path) -> None:
    run("speech.csv", "talks", "--target", "body", *_TARGETS, "--report", tmp_path / "report.json")
    pieces = json.loads((tmp_path / "report.json").read_text())["pieces"]
    assert {tuple(piece["shift"]) for piece in pieces} == {(0.0, 0.0, 0.0)}
    assert [piece["source_start"] for piece in pieces[:3]] == pytest.approx([piece["start"] for piece in pieces[:3]])


def test_every_piece_says_where_it_is_from_and_what_it_costs(run: Run) -> None:
    summary = run("path.csv", "walks", "--pieces")
    rows = summary["breakdown"]
    assert len(rows) == summary["pieces"]
    assert {row["take"] for row in rows} == {"walk"}
    assert sum(row["interpretation"] for row in rows) == pytest.approx(summary["cost_of_interpretation"])
    assert sum(row["continuity"] for row in rows) == pytest.approx(summary["cost_of_continuity"])
    for row in rows:
        assert row["stretch"] == pytest.approx((row["stop"] - row["start"]) / (row["to"] - row["from"]))
    assert "breakdown" not in run("path.csv", "walks", "--force")


def test_why_a_piece_is_there(run: Run, tmp_path: Path, folder: Path) -> None:
    summary = run("path.csv", "walks", "--why", 2.2, "--why", 0, "--pieces", "--report", tmp_path / "report.json")
    (reasons, first) = summary["why"]
    assert (reasons["second"], first["second"]) == (2.2, 0.0)
    (chosen,) = (piece for piece in reasons["pieces"] if piece["chosen"])
    there = next(row for row in summary["breakdown"] if row["start"] <= 2.2 < row["stop"])
    assert chosen["source_start"] == pytest.approx(there["from"])
    assert chosen["total"] == pytest.approx(summary["cost"], rel=1e-4)
    assert chosen["total"] == pytest.approx(sum(chosen["terms"].values()))
    margins = [piece["margin"] for piece in reasons["pieces"]]
    assert margins[0] == pytest.approx(0.0, abs=1e-9)
    assert margins == sorted(margins)
    assert json.loads((tmp_path / "report.json").read_text())["why"] == summary["why"]
    files = (folder / "path.csv", "-l", folder / "walks", "-o", tmp_path / "other.bvh")
    said = answer("perform", *files, "--why", 2.2).stdout
    assert f"why walk {there['from']:.2f}-{there['to']:.2f} s at 2.2 s" in said


def test_arms_are_driven_by_a_motion_or_by_readings(run: Run, tmp_path: Path, folder: Path) -> None:
    leader = kg.load(folder / "leader.bvh").motion()
    raised = leader.rotations.copy()
    raised[:, leader.skeleton.index("left_shoulder")] = rot.about("z", 1.0)
    kg.save(replace(leader, rotations=raised), tmp_path / "wave.bvh")
    plain = run("path.csv", "walks", "--force")
    feet = role_positions(kg.load(tmp_path / "out.bvh").motion(), ("left_foot", "right_foot"))
    layer = ("--layer", f"arms={tmp_path / 'wave.bvh'}@1.5", "--layer-ease", 0.2)
    report = tmp_path / "report.json"
    summary = run("path.csv", "walks", *layer, "--report", report, "--force")
    assert summary["cost"] == plain["cost"]
    assert summary["layers"][0]["name"] == "wave.bvh"
    motion = kg.load(tmp_path / "out.bvh").motion()
    np.testing.assert_allclose(role_positions(motion, ("left_foot", "right_foot")), feet, atol=1e-3)
    shoulder = motion.skeleton.index("left_shoulder")
    angles = rot.angle_between(motion.rotations[:, shoulder], rot.about("z", 1.0))
    assert angles[60:].max() < 1e-3
    assert angles[:45].min() > 0.5
    runs = json.loads(report.read_text())["joints"]["left_shoulder"]
    assert [(each["layer"], each["first"]) for each in runs] == [(None, 0), ("wave.bvh", 46)]
    write_readings(simulate(leader, preset("wii"), np.random.default_rng(0)), tmp_path / "r.csv")
    readings = run("path.csv", "walks", "--layer", f"left arm={tmp_path / 'r.csv'}", "--force")
    assert len(readings["layers"][0]["joints"]) == 3


@pytest.mark.parametrize("alike", [False, True])
def test_alternatives_are_written_next_to_the_best(run: Run, tmp_path: Path, alike: bool) -> None:
    single = run("path.csv", "walks", "--reuse", 0)
    sharing = ("--alike",) if alike else ()
    options = ("--reuse", 0, "--alternatives", 3, *sharing, "--report", tmp_path / "r.json", "--force")
    summary = run("path.csv", "walks", *options)
    assert {p.name for p in tmp_path.iterdir()} >= {"out.bvh", "out_2.bvh", "out_3.bvh", "r_2.json", "r_3.json"}
    assert single["optimal"]
    assert summary["cost"] == pytest.approx(single["cost"])
    assert summary["cost"] <= summary["cost_2"] <= summary["cost_3"]
    lasting = {json.dumps(json.loads(p.read_text())["pieces"]) for p in tmp_path.glob("r*.json")}
    assert len(lasting) == 3
    (tmp_path / "out.bvh").unlink()
    with pytest.raises(KinetographError, match=r"out_2\.bvh"):
        run("path.csv", "walks", "--alternatives", 2)


def test_reuse_costs_and_what_that_gives_up_is_said(run: Run) -> None:
    free = run("path.csv", "walks", "--reuse", 0, "--gap")
    assert (free["optimal"], free["gap"]) == (True, 0.0)
    assert "cost_of_reuse" not in free
    varied = run("path.csv", "walks", "--reuse", 30, "--gap", "--force")
    assert not varied["optimal"]
    assert varied["times_running"] == 1
    assert varied["gap"] > 0


def test_pieces_are_listed_as_a_table_too(folder: Path, tmp_path: Path) -> None:
    done = answer("perform", folder / "path.csv", "-l", folder / "walks", "-o", tmp_path / "out.bvh", "--pieces")
    lines = done.stdout.splitlines()
    assert lines[0].split() == ["start", "stop", "take", "from", "to", "stretch", "interpretation", "continuity"]
    assert lines[1].split()[2] == "walk"


def test_what_the_recordings_are_annotated_with_comes_along(run: Run, tmp_path: Path) -> None:
    report, moves = tmp_path / "report.json", tmp_path / "moves.csv"
    options = (*_TARGETS, *_CONTROLS, "--report", report, "--transcript", moves)
    run("leader.bvh", "danced", "--target", "follower", "--stretch", 0, "--span", 1, "--rate", 10, *options)
    found = json.loads(report.read_text())["annotations"]
    spans = {(note["kind"], note["label"]): (note["start"], note["stop"]) for note in found}
    assert spans["style", "calm"] == pytest.approx((0.0, 6.0), abs=0.1)
    assert spans["move", "basic"] == pytest.approx((0.0, 3.0), abs=0.1)
    assert spans["handhold", "left_hand:right_hand"] == pytest.approx((1.0, 5.0), abs=0.1)
    assert ("contact", "left_toe") in spans
    assert moves.read_text().startswith("move,start,stop,margin\nbasic,0.000,")


def test_a_library_is_grown_from_a_take_and_compared(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    for name, turn, by_hand in (("a", 0.3, True), ("b", -0.2, True), ("c", 0.1, False)):
        steps = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(1, 12) / 2) if by_hand else ()
        library.add(Take(name, {"body": walk(6.0, turn_rate=turn)}, steps))
    line = ("library", "segment", library.path, "--by", "examples")
    rows = {row["take"]: row for row in json.loads(answer(*line, "--json").stdout)}
    assert set(rows) == {"a", "b", "c"}
    assert min(rows["a"]["f1"], rows["b"]["f1"]) > 0.9
    assert (rows["c"]["f1"], rows["c"]["by_hand"]) == (None, None)
    assert {note.label for note in library.take("c").annotated("body", "cut")} == {"grown"}
    lines = answer(*line, "--example", "a").stdout.splitlines()
    assert lines[0].split()[:3] == ["take", "cuts", "metres"]
    assert [line.split()[0] for line in lines[1:]] == ["b"]
