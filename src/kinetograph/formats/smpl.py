"""Poses of the SMPL family of bodies: the joints are in their order, the offsets are given or an average body's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.conventions import unit_factor
from kinetograph.formats.numpy_arrays import Arrays
from kinetograph.formats.options import ReadOptions
from kinetograph.formats.smpl_poses import Poses, read_poses, read_rate
from kinetograph.kinematics import joint_positions
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
_CANDIDATES = {"metre": 1.0, "centimetre": 0.01, "millimetre": 0.001}
_BODIES = (0.5, 2.0)  # sizes of people, in that of the average body
_FEET = ("left_ankle", "right_ankle", "left_foot", "right_foot")
_STEPPING = 0.3  # metres per second: a foot that moves faster against the hips, in most frames, steps
_CLEARLY = 0.6  # of the feet's slide in the likely unit: a unit with less is taken
_NEAR = 0.05  # metres: a body that stays so near the origin says nothing on its unit


def average_body() -> Skeleton:
    """The skeleton of an average body of 1.70 m with SMPL's first 22 joints."""
    parents = np.array([parent for _, parent, _ in _BODY])
    return Skeleton(tuple(name for name, _, _ in _BODY), parents, np.array([offset for _, _, offset in _BODY]))


def motion_of_poses(path: Path, arrays: Arrays, options: ReadOptions) -> tuple[Motion, str | None, list[str]]:
    """The motion of the body's 22 joints in the file's own axes, its upward axis, and notes.

    Parameters
    ----------
    path : Path
        For errors.
    arrays : dict of str to ndarray
        The file's arrays.
    options : ReadOptions
        A rate, the unit of the translation, and a file with the joints' offsets.

    Returns
    -------
    motion : Motion
        In metres; fingers and face are left out.
    up : {"y", "z"} or None
        As in other files of the same origin; None where that is not known.
    notes : list of str

    Raises
    ------
    FormatError
        There are no poses or no rate, or arrays have another shape.
    RequestError
        The file with the offsets lacks a joint.
    """
    notes: list[str] = []
    poses = read_poses(path, arrays, notes)
    fps = read_rate(path, arrays, options.fps, poses.kind, notes)
    skeleton = _skeleton(path, arrays, options, notes)
    rotations = rot.unroll(poses.rotations)
    size, unit = _sizes(Motion(skeleton, poses.translation, rotations, fps), poses, options.units, notes)
    skeleton = replace(skeleton, offsets=skeleton.offsets * size)
    up = {"amass": "z", "aist": "y"}.get(poses.kind)
    if up is not None and options.up is None and poses.kind == "aist":
        notes.append("up axis not given: y, as in AIST++; say another with --up")
    return Motion(skeleton, poses.translation * unit + skeleton.offsets[0], rotations, fps), up, notes


def _sizes(motion: Motion, poses: Poses, units: str | None, notes: list[str]) -> tuple[float, float]:
    """The size of the body, which is in metres, and the metres in a unit of the translation."""
    scaled = {name: poses.scale * metres for name, metres in _CANDIDATES.items()} if poses.scale else {}
    likely = next((name for name, size in scaled.items() if _BODIES[0] < size < _BODIES[1]), None)
    if units is not None:
        size = (poses.scale or 1.0) * unit_factor(units)
        return (size if poses.scale and _BODIES[0] < size < _BODIES[1] else 1.0), unit_factor(units)
    size = scaled[likely] if likely else 1.0
    found = "metre" if poses.kind == "amass" else _translation_units(motion, size, likely or "metre")
    if poses.scale:
        notes.append(f"the body is {size:.3g} times its size, by the file's scaling of {poses.scale:.4g}")
    if found != "metre" or poses.scale:
        notes.append(f"units of the translation not given: guessed {found}, from how feet stand and how far it goes")
    return size, _CANDIDATES[found]


def _translation_units(motion: Motion, size: float, likely: str) -> str:
    """The unit in which feet that stand move least; of a body that does not step, the one that puts it near by."""
    moved = np.diff(motion.translation, axis=0)
    still = replace(motion, translation=np.zeros_like(motion.translation))
    feet = joint_positions(still)[:, [motion.skeleton.index(name) for name in _FEET]] * size
    steps = np.diff(feet, axis=0)
    far = float(np.median(np.linalg.norm(motion.translation, axis=1)))
    if len(steps) and np.median(np.linalg.norm(steps, axis=-1).max(axis=1)) * motion.fps > _STEPPING:
        slides = {
            name: float(np.median(np.linalg.norm(steps + metres * moved[:, None], axis=-1).min(axis=1)))
            for name, metres in _CANDIDATES.items()
        }
        best = min(slides, key=lambda name: slides[name])
        return best if slides[best] < _CLEARLY * slides[likely] else likely
    if far * _CANDIDATES["metre"] < _NEAR:
        return likely if far * _CANDIDATES[likely] > _NEAR else "metre"
    return min(_CANDIDATES, key=lambda name: abs(np.log(far * _CANDIDATES[name])))


def _skeleton(path: Path, arrays: Arrays, options: ReadOptions, notes: list[str]) -> Skeleton:
    body = average_body()
    names, offsets = body.names, body.offsets
    if options.skeleton is not None:
        offsets = _offsets_of(Path(options.skeleton), names)
    elif "joint_offsets" in arrays:
        offsets = np.asarray(arrays["joint_offsets"], dtype=np.float64)
        if offsets.shape != (len(names), 3) or not np.all(np.abs(offsets) < _LARGEST):
            raise FormatError(path, f"expected joint_offsets ({len(names)}, 3), found {offsets.shape}")
    else:
        notes.append("joint offsets not given: an average body of 1.70 m; give yours with --skeleton")
    return replace(body, offsets=offsets)


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
