"""Requests from the command line: the same results as their short forms, and refusals in one line."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import answer, invoke

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import KinetographError
from kinetograph.formats.readings import write_readings
from kinetograph.sensing import preset, simulate
from made_walks import PATH, walked


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A library of walks, a path, and poses."""
    root = tmp_path_factory.mktemp("requests")
    walked(root)
    (root / "path.csv").write_text("t,x,z\n" + "".join(f"{t!r},{x!r},{z!r}\n" for t, x, z in PATH))
    left = kg.Library.open(root / "walks").take("left").motion()
    kg.save(left, root / "pose.bvh")
    write_readings(simulate(left, preset("wii"), np.random.default_rng(0)), root / "readings.csv")
    return root


def asked(folder: Path, tmp_path: Path, **document: object) -> Path:
    """A request in the folder."""
    (folder / "request.json").write_text(json.dumps({"library": "walks", **document}))
    return folder / "request.json"


def rendered(request: Path, tmp_path: Path) -> bytes:
    answer("render", request, "-o", tmp_path / "asked.bvh", "--force")
    return (tmp_path / "asked.bvh").read_bytes()


@pytest.mark.parametrize(
    ("document", "options"),
    [
        ({}, ()),
        ({"mirror": True, "smooth_time": 0.1}, ("--mirror", "--smooth-time", "0.1")),
        ({"keys": [{"pose": "take:left@2", "time": 1.5}]}, ("--key", "take:left@2; time=1.5")),
        ({"keys": [{"pose": "take:left@2", "time": [1, 2]}]}, ("--key", "take:left@2; time=1..2")),
        ({"keys": [{"pose": "pose.bvh@2", "along": 0.1}]}, ("--key", "FOLDER/pose.bvh@2; along=0.1")),
        (
            {
                "moves": [
                    {"start": 0.2, "stop": 1, "name": "left"},
                    {"start": 1.2, "stop": 2, "name": "left", "forbid": True},
                ]
            },
            ("--move", "0.2-1=left", "--move", "1.2-2=!left"),
        ),
        ({"moves": [{"start": 0, "stop": 3, "name": "right", "weight": 0.2}]}, ("--move", "0-3=right:0.2")),
        ({"pieces": [{"start": 1, "stop": 2, "take": "right"}]}, ("--pin", "right@1-2")),
        (
            {"layers": [{"parts": ["left arm", "right_hand"], "motion": "pose.bvh", "start": 0.5, "ease": 0.2}]},
            ("--layer", "left arm+right_hand=FOLDER/pose.bvh@0.5", "--layer-ease", "0.2"),
        ),
        (
            {"layers": [{"parts": ["arms"], "readings": "readings.csv", "hold": True}]},
            ("--layer", "arms=FOLDER/readings.csv", "--layer-hold"),
        ),
        ({"search": {"continuity": 0.3, "reuse": 0}}, ("--continuity", "0.3", "--reuse", "0")),
    ],
)
def test_perform_is_the_short_form_of_a_request(
    folder: Path, tmp_path: Path, document: dict[str, object], options: tuple[str, ...]
) -> None:
    short = tuple(text.replace("FOLDER", str(folder)) for text in options)
    answer("perform", folder / "path.csv", "-l", folder / "walks", "-o", tmp_path / "short.bvh", *short)
    for path in ("path.csv", PATH):
        made = rendered(asked(folder, tmp_path, path=path, **document), tmp_path)
        assert made == (tmp_path / "short.bvh").read_bytes()


