"""Motions as comma-separated text, for spreadsheets: positions of joints, or their angles.

Positions are a signal's columns, ``t,Hips.x,Hips.y,Hips.z,...``, in metres, which `csv.read` reads as points. Angles
are ``t,Hips.tx,Hips.ty,Hips.tz,Hips.rz,...``: the root's place in metres and local Euler angles in degrees, in the
order that the comment on the first line names.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.formats.options import WriteOptions
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion

TABLES = ("positions", "angles")


def write_motion(motion: Motion, path: str | Path, options: WriteOptions) -> None:
    """Write a motion's table to exactly ``path``. Raises RequestError for a table that is not known."""
    if options.table not in TABLES:
        raise RequestError(f"a CSV of a motion holds one of {', '.join(TABLES)}, found {options.table!r}")
    names = motion.skeleton.names
    if options.table == "positions":
        comments = [f"units: m, Y up; {len(motion)} frames at {motion.fps!r} fps"]
        header = [f"{name}.{axis}" for name in names for axis in "xyz"]
        values = joint_positions(motion).reshape(len(motion), -1)
    else:
        order = options.order.lower()
        comments = [f"angles: degrees, intrinsic {order.upper()}, outermost first; root in m, Y up"]
        header = [f"{names[0]}.t{axis}" for axis in "xyz"] + [f"{name}.r{axis}" for name in names for axis in order]
        angles = np.degrees(np.unwrap(rot.to_euler(motion.rotations, order), axis=0))
        values = np.concatenate([motion.translation, angles.reshape(len(motion), -1)], axis=1)
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {comment}\n" for comment in comments)
        csv.writer(file, lineterminator="\n").writerow(["t", *header])
        times = np.arange(len(motion)) / motion.fps
        np.savetxt(file, np.column_stack([times, values]), fmt="%.9g", delimiter=",")
