"""Compiled kernels of the readers: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray, IntArray

DONE, WRONG_LENGTH, NOT_A_NUMBER = 0, 1, 2
_POWERS = 10.0 ** np.arange(23)  # exact in double precision up to 10^22
_DIGITS = 18  # the most that a signed 64-bit integer surely holds


@numba.njit(cache=True, nogil=True)
def _number(text: npt.NDArray[np.uint8], position: int) -> tuple[float, int, bool]:
    """The number that begins at a byte, the byte after it, and whether it is one."""
    size = len(text)
    negative = text[position] == 45
    if negative or text[position] == 43:
        position += 1
    mantissa = 0
    digits = kept = exponent = 0
    pointed = False
    while position < size:
        byte = text[position]
        if 48 <= byte <= 57:
            digits += 1
            if kept < _DIGITS:
                mantissa = mantissa * 10 + (int(byte) - 48)
                kept += 1 if mantissa > 0 else 0
                exponent -= 1 if pointed else 0
            elif not pointed:
                exponent += 1
        elif byte == 46 and not pointed:
            pointed = True
        else:
            break
        position += 1
    if digits > 0 and position < size and (text[position] == 69 or text[position] == 101):
        power, position, digits = _exponent(text, position + 1)
        exponent += power
    good = digits > 0 and (position == size or text[position] <= 32)
    number = _scaled(float(mantissa), exponent)
    return (-number if negative else number), position, good


@numba.njit(cache=True, nogil=True)
def _exponent(text: npt.NDArray[np.uint8], position: int) -> tuple[int, int, int]:
    """The whole number that begins at a byte, the byte after it, and how many digits it has."""
    size = len(text)
    negative = position < size and text[position] == 45
    if position < size and (text[position] == 45 or text[position] == 43):
        position += 1
    power = digits = 0
    while position < size and 48 <= text[position] <= 57:
        power = min(power * 10 + (int(text[position]) - 48), 100_000)
        digits += 1
        position += 1
    return (-power if negative else power), position, digits


@numba.njit(cache=True, nogil=True)
def _scaled(mantissa: float, exponent: int) -> float:
    """``mantissa * 10**exponent``: exactly rounded where both are exact, as numbers in files nearly always are."""
    if exponent == 0 or mantissa == 0.0:
        return mantissa
    if -22 <= exponent < 0:
        return float(mantissa / _POWERS[-exponent])
    if 0 < exponent <= 22:
        return float(mantissa * _POWERS[exponent])
    if exponent < -300:  # in two steps, as 10^-exponent alone would overflow
        return mantissa / 10.0**300 * 10.0 ** (exponent + 300)
    return mantissa * 10.0**exponent


@numba.njit(cache=True, nogil=True)
def parse_rows(
    text: npt.NDArray[np.uint8], position: int, line: int, values: FloatArray, largest: float
) -> tuple[int, int, int, int]:
    """Parse lines of decimal numbers; blank lines are skipped.

    Parameters
    ----------
    text : ndarray of uint8
        The file's bytes.
    position, line : int
        The byte to begin at, and its line.
    values : ndarray, shape (rows at most, width)
        Written in place. Numbers are right to a few units in the last place.
    largest : float
        Numbers beyond it, to either side, are none.

    Returns
    -------
    rows : int
        Rows read.
    status : int
        ``DONE``, ``WRONG_LENGTH`` or ``NOT_A_NUMBER``.
    line : int
        The line where reading stopped.
    detail : int
        For ``WRONG_LENGTH`` the number of values on the line, for ``NOT_A_NUMBER`` the byte where the word begins,
        else 0.
    """
    size = len(text)
    room, width = values.shape
    row = column = 0
    while True:
        while position < size and text[position] <= 32 and text[position] != 10:
            position += 1
        if position == size or text[position] == 10:
            if column > 0:
                if column != width:
                    return row, WRONG_LENGTH, line, column
                row += 1
                column = 0
            if position == size:
                return row, DONE, line, 0
            line += 1
            position += 1
            continue
        number, after, good = _number(text, position)
        if not good or not abs(number) <= largest:
            return row, NOT_A_NUMBER, line, position
        position = after
        if row < room and column < width:
            values[row, column] = number
        column += 1


@numba.njit(cache=True, nogil=True)
def rotations_of_channels(values: FloatArray, columns: IntArray, axes: IntArray) -> FloatArray:
    """Quaternions of Euler angles.

    Parameters
    ----------
    values : ndarray, shape (F, C)
        Channels, degrees.
    columns : ndarray of int, shape (J, K)
        The channels that rotate each joint, the first one outermost; -1 ends a shorter list.
    axes : ndarray of int, shape (J, K)
        0, 1 or 2 for x, y or z.

    Returns
    -------
    ndarray, shape (F, J, 4)
    """
    frames, joints = len(values), len(columns)
    out = np.empty((frames, joints, 4))
    half = np.pi / 360.0
    for frame in range(frames):
        for joint in range(joints):
            w, x, y, z = 1.0, 0.0, 0.0, 0.0
            for k in range(columns.shape[1]):
                if columns[joint, k] < 0:
                    break
                angle = values[frame, columns[joint, k]] * half
                c, s = np.cos(angle), np.sin(angle)
                if axes[joint, k] == 0:
                    w, x, y, z = w * c - x * s, x * c + w * s, y * c + z * s, z * c - y * s
                elif axes[joint, k] == 1:
                    w, x, y, z = w * c - y * s, x * c - z * s, y * c + w * s, z * c + x * s
                else:
                    w, x, y, z = w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s
            out[frame, joint, 0] = w
            out[frame, joint, 1] = x
            out[frame, joint, 2] = y
            out[frame, joint, 3] = z
    return out
