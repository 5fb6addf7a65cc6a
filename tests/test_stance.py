"""Standing references: nothing depends on how a skeleton is at rest, only on how it moves in the world."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import bodies
from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.cli import app
from kinetograph.errors import RequestError
from kinetograph.formats import ReadOptions, body_capsules, dressed, read, read_character, save
from kinetograph.kinematics import end_positions, forward, joint_positions
from kinetograph.live.sinks.humanoid import Humanoid
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion, headings, transform
from kinetograph.post.retargeting import retarget
from kinetograph.roles import with_found_roles
from kinetograph.skeleton import Skeleton
from kinetograph.stance import find_stance, from_standing, stance_at, stance_frames, standing, stands, to_standing
from rest_poses import along_x, at_random, lying, seated, with_frames

Frames = Callable[[Skeleton], FloatArray]
FALLEN: tuple[Frames, ...] = (along_x, at_random, seated)
"""Rest poses in which nobody stands."""


def person() -> Skeleton:
    """A person at rest in a T pose, feet as most skeletons have them."""
    body = bodies.person()
    offsets = body.offsets.copy()
    for side in ("Left", "Right"):
        offsets[body.index(f"{side}Toe")] = (0.0, -0.05, 0.1335)
    ends = [body.index(name) for name in ("Head", "LeftHand", "RightHand")]
    tips = np.array([[0.0, 0.2, 0.0], [0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]])
    return with_found_roles(replace(body, offsets=offsets, end_parents=np.array(ends), end_offsets=tips))


def stroll(skeleton: Skeleton) -> Motion:
    """A walk on a circle, leaning forward a little, arms that hang, swing and bend, a head that looks around."""
    motion = bodies.walk(skeleton)
    t = np.arange(len(motion)) / motion.fps
    turns = motion.rotations.copy()
    turns[:, 0] = rot.multiply(rot.about("y", 0.5 * t), rot.about("x", 0.06 + 0.03 * np.sin(2 * np.pi * t)))
    turns[:, skeleton.index("Neck")] = rot.about("y", 0.2 * np.sin(3 * t))
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        hangs = rot.about("z", np.full(len(t), -sign * 1.4))
        turns[:, skeleton.index(f"{side}Arm")] = rot.multiply(rot.about("x", 0.3 * sign * np.sin(2 * np.pi * t)), hangs)
        turns[:, skeleton.index(f"{side}ForeArm")] = rot.about("y", -sign * (0.5 + 0.3 * np.sin(2 * np.pi * t)))
    travel = np.stack([np.sin(0.5 * t), 0 * t, np.cos(0.5 * t)], axis=1)
    return replace(motion, translation=motion.translation + travel, rotations=turns)


def found(motion: Motion) -> Motion:
    """A motion with the stance that reading it would find."""
    if stands(motion.skeleton):
        return motion
    stance = find_stance(motion)
    assert stance is not None
    return replace(motion, skeleton=replace(motion.skeleton, stance=stance.rotations))


def furthest(a: Motion, b: Motion) -> float:
    """Metres between joints and end sites of two motions in the world, at most."""
    gaps = [joint_positions(a) - joint_positions(b), end_positions(a) - end_positions(b)]
    return max(float(np.linalg.norm(gap, axis=-1).max(initial=0.0)) for gap in gaps)


def test_who_stands_at_rest_and_who_does_not() -> None:
    motion = stroll(person())
    assert stands(person())
    assert stands(with_frames(motion, lying(person())).skeleton)  # straight, whichever way it lies
    for frames in FALLEN:
        assert not stands(with_frames(motion, frames(person())).skeleton), frames.__name__
    limp = person().offsets.copy()
    limp[person().index("Neck")] *= -1.0
    limp[person().index("Head")] *= -1.0
    assert not stands(replace(person(), offsets=limp))  # a head below the chest


def test_hips_that_are_one_joint_do_not_fell_a_body() -> None:
    offsets = person().offsets.copy()
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        offsets[person().index(f"{side}UpLeg")] = 0.0
        offsets[person().index(f"{side}Leg")] = (0.2 * sign, -0.4, 0.0)
    assert stands(replace(person(), offsets=offsets))


@given(st.integers(0, 1000))
def test_to_a_standing_skeleton_and_back_nothing_moves(seed: int) -> None:
    motion = stroll(person())
    motion = replace(motion, skeleton=replace(motion.skeleton, stance=at_random(motion.skeleton, seed)))
    there = to_standing(motion)
    assert furthest(there, motion) < 1e-12
    assert there.skeleton is standing(motion.skeleton)
    assert there.skeleton.stance is None
    back = from_standing(there, motion.skeleton)
    np.testing.assert_allclose(back.rotations, motion.rotations, atol=1e-12)
    pose = Motion(motion.skeleton, np.zeros((1, 3)), motion.skeleton.stance[None], 30.0)
    rest = Motion(there.skeleton, np.zeros((1, 3)), rot.identity(1, len(there.skeleton)), 30.0)
    assert furthest(pose, rest) < 1e-12


@pytest.mark.parametrize("frames", FALLEN)
def test_the_stance_is_the_same_whatever_the_rest_pose(frames: Frames) -> None:
    body = person()
    motion = found(with_frames(stroll(body), frames(body)))
    places = joint_positions(Motion(standing(motion.skeleton), np.zeros((1, 3)), rot.identity(1, len(body)), 30.0))[0]
    truth = joint_positions(Motion(body, np.zeros((1, 3)), rot.identity(1, len(body)), 30.0))[0]
    for name in body.names:
        joint = body.index(name)
        if "Arm" in name or "Hand" in name:  # arms hang, where the person's own rest pose is a T
            upper = body.index(f"{'Left' if name.startswith('Left') else 'Right'}Arm")
            down = np.linalg.norm(truth[joint] - truth[upper])
            np.testing.assert_allclose(places[joint], truth[upper] - [0.0, down, 0.0], atol=1e-4, err_msg=name)
        else:
            np.testing.assert_allclose(places[joint], truth[joint], atol=1e-4, err_msg=name)


@pytest.mark.parametrize("frames", [*FALLEN, lying])
def test_retargeting_does_not_depend_on_the_rest_pose(frames: Frames) -> None:
    body = person()
    other = replace(stroll(bodies.person()), skeleton=replace(bodies.person(), offsets=1.2 * bodies.person().offsets))
    motion = stroll(body)
    changed = found(with_frames(motion, frames(body)))
    assert furthest(changed, motion) < 1e-9
    assert furthest(retarget(changed, other.skeleton).motion, retarget(motion, other.skeleton).motion) < 1e-3
    onto = retarget(other, changed.skeleton).motion
    assert onto.skeleton is changed.skeleton  # its own rest pose, not the one that stands
    assert furthest(onto, retarget(other, body).motion) < 1e-3


def test_a_chosen_frame_makes_two_rest_poses_agree_exactly() -> None:
    body, other = person(), bodies.person()
    motion = stroll(body)
    changed = with_frames(motion, at_random(body))
    pair = [replace(m, skeleton=replace(m.skeleton, stance=stance_at(m, 40).rotations)) for m in (motion, changed)]
    assert furthest(*(retarget(m, other).motion for m in pair)) < 1e-9
    assert furthest(*(retarget(stroll(other), m.skeleton).motion for m in pair)) < 1e-9
    with pytest.raises(RequestError, match="--rest 120: expected a frame from 0 to 119"):
        stance_at(motion, 120)


def test_where_nobody_stands_it_is_said_and_the_body_is_stood_up() -> None:
    body = person()
    motion = transform(stroll(body), rot.about("x", -np.pi / 2), (0.0, 0.2, 0.0))
    fallen = with_frames(motion, along_x(body))
    stance = find_stance(fallen)
    assert stance is not None
    assert "no frame stands" in stance.note
    upright = standing(replace(fallen.skeleton, stance=stance.rotations))
    places = joint_positions(Motion(upright, np.zeros((1, 3)), rot.identity(1, len(body)), 30.0))[0]
    assert places[body.index("Head"), 1] > 0.6
    assert places[body.index("LeftFoot"), 1] < -0.7
    assert find_stance(replace(fallen, skeleton=replace(fallen.skeleton, roles={}))) is None


def test_roles_are_found_by_how_a_body_moves() -> None:
    body = person()
    names = tuple(f"b{i}" for i in range(len(body)))
    nameless = with_found_roles(replace(body, names=names, roles={}))
    assert len(nameless.roles) > 15
    for frames in (along_x, at_random):
        motion = with_frames(stroll(body), frames(body))
        skeleton = with_found_roles(replace(motion.skeleton, names=names, roles={}), motion)
        assert {r: p.joint for r, p in skeleton.roles.items()} == {r: p.joint for r, p in nameless.roles.items()}


@pytest.mark.parametrize("frames", FALLEN)
def test_headings_capsules_avatars_and_mirrors_do_not_depend_on_it(frames: Frames) -> None:
    body = person()
    motion = stroll(body)
    changed = found(with_frames(motion, frames(body)))
    np.testing.assert_allclose(headings(changed), headings(motion), atol=1e-6)
    assert furthest(mirror(changed), mirror(motion)) < 1e-6
    own, stood = (Humanoid(m.skeleton).pose(m) for m in (motion, changed))
    np.testing.assert_allclose(stood[0], own[0], atol=2e-3)
    assert np.degrees(rot.angle_between(stood[1], own[1])).max() < 2.0
    ends = [_capsule_ends(m) for m in (changed, to_standing(changed))]
    np.testing.assert_allclose(*ends, atol=1e-9)
    worn, skin = dressed(changed)
    assert 1.5 < np.ptp(skin.points[:, 1]) < 1.9
    assert worn.skeleton.stance is None


def _capsule_ends(motion: Motion) -> FloatArray:
    """Both ends of a motion's capsules in the world."""
    positions, rotations = forward(motion)
    capsules = body_capsules(motion.skeleton)
    joints = [capsule.joint for capsule in capsules]
    ends = np.array([[capsule.start, capsule.stop] for capsule in capsules])
    return positions[:, joints, None] + rot.rotate(rotations[:, joints, None], ends)


