"""The studio's sensors: the same motions as the command line's, live runs of replays, and calibration in words."""

from __future__ import annotations

import asyncio
import json
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import KinetographError, RequestError
from kinetograph.evaluation.sensor_scores import pose_errors
from kinetograph.formats.gltf import read as read_glb
from kinetograph.formats.readings import read_layout, write_readings
from kinetograph.library import Library
from kinetograph.methods.sensor import SensorControl
from kinetograph.motion import Motion, resample
from kinetograph.pipeline import read_rows
from kinetograph.sensing import Layout, Readings, preset, select_rows, simulate
from kinetograph.studio.messages import (
    Calibrate,
    Calibrated,
    CalibrationStep,
    CallSensors,
    Heard,
    JointUncertainty,
    Listen,
    LiveEnded,
    Message,
    PhoneLink,
    Said,
)
from kinetograph.studio.project import Project, Sensors
from kinetograph.studio.room import FILES, Room
from kinetograph.studio.sensors.lanes import MOST, joints_alike, thinned
from kinetograph.studio.sensors.live import is_live, source_of
from kinetograph.studio.sensors.making import ANSWERS, RUNS, make
from kinetograph.take import Take
from walkers import walk


def swinging(motion: Motion) -> Motion:
    """The walk with arms that swing against the legs, elbows a little bent."""
    phase = 2 * np.pi * np.arange(len(motion)) / motion.fps
    rotations = motion.rotations.copy()
    for side, shift in (("left", 0.0), ("right", np.pi)):
        swing = np.sin(phase + shift)
        rotations[:, motion.skeleton.index(f"{side}_shoulder")] = rot.about("x", 0.5 * swing - 0.3)
        rotations[:, motion.skeleton.index(f"{side}_elbow")] = rot.about("x", -0.4 - 0.3 * swing)
    return replace(motion, rotations=rotations)


WALKS = {"slow": 0.8, "brisk": 1.2, "held": 1.0}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("studio")
    library = Library.create(made / "walks")
    for name, speed in WALKS.items():
        library.add(Take(name, {"motion": swinging(walk(4.0, speed=speed, turn_rate=0.3 * (speed - 1.0)))}))
    (made / FILES).mkdir()
    write_readings(worn(), made / FILES / "worn.csv")
    return made


def worn() -> Readings:
    return simulate(swinging(walk(3.0, speed=1.1)), preset("wii"), np.random.default_rng(3))


def project(**section: Any) -> Project:
    return Project(mode="sensors", libraries={"walks": "walks"}, sensors=Sensors(**section))


def nothing(done: float, total: float) -> None:
    assert 0 <= done <= total


def test_nothing_is_made_without_readings(folder: Path) -> None:
    assert make(project(), Room(folder), nothing) is None


def test_a_file_gives_what_the_command_gives(folder: Path) -> None:
    made = make(project(readings="worn.csv"), Room(folder), nothing)
    assert made is not None
    rows, _ = read_rows(folder / FILES / "worn.csv")
    expected = SensorControl(layout=preset("wii")).fit(Library.open(folder / "walks")).synthesize(rows)
    np.testing.assert_array_equal(made.synthesis.motion.rotations, expected.motion.rotations)
    np.testing.assert_array_equal(made.synthesis.motion.translation, expected.motion.translation)
    assert made.synthesis.warnings == expected.warnings
    assert made.others == {}
    assert [figure.name for figure in made.figures] == ["uncertainty", "missing readings"]
    uncertainty = next(lane for lane in made.lanes if lane.role == "uncertainty")
    np.testing.assert_allclose(uncertainty.values, np.degrees(expected.uncertainty).mean(axis=1), atol=0.006)


