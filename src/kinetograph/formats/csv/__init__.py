"""Comma-separated text: paths and signals, read and written, and motions as tables, written only.

A path has the header ``t,x,z`` or ``t,x,y,z``: seconds and metres. A signal has ``t,name,...``, one column per channel,
or ``t,hand.x,hand.y,hand.z,...``, three per point. Semicolons and tabs separate as well (numbers may then have decimal
commas). Lines that begin with ``#`` are comments, of which ``# units: m/s^2`` and ``# fps: 100`` are read. An empty
cell is a missing sample. Rows that are not evenly spaced are interpolated linearly.
"""

from __future__ import annotations

from kinetograph.formats.csv.reader import path_of, read
from kinetograph.formats.csv.writer import write

__all__ = ["path_of", "read", "write"]
