"""Handholds of two dancers whose hands were put where they are."""

from __future__ import annotations

import numpy as np
import pytest

from kinetograph.arrays import BoolArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion, resample
from kinetograph.segmentation import HoldThresholds, detect_handholds
from kinetograph.skeleton import Skeleton
from walkers import slide, walk


def _pair(held: BoolArray) -> tuple[Motion, Motion]:
    """Two walkers side by side, the left hand of the first 0.2 m over the right hand of the second where held."""
    own, partner = walk(4.0), walk(4.0)
    reach = role_positions(partner, ("right_hand",)) - role_positions(own, ("left_hand",)) + [0.0, 0.2, 0.0]
    off = role_positions(own, ("left_hand",)) * 0 + [0.0, 3.0, 0.0]
    path = np.where(held[:, None], _to_parent(own, reach[:, 0]), off[:, 0])
    return slide(own, "left_hand", path), partner


def _to_parent(motion: Motion, world: np.ndarray) -> np.ndarray:
    from kinetograph import rotations as rot
    from kinetograph.kinematics import forward

    return rot.rotate(rot.conjugate(forward(motion)[1][:, motion.skeleton.index("left_elbow")]), world)


def test_a_hold_is_found_with_its_hands_and_times() -> None:
    held = np.zeros(121, dtype=bool)
    held[30:90] = True
    holds = [n for n in detect_handholds(*_pair(held), track="a") if n.label == "left_hand:right_hand"]
    assert [(n.track, n.kind, round(n.start, 3), round(n.stop, 3)) for n in holds] == [("a", "handhold", 1.0, 2.967)]


def test_brief_breaks_are_closed_and_brief_holds_dropped() -> None:
    held = np.zeros(121, dtype=bool)
    held[20:50], held[53:80], held[100:105] = True, True, True
    holds = [n for n in detect_handholds(*_pair(held)) if n.label == "left_hand:right_hand"]
    assert [(round(n.start * 30), round(n.stop * 30)) for n in holds] == [(20, 79)]


def test_hands_must_come_close_to_begin_a_hold() -> None:
    pair = _pair(np.ones(121, dtype=bool))
    assert not [n for n in detect_handholds(*pair, HoldThresholds((0.1, 0.25))) if n.label == "left_hand:right_hand"]


def test_characters_that_cannot_be_compared() -> None:
    with pytest.raises(RequestError, match="handholds need two motions of one rate and length"):
        detect_handholds(walk(2.0), resample(walk(2.0), 60.0))
    bare = walk(2.0)
    skeleton = Skeleton(bare.skeleton.names, bare.skeleton.parents, bare.skeleton.offsets)
    assert detect_handholds(Motion(skeleton, bare.translation, bare.rotations, 30.0), bare) == ()
