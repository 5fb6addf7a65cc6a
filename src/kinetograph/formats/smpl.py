"""Poses of the SMPL family of bodies: the joints are in their order, the offsets are given or an average body's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.options import ReadOptions
from kinetograph.motion import Motion
from kinetograph.roles import read_names
from kinetograph.skeleton import Skeleton

# joint, parent, and an offset of a body of 1.70 m from common proportions: left is +x, up +y, forward +z
_BODY: tuple[tuple[str, int, tuple[float, float, float]], ...] = (
    ("pelvis", -1, (0.0, 0.0, 0.0)),
    ("left_hip", 0, (0.075, -0.085, -0.005)),
    ("right_hip", 0, (-0.075, -0.085, -0.005)),
    ("spine1", 0, (0.0, 0.115, -0.02)),
    ("left_knee", 1, (0.035, -0.39, 0.0)),
    ("right_knee", 2, (-0.035, -0.39, 0.0)),
    ("spine2", 3, (0.0, 0.135, 0.005)),
    ("left_ankle", 4, (-0.015, -0.41, -0.03)),
    ("right_ankle", 5, (0.015, -0.41, -0.03)),
    ("spine3", 6, (0.0, 0.055, 0.02)),
    ("left_foot", 7, (0.035, -0.06, 0.13)),
    ("right_foot", 8, (-0.035, -0.06, 0.13)),
    ("neck", 9, (0.0, 0.21, -0.04)),
    ("left_collar", 9, (0.08, 0.115, -0.03)),
    ("right_collar", 9, (-0.08, 0.115, -0.03)),
    ("head", 12, (0.0, 0.09, 0.05)),
    ("left_shoulder", 13, (0.1, 0.04, -0.01)),
    ("right_shoulder", 14, (-0.1, 0.04, -0.01)),
    ("left_elbow", 16, (0.26, -0.01, -0.02)),
    ("right_elbow", 17, (-0.26, -0.01, -0.02)),
    ("left_wrist", 18, (0.25, 0.01, 0.0)),
    ("right_wrist", 19, (-0.25, 0.01, 0.0)),
)
_LARGEST = 1e6

Arrays = dict[str, npt.NDArray[Any]]


def motion_of_poses(path: Path, arrays: Arrays, options: ReadOptions) -> tuple[Motion, list[str]]:
    """The motion of the body's 22 joints in the file's own axes, and notes; fingers and face are left out.

    Parameters
    ----------
    path : Path
        For errors.
    arrays : dict of str to ndarray
        The file's arrays.
    options : ReadOptions
        A rate, and a file with the joints' offsets.

    Returns
    -------
    motion : Motion
    notes : list of str

    Raises
    ------
    FormatError
        There are no poses or no rate, or arrays have another shape.
    RequestError
        The file with the offsets lacks a joint.
    """
    notes: list[str] = []
    poses, translation = _poses(path, arrays, notes)
    fps = options.fps or next(
        (float(arrays[key]) for key in ("mocap_framerate", "mocap_frame_rate", "fps") if key in arrays), 0
    )
    if not (np.isfinite(fps) and 0 < fps < 1e5):
        raise FormatError(path, "the file gives no rate (mocap_framerate); give it with --fps")
    skeleton = _skeleton(path, arrays, options, notes)
    rotations = rot.unroll(rot.exp(poses))
    return Motion(skeleton, translation + skeleton.offsets[0], rotations, fps), notes


def _poses(path: Path, arrays: Arrays, notes: list[str]) -> tuple[FloatArray, FloatArray]:
    """Rotation vectors ``(F, 22, 3)`` and translations ``(F, 3)``."""
    if "poses" in arrays:
        flat = arrays["poses"]
    elif "pose_body" in arrays and "root_orient" in arrays:
        parts = [arrays[key] for key in ("root_orient", "pose_body")]
        if any(part.ndim != 2 for part in parts) or len(parts[0]) != len(parts[1]):
            raise FormatError(path, f"expected rows of poses, found {[part.shape for part in parts]}")
        flat = np.concatenate(parts, axis=1)
    else:
        raise FormatError(path, "expected poses and trans, or this package's own arrays; found neither")
    flat = flat.reshape(len(flat), -1).astype(np.float64) if flat.ndim else flat
    count = len(_BODY)
    if flat.ndim != 2 or len(flat) == 0 or flat.shape[1] < 3 * count or flat.shape[1] % 3:
        raise FormatError(path, f"expected poses (F, {3 * count} or more), found {flat.shape}")
    moved = next((arrays[key] for key in ("trans", "transl") if key in arrays), None)
    if moved is None:
        notes.append("the file has no translation: the body stays where it is")
        moved = np.zeros((len(flat), 3))
    moved = np.asarray(moved, dtype=np.float64)
    if moved.shape != (len(flat), 3):
        raise FormatError(path, f"expected trans ({len(flat)}, 3), found {moved.shape}")
    if not (np.all(np.abs(flat) < _LARGEST) and np.all(np.abs(moved) < _LARGEST)):
        raise FormatError(path, "expected finite numbers as poses and translations")
    if flat.shape[1] > 3 * count:
        notes.append(f"{flat.shape[1] // 3} joints: the body's {count} are read, not fingers and face")
    return flat[:, : 3 * count].reshape(-1, count, 3), moved


def _skeleton(path: Path, arrays: Arrays, options: ReadOptions, notes: list[str]) -> Skeleton:
    names = tuple(name for name, _, _ in _BODY)
    parents = np.array([parent for _, parent, _ in _BODY])
    offsets = np.array([offset for _, _, offset in _BODY])
    if options.skeleton is not None:
        offsets = _offsets_of(Path(options.skeleton), names)
    elif "joint_offsets" in arrays:
        offsets = np.asarray(arrays["joint_offsets"], dtype=np.float64)
        if offsets.shape != (len(names), 3) or not np.all(np.abs(offsets) < _LARGEST):
            raise FormatError(path, f"expected joint_offsets ({len(names)}, 3), found {offsets.shape}")
    else:
        notes.append("joint offsets not given: an average body of 1.70 m; give yours with --skeleton")
    return Skeleton(names, parents, offsets)


def _offsets_of(path: Path, names: tuple[str, ...]) -> FloatArray:
    """The offsets of the joints of a file, by role or by name."""
    from kinetograph.formats.files import read  # reads any file, this one included

    motion = next(iter(read(path).take.tracks.values()))
    if not isinstance(motion, Motion):
        raise RequestError(f"{path}: expected a file with a skeleton, found a signal")
    theirs = {(n.side, n.word, n.number): i for i, n in enumerate(read_names(motion.skeleton.names))}
    roles = {role: point.joint for role, point in motion.skeleton.roles.items() if not point.offset.any()}
    as_role = {"pelvis": "hips", "left_ankle": "left_foot", "right_ankle": "right_foot", "left_foot": "left_toe"}
    as_role |= {"right_foot": "right_toe", "left_wrist": "left_hand", "right_wrist": "right_hand", "spine3": "chest"}
    trunk = _trunk(motion.skeleton)
    roles |= {f"spine{i + 1}": joint for i, joint in enumerate(trunk)} if len(trunk) == 3 else {}
    out = np.zeros((len(names), 3))
    for joint, (name, words) in enumerate(zip(names, read_names(names), strict=True)):
        index = theirs.get((words.side, words.word, words.number))
        index = roles.get(name, roles.get(as_role.get(name, ""))) if index is None else index
        if index is None:
            raise RequestError(f"{path}: no joint that could be {name!r}; a skeleton with SMPL's 22 joints is needed")
        out[joint] = motion.skeleton.offsets[index] if joint else 0.0
    return out


def _trunk(skeleton: Skeleton) -> list[int]:
    """The joints between the hips and the neck, from below."""
    if "neck" not in skeleton.roles or "hips" not in skeleton.roles:
        return []
    chain = []
    joint = int(skeleton.parents[skeleton.roles["neck"].joint])
    while joint > skeleton.roles["hips"].joint:
        chain.append(joint)
        joint = int(skeleton.parents[joint])
    return chain[::-1]
