"""How BVH files of this package say their units and axes: BVH has no place for them, and no comments.

``Frame Time`` is written to twelve decimals, a picosecond, and eight more digits follow. They say who wrote the file
and what its numbers mean; to other programs they are decimals of a time like any others.
"""

from __future__ import annotations

import re

from kinetograph.formats.conventions import UPS

_DECIMALS = 12
_BEGIN, _END = "8614", "73"  # around a digit for the units and one for the axis
_UNITS = ("metre", "centimetre", "millimetre", "inch", "foot", "cmu")  # in this order for ever
_STAMP = re.compile(rf"(\d+\.\d{{{_DECIMALS}}}){_BEGIN}(\d)(\d){_END}")
_LINE = re.compile(rb"\s*Frames:\s*\S+\s*Frame\s*Time:\s*(\S+)", re.IGNORECASE)


def stamped(fps: float, units: str, up: str) -> str:
    """The frame time of a rate, with what the file's numbers mean.

    Parameters
    ----------
    fps : float
    units : str
        A name in `UNITS`.
    up : {"x", "y", "z"}

    Returns
    -------
    str

    Examples
    --------
    >>> stamped(30.0, "metre", "y")
    '0.03333333333386141273'
    """
    return f"{1.0 / fps:.{_DECIMALS}f}{_BEGIN}{_UNITS.index(units) + 1}{UPS.index(up) + 1}{_END}"


def read_stamp(text: bytes) -> tuple[bytes, tuple[str, str] | None]:
    """A frame time without the stamp, and the units and the upward axis that it says; None without one.

    Examples
    --------
    >>> read_stamp(b"0.03333333333386141273")
    (b'0.033333333333', ('metre', 'y'))
    >>> read_stamp(b"0.0333333")
    (b'0.0333333', None)
    """
    match = _STAMP.fullmatch(text.decode("latin-1"))
    if match is None or not (0 < int(match[2]) <= len(_UNITS) and 0 < int(match[3]) <= len(UPS)):
        return text, None
    return match[1].encode(), (_UNITS[int(match[2]) - 1], UPS[int(match[3]) - 1])


def meaning(data: bytes, position: int) -> tuple[str | None, str | None]:
    """The units and the upward axis that a file of this package says; None twice of another file.

    Parameters
    ----------
    data : bytes
    position : int
        The byte after the word MOTION.

    Returns
    -------
    units, up : str or None
    """
    match = _LINE.match(data, position)
    said = None if match is None else read_stamp(match[1])[1]
    return (None, None) if said is None else said
