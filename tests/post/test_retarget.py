"""Retargeting: the same body, an A pose, other axes and sizes, there and back, feet that stay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bodies import BONES
from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import load
from kinetograph.kinematics import forward, joint_positions, role_positions
from kinetograph.motion import Motion, cut
from kinetograph.post.footskate import move_foot
from kinetograph.post.joint_tables import joint_table, parse_table
from kinetograph.post.rest_pose import ankle_height, body_axes, leg_length, role_places
from kinetograph.post.retargeting import retarget
from kinetograph.roles import with_found_roles
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation
from walkers import stick_figure


def person(droop: float = 0.0, size: float = 1.0, turn: float = 0.0, legs: float = 1.0) -> Skeleton:
    """A person; droop: degrees by which the arms hang, size: of all bones, turn: degrees of heading at rest."""
    names = [name for name, _, _ in BONES]
    offsets = np.array([offset for _, _, offset in BONES], dtype=np.float64) * size
    for i, name in enumerate(names):
        if name.endswith(("ForeArm", "Hand")):
            way = -droop if name.startswith("Left") else droop
            offsets[i] = rot.rotate(rot.about("z", np.radians(way)), offsets[i])
        if name.endswith(("Leg", "Foot")) and "Up" not in name:
            offsets[i] *= legs
    offsets = rot.rotate(rot.about("y", np.radians(turn)), offsets)
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _ in BONES])
    return with_found_roles(Skeleton(tuple(names), parents, offsets))


def walk(skeleton: Skeleton, frames: int = 60) -> Motion:
    """Something like a walk: bent knees that swing, arms that hang."""
    t = np.arange(frames) / 30.0
    turns = rot.identity(frames, len(skeleton))
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        swing = 0.4 * sign * np.sin(2 * np.pi * t)
        turns[:, skeleton.index(f"{side}UpLeg")] = rot.about("x", swing - 0.5)
        turns[:, skeleton.index(f"{side}Leg")] = rot.about("x", 1.0 + 0.2 * np.cos(2 * np.pi * t))
        turns[:, skeleton.index(f"{side}Arm")] = rot.about("z", -sign * (1.2 + 0.1 * np.sin(t)))
    turns[:, 0] = rot.about("y", 0.3 * t)
    way = np.column_stack([0.2 * t, np.full(frames, 0.88), 1.2 * t])
    return Motion(skeleton, way, turns, 30.0)


def test_onto_itself_nothing_changes() -> None:
    motion = walk(person())
    same = retarget(motion, motion.skeleton)
    np.testing.assert_allclose(joint_positions(same.motion), joint_positions(motion), atol=1e-9)
    assert same.scale == pytest.approx(1.0)
    assert same.table.rest == ()


def test_a_body_half_as_large_walks_half_as_far() -> None:
    motion = walk(person())
    small = retarget(motion, person(size=0.5))
    np.testing.assert_allclose(joint_positions(small.motion), 0.5 * joint_positions(motion), atol=1e-9)
    assert small.scale == pytest.approx(0.5)
    given = retarget(motion, person(size=0.5), scale=1.0)
    np.testing.assert_allclose(given.motion.translation[:, [0, 2]], motion.translation[:, [0, 2]], atol=1e-9)


def test_an_a_pose_and_another_heading_at_rest_show_the_same_poses() -> None:
    motion = walk(person())
    for other in (person(droop=45), person(turn=90), person(droop=30, turn=-90)):
        done = retarget(motion, other).motion
        np.testing.assert_allclose(joint_positions(done), joint_positions(motion), atol=1e-9)


@pytest.mark.parametrize("other", [person(droop=40, size=1.2), person(turn=90, legs=1.1), person(legs=0.85)])
def test_there_and_back_is_the_pose_within_a_degree(other: Skeleton) -> None:
    motion = walk(person())
    back = retarget(retarget(motion, other).motion, motion.skeleton).motion
    assert np.degrees(rot.angle_between(forward(back)[1], forward(motion)[1])).max() < 1.0
    np.testing.assert_allclose(joint_positions(back), joint_positions(motion), atol=0.005)


def test_straight_legs_stay_straight_there_and_back() -> None:
    motion = walk(person())
    turns = motion.rotations.copy()
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        swing = 0.3 * sign * np.sin(2 * np.pi * np.arange(len(motion)) / 30.0)
        turns[:, motion.skeleton.index(f"{side}UpLeg")] = rot.about("x", swing)
        turns[:, motion.skeleton.index(f"{side}Leg")] = rot.about("x", np.radians(3.0) * (1 - sign * np.sign(swing)))
    motion = replace(motion, rotations=turns)
    wide = person()
    wide = replace(wide, offsets=wide.offsets * np.where([[n.endswith("UpLeg")] for n in wide.names], [1.3, 1, 1], 1.0))
    there = retarget(motion, wide).motion
    back = retarget(there, motion.skeleton).motion
    assert np.degrees(rot.angle_between(forward(back)[1], forward(motion)[1])).max() < 1.0
    for role in ("left_foot", "right_foot"):
        apart = role_positions(there, [role]) - role_positions(motion, [role])
        assert np.linalg.norm(apart, axis=-1).max() < 0.002


def test_feet_that_stand_still_stay_where_they_are() -> None:
    motion = walk(person())
    ankle = motion.skeleton.landmark("left_foot").joint
    places = joint_positions(motion)[:, ankle]
    held = np.arange(len(motion))[:, None] < 30
    planted = move_foot(motion, "left", np.where(held, places[8] - places, 0.0), gently=False)
    slid = np.ptp(joint_positions(planted)[5:12, ankle], axis=0).max()
    other = retarget(planted, person(legs=1.15, droop=20)).motion
    there = np.ptp(joint_positions(other)[5:12, other.skeleton.landmark("left_foot").joint], axis=0).max()
    assert slid < 1e-6
    assert there < 1e-3


def test_hands_that_are_held_are_where_they_were() -> None:
    motion = walk(person())
    hold = (Annotation("motion", "handhold", "left_hand", 0.5, 1.5),)
    other = person(droop=20)
    other = replace(other, offsets=np.where([[n == "LeftForeArm"] for n in other.names], 1.1, 1.0) * other.offsets)
    hand, there = motion.skeleton.landmark("left_hand").joint, other.landmark("left_hand").joint
    held = retarget(motion, other, scale=1.0, handholds=hold).motion
    free = retarget(motion, other, scale=1.0).motion
    gap = np.linalg.norm(joint_positions(held)[:, there] - joint_positions(motion)[:, hand], axis=1)
    assert gap[15:46].max() < 1e-6
    assert np.linalg.norm(joint_positions(free)[:, there] - joint_positions(motion)[:, hand], axis=1).min() > 0.02
    np.testing.assert_allclose(held.rotations[:7], free.rotations[:7], atol=1e-12)
    assert np.abs(np.diff(gap)).max() < 0.01  # comes and goes smoothly


def test_the_table_is_printed_edited_and_read_again() -> None:
    a, b = person(), person(size=1.1)
    b = with_found_roles(replace(b, names=tuple("Tail" if n == "RightToe" else n for n in b.names)))
    table = joint_table(a, b)
    text = str(table)
    assert text.startswith("# target\tsource\twhy\nHips\tHips\thips\n")
    assert parse_table(text).pairs == table.pairs
    edited = parse_table(text.replace("LeftHand\tLeftHand", "LeftHand\t-"))
    assert "LeftHand" in edited.rest
    done = retarget(walk(a), b, table=edited).motion
    np.testing.assert_allclose(done.rotations[:, b.index("LeftHand"), 0], 1.0)
    with pytest.raises(FormatError, match=r"joint table:2: target joint 'a' occurs twice"):
        parse_table("a b\na c\n")
    with pytest.raises(RequestError, match="no joint 'Wing'"):
        retarget(walk(a), b, table=parse_table("Hips\tWing\n"))


def test_a_body_without_legs_is_refused() -> None:
    stick = Skeleton(("a", "b"), np.array([-1, 0]), np.array([[0.0, 0, 0], [0, 1, 0]]))
    with pytest.raises(RequestError, match="the target has no hips, left_hip, right_hip; name them with --role"):
        retarget(walk(person()), stick)
    with pytest.raises(RequestError, match="must be a positive number, found 0"):
        retarget(walk(person()), person(), scale=0.0)


def test_what_a_rest_pose_says() -> None:
    np.testing.assert_allclose(body_axes(person()), np.eye(3), atol=1e-12)
    np.testing.assert_allclose(body_axes(person(turn=90))[2], [1, 0, 0], atol=1e-12)
    assert leg_length(person()) == pytest.approx(0.82)
    assert ankle_height(person()) == pytest.approx(0.06)


def test_real_bodies_there_and_back(data_folder: Path) -> None:
    a = cut(load(sorted((data_folder / "walks").glob("15_*.bvh"))[0]).motion(), 0, 300)
    b = load(data_folder / "salsa" / "Easy_01_leader.bvh").motion().skeleton
    there = retarget(a, b)
    back = retarget(there.motion, a.skeleton)
    pairs = [a.skeleton.index(s) for t, s in there.table.pairs.items() if back.table.pairs.get(s) == t]
    error = np.degrees(rot.angle_between(forward(a)[1][:, pairs], forward(back.motion)[1][:, pairs]))
    assert len(pairs) > 18
    assert error.max() < 1.0


def test_what_a_rest_pose_says_is_worked_out_once_and_cannot_be_spoiled() -> None:
    skeleton = stick_figure()
    places, axes = role_places(skeleton), body_axes(skeleton)
    places.clear()
    axes[:] = 0.0
    assert np.allclose(body_axes(skeleton), np.eye(3))
    assert role_places(skeleton)["left_knee"].shape == (3,)
    assert leg_length(stick_figure(2.0)) == pytest.approx(2.0 * leg_length(skeleton))
