"""Reading Acclaim: from the bones of a skeleton file and the values of a motion file to a motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.acclaim.skeleton import ROOT, Asf, AsfBone, parse_skeleton
from kinetograph.formats.acclaim.values import Values, parse_values
from kinetograph.formats.conventions import UNITS, scale_motion, to_metres_y_up
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.formats.timing import check_fps
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

_RATE = 120.0


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read an ``.amc`` file with its skeleton, or the rest pose of an ``.asf`` file, as a take in metres, Y up.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        ``skeleton`` is the ``.asf`` file; without it, the skeleton of ``16_11.amc`` is ``16_11.asf``, ``16.asf`` or
        the only ``.asf`` in the same folder. ``fps`` is the rate; without it, 120, which is noted.

    Returns
    -------
    Loaded
        With the track ``motion``.

    Raises
    ------
    FormatError
        The file is not Acclaim, or there is no skeleton; with the line.
    """
    path = Path(path)
    options = options or ReadOptions()
    alone = path.suffix.lower() == ".asf"
    asf_path = path if alone else _skeleton_of(path, options.skeleton)
    asf = parse_skeleton(asf_path)
    notes = [] if alone else [f"skeleton from {asf_path.name}"]
    if options.fps is None and not alone:
        notes.append("rate not given: taken as 120 frames per second, as of most such files; give it with --fps")
    values = Values({}, 1) if alone else parse_values(path, asf, options.lenient)
    notes += values.notes
    fps = _RATE if options.fps is None else check_fps(path, options.fps)
    motion = _motion(asf, values, fps)
    if motion.bones is not None:
        notes.append(
            "some bones move against their parents or change their length: both are kept (bones of the motion)"
        )
    units = options.units
    if units is None and asf.length != 1.0:  # 1 says nothing; other values are in inches
        motion, units = scale_motion(motion, UNITS["inch"] / asf.length), "metre"
    converted = to_metres_y_up([motion], units, options.up or "y")
    return Loaded(Take(path.stem, {"motion": converted.motions[0]}), (*notes, *converted.notes))


def _skeleton_of(path: Path, given: str | Path | None) -> Path:
    if given is not None:
        return Path(given)
    others = sorted(p for p in path.parent.iterdir() if p.suffix.lower() == ".asf")
    for stem in (path.stem, path.stem.rpartition("_")[0]):
        for other in others:
            if other.stem.lower() == stem.lower():
                return other
    if len(others) == 1:
        return others[0]
    raise FormatError(path, f"expected its skeleton {path.stem}.asf in its folder, found {len(others)} others; name it")


def _motion(asf: Asf, read: Values, fps: float) -> Motion:
    columns, frames = read.columns, read.frames
    names = [ROOT, *asf.order_of_bones]
    index = {name: joint for joint, name in enumerate(names)}
    bones = [asf.bones[name] for name in asf.order_of_bones]
    parents = np.array([-1, *(index[asf.parents[bone.name]] for bone in bones)])
    offsets = np.array([np.zeros(3), *(_end(asf, asf.parents[bone.name]) for bone in bones)])
    leaves = [joint for joint in range(1, len(names)) if joint not in set(parents.tolist())]
    ends = np.array([_end(asf, names[joint]) for joint in leaves]).reshape(-1, 3)
    rotations = rot.identity(frames, len(names))
    for joint, bone in enumerate(bones, start=1):
        if bone.name in columns:
            rotations[:, joint] = _rotations(bone, columns[bone.name], asf.degree)
    translation = np.tile(np.array(asf.position), (frames, 1))
    if ROOT in columns:
        values = columns[ROOT]
        for column, word in enumerate(asf.order):
            if word[0] == "t":
                translation[:, "xyz".index(word[1])] += values[:, column]
        root = AsfBone(ROOT, (0.0, 0.0, 0.0), 0.0, asf.orientation, asf.axis, asf.order)
        rotations[:, 0] = _rotations(root, values, asf.degree)
    skeleton = Skeleton(tuple(names), parents, offsets, np.array(leaves, dtype=np.int64), ends)
    return Motion(skeleton, translation, rot.unroll(rotations), fps, _moving(asf, columns, skeleton, frames))


def _moving(asf: Asf, columns: dict[str, FloatArray], skeleton: Skeleton, frames: int) -> FloatArray | None:
    """The joints' offsets in every frame, ``(F, J, 3)``, where bones move or stretch; None where none does.

    ``tx ty tz`` move a bone's near end along its own axes, ``l`` lengthens the bone.
    """
    moving = [
        (skeleton.index(name), asf.bones[name], word, values[:, [column]])
        for name, values in columns.items()
        if name != ROOT
        for column, word in enumerate(_named(asf.bones[name], values))
        if word[0] != "r"
    ]
    if not moving:
        return None
    bones = np.tile(skeleton.offsets, (frames, 1, 1))
    for joint, bone, word, values in moving:
        if word == "l":
            bones[:, skeleton.parents == joint] += (values * np.array(bone.direction))[:, None]
        else:
            bones[:, joint] += values * rot.rotate(_axes_of(bone, asf.degree), rot.AXES[word[1]])
    return bones


def _end(asf: Asf, name: str) -> FloatArray:
    """A bone's far end relative to its near end, in the file's own units."""
    if name == ROOT:
        return np.zeros(3)
    bone = asf.bones[name]
    return np.array(bone.direction) * bone.length


def _rotations(bone: AsfBone, values: FloatArray, degree: float) -> FloatArray:
    """Local rotations, shape ``(F, 4)``: C M C^-1."""
    own = rot.identity(len(values))
    for column, word in enumerate(_named(bone, values)):
        if word[0] == "r":
            own = rot.multiply(rot.about(word[1], values[:, column] * degree), own)
    axis = _axes_of(bone, degree)
    return rot.normalize(rot.multiply(rot.multiply(axis, own), rot.conjugate(axis)))


def _named(bone: AsfBone, values: FloatArray) -> tuple[str, ...]:
    """The degree of freedom of each column of a bone's values."""
    return bone.freedoms if len(bone.freedoms) == values.shape[1] else ("rx", "ry", "rz")


def _axes_of(bone: AsfBone, degree: float) -> FloatArray:
    """The rotation C, ``(4,)``, of a bone's own axes."""
    return rot.from_euler(np.array(bone.angles)[::-1] * degree, bone.axis[::-1])
