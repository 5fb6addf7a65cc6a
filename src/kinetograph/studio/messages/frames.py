"""Messages and binary frames."""

from __future__ import annotations

import struct
from typing import Literal

import msgspec
import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError

BLOB, POSE = 1, 2
"""The first number of a binary frame."""


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", rename=None):
    """A message, whose kind is the name of its class in small letters."""


class FileHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="file", forbid_unknown_fields=True):
    """The header of a blob from the page: a file that was dropped onto it.

    Parameters
    ----------
    id : int
    name : str
        Its name, without a folder.
    role : str
        What it is to be: ``character``, ``leader``, ``readings``, ``layout`` or ``recording``.
    """

    id: int
    name: str
    role: Literal["character", "leader", "readings", "layout", "recording"]


def blob(header: msgspec.Struct, payload: bytes) -> bytes:
    """A binary frame: the number 1, the header's length, the header as JSON, the payload from a multiple of 4 on."""
    text = msgspec.json.encode(header)
    text += b" " * (-len(text) % 4)
    return struct.pack("<2I", BLOB, len(text)) + text + payload


def pose_frame(time: float, translation: FloatArray, rotations: FloatArray, deviations: FloatArray | None) -> bytes:
    """A pose as a binary frame of float32 values after the number 2.

    Parameters
    ----------
    time : float
        Seconds.
    translation : ndarray, shape (3,)
        The root's, metres.
    rotations : ndarray, shape (J, 4)
    deviations : ndarray, shape (J,), optional
        Standard deviation of each joint, radians.
    """
    parts = [np.array([time]), translation, rotations.ravel(), *([] if deviations is None else [deviations])]
    return struct.pack("<I", POSE) + np.concatenate(parts).astype("<f4").tobytes()


def read_blob(data: bytes) -> tuple[FileHeader, bytes]:
    """The header and payload of a binary frame from the page.

    Raises
    ------
    RequestError
        For bytes that are none.
    """
    if len(data) < 8:
        raise RequestError(f"expected a binary frame of 8 bytes or more, found {len(data)}")
    kind, length = struct.unpack_from("<2I", data)
    if kind != BLOB or length > len(data) - 8:
        raise RequestError(f"expected a binary frame of kind {BLOB} with its header, found kind {kind}")
    try:
        return msgspec.json.decode(data[8 : 8 + length], type=FileHeader), data[8 + length :]
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise RequestError(f"expected the header of a file, found: {error}") from None
