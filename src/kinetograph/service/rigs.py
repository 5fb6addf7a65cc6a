"""Motions between bodies, and the roles that a body's joints play."""

from __future__ import annotations

import msgspec

from kinetograph.character import Character
from kinetograph.errors import RequestError
from kinetograph.motion import resample
from kinetograph.post import joint_table, retarget
from kinetograph.post.rest_pose import leg_length
from kinetograph.service.bodies import Body, Moving, motion_of, skeleton_of, wearer_of, written
from kinetograph.service.job import Job
from kinetograph.skeleton import ROLES
from kinetograph.stance import stands


class Roles(msgspec.Struct, forbid_unknown_fields=True):
    """A question for the roles of a body's joints.

    Parameters
    ----------
    body : Body
    """

    body: Body


class FoundRoles(msgspec.Struct):
    """The roles of a body's joints.

    Parameters
    ----------
    roles : dict of str to str
        Joints by role; a point on a joint is given as that joint.
    missing : tuple of str
        Roles that nobody plays.
    stands : bool
        Whether its rest pose stands upright.
    leg : float
        Metres from hip to knee to ankle.
    """

    roles: dict[str, str]
    missing: tuple[str, ...]
    stands: bool
    leg: float


class Retarget(msgspec.Struct, forbid_unknown_fields=True):
    """A motion for another body.

    Parameters
    ----------
    motion : Moving
    body : Body
    folder : str
        Where arrays are written to.
    fps : float, optional
        Frames per second; as before unless given.
    scale : float, optional
        Of the root path on the ground; that of the legs unless given.
    """

    motion: Moving
    body: Body
    folder: str
    fps: float | None = None
    scale: float | None = None


class Worn(msgspec.Struct):
    """A motion on another body.

    Parameters
    ----------
    motion : Moving
    frames : int
    scale : float
        Of the root path on the ground.
    pairs : dict of str to str
        The joints of the motion by those of the body.
    """

    motion: Moving
    frames: int
    scale: float
    pairs: dict[str, str]


def roles(asked: Roles, job: Job) -> FoundRoles:
    """The roles that a body's joints play, as named by the client or found."""
    skeleton = skeleton_of(asked.body)
    played = {role: skeleton.names[mark.joint] for role, mark in skeleton.roles.items()}
    missing = tuple(role for role in ROLES if role not in played)
    return FoundRoles(played, missing, stands(skeleton), leg_length(skeleton))


def retargeted(asked: Retarget, job: Job) -> Worn:
    """A motion on another body."""
    motion, body = motion_of(asked.motion), wearer_of(asked.body)
    if len(motion) == 0:
        raise RequestError("there is no frame to retarget")
    if asked.fps is not None and asked.fps != motion.fps:
        motion = resample(motion, asked.fps)
    table = joint_table(motion.skeleton, body.skeleton if isinstance(body, Character) else body)
    made = retarget(motion, body, table=table, scale=asked.scale)
    return Worn(
        written(made.motion, asked.folder, asked.motion.name), len(made.motion), made.scale, dict(made.table.pairs)
    )
