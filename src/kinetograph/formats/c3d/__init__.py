"""C3D files: markers of optical systems, as points; read only.

All three kinds of processor (Intel, DEC, MIPS) and both kinds of numbers (scaled integers and reals) are read. Units
are those of the parameter POINT:UNITS, or else guessed, as is the upward axis. Analog channels and events are not read.
A marker that is missing (negative residual) is not valid.
"""

from __future__ import annotations

from kinetograph.formats.c3d.reader import read

__all__ = ["read"]
