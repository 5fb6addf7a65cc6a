"""A long control is made block by block: the same motion, contacts and figures as at once."""

from __future__ import annotations

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.kinematics import joint_positions
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, making
from kinetograph.segmentation import detect_contacts
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation, Take
from walkers import walk

_FPS = 30.0


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> PerformanceModel:
    times = np.arange(241) / _FPS
    recording = walk(8.0, speed=1.0 + 0.25 * np.sin(0.9 * times), turn_rate=0.6 * np.cos(0.7 * times))
    library = kg.Library.create(tmp_path_factory.mktemp("long") / "library")
    cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(17) / 2)
    library.add(Take("walk", {"body": recording}, (*cuts, *detect_contacts(recording, track="body"))))
    return PerformanceControl(stretch=0.1).fit(library)


def _path(seconds: float) -> kg.Signal:
    times = np.arange(round(seconds * _FPS) + 1) / _FPS
    heading = np.cumsum(0.5 * np.sin(times)) / _FPS
    steps = np.stack([np.sin(heading), 0 * heading, np.cos(heading)], axis=1) / _FPS
    return kg.Signal(np.cumsum(steps, axis=0)[:, None], ("path",), "m", _FPS)


@pytest.fixture(scope="module")
def both(model: PerformanceModel) -> tuple[Synthesis, Synthesis]:
    """A control of a minute, made at once and in blocks of some seconds."""
    at_once = model.synthesize(_path(70.0))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(making, "LONGEST", 600)
        return at_once, model.synthesize(_path(70.0))


def test_places_contacts_and_provenance_are_those_of_the_whole(both: tuple[Synthesis, Synthesis]) -> None:
    at_once, blocks = both
    assert at_once.pieces == blocks.pieces
    np.testing.assert_allclose(blocks.motion.translation, at_once.motion.translation, atol=1e-9)
    assert [(n.kind, n.label) for n in blocks.annotations] == [(n.kind, n.label) for n in at_once.annotations]
    contacts = [(n.start, n.stop) for n in at_once.annotations]
    assert len(contacts) > 100
    np.testing.assert_allclose([(n.start, n.stop) for n in blocks.annotations], contacts, atol=1e-9)


def test_joints_are_those_of_the_whole_but_for_millimetres(both: tuple[Synthesis, Synthesis]) -> None:
    at_once, blocks = both
    away = np.linalg.norm(joint_positions(blocks.motion) - joint_positions(at_once.motion), axis=-1)
    assert away.max() < 0.01
    assert away.mean() < 1e-4
    assert np.abs(blocks.edited - at_once.edited).max() < 2e-3
    for name, value in at_once.statistics.items():
        assert blocks.statistics[name] == pytest.approx(value, rel=0.02, abs=1e-3)


def test_nothing_leaps_where_blocks_meet(both: tuple[Synthesis, Synthesis]) -> None:
    at_once, blocks = both
    for axis in range(2):  # positions, and signs of quaternions
        of = (joint_positions, lambda motion: motion.rotations)[axis]
        whole, made = (np.abs(np.diff(of(each.motion), 2, axis=0)).max() for each in (at_once, blocks))
        assert made < 1.05 * whole + 1e-3
    assert (np.sum(blocks.motion.rotations[1:] * blocks.motion.rotations[:-1], axis=-1) > 0.5).all()
    assert rot.angle_between(blocks.motion.rotations, at_once.motion.rotations).max() < 0.1


def test_no_more_frames_than_a_block_and_its_margins_are_made_together(
    model: PerformanceModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []
    once = making._at_once

    def counted(fitted: object, recorded: making.Recorded) -> making.Made:
        made.append(recorded.frames)
        return once(fitted, recorded)  # type: ignore[arg-type]

    monkeypatch.setattr(making, "_at_once", counted)
    monkeypatch.setattr(making, "LONGEST", 600)
    model.synthesize(_path(70.0))
    assert len(made) == 8
    assert max(made) <= 300 + 2 * (making.MARGIN + 4.0) * _FPS
    made.clear()
    model.synthesize(_path(19.0))
    assert made == [571]  # a short one is made as a whole


def test_a_foot_that_stands_for_long_is_in_the_margin_from_before_it_is_set_down() -> None:
    stands = (
        Annotation("motion", "contact", "left_foot", 5.0, 58.0),
        Annotation("motion", "contact", "left_toe", 60.0, 61.0),
    )
    recorded = making.Recorded([], stands, (), None, 6000)
    blocks = list(making._blocks(recorded, 100.0))
    assert blocks[0][2:] == (0, 6000) or blocks[0][3] >= 5800
    first, stop, begin, end = making_block(recorded, 3000, monkey=600)
    assert begin <= 400 or begin == 0
    assert first >= begin
    assert stop <= end


def making_block(recorded: making.Recorded, frame: int, monkey: int) -> tuple[int, int, int, int]:
    """The block that a frame is in, where so many frames may be made at once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(making, "LONGEST", monkey)
        return next(block for block in making._blocks(recorded, 100.0) if block[0] <= frame < block[1])
