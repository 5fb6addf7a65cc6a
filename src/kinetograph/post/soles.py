"""Soles: the undersides of feet, how high they are above the floor, and where the floor of a recording is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.character import Character, extreme_points, skin_heights
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.post.footskate import contact_mask
from kinetograph.post.rest_pose import leg_length
from kinetograph.segmentation import CONTACT_ROLES, detect_contacts
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation

SIDES = ("left", "right")
_UNDER, _OVER = 0.1, 0.25  # of a leg's length: a planted toe between these and y = 0 stands on y = 0
_THICKNESS = 0.03  # of a leg's length: a toe joint over the sole, where nothing else is known


@dataclass(frozen=True, eq=False)
class Undersides:
    """The points of a character that may touch the floor, by part of the body.

    Parameters
    ----------
    character : Character
    feet, hands : dict of str to ndarray of int
        Indices of points of the skin, by side; no entry for a limb that the skeleton does not have.
    rest : ndarray of int
        Those of all other parts.
    """

    character: Character
    feet: dict[str, IntArray]
    hands: dict[str, IntArray]
    rest: IntArray

    def lowest(self, motion: Motion, points: IntArray) -> FloatArray:
        """Height of the lowest of some points in every frame of a motion, shape ``(F,)``, metres."""
        return np.asarray(skin_heights(motion, self.character.skin, points).min(axis=1, initial=np.inf))

    def soles(self, motion: Motion) -> dict[str, FloatArray]:
        """Height of each sole in every frame of a motion, shape ``(F,)``, metres, by side."""
        return {side: self.lowest(motion, points) for side, points in self.feet.items()}


def undersides(character: Character) -> Undersides:
    """The points of a character that may touch the floor.

    Parameters
    ----------
    character : Character

    Returns
    -------
    Undersides
    """
    points = extreme_points(character.skin)
    parts: dict[str, dict[str, IntArray]] = {"foot": {}, "hand": {}}
    left = np.ones(len(points), dtype=np.bool_)
    for part, found in parts.items():
        for side in SIDES:
            own = _below(character, f"{side}_{part}", points)
            if own.any():
                found[side] = points[own]
                left &= ~own
    return Undersides(character, parts["foot"], parts["hand"], points[left])


def _below(character: Character, role: str, points: IntArray) -> BoolArray:
    """Which points follow the joint of a role, or those that hang on it, by more than half."""
    skeleton = character.skeleton
    if role not in skeleton.roles:
        return np.zeros(len(points), dtype=np.bool_)
    joints = _hanging(skeleton, skeleton.roles[role].joint)
    weights = np.where(np.isin(character.skin.joints[points], joints), character.skin.weights[points], 0.0)
    return np.asarray(weights.sum(axis=1) > 0.5)


def _hanging(skeleton: Skeleton, top: int) -> list[int]:
    """A joint and all that hang on it."""
    joints = [top]
    for joint in range(top + 1, len(skeleton)):
        if skeleton.parents[joint] in joints:
            joints.append(joint)
    return joints


def planted_feet(motion: Motion, contacts: tuple[Annotation, ...]) -> dict[str, BoolArray]:
    """The frames at which any point of a foot is in contact, by side, shape ``(F,)``."""
    return {
        side: np.logical_or.reduce(
            [contact_mask(contacts, f"{side}_{part}", len(motion), motion.fps) for part in ("foot", "toe")]
        )
        for side in SIDES
    }


def floor_height(motion: Motion, contacts: tuple[Annotation, ...] | None = None) -> float:
    """The height in metres of the floor of a recording.

    The floor is y = 0 where feet are planted near it: the joints of a foot lie somewhat above its sole, and by how much
    differs between skeletons. Where feet are planted far from y = 0, as in recordings about the root, the floor is
    found from them.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation, optional
        Of feet; detected unless given.

    Returns
    -------
    float
        0 without planted feet.
    """
    contacts = detect_contacts(motion) if contacts is None else contacts
    roles = [role for role in CONTACT_ROLES if role in motion.skeleton.roles]
    if not roles:
        return 0.0
    heights = role_positions(motion, roles)[..., 1]
    masks = np.stack([contact_mask(contacts, role, len(motion), motion.fps) for role in roles], axis=1)
    lowest = np.where(masks, heights, np.inf).min(axis=1)
    if not np.isfinite(lowest).any():
        return 0.0
    level, leg = float(np.median(lowest[np.isfinite(lowest)])), leg_length(motion.skeleton)
    return 0.0 if -_UNDER * leg < level < _OVER * leg else level - _THICKNESS * leg
