"""Acclaim skeletons (``.asf``) and their motions (``.amc``).

A bone's direction and axis are given in the world at rest, so with C the rotation of its axis and M that of its
values, its local rotation is C M C^-1 and rest offsets need no turning: the pose without turns is the file's rest pose.
Turns are about fixed axes in the order written: ``XYZ`` is the product Z Y X. A bone becomes a joint at its near end.
Lengths are in inches over the file's ``length``, as Carnegie Mellon's and HDM05's are. A file gives no rate.
"""

from __future__ import annotations

import math
from array import array
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.acclaim.skeleton import ROOT, Asf, AsfBone, parse_skeleton, text_lines
from kinetograph.formats.conventions import UNITS, to_metres_y_up
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

_RATE = 120.0
_LARGEST = 1e12
_CROWDED = 20  # joints a value read at most


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """An ``.amc`` file with its skeleton, or the rest pose of an ``.asf`` file, as a take with the track ``motion``.

    The skeleton of ``16_11.amc`` is ``options.skeleton``, or beside it ``16_11.asf``, ``16.asf`` or the only ``.asf``.
    Every frame is read, the last one too. The rate is ``options.fps`` or 120, and that is noted.

    Raises FormatError, with the line, for what is not Acclaim, and where there is no skeleton.
    """
    path = Path(path)
    options = options or ReadOptions()
    alone = path.suffix.lower() == ".asf"
    asf_path = path if alone else _skeleton_of(path, options.skeleton)
    asf = parse_skeleton(asf_path)
    notes = [] if alone else [f"skeleton from {asf_path.name}"]
    if options.fps is None and not alone:
        notes.append("rate not given: taken as 120 frames a second, as of most such files; give it with --fps")
    if alone:
        columns: dict[str, FloatArray] = {}
        frames = 1
    else:
        columns, frames = _parse_values(path, asf, notes, options.lenient)
    motion = _motion(asf, columns, frames, options.fps or _RATE)
    if motion.bones is not None:
        notes.append(
            "some bones move against their parents or change their length: both are kept (bones of the motion)"
        )
    if options.fps is not None and not (math.isfinite(options.fps) and options.fps > 0):
        raise FormatError(path, f"fps must be a positive number, found {options.fps}")
    units = options.units
    if units is None and asf.length != 1.0:  # 1 says nothing; other values are in inches
        motion, units = _scaled(motion, UNITS["inch"] / asf.length), "metre"
    converted = to_metres_y_up([motion], units, options.up or "y")
    return Loaded(Take(path.stem, {"motion": converted.motions[0]}), (*notes, *converted.notes))


def _scaled(motion: Motion, factor: float) -> Motion:
    from kinetograph.formats.conventions import scale_motion

    return scale_motion(motion, factor)


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
    raise FormatError(path, f"expected its skeleton {path.stem}.asf beside it, found {len(others)} others; name it")