def test_a_layer_goes_from_key_to_key_while_the_legs_follow_the_path(folder: Path, tmp_path: Path) -> None:
    keys = [{"pose": "take:left@1"}, {"pose": "take:left@2", "time": 1}]
    layers = [{"parts": ["arms"], "keys": keys, "start": 0.5, "ease": 0}]
    answer("render", asked(folder, tmp_path, path="path.csv"), "-o", tmp_path / "plain.bvh")
    request = asked(folder, tmp_path, path="path.csv", layers=layers)
    answer("render", request, "-o", tmp_path / "asked.bvh", "--report", tmp_path / "report.json")
    plain, made = (kg.load(tmp_path / f"{name}.bvh").motion() for name in ("plain", "asked"))
    take = kg.Library.open(folder / "walks").take("left").motion()
    elbow, knee = (made.skeleton.index(name) for name in ("left_elbow", "left_knee"))
    first, last = round(0.5 * made.fps), round(1.5 * made.fps)
    for frame, second in ((first, 1.0), (last, 2.0)):
        there = take.rotations[round(second * take.fps), elbow]
        assert np.degrees(rot.angle_between(made.rotations[frame, elbow], there)) < 1.0
    np.testing.assert_allclose(made.rotations[:, knee], plain.rotations[:, knee], atol=1e-3)
    report = json.loads((tmp_path / "report.json").read_text())
    assert [run["layer"] for run in report["joints"]["left_elbow"]] == [None, "keys", None]
    assert report["layers"][0]["pieces"][0]["take"] == "left"


@pytest.mark.parametrize(
    ("layer", "match"),
    [
        ({"parts": ["arms"]}, "the layer of arms: expected a motion, readings or keys, one of them, found none"),
        ({"parts": ["wings"], "motion": "pose.bvh"}, "expected parts among arms, .* found \\['wings'\\]"),
        ({"parts": ["arms"], "motion": "path.csv"}, "the layer of arms: expected a motion, found a path in path.csv"),
        ({"parts": ["arms"], "motion": "pose.bvh", "start": 90}, "begins at 90 s .* has none of it"),
    ],
)
def test_layers_that_cannot_be_are_refused(folder: Path, tmp_path: Path, layer: dict[str, object], match: str) -> None:
    with pytest.raises(KinetographError, match=match) as caught:
        answer("render", asked(folder, tmp_path, path="path.csv", layers=[layer]), "-o", tmp_path / "asked.bvh")
    assert "\n" not in str(caught.value)


def test_inbetween_is_the_short_form_of_keys_alone(folder: Path, tmp_path: Path) -> None:
    keys = [{"pose": "take:left@1"}, {"pose": "take:right@3", "time": 2}]
    (folder / "keys.json").write_text(json.dumps({"keys": keys}))
    answer("inbetween", folder / "keys.json", "-l", folder / "walks", "-o", tmp_path / "short.bvh")
    assert rendered(asked(folder, tmp_path, keys=keys), tmp_path) == (tmp_path / "short.bvh").read_bytes()


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({}, "the request asks for nothing: give it a path, a partner or keys"),
        ({"path": "path.csv", "partner": "pose.bvh"}, "a path or a partner, found both"),
        ({"path": "other.csv"}, "other.csv"),
        ({"path": [[0, 0, 0]]}, "two points or more"),
        ({"path": "path.csv", "keys": [{"pose": "take:left@2"}]}, "key 1: on a path a key has a time, or a place"),
        ({"path": "path.csv", "keys": [{"pose": "take:none@2", "time": 1}]}, "none"),
        ({"path": "path.csv", "moves": [{"start": 3, "stop": 2, "name": "left"}]}, "from a start to a later stop"),
        ({"path": "path.csv", "moves": [{"start": 3, "stop": 9, "name": "left"}]}, "9 s is outside the control"),
        ({"path": "path.csv", "moves": [{"start": 1, "stop": 2}]}, "a move has a name, or a first or last foot"),
        ({"path": "path.csv", "contacts": [{"part": "left_foot", "start": 2, "stop": 1}]}, "a contact runs from"),
        ({"path": "path.csv", "keys": [{"pose": "take:left@2", "time": 1, "weight": -1}]}, "a weight is 0 or more"),
        ({"keys": [{"pose": "take:left@2", "along": 1}]}, "a place along the path, and the request has no path"),
        ({"keys": [{"pose": "take:left@2"}], "moves": [{"start": 0, "stop": 1, "name": "left"}]}, "are in spans of"),
        ({"partner": "pose.bvh", "facing": 10}, "facing is for a drawn path"),
    ],
)
def test_what_cannot_be_asked_for_is_refused_in_one_line(
    folder: Path, tmp_path: Path, document: dict[str, object], says: str
) -> None:
    result = invoke("render", asked(folder, tmp_path, **document), "-o", tmp_path / "out.bvh")
    assert isinstance(result.exception, KinetographError)
    assert says in str(result.exception)
    assert "\n" not in str(result.exception)
    assert not (tmp_path / "out.bvh").exists()