def test_reading_finds_a_stance_and_files_keep_their_own_rest_pose(tmp_path: Path) -> None:
    motion = with_frames(stroll(person()), along_x(person()))
    save(motion, tmp_path / "x.bvh")
    loaded = read(tmp_path / "x.bvh")
    assert any("rest pose does not stand" in note and "--rest" in note for note in loaded.notes)
    again = loaded.take.motion()
    assert again.skeleton.stance is not None
    for name in motion.skeleton.names[1:]:
        here, there = (m.skeleton.offsets[m.skeleton.index(name)] for m in (again, motion))
        np.testing.assert_allclose(here, there, atol=1e-5, err_msg=name)
    chosen = read(tmp_path / "x.bvh", ReadOptions(rest=7)).take.motion().skeleton
    assert chosen.stance is not None
    np.testing.assert_allclose(chosen.stance[1:], again.rotations[7, 1:], atol=1e-9)
    save(again, tmp_path / "x.glb")
    stood = read(tmp_path / "x.glb").take.motion()
    assert stood.skeleton.stance is None
    assert stands(stood.skeleton)
    order = [stood.skeleton.index(name) for name in again.skeleton.names]
    assert float(np.abs(joint_positions(stood)[:, order] - joint_positions(again)).max()) < 1e-4
    tall = np.ptp(read_character(tmp_path / "x.glb").skin.points[:, 1])
    assert 1.5 < tall < 1.9


