"""A person of one build, bodies of cubes for it, and a walk on the spot."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.character import Character, Skin
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion
from kinetograph.roles import with_found_roles
from kinetograph.skeleton import Skeleton

BONES: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    ("Hips", "", (0, 0.95, 0)),
    ("Spine", "Hips", (0, 0.15, 0)),
    ("Chest", "Spine", (0, 0.2, 0)),
    ("Neck", "Chest", (0, 0.2, 0)),
    ("Head", "Neck", (0, 0.1, 0)),
    *(
        bone
        for side, s in (("Left", 1), ("Right", -1))
        for bone in (
            (f"{side}Shoulder", "Chest", (0.05 * s, 0.15, 0)),
            (f"{side}Arm", f"{side}Shoulder", (0.12 * s, 0, 0)),
            (f"{side}ForeArm", f"{side}Arm", (0.28 * s, 0, 0)),
            (f"{side}Hand", f"{side}ForeArm", (0.25 * s, 0, 0)),
            (f"{side}UpLeg", "Hips", (0.1 * s, -0.05, 0)),
            (f"{side}Leg", f"{side}UpLeg", (0, -0.42, 0)),
            (f"{side}Foot", f"{side}Leg", (0, -0.4, 0)),
            (f"{side}Toe", f"{side}Foot", (0, -0.06, 0.13)),
        )
    ),
)


def person() -> Skeleton:
    names = [name for name, _, _ in BONES]
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _ in BONES])
    return with_found_roles(Skeleton(tuple(names), parents, np.array([offset for *_, offset in BONES])))


def blocks(skeleton: Skeleton, thick: float) -> Character:
    """A body of cubes, of this edge in metres, one around each joint."""
    corners = thick / 2 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    still = Motion(skeleton, np.zeros((1, 3)), rot.identity(1, len(skeleton)), 30.0)
    points = (joint_positions(still)[0][:, None] + corners).reshape(-1, 3)
    joints = np.repeat(np.arange(len(skeleton)), 8)[:, None] * np.array([1, 0, 0, 0])
    weights = np.tile([1.0, 0, 0, 0], (len(points), 1))
    faces = np.arange(len(points) - 2)[:, None] + np.arange(3)
    skin = Skin(points, np.tile([0.0, 1, 0], (len(points), 1)), faces, joints, weights, np.zeros(len(faces), int), ())
    return Character("blocks", skeleton, skin)


def walk(skeleton: Skeleton, floor: float = 0.0, frames: int = 120) -> Motion:
    """A walk on the spot: each foot in turn stands for half a second with its toe joint 3 cm over the floor."""
    phase = 2 * np.pi * np.arange(frames) / 30.0
    turns = rot.identity(frames, len(skeleton))
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        raised = np.maximum(sign * np.sin(phase), 0.0)
        turns[:, skeleton.index(f"{side}UpLeg")] = rot.about("x", -0.5 * raised)
        turns[:, skeleton.index(f"{side}Leg")] = rot.about("x", 1.0 * raised)
        turns[:, skeleton.index(f"{side}Foot")] = rot.about("x", -0.5 * raised)
    height = 0.05 + 0.42 + 0.4 + 0.06 + 0.03 + floor
    return Motion(skeleton, np.tile([0.0, height, 0.0], (frames, 1)), turns, 30.0)
