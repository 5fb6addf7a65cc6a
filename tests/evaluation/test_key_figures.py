"""The picture of the keys: bodies seen from their side, whatever way their skeleton faces at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.evaluation.reproduce.molina_tanco2000.figures import seen_from_side
from kinetograph.motion import Motion, cut
from walkers import walk


def rested_elsewhere(motion: Motion, angle: float) -> Motion:
    """The same motion of a skeleton that faces another way at rest, so that its root is rotated otherwise."""
    offsets = rot.rotate(rot.about("y", angle), motion.skeleton.offsets)
    back = rot.about("y", -angle)
    rotations = rot.multiply(rot.multiply(rot.about("y", angle), motion.rotations), back)
    rotations[:, 0] = rot.multiply(motion.rotations[:, 0], back)
    return replace(motion, skeleton=replace(motion.skeleton, offsets=offsets), rotations=rotations)


@pytest.mark.parametrize("angle", [0.0, np.pi / 2, 2.0])
def test_hips_lie_behind_one_another_and_steps_ahead(angle: float) -> None:
    motion = walk(2.0)
    pose = cut(motion, 20, 21)
    points = seen_from_side(rested_elsewhere(pose, angle))
    hips = [pose.skeleton.roles[f"{side}_hip"].joint for side in ("left", "right")]
    feet = [pose.skeleton.roles[f"{side}_foot"].joint for side in ("left", "right")]
    assert abs(points[hips[0], 0] - points[hips[1], 0]) < 1e-6
    assert points == pytest.approx(seen_from_side(pose), abs=1e-6)
    assert np.ptp(points[feet, 0]) > 0.05
    assert points[:, 1].min() == 0.0