@pytest.mark.parametrize("text", ["run", "4=run", "4-7", "4-7=run:x", "4-7=walk/up", "4-7=a/left/right/left"])
def test_a_move_that_cannot_be_read_is_refused(folder: Path, tmp_path: Path, text: str) -> None:
    files = (folder / "path.csv", "-l", folder / "walks", "-o", tmp_path / "out.bvh")
    result = invoke("perform", *files, "--move", text)
    assert "a move is start-stop=name in seconds" in str(result.exception)


def test_why_of_a_request_knows_its_keys_moves_and_layers(folder: Path, tmp_path: Path) -> None:
    document = {
        "path": "path.csv",
        "keys": [{"pose": "take:left@2.2", "time": 1.5, "weight": 50, "name": "lean"}],
        "moves": [{"start": 2.5, "stop": 3.5, "name": "right", "weight": 10}],
        "layers": [
            {"parts": ["left arm"], "keys": [{"pose": "take:left@1"}, {"pose": "take:left@3", "time": 2}], "start": 0.5}
        ],
    }
    request = asked(folder, tmp_path, **document)
    written = ("-o", tmp_path / "asked.bvh", "--why", 1.5, "--why", 3, "--report", tmp_path / "report.json")
    summary = json.loads(answer("render", request, *written, "--json").stdout)
    at_key, in_move = summary["why"]
    assert json.loads((tmp_path / "report.json").read_text())["why"] == summary["why"]
    for why in (at_key, in_move):
        (chosen,) = (piece for piece in why["pieces"] if piece["chosen"])
        assert chosen["total"] == pytest.approx(summary["cost"], rel=1e-4)
    assert max(piece["terms"]["keys"] for piece in at_key["pieces"]) > 0.01
    assert {piece["terms"]["rules"] for piece in at_key["pieces"]} == {0.0}
    assert "called 'right' from 2.5 to 3.5 s" in in_move["without"][0]["constraint"]
    assert "the demand for lean" in {each["constraint"] for each in at_key["without"]}
    assert [layer["joints"] for layer in at_key["layers"]] == [["left_shoulder", "left_elbow", "left_hand"]]
    assert in_move["layers"] == []
    said = answer("render", request, "-o", tmp_path / "said.bvh", "--why", 1.2).stdout
    assert "layer keys drives left_shoulder, left_elbow, left_hand, 0.53 to 2.47 s, from left at 1.70 s" in said


def test_why_between_keys_names_what_plays_there(folder: Path, tmp_path: Path) -> None:
    keys = [{"pose": "take:left@1"}, {"pose": "take:left@2.5", "time": 1.5}, {"pose": "take:left@4", "time": 3}]
    request = asked(folder, tmp_path, keys=keys)
    summary = json.loads(answer("render", request, "-o", tmp_path / "asked.bvh", "--why", 2, "--json").stdout)
    (why,) = summary["why"]
    assert why["span"] == why["keys"] == [1.5, 3.0]
    assert {piece["take"] for piece in why["recordings"]} == {"left"}
    said = answer("render", request, "-o", tmp_path / "said.bvh", "--why", 2).stdout
    assert "at 2 s the timed search plays, from 1.50 to 3.00 s, to meet the keys at 1.50, 3.00 s" in " ".join(
        said.split()
    )


def test_a_moment_outside_a_request_is_refused_before_the_work(folder: Path, tmp_path: Path) -> None:
    for document, says in (
        ({"path": "path.csv"}, "--why: the control lasts 4.00 s, found a time of 7 s"),
        ({"keys": [{"pose": "take:left@1"}, {"pose": "take:left@2", "time": 1}]}, "the result lasts 1.00 s"),
    ):
        result = invoke("render", asked(folder, tmp_path, **document), "-o", tmp_path / "out.bvh", "--why", 7)
        assert says in str(result.exception)
        assert not (tmp_path / "out.bvh").exists()


