"""The header and the parameters of a C3D file."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError

_BLOCK = 512
_INTEL, _DEC, _MIPS = 1, 2, 3


@dataclass(frozen=True)
class Parameter:
    """A value of a group.

    Parameters
    ----------
    kind : int
        -1 text, 1 byte, 2 integer, 4 real.
    sides : tuple of int
        Its shape, the fastest index first.
    data : bytes
    """

    kind: int
    sides: tuple[int, ...]
    data: bytes


@dataclass(frozen=True)
class Parameters:
    """What the header and the parameters say.

    Parameters
    ----------
    processor : int
        1 Intel, 2 DEC, 3 MIPS.
    points, analog : int
        Numbers of markers, and of analog values per frame.
    first, last : int
        The frames' numbers.
    header_scale, header_rate : float
        Scale (negative where numbers are reals) and frames per second.
    data_block : int
        The block of 512 bytes, from 1, where the data begin.
    values : dict of tuple of str to Parameter
        By group and name in capitals.
    """

    processor: int
    points: int
    analog: int
    first: int
    last: int
    header_scale: float
    header_rate: float
    data_block: int
    values: dict[tuple[str, str], Parameter]

    def number(self, group: str, name: str, default: float) -> float:
        """A number, unsigned where it is whole, or a default."""
        value = self.values.get((group, name))
        if value is None or len(value.data) < abs(value.kind) or value.kind == -1:
            return float(default)
        if value.kind == 4:
            return float(reals(np.frombuffer(value.data[:4], np.uint8), self.processor)[0])
        order = ">" if self.processor == _MIPS else "<"
        return float(struct.unpack(f"{order}{'B' if value.kind == 1 else 'H'}", value.data[: value.kind])[0])

    def long_frames(self) -> float:
        """Frames of a file with more than the header can count: TRIAL gives the first and last, in two words each."""
        ends = [self.values.get(("TRIAL", name)) for name in ("ACTUAL_START_FIELD", "ACTUAL_END_FIELD")]
        order = ">" if self.processor == _MIPS else "<"
        words = [struct.unpack(f"{order}2H", end.data[:4]) for end in ends if end is not None and len(end.data) >= 4]
        if len(words) == 2:
            start, stop = (low + 65536 * high for low, high in words)
            return float(stop - start + 1)
        return self.number("POINT", "LONG_FRAMES", 0)

    def texts(self, group: str, name: str) -> list[str]:
        """The rows of a table of characters, and of those that continue it where 255 rows are not enough."""
        rows: list[str] = []
        for part in ("", *map(str, range(2, 10))):
            value = self.values.get((group, name + part))
            if value is None or value.kind != -1 or not value.data:
                break
            size = value.sides[0] if value.sides else len(value.data)  # a single character has no sides
            text = value.data.decode("latin-1")
            rows += [text[i : i + size].rstrip("\0 ") for i in range(0, len(text) - size + 1, size)]
        return rows

    def text(self, group: str, name: str) -> str:
        """The first row of a table of characters."""
        return next(iter(self.texts(group, name)), "")


def parse_parameters(path: Path, data: bytes) -> Parameters:
    """Read the header and the parameters.

    Parameters
    ----------
    path : Path
        For errors.
    data : bytes
        The whole file.

    Returns
    -------
    Parameters

    Raises
    ------
    FormatError
    """
    start = (data[0] - 1) * _BLOCK
    if start < _BLOCK or start + 4 > len(data):
        raise FormatError(path, f"its parameters would begin at byte {start}; is the file damaged?")
    processor = data[start + 3] - 83
    if processor not in (_INTEL, _DEC, _MIPS):
        raise FormatError(path, f"expected a processor of type 84 to 86, found {data[start + 3]}")
    order = ">" if processor == _MIPS else "<"
    points, analog, first, last = struct.unpack_from(f"{order}4H", data, 2)
    (block,) = struct.unpack_from(f"{order}H", data, 16)
    scale, rate = (float(reals(np.frombuffer(data, np.uint8, 4, at), processor)[0]) for at in (12, 20))
    stop = min(start + max(data[start + 2], 1) * _BLOCK, len(data))
    values = _values(data, start + 4, stop, order)
    return Parameters(processor, points, analog, first, last, scale, rate, block, values)


def _values(data: bytes, position: int, stop: int, order: str) -> dict[tuple[str, str], Parameter]:
    groups: dict[int, str] = {}
    parameters: list[tuple[int, str, Parameter]] = []
    while position + 4 <= stop:
        size, number = abs(struct.unpack_from("b", data, position)[0]), struct.unpack_from("b", data, position + 1)[0]
        end = position + 2 + size
        if size == 0 or number == 0 or end + 2 > stop:
            break
        name = data[position + 2 : end].decode("latin-1").upper().strip()
        (step,) = struct.unpack_from(f"{order}H", data, end)
        if number < 0:
            groups[-number] = name
        elif (value := _parameter(data, end + 2, stop)) is not None:
            parameters.append((number, name, value))
        if step == 0:
            break
        position = end + step
    return {(groups.get(number, ""), name): value for number, name, value in parameters}


def _parameter(data: bytes, position: int, stop: int) -> Parameter | None:
    if position + 2 > stop:
        return None
    kind, count = struct.unpack_from("bB", data, position)
    begin = position + 2 + count
    if kind not in (-1, 1, 2, 4) or begin > stop or count > 7:
        return None
    sides = tuple(data[position + 2 : begin])
    size = abs(kind)
    for side in sides:
        size *= side
    return Parameter(kind, sides, data[begin : begin + size]) if begin + size <= stop else None


def reals(raw: npt.NDArray[np.uint8], processor: int) -> FloatArray:
    """Single-precision numbers as a processor has them.

    Parameters
    ----------
    raw : ndarray of uint8, shape (..., 4 N)
    processor : int
        1 Intel, 2 DEC (the format of a VAX), 3 MIPS.

    Returns
    -------
    ndarray, shape (..., N)
        NaN where the bytes are not a number.
    """
    raw = np.ascontiguousarray(raw)
    with np.errstate(invalid="ignore"):  # bytes that are no number become NaN
        if processor == _MIPS:
            return raw.view(">f4").astype(np.float64)
        if processor == _INTEL:
            return raw.view("<f4").astype(np.float64)
        words = raw.view("<u2").astype(np.uint32)
        bits = (words[..., 0::2] << 16) | words[..., 1::2]
        values = bits.astype("<u4").view("<f4").astype(np.float64) / 4.0
        return np.where((bits >> 23) & 0xFF == 0, 0.0, values)
