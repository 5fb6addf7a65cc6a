"""Spans around keys that no segment is like: the take that has the pose plays, joined without a jump."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.formats import write_report
from kinetograph.keys import Key, key_at
from kinetograph.kinematics import joint_positions
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.methods.together import Asked, AskedKey, performed, pose_errors
from kinetograph.motion import Motion, sample
from kinetograph.pipeline import Rendered, why_at
from kinetograph.take import Annotation, Take
from walkers import walk

SETTINGS = {"continuity": 0.1, "reuse": 0.0, "change": 0.0, "unusual": 0.0, "stand": False}


def lifted(motion: Motion, second: float, height: float = 2.5) -> Motion:
    """A walk whose left arm is raised for a while around a second."""
    times = np.arange(len(motion)) / motion.fps
    angle = height * np.exp(-(((times - second) / 0.4) ** 2))
    rotations = motion.rotations.copy()
    joint = motion.skeleton.names.index("left_shoulder")
    rotations[:, joint] = rot.multiply(rot.about("z", angle), rotations[:, joint])
    return replace(motion, rotations=rotations)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    """Walks that are cut, and one with a raised arm that is not, so that no performance has it."""
    made = kg.Library.create(tmp_path_factory.mktemp("filling") / "library")
    walks = {"straight": walk(8.0), "left": walk(8.0, turn_rate=0.6), "right": walk(8.0, turn_rate=-0.6)}
    for name, motion in {**walks, "wave": lifted(walk(8.0), 4.1)}.items():
        cuts = [Annotation("body", "cut", "", t, t) for t in np.arange(17) / 2]
        plants = [
            Annotation("body", "contact", f"{side}_foot", float(t), float(t) + 0.6)
            for side, offset in (("left", 0.0), ("right", 0.5))
            for t in np.arange(8) + offset
        ]
        made.add(Take(name, {"body": motion}, (*(cuts if name in walks else ()), *plants)))
    return made


@pytest.fixture(scope="module")
def model(library: kg.Library) -> PerformanceModel:
    return PerformanceControl(**SETTINGS).fit(library, exclude=["wave"])  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def keyframes(library: kg.Library) -> KeyframeModel:
    return KeyframeControl().fit(library)


def straight(seconds: float) -> kg.Signal:
    times = np.arange(round(seconds * 30) + 1) / 30
    return kg.Signal(np.stack([0 * times, 0 * times, times], axis=1)[:, None], ("path",), "m", 30.0)


def raised(time: float, height: float = 2.5) -> AskedKey:
    return AskedKey(key_at(lifted(walk(8.0), 4.1, height), 4.1, time=(time, time), label="wave"))


def test_the_take_that_has_the_pose_plays(model: PerformanceModel, keyframes: KeyframeModel) -> None:
    asked = Asked((raised(5.1),), fill=True)
    bare, made = (
        performed(model, straight(10.0), asked),
        performed(model, straight(10.0), asked, keyframes=lambda: keyframes),
    )
    assert bare.piece_at(153).take != "wave"
    assert made.piece_at(153).take == "wave"
    assert made.piece_at(153).source_time(5.1) == pytest.approx(4.1, abs=0.05)
    assert max(pose_errors(model, made, asked.keys)) < 1e-3
    assert made.met == (5.1,)
    assert made.statistics["filled_spans"] == 1
    assert made.costs["filled"] > 0
    assert len(made.motion) == len(bare.motion) == len(made.edited)
    # what plays is the recording: its pose a while before the key too, which blending in does not have
    late = round(5.1 * 30) - 8
    seen = [
        joint_positions(m)[at] - m.translation[at]
        for m, at in ((made.motion, late), (lifted(walk(8.0), 4.1), round(4.1 * 30) - 8), (bare.motion, late))
    ]
    hand = made.motion.skeleton.names.index("left_hand")
    near, blended = (np.linalg.norm(seen[i][hand] - seen[1][hand]) for i in (0, 2))
    assert near < 0.5 * blended


def test_a_filled_span_is_joined_without_a_jump(model: PerformanceModel, keyframes: KeyframeModel) -> None:
    asked = Asked((raised(5.1),), fill=True)
    bare, made = (
        performed(model, straight(10.0), asked),
        performed(model, straight(10.0), asked, keyframes=lambda: keyframes),
    )
    for before, after in itertools.pairwise(made.pieces):
        assert before.stop == pytest.approx(after.start)
    outside = [*range(60), *range(250, 300)]
    np.testing.assert_allclose(made.motion.rotations[outside], bare.motion.rotations[outside], atol=1e-9)
    np.testing.assert_allclose(made.motion.translation[outside], bare.motion.translation[outside], atol=1e-9)
    bends = np.linalg.norm(np.diff(joint_positions(made.motion), n=2, axis=0), axis=-1).max()
    recorded = np.linalg.norm(np.diff(joint_positions(lifted(walk(8.0), 4.1)), n=2, axis=0), axis=-1).max()
    assert bends < 1.5 * recorded


def test_a_pose_that_no_recording_has_is_met_by_editing(model: PerformanceModel, keyframes: KeyframeModel) -> None:
    pose = lifted(walk(8.0), 4.1)
    joint = pose.skeleton.names.index("right_shoulder")
    rotations = pose.rotations.copy()
    rotations[:, joint] = rot.multiply(rot.about("z", np.full(len(pose), -2.5)), rotations[:, joint])
    key = key_at(replace(pose, rotations=rotations), 4.1, time=(5.0, 5.0), label="both arms")
    bare = performed(model, straight(10.0), Asked((AskedKey(key),)))
    made = performed(model, straight(10.0), Asked((AskedKey(key),), fill=True), keyframes=lambda: keyframes)
    np.testing.assert_array_equal(made.motion.rotations, bare.motion.rotations)
    assert any(text.startswith("both arms: no recording") for text in made.warnings)
    assert made.statistics["filled_spans"] == 0


def test_nothing_is_fitted_for_a_key_that_is_near(model: PerformanceModel) -> None:
    def never() -> KeyframeModel:
        raise AssertionError("fitted without need")

    key = key_at(walk(8.0), 4.0, time=(4.0, 4.0), label="step")
    made = performed(model, straight(8.0), Asked((AskedKey(key),), fill=True), keyframes=never)
    assert "filled_spans" not in made.statistics


def test_keys_that_are_near_to_one_another_share_a_span(model: PerformanceModel, keyframes: KeyframeModel) -> None:
    asked = Asked((raised(5.1), AskedKey(key_at(walk(8.0), 5.1, time=(6.1, 6.1), label="step"))), fill=True)
    made = performed(model, straight(11.0), asked, keyframes=lambda: keyframes)
    assert made.statistics["filled_spans"] == 1
    assert made.piece_at(153).take == "wave"
    assert max(pose_errors(model, made, asked.keys)) < 1e-3
    assert Key(made.motion, 183).frame == round(made.met[1] * 30)


def test_a_request_says_whether_spans_are_filled(library: kg.Library, tmp_path: Path) -> None:
    from kinetograph.formats import KeySources
    from kinetograph.formats.request_json import OnPathRow, Request
    from kinetograph.pipeline import render_request

    points = tuple((float(t), 0.0, float(t)) for t in np.arange(301) / 30)
    row = OnPathRow(pose="take:wave@4.1", time=5.1)
    request = Request(path=points, keys=(row,), standing=False)
    sources = KeySources(library, folder=tmp_path)
    takes = [
        render_request(each, library, sources).synthesis.piece_at(153).take
        for each in (request, msgspec.structs.replace(request, fill=True))
    ]
    assert takes[1] == "wave"


def test_why_names_the_recordings_of_a_filled_span(model: PerformanceModel, keyframes: KeyframeModel) -> None:
    asked = Asked((raised(5.1),), fill=True)
    made = performed(model, straight(10.0), asked, keyframes=lambda: keyframes)
    rendered = Rendered(made, straight(10.0), model, asked)
    ((start, stop),) = made.filled
    there = why_at(rendered, 5.1)
    assert there.reasons is None
    assert there.span == (start, stop)
    assert there.keys == (5.1,)
    assert "wave" in {piece.take for piece in there.pieces}
    assert all(piece.stop > start and piece.start < stop for piece in there.pieces)
    before = why_at(rendered, start - 0.5)
    assert before.span is None
    assert before.reasons is not None
    assert before.reasons.chosen.piece.take != "wave"


def halted(motion: Motion, second: float, seconds: float) -> Motion:
    """A walk that slows down, stands for a while, and goes on."""
    length = motion.duration + seconds
    times = np.arange(round(length * motion.fps) + 1) / motion.fps
    pace = 1.0 - np.clip(np.minimum((times - second) / 0.4, (second + 0.4 + seconds - times) / 0.4), 0.0, 1.0)
    gone = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1])) / motion.fps])
    return sample(motion, np.minimum(gone, motion.duration), motion.fps)


@pytest.fixture(scope="module")
def waving(
    tmp_path_factory: pytest.TempPathFactory, library: kg.Library
) -> tuple[PerformanceModel, KeyframeModel, Motion]:
    """Fits to walks, and to one who stands still to raise an arm; and that take."""
    made = kg.Library.create(tmp_path_factory.mktemp("waiting") / "library")
    for name in ("straight", "left", "right"):
        made.add(library.take(name))
    stands = lifted(halted(walk(8.0), 3.0, 3.0), 4.9)
    plants = [Annotation("body", "contact", f"{side}_foot", 3.6, 5.9) for side in ("left", "right")]
    made.add(Take("wave", {"body": stands}, tuple(plants)))
    return PerformanceControl(**SETTINGS).fit(made, exclude=["wave"]), KeyframeControl().fit(made), stands  # type: ignore[arg-type]


def placed(clip: Motion, metres: float) -> AskedKey:
    return AskedKey(key_at(clip, 4.9, label="wave"), along=metres)


def test_a_path_waits_for_a_key_at_a_place(waving: tuple[PerformanceModel, KeyframeModel, Motion]) -> None:
    model, keyframes, clip = waving
    later = AskedKey(key_at(walk(8.0), 4.0, time=(9.0, 9.0), label="step"))
    made = performed(model, straight(11.0), Asked((placed(clip, 5.0), later)), keyframes=lambda: keyframes)
    assert made.statistics["filled_spans"] == 1
    assert made.piece_at(round(made.met[0] * 30)).take == "wave"
    waited = made.statistics["waited_seconds"]
    assert waited > 1.0
    assert made.motion.duration == pytest.approx(11.0 + waited, abs=1 / 30)
    # the clock never goes back, and is whole at both ends
    assert len(made.clock) == len(made.motion)
    assert np.diff(made.clock).min() >= 0
    assert (made.clock[0], made.clock[-1]) == (0.0, pytest.approx(11.0, abs=1 / 30))
    # the key is met where the path is asked for it, and the one after it at its second of the control
    frame = round(made.met[0] * 30)
    assert made.motion.translation[frame, 2] == pytest.approx(5.0, abs=0.05)
    assert max(pose_errors(model, made, (placed(clip, 5.0), later))) < 1e-3
    assert made.clock_at(round(made.met[1] * 30)) == pytest.approx(9.0, abs=1 / 30)
    assert made.met[1] == pytest.approx(9.0 + waited, abs=1 / 30)
    # and elsewhere the path is followed: the straight walk is exactly on it
    assert made.statistics["path_off_mean"] < 0.01


def test_a_key_at_a_time_close_by_does_not_keep_the_path_from_waiting(
    waving: tuple[PerformanceModel, KeyframeModel, Motion],
) -> None:
    model, keyframes, clip = waving
    asked = (AskedKey(key_at(walk(8.0), 4.4, time=(4.4, 4.4), label="step")), placed(clip, 5.0))
    made = performed(model, straight(11.0), Asked(asked), keyframes=lambda: keyframes)
    assert made.piece_at(round(made.met[1] * 30)).take == "wave"
    assert made.clock_at(round(made.met[0] * 30)) == pytest.approx(4.4, abs=0.2)
    assert max(pose_errors(model, made, asked)) < 1e-3


def test_a_report_says_where_the_path_waits(
    waving: tuple[PerformanceModel, KeyframeModel, Motion], tmp_path: Path
) -> None:
    model, keyframes, clip = waving
    made = performed(model, straight(11.0), Asked((placed(clip, 5.0),)), keyframes=lambda: keyframes)
    write_report(made, tmp_path / "report.json")
    report = json.loads((tmp_path / "report.json").read_text())
    ((start, stop),) = made.filled
    assert report["filled"] == [{"start": start, "stop": stop}]
    assert report["met"] == list(made.met)
    assert [row["control"] for row in report["frames"]] == made.clock.tolist()


def test_a_path_keeps_its_time_where_that_is_asked_for(waving: tuple[PerformanceModel, KeyframeModel, Motion]) -> None:
    model, keyframes, clip = waving
    asked = (placed(clip, 5.0),)
    settings = replace(model.fitted.settings, keep_time=True)
    strict = replace(model, fitted=replace(model.fitted, settings=settings))
    for made in (
        performed(model, straight(11.0), Asked(asked, fill=False), keyframes=lambda: keyframes),
        performed(strict, straight(11.0), Asked(asked), keyframes=lambda: keyframes),
    ):
        assert len(made.clock) == 0
        assert made.motion.duration == pytest.approx(11.0)
        assert max(pose_errors(model, made, asked)) < 1e-3


def test_why_counts_in_seconds_of_the_result(waving: tuple[PerformanceModel, KeyframeModel, Motion]) -> None:
    model, keyframes, clip = waving
    asked = Asked((placed(clip, 5.0),))
    made = performed(model, straight(11.0), asked, keyframes=lambda: keyframes)
    second = made.motion.duration - 1.0
    answer = why_at(Rendered(made, straight(11.0), model, asked), second)
    assert answer.reasons is not None
    shown = made.piece_at(round(second * 30))
    assert answer.reasons.chosen.piece.take == shown.take
