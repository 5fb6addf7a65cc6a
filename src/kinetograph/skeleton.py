"""Skeletons: joints, their parents and rest offsets, end sites, and the roles that joints play."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError, RequestError

SIDED = ("collar", "shoulder", "elbow", "hand", "hip", "knee", "foot", "toe")
ROLES: tuple[str, ...] = (
    *("hips", "spine", "chest", "neck", "head"),
    *(f"{side}_{part}" for side in ("left", "right") for part in SIDED),
)
"""Every role: ``hand`` is the wrist joint, ``foot`` the ankle joint, ``hip`` the upper end of the thigh."""

_SOLE = 1.05  # of the leg from hip to ankle: the leg with the sole
_ABOVE = {"head": 0.1, "neck": 0.167}  # of a person's height: what is above the head's joint, or the base of the neck


@dataclass(frozen=True, eq=False)
class Landmark:
    """A point that moves with a joint.

    Parameters
    ----------
    joint : int
        Index of the joint.
    offset : ndarray, shape (3,), optional
        Metres in the joint's frame; 0 for the joint itself.
    """

    joint: int
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, eq=False)
class Ancestor:
    """A node above the root of a body, as a file has it: where it stands in its own parent. It never moves.

    Parameters
    ----------
    name : str
    translation : ndarray, shape (3,), optional
        Metres.
    rotation : ndarray, shape (4,), optional
        A unit quaternion.
    """

    name: str
    translation: FloatArray = field(default_factory=lambda: np.zeros(3))
    rotation: FloatArray = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A tree of joints.

    Parameters
    ----------
    names : tuple of str
        One per joint, unique.
    parents : ndarray of int, shape (J,)
        Index of each joint's parent, which comes before it; -1 for the root, which is the first.
    offsets : ndarray, shape (J, 3)
        Metres, each joint in its parent's frame at rest. The root's is kept for files only: the translation of a
        motion replaces it.
    end_parents : ndarray of int, shape (E,), optional
        The joints that end sites, the tips of the last bones, hang on.
    end_offsets : ndarray, shape (E, 3), optional
        Metres, each end site in the frame of its joint.
    roles : mapping of str to Landmark, optional
        The joint, or point on a joint, that plays each of `ROLES`; a skeleton need not have all of them.
    stance : ndarray, shape (J, 4), optional
        The joints' local rotations in a pose in which the body stands upright, where the rest pose, with all rotations
        zero, does not; None where the rest pose stands.
    ancestors : tuple of Ancestor, optional
        What a file has above the root, outermost first; motions are in the world, and files are written with these.

    Raises
    ------
    DataError
        If these do not hold.
    """

    names: tuple[str, ...]
    parents: IntArray
    offsets: FloatArray
    end_parents: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    end_offsets: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    roles: Mapping[str, Landmark] = field(default_factory=dict)
    stance: FloatArray | None = None
    ancestors: tuple[Ancestor, ...] = ()

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        set_field(self, "names", tuple(self.names))
        set_field(self, "parents", np.asarray(self.parents, dtype=np.int64))
        set_field(self, "offsets", np.asarray(self.offsets, dtype=np.float64))
        set_field(self, "end_parents", np.asarray(self.end_parents, dtype=np.int64).reshape(-1))
        set_field(self, "end_offsets", np.asarray(self.end_offsets, dtype=np.float64).reshape(-1, 3))
        set_field(self, "roles", MappingProxyType(dict(self.roles)))
        joints = len(self.names)
        if joints == 0:
            raise DataError("a skeleton needs at least one joint, found none")
        if len(set(self.names)) != joints:
            twice = next(n for n in self.names if self.names.count(n) > 1)
            raise DataError(f"joint names must be unique, found {twice!r} twice; rename one")
        if self.parents.shape != (joints,) or self.offsets.shape != (joints, 3):
            raise DataError(
                f"expected parents ({joints},) and offsets ({joints}, 3) for {joints} names, "
                f"found {self.parents.shape} and {self.offsets.shape}"
            )
        if self.parents[0] != -1 or not all(0 <= p < i for i, p in enumerate(self.parents[1:], start=1)):
            raise DataError("parents must come before their children and the one root first; sort the joints")
        if len(self.end_parents) != len(self.end_offsets):
            raise DataError(f"{len(self.end_parents)} end parents but {len(self.end_offsets)} end offsets")
        if len(self.end_parents) and not (self.end_parents.min() >= 0 and self.end_parents.max() < joints):
            raise DataError(f"end sites must hang on joints 0 to {joints - 1}, found {self.end_parents.tolist()}")
        if not (np.isfinite(self.offsets).all() and np.isfinite(self.end_offsets).all()):
            raise DataError("offsets must be finite numbers of metres")
        for role, landmark in self.roles.items():
            if role not in ROLES or not 0 <= landmark.joint < joints:
                raise DataError(f"role {role!r} on joint {landmark.joint}: expected one of {', '.join(ROLES)}")
            if landmark.offset.shape != (3,) or not np.isfinite(landmark.offset).all():
                raise DataError(f"role {role!r}: an offset is three finite metres, found {landmark.offset}")
        if self.stance is not None:
            set_field(self, "stance", np.asarray(self.stance, dtype=np.float64))
            if self.stance.shape != (joints, 4) or not np.allclose(np.linalg.norm(self.stance, axis=1), 1.0, atol=1e-6):
                raise DataError(f"a stance is ({joints}, 4) unit quaternions, found {self.stance.shape}")

    def __len__(self) -> int:
        return len(self.names)

    def __reduce__(self) -> tuple[Any, ...]:
        parts = (self.names, self.parents, self.offsets, self.end_parents, self.end_offsets, dict(self.roles))
        return Skeleton, (*parts, self.stance, self.ancestors)  # a read-only view of a dict does not pickle

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """The indices of each joint's children."""
        return tuple(tuple(np.flatnonzero(self.parents == i).tolist()) for i in range(len(self)))

    @property
    def height(self) -> float:
        """Rough standing height in metres: the bones of a leg and those from the hips to the head, and a share of it.

        The share is for the sole and for the head above its joint, or above the base of the neck, whatever end sites
        say, as not every format has those. Without joints in those roles, the two longest chains of bones from the
        root, which may be an arm and a leg.
        """
        feet = [f"{side}_foot" for side in ("left", "right") if {f"{side}_hip", f"{side}_foot"} <= self.roles.keys()]
        tops = [role for role in ("head", "neck") if role in self.roles and not self.roles[role].offset.any()]
        if feet and tops and "hips" in self.roles:
            hips, top = self.roles["hips"].joint, tops[0]
            legs = max(self._between(self.roles[f"{foot[:-4]}hip"].joint, self.roles[foot].joint) for foot in feet)
            trunk = self._between(hips, self.roles[top].joint)
            return (_SOLE * legs + self._drop(hips) + trunk) / (1.0 - _ABOVE[top])
        reach = self._reach()
        limbs = sorted((reach[c] + np.linalg.norm(self.offsets[c]) for c in self.children[0]), reverse=True)
        return float(sum(limbs[:2])) if len(limbs) > 1 else float(reach[0])

    def _drop(self, hips: int) -> float:
        """Metres from the hips down to the middle between the upper ends of the thighs, in the pose of the stance."""
        thighs = [self.roles[role].joint for role in ("left_hip", "right_hip") if role in self.roles]
        lines = [self._line(joint, hips) for joint in thighs]
        if len(lines) < 2:
            return 0.0
        stance = np.tile([1.0, 0.0, 0.0, 0.0], (len(self), 1)) if self.stance is None else self.stance
        ends = []
        for line in lines:
            at = np.zeros(3)
            for joint in line:  # from the thigh up, in each joint's parent
                at = self.offsets[joint] + rot.rotate(stance[joint], at)
            ends.append(at)
        return float(np.linalg.norm(ends[0] + ends[1])) / 2.0

    def _reach(self) -> FloatArray:
        """Length of the longest chain of bones that hangs on each joint, end sites included, shape ``(J,)``."""
        reach = np.zeros(len(self))
        for parent, offset in zip(self.end_parents, self.end_offsets, strict=True):
            reach[parent] = max(reach[parent], float(np.linalg.norm(offset)))
        for joint in range(len(self) - 1, 0, -1):
            parent = self.parents[joint]
            reach[parent] = max(reach[parent], reach[joint] + float(np.linalg.norm(self.offsets[joint])))
        return reach

    def _line(self, joint: int, above: int) -> list[int]:
        """A joint and its ancestors below ``above``, or below the root."""
        line = []
        while joint > 0 and joint != above:
            line.append(joint)
            joint = int(self.parents[joint])
        return line

    def _between(self, above: int, joint: int) -> float:
        """Metres along the bones from one joint down to another."""
        return float(np.linalg.norm(self.offsets[self._line(joint, above)], axis=1).sum())

    def landmark(self, role: str) -> Landmark:
        """The joint, or point on a joint, that plays a role.

        Parameters
        ----------
        role : str
            One of `ROLES`.

        Returns
        -------
        Landmark

        Raises
        ------
        RequestError
            If none does; the message names the roles that the skeleton has.
        """
        try:
            return self.roles[role]
        except KeyError:
            known = ", ".join(self.roles) or "none"
            hint = f"expected one of {', '.join(ROLES)}" if role not in ROLES else f"this skeleton has: {known}"
            raise RequestError(f"no joint plays the role {role!r}; {hint}; name it with --role") from None

    def index(self, name: str) -> int:
        """Index of a joint.

        Parameters
        ----------
        name : str

        Returns
        -------
        int

        Raises
        ------
        RequestError
            If there is none; the message names the joints with the most similar names.
        """
        import difflib

        try:
            return self.names.index(name)
        except ValueError:
            near = ", ".join(difflib.get_close_matches(name, self.names, 3)) or ", ".join(self.names[:8])
            raise RequestError(f"no joint {name!r}; did you mean {near}?") from None


