"""SlimeVR's protocol: trackers that send rotations and accelerations over UDP.

Packets are big-endian: a type, a number that grows, and the contents; bundles hold several. Rotations are from the
sensor's frame to a world with Z up. Accelerations are in the sensor's frame and without gravity, which is put back.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kinetograph import rotations as rot
from kinetograph.live.rows import Quaternion, Row, Vector
from kinetograph.sensing import GRAVITY

PORT = 6969
"""The port that trackers look for."""
HANDSHAKE, HEARTBEAT, PING = 3, 0, 10
_ACCELERATION, _SENSOR, _ROTATION, _FLAGS, _BOTH = 4, 15, 17, 22, 23
_BUNDLE, _COMPACT = 100, 101
_WELCOME = (b"\x03Hey OVR =D 5").ljust(64, b"\0")
_Y_UP = np.array([np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0])  # z of their world to y of ours


class Packet(NamedTuple):
    """What a packet says of one sensor; other packets have no sensor.

    Parameters
    ----------
    kind : int
    sensor : int
    rotation : tuple of float, length 4, or None
        Quaternion (w, x, y, z) as sent.
    acceleration : tuple of float, length 3, or None
        m/s^2 as sent.
    """

    kind: int
    sensor: int = 0
    rotation: Quaternion | None = None
    acceleration: Vector | None = None


def parse(data: bytes) -> list[Packet]:
    """The packets of a datagram; none where it is damaged or of a type that does not matter here.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    list of Packet
    """
    if len(data) < 4:
        return []
    kind = struct.unpack_from(">i", data)[0]
    if kind in (_BUNDLE, _COMPACT):
        return _bundle(data[12:], kind == _COMPACT)
    return _contents(kind, data[12:])


def _bundle(data: bytes, compact: bool) -> list[Packet]:
    head, kind_head = (1, 1) if compact else (2, 4)
    packets: list[Packet] = []
    at = 0
    while at + head + kind_head <= len(data):
        length = int.from_bytes(data[at : at + head], "big")
        inner = data[at + head : at + head + length]
        at += head + length
        if len(inner) >= kind_head:
            packets += _contents(int.from_bytes(inner[:kind_head], "big"), inner[kind_head:])
    return packets


def _contents(kind: int, data: bytes) -> list[Packet]:
    """A packet without its head; contents that are too short are left out."""
    try:
        if kind == _ROTATION:
            sensor, what, x, y, z, w = struct.unpack_from(">BB4f", data)
            return [Packet(kind, sensor, (w, x, y, z))] if what == 1 else []
        if kind == _ACCELERATION:
            ax, ay, az = struct.unpack_from(">3f", data)
            return [Packet(kind, data[12] if len(data) > 12 else 0, None, (ax, ay, az))]
        if kind == _BOTH:
            sensor, *values = struct.unpack_from(">B7h", data)
            x, y, z, w = (value / 2**15 for value in values[:4])
            ax, ay, az = (value / 2**7 for value in values[4:])
            return [Packet(kind, sensor, (w, x, y, z), (ax, ay, az))]
        if kind == _SENSOR:
            return [Packet(kind, data[0])]
    except (struct.error, IndexError):
        return []
    return [Packet(kind)] if kind in (HANDSHAKE, HEARTBEAT, PING, _FLAGS) else []


@dataclass
class Trackers:
    """Trackers of one address: answers what they ask, and makes rows of what they send.

    Parameters
    ----------
    name : str
        Sensors are called by it and their number, ``"name.0"``.
    """

    name: str
    _rotations: dict[int, Quaternion] = field(default_factory=dict)

    def receive(self, data: bytes) -> tuple[list[Row], list[bytes]]:
        """Take a datagram.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        rows : list of Row
        answers : list of bytes
            To be sent back.
        """
        rows: list[Row] = []
        answers: list[bytes] = []
        for packet in parse(data):
            answers += _answers(packet)
            if packet.rotation is not None and len(self._rotations) < 256:
                self._rotations[packet.sensor] = packet.rotation
            rotation = self._rotations.get(packet.sensor)
            if packet.acceleration is not None and rotation is not None:
                row = _row(f"{self.name}.{packet.sensor}", rotation, packet.acceleration)
                rows += [] if row is None else [row]
        return rows, answers


def hardware_address(data: bytes) -> str | None:
    """The hardware address that a handshake gives, as hexadecimal digits; None for other packets."""
    if len(data) < 41 or struct.unpack_from(">i", data)[0] != HANDSHAKE:
        return None
    at = 41 + data[40]  # after a head of 12 bytes, seven integers, and the version's length and text
    return data[at : at + 6].hex() if len(data) >= at + 6 else None


def heartbeat() -> bytes:
    """What keeps trackers sending; they give up after some seconds without."""
    return struct.pack(">iq", 1, 0)


def _answers(packet: Packet) -> list[bytes]:
    if packet.kind == HANDSHAKE:
        return [_WELCOME]
    if packet.kind == _SENSOR:
        return [struct.pack(">iBB", _SENSOR, packet.sensor, 1)]
    if packet.kind == _FLAGS:
        return [struct.pack(">iqB", _FLAGS, 0, 0b11)]  # bundles, and compact ones
    return []


def _row(name: str, rotation: Quaternion, acceleration: Vector) -> Row | None:
    """Specific force, and the orientation in a world with Y up; None for what no tracker can send."""
    q, a = np.array(rotation), np.array(acceleration)
    norm = float(np.linalg.norm(q))
    if not (np.isfinite(q).all() and np.isfinite(a).all() and 0.5 < norm < 2.0):
        return None
    q = q / norm
    force = a + rot.rotate(rot.conjugate(q), np.array([0.0, 0.0, GRAVITY]))
    ours = rot.multiply(_Y_UP, q)
    return Row(name, None, tuple(force.tolist()), None, tuple(ours.tolist()))
