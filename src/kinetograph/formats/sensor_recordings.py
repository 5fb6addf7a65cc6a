"""Readers of public recordings of real sensors: Xsens text, the qmt toolbox's MATLAB file, UTD-MHAD, Vicon tables."""

from __future__ import annotations

import re
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.motion import Motion
from kinetograph.sensing import GRAVITY, Readings
from kinetograph.skeleton import Landmark, Skeleton

XSENS_COLUMNS = ("Acc_X", "Acc_Y", "Acc_Z", "Gyr_X", "Gyr_Y", "Gyr_Z")
XSENS_ROTATIONS = ("Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3")
_LARGEST, _SHORTEST = 1e12, 1e-6
_TO_Y_UP = rot.about("x", -np.pi / 2)


def read_xsens(path: str | Path, name: str, fps: float = 100.0) -> Readings:
    """Read one sensor from an MT Manager text file.

    Parameters
    ----------
    path : str or Path
    name : str
        The sensor's.
    fps : float
        Rows per second.

    Returns
    -------
    Readings
        Specific force in m/s^2, angular velocity in rad/s, and, where there are columns of quaternions (whose world has
        Z up), orientations in a world with Y up.

    Raises
    ------
    FormatError
        For a file without the columns.
    """
    path = Path(path)
    lines = _lines(path)
    header = lines[0][1] if lines else []
    missing = [column for column in XSENS_COLUMNS if column not in header]
    if missing:
        raise FormatError(path, f"expected columns {', '.join(XSENS_COLUMNS)}, found none called {missing[0]}")
    quaternions = XSENS_ROTATIONS if set(XSENS_ROTATIONS) <= set(header) else ()
    rows = _numbers(path, lines, [*XSENS_COLUMNS, *quaternions])
    times = np.arange(len(rows)) / fps
    facing = rot.multiply(_TO_Y_UP, rot.normalize(rows[:, 6:])) if quaternions else None
    return Readings((name,), times, np.zeros(len(rows), dtype=np.int64), rows[:, :3], rows[:, 3:6], facing)


def read_qmt(path: str | Path, names: dict[str, str]) -> Readings:
    """Read the qmt toolbox's full-body recording.

    Parameters
    ----------
    path : str or Path
    names : dict
        Names of the sensors to read: in the file, and in the readings.

    Returns
    -------
    Readings

    Raises
    ------
    FormatError
        For a file without such a sensor.
    """
    table = _matlab(Path(path), squeeze_me=True)
    missing = [name for name in names if name not in table]
    if missing or "t" not in table:
        raise FormatError(path, f"expected sensors {', '.join(names)} and t, found no {(*missing, 't')[0]!r}")
    times = _array(path, "t", table["t"], (-1,))
    parts = {}
    for key, name in names.items():
        fields = table[key].dtype.names if isinstance(table[key], np.ndarray) else None
        if not {"acc", "gyr"} <= set(fields or ()) or table[key].size != 1:
            raise FormatError(path, f"expected fields acc and gyr of {key!r}, found {', '.join(fields or ('none',))}")
        force, angular = (
            _array(path, f"{key}.{field}", table[key][field].item(), (len(times), 3)) for field in ("acc", "gyr")
        )
        parts[name] = Readings((name,), times, np.zeros(len(times), dtype=np.int64), force, angular)
    return merge_sensors(parts)


def read_utd(path: str | Path, name: str) -> Readings:
    """Read UTD-MHAD's inertial file: one sensor at 50 Hz, in g and degrees per second, without times.

    Parameters
    ----------
    path : str or Path
    name : str
        The sensor's.

    Returns
    -------
    Readings

    Raises
    ------
    FormatError
        For another file.
    """
    table = _matlab(Path(path))
    if "d_iner" not in table:
        raise FormatError(path, "expected a matrix d_iner of 6 columns")
    rows = _array(path, "d_iner", table["d_iner"], (-1, 6))
    times = np.arange(len(rows)) / 50.0
    return Readings((name,), times, np.zeros(len(rows), dtype=np.int64), rows[:, :3] * GRAVITY, np.radians(rows[:, 3:]))


def merge_sensors(parts: dict[str, Readings]) -> Readings:
    """The readings of several sensors as one.

    Parameters
    ----------
    parts : dict
        Readings of one sensor each, by name.

    Returns
    -------
    Readings
        With the angular velocities and orientations that all have.
    """
    rows = list(parts.values())
    angular = [part.angular for part in rows if part.angular is not None]
    facing = [part.orientation for part in rows if part.orientation is not None]
    return Readings(
        tuple(parts),
        np.concatenate([part.times for part in rows]),
        np.concatenate([np.full(len(part), i) for i, part in enumerate(rows)]),
        np.concatenate([part.force for part in rows]),
        np.concatenate(angular) if len(angular) == len(rows) else None,
        np.concatenate(facing) if len(facing) == len(rows) else None,
    )


