"""DeepMimic motion files: JSON rows of the 15-body humanoid (Peng et al. 2018), metres, Y up, facing +x.

A row is the seconds to the next row, the root's position and quaternion (w, x, y, z), then for each joint a quaternion
or, for the hinges (knees and elbows), one angle about +z: 44 numbers. ``Loop`` says whether the clip is a cycle; the
last row of a ``"wrap"`` clip is the first pose a cycle later (same height and phase; the poses themselves differ by
some degrees in most published clips).
"""

from __future__ import annotations

import json
import math
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.motion import Motion
from kinetograph.sampling import uneven_spline
from kinetograph.skeleton import Landmark, Skeleton
from kinetograph.take import Annotation, Take

# joint, parent, offset in metres, numbers in a row (4: quaternion, 1: angle about +z, 0: rigid); right is +z
_BODY: tuple[tuple[str, str, tuple[float, float, float], int], ...] = (
    ("root", "", (0.0, 0.0, 0.0), 4),
    ("chest", "root", (0.0, 0.236151, 0.0), 4),
    ("neck", "chest", (0.0, 0.223894, 0.0), 4),
    ("right_hip", "root", (0.0, 0.0, 0.084887), 4),
    ("right_knee", "right_hip", (0.0, -0.421546, 0.0), 1),
    ("right_ankle", "right_knee", (0.0, -0.409870, 0.0), 4),
    ("right_shoulder", "chest", (-0.02405, 0.24350, 0.18311), 4),
    ("right_elbow", "right_shoulder", (0.0, -0.274788, 0.0), 1),
    ("right_wrist", "right_elbow", (0.0, -0.258947, 0.0), 0),
    ("left_hip", "root", (0.0, 0.0, -0.084887), 4),
    ("left_knee", "left_hip", (0.0, -0.421546, 0.0), 1),
    ("left_ankle", "left_knee", (0.0, -0.409870, 0.0), 4),
    ("left_shoulder", "chest", (-0.02405, 0.24350, -0.18311), 4),
    ("left_elbow", "left_shoulder", (0.0, -0.274788, 0.0), 1),
    ("left_wrist", "left_elbow", (0.0, -0.258947, 0.0), 0),
)
# the tips of the character's collision shapes: top of the head's sphere, front bottom edge of the feet's boxes
_HEAD_TOP, _TOE_TIP, _HAND_TIP = (0.0, 0.275, 0.0), (0.1335, -0.05, 0.0), (0.0, -0.08, 0.0)
_ENDS = {
    "neck": _HEAD_TOP,
    "right_ankle": _TOE_TIP,
    "right_wrist": _HAND_TIP,
    "left_ankle": _TOE_TIP,
    "left_wrist": _HAND_TIP,
}
_ROLES = {"hips": "root", "chest": "chest", "neck": "neck"} | {
    f"{side}_{role}": f"{side}_{joint}"
    for side in ("left", "right")
    for role, joint in (
        *(("hip", "hip"), ("knee", "knee"), ("foot", "ankle")),
        *(("shoulder", "shoulder"), ("elbow", "elbow"), ("hand", "wrist")),
    )
}
_ROOT_COLUMN = 4
_COLUMNS = tuple(accumulate((width for *_, width in _BODY), initial=_ROOT_COLUMN))
_ROW = _COLUMNS[-1]
_LARGEST = 1e12
_STEADY = 0.01  # of the median duration of a frame
_RATE_TOLERANCE = 1e-4
_SHORTEST_QUATERNION = 0.1  # published clips that were edited go down to 0.58; a zero has no direction


def skeleton() -> Skeleton:
    """The 15 joints of the DeepMimic humanoid, with its roles: up is +y, forward +x and right +z.

    Examples
    --------
    >>> skeleton().landmark("left_toe").offset.tolist()
    [0.1335, -0.05, 0.0]
    """
    names = tuple(name for name, *_ in _BODY)
    roles = {role: Landmark(names.index(joint)) for role, joint in _ROLES.items()}
    roles["head"] = Landmark(names.index("neck"), np.array(_HEAD_TOP))
    for side in ("left", "right"):
        roles[f"{side}_toe"] = Landmark(names.index(f"{side}_ankle"), np.array(_TOE_TIP))
    return Skeleton(
        names,
        np.array([names.index(parent) if parent else -1 for _, parent, *_ in _BODY]),
        np.array([offset for _, _, offset, _ in _BODY]),
        np.array([names.index(joint) for joint in _ENDS]),
        np.array(list(_ENDS.values())),
        roles,
    )


