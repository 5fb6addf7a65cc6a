"""Requests of other programs: every line is answered, and nothing that a line says ends the process."""

from __future__ import annotations

import json
import queue
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from kinetograph.errors import RequestError
from kinetograph.formats import KeySources, ReadOptions, Request, load
from kinetograph.formats.deepmimic import skeleton as deepmimic
from kinetograph.formats.readings import write_readings
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.motion import Motion, cut, heading_at, place
from kinetograph.pipeline import read_take, render_request
from kinetograph.post import retarget
from kinetograph.sensing import preset, simulate
from kinetograph.service import METHODS, PROTOCOL, serve, serving
from kinetograph.service.bodies import Body, Moving, body_of, motion_of, skeleton_of, written
from kinetograph.service.job import Job
from kinetograph.service.listening import Pose, Preview
from kinetograph.take import Annotation, Take
from walkers import stick_figure, walk


def asked(*lines: object) -> list[dict[str, Any]]:
    """The answers to some lines, of which those that are no text are requests."""
    answers: list[str] = []
    serve([line if isinstance(line, str) else json.dumps(line) for line in lines], answers.append)
    return [json.loads(answer) for answer in answers]


def ended(answers: list[dict[str, Any]]) -> dict[Any, dict[str, Any]]:
    """The ends of requests, by id."""
    return {answer["id"]: answer for answer in answers if "result" in answer or "error" in answer}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("service") / "walks"
    library = Library.create(folder)
    cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(0, 17) / 2)
    for name, turn in (("straight", 0.0), ("left", 0.4), ("right", -0.4)):
        library.add(Take(name, {"motion": walk(8.0, turn_rate=turn)}, cuts))
    return folder


def path(seconds: float = 4.0, rate: float = 24.0) -> list[list[float]]:
    times = np.arange(round(seconds * rate) + 1) / rate
    return np.stack([times, 0.0 * times, times], axis=1).tolist()  # type: ignore[no-any-return]


def test_hello_says_the_protocol_and_what_may_be_asked() -> None:
    (answer,) = asked({"id": 1, "method": "hello", "params": {"protocol": PROTOCOL}})
    assert answer["result"]["protocol"] == PROTOCOL
    assert answer["result"]["methods"] == sorted(METHODS)


def test_another_protocol_is_refused_in_words() -> None:
    (answer,) = asked({"id": 1, "method": "hello", "params": {"protocol": PROTOCOL + 1}})
    assert f"speaks protocol {PROTOCOL}, the client {PROTOCOL + 1}" in answer["error"]["message"]


@pytest.mark.parametrize(
    "line",
    [
        "rubbish",
        "[]",
        '{"id": 3}',
        '{"id": 3, "method": 7}',
        '{"id": 3, "method": "hello", "params": []}',
        "[" * 20_000,
        '{"id": 3, "method": "walk", "more": 1}',
        "\udce4",
    ],
)
def test_a_line_that_is_no_request_is_answered(line: str) -> None:
    answers = asked(line, {"id": 4, "method": "hello", "params": {"protocol": PROTOCOL}})
    assert [sorted(answer) for answer in answers] == [["error", "id"], ["id", "result"]]
    assert answers[0]["id"] == (3 if line.startswith('{"id": 3') else None)


def test_an_unknown_method_names_those_that_there_are() -> None:
    (answer,) = asked({"id": "a", "method": "dance"})
    assert answer["id"] == "a"
    assert "unknown method 'dance'; expected add, alike, drop" in answer["error"]["message"]


def test_parameters_are_checked_by_name(library: Path) -> None:
    params = {"recordings": {"library": str(library)}, "path": path(), "folder": ".", "speed": 1}
    (answer,) = asked({"id": 1, "method": "walk", "params": params})
    assert answer["error"]["kind"] == "RequestError"
    assert "unknown field `speed`" in answer["error"]["message"]


