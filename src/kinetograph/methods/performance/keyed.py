"""Keys in the search: what the frames of the recordings lack of a key's pose."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.segments import Source
from kinetograph.methods.relative_pose import BODY, REACH, leg_length, relative_joints


def distances_to(fitted: Fitted, key: Key) -> tuple[FloatArray, ...]:
    """How far every frame of every source is from a key's pose, metres ``(F,)``.

    It is the root of the mean squared distance of the roles that count, as seen from the root; where the key's clip has
    neighbours of its frame, velocities count as far as they lead in 0.2 s.

    Parameters
    ----------
    fitted : Fitted
    key : Key
        A pose of another build is scaled by the length of the legs.

    Raises
    ------
    RequestError
        Where the recordings have none of the key's roles.
    """
    skeleton = fitted.sources[0].motion.skeleton
    both = [role for role in BODY if role in skeleton.roles and role in key.clip.skeleton.roles]
    asked = [role for role in both if key.roles is None or role in key.roles] or both
    if not asked:
        raise RequestError(f"{key.label}: the recordings have none of the roles that its pose has")
    pose, velocity = relative_joints(key.clip, tuple(asked))
    scale = leg_length(skeleton) / leg_length(key.clip.skeleton)
    wanted = pose[key.frame] * scale
    moving = velocity[key.frame] * scale * REACH if len(key.clip) > 1 else None
    return tuple(_distances(source, tuple(asked), wanted, moving) for source in fitted.sources)


def _distances(source: Source, roles: tuple[str, ...], pose: FloatArray, moving: FloatArray | None) -> FloatArray:
    known, positions, velocities = source.posture
    if roles != known:
        columns = [known.index(role) for role in roles]
        positions, velocities = positions[:, columns], velocities[:, columns]
    squares = _squares(positions - pose)
    if moving is not None:
        squares += _squares(velocities * REACH - moving)
    return np.asarray(np.sqrt(squares / len(roles)))


def _squares(gaps: FloatArray) -> FloatArray:
    """The sums of squares of gaps ``(F, R, 3)``, ``(F,)``."""
    flat = gaps.reshape(len(gaps), -1)
    return np.asarray(np.einsum("ij,ij->i", flat, flat))