def read_vicon_rotations(path: str | Path) -> tuple[dict[str, FloatArray], int]:
    """Read the rotations of segments from a neura Vicon table.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    rotations : dict
        Quaternions, shape (F, 4), by segment.
    start : int
        The sensors' frame that the table begins at.

    Raises
    ------
    FormatError
        For a table without this frame.
    """
    path = Path(path)
    start = re.search(r"^// idx=[ \t]*([0-9]{1,9})[ \t]*,", _latin(path), re.MULTILINE)
    if start is None:
        raise FormatError(path, "expected a line '// idx=first,last'")
    lines = _lines(path)
    header = lines[0][1] if lines else []
    stems = sorted({name[:-2] for name in header if name.startswith("q")})
    wanted = [f"{stem}_{i}" for stem in stems for i in range(1, 5)]
    missing = [name for name in wanted if name not in header]
    if missing or not wanted:
        raise FormatError(path, f"expected columns q..._1 to q..._4, found none called {(*missing, 'q..._1')[0]}")
    rows = _numbers(path, lines, wanted).reshape(-1, len(stems), 4)
    if not (np.linalg.norm(rows, axis=-1) > _SHORTEST).all():
        raise FormatError(path, "expected unit quaternions, found one of length 0")
    return {stem: rot.normalize(rows[:, i]) for i, stem in enumerate(stems)}, int(start[1]) - 1


def _latin(path: Path) -> str:
    try:
        return path.read_text(encoding="latin-1")
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """The cells, between commas or tabs, of lines that are neither blank nor comments, with the lines' numbers."""
    return [
        (number, [cell.strip() for cell in line.replace("\t", ",").split(",")])
        for number, line in enumerate(_latin(path).splitlines(), start=1)
        if line.strip() and not line.startswith("//")
    ]


def _numbers(path: Path, lines: list[tuple[int, list[str]]], columns: list[str]) -> FloatArray:
    """The numbers in some columns of a table whose first line has their names, shape ``(rows, columns)``."""
    used = [lines[0][1].index(column) for column in columns]
    rows = np.full((len(lines) - 1, len(used)), np.nan)
    for row, (number, cells) in enumerate(lines[1:]):
        for i, (at, column) in enumerate(zip(used, columns, strict=True)):
            cell = cells[at] if at < len(cells) else ""
            with suppress(ValueError):
                rows[row, i] = float(cell)
            if not abs(rows[row, i]) < _LARGEST:
                raise FormatError(path, f"expected a finite number in {column!r}, found {cell[:30]!r}", line=number)
    if not len(rows):
        raise FormatError(path, "expected rows of numbers below the header, found none")
    return rows


def _matlab(path: Path, *, squeeze_me: bool = False) -> dict[str, Any]:
    """What is in a MATLAB file."""
    from scipy.io import loadmat

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            table: dict[str, Any] = loadmat(path, squeeze_me=squeeze_me)
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    except Exception as error:  # whatever SciPy meets in a damaged file
        raise FormatError(path, f"expected a MATLAB file, found: {str(error)[:100] or type(error).__name__}") from None
    return table


