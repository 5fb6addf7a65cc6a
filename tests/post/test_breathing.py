from __future__ import annotations

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.kinematics import forward, joint_positions
from kinetograph.motion import Motion
from kinetograph.post.breathing import PERIOD, SWAY, breathe
from kinetograph.skeleton import Landmark, Skeleton
from walkers import walk

_FPS = 120.0


def _standing(seconds: float = 12.0) -> Motion:
    """Somebody who stands and faces a quarter to the left; each joint but the hips a little rotated."""
    names = ("hips", "left_hip", "right_hip", "spine", "chest", "head", "left_hand")
    parents = np.array([-1, 0, 0, 0, 3, 4, 4])
    offsets = np.array([[0, 0, 0], [0.1, 0, 0], [-0.1, 0, 0], [0, 0.2, 0], [0, 0.2, 0], [0, 0.3, 0], [0.2, -0.3, 0]])
    roles = {name: Landmark(i) for i, name in enumerate(names) if name != "spine"}
    skeleton = Skeleton(names, parents, offsets.astype(float), roles=roles)
    frames = round(seconds * _FPS) + 1
    pose = rot.exp(0.1 * np.random.default_rng(0).normal(size=(7, 3)))
    pose[0] = rot.about("y", np.pi / 4)
    return Motion(skeleton, np.tile([0.0, 1.0, 0.0], (frames, 1)), np.tile(pose, (frames, 1, 1)), _FPS)


def test_the_chest_sways_once_a_breath_and_nothing_below_it_moves() -> None:
    motion = _standing()
    result = breathe(motion, [(0.0, 12.0)])
    moved = np.linalg.norm(joint_positions(result) - joint_positions(motion), axis=-1)
    assert moved[:, :5].max() < 1e-12
    top = moved[:, 5]
    peaks = np.flatnonzero((top[1:-1] > top[:-2]) & (top[1:-1] >= top[2:])) + 1
    np.testing.assert_allclose(peaks / _FPS, PERIOD * (np.arange(3) + 0.5), atol=0.02)
    assert top.max() == pytest.approx(0.3 * 2 * np.sin(SWAY / 2), rel=0.02)  # 0.3 m above the chest, a little tilted


def test_the_chest_goes_back_and_the_head_stays_upright() -> None:
    motion = _standing()
    result = breathe(motion, [(0.0, 12.0)])
    forwards = np.array([np.sin(np.pi / 4), 0.0, np.cos(np.pi / 4)])
    away = (joint_positions(result) - joint_positions(motion))[round(2 * _FPS), 5]
    assert away @ forwards < -0.9 * np.linalg.norm(away)
    np.testing.assert_allclose(forward(result)[1][:, 5], forward(motion)[1][:, 5], atol=1e-12)


def test_nothing_jumps_where_it_begins_and_ends() -> None:
    motion = _standing()
    result = breathe(motion, [(2.0, 9.3)])
    head = joint_positions(result)[:, 5]
    times = np.arange(len(head)) / _FPS
    outside = (times < 2.0) | (times > 9.3)
    np.testing.assert_allclose(head[outside], joint_positions(motion)[outside, 5], atol=1e-12)
    jerk = np.linalg.norm(np.diff(head, 3, axis=0), axis=-1) * _FPS**3
    assert jerk.max() < 1.0  # a jump in acceleration of 0.01 m/s^2 would be one of 1.2


def test_what_cannot_breathe_or_is_not_held_stays_as_it_is() -> None:
    motion = _standing(2.0)
    assert breathe(motion, []) is motion
    figure = walk(2.0)
    assert "chest" not in figure.skeleton.roles
    assert breathe(figure, [(0.0, 2.0)]) is figure
