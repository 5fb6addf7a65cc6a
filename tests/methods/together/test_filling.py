"""Spans around keys that no segment is like: the take that has the pose plays, joined without a jump."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.keys import Key, key_at
from kinetograph.kinematics import joint_positions
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.methods.together import Asked, AskedKey, performed, pose_errors
from kinetograph.motion import Motion
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
    asked = Asked((raised(5.1),))
    bare, made = (
        performed(model, straight(10.0), asked),
        performed(model, straight(10.0), asked, fill=lambda: keyframes),
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
    asked = Asked((raised(5.1),))
    bare, made = (
        performed(model, straight(10.0), asked),
        performed(model, straight(10.0), asked, fill=lambda: keyframes),
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
    made = performed(model, straight(10.0), Asked((AskedKey(key),)), fill=lambda: keyframes)
    np.testing.assert_array_equal(made.motion.rotations, bare.motion.rotations)
    assert any(text.startswith("both arms: no recording") for text in made.warnings)
    assert made.statistics["filled_spans"] == 0


def test_nothing_is_fitted_for_a_key_that_is_near(model: PerformanceModel) -> None:
    def never() -> KeyframeModel:
        raise AssertionError("fitted without need")

    key = key_at(walk(8.0), 4.0, time=(4.0, 4.0), label="step")
    made = performed(model, straight(8.0), Asked((AskedKey(key),)), fill=never)
    assert "filled_spans" not in made.statistics


def test_keys_that_are_near_to_one_another_share_a_span(model: PerformanceModel, keyframes: KeyframeModel) -> None:
    asked = Asked((raised(5.1), AskedKey(key_at(walk(8.0), 5.1, time=(6.1, 6.1), label="step"))))
    made = performed(model, straight(11.0), asked, fill=lambda: keyframes)
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
    asked = Asked((raised(5.1),))
    made = performed(model, straight(10.0), asked, fill=lambda: keyframes)
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