def _array(path: str | Path, name: str, value: Any, shape: tuple[int, ...]) -> FloatArray:
    """Finite numbers of a shape, of which -1 may be any length but 0."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
    fits = array.ndim == len(shape) and all(want in (-1, size) for want, size in zip(shape, array.shape, strict=True))
    if not (fits and array.size and (np.abs(array) < _LARGEST).all()):
        wanted = " x ".join("any" if size < 0 else str(size) for size in shape)
        raise FormatError(path, f"expected {wanted} finite numbers in {name!r}, found {array.shape}")
    return array


_KINECT = (
    ("hips", -1), ("spine", 0), ("shoulder_center", 1), ("head", 2),
    ("left_shoulder", 2), ("left_elbow", 4), ("left_wrist", 5), ("left_hand", 6),
    ("right_shoulder", 2), ("right_elbow", 8), ("right_wrist", 9), ("right_hand", 10),
    ("left_hip", 0), ("left_knee", 12), ("left_ankle", 13), ("left_foot", 14),
    ("right_hip", 0), ("right_knee", 16), ("right_ankle", 17), ("right_foot", 18),
)  # fmt: skip
_FILE_ORDER = (3, 2, 1, 0, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19)  # its rows: head first
_ROLES = {
    "hips": "hips", "head": "head", "chest": "shoulder_center",
    **{f"{s}_{role}": f"{s}_{name}" for s in ("left", "right") for role, name in (
        ("shoulder", "shoulder"), ("elbow", "elbow"), ("hand", "wrist"), ("hip", "hip"), ("knee", "knee"),
        ("foot", "ankle"), ("toe", "foot"))},
}  # fmt: skip


def read_kinect(path: str | Path, fps: float = 30.0, smooth: float = 3.0, seconds: float | None = None) -> Motion:
    """Read UTD-MHAD's Kinect skeleton, whose joints are only points, as a motion.

    Bones are given their median length; each joint takes the least rotation that brings its bones to the points.

    Parameters
    ----------
    path : str or Path
    fps : float
        Frames per second; the file does not say.
    smooth : float
        Frames of a Gaussian over the points, which shake by centimetres from frame to frame.
    seconds : float, optional
        That the frames span, in place of ``fps``: the files of UTD-MHAD span those of its inertial sensor.

    Returns
    -------
    Motion

    Raises
    ------
    FormatError
        For another file.
    """
    from scipy.ndimage import gaussian_filter1d

    table = _matlab(Path(path))
    if "d_skel" not in table:
        raise FormatError(path, "expected an array d_skel (20, 3, F)")
    # the camera looks along z with y up: rotated about y, the person faces +z
    points = np.moveaxis(_array(path, "d_skel", table["d_skel"], (20, 3, -1)), 2, 0) * [-1.0, 1.0, -1.0]
    fps = fps if seconds is None else (len(points) - 1) / seconds
    points = gaussian_filter1d(points, smooth, axis=0, mode="nearest")
    ordered = np.empty_like(points)
    for row, joint in enumerate(_FILE_ORDER):
        ordered[:, joint] = points[:, row]
    return motion_of_points(ordered, fps)


def motion_of_points(points: FloatArray, fps: float) -> Motion:
    """A motion of the Kinect's 20 joints from their positions.

    Parameters
    ----------
    points : ndarray, shape (F, 20, 3)
        In metres.
    fps : float

    Returns
    -------
    Motion
    """
    names = tuple(name for name, _ in _KINECT)
    parents = np.array([parent for _, parent in _KINECT])
    rest = _rest(points, parents)
    roles = {role: Landmark(names.index(name)) for role, name in _ROLES.items()}
    skeleton = Skeleton(names, parents, rest, roles=roles)
    world = np.empty((*points.shape[:2], 4))
    for joint in range(points.shape[1]):
        above = world[:, parents[joint]] if joint else rot.identity(len(points))
        children = np.flatnonzero(parents == joint)
        world[:, joint] = _bone_rotations(points[:, children] - points[:, joint, None], rest[children], above)
    local = world.copy()
    local[:, 1:] = rot.multiply(rot.conjugate(world[:, parents[1:]]), world[:, 1:])
    return Motion(skeleton, points[:, 0], rot.normalize(rot.unroll(local)), fps)


def _bone_rotations(bones: FloatArray, rest: FloatArray, above: FloatArray) -> FloatArray:
    """World rotations, ``(F, 4)``, of a joint with bones ``(F, C, 3)``, at rest ``(C, 3)``; ``above`` its parent's."""
    if len(rest) == 0:
        return above
    if len(rest) == 1:
        return rot.multiply(rot.between(rot.rotate(above, rest[0]), bones[:, 0]), above)
    u, _, vt = np.linalg.svd(np.einsum("fci,cj->fij", bones, rest))
    handed = np.ones((len(bones), 3))
    handed[:, 2] = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    return rot.from_matrix((u * handed[:, None]) @ vt)


def _rest(points: FloatArray, parents: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> FloatArray:
    """Offsets of a person who stands with hanging arms, with the points' median bone lengths."""
    down, up = np.array([0.0, -1.0, 0.0]), np.array([0.0, 1.0, 0.0])
    rest = np.zeros((len(parents), 3))
    for joint, parent in enumerate(parents):
        if parent < 0:
            continue
        length = float(np.median(np.linalg.norm(points[:, joint] - points[:, parent], axis=1)))
        name = _KINECT[joint][0]
        direction = up if name in ("spine", "shoulder_center", "head") else down
        if name.endswith(("shoulder", "hip")):
            direction = np.array([1.0 if name.startswith("left") else -1.0, -0.3, 0.0])
        if name.endswith("foot"):
            direction = np.array([0.0, -0.3, 1.0])
        rest[joint] = length * direction / np.linalg.norm(direction)
    return rest