def test_a_move_by_an_example_asks_for_what_is_like_it(folder: Path, tmp_path: Path) -> None:
    """The takes differ in their bends only: what is like a left bend is the left bend, or the right one's mirror."""
    path = [[t, 0, t] for t, _, _ in PATH]
    for example in ("take:left@1-3", "pose.bvh@1-3"):
        for mirror, forbid in ((False, False), (True, False), (False, True)):
            move = {"start": 1, "stop": 3, "like": example, "within": 0.02, "forbid": forbid}
            request = asked(folder, tmp_path, path=path, moves=[move], mirror=mirror)
            report = tmp_path / "report.json"
            answer("render", request, "-o", tmp_path / "asked.bvh", "--report", report, "--force")
            pieces = json.loads(report.read_text())["pieces"]
            inside = {(p["take"], p["mirrored"]) for p in pieces if p["start"] < 3 - 1e-6 and p["stop"] > 1 + 1e-6}
            wanted = {("left", False), ("right", True)}
            assert inside
            assert not inside & wanted if forbid else inside <= wanted


@pytest.mark.parametrize(
    ("move", "says"),
    [
        ({"like": "take:left@1-3", "name": "left"}, "a move has a name or an example"),
        ({"name": "left", "within": 0.2}, "within is of a move with an example"),
        ({"like": "take:left@1"}, "an example is FILE@2-4 or take:NAME@2-4"),
        ({"like": "take:left@5-9"}, "expected a part of the 6.00 s of 'left'"),
        ({"like": "take:left@1-3", "within": 0}, "within more than 0 m of it, found 0"),
        ({"like": "other.bvh@1-3"}, "other.bvh"),
    ],
)
def test_examples_that_are_none_are_refused(folder: Path, tmp_path: Path, move: dict[str, object], says: str) -> None:
    request = asked(folder, tmp_path, path="path.csv", moves=[{"start": 1, "stop": 2, **move}])
    result = invoke("render", request, "-o", tmp_path / "out.bvh")
    assert isinstance(result.exception, KinetographError)
    assert says in str(result.exception)
    assert "\n" not in str(result.exception)


def test_where_nothing_is_like_an_example_the_nearest_is_named(folder: Path, tmp_path: Path) -> None:
    left = kg.load(folder / "pose.bvh").motion()
    rotations = left.rotations.copy()
    rotations[:, left.skeleton.index("left_shoulder")] = rot.about("z", 2.0)
    kg.save(replace(left, rotations=rotations), folder / "raised.bvh")
    files = (folder / "path.csv", "-l", folder / "walks", "-o", tmp_path / "out.bvh")
    result = invoke("perform", *files, "--move", f"1-2=like:{folder}/raised.bvh@1-2; within=0.1")
    found = re.search(
        r"nothing in the library is within 0\.10 m of .*raised\.bvh@1-2; the nearest is (\w+) from .* s, ([\d.]+) m: "
        r"ask for what is within ([\d.]+) m",
        str(result.exception),
    )
    assert found is not None
    assert float(found[2]) > 0.1
    answer("perform", *files, "--move", f"1-2=like:{folder}/raised.bvh@1-2; within={float(found[3]) + 0.05:.2f}")


def test_an_example_of_the_command_line_is_that_of_the_document(folder: Path, tmp_path: Path) -> None:
    move = {"start": 1, "stop": 3, "like": "take:left@1-3", "within": 0.05, "weight": 0.5, "first": "left"}
    made = rendered(asked(folder, tmp_path, path="path.csv", moves=[move]), tmp_path)
    files = (folder / "path.csv", "-l", folder / "walks", "-o", tmp_path / "short.bvh")
    answer("perform", *files, "--move", "1-3=like:take:left@1-3/left:0.5; within=0.05")
    assert made == (tmp_path / "short.bvh").read_bytes()


