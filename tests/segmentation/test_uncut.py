"""Why recordings have no footplants: walks that are made to have none, each in one respect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.motion import Motion
from kinetograph.segmentation import UncutError, detect_contacts, footplant_cuts
from kinetograph.segmentation.uncut import ELSEWHERE, IN_PLACE, LANDS_ONCE, NO_FEET, NOBODY_STEPS, TOO_SHORT
from walkers import HIP_HEIGHT, stick_figure, walk


def _why(motion: Motion) -> str:
    with pytest.raises(UncutError, match=r"found \d footplants? in .*cut by fixed length") as caught:
        footplant_cuts(motion, detect_contacts(motion))
    return caught.value.why


def _standing(heights: np.ndarray) -> Motion:
    """A body with its legs straight whose hips are at some heights, ``(F,)``."""
    frames = len(heights)
    translation = np.stack([np.zeros(frames), heights, np.zeros(frames)], axis=1)
    return Motion(stick_figure(), translation, rot.identity(frames, 15), 30.0)


def test_a_walk_without_its_path_is_a_clip_in_place() -> None:
    motion = walk(5.0)
    assert _why(replace(motion, translation=motion.translation * [0.0, 1.0, 0.0])) == IN_PLACE


def test_somebody_who_stands_steps_nowhere() -> None:
    assert _why(_standing(np.full(150, HIP_HEIGHT))) == NOBODY_STEPS


def test_somebody_who_jumps_on_the_spot_lands_once() -> None:
    time = np.arange(90) / 30
    assert _why(_standing(HIP_HEIGHT + np.maximum(0.4 - 4 * (time - 1.5) ** 2, 0.0))) == LANDS_ONCE


def test_half_a_second_is_too_short() -> None:
    assert _why(walk(0.5)) == TOO_SHORT


def test_feet_that_glide_over_no_ground_are_elsewhere() -> None:
    motion = _standing(np.full(150, HIP_HEIGHT))
    assert _why(replace(motion, translation=motion.translation + np.linspace(0, 5, 150)[:, None] * [1, 0, 0])) == (
        ELSEWHERE
    )


def test_a_skeleton_without_feet_is_told() -> None:
    motion = walk(5.0)
    roles = {name: point for name, point in motion.skeleton.roles.items() if not name.endswith(("foot", "toe"))}
    assert _why(replace(motion, skeleton=replace(motion.skeleton, roles=roles))) == NO_FEET
