"""Virtual Motion Capture protocol: a body as OSC messages, which avatars in Unity, Unreal, Warudo and Blender take.

Bones are Unity's humanoid ones, positions and rotations relative to their parents, in Unity's left-handed axes, and
rotations are none in the T pose.
"""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.live.sinks.humanoid import Humanoid
from kinetograph.live.sinks.osc import bundles, message
from kinetograph.motion import Motion

PORT = 39539
"""The port that receivers of bodies listen on."""


def datagrams(body: Humanoid, motion: Motion, time: float) -> list[bytes]:
    """The first frame of a motion, packed.

    Parameters
    ----------
    body : Humanoid
        Of the motion's skeleton.
    motion : Motion
    time : float
        Seconds since the stream began.

    Returns
    -------
    list of bytes
        Datagrams of at most 1,400 bytes.
    """
    positions, rotations = body.pose(motion)
    return bundles(
        [
            message("/VMC/Ext/OK", 1, 3, 0, 1),
            message("/VMC/Ext/T", float(time)),
            message("/VMC/Ext/Root/Pos", "root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
            *(
                message("/VMC/Ext/Bone/Pos", bone, *_left_handed(place, rotation))
                for bone, place, rotation in zip(body.bones, positions[0], rotations[0], strict=True)
            ),
            message("/VMC/Ext/Blend/Apply"),
        ]
    )


def _left_handed(place: FloatArray, rotation: FloatArray) -> tuple[float, ...]:
    """Position and quaternion ``(x, y, z, w)`` in Unity's axes: x the other way round."""
    w, x, y, z = rotation.tolist()
    return (-float(place[0]), float(place[1]), float(place[2]), x, -y, -z, w)


def right_handed(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What seven numbers of a message say in our axes.

    Parameters
    ----------
    values : ndarray, shape (..., 7)
        Position, and quaternion ``(x, y, z, w)``, as they are sent.

    Returns
    -------
    positions : ndarray, shape (..., 3)
    rotations : ndarray, shape (..., 4)
    """
    values = np.asarray(values, dtype=np.float64)
    quaternions = np.stack([values[..., 6], values[..., 3], -values[..., 4], -values[..., 5]], axis=-1)
    return values[..., :3] * [-1.0, 1.0, 1.0], rot.normalize(quaternions)