def test_readings_simulated_on_a_take_are_compared_with_it(folder: Path) -> None:
    made = make(project(readings="take:held"), Room(folder), nothing)
    assert made is not None
    library = Library.open(folder / "walks")
    recorded = library.take("held").motion()
    expected = SensorControl(layout=preset("wii")).fit(library, exclude=("held",)).synthesize(
        simulate(recorded, preset("wii"))
    )  # fmt: skip
    np.testing.assert_array_equal(made.synthesis.motion.rotations, expected.motion.rotations)
    assert "held" not in {piece.take for piece in made.synthesis.pieces}
    truth = made.others["truth"]
    np.testing.assert_allclose(truth.translation[0, [0, 2]], expected.motion.translation[0, [0, 2]], atol=1e-9)
    assert rot.heading(truth.rotations[0, 0]) == pytest.approx(rot.heading(expected.motion.rotations[0, 0]))
    # a person is placed elsewhere, not changed
    np.testing.assert_allclose(truth.rotations[:, 1:], recorded.rotations[:, 1:], atol=1e-12)
    frames = min(len(expected.motion), len(resample(recorded, 60.0)))
    errors = pose_errors(expected.motion.rotations[:frames], resample(recorded, 60.0).rotations[:frames])
    lane = next(lane for lane in made.lanes if lane.role == "error")
    np.testing.assert_allclose(lane.values[:frames], errors.mean(axis=1), atol=0.006)
    assert made.figures[0].value == f"{errors.mean():.1f}°"


def test_each_sensor_has_a_lane_with_its_force_and_its_gaps(folder: Path, tmp_path: Path) -> None:
    rows = worn()
    silent = (rows.names.index("left_shank") == rows.sensors) & (rows.times > 1.0) & (rows.times < 2.0)
    room = Room(tmp_path)
    (tmp_path / FILES).mkdir()
    (tmp_path / "walks").symlink_to(folder / "walks")
    write_readings(select_rows(rows, ~silent), tmp_path / FILES / "gap.csv")
    made = make(project(readings="gap.csv"), room, nothing)
    assert made is not None
    lanes = {lane.name: lane for lane in made.lanes if lane.role == "readings"}
    assert list(lanes) == [name.replace("_", " ") for name in preset("wii").names]
    (gap,) = lanes["left shank"].spans
    assert gap.start == pytest.approx(1.0, abs=0.3)
    assert gap.stop == pytest.approx(2.0, abs=0.3)
    assert not lanes["right shank"].spans
    assert 7 < np.median(lanes["right shank"].values) < 13
    assert np.isfinite(lanes["left shank"].values).all()


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ({"readings": "nowhere.csv"}, "the project has no file 'nowhere.csv'"),
        ({"readings": "../worn.csv"}, "without a folder"),
        ({"readings": "take:nobody"}, "nobody"),
        ({"readings": "worn.csv", "layout": "odd"}, "no layout 'odd'"),
        ({"readings": "worn.csv", "layout": "mine.toml"}, "the project has no file 'mine.toml'"),
        ({"readings": "worn.csv", "layout": "phone"}, "unknown sensor"),
        ({"readings": "worn.csv", "library": "other"}, "no library 'other'"),
        ({"readings": "worn.csv", "use": ("angular",)}, "kinds must be force"),
    ],
)
def test_what_cannot_be_sensed_is_refused_in_one_line(folder: Path, section: dict[str, Any], said: str) -> None:
    with pytest.raises(KinetographError, match=said) as caught:
        make(project(**section), Room(folder), nothing)
    assert "\n" not in str(caught.value)


def test_what_is_made_can_be_stopped_and_the_model_is_fitted_once(folder: Path) -> None:
    class Stop(Exception):
        pass

    def stop(done: float, total: float) -> None:
        raise Stop

    def no_fit(done: float, total: float) -> None:
        assert done >= 50, "the model was fitted again"

    room = Room(folder)
    with pytest.raises(Stop):
        make(project(readings="take:held"), room, stop)
    make(project(readings="take:held"), room, nothing)
    make(project(readings="take:held"), room, no_fit)


