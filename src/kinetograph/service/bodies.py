"""Skeletons and motions as a client describes them, and as it is given them.

A skeleton's joints are frames that are aligned with the world at rest: metres, Y up, as everywhere. Arrays of a motion
are in a .npz file: ``translation`` (F, 3), the root's, and ``rotations`` (F, J, 4), unit quaternions w, x, y, z, each
joint in its parent's frame.
"""

from __future__ import annotations

import itertools
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from kinetograph.character import Character, Skin
from kinetograph.errors import RequestError
from kinetograph.formats.stances import with_stance
from kinetograph.motion import Motion
from kinetograph.roles import find_roles
from kinetograph.rotations import identity, normalize
from kinetograph.skeleton import Skeleton, with_roles

Vector = tuple[float, float, float]
_numbers = itertools.count(1)


class End(msgspec.Struct, forbid_unknown_fields=True):
    """The tip of a last bone.

    Parameters
    ----------
    joint : str
        That it hangs on.
    offset : tuple of float
        Metres from the joint at rest.
    """

    joint: str
    offset: Vector


class Body(msgspec.Struct, forbid_unknown_fields=True):
    """A skeleton.

    Parameters
    ----------
    names : tuple of str
        Of joints, parents before children.
    parents : tuple of int
    offsets : tuple of tuple of float
        Metres from the parent at rest.
    ends : tuple of End, optional
    roles : dict of str to str, optional
        Joints by role; those that are not given are found by names and shape, and one that is given as "" is nobody's.
    skin : str, optional
        A .npz file of what is around the joints at rest, so that it is stood on the floor: ``points`` (V, 3), metres
        from the first joint, and the ``joints`` (V, 4) that move them, with ``weights`` (V, 4).
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: tuple[Vector, ...]
    ends: tuple[End, ...] = ()
    roles: dict[str, str] = msgspec.field(default_factory=dict)
    skin: str = ""


class Moving(msgspec.Struct, forbid_unknown_fields=True):
    """A motion.

    Parameters
    ----------
    body : Body
    fps : float
    arrays : str
        A .npz file.
    name : str, optional
    """

    body: Body
    fps: float
    arrays: str
    name: str = "motion"


def skeleton_of(body: Body) -> Skeleton:
    """A client's skeleton, with the roles that it names and those that are found, and a stance where it needs one.

    Raises
    ------
    DataError
        For a tree that is none.
    RequestError
        For an unknown role or joint.
    """
    return _standing(_plain(body))


def wearer_of(body: Body) -> Skeleton | Character:
    """A client's skeleton, with its skin where it has one.

    Raises
    ------
    RequestError, DataError
        As `skeleton_of`, and where a skin cannot be read.
    """
    skeleton = skeleton_of(body)
    if not body.skin:
        return skeleton
    found = _arrays(Path(body.skin), ("points", "joints", "weights"))
    points, joints, weights = (found[name] for name in ("points", "joints", "weights"))
    if joints.size and not 0 <= joints.min() <= joints.max() < len(skeleton):
        raise RequestError(f"{body.skin}: joints of a skin are 0 to {len(skeleton) - 1}, found {joints.max()}")
    none = np.zeros((0, 3), dtype=np.int64)
    skin = Skin(points, np.zeros_like(points), none, joints, weights, none[:, 0], ())
    return Character("client", skeleton, skin)


def _plain(body: Body) -> Skeleton:
    ends = [end for end in body.ends if end.joint in body.names]
    plain = Skeleton(
        body.names,
        np.array(body.parents, dtype=np.int64),
        np.array(body.offsets, dtype=np.float64).reshape(-1, 3),
        np.array([body.names.index(end.joint) for end in ends], dtype=np.int64),
        np.array([end.offset for end in ends], dtype=np.float64).reshape(-1, 3),
    )
    found = {role: where for role, where in find_roles(plain).items() if body.roles.get(role) != ""}
    return with_roles(replace(plain, roles=found), {role: joint for role, joint in body.roles.items() if joint})


def _standing(skeleton: Skeleton) -> Skeleton:
    still = Motion(skeleton, np.zeros((1, 3)), identity(1, len(skeleton)), 30.0)
    return with_stance(still)[0]


def motion_of(moving: Moving) -> Motion:
    """A client's motion.

    Raises
    ------
    RequestError
        Where its arrays cannot be read.
    DataError
        Where they are of other shapes than its skeleton.
    """
    found = _arrays(Path(moving.arrays), ("translation", "rotations"))
    return Motion(skeleton_of(moving.body), found["translation"], normalize(found["rotations"]), moving.fps)


def _arrays(path: Path, names: tuple[str, ...]) -> dict[str, Any]:
    """Arrays of a file. Raises RequestError."""
    try:
        with np.load(path) as arrays:
            return {name: arrays[name] for name in names}
    except (OSError, ValueError, KeyError) as error:
        raise RequestError(f"{path}: expected a .npz file with {', '.join(names)}: {error}") from None


def body_of(skeleton: Skeleton) -> Body:
    """A skeleton for a client."""
    ends = zip(skeleton.end_parents.tolist(), skeleton.end_offsets.tolist(), strict=True)
    return Body(
        skeleton.names,
        tuple(skeleton.parents.tolist()),
        tuple(tuple(row) for row in skeleton.offsets.tolist()),
        tuple(End(skeleton.names[joint], tuple(offset)) for joint, offset in ends),
        {role: skeleton.names[mark.joint] for role, mark in skeleton.roles.items() if not mark.offset.any()},
    )


def written(motion: Motion, folder: str, name: str = "motion") -> Moving:
    """A motion for a client, its arrays in a new file of a folder.

    Parameters
    ----------
    motion : Motion
    folder : str
    name : str

    Raises
    ------
    RequestError
        Where there is no such folder.
    """
    where = Path(folder)
    if not where.is_dir():
        raise RequestError(f"{where}: expected a folder for arrays; it is not there")
    path = where / f"kinetograph-{os.getpid()}-{next(_numbers)}.npz"
    np.savez(path, translation=motion.translation, rotations=motion.rotations)
    return Moving(body_of(motion.skeleton), motion.fps, str(path), name)