def read(path: str | Path, options: ReadOptions) -> Loaded:
    """Read a DeepMimic motion file as a take.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions
        ``fps`` is the rate; without it, that of the median row. ``lenient`` stops before the first frame that is wrong.

    Returns
    -------
    Loaded
        With the track ``motion``. A clip that loops has an annotation of kind ``"loop"`` and label ``"wrap"`` over
        all of it.

    Raises
    ------
    FormatError
        The file is not JSON or is of another character, or rows have a wrong length or values that are not numbers.

    Notes
    -----
    Where the durations of rows differ by over 1 %, the motion is resampled. Quaternions are brought to unit length and
    to signs without jumps.
    """
    path = Path(path)
    notes: list[str] = []
    if options.units not in (None, "metre") or options.up not in (None, "y"):
        notes.append("DeepMimic files are in metres with Y up; the units and the axis asked for were not applied")
    content = _parse(path)
    frames = content["Frames"]
    if (fault := _first_fault(path, frames)) is not None:
        frame, error = fault
        if not options.lenient or frame == 0:
            raise error
        notes.append(f"left out frames {frame} to {len(frames) - 1}: {error}")
        frames = frames[:frame]
    motion = _motion(path, np.array(frames, dtype=np.float64), options.fps, notes)
    loops = str(content.get("Loop", "none")).lower() == "wrap" and len(frames) == len(content["Frames"])
    annotations = (Annotation("motion", "loop", "wrap", 0.0, motion.duration),) if loops else ()
    return Loaded(Take(path.stem, {"motion": motion}, annotations), tuple(notes))


def _parse(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except json.JSONDecodeError as error:
        message = f"expected DeepMimic JSON, found text that is not: {error.msg}; is the file whole, or another format?"
        raise FormatError(path, message, line=error.lineno) from None
    except (ValueError, RecursionError):  # bytes that are not text, numbers of thousands of digits, endless nesting
        raise FormatError(path, "expected DeepMimic JSON, found text that is not; is it another format?") from None
    if not isinstance(content, dict) or not isinstance(content.get("Frames"), list):
        what = f"the keys {', '.join(list(content)[:8]) or 'none'}" if isinstance(content, dict) else "no object"
        raise FormatError(path, f'expected a DeepMimic object with a list "Frames", found {what}')
    if not content["Frames"]:
        raise FormatError(path, "expected at least one frame, found none")
    return content


def _first_fault(path: Path, frames: list[Any]) -> tuple[int, FormatError] | None:
    """The first frame, counted from 0, that is not 44 finite numbers with real quaternions, and the complaint."""
    for frame, row in enumerate(frames):
        fault = _fault(row, frame, last=frame == len(frames) - 1)
        if fault:
            if frame == 0 and isinstance(row, list) and all(isinstance(r, list) and len(r) == len(row) for r in frames):
                fault += "" if len(row) == _ROW else "; only the 15-body humanoid is read, this is another character"
            return frame, FormatError(path, fault)
    return None


def _fault(row: Any, frame: int, *, last: bool) -> str:
    if not isinstance(row, list) or len(row) != _ROW:
        what = f"{len(row)} numbers" if isinstance(row, list) else json.dumps(row)[:20]
        return f"expected {_ROW} numbers in frame {frame}, found {what}"
    for column, value in enumerate(row):
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < _LARGEST:
            return f"expected a finite number in frame {frame}, column {column}, found {json.dumps(value)[:20]}"
    if row[0] <= 0 and not last:  # the last row has no next one, and in most files says 0
        return f"expected positive seconds to the next frame in frame {frame}, found {row[0]:g}"
    for (name, *_), (start, stop) in zip(_BODY, pairwise(_COLUMNS), strict=True):
        length = math.hypot(*row[start:stop])
        if stop - start == 4 and length < _SHORTEST_QUATERNION:
            return f"expected a unit quaternion in frame {frame}, joint {name}, found length {length:.4g}"
    return ""


def _motion(path: Path, rows: FloatArray, given_fps: float | None, notes: list[str]) -> Motion:
    translation, rotations = rows[:, 1:_ROOT_COLUMN], _rotations(rows)
    steps = rows[:-1, 0] if len(rows) > 1 else rows[:, 0]
    fps = given_fps if given_fps is not None else _rate(path, steps)
    if given_fps is not None or np.ptp(steps) <= _STEADY * np.median(steps):
        return Motion(skeleton(), translation, rotations, fps)
    notes.append(f"frames last {steps.min():.4g} to {steps.max():.4g} s: resampled to {fps:g} frames per second")
    clock = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.arange(round(clock[-1] * fps) + 1) / fps  # rounded, since a clip that loops must keep its last pose
    turned = rot.normalize(uneven_spline(rot.unroll(rotations), clock, wanted))
    return Motion(skeleton(), uneven_spline(translation, clock, wanted), turned, fps)


def _rate(path: Path, steps: FloatArray) -> float:
    """Frames per second of the median step; 60 for the many files that write 0.016666, so that their rates agree."""
    step = float(np.median(steps))
    if step <= 0:
        raise FormatError(
            path, f"expected positive seconds per frame, found {step:g} in frame 0; give the rate with --fps"
        )
    whole = round(1.0 / step)
    return float(whole) if whole and abs(1.0 / step - whole) < _RATE_TOLERANCE * whole else 1.0 / step


def _rotations(rows: FloatArray) -> FloatArray:
    """Local rotations, shape ``(F, 15, 4)``, of rows, shape ``(F, 44)``."""
    out = rot.identity(len(rows), len(_BODY))
    for joint, (start, stop) in enumerate(pairwise(_COLUMNS)):
        if stop - start == 4:
            out[:, joint] = rot.normalize(rows[:, start:stop])
        elif stop - start == 1:
            out[:, joint] = rot.about("z", rows[:, start])
    return rot.unroll(out)
