"""Writing comma-separated text: signals and, for spreadsheets, motions as positions or angles of their joints.

Positions are a signal's columns, ``t,Hips.x,Hips.y,Hips.z,...``, in metres, which are read back as points. Angles are
``t,Hips.tx,Hips.ty,Hips.tz,Hips.rz,...``: the root's position in metres and local Euler angles in degrees, in the
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
from kinetograph.signal import Signal
from kinetograph.take import Take

TABLES = ("positions", "angles")
"""What a table of a motion may hold."""


def write(what: Take | Motion | Signal, path: str | Path, options: WriteOptions | None = None) -> None:
    """Write a signal, a take's only signal, or else a motion's table, as CSV.

    Parameters
    ----------
    what : Take, Motion or Signal
        One point named ``path`` becomes a path file.
    path : str or Path
        Written to exactly this path.
    options : WriteOptions, optional
        ``table`` says what a motion's table holds. Times are seconds from 0 and points metres, Y up, whatever the
        options.

    Raises
    ------
    RequestError
        A take has several signals, or neither one signal nor one motion.

    Notes
    -----
    Samples that are not valid are empty cells.
    """
    if isinstance(what, Take):
        signals = any(isinstance(track, Signal) for track in what.tracks.values())
        what = what.signal() if signals else what.motion()
    if isinstance(what, Motion):
        _write_motion(what, Path(path), options or WriteOptions())
    else:
        _write_signal(what, Path(path))


def _write_signal(signal: Signal, path: Path) -> None:
    values = signal.values.reshape(len(signal), -1)
    valid = signal.valid if not signal.spatial else np.repeat(signal.valid, 3, axis=1)
    names = [f"{name}.{axis}" for name in signal.names for axis in "xyz"] if signal.spatial else list(signal.names)
    if signal.spatial and signal.names == ("path",) and valid.all():
        kept = [0, 1, 2] if values[:, 1].any() else [0, 2]
        names, values, valid = ["xyz"[i] for i in kept], values[:, kept], valid[:, kept]
    with path.open("w", encoding="utf-8", newline="") as file:
        if not signal.spatial and signal.units:
            file.write(f"# units: {signal.units}\n")
        if len(signal) == 1:
            file.write(f"# fps: {signal.fps!r}\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["t", *names])
        for frame, (row, good) in enumerate(zip(values.tolist(), valid.tolist(), strict=True)):
            rows.writerow([repr(frame / signal.fps), *(repr(v) if g else "" for v, g in zip(row, good, strict=True))])


def _write_motion(motion: Motion, path: Path, options: WriteOptions) -> None:
    """Write a motion's table."""
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
    with path.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {comment}\n" for comment in comments)
        csv.writer(file, lineterminator="\n").writerow(["t", *header])
        times = np.arange(len(motion)) / motion.fps
        np.savetxt(file, np.column_stack([times, values]), fmt="%.9g", delimiter=",")
