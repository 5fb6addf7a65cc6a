"""Poses of SMPL bodies in their many spellings: names of arrays, forms of rotations, units of translations.

A pose is one array (``poses``, ``smpl_poses``, ``fullpose``, ...) or two (``global_orient`` and ``body_pose``). Its
rotations are rotation vectors, matrices, or the first two columns or rows of matrices; flat or with an axis for the
joints. What a file does not say is found from its numbers: matrices are orthogonal, knees bend backwards, and feet that
stand do not move, which gives the unit of the translation.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.numpy_arrays import Arrays

WHOLE = ("poses", "pose", "smpl_poses", "smpl_pose", "fullpose", "full_pose", "pose_aa")
"""Names of arrays with all joints' rotations; without the first joint's where there are 21 or 23."""

BODY = ("pose_body", "body_pose", "smpl_body_pose")
"""Names of arrays with the rotations of all joints but the first."""

ROOT = ("root_orient", "global_orient", "smpl_global_orient", "orient", "root_pose")
"""Names of arrays with the first joint's rotations."""

TRANSLATIONS = ("trans", "transl", "smpl_trans", "smpl_transl", "root_translation", "root_trans", "translation")
"""Names of arrays with the body's translation."""

RATES = ("mocap_framerate", "mocap_frame_rate", "mocap_fps", "fps", "frame_rate", "framerate", "FPS")
"""Names of the frames per second."""

SCALES = ("smpl_scaling", "scaling")
"""Names of the body's size in units of the translation."""

SMPL_ARRAYS = frozenset((*WHOLE, *BODY, *ROOT, *TRANSLATIONS, *RATES, *SCALES, "joint_offsets"))
"""All names of arrays that mean something in a file of SMPL poses."""

JOINTS = 22
"""Joints of a body without hands and face, the first ones of every body of the family."""