def test_a_request_that_crashes_does_not_end_the_others(monkeypatch: pytest.MonkeyPatch, library: Path) -> None:
    def crash(params: object, job: Job) -> None:
        raise {"look": KeyError("lost"), "roles": MemoryError(), "add": RecursionError()}[current.pop(0)]  # type: ignore[misc]

    class Nothing(msgspec.Struct):
        pass

    current = ["look", "roles", "add"]
    monkeypatch.setattr(serving, "method", lambda name: (Nothing, crash))
    answers = ended(asked(*({"id": number, "method": name} for number, name in enumerate(("look", "roles", "add")))))
    assert "an error in kinetograph itself, KeyError: 'lost'" in answers[0]["error"]["message"]
    assert "not enough memory" in answers[1]["error"]["message"]
    assert "RecursionError" in answers[2]["error"]["message"]


def test_a_request_is_cancelled_while_it_works_and_while_it_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    class Nothing(msgspec.Struct):
        pass

    started, answers = threading.Event(), queue.Queue[dict[str, Any]]()

    def endless(params: object, job: Job) -> None:
        started.set()
        while True:
            job.progress(1, 10)
            threading.Event().wait(0.01)

    monkeypatch.setattr(serving, "method", lambda name: (Nothing, endless))

    def lines() -> Iterator[str]:
        yield json.dumps({"id": 1, "method": "look"})
        yield json.dumps({"id": 2, "method": "look"})
        started.wait(10)
        yield json.dumps({"id": 3, "method": "cancel", "params": {"id": 2}})
        yield json.dumps({"id": 4, "method": "cancel", "params": {"id": 1}})
        yield json.dumps({"id": 5, "method": "cancel", "params": {"id": 77}})

    serve(lines(), lambda line: answers.put(json.loads(line)))
    ends = ended(list(answers.queue))
    assert [ends[number]["error"]["kind"] for number in (1, 2)] == ["Cancelled", "Cancelled"]
    assert [ends[number]["result"]["cancelled"] for number in (3, 4, 5)] == [True, True, False]


def test_a_client_that_has_gone_ends_the_loop() -> None:
    def gone(line: str) -> None:
        raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        serve([json.dumps({"id": 1, "method": "look", "params": {"library": "nowhere"}})], gone)


def test_a_walk_is_at_the_rate_and_along_the_path_that_are_asked_for(library: Path, tmp_path: Path) -> None:
    params = {"recordings": {"library": str(library)}, "path": path(), "folder": str(tmp_path), "fps": 24.0}
    made = ended(asked({"id": 1, "method": "walk", "params": params}))[1]["result"]
    arrays = np.load(made["motion"]["arrays"])
    assert len(arrays["translation"]) == 97
    assert arrays["rotations"].shape == (97, 15, 4)
    assert np.abs(arrays["translation"][:, [0, 2]] - np.array(path())[:, 1:]).max() < 0.05
    assert {source["take"] for source in made["sources"]} <= {"straight", "left", "right"}
    assert made["sources"][0]["start"] == 0.0


def test_hips_are_on_the_path_at_every_frame(library: Path, tmp_path: Path) -> None:
    wanted = path(4.02, 60.0)
    params = {"recordings": {"library": str(library)}, "path": wanted, "folder": str(tmp_path), "onto_path": 0.0}
    for fps in (24.0, 60.0):
        made = ended(asked({"id": 1, "method": "walk", "params": {**params, "fps": fps}}))[1]["result"]
        translation = np.load(made["motion"]["arrays"])["translation"]
        times = np.arange(len(translation)) / fps
        assert np.abs(translation[:, 2] - np.minimum(times, 4.0 + 1 / 60)).max() < 1e-3
        assert np.abs(translation[:, 0]).max() < 1e-3


def test_a_longer_leg_takes_longer_steps_along_the_same_path(library: Path, tmp_path: Path) -> None:
    long = msgspec.to_builtins(body_of(stick_figure(1.5)))
    params = {"recordings": {"library": str(library)}, "path": path(), "folder": str(tmp_path), "body": long}
    made = ended(asked({"id": 1, "method": "walk", "params": params}))[1]["result"]
    translation = np.load(made["motion"]["arrays"])["translation"]
    assert translation[-1, 2] == pytest.approx(4.0, abs=0.05)
    assert translation[:, 1].mean() == pytest.approx(1.5 * 0.86, abs=0.03)


