"""Footplants of a walk whose plants were put in, and of points that hover at a threshold."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion, place
from kinetograph.segmentation import ContactThresholds, detect_contacts, footplant_cuts
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation
from walkers import slide, stick_figure, walk

_FPS = 60.0
_TOE = stick_figure().index("left_toe")


def _contact(label: str, start: float, stop: float) -> Annotation:
    return Annotation("motion", "contact", label, start, stop)


def _toe(path: FloatArray) -> Motion:
    """A body that hangs still in the air except for its left toe, which moves by ``path``, ``(F, 3)``."""
    skeleton = stick_figure()
    frames = len(path)
    still = Motion(skeleton, np.tile([0.0, 5.0, 0.0], (frames, 1)), rot.identity(frames, 15), _FPS)
    return slide(still, "left_toe", path)


def _of_toe(motion: Motion, thresholds: ContactThresholds | None = None) -> list[tuple[float, float]]:
    return [(n.start, n.stop) for n in detect_contacts(motion, thresholds) if n.label == "left_toe"]


def _dip(frames: int, low: int, high: int, height: float = 0.2) -> FloatArray:
    """On the ground from frame ``low`` to ``high - 1``, ``height`` above it before and after, in one leap."""
    path = np.zeros((frames, 3))
    path[:, 1] = height
    path[low:high, 1] = 0.0
    return path


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_the_plants_of_a_walk_are_found(fps: float) -> None:
    contacts = detect_contacts(walk(5.0, fps=fps))
    for role, first in (("left_toe", 0.0), ("right_toe", 0.5), ("left_foot", 0.0), ("right_foot", 0.5)):
        plants = [n for n in contacts if n.label == role and n.start >= 0.4 and n.stop < 4.9]
        np.testing.assert_allclose(
            [n.start for n in plants], first + np.arange(first == 0, 4 + (first == 0)), atol=0.05
        )
        np.testing.assert_allclose([n.stop - n.start for n in plants], 0.6, atol=0.1)
    assert {n.kind for n in contacts} == {"contact"}
    assert list(contacts) == sorted(contacts, key=lambda n: (n.start, n.label))


def test_a_walk_is_cut_where_either_foot_is_planted() -> None:
    motion = walk(5.0, fps=_FPS)
    cuts = footplant_cuts(motion, detect_contacts(motion))
    np.testing.assert_allclose(cuts, np.arange(1, 10) / 2, atol=0.05)


@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_neither_place_nor_level_of_the_ground_matters(turn: float) -> None:
    motion = walk(3.0, fps=_FPS)
    assert detect_contacts(place(motion, turn, (5.0, 1.3, -2.0))) == detect_contacts(motion)


def test_the_track_is_named() -> None:
    assert {n.track for n in detect_contacts(walk(2.0), track="leader")} == {"leader"}


def test_a_fast_foot_near_the_ground_is_not_planted() -> None:
    path = np.zeros((120, 3))
    path[:, 2] = np.arange(120) / _FPS * 0.6
    assert _of_toe(_toe(path)) == []
    path[:, 2] /= 2
    assert _of_toe(_toe(path)) == [(0.0, 119 / _FPS)]


def test_a_slow_foot_in_the_air_is_not_planted() -> None:
    path = np.zeros((120, 3))
    path[:60, 1] = 0.2
    (plant,) = _of_toe(_toe(path))
    assert plant == (pytest.approx(61 / _FPS, abs=2.5 / _FPS), 119 / _FPS)


@pytest.mark.parametrize("what", ["height", "speed"])
@pytest.mark.parametrize("seed", range(4))
def test_noise_between_the_thresholds_does_not_flicker(what: str, seed: int) -> None:
    # planted for a moment, then in the band between beginning and staying, up and down, and once clearly off
    rng = np.random.default_rng(seed)
    path = np.zeros((240, 3))
    if what == "height":
        path[20:180, 1] = rng.uniform(0.035, 0.055, 160)
        smooth = ContactThresholds(speed=(5.0, 9.0))
    else:
        path[20:180, 2] = np.cumsum(rng.uniform(0.3, 0.5, 160)) / _FPS
        path[180:, 2] = path[179, 2]
        smooth = ContactThresholds()
    path[180:, 1] = 0.3
    assert len(_of_toe(_toe(path), smooth)) == 1
    loose = dataclasses.replace(smooth, height=(0.04, 0.04), speed=(smooth.speed[0],) * 2, gap=0.0, shortest=0.0)
    assert len(_of_toe(_toe(path), loose)) > 1  # without hysteresis it does


def test_a_foot_that_never_settles_is_not_planted_by_the_looser_thresholds() -> None:
    path = _dip(240, 200, 240)
    path[100:140, 1] = 0.05
    (plant,) = _of_toe(_toe(path))
    assert plant[0] > 190 / _FPS


def test_brief_breaks_are_closed_and_brief_contacts_dropped() -> None:
    path = np.zeros((240, 3))
    path[:, 1] = 0.2
    path[30:90, 1] = 0.0
    path[60:62, 1] = 0.1  # a break of two frames, which the measure of speed widens by one either side
    path[150:154, 1] = 0.0  # a touch of four
    thresholds = ContactThresholds(speed=(50.0, 50.0))
    assert _of_toe(_toe(path), thresholds) == [(30 / _FPS, 89 / _FPS)]
    exact = dataclasses.replace(thresholds, gap=0.0)
    assert _of_toe(_toe(path), exact) == [(30 / _FPS, 59 / _FPS), (62 / _FPS, 89 / _FPS)]
    every = dataclasses.replace(thresholds, shortest=0.0)
    assert _of_toe(_toe(path), every) == [(30 / _FPS, 89 / _FPS), (150 / _FPS, 153 / _FPS)]


def test_a_skeleton_without_feet_has_no_contacts() -> None:
    lone = Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))
    assert detect_contacts(Motion(lone, np.zeros((9, 3)), rot.identity(9, 1), 30.0)) == ()


def test_heel_and_toe_of_one_step_are_one_plant() -> None:
    contacts = (
        _contact("left_foot", 0.5, 0.9),
        _contact("left_toe", 0.6, 1.1),  # within the heel's
        _contact("left_foot", 1.12, 1.3),  # a moment after
        _contact("right_toe", 1.5, 2.0),
        _contact("left_toe", 1.8, 2.2),
    )
    assert footplant_cuts(walk(3.0), contacts) == (0.5, 1.5, 1.8)


def test_cuts_keep_a_distance() -> None:
    contacts = tuple(
        _contact(f"{side}_toe", t, t + 0.05) for side, t in (("left", 0.5), ("right", 0.6), ("left", 0.75))
    )
    assert footplant_cuts(walk(3.0), contacts) == (0.5, 0.75)
    assert footplant_cuts(walk(3.0), contacts, shortest=0.09) == (0.5, pytest.approx(0.6), 0.75)


def test_a_foot_that_is_down_at_the_start_was_planted_earlier() -> None:
    contacts = (_contact("left_toe", 0.0, 0.4), _contact("right_toe", 0.5, 0.9), _contact("left_toe", 1.0, 1.4))
    assert footplant_cuts(walk(3.0), contacts) == (0.5, 1.0)


@pytest.mark.parametrize(("contacts", "count"), [((), 0), ((_contact("left_toe", 1.0, 2.0),), 1)])
def test_too_few_footplants_are_an_error_with_a_remedy(contacts: tuple[Annotation, ...], count: int) -> None:
    message = rf"found {count} footplants? in 3.0 s, expected 2 or more; the ground .* cut by fixed length instead"
    with pytest.raises(RequestError, match=message):
        footplant_cuts(walk(3.0), contacts)