def test_uncertainty_is_answered_for_the_joints_of_the_body_that_is_shown(folder: Path) -> None:
    room, asked = Room(folder), project(readings="worn.csv")
    with pytest.raises(RequestError, match="nothing has been sensed yet"):
        ANSWERS[JointUncertainty](room, asked, JointUncertainty(7))
    made = make(asked, room, nothing)
    assert made is not None
    room.latest["sensors"] = made
    header, payload = opened(bytes(ANSWERS[JointUncertainty](room, asked, JointUncertainty(7))))  # type: ignore[arg-type]
    values = np.frombuffer(payload, "<f4").reshape(header["frames"], -1)
    assert header["id"] == 7
    assert tuple(header["joints"]) == made.synthesis.motion.skeleton.names
    np.testing.assert_allclose(values, made.synthesis.uncertainty[::4], rtol=1e-6)  # type: ignore[attr-defined]
    assert header["fps"] == 15.0


def test_joints_of_another_body_are_as_uncertain_as_those_of_their_role() -> None:
    from bodies import person

    ours, theirs = walk(1.0).skeleton, person()
    alike = joints_alike(theirs, ours)
    for role in ("left_elbow", "right_knee", "hips"):
        assert alike[theirs.roles[role].joint] == ours.roles[role].joint


def test_thinned_values_keep_their_extremes() -> None:
    values = np.random.default_rng(0).normal(size=20_001)
    few = thinned(values, MOST)
    assert len(few) == MOST
    assert few.max() == values.max()
    assert few.min() == values.min()
    shift = np.arange(MOST) / MOST - np.array([np.flatnonzero(values == v)[0] for v in few]) / len(values)
    assert np.abs(shift).max() < 2 / MOST  # each is where it was
    np.testing.assert_array_equal(thinned(values[:100], MOST), values[:100])


# ---- live ----


def opened(frame: bytes) -> tuple[dict[str, Any], bytes]:
    kind, length = struct.unpack_from("<2I", frame)
    assert kind == 1
    return json.loads(frame[8 : 8 + length]), frame[8 + length :]


def ran(folder: Path, asked: Project, message: Message, said: Callable[[Any], object] | None = None) -> list[Any]:
    """What a run sends."""
    sent: list[Any] = []

    async def run() -> None:
        inbox: asyncio.Queue[Message] = asyncio.Queue()

        def send(frame: Message | bytes) -> None:
            sent.append(frame)
            answer = said(frame) if said else None
            if isinstance(answer, Message):
                inbox.put_nowait(answer)

        await RUNS[type(message)](Room(folder), asked, message, inbox, send)

    asyncio.run(run())
    return sent


def poses(sent: list[Any], joints: int) -> np.ndarray[Any, Any]:
    frames = [np.frombuffer(f, "<f4", offset=4) for f in sent if isinstance(f, bytes) and f[:4] == b"\x02\0\0\0"]
    assert {len(frame) for frame in frames} == {4 + 5 * joints}
    return np.array(frames)


def test_a_replay_is_drawn_as_live_sense_makes_it(folder: Path) -> None:
    sent = ran(folder, project(source="replay:worn.csv@4"), Listen())
    header, glb = opened(sent[0])
    assert header["kind"] == "live"
    path = folder / "body.glb"
    path.write_bytes(glb)
    body = read_glb(path).take.motion().skeleton
    frames = poses(sent, len(body))
    model = SensorControl(layout=preset("wii")).fit(Library.open(folder / "walks"))
    assert body.names == model.fitted.examples.space.skeleton.names
    rows, _ = read_rows(folder / FILES / "worn.csv")
    live = model.start()
    expected = [*live.step(rows), *live.rest()]
    count = min(len(frames), len(expected))
    assert count >= len(expected) - 3
    np.testing.assert_allclose(np.diff(frames[:, 0]), 1 / 60, atol=1e-4)
    quaternions = frames[:count, 4 : 4 + 4 * len(body)].reshape(count, -1, 4)
    apart = rot.angle_between(quaternions, np.array([pose.rotations for pose in expected[:count]]))
    # rows are stamped as they arrive, so that few frames are a little other ones
    assert np.quantile(apart, 0.9) < np.radians(2.0)
    uncertain = frames[:count, 4 + 4 * len(body) :]
    assert np.median(np.abs(uncertain - np.array([pose.uncertainty for pose in expected[:count]]))) < np.radians(0.5)
    assert sent[-1] == LiveEnded("sensors", len(frames))
    heard = [message for message in sent if isinstance(message, Heard)]
    assert {row.sensor for row in heard[-1].rows} == set(preset("wii").names)
    assert all(row.known and 90 < row.rate < 110 for row in heard[-1].rows)
    assert {f"{name}: heard" for name in preset("wii").names} <= {
        message.message.split(" at ")[0] for message in sent if isinstance(message, Said)
    }