def test_keys_are_met_exactly_at_whole_frames(library: Path, tmp_path: Path) -> None:
    recording = walk(8.0, turn_rate=0.4)
    motion = msgspec.to_builtins(written(recording, str(tmp_path)))
    keys = [{"second": 0.5, "time": 0.0}, {"second": 3.5, "time": 73 / 24}]
    params = {
        "recordings": {"library": str(library)},
        "motion": motion,
        "keys": keys,
        "folder": str(tmp_path),
        "fps": 24,
    }
    made = ended(asked({"id": 1, "method": "inbetween", "params": params}))[1]["result"]["made"][0]
    result = motion_of(msgspec.convert(made["motion"], type(written(recording, str(tmp_path)))))
    assert len(result) == 74
    for frame, source in ((0, 15), (73, 105)):
        apart = joint_positions(result)[frame] - joint_positions(recording)[source]
        assert np.abs(apart).max() < 1e-6


def test_a_library_is_added_to_and_looked_into(tmp_path: Path) -> None:
    motion = msgspec.to_builtins(written(walk(2.0), str(tmp_path), "my walk"))
    add = {"library": str(tmp_path / "new"), "motions": [motion]}
    look = {"library": str(tmp_path / "new"), "words": "MY"}
    drop = {"library": str(tmp_path / "new"), "take": "my walk", "folder": str(tmp_path), "start": 0.5, "stop": 1.0}
    ends = ended(
        asked(
            {"id": 1, "method": "add", "params": add},
            {"id": 2, "method": "look", "params": look},
            {"id": 3, "method": "add", "params": add},
            {"id": 4, "method": "drop", "params": drop},
        )
    )
    assert ends[1]["result"]["names"] == ["my walk"]
    assert ends[2]["result"]["rows"][0]["seconds"] == pytest.approx(2.0)
    assert "my walk" in ends[3]["error"]["message"]
    assert len(np.load(ends[4]["result"]["motion"]["arrays"])["translation"]) == 16
    assert ends[4]["result"]["sources"][0]["source_start"] == 0.5


def test_roles_are_found_and_can_be_named_or_taken_away() -> None:
    body = body_of(stick_figure())
    given = msgspec.structs.replace(body, roles={"left_toe": "", "head": "left_hand"})
    params = {"body": msgspec.to_builtins(given)}
    found = ended(asked({"id": 1, "method": "roles", "params": params}))[1]["result"]
    assert found["roles"]["left_knee"] == "left_knee"
    assert found["roles"]["head"] == "left_hand"
    assert "left_toe" in found["missing"]


def test_a_body_comes_back_as_it_was() -> None:
    body = body_of(stick_figure())
    again = body_of(skeleton_of(msgspec.json.decode(msgspec.json.encode(body), type=Body)))
    assert (again.names, again.parents, again.offsets) == (body.names, body.parents, body.offsets)


def test_arrays_that_are_not_there_are_named(tmp_path: Path) -> None:
    moving = msgspec.structs.replace(written(walk(1.0), str(tmp_path)), arrays=str(tmp_path / "gone.npz"))
    with pytest.raises(RequestError, match=r"gone\.npz: expected a \.npz file"):
        motion_of(moving)


def sensed(clips: Path, folder: Path) -> tuple[Path, str]:
    """A library, and a source that replays what sensors would say of one of its takes."""
    library = Library.create(folder / "sensed")
    for name in ("jump", "walk"):
        library.add(read_take(clips / f"humanoid3d_{name}.txt", ReadOptions())[0])
    jump = load(clips / "humanoid3d_jump.txt").motion()
    write_readings(simulate(jump, preset("ideal"), np.random.default_rng(0)), folder / "r.csv")
    return folder / "sensed", f"replay:{folder}/r.csv"


def listening(library: Path, source: str, **more: object) -> dict[str, Any]:
    params = {"recordings": {"library": str(library)}, "sources": [source], "layout": "ideal", **more}
    return {"id": 1, "method": "live", "params": params}


def live_answers(request: dict[str, Any], stop: Callable[[list[dict[str, Any]]], bool]) -> list[dict[str, Any]]:
    """What a live session answers; it is cancelled once its answers so far are enough, or ends by itself."""
    answers: list[dict[str, Any]] = []

    def lines() -> Iterator[str]:
        yield json.dumps(request)
        end = time.monotonic() + 120
        while time.monotonic() < end and not ended(answers):
            if stop(answers):
                yield json.dumps({"method": "cancel", "params": {"id": 1}})
                end = min(end, time.monotonic() + 5)
            time.sleep(0.01)

    serve(lines(), lambda line: answers.append(json.loads(line)))
    return answers


