"""Characters that stand on the floor: skins moved by joints, the floor of a recording, soles, backs and hands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bodies import blocks, person, walk
from kinetograph import rotations as rot
from kinetograph.character import Character, extreme_points, skin_heights
from kinetograph.errors import FetchError
from kinetograph.formats import body_capsules, body_of, capsule_character, load
from kinetograph.kinematics import forward, joint_positions, role_positions
from kinetograph.motion import Motion
from kinetograph.post.retargeting import retarget
from kinetograph.post.soles import floor_height, planted_feet, undersides
from kinetograph.samples import human
from kinetograph.segmentation import detect_contacts


def lowest(motion: Motion, character: Character) -> np.ndarray:
    """Height of the lowest point of a skin in each frame."""
    return skin_heights(motion, character.skin, np.arange(len(character.skin.points))).min(axis=1)


def test_a_skin_is_moved_by_its_joints_by_their_weights() -> None:
    skeleton = person()
    body = blocks(skeleton, 0.1)
    rng = np.random.default_rng(0)
    weights = rng.random((len(body.skin.points), 4))
    weights /= weights.sum(axis=1, keepdims=True)
    joints = rng.integers(0, len(skeleton), weights.shape)
    skin = replace(body.skin, joints=joints, weights=weights)
    motion = walk(skeleton, frames=3)
    turns = rot.normalize(rng.normal(size=motion.rotations.shape))
    motion = replace(motion, rotations=turns)
    still = Motion(skeleton, np.zeros((1, 3)), rot.identity(1, len(skeleton)), 30.0)
    rest = joint_positions(still)[0]
    places, world = forward(motion)
    for frame in range(3):
        for point in range(0, len(skin.points), 17):
            moved = sum(
                weights[point, k] * (places[frame, j] + rot.rotate(world[frame, j], skin.points[point] - rest[j]))
                for k, j in enumerate(joints[point])
            )
            assert skin_heights(motion, skin, np.array([point]))[frame, 0] == pytest.approx(moved[1], abs=1e-12)


def test_extreme_points_hold_the_lowest_of_any_pose() -> None:
    body = blocks(person(), 0.1)
    motion = walk(body.skeleton, frames=40)
    motion = replace(motion, rotations=rot.normalize(np.random.default_rng(1).normal(size=motion.rotations.shape)))
    some = skin_heights(motion, body.skin, extreme_points(body.skin)).min(axis=1)
    np.testing.assert_allclose(some, lowest(motion, body), atol=1e-12)  # a cube has eight corners, all extreme


def test_parts_of_a_body_cover_it() -> None:
    parts = undersides(blocks(person(), 0.1))
    names = [person().names[j] for j in parts.character.skin.joints[parts.feet["left"], 0]]
    assert set(names) == {"LeftFoot", "LeftToe"}
    assert set(parts.hands) == {"left", "right"}
    everything = np.concatenate([*parts.feet.values(), *parts.hands.values(), parts.rest])
    assert len(everything) == len(set(everything.tolist())) == 8 * len(person())


@pytest.mark.parametrize("floor", [0.0, -1.0, 2.0])
def test_the_floor_is_where_feet_are_planted(floor: float) -> None:
    motion = walk(person(), floor)
    assert floor_height(motion) == pytest.approx(floor, abs=0.02)
    assert floor_height(walk(person(), 0.05)) == 0.0  # thick soles


@pytest.mark.parametrize("thick", [0.02, 0.1, 0.16])
@pytest.mark.parametrize("floor", [0.0, -1.0])
def test_soles_of_any_thickness_are_on_the_floor_while_planted(thick: float, floor: float) -> None:
    motion = walk(person(), floor)
    body = blocks(person(), thick)
    done = retarget(motion, body)
    soles = undersides(body).soles(done.motion)
    for side, planted in planted_feet(motion, detect_contacts(motion)).items():
        assert planted.sum() > 30
        assert np.abs(soles[side][planted] - done.floor).max() < 0.01
    assert lowest(done.motion, body).min() > done.floor - 0.015
    plain = retarget(motion, body.skeleton).motion
    assert np.abs(lowest(plain, body) - done.floor).max() > 0.01


def test_who_lies_down_lies_on_the_floor() -> None:
    motion = walk(person())
    turns = motion.rotations.copy()
    turns[:, 0] = rot.about("x", -np.pi / 2)  # on the back
    lying = replace(motion, rotations=turns, translation=np.tile([0.0, 0.05, 0.0], (len(motion), 1)))
    body = blocks(person(), 0.3)
    assert lowest(retarget(lying, body.skeleton).motion, body).min() < -0.1
    assert lowest(retarget(lying, body).motion, body).min() > -0.015


def test_a_step_is_no_floor() -> None:
    motion = walk(person())
    up = 0.3 * (np.arange(len(motion)) >= 60)
    motion = replace(motion, translation=motion.translation + np.outer(up, [0, 1, 0]))
    done = retarget(motion, blocks(person(), 0.06)).motion
    toes = role_positions(done, ("left_toe", "right_toe"))[..., 1].min(axis=1)
    assert toes[:50].max() < 0.1
    assert toes[70:].min() > 0.25


def test_real_walks_on_the_human_body(data_folder: Path) -> None:
    try:
        body = human()
    except FetchError as error:
        pytest.skip(f"no character sample: {error}")
    for path in (sorted((data_folder / "walks").glob("15_*.bvh"))[0], data_folder / "actions" / "140_01.bvh"):
        motion = load(path).motion()
        done = retarget(motion, body).motion
        soles = undersides(body).soles(done)
        for side, planted in planted_feet(motion, detect_contacts(motion)).items():
            assert np.abs(soles[side][planted]).max() < 0.01
        assert lowest(done, body).min() > -0.015


@pytest.mark.parametrize("level", [-0.01, 0.03, 0.08])
def test_capsules_have_their_soles_where_recordings_hold_their_feet(level: float) -> None:
    motion = walk(person(), level - 0.03)
    skin, _ = body_of(motion)
    body = Character("capsules", motion.skeleton, skin)
    soles = undersides(body).soles(motion)
    for side, planted in planted_feet(motion, detect_contacts(motion)).items():
        assert abs(float(np.median(soles[side][planted]))) < 0.003
    foot, heel = (next(c for c in body_capsules(person(), level) if c.part == part) for part in ("foot", "heel"))
    ankle = 0.06 + level  # over the sole
    assert foot.stop[1] - foot.radii[1] == pytest.approx(-ankle)
    assert heel.stop[1] - heel.radii[1] == pytest.approx(-ankle)
    assert heel.stop[2] < 0.0 < foot.stop[2]
    assert foot.start[1] == pytest.approx(max(0.0, foot.radii[0] - ankle))  # at the ankle, if that is no lower


def test_capsules_that_are_stood_on_the_floor_are_written_so() -> None:
    done = retarget(walk(person(), 0.05), capsule_character(person())).motion
    skin, _ = body_of(done)
    np.testing.assert_allclose(skin.points, capsule_character(person()).skin.points, atol=0.003)


def test_a_rest_pose_that_nobody_stands_in_gets_no_heels() -> None:
    names = person().names
    up = np.where([[n.endswith(("UpLeg", "Leg", "Foot", "Toe"))] for n in names], [[0, 1.0, 0]], person().offsets)
    assert not [c for c in body_capsules(replace(person(), offsets=up)) if c.part == "heel"]
