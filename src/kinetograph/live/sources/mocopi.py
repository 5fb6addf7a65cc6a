"""mocopi's stream: the pose of 27 bones over UDP, in a tree of little-endian chunks.

A chunk is its length, four letters and its contents. One datagram describes the skeleton (``skdf``), again and again;
the others are frames (``fram``). Axes are right-handed, Y up.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion
from kinetograph.roles import with_found_roles
from kinetograph.skeleton import Skeleton

PORT = 12351
"""The port that the app sends to unless set otherwise."""
NAMES = (
    "root",
    "torso_1",
    "torso_2",
    "torso_3",
    "torso_4",
    "torso_5",
    "torso_6",
    "torso_7",
    "neck_1",
    "neck_2",
    "head",
    "l_shoulder",
    "l_up_arm",
    "l_low_arm",
    "l_hand",
    "r_shoulder",
    "r_up_arm",
    "r_low_arm",
    "r_hand",
    "l_up_leg",
    "l_low_leg",
    "l_foot",
    "l_toes",
    "r_up_leg",
    "r_low_leg",
    "r_foot",
    "r_toes",
)
"""Bones in the order of their numbers."""
_TRANSFORM = struct.Struct("<7f")
_DEPTH = 6  # chunks within chunks


@dataclass(frozen=True)
class Frame:
    """One frame as sent.

    Parameters
    ----------
    number : int
    time : float or None
        Seconds of the app's clock; None where it has none.
    rotations : ndarray, shape (27, 4)
        Quaternions, each bone in its parent's frame.
    positions : ndarray, shape (27, 3)
        Metres, each bone in its parent's frame.
    """

    number: int
    time: float | None
    rotations: FloatArray
    positions: FloatArray


@dataclass
class Receiver:
    """Puts frames on the skeleton that was described last.

    Parameters
    ----------
    fps : float
        What the app sends by.
    """

    fps: float = 50.0
    skeleton: Skeleton | None = None
    _described: bytes = field(default=b"", repr=False)

    def receive(self, data: bytes) -> tuple[float | None, Motion] | None:
        """Take a datagram: the app's time and a motion of one frame, or None.

        Frames that come before a skeleton are left out, as is what is damaged.
        """
        chunks = dict(chunks_of(data))
        if "skdf" in chunks:
            if data != self._described:
                self.skeleton, self._described = skeleton_of(data) or self.skeleton, data
            return None
        frame = frame_of(data)
        if frame is None or self.skeleton is None:
            return None
        motion = Motion(self.skeleton, frame.positions[:1], frame.rotations[None], self.fps)
        return frame.time, motion


def chunks_of(data: bytes, depth: int = 0) -> Iterator[tuple[str, bytes]]:
    """Names and contents of the chunks that data begin with; it ends at what is damaged."""
    at = 0
    while at + 8 <= len(data) and depth < _DEPTH:
        length, name = struct.unpack_from("<I4s", data, at)
        if at + 8 + length > len(data):
            return
        yield name.decode("latin-1"), data[at + 8 : at + 8 + length]
        at += 8 + length


def skeleton_of(data: bytes) -> Skeleton | None:
    """The skeleton that a datagram describes, None where it is damaged or of other bones."""
    bones = [dict(chunks_of(bone)) for name, bone in _under(data, "skdf", "bons") if name == "bndt"]
    if len(bones) != len(NAMES) or any(not {"bnid", "pbid", "tran"} <= bone.keys() for bone in bones):
        return None
    offsets = np.zeros((len(NAMES), 3))
    parents = np.full(len(NAMES), -2)
    for bone in bones:
        number, parent, place = _number(bone["bnid"]), _number(bone["pbid"], signed=True), _transform(bone["tran"])
        if not 0 <= number < len(NAMES) or place is None:
            return None
        offsets[number] = place[1]
        parents[number] = -1 if number == 0 else parent
    if not all(0 <= parent < i for i, parent in enumerate(parents.tolist()) if i):
        return None
    return with_found_roles(Skeleton(NAMES, parents, offsets))


def frame_of(data: bytes) -> Frame | None:
    """The frame of a datagram, None where it is damaged or of another kind."""
    inside = dict(_under(data, "fram"))
    if not {"fnum", "btrs"} <= inside.keys():
        return None
    rotations, positions = rot.identity(len(NAMES)), np.zeros((len(NAMES), 3))
    seen = set()
    for name, bone in chunks_of(inside["btrs"], 2):
        parts = dict(chunks_of(bone, 3))
        place = _transform(parts.get("tran", b""))
        number = _number(parts.get("bnid", b""))
        if name == "btdt" and place is not None and 0 <= number < len(NAMES):
            rotations[number], positions[number] = place
            seen.add(number)
    if len(seen) != len(NAMES):
        return None
    return Frame(_number(inside["fnum"]), _seconds(inside.get("uttm", b"")), rotations, positions)


def _seconds(data: bytes) -> float | None:
    """The time since 1970 that eight bytes give, None where they give no time of our days."""
    if len(data) != 8:
        return None
    (seconds,) = struct.unpack("<d", data)
    return float(seconds) if 1e9 < seconds < 1e10 else None


def _under(data: bytes, *names: str) -> Iterator[tuple[str, bytes]]:
    """The chunks inside of a chunk inside of a chunk."""
    for depth, name in enumerate(names):
        data = dict(chunks_of(data, depth)).get(name, b"")
    return chunks_of(data, len(names))


def _number(data: bytes, signed: bool = False) -> int:
    return int.from_bytes(data, "little", signed=signed) if data else -1


def _transform(data: bytes) -> tuple[FloatArray, FloatArray] | None:
    """Quaternion (w, x, y, z) and metres of ``q.xyzw p.xyz``."""
    if len(data) < _TRANSFORM.size:
        return None
    values = np.array(_TRANSFORM.unpack_from(data))
    norm = float(np.linalg.norm(values[:4]))
    if not (np.isfinite(values).all() and 0.5 < norm < 2.0):
        return None
    return values[[3, 0, 1, 2]] / norm, values[4:]