def shown(answers: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [answer["event"] for answer in answers if "root" in answer.get("event", {})]


def test_a_live_session_sends_its_body_and_then_poses_at_the_rate(clips_folder: Path, tmp_path: Path) -> None:
    library, source = sensed(clips_folder, tmp_path)
    answers = live_answers(listening(library, source, fps=20.0), lambda answers: False)
    (body,) = [answer["event"]["body"] for answer in answers if "body" in answer.get("event", {})]
    poses, result = shown(answers), ended(answers)[1]["result"]
    assert len(poses) == result["sent"] <= result["frames"] / 3 + 1  # 20 of 60 poses per second, or fewer
    assert np.array([pose["rotations"] for pose in poses]).shape == (len(poses), len(body["names"]), 4)
    assert np.diff([pose["second"] for pose in poses]).min() > 0.04
    assert np.allclose(np.linalg.norm(poses[-1]["rotations"], axis=-1), 1.0, atol=1e-5)
    assert all("worn" not in pose for pose in poses)
    assert sum(result["rows"].values()) > 100


def test_a_live_session_ends_when_it_is_cancelled_and_when_no_more_lines_come(
    clips_folder: Path, tmp_path: Path
) -> None:
    library, source = sensed(clips_folder, tmp_path)
    wanted = listening(library, f"{source}@0.2")  # for half a minute or so
    answers = live_answers(wanted, lambda answers: len(shown(answers)) > 3)
    assert ended(answers)[1]["error"]["kind"] == "Cancelled"
    began = time.monotonic()
    assert ended(asked(wanted))[1]["error"]["kind"] == "Cancelled"
    assert time.monotonic() - began < 2


def test_live_poses_are_shown_on_the_body_of_a_client_too(clips_folder: Path, tmp_path: Path) -> None:
    library, source = sensed(clips_folder, tmp_path)
    long = msgspec.to_builtins(body_of(stick_figure(1.5)))
    answers = live_answers(listening(library, source, body=long, fps=10.0), lambda answers: False)
    pose = shown(answers)[-1]
    assert np.array(pose["worn"]["rotations"]).shape == (15, 4)
    assert pose["worn"]["root"][1] > 1.2 * pose["root"][1]
    expected = retarget(
        Motion(deepmimic(), np.array([pose["root"]]), np.array([pose["rotations"]]), 30.0),
        skeleton_of(body_of(stick_figure(1.5))),
    ).motion
    assert np.allclose(pose["worn"]["root"], expected.translation[0], atol=1e-4)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"sources": ["telepathy://"]}, "expected a source"),
        ({"sources": []}, "expected a source of readings"),
        ({"sources": ["replay:nowhere.csv"]}, "nowhere.csv"),
        ({"fps": 0.0}, "1 to 240 poses per second"),
        ({"layout": "phone"}, "was heard from"),
    ],
)
def test_a_live_session_that_cannot_be_says_why(
    clips_folder: Path, tmp_path: Path, more: dict[str, Any], words: str
) -> None:
    library, source = sensed(clips_folder, tmp_path)
    answers = live_answers(listening(library, f"{source}@8", **more), lambda answers: False)
    assert words in ended(answers)[1]["error"]["message"]


def test_of_poses_that_cannot_be_sent_in_time_the_newest_is() -> None:
    sent: list[Pose] = []
    gate = threading.Event()

    def slow(pose: object) -> None:
        assert isinstance(pose, Pose)
        sent.append(pose)
        gate.wait(10)

    preview = Preview(slow, 30.0)
    motion = walk(2.0)
    for frame in range(30):
        preview.send(cut(motion, frame, frame + 1), frame / 30.0)
        while not sent:
            time.sleep(0.001)
    gate.set()
    preview.close()
    assert [pose.second for pose in sent] == [0.0, pytest.approx(29 / 30)]


def test_a_client_that_has_gone_ends_a_live_session() -> None:
    def gone(pose: object) -> None:
        raise BrokenPipeError

    preview = Preview(gone, 30.0)
    preview.send(cut(walk(2.0), 0, 1), 0.0)
    preview.close()
    assert isinstance(preview.broken, BrokenPipeError)