_WITHOUT_ROOT = (21, 23)
_LARGEST = 1e6
_ORTHOGONAL = 0.02  # how far products of a matrix's columns may be from what they should be
_KNEES = (4, 5)
_BENT = 0.05  # radians, in the mean


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses in a file, in its own axes.

    Parameters
    ----------
    rotations : ndarray, shape (F, 22, 4)
        Local.
    translation : ndarray, shape (F, 3)
        In the file's unit.
    scale : float or None
        The body's size in that unit, where the file says it.
    kind : {"amass", "aist", ""}
        Whose file it is, where its names say so.
    """

    rotations: FloatArray
    translation: FloatArray
    scale: float | None
    kind: str


def read_poses(path: Path, arrays: Arrays, notes: list[str]) -> Poses:
    """Read the poses out of a file's arrays.

    Parameters
    ----------
    path : Path
        For errors.
    arrays : dict of str to ndarray
    notes : list of str
        Gets a line on each thing that is assumed or left out.

    Returns
    -------
    Poses

    Raises
    ------
    FormatError
        There are no poses, or arrays have another shape.
    """
    name = next((key for key in (*WHOLE, *BODY) if key in arrays), None)
    if name is None:
        known = ", ".join((*WHOLE[:3], *BODY[:1]))
        raise FormatError(path, f"expected poses ({known}, ...) and trans, or this package's own arrays; found neither")
    rotations = _rotations(path, name, arrays[name], notes)
    if rotations.shape[1] in _WITHOUT_ROOT:
        rotations = np.concatenate([_root(path, arrays, len(rotations), notes), rotations], axis=1)
    count = rotations.shape[1]
    if count < JOINTS:
        raise FormatError(path, f"expected {name} of {JOINTS} joints or more, found {count} in {arrays[name].shape}")
    if count > JOINTS:
        notes.append(f"{count} joints: the body's {JOINTS} are read, not fingers and face")
    kind = "aist" if name.startswith("smpl_poses") else "amass" if any(key in arrays for key in RATES[:2]) else ""
    moved = _translation(path, arrays, len(rotations), notes)
    return Poses(rotations[:, :JOINTS], moved, _scale(path, arrays), kind)


def read_rate(path: Path, arrays: Arrays, given: float | None, kind: str, notes: list[str]) -> float:
    """Frames per second of a file.

    Parameters
    ----------
    path : Path
        For errors.
    arrays : dict of str to ndarray
    given : float or None
        In place of the file's.
    kind : str
        See `Poses`.
    notes : list of str

    Returns
    -------
    float

    Raises
    ------
    FormatError
        The file gives no rate, and none is given.
    """
    said = next((arrays[key] for key in RATES if key in arrays), None)
    fps = given if given is not None else 0.0 if said is None or said.size != 1 else float(said.reshape(-1)[0])
    if given is None and said is None and kind == "aist":
        notes.append("rate not given: 60 frames per second, as in AIST++; say another with --fps")
        return 60.0
    if not (np.isfinite(fps) and 0 < fps < 1e5):
        raise FormatError(path, f"the file gives no rate ({RATES[0]}); give it with --fps")
    return fps


def _rotations(path: Path, name: str, values: np.ndarray, notes: list[str]) -> FloatArray:
    """Rotations ``(F, K, 4)`` from any of their forms."""
    whole = _numbers(path, name, values)
    shape = whole.shape
    if whole.ndim == 5 or (whole.ndim == 4 and shape[-2:] != (3, 3)) or (whole.ndim == 3 and shape[-1] > 9):
        if shape[0] != 1:
            raise FormatError(path, f"expected one recording in {name}, found {shape[0]}: save one of them by itself")
        whole = whole[0]
    frames = len(whole)
    if whole.ndim < 2 or frames == 0:
        raise FormatError(path, f"expected rows of poses in {name}, found {shape}")
    per_joint = 9 if whole.ndim > 2 and whole.shape[-2:] == (3, 3) else whole.shape[-1] if whole.ndim == 3 else 0
    flat = whole.reshape(frames, -1)
    forms = {9: _of_matrices, 6: _of_columns, 3: _of_vectors}
    for size, read in forms.items():
        if flat.shape[1] % size == 0 and per_joint in (0, size):
            rows = flat.reshape(frames, -1, size)
            if (found := read(rows, notes)) is not None:
                return found
    raise FormatError(
        path,
        f"expected {name} as rotation vectors (F, 66, 72, 156, ...), matrices or six numbers per joint, found {shape}",
    )


def _numbers(path: Path, name: str, values: np.ndarray) -> FloatArray:
    numbers = np.asarray(values, dtype=np.float64)
    if not np.all(np.abs(numbers) < _LARGEST):
        raise FormatError(path, f"expected finite numbers as poses and translations; {name} has others")
    return numbers


def _of_vectors(rows: FloatArray, notes: list[str]) -> FloatArray:
    return rot.exp(rows)


def _of_matrices(rows: FloatArray, notes: list[str]) -> FloatArray | None:
    """Rotations of matrices ``(F, K, 9)``; None where they are not orthogonal."""
    matrices = rows.reshape(*rows.shape[:2], 3, 3)
    products = np.einsum("fkab,fkac->fkbc", matrices, matrices)
    if np.abs(products - np.eye(3)).max() > _ORTHOGONAL or np.linalg.det(matrices).min() < 0:
        return None
    notes.append("poses are rotation matrices")
    return rot.normalize(rot.from_matrix(matrices))


def _of_columns(rows: FloatArray, notes: list[str]) -> FloatArray | None:
    """Rotations of six numbers ``(F, K, 6)``; None where they are not two perpendicular unit vectors.

    The two are the matrix's first columns, one after the other or side by side, or its first rows, which give the
    inverse rotations: knees, which bend one way only, tell these apart.
    """
    for pairs in (rows.reshape(*rows.shape[:2], 2, 3), np.swapaxes(rows.reshape(*rows.shape[:2], 3, 2), 2, 3)):
        products = np.einsum("fkai,fkbi->fkab", pairs, pairs)
        if np.abs(products - np.eye(2)).max() > _ORTHOGONAL:
            continue
        first, second = pairs[..., 0, :], pairs[..., 1, :]
        columns = rot.normalize(rot.from_matrix(np.stack([first, second, np.cross(first, second)], axis=-1)))
        bend = _knee_bend(columns)
        notes.append(
            f"poses are six numbers per joint, the first two {'rows' if bend < -_BENT else 'columns'} of a matrix"
        )
        return rot.conjugate(columns) if bend < -_BENT else columns
    return None


def _knee_bend(rotations: FloatArray) -> float:
    """Mean rotation of the knees about x, in radians: positive on every body."""
    first = 0 if rotations.shape[1] not in _WITHOUT_ROOT else 1
    if rotations.shape[1] <= max(_KNEES):
        return 0.0
    return float(rot.log(rotations[:, [knee - first for knee in _KNEES]])[..., 0].mean())


def _root(path: Path, arrays: Arrays, frames: int, notes: list[str]) -> FloatArray:
    """The first joint's rotations ``(F, 1, 4)``."""
    name = next((key for key in ROOT if key in arrays), None)
    if name is None:
        notes.append("the file has no orientation of the body (global_orient): it faces one way")
        return rot.identity(frames, 1)
    values = np.asarray(arrays[name])
    if values.size % frames or values.size // frames not in (3, 6, 9):
        raise FormatError(path, f"expected {name} of {frames} frames, found {values.shape}")
    return _rotations(path, name, values.reshape(frames, 1, *((3, 3) if values.size == 9 * frames else (-1,))), [])


def _translation(path: Path, arrays: Arrays, frames: int, notes: list[str]) -> FloatArray:
    name = next((key for key in TRANSLATIONS if key in arrays), None)
    if name is None:
        notes.append("the file has no translation: the body stays where it is")
        return np.zeros((frames, 3))
    values = _numbers(path, name, arrays[name])
    if values.size == 3 and values.ndim < 2:
        values = np.broadcast_to(values, (frames, 3))
    shape = values.shape
    while values.ndim > 2 and 1 in values.shape[:-1]:
        values = np.squeeze(values, axis=values.shape.index(1))
    if values.shape != (frames, 3):
        raise FormatError(path, f"expected {name} ({frames}, 3), found {shape}")
    return values


def _scale(path: Path, arrays: Arrays) -> float | None:
    name = next((key for key in SCALES if key in arrays), None)
    if name is None:
        return None
    value = _numbers(path, name, arrays[name]).reshape(-1)
    if len(value) != 1 or value[0] <= 0:
        raise FormatError(path, f"expected one positive number as {name}, found {arrays[name].shape}")
    return float(value[0])