def test_convert_takes_the_frame_that_stands(tmp_path: Path) -> None:
    for name, frames in (("a", rot.identity(len(person()))), ("b", at_random(person()))):
        save(with_frames(stroll(person()), frames), tmp_path / f"{name}.bvh")
    save(stroll(bodies.person()), tmp_path / "target.bvh")
    for name in "ab":
        args = [f"{tmp_path}/{name}.bvh", f"{tmp_path}/{name}.glb", "--retarget", f"{tmp_path}/target.bvh"]
        done = CliRunner().invoke(app, ["convert", *args, "--rest", "40", "--units", "metre", "--up", "y"])
        assert done.exit_code == 0, done.output
    a, b = (read(tmp_path / f"{name}.glb").take.motion() for name in "ab")
    assert furthest(a, b) < 1e-4


@pytest.mark.parametrize("take", ["walks/15_01.bvh", "salsa/Easy_01_leader.bvh", "acclaim/16_12.amc"])
def test_recordings_stand_as_before(take: str, data_folder: Path) -> None:
    if not (data_folder / take).exists():
        pytest.skip(f"no {take}")
    motion = read(data_folder / take).take.motion()
    assert motion.skeleton.stance is None
    changed = found(with_frames(motion, at_random(motion.skeleton)))
    gap = joint_positions(retarget(changed, person()).motion) - joint_positions(retarget(motion, person()).motion)
    # the curve of a real back, and collars over hanging arms, cannot be seen from outside
    assert np.median(np.linalg.norm(gap, axis=-1)) < 0.04
    assert np.linalg.norm(gap, axis=-1).max() < 0.12


def test_bones_that_all_point_up_are_read(data_folder: Path) -> None:
    path = data_folder / "sports" / "006_14_cmu60.bvh"
    if not path.exists():
        pytest.skip("no sports/006_14_cmu60.bvh")
    motion = read(path).take.motion()
    assert motion.skeleton.stance is not None
    out = retarget(motion, person()).motion
    here, there = (
        joint_positions(m)[:, m.skeleton.roles["head"].joint] - m.translation for m in (to_standing(motion), out)
    )
    here, there = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (here, there))
    assert np.degrees(np.arccos(np.clip(np.sum(here * there, axis=1), -1, 1))).max() < 15.0
    assert stance_frames(motion.skeleton).shape == (len(motion.skeleton), 4)
