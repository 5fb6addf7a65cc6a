"""Toes that a blend has lowered are lifted to where toes are; recordings are left as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.post.clearance import SPEEDS, clearance_of, lift
from kinetograph.post.footskate import lift_toes
from kinetograph.skeleton import Skeleton
from walkers import walk

_FPS = 60.0


def _toes(motion: Motion) -> np.ndarray:
    return role_positions(motion, ("left_toe", "right_toe"))


def test_the_faster_toes_are_the_higher_they_are() -> None:
    heights = clearance_of([walk(6.0, fps=_FPS)])
    assert heights.shape == SPEEDS.shape
    assert (np.diff(heights) >= 0).all()
    assert heights[0] == 0.0
    assert heights[-1] > 0.01


def test_a_recording_is_hardly_lifted() -> None:
    motion = walk(6.0, fps=_FPS)
    clearance = clearance_of([motion])
    for i in (0, 1):
        assert lift(_toes(motion)[:, i], clearance, _FPS).max() < 0.004


def test_toes_that_sweep_the_floor_are_lifted_and_stay_where_they_are_along_it() -> None:
    motion = walk(6.0, fps=_FPS)
    clearance = clearance_of([motion])
    flat = replace(motion, translation=motion.translation.copy())
    places = _toes(motion)[:, 0].copy()
    places[:, 1] = np.median(places[:, 1])
    swept = lift(places, clearance, _FPS)
    speed = np.linalg.norm(np.gradient(places[:, [0, 2]], axis=0), axis=1) * _FPS
    assert swept[speed > 2.2].min() > 0.7 * clearance[-1]
    assert swept[speed < 0.05].mean() < 0.1 * clearance[-1]
    higher = lift_toes(flat, clearance + 0.03 * (SPEEDS > 0.5))
    rise = _toes(higher) - _toes(flat)
    assert rise[..., 1].max() > 0.005
    assert np.abs(rise[..., [0, 2]]).max() < 1e-3


def test_skeletons_without_toes_are_left_alone() -> None:
    motion = walk(1.0)
    roles = {role: place for role, place in motion.skeleton.roles.items() if not role.endswith("toe")}
    skeleton = motion.skeleton
    bare = replace(motion, skeleton=Skeleton(skeleton.names, skeleton.parents, skeleton.offsets, roles=roles))
    assert clearance_of([bare]).tolist() == [0.0] * len(SPEEDS)
    assert lift_toes(bare, np.full(len(SPEEDS), 0.1)) is bare
