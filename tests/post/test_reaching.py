"""Parts of the body brought to targets: exact where they can be, as near as bones go where not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.kinematics import forward, joint_positions, role_positions
from kinetograph.motion import Motion, cut, headings, place
from kinetograph.post.meet_parts import Room, meet_parts, stand_at
from kinetograph.post.part_targets import PartTarget, are_met, misses, parts_of
from kinetograph.post.reaching import reach_parts
from kinetograph.take import Annotation
from walkers import walk


def target_of(motion: Motion, frame: int, role: str, *, rotated: bool = True) -> PartTarget:
    points, rotations = parts_of(motion, (role,))
    return PartTarget(role, points[frame, 0], rotations[frame, 0] if rotated else None)


def bent(motion: Motion, seed: int = 0) -> Motion:
    """A motion with every joint but the root rotated a little, the same in all frames."""
    rng = np.random.default_rng(seed)
    rotations = motion.rotations.copy()
    change = rot.exp(0.25 * rng.normal(size=(rotations.shape[1] - 1, 3)))
    rotations[:, 1:] = rot.multiply(rotations[:, 1:], change)
    return replace(motion, rotations=rotations)


@pytest.mark.parametrize(
    "roles", [("left_hand",), ("right_foot",), ("left_toe",), ("left_elbow",), ("right_shoulder",)]
)
@pytest.mark.parametrize("seed", range(3))
def test_a_part_of_another_pose_of_the_same_body_is_met(roles: tuple[str, ...], seed: int):
    motion = place(walk(2.0), 0.7, (3.0, 0.0, -1.0))
    posed = bent(motion, seed)
    targets = [target_of(posed, 20, role) for role in roles]
    solved = reach_parts(cut(motion, 10, 40), targets)
    apart, twisted = misses(solved, targets)
    assert are_met(apart, twisted).all(), (apart.max(), np.degrees(twisted.max()))
    bones = np.linalg.norm(joint_positions(solved) - joint_positions(solved)[:, solved.skeleton.parents], axis=-1)
    assert bones[:, 1:] == pytest.approx(np.linalg.norm(solved.skeleton.offsets[1:], axis=1)[None].repeat(30, 0))
    assert solved.translation[:, [0, 2]] == pytest.approx(cut(motion, 10, 40).translation[:, [0, 2]])
    assert headings(solved) == pytest.approx(headings(cut(motion, 10, 40)))


def test_what_is_out_of_reach_is_missed_by_what_the_bones_lack():
    motion = cut(walk(1.0), 5, 6)
    (shoulder,) = role_positions(motion, ("left_shoulder",))[0] - [
        motion.translation[0, 0],
        0.0,
        motion.translation[0, 2],
    ]
    far = PartTarget("left_hand", shoulder + np.array([1.0, 0.0, 0.0]))
    apart, _ = misses(reach_parts(motion, [far]), [far])
    assert apart[0, 0] < 0.45 + 1e-6  # the arm is 0.55 m long: all of it points there, but for its last bend
    near = PartTarget("left_hand", shoulder + np.array([0.5, 0.0, 0.0]))
    assert misses(reach_parts(motion, [near]), [near])[0].max() < 1e-4


def test_an_edit_fades_and_leaves_feet_and_other_keys_alone():
    motion = walk(4.0)
    contacts = (
        Annotation("motion", "contact", "left_foot", 1.8, 2.2),
        Annotation("motion", "contact", "left_toe", 1.8, 2.2),
    )
    target = target_of(bent(motion, 1), 60, "left_hand")
    met = meet_parts(motion, Room(60, 30, 90), [target], contacts, 0.5)
    assert misses(cut(met, 60, 61), [target])[0].max() < 1e-4
    legs = [
        met.skeleton.index(f"{side}_{part}") for side in ("left", "right") for part in ("hip", "knee", "foot", "toe")
    ]
    assert joint_positions(met)[:, legs] == pytest.approx(joint_positions(motion)[:, legs], abs=1e-9)
    assert np.array_equal(met.rotations[:31], motion.rotations[:31])
    assert np.array_equal(met.rotations[90:], motion.rotations[90:])
    change = np.linalg.norm(np.diff(joint_positions(met) - joint_positions(motion), n=2, axis=0), axis=-1) * 30**2
    assert change.max() < 25.0  # the recordings' own go up to 50


def test_a_planted_foot_that_is_moved_stands_where_it_is_moved_to():
    motion = walk(4.0)  # the left foot is planted from 2.0 to 2.6 s
    contacts = tuple(Annotation("motion", "contact", f"left_{part}", 2.0, 2.6) for part in ("foot", "toe"))
    points, _ = parts_of(motion, ("left_foot",))
    target = PartTarget("left_foot", points[69, 0] + np.array([0.08, 0.0, 0.0]))
    met = meet_parts(motion, Room(69, 0, 120), [target], contacts, 0.5)
    foot = role_positions(met, ("left_foot",))[61:78, 0]
    assert misses(cut(met, 69, 70), [target])[0].max() < 1e-4
    assert np.linalg.norm(foot - foot[0], axis=1).max() < 2e-3
    assert np.array_equal(met.rotations[0], motion.rotations[0])


def test_feet_stand_where_a_pose_has_them_and_do_not_jump_where_two_poses_disagree():
    motion = walk(4.0)
    contacts = tuple(Annotation("motion", "contact", f"left_{part}", 0.0, 4.0) for part in ("foot", "toe"))
    (pose,) = (cut(place(motion, 0.0, (0.05, 0.0, 0.0)), 60, 61),)
    moved = stand_at(motion, Room(60, 0, 120), pose, contacts, 0.2)
    step = np.diff(role_positions(moved, ("left_foot",))[:, 0] - role_positions(motion, ("left_foot",))[:, 0], axis=0)
    assert np.abs(step).max() < 0.01  # 5 cm over a second, not from one frame to the next
    _, world = forward(moved)
    foot = motion.skeleton.index("left_foot")
    assert rot.angle_between(world[:, foot], forward(motion)[1][:, foot]).max() < 1e-6
