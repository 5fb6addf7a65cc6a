"""Stances and transitions of two dancers who were put where they are, turned as they are, hand in hand as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import forward, role_positions
from kinetograph.methods.recordings import mirrored_annotations
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion
from kinetograph.segmentation import Couple, StanceThresholds, find_thresholds, notation, transition_of
from kinetograph.take import Annotation
from walkers import slide, walk

FPS, BEAT, COUNT = 30.0, 0.5, 9
BEATS = tuple(BEAT * i for i in range(COUNT))
TIMES = np.arange(round(BEAT * (COUNT - 1) * FPS) + 1) / FPS


def _dancer(places: FloatArray, headings: FloatArray) -> Motion:
    """A body that stands at ``(COUNT,)`` places on the z axis and has as many headings at the beats, radians."""
    still = walk(TIMES[-1], fps=FPS, speed=0.0)
    rotations = still.rotations.copy()
    rotations[:] = rot.identity(*rotations.shape[:2])
    rotations[:, 0] = rot.about("y", np.interp(TIMES, BEATS, headings))
    translation = still.translation.copy()
    translation[:, 2] = np.interp(TIMES, BEATS, places)
    return replace(still, translation=translation, rotations=rotations)


def _holding(follower: Motion, leader: Motion, hands: dict[str, str], beats: slice) -> Motion:
    """The follower's hands put on the leader's between two beats, and far away from any hand otherwise."""
    held = np.zeros(len(TIMES), dtype=bool)
    held[round(beats.start * BEAT * FPS) : round(beats.stop * BEAT * FPS) + 1] = True
    for own, theirs in hands.items():
        elbow = forward(follower)[1][:, follower.skeleton.index(own.replace("hand", "elbow"))]
        reach = role_positions(leader, (theirs,))[:, 0] - role_positions(follower, (own,))[:, 0]
        over = rot.rotate(rot.conjugate(elbow), reach + np.array([0.0, 0.1, 0.0]))
        path = np.where(held[:, None], over, [0.0, 3.0, 0.0])
        follower = slide(follower, own, path)
    return follower


def _couple(apart: FloatArray, turned: FloatArray, hands: dict[str, str] | None = None) -> tuple[Motion, Motion]:
    leader = _dancer(np.zeros(COUNT), np.zeros(COUNT))
    follower = _dancer(apart, np.pi + turned)
    return leader, _holding(follower, leader, hands or {}, slice(2, 4))


def test_stances_follow_distance_and_facing() -> None:
    apart = np.array([0.4, 0.4, 0.4, 0.4, 0.9, 0.9, 0.9, 0.4, 0.4])
    turned = np.radians([0, 50, 70, 0, 0, 0, 0, 180, 360])
    stances = Couple.of(*_couple(apart, turned), BEATS).stances(StanceThresholds())
    near, far = "closed", "open"
    assert stances == [near, near, far, near, far, far, far, far, near]


@pytest.mark.parametrize(
    ("degrees", "transition"),
    [(0, "step"), (80, "step"), (-80, "step"), (180, "inside turn"), (-180, "outside turn"), (720, "inside turn")],
)
def test_transitions_follow_the_rotation_of_the_follower(degrees: float, transition: str) -> None:
    turned = np.radians(np.array([0, 0, 0, 0, degrees / 2, degrees, degrees, degrees, degrees]))
    names = Couple.of(*_couple(np.full(COUNT, 0.9), turned), BEATS).names(StanceThresholds())
    assert [transition_of(name) for name in names[1::2]] == ["step", transition, "step"]


@pytest.mark.parametrize(
    ("hands", "crosshand"),
    [
        ({"right_hand": "left_hand"}, False),
        ({"left_hand": "right_hand", "right_hand": "left_hand"}, False),
        ({"right_hand": "right_hand"}, True),
        ({"left_hand": "left_hand"}, True),
        ({}, False),
    ],
)
def test_crosshand_is_hands_of_one_side(hands: dict[str, str], crosshand: bool) -> None:
    couple = Couple.of(*_couple(np.full(COUNT, 0.9), np.zeros(COUNT), hands), BEATS)
    expected = np.zeros(COUNT, dtype=bool)
    expected[2:5] = crosshand
    np.testing.assert_array_equal(couple.crosshand, expected)


def test_of_holds_at_once_the_closest_counts() -> None:
    leader, follower = _couple(np.full(COUNT, 0.9), np.zeros(COUNT), {"right_hand": "right_hand"})
    holds = [Annotation("f", "handhold", f"right_hand:{hand}", 1.0, 2.0) for hand in ("left_hand", "right_hand")]
    assert Couple.of(leader, follower, BEATS, holds).crosshand.tolist() == [False, False, *[True] * 3, *[False] * 4]


def test_a_mirror_image_has_the_mirrored_names() -> None:
    turned = np.radians(np.array([0, 0, 0, 90, 180, 180, 180, 270, 360]))
    apart = np.array([0.9, 0.9, 0.9, 0.9, 0.9, 0.4, 0.4, 0.4, 0.4])
    pair = _couple(apart, turned, {"right_hand": "right_hand"})
    names = Couple.of(*pair, BEATS).names(StanceThresholds())
    assert {transition_of(name) for name in names} == {"step", "inside turn"}
    notes = [Annotation("follower", "move", name, 0.0, 1.0) for name in names]
    image = Couple.of(*(mirror(motion) for motion in pair), BEATS).names(StanceThresholds())
    assert image == [note.label for note in mirrored_annotations(notes)]


def test_thresholds_lie_in_the_gaps_of_the_recordings() -> None:
    rng = np.random.default_rng(3)
    distance = np.concatenate([rng.normal(0.42, 0.03, 40), rng.normal(0.85, 0.05, 160)])
    steps = np.concatenate([rng.normal(0, np.radians(15), 150), rng.normal(np.radians(170), np.radians(15), 49)])
    heading = np.concatenate([[0.0], np.cumsum(steps)])
    couple = Couple(np.arange(200.0), distance, np.zeros(200), heading, np.zeros(200, dtype=bool))
    found = find_thresholds([couple], span=1)
    assert found.found == ("distance", "rotation")
    assert 0.5 < found.distance < 0.72
    assert np.radians(60) < found.rotation < np.radians(125)


def test_recordings_without_gaps_keep_the_given_thresholds() -> None:
    rng = np.random.default_rng(4)
    steady = Couple(
        np.arange(100.0), rng.normal(0.85, 0.05, 100), np.zeros(100), rng.normal(0, 0.2, 100), np.zeros(100, dtype=bool)
    )
    given = StanceThresholds(distance=0.5, rotation=2.0)
    assert find_thresholds([steady], thresholds=given) == given


def test_notation_joins_units_at_the_stance_they_share() -> None:
    text = notation(["open step open", "open outside turn closed crosshand", "closed step open", "a lift"])
    assert text == "o\u0305 \u2192 o\u0305 \u21b6 \u25cf\u0332 \u25cf\u0305 \u2192 o\u0305 a lift"
    with pytest.raises(RequestError, match="notation needs a name or more"):
        notation([])
