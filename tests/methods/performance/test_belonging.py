"""What a path is preferably performed by: one person in one style, who walks; and what that is said to cost."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.library import Facts, describe_takes
from kinetograph.methods.everyday import everyday_frames
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, Rule, partner_control
from kinetograph.methods.performance.belonging import ANYONE, origins_of
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation, Take
from walkers import walk

SPEEDS = (0.9, 1.2)
"""Metres per second of two people, each of whom walks one half of the path best."""


def _cuts(seconds: float) -> tuple[Annotation, ...]:
    return tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(0.0, seconds + 0.1, 0.5))


def _library(folder: Path, **takes: Motion) -> kg.Library:
    """Takes whose names have their double underscores as slashes."""
    library = kg.Library.create(folder / "library")
    for name, motion in takes.items():
        library.add(Take(name.replace("__", "/"), {"motion": motion}, _cuts(motion.duration)))
    return library


def _path() -> Signal:
    """A straight path, first as fast as one person walks and then as fast as the other, three times."""
    speed = np.repeat(np.tile(SPEEDS, 3), 60)
    z = np.concatenate([[0.0], np.cumsum(speed) / 30])
    return Signal(np.stack([0 * z, 0 * z, z], axis=-1)[:, None], ("path",), "m", 30.0)


def _folders(made: Synthesis) -> list[str]:
    return [piece.take.split("/")[0] for piece in made.pieces]


def _changes(made: Synthesis) -> int:
    names = _folders(made)
    return sum(a != b for a, b in pairwise(names))


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    slow, fast = (walk(6.0, speed=speed) for speed in SPEEDS)
    return _library(tmp_path_factory.mktemp("two"), ann__walk=slow, bob__walk=fast)


def test_people_take_turns_only_where_that_is_free(two: kg.Library) -> None:
    method = PerformanceControl(continuity=0.001, reuse=0.0, change=0.0)
    free = method.fit(two).synthesize(_path())
    dear = replace(method, change=1.0).fit(two).synthesize(_path())
    assert (set(_folders(free)), len(set(_folders(dear)))) == ({"ann", "bob"}, 1)
    assert (_changes(free) >= 4, _changes(dear)) == (True, 0)
    assert ("change" in free.costs, dear.costs["change"]) == (False, 0.0)


def test_what_changes_cost_is_part_of_the_cost_and_told(two: kg.Library) -> None:
    method = PerformanceControl(continuity=0.001, reuse=0.0, change=1e-6, fine_rate=None)
    made = method.fit(two).synthesize(_path())
    assert made.costs["change"] == pytest.approx(1e-6 * _changes(made))
    assert made.costs["change"] > 0
    free = replace(method, change=0.0).fit(two).synthesize(_path())
    assert made.cost == pytest.approx(free.cost + made.costs["change"], abs=1e-9)


def test_subjects_tags_and_styles_make_the_difference(tmp_path: Path) -> None:
    library = _library(tmp_path, one=walk(2.0), two=walk(2.0, speed=1.1))
    assert _origins(library) is None  # nobody knows who they are
    describe_takes(library, {"one": Facts(subject="ann"), "two": Facts(subject="ann")})
    assert _origins(library) is None
    describe_takes(library, {"one": Facts(subject="ann"), "two": Facts(subject="bob")})
    assert _origins(library) == [0, 0, 0, 0, 1, 1, 1, 1]
    describe_takes(library, {"one": Facts(tags=frozenset({"sad"})), "two": Facts()})
    assert _origins(library) == [0, 0, 0, 0, 1, 1, 1, 1]
    describe_takes(library, {"one": Facts(), "two": Facts()})
    library.annotate("one", (*_cuts(2.0), Annotation("motion", "style", "sad", 0.0, 1.0)))
    assert _origins(library) == [0, 0, 1, 1, 1, 1, 1, 1]


def _origins(library: kg.Library) -> list[int] | None:
    fitted = PerformanceControl(stand=False).fit(library).fitted
    origins = origins_of(fitted.sources, fitted.instances.segments)
    return None if origins is None else origins.tolist()


def test_a_pose_that_is_held_is_anybodys(two: kg.Library) -> None:
    fitted = PerformanceControl().fit(two).fitted
    held = np.array([segment.held for segment in fitted.instances.segments])
    origins = origins_of(fitted.sources, fitted.instances.segments)
    assert held.any()
    assert origins is not None
    assert set(origins[held].tolist()) == {ANYONE}


def _arms_up(motion: Motion) -> Motion:
    """The same walk with both arms raised."""
    rotations = motion.rotations.copy()
    for side in ("left", "right"):
        rotations[:, motion.skeleton.index(f"{side}_shoulder")] = rot.about("x", np.full(len(motion), -np.pi))
    return replace(motion, rotations=rotations)


@pytest.fixture(scope="module")
def raised(tmp_path_factory: pytest.TempPathFactory) -> PerformanceModel:
    """Somebody who walks at 1 m/s, and with raised arms at 1.1 m/s."""
    up = _arms_up(walk(6.0, speed=1.1))
    assert not any(frames.any() for frames in everyday_frames(up))
    library = _library(tmp_path_factory.mktemp("raised"), plain=walk(6.0), up=up)
    return PerformanceControl(reuse=0.0, unusual=0.005).fit(library)


def _straight() -> Signal:
    z = 1.1 * np.arange(151) / 30
    return Signal(np.stack([0 * z, 0 * z, z], axis=-1)[:, None], ("path",), "m", 30.0)


def test_a_path_is_walked_although_something_else_fits_it_better(raised: PerformanceModel) -> None:
    free = PerformanceModel(replace(raised.fitted, settings=replace(raised.method, unusual=0.0)))
    assert {piece.take for piece in free.synthesize(_straight()).pieces} == {"up"}
    made = raised.synthesize(_straight())
    assert {piece.take for piece in made.pieces} == {"plain"}
    assert made.costs["unusual"] == 0.0


def test_what_is_unusual_costs_by_the_second_where_there_is_nothing_else(raised: PerformanceModel) -> None:
    made = raised.synthesize(_straight(), rules=[Rule(0.0, 5.0, take="up")])
    assert made.costs["unusual"] == pytest.approx(0.005 * 5.0, rel=0.05)


def test_the_motion_of_somebody_is_followed_whatever_it_is(raised: PerformanceModel) -> None:
    made = raised.synthesize(walk(5.0, speed=1.1))
    assert {piece.take for piece in made.pieces} == {"up"}
    assert "unusual" not in made.costs


def test_negative_costs_are_refused_and_partners_are_free() -> None:
    for name in ("change", "unusual"):
        with pytest.raises(RequestError, match=f"{name} must be 0 or more, found -1"):
            PerformanceControl(**{name: -1})
    assert partner_control().change == 0.0
