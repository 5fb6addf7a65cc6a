"""Readers of public recordings of real sensors: Xsens text, the qmt toolbox's MATLAB file, UTD-MHAD, Vicon tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.motion import Motion
from kinetograph.sensing import GRAVITY, Readings
from kinetograph.skeleton import Landmark, Skeleton

XSENS_COLUMNS = ("Acc_X", "Acc_Y", "Acc_Z", "Gyr_X", "Gyr_Y", "Gyr_Z")
XSENS_ROTATIONS = ("Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3")
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
    with path.open(encoding="latin-1") as file:
        lines = [line for line in file if not line.startswith("//")]
    header = [cell.strip() for cell in lines[0].replace("\t", ",").split(",")] if lines else []
    missing = [column for column in XSENS_COLUMNS if column not in header]
    if missing:
        raise FormatError(path, f"expected columns {', '.join(XSENS_COLUMNS)}, found none called {missing[0]}")
    quaternions = XSENS_ROTATIONS if set(XSENS_ROTATIONS) <= set(header) else ()
    used = [header.index(column) for column in (*XSENS_COLUMNS, *quaternions)]
    rows = np.array(
        [[float(line.replace("\t", ",").split(",")[i]) for i in used] for line in lines[1:] if line.strip()]
    )
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
    from scipy.io import loadmat

    table = loadmat(path, squeeze_me=True)
    missing = [name for name in names if name not in table]
    if missing or "t" not in table:
        raise FormatError(path, f"expected sensors {', '.join(names)} and t, found no {(*missing, 't')[0]!r}")
    return merge_sensors({
        name: Readings(
            (name,),
            np.asarray(table["t"], dtype=np.float64),
            np.zeros(len(table["t"]), dtype=np.int64),
            table[key]["acc"].item(),
            table[key]["gyr"].item(),
        )
        for key, name in names.items()
    })  # fmt: skip


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
    from scipy.io import loadmat

    table = loadmat(path)
    if "d_iner" not in table:
        raise FormatError(path, "expected a matrix d_iner of 6 columns")
    rows = np.asarray(table["d_iner"], dtype=np.float64)
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
    lines = path.read_text(encoding="latin-1").splitlines()
    comments = [line for line in lines if line.startswith("//")]
    start = [line.partition("=")[2] for line in comments if line.startswith("// idx=")]
    if not start:
        raise FormatError(path, "expected a line '// idx=first,last'")
    body = [line for line in lines if not line.startswith("//") and line.strip()]
    header = body[0].split(",")
    rows = np.array([[float(cell) for cell in line.split(",")] for line in body[1:]])
    stems = sorted({name[:-2] for name in header if name.startswith("q")})
    rotations = {stem: rot.normalize(rows[:, [header.index(f"{stem}_{i}") for i in range(1, 5)]]) for stem in stems}
    return rotations, int(start[0].split(",")[0]) - 1


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


def read_kinect(path: str | Path, fps: float = 30.0, smooth: float = 0.1) -> Motion:
    """Read UTD-MHAD's Kinect skeleton, whose joints are only points, as a motion.

    Bones are given their median length; each joint takes the least rotation that brings its bones to the points.

    Parameters
    ----------
    path : str or Path
    fps : float
        Frames per second.
    smooth : float
        Seconds of a Gaussian over the points, which shake by centimetres.

    Returns
    -------
    Motion

    Raises
    ------
    FormatError
        For another file.
    """
    from scipy.io import loadmat
    from scipy.ndimage import gaussian_filter1d

    table = loadmat(path)
    if "d_skel" not in table:
        raise FormatError(path, "expected an array d_skel (20, 3, F)")
    # the camera looks along z with y up: rotated about y, the person faces +z
    points = np.moveaxis(np.asarray(table["d_skel"], dtype=np.float64), 2, 0) * [-1.0, 1.0, -1.0]
    points = gaussian_filter1d(points, smooth * fps, axis=0, mode="nearest")
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