def rendered(library: Path, folder: Path, document: dict[str, Any], **more: Any) -> dict[str, Any]:
    """The end of a request for a document."""
    params = {"recordings": {"library": str(library)}, "request": document, "folder": str(folder), **more}
    return ended(asked({"id": 1, "method": "render", "params": params}))[1]


def motion_in(answer: dict[str, Any]) -> Motion:
    return motion_of(msgspec.convert(answer["result"]["motion"], Moving))


def test_a_document_is_rendered_as_its_file_is(library: Path, tmp_path: Path) -> None:
    document = {
        "path": path(),
        "keys": [{"pose": "take:left@2", "time": 1.5}],
        "moves": [{"start": 2.5, "stop": 3.5, "name": "straight"}],
        "contacts": [{"part": "left_foot", "start": 3.2, "stop": 3.4}],
        "layers": [{"parts": ["left arm"], "motion": "wave", "start": 0.5}],
    }
    wave = written(cut(walk(8.0), 0, 60), str(tmp_path), "wave")
    made = rendered(library, tmp_path, document, motions=[msgspec.to_builtins(wave)])
    opened = Library.open(library)
    sources = KeySources(opened, motions={"wave": motion_of(wave)})
    alone = render_request(msgspec.convert(document, Request), opened, sources).synthesis
    mine = motion_in(made)
    assert np.allclose(mine.rotations, alone.motion.rotations, rtol=0, atol=1e-12)
    assert made["result"]["met"] == [1.5]
    assert made["result"]["cost"] == alone.cost
    assert made["result"]["costs"] == dict(alone.costs)
    assert [(each["name"], each["joints"][0]) for each in made["result"]["layers"]] == [("wave", "left_shoulder")]


@pytest.mark.parametrize(("scale", "named"), [(1.0, True), (1.4, True), (1.0, False)])
def test_poses_of_an_armature_are_met_on_its_own_body_along_its_own_path(
    library: Path, tmp_path: Path, scale: float, named: bool
) -> None:
    """Lengths are those of the client's world: the key is 1.5 m along its path, and beside it."""
    body = stick_figure(scale)
    posed = replace(walk(8.0, turn_rate=0.4), skeleton=body)
    keys = [{"pose": "armature@2", "along": 1.5, "position": [0.2, 1.5], "heading": 20.0}]
    moving = written(posed, str(tmp_path), "armature")
    made = rendered(
        library,
        tmp_path,
        {"path": path(), "keys": keys},
        motions=[msgspec.to_builtins(moving)],
        fps=24.0,
        **({"body": msgspec.to_builtins(moving.body)} if named else {}),
    )
    motion, frame = motion_in(made), round(made["result"]["met"][0] * 24.0)
    root = motion.translation[frame, [0, 2]]
    assert np.allclose(root, [0.2, 1.5], atol=1e-3)
    assert heading_at(motion, frame) == pytest.approx(np.radians(20.0), abs=1e-3)
    pose, wanted = (
        joint_positions(place(cut(each, at, at + 1), -heading_at(each, at), np.zeros(3)))[0]
        for each, at in ((motion, frame), (posed, 60))
    )
    apart = pose - wanted
    assert np.abs(apart - apart[0] * [1, 0, 1]).max() < 1e-3
    assert np.abs(motion.translation[-1, [0, 2]] - path()[-1][1:]).max() < 0.1


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({}, "asks for nothing"),
        ({"path": [[0, 0, 0], [1, 0, 1]], "speed": 1}, "unknown field `speed`"),
        ({"path": "nowhere.csv"}, "nowhere.csv"),
        ({"path": [[0, 0, 0], [2, 0, 2]], "keys": [{"pose": "armature@1", "time": 1}]}, "armature"),
        ({"path": [[0, 0, 0], [2, 0, 2]], "moves": [{"start": 1, "stop": 2, "name": "tango"}]}, "'tango'"),
    ],
)
def test_a_document_that_cannot_be_made_says_why(
    library: Path, tmp_path: Path, document: dict[str, Any], words: str
) -> None:
    assert words in rendered(library, tmp_path, document)["error"]["message"]