def test_sensors_under_other_names_are_called_by_those_of_the_layout(folder: Path) -> None:
    rows = worn()
    strange = replace(rows, names=tuple(f"tracker.{i}" for i in range(len(rows.names))))
    write_readings(strange, folder / FILES / "strange.csv")
    names = dict(zip(strange.names, rows.names, strict=True))

    def call(frame: Any) -> Message | None:
        return CallSensors(names) if isinstance(frame, Heard) and not any(row.known for row in frame.rows) else None

    sent = ran(folder, project(source="replay:strange.csv"), Listen(), call)
    heard = [message for message in sent if isinstance(message, Heard)]
    assert not any(row.known for row in heard[0].rows)
    assert all(row.known for row in heard[-1].rows)
    assert sent[-1].frames > 30
    direct = ran(folder, project(source="replay:strange.csv@4", names=names), Listen())
    assert all(row.known for message in direct if isinstance(message, Heard) for row in message.rows)
    assert direct[-1].frames > 30


def test_a_replay_reads_no_file_but_the_project_s(folder: Path) -> None:
    room = Room(folder)
    for text in ("replay:/etc/passwd", "replay:../walks/catalogue.sqlite", "replay:/etc/passwd@2", "replay:"):
        with pytest.raises(RequestError):
            source_of(text, room, (), print)
    with pytest.raises(RequestError, match="expected a source"):
        ran(folder, project(source="mind://reading"), Listen())
    assert source_of("replay:worn.csv@2", room, (), print).name == "replay:worn.csv"
    assert is_live("slimevr://")
    assert not is_live("worn.csv")


def test_a_phone_is_shown_its_link_as_a_code(folder: Path) -> None:
    links: list[PhoneLink] = []

    async def run() -> None:
        asked = project(source="phone://127.0.0.1:0")

        def send(frame: Message | bytes) -> None:
            links.extend([frame] if isinstance(frame, PhoneLink) else [])

        inbox: asyncio.Queue[Message] = asyncio.Queue()
        task = asyncio.ensure_future(RUNS[Listen](Room(folder), asked, Listen(), inbox, send))  # type: ignore[arg-type]
        for _ in range(600):
            await asyncio.sleep(0.05)
            if links or task.done():
                break
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(run())
    (link,) = links
    assert link.link.startswith("http://127.0.0.1:")
    assert len({len(row) for row in link.code} | {len(link.code)}) == 1  # a square
    assert link.code[0].startswith("0000") or link.code[0].startswith("1111111")


# ---- calibration ----


def askew(layout: Layout, seed: int) -> Layout:
    vectors = np.random.default_rng(seed).normal(scale=0.5, size=(len(layout.sensors), 3))
    sensors = [
        replace(s, rotation=rot.multiply(s.rotation, rot.exp(v))) for s, v in zip(layout.sensors, vectors, strict=True)
    ]
    return replace(layout, sensors=tuple(sensors))


def swapped(layout: Layout, first: str, second: str) -> Layout:
    """Two sensors, each worn where the other belongs."""
    other = {first: second, second: first}
    by_name = {sensor.name: sensor for sensor in layout.sensors}
    worn_there = [
        replace(by_name[other[s.name]], name=s.name, rotation=s.rotation) if s.name in other else s
        for s in layout.sensors
    ]
    return replace(layout, sensors=tuple(worn_there))


def stand_then(motion: Motion, seconds: float) -> Motion:
    count = round(seconds * motion.fps)
    return replace(
        motion,
        translation=np.concatenate([np.repeat(motion.translation[:1], count, axis=0), motion.translation]),
        rotations=np.concatenate([rot.identity(count, len(motion.skeleton)), motion.rotations]),
    )


