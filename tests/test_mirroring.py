"""Mirroring against reflected positions, on bodies whose joints' axes were turned at will."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.formats import deepmimic, load
from kinetograph.kinematics import end_positions, joint_positions, role_positions
from kinetograph.mirroring import mirror, mirror_plan
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark, Skeleton

_REFLECT = np.array([-1.0, 1.0, 1.0])

_Row = tuple[str, str, tuple[float, float, float]]
_TRUNK: list[_Row] = [("hips", "", (0, 0, 0)), ("spine", "hips", (0, 0.2, 0.02)), ("chest", "spine", (0, 0.25, -0.03))]
_HEAD: list[_Row] = [("neck", "chest", (0, 0.2, 0)), ("head", "neck", (0, 0.1, 0.03))]
_LIMBS: list[_Row] = [  # of the left side, facing +z
    *(("hip", "hips", (0.09, -0.05, 0.01)), ("knee", "hip", (0.01, -0.4, 0.01))),
    *(("ankle", "knee", (-0.01, -0.4, -0.02)), ("toe", "ankle", (0.02, -0.06, 0.13))),
    *(("collar", "chest", (0.03, 0.15, 0.01)), ("shoulder", "collar", (0.15, 0.01, 0))),
    *(("elbow", "shoulder", (0.28, -0.01, 0)), ("wrist", "elbow", (0.25, 0, 0.02))),
    *(("thumb", "wrist", (0.02, -0.01, 0.04)), ("finger", "wrist", (0.09, 0, 0.02)), ("tip", "finger", (0.03, 0, 0))),
]


def _body() -> Skeleton:
    sided = {name for name, *_ in _LIMBS}
    rows = [*_TRUNK, *_HEAD]
    for side, sign in (("right", -1), ("left", 1)):
        for name, parent, (x, y, z) in _LIMBS:
            rows.append((f"{side}_{name}", f"{side}_{parent}" if parent in sided else parent, (sign * x, y, z)))
    names = [name for name, *_ in rows]
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _ in rows])
    ends = [names.index("head"), names.index("left_tip"), names.index("right_tip")]
    return Skeleton(
        tuple(names),
        parents,
        np.array([offset for *_, offset in rows], dtype=float),
        np.array(ends),
        np.array([[0, 0.15, 0.02], [0.02, 0.01, 0], [-0.02, 0.01, 0]]),
    )


def _turned_frames(skeleton: Skeleton, rng: np.random.Generator) -> Skeleton:
    """The same body with the axes of every joint turned by a random rotation of its own."""
    turns = rot.normalize(rng.normal(size=(len(skeleton), 4)))
    offsets = rot.rotate(rot.conjugate(turns[skeleton.parents]), skeleton.offsets)
    ends = rot.rotate(rot.conjugate(turns[skeleton.end_parents]), skeleton.end_offsets)
    return Skeleton(skeleton.names, skeleton.parents, offsets, skeleton.end_parents, ends)


def _random_motion(skeleton: Skeleton, rng: np.random.Generator, frames: int = 5) -> Motion:
    rotations = rot.normalize(rng.normal(size=(frames, len(skeleton), 4)))
    return Motion(skeleton, rng.normal(size=(frames, 3)), rotations, 30.0)


def _partners_by_name(skeleton: Skeleton) -> IntArray:
    swap = {"left": "right", "right": "left"}
    words = [name.split("_", 1) for name in skeleton.names]
    return np.array([skeleton.index("_".join([swap.get(first, first), *rest])) for first, *rest in words])


def _off_reflection(motion: Motion) -> float:
    """How far the joints of the mirrored motion are from the reflected positions of their partners."""
    expected = joint_positions(motion)[:, mirror_plan(motion.skeleton).partners] * _REFLECT
    return float(np.abs(joint_positions(mirror(motion)) - expected).max())


def _same_turn(a: FloatArray, b: FloatArray) -> float:
    return float(rot.angle_between(a, b).max())


def test_a_body_with_world_axes_swaps_sides_and_flips_the_signs() -> None:
    motion = _random_motion(_body(), np.random.default_rng(0))
    plan = mirror_plan(motion.skeleton)
    assert np.array_equal(plan.partners, _partners_by_name(motion.skeleton))
    expected = (motion.rotations * np.array([1.0, 1, -1, -1]))[:, plan.partners]
    assert np.array_equal(plan.apply(motion).rotations, expected)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_positions_are_reflected_whatever_the_axes_of_the_joints(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion = _random_motion(_turned_frames(_body(), rng), rng)
    partners = _partners_by_name(motion.skeleton)
    mirrored = mirror(motion)
    expected = joint_positions(motion)[:, partners] * _REFLECT
    np.testing.assert_allclose(joint_positions(mirrored), expected, atol=1e-9)
    np.testing.assert_allclose(end_positions(mirrored), end_positions(motion)[:, [0, 2, 1]] * _REFLECT, atol=1e-9)


@given(seed=st.integers(0, 2**32 - 1), turned=st.booleans())
@settings(max_examples=30)
def test_mirroring_twice_gives_the_motion_back(seed: int, turned: bool) -> None:
    rng = np.random.default_rng(seed)
    motion = _random_motion(_turned_frames(_body(), rng) if turned else _body(), rng)
    twice = mirror(mirror(motion))
    assert np.array_equal(twice.translation, motion.translation)
    if turned:
        assert _same_turn(twice.rotations, motion.rotations) < 1e-7
    else:
        assert np.array_equal(twice.rotations, motion.rotations)


def test_deepmimic_is_symmetric_in_z_at_rest_and_still_reflected_in_x() -> None:
    motion = _random_motion(deepmimic.skeleton(), np.random.default_rng(1))
    mirrored = mirror(motion)
    roles = ["head", "left_hand", "left_foot", "left_toe", "left_knee"]
    others = ["head", "right_hand", "right_foot", "right_toe", "right_knee"]
    np.testing.assert_allclose(role_positions(mirrored, others), role_positions(motion, roles) * _REFLECT, atol=1e-9)


def test_a_hinge_stays_a_hinge() -> None:
    skeleton = deepmimic.skeleton()
    motion = Motion(skeleton, np.zeros((1, 3)), rot.identity(1, 15), 30.0)
    motion.rotations[0, skeleton.index("left_knee")] = rot.about("z", -0.7)
    mirrored = mirror(motion).rotations[0, skeleton.index("right_knee")]
    assert _same_turn(mirrored, rot.about("z", -0.7)) < 1e-9


def test_a_mirrored_body_faces_the_mirrored_way() -> None:
    skeleton = deepmimic.skeleton()
    motion = Motion(skeleton, np.zeros((1, 3)), rot.identity(1, 15), 30.0)
    toes, ankles = (role_positions(mirror(motion), [f"left_{part}"])[0, 0] for part in ("toe", "foot"))
    assert (toes - ankles)[0] == pytest.approx(-0.1335)


def test_a_side_turned_round_is_told_by_its_fingers() -> None:
    body = _body()
    offsets, ends = body.offsets.copy(), body.end_offsets.copy()
    hand = [body.index(f"right_{name}") for name in ("thumb", "finger")]
    offsets[hand] = -offsets[[body.index(f"left_{name}") for name in ("thumb", "finger")]]
    turned = Skeleton(body.names, body.parents, offsets, body.end_parents, ends)
    plan = mirror_plan(turned)
    for name in ("left_wrist", "right_wrist"):
        np.testing.assert_array_equal(plan.reflections[turned.index(name)], -np.eye(3))


def test_unlike_sides_keep_their_own_bones_and_plain_axes() -> None:
    body = _body()
    rng = np.random.default_rng(2)
    unlike = Skeleton(body.names, body.parents, body.offsets + rng.normal(scale=0.002, size=body.offsets.shape))
    motion = _random_motion(unlike, rng)
    assert np.array_equal(mirror(mirror(motion)).rotations, motion.rotations)
    assert _off_reflection(motion) < 0.05


def test_bones_that_change_keep_their_side_of_an_unlike_body() -> None:
    rng = np.random.default_rng(3)
    skeleton = _turned_frames(_body(), rng)
    still = _random_motion(skeleton, rng)
    bones = np.broadcast_to(skeleton.offsets, (5, len(skeleton), 3)) * rng.uniform(0.8, 1.2, (5, len(skeleton), 1))
    motion = Motion(skeleton, still.translation, still.rotations, 30.0, bones)
    assert _off_reflection(motion) < 1e-9
    twice = mirror(mirror(motion)).bones
    assert twice is not None
    np.testing.assert_allclose(twice[:, 1:], bones[:, 1:], atol=1e-12)


def test_a_prop_in_one_hand_keeps_its_rotations() -> None:
    body = _body()
    hand = body.index("right_wrist")
    armed = Skeleton((*body.names, "racket"), np.append(body.parents, hand), np.vstack([body.offsets, [[0, 0.1, 0]]]))
    motion = _random_motion(armed, np.random.default_rng(4))
    mirrored = mirror(motion)
    assert np.array_equal(mirrored.rotations[:, -1], motion.rotations[:, -1])
    assert np.array_equal(mirror(mirrored).rotations, motion.rotations)


def test_roles_pair_joints_whose_names_say_nothing() -> None:
    body = _body()
    roles = {
        f"{side}_{role}": Landmark(body.index(f"{side}_{joint}"))
        for side in ("left", "right")
        for role, joint in (("hip", "hip"), ("knee", "knee"), ("foot", "ankle"), ("toe", "toe"), ("collar", "collar"))
    }
    names = tuple(f"joint_{i}" for i in range(len(body)))
    anonymous = Skeleton(names, body.parents, body.offsets, body.end_parents, body.end_offsets, roles)
    assert np.array_equal(mirror_plan(anonymous).partners, _partners_by_name(body))


def test_a_left_joint_without_a_partner_is_an_error() -> None:
    skeleton = Skeleton(("hips", "left_leg", "right_leg", "left_sword"), np.array([-1, 0, 0, 1]), np.ones((4, 3)))
    with pytest.raises(RequestError, match=r"expected a right partner of the left joint 'left_sword'"):
        mirror_plan(skeleton)


def test_partners_in_different_places_are_an_error() -> None:
    skeleton = Skeleton(("hips", "left_leg", "right_leg", "tail"), np.array([-1, 0, 1, 0]), np.ones((4, 3)))
    with pytest.raises(RequestError, match=r"'left_leg', 'right_leg' hangs elsewhere"):
        mirror_plan(skeleton)


def test_a_plan_is_for_its_own_skeleton() -> None:
    motion = _random_motion(deepmimic.skeleton(), np.random.default_rng(5))
    with pytest.raises(RequestError, match="other joints"):
        mirror_plan(_body()).apply(motion)


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        ("walks/15_01.bvh", 0.06),
        ("salsa/Easy_01_leader.bvh", 1e-3),
        ("sports/006_15_cmu60.bvh", 0.03),
        ("sensors/neura/S02-Trial-Walk-1.bvh", 1e-6),
        ("walks/humanoid3d_long_walk3.txt", 1e-9),
    ],
)
def test_recordings_are_reflected(data_folder: Path, name: str, tolerance: float) -> None:
    if not (data_folder / name).exists():
        pytest.skip(f"no {name} in the recordings")
    motion = load(data_folder / name).motion()
    expected = joint_positions(motion) * _REFLECT
    plan = mirror_plan(motion.skeleton)
    mirrored = joint_positions(plan.apply(motion))
    paired = (plan.partners != np.arange(len(plan.partners))) | (
        plan.partners[motion.skeleton.parents] == motion.skeleton.parents
    )
    off = np.linalg.norm(mirrored - expected[:, plan.partners], axis=-1)[:, paired]
    assert off.max() < tolerance
    assert _same_turn(mirror(mirror(motion)).rotations, motion.rotations) < 1e-7
