from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.kinematics import (
    angular_velocities,
    end_positions,
    forward,
    joint_positions,
    landmark_positions,
    on_ground,
    role_positions,
    velocities,
)
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark, Skeleton
from walkers import stick_figure, walk

_ARM = Skeleton(
    ("shoulder", "elbow", "wrist"),
    np.array([-1, 0, 1]),
    np.array([[7.0, 7, 7], [2, 0, 0], [1, 0, 0]]),
    np.array([2]),
    np.array([[0.5, 0, 0]]),
)


def _arm() -> Motion:
    """At rest; then the shoulder turned a quarter about z, and the elbow a quarter about its own y as well."""
    rotations = rot.identity(2, 3)
    rotations[1, 0], rotations[1, 1] = rot.about("z", np.pi / 2), rot.about("y", np.pi / 2)
    return Motion(_ARM, np.array([[0.0, 1, 0], [0, 1, 3]]), rotations, 2.0)


def test_two_bones_by_hand() -> None:
    positions, turns = forward(_arm())
    np.testing.assert_allclose(positions[0], [[0, 1, 0], [2, 1, 0], [3, 1, 0]], atol=1e-12)
    # the upper arm points up; the elbow's own y is then the world's -x, and the forearm turns to -z about it
    np.testing.assert_allclose(positions[1], [[0, 1, 3], [0, 3, 3], [0, 3, 2]], atol=1e-12)
    np.testing.assert_allclose(rot.rotate(turns[1, 2], np.array([0.0, 1, 0])), [-1, 0, 0], atol=1e-12)
    np.testing.assert_array_equal(joint_positions(_arm()), positions)


def test_end_sites_hang_on_their_joints() -> None:
    np.testing.assert_allclose(end_positions(_arm())[:, 0], [[3.5, 1, 0], [0, 3, 1.5]], atol=1e-12)


def test_bones_take_the_place_of_offsets() -> None:
    motion = _arm()
    bones = np.array([[[9, 9, 9], [1, 0, 0], [0, 1, 0]], [[9, 9, 9], [4, 0, 0], [1, 0, 0]]], dtype=np.float64)
    positions = joint_positions(Motion(_ARM, motion.translation, motion.rotations, 2.0, bones))
    np.testing.assert_allclose(positions[0], [[0, 1, 0], [1, 1, 0], [1, 2, 0]], atol=1e-12)
    np.testing.assert_allclose(positions[1], [[0, 1, 3], [0, 5, 3], [0, 5, 2]], atol=1e-12)


def test_landmarks_move_with_their_joint() -> None:
    marks = [Landmark(1, np.array([0.0, 1, 0])), Landmark(0)]
    points = landmark_positions(_arm(), marks)
    np.testing.assert_allclose(points[0], [[2, 2, 0], [0, 1, 0]], atol=1e-12)
    np.testing.assert_allclose(points[1], [[-1, 3, 3], [0, 1, 3]], atol=1e-12)
    assert landmark_positions(_arm(), []).shape == (2, 0, 3)


def test_roles_are_landmarks() -> None:
    motion = walk(0.5)
    joints = [motion.skeleton.index(name) for name in ("left_toe", "hips")]
    np.testing.assert_array_equal(role_positions(motion, ("left_toe", "hips")), joint_positions(motion)[:, joints])
    with pytest.raises(RequestError, match="no joint plays the role 'head'"):
        role_positions(motion, ("head",))


def test_kinematics_agree_with_products_of_matrices() -> None:
    rng = np.random.default_rng(0)
    skeleton = stick_figure()
    motion = Motion(skeleton, rng.normal(size=(1, 3)), rot.normalize(rng.normal(size=(1, 15, 4))), 30.0)
    world = [np.eye(4)] * 15
    for joint in range(15):
        local = np.eye(4)
        local[:3, :3] = Rotation.from_quat(motion.rotations[0, joint, [1, 2, 3, 0]]).as_matrix()
        local[:3, 3] = skeleton.offsets[joint] if joint else motion.translation[0]
        world[joint] = world[skeleton.parents[joint]] @ local if joint else local
    positions, turns = forward(motion)
    np.testing.assert_allclose(positions[0], [m[:3, 3] for m in world], atol=1e-12)
    np.testing.assert_allclose(rot.to_matrix(turns[0]), [m[:3, :3] for m in world], atol=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_points_on_the_ground_lie_below_where_they_were(seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(4, 2, 3))
    ground = on_ground(points)
    np.testing.assert_array_equal(ground[..., [0, 2]], points[..., [0, 2]])
    np.testing.assert_array_equal(ground[..., 1], 0.0)
    np.testing.assert_array_equal(on_ground(ground), ground)
    angle = rot.about("y", 0.7)
    np.testing.assert_allclose(on_ground(rot.rotate(angle, points)), rot.rotate(angle, ground), atol=1e-12)


def test_velocities_are_central_differences() -> None:
    times = np.arange(6) / 10
    positions = np.stack([3 * times, times**2, np.ones(6)], axis=1)
    rates = velocities(positions, 10.0)
    np.testing.assert_allclose(rates[:, 0], 3.0)
    np.testing.assert_allclose(rates[1:-1, 1], 2 * times[1:-1])
    np.testing.assert_allclose(rates[[0, -1], 1], [0.1, 0.9])
    np.testing.assert_allclose(rates[:, 2], 0.0)
    np.testing.assert_array_equal(velocities(positions[:1], 10.0), np.zeros((1, 3)))


def test_angular_velocities_are_in_the_parents_frame() -> None:
    spin = np.array([0.3, -1.0, 2.0])
    start = rot.normalize(np.array([1.0, 2, 3, 4]))
    turns = rot.multiply(rot.exp(np.outer(np.arange(5) / 50, spin)), start)[:, None]
    np.testing.assert_allclose(angular_velocities(turns, 50.0), np.broadcast_to(spin, (5, 1, 3)), atol=1e-9)
    np.testing.assert_allclose(angular_velocities(-turns[::-1], 50.0)[:, 0], [-spin] * 5, atol=1e-9)
    assert angular_velocities(turns[:1], 50.0).shape == (1, 1, 3)