def test_alternatives_of_a_request_all_meet_its_keys(folder: Path, tmp_path: Path) -> None:
    keys = [{"pose": "take:left@2.2", "time": 1.5}]
    request = asked(folder, tmp_path, path="path.csv", keys=keys)
    summary = json.loads(answer("render", request, "-o", tmp_path / "a.bvh", "--alternatives", 3, "--json").stdout)
    assert [Path(path).name for path in summary["wrote"]] == ["a.bvh", "a_2.bvh", "a_3.bvh"]
    assert summary["cost"] <= 1.01 * min(summary["cost_2"], summary["cost_3"])  # what is used again costs a little
    files = (folder / "path.csv", "-l", folder / "walks", "-o", tmp_path / "b.bvh")
    answer("perform", *files, "--key", "take:left@2.2; time=1.5", "--alternatives", 3)
    elbow = kg.load(tmp_path / "a.bvh").motion().skeleton.index("left_elbow")
    take = kg.Library.open(folder / "walks").take("left").motion()
    made = [kg.load(tmp_path / f"a{number}.bvh").motion() for number in ("", "_2", "_3")]
    for motion, number in zip(made, ("", "_2", "_3"), strict=True):
        assert rot.angle_between(motion.rotations[45, elbow], take.rotations[66, elbow]) < 1e-3
        assert (tmp_path / f"a{number}.bvh").read_bytes() == (tmp_path / f"b{number}.bvh").read_bytes()
    assert not np.allclose(made[0].rotations, made[1].rotations)
    keys = [{"pose": "take:left@1"}, {"pose": "take:right@3"}]
    (folder / "free.json").write_text(json.dumps({"keys": keys}))
    between = asked(folder, tmp_path, keys=keys, mirror=True)
    summary = json.loads(answer("render", between, "-o", tmp_path / "c.bvh", "--alternatives", 3, "--json").stdout)
    files = (folder / "free.json", "-l", folder / "walks", "-o", tmp_path / "d.bvh", "--mirror", "--alternatives", 3)
    answer("inbetween", *files)
    wrote = sorted(path.name for path in tmp_path.glob("d*.bvh"))
    assert [Path(path).name.replace("c", "d") for path in summary["wrote"]] == wrote


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_folder_of_requests_is_made_as_each_of_them_is(folder: Path, tmp_path: Path, jobs: int) -> None:
    orders = tmp_path / "orders"
    orders.mkdir()
    documents: dict[str, dict[str, object]] = {
        "a": {"path": PATH},
        "b": {"path": PATH, "keys": [{"pose": "take:left@2.2", "time": 1.5}]},
        "bad": {"path": PATH, "keys": [{"pose": "take:nobody@2", "time": 1.5}]},
        "c": {"path": PATH, "moves": [{"start": 1, "stop": 2, "name": "right"}]},
    }
    for name, document in documents.items():
        (orders / f"{name}.json").write_text(json.dumps({"library": str(folder / "walks"), **document}))
    (orders / "broken.json").write_text("{")
    (orders / "project.json").write_text('{"mode": "walk"}')
    result = invoke("render", orders, "-o", tmp_path / "made", "--jobs", jobs, "--json")
    assert result.exit_code == 1
    rows = {row["request"]: row for row in json.loads(result.stdout)["requests"]}
    assert sorted(rows) == ["a.json", "b.json", "bad.json", "broken.json", "c.json"]
    assert "nobody" in rows["bad.json"]["error"]
    assert "expected a request" in rows["broken.json"]["error"]
    for name in ("a", "b", "c"):
        answer("render", orders / f"{name}.json", "-o", tmp_path / "alone.bvh", "--force")
        assert (tmp_path / "alone.bvh").read_bytes() == (tmp_path / "made" / f"{name}.bvh").read_bytes()
    assert sorted(path.name for path in (tmp_path / "made").iterdir()) == ["a.bvh", "b.bvh", "c.bvh"]


def test_what_a_folder_cannot_be_asked_for_is_refused(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    asked(folder, tmp_path, path="path.csv")
    for path, more, says in (
        (tmp_path / "empty", ("-o", tmp_path / "made"), "empty: expected requests, .json, found none"),
        (folder, (), "written to one folder: -o made"),
        (folder, ("-o", tmp_path / "made", "--why", 1), "are of one request, found a folder"),
        (folder, ("-o", tmp_path / "made", "--to", ".xyz"), "xyz"),
    ):
        assert says in str(invoke("render", path, *more).exception)
        assert not (tmp_path / "made").exists()
