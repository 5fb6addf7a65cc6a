"""The collector that all three methods share: what is left out, loops, skeletons."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions
from kinetograph.methods.recordings import CYCLES, adopt, collect, looped, mirrored_annotations
from kinetograph.methods.relative_pose import leg_length
from kinetograph.motion import Motion
from kinetograph.take import Annotation, Take
from walkers import stick_figure, walk


def _library(folder: Path, *takes: Take) -> kg.Library:
    library = kg.Library.create(folder / "library")
    for take in takes:
        library.add(take)
    return library


@pytest.mark.parametrize("method", [kg.PerformanceControl, kg.KeyframeControl, kg.SensorControl])
def test_every_method_refuses_a_name_to_leave_out_that_is_not_there(tmp_path: Path, method: type) -> None:
    library = _library(tmp_path, Take("a", {"body": walk(2.0)}), Take("b", {"body": walk(2.0)}))
    with pytest.raises(RequestError, match="no take 'bb' to leave out; there are a, b"):
        method().fit(library, exclude=("bb",))


def test_takes_are_left_out_and_progress_is_told(tmp_path: Path) -> None:
    library = _library(tmp_path, *(Take(name, {"body": walk(1.0)}) for name in "abc"))
    told: list[tuple[int, int]] = []
    recordings = collect(library, exclude=("b",), progress=lambda done, total: told.append((done, total)))
    assert [(r.name, r.track, r.period) for r in recordings] == [("a", "body", 0.0), ("c", "body", 0.0)]
    assert told == [(1, 2), (2, 2)]


def test_nothing_left_is_an_error(tmp_path: Path) -> None:
    library = _library(tmp_path, Take("a", {"body": walk(1.0)}))
    with pytest.raises(RequestError, match="the library has no take to use; add recordings, or exclude fewer"):
        collect(library, exclude=("a",))


def test_a_loop_is_played_several_times_and_its_contacts_are_found_anew(tmp_path: Path) -> None:
    clip = walk(1.0)
    noted = (Annotation("body", "loop", "wrap", 0.0, 1.0), Annotation("body", "contact", "left_toe", 0.0, 0.1))
    once, plain = collect(_library(tmp_path, Take("a", {"body": clip}, noted), Take("b", {"body": clip}, noted[1:])))
    long = looped(once)
    assert long.motion.duration == pytest.approx(CYCLES * clip.duration)
    assert long.period == pytest.approx(clip.duration)
    assert len(long.contacts()) > len(noted[1:])
    assert looped(plain) is plain
    assert plain.contacts() == noted[1:]


def test_another_build_is_scaled_with_its_legs_or_stays_where_it_is() -> None:
    small, tall = stick_figure(), stick_figure(1.2)
    motion = walk(2.0)
    assert leg_length(tall) == pytest.approx(1.2 * leg_length(small))
    grown = Motion(tall, 1.2 * motion.translation, motion.rotations, motion.fps)
    back = adopt(grown, motion.skeleton)
    np.testing.assert_allclose(joint_positions(back), joint_positions(motion), atol=1e-9)
    stayed = adopt(grown, motion.skeleton, scaled=False)
    np.testing.assert_allclose(stayed.translation[:, [0, 2]], grown.translation[:, [0, 2]])
    assert joint_positions(stayed)[..., 1].min() == pytest.approx(joint_positions(grown)[..., 1].min(), abs=1e-6)


def test_nearly_the_same_build_is_lifted_to_its_floor() -> None:
    motion = walk(2.0)
    longer = replace(motion.skeleton, offsets=motion.skeleton.offsets * 1.02)
    moved = adopt(motion, longer)
    np.testing.assert_allclose(moved.translation[:, [0, 2]], motion.translation[:, [0, 2]])
    lowest, before = (joint_positions(m)[..., 1].min(axis=1) for m in (moved, motion))
    assert np.quantile(lowest, 0.05) == pytest.approx(np.quantile(before, 0.05), abs=1e-9)
    assert adopt(motion, motion.skeleton) is motion


def test_labels_change_sides() -> None:
    notes = [Annotation("body", kind, label, 0.0, 1.0) for kind, label in (("contact", "left_toe"), ("move", "waltz"))]
    assert [note.label for note in mirrored_annotations(notes)] == ["right_toe", "waltz"]


@pytest.mark.parametrize(
    ("name", "mirrored"),
    [
        ("turn left", "turn right"),
        ("Right_turn", "Left_turn"),
        ("inside turn", "outside turn"),
        ("leftover", "leftover"),
        ("hop-left-left", "hop-right-right"),
    ],
)
def test_names_of_moves_change_sides_word_by_word(name: str, mirrored: str) -> None:
    (note,) = mirrored_annotations([Annotation("body", "move", name, 0.0, 1.0)])
    assert note.label == mirrored
    assert next(iter(mirrored_annotations([note]))).label == name


def test_a_library_may_have_pairs_of_its_own() -> None:
    (note,) = mirrored_annotations([Annotation("body", "style", "port tack", 0.0, 1.0)], [("port", "starboard")])
    assert note.label == "starboard tack"