def _parse_values(path: Path, asf: Asf, notes: list[str], lenient: bool) -> tuple[dict[str, FloatArray], int]:
    """Values of each bone, shape ``(F, n)``, as written, and the number of frames."""
    rows: dict[str, array[float]] = {}  # a list would take ten times the file
    widths: dict[str, int] = {}
    frames, seen, first = 0, set[str](), set[str]()
    fault: FormatError | None = None
    for number, words in text_lines(path):
        if words[0][0] in "#:":
            continue
        if len(words) == 1 and words[0].isdigit():
            first = seen if frames == 1 else first
            if seen != first:
                fault = FormatError(path, f"frame {frames} has other bones than the first one", line=number)
            frames, seen = frames + 1, set()
        else:
            fault = _add_row(path, number, words, asf, frames, seen, rows, widths)
        if fault is not None:
            break
    if fault is None and frames > 1 and seen != first:
        fault = FormatError(path, f"frame {frames} has other bones than the first one; is the file cut short?")
    if fault is not None:
        if not lenient or frames < 2:
            raise fault
        frames -= 1
        notes.append(f"{fault}: took {frames} frames before it")
    if frames == 0 or not rows:
        raise FormatError(path, "expected frames: a number alone on a line, then a line a bone; found none")
    given = sum(len(values) // max(widths[name], 1) for name, values in rows.items())
    if frames * (len(asf.bones) + 1) > 1_000_000 + _CROWDED * given:
        raise FormatError(path, "expected values for most bones, found few; is the file damaged?")
    columns = {name: np.array(v[: frames * widths[name]]).reshape(frames, widths[name]) for name, v in rows.items()}
    _check_widths(asf, columns, notes)
    return columns, frames


def _add_row(
    path: Path,
    number: int,
    words: list[str],
    asf: Asf,
    frames: int,
    seen: set[str],
    rows: dict[str, array[float]],
    widths: dict[str, int],
) -> FormatError | None:
    name = words[0]
    if frames == 0:
        return FormatError(path, f"expected a frame's number, found {name[:40]!r}", line=number)
    if name != ROOT and name not in asf.bones:
        return FormatError(path, f"expected a bone of the skeleton, found {name[:40]!r}; is it another's?", line=number)
    if name in seen:
        return FormatError(path, f"bone {name!r} occurs twice in frame {frames}", line=number)
    try:
        values = [float(word) for word in words[1:]]
    except ValueError:
        return FormatError(path, f"expected numbers after {name!r}, found {' '.join(words[1:])[:40]!r}", line=number)
    if not all(abs(value) < _LARGEST for value in values):
        return FormatError(path, f"expected finite numbers after {name!r}", line=number)
    expected = widths.setdefault(name, len(values))
    if len(values) != expected or not _fits(asf, name, expected):
        wanted = len(_freedoms(asf, name))
        return FormatError(path, f"expected {wanted} numbers after {name!r}, found {len(values)}", line=number)
    seen.add(name)
    rows.setdefault(name, array("d")).extend(values)
    return None


def _freedoms(asf: Asf, name: str) -> tuple[str, ...]:
    return asf.order if name == ROOT else asf.bones[name].freedoms


def _fits(asf: Asf, name: str, count: int) -> bool:
    return count == len(_freedoms(asf, name)) or (count == 3 and name != ROOT)


def _check_widths(asf: Asf, columns: dict[str, FloatArray], notes: list[str]) -> None:
    """Some programs write three turns for every bone, whatever its degrees of freedom are."""
    odd = [n for n, values in columns.items() if values.shape[1] != len(_freedoms(asf, n))]
    if odd:
        notes.append(f"{len(odd)} bones have three turns where the skeleton names fewer: taken as rx ry rz")


def _motion(asf: Asf, columns: dict[str, FloatArray], frames: int, fps: float) -> Motion:
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
            rotations[:, joint] = _turns(bone, columns[bone.name], asf.degree)
    translation = np.tile(np.array(asf.position), (frames, 1))
    if ROOT in columns:
        values = columns[ROOT]
        for column, word in enumerate(asf.order):
            if word[0] == "t":
                translation[:, "xyz".index(word[1])] += values[:, column]
        root = AsfBone(ROOT, (0.0, 0.0, 0.0), 0.0, asf.orientation, asf.axis, asf.order)
        rotations[:, 0] = _turns(root, values, asf.degree)
    skeleton = Skeleton(tuple(names), parents, offsets, np.array(leaves, dtype=np.int64), ends)
    return Motion(skeleton, translation, rot.unroll(rotations), fps, _moving(asf, columns, skeleton, frames))


def _moving(asf: Asf, columns: dict[str, FloatArray], skeleton: Skeleton, frames: int) -> FloatArray | None:
    """The joints' offsets in every frame, ``(F, J, 3)``, where bones move or stretch; None where none does.

    ``tx ty tz`` move a bone's near end along its own axes, ``l`` makes the bone longer than the skeleton has it.
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
    """A bone's far end from its near one, in the file's own units."""
    if name == ROOT:
        return np.zeros(3)
    bone = asf.bones[name]
    return np.array(bone.direction) * bone.length


def _turns(bone: AsfBone, values: FloatArray, degree: float) -> FloatArray:
    """Local rotations, shape ``(F, 4)``: C M C^-1."""
    turn = rot.identity(len(values))
    for column, word in enumerate(_named(bone, values)):
        if word[0] == "r":
            turn = rot.multiply(rot.about(word[1], values[:, column] * degree), turn)
    axis = _axes_of(bone, degree)
    return rot.normalize(rot.multiply(rot.multiply(axis, turn), rot.conjugate(axis)))


def _named(bone: AsfBone, values: FloatArray) -> tuple[str, ...]:
    """The degree of freedom of each column of a bone's values."""
    return bone.freedoms if len(bone.freedoms) == values.shape[1] else ("rx", "ry", "rz")


def _axes_of(bone: AsfBone, degree: float) -> FloatArray:
    """The turn C, ``(4,)``, of a bone's own axes."""
    return rot.from_euler(np.array(bone.angles)[::-1] * degree, bone.axis[::-1])
