"""Xsens MVN's network stream: trackers and segments over UDP, in its big-endian datagrams.

World axes are x forward, y left, z up. Of the message types, tracker kinematics (23) make rows of sensors, and poses in
quaternions (02) make places and rotations of segments.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.live.rows import Row
from kinetograph.sensing import GRAVITY

PORT = 9763
"""The port that MVN sends to unless set otherwise."""
SEGMENTS = (
    "Pelvis",
    "L5",
    "L3",
    "T12",
    "T8",
    "Neck",
    "Head",
    "RightShoulder",
    "RightUpperArm",
    "RightForearm",
    "RightHand",
    "LeftShoulder",
    "LeftUpperArm",
    "LeftForearm",
    "LeftHand",
    "RightUpperLeg",
    "RightLowerLeg",
    "RightFoot",
    "RightToe",
    "LeftUpperLeg",
    "LeftLowerLeg",
    "LeftFoot",
    "LeftToe",
)
"""Segments in the order of their numbers, which begin with 1."""
_HEAD = struct.Struct(">6sIBBIBB6s")
_POSE = struct.Struct(">i7f")
_SHORT, _LONG = struct.Struct(">i10f"), struct.Struct(">i16f")  # trackers as MVN 2020 and as MVN 2021 and later send
_LAST = 0x80  # of the datagram counter: set on a sample's last datagram
_Y_UP = np.array([0.5, -0.5, -0.5, -0.5])  # x forward, y left, z up to z forward, x left, y up


class Head(NamedTuple):
    """The head of a datagram.

    Parameters
    ----------
    kind : int
        The message type.
    sample : int
        Counts samples.
    part : int
        Counts the datagrams of one sample; the last has 128 added.
    items : int
    time : float
        Seconds since the recording began.
    character : int
    """

    kind: int
    sample: int
    part: int
    items: int
    time: float
    character: int


class Segment(NamedTuple):
    """A segment of the body.

    Parameters
    ----------
    name : str
    position : ndarray, shape (3,)
        Metres, Y up.
    rotation : ndarray, shape (4,)
        Quaternion from a T pose that faces +Z.
    """

    name: str
    position: FloatArray
    rotation: FloatArray


def head(data: bytes) -> Head | None:
    """The head of a datagram, None where it is none of MVN's."""
    if len(data) < _HEAD.size:
        return None
    identity, sample, part, items, milliseconds, character, _, _ = _HEAD.unpack_from(data)
    if identity[:4] != b"MXTP" or not identity[4:].isdigit():
        return None
    return Head(int(identity[4:]), sample, part, items, milliseconds / 1000.0, character)


def trackers(data: bytes) -> list[Row]:
    """The rows of a datagram of tracker kinematics.

    Newer versions send specific force and angular velocity as measured. Of older ones specific force is what they send
    as free acceleration, in the world, with gravity put back and turned into the sensor's frame.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    list of Row
        None for other types and for what is damaged; sensors are called as their segments.
    """
    found = head(data)
    if found is None or found.kind != 23 or found.items == 0:
        return []
    layout = _LONG if len(data) - _HEAD.size >= found.items * _LONG.size else _SHORT
    rows = []
    for number, *values in _items(data, layout, found.items):
        row = _tracker(number, np.array(values), found)
        rows += [] if row is None else [row]
    return rows


def segments(data: bytes) -> list[Segment]:
    """The segments of a datagram of poses in quaternions; none for other types and for what is damaged."""
    found = head(data)
    if found is None or found.kind != 2:
        return []
    out = []
    for number, *values in _items(data, _POSE, found.items):
        place, rotation = np.array(values[:3]), np.array(values[3:])
        if 1 <= number <= len(SEGMENTS) and np.isfinite(values).all() and 0.5 < np.linalg.norm(rotation) < 2.0:
            whole = rot.multiply(rot.multiply(_Y_UP, rot.normalize(rotation)), rot.conjugate(_Y_UP))
            out.append(Segment(SEGMENTS[int(number) - 1], rot.rotate(_Y_UP, place), whole))
    return out


def _items(data: bytes, layout: struct.Struct, most: int) -> list[tuple[float, ...]]:
    body = data[_HEAD.size :]
    count = min(most, len(body) // layout.size)
    return list(layout.iter_unpack(body[: count * layout.size]))


def _tracker(number: float, values: FloatArray, found: Head) -> Row | None:
    """Row of quaternion, free acceleration and either the magnetic field or force, angular velocity and that."""
    norm = float(np.linalg.norm(values[:4]))
    if not (1 <= number <= len(SEGMENTS) and np.isfinite(values).all() and 0.5 < norm < 2.0):
        return None
    q = values[:4] / norm
    angular = None
    if len(values) == 16:
        force, angular = values[7:10], tuple(values[10:13].tolist())
    else:
        force = rot.rotate(rot.conjugate(q), values[4:7] + np.array([0.0, 0.0, GRAVITY]))
    name = SEGMENTS[int(number) - 1]
    return Row(name, found.time, tuple(force.tolist()), angular, tuple(rot.multiply(_Y_UP, q).tolist()))