def with_roles(skeleton: Skeleton, overrides: Mapping[str, str | Landmark]) -> Skeleton:
    """A skeleton with some of its roles replaced.

    Parameters
    ----------
    skeleton : Skeleton
    overrides : mapping of str to str or Landmark
        Role to the name of a joint, or to a point on one.

    Returns
    -------
    Skeleton

    Raises
    ------
    RequestError
        If a role or a joint is unknown.

    Examples
    --------
    >>> bone = Skeleton(("a", "b"), np.array([-1, 0]), np.zeros((2, 3)))
    >>> with_roles(bone, {"head": "b"}).roles["head"].joint
    1
    """
    roles = dict(skeleton.roles)
    for role, value in overrides.items():
        if role not in ROLES:
            raise RequestError(f"unknown role {role!r}; expected one of {', '.join(ROLES)}")
        roles[role] = Landmark(skeleton.index(value)) if isinstance(value, str) else value
    return replace(skeleton, roles=roles)


def plain_names(names: Iterable[str]) -> tuple[str, ...]:
    """Names of joints without the namespace that all share, as in ``actor:Hips``.

    Examples
    --------
    >>> plain_names(["a:Hips", "a:Head"]), plain_names(["a:Hips", "Head"])
    (('Hips', 'Head'), ('a:Hips', 'Head'))
    """
    names = tuple(names)
    space, colon, _ = names[0].rpartition(":") if names else ("", "", "")
    shared = space + colon
    return tuple(name[len(shared) :] for name in names) if all(name.startswith(shared) for name in names) else names


def same_shape(a: Skeleton, b: Skeleton, tolerance: float = 1e-3) -> bool:
    """Whether two skeletons have the same joints and the same bones.

    Parameters
    ----------
    a, b : Skeleton
    tolerance : float
        Metres by which the coordinates of offsets may differ.

    Returns
    -------
    bool
    """
    return (
        a.names == b.names
        and np.array_equal(a.parents, b.parents)
        and bool(np.all(np.abs(a.offsets[1:] - b.offsets[1:]) <= tolerance))
    )


def opposite(role: str) -> str:
    """The role on the other side of the body; roles on the midline are their own.

    Examples
    --------
    >>> opposite("left_knee"), opposite("head")
    ('right_knee', 'head')
    """
    if role.startswith("left_"):
        return "right_" + role[5:]
    if role.startswith("right_"):
        return "left_" + role[6:]
    return role