@pytest.fixture(scope="module")
def performed() -> Motion:
    return stand_then(swinging(walk(8.0, speed=1.05, turn_rate=0.1)), 3.0)


def test_sensors_worn_askew_are_good_and_the_layout_is_the_project_s(folder: Path, performed: Motion) -> None:
    write_readings(simulate(performed, askew(preset("wii"), 1), np.random.default_rng(0)), folder / FILES / "askew.csv")
    message = Calibrate("askew.csv", still=(0.2, 2.8))
    sent = ran(folder, project(), message)
    done = sent[-1]
    assert isinstance(done, Calibrated)
    assert {row.verdict for row in done.rows} == {"good"}
    assert done.layout in done.files
    again = ran(folder, project(), message)[-1]
    assert again.layout != done.layout  # what was made with the first stays as it is
    errors = {}
    for name in ("wii", done.layout):
        path = folder / FILES / name
        mounts = read_layout(path if name.endswith(".toml") else name).sensors
        true = askew(preset("wii"), 1).sensors
        errors[name] = np.mean([rot.angle_between(a.rotation, b.rotation) for a, b in zip(mounts, true, strict=True)])
    assert errors[done.layout] < 0.3 * errors["wii"]
    assert make(project(readings="askew.csv", layout=done.layout), Room(folder), nothing) is not None


def test_a_sensor_on_another_limb_is_to_be_put_on_again(folder: Path, performed: Motion) -> None:
    wrong = swapped(askew(preset("wii"), 1), "left_forearm", "left_shank")
    write_readings(simulate(performed, wrong, np.random.default_rng(0)), folder / FILES / "wrong.csv")
    done = ran(folder, project(), Calibrate("wrong.csv", still=(0.2, 2.8)))[-1]
    words = {row.sensor: row.verdict for row in done.rows}
    assert words["left_forearm"] == words["left_shank"] == "put it on again"
    assert all(words[name] != "put it on again" for name in words.keys() - {"left_forearm", "left_shank"})


def test_a_live_calibration_counts_its_steps_down(folder: Path, performed: Motion) -> None:
    rows = simulate(performed, askew(preset("wii"), 1), np.random.default_rng(0))
    quiet = select_rows(rows, rows.sensors != rows.names.index("right_thigh"))
    write_readings(quiet, folder / FILES / "performed.csv")
    message = Calibrate("replay:performed.csv@5", ready=0.5, standing=2.0, moving=7.0, layout="mine.toml")
    sent = ran(folder, project(), message)
    steps = [each for each in sent if isinstance(each, CalibrationStep)]
    assert list(dict.fromkeys(step.step for step in steps)) == ["ready", "still", "moving", "solving"]
    moving = [step.left for step in steps if step.step == "moving"]
    assert moving == sorted(moving, reverse=True)
    words = {row.sensor: row.verdict for row in sent[-1].rows}
    assert words.pop("right_thigh") == "not heard"
    assert set(words.values()) <= {"good", "fair"}
    assert sent[-1].layout == "mine.toml"


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (Calibrate("nowhere.csv"), "no file 'nowhere.csv'"),
        (Calibrate("worn.csv", still=(1.0, 2.0)), "moved between 1 and 2 s"),
        (Calibrate("worn.csv", layout="../mine.toml"), "without a folder"),
        (Calibrate("worn.csv", layout="mine.txt"), "written as .toml"),
        (Calibrate("replay:strange.csv@20", ready=0, standing=1, moving=1), "say which sensor is which"),
    ],
)
def test_what_cannot_be_calibrated_is_refused(folder: Path, message: Calibrate, said: str) -> None:
    rows = worn()
    strange = replace(rows, names=tuple(f"tracker.{i}" for i in range(len(rows.names))))
    write_readings(strange, folder / FILES / "strange.csv")
    with pytest.raises(RequestError, match=said):
        ran(folder, project(), message)
