"""NumPy archives: this package's own motions, and poses of AMASS and of SMPL bodies.

Own files have for each track ``track/names``, ``parents``, ``offsets``, ``end_parents``, ``end_offsets``,
``translation``, ``rotations``, ``fps`` and, where bones change, ``bones``: metres, Y up, quaternions w, x, y, z; and
``stance`` and ``ancestor_names``, ``ancestor_translations``, ``ancestor_rotations`` of skeletons that have these. AMASS
files have ``poses`` (rotation vectors, three numbers per joint), ``trans`` and a rate; Z is up, and the rest pose is a
T pose that faces z. `kinetograph.formats.smpl_poses` has the other names and forms of such poses.
"""

from __future__ import annotations

import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.body import named_motions
from kinetograph.formats.conventions import righted, to_metres_y_up
from kinetograph.formats.numpy_arrays import LONGEST_HEADER, ArrayHeader, Arrays, parse_header, values_of
from kinetograph.formats.options import Loaded, ReadOptions, WriteOptions
from kinetograph.formats.smpl import motion_of_poses
from kinetograph.formats.smpl_poses import SMPL_ARRAYS
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Ancestor, Skeleton
from kinetograph.take import Take

_FIELDS = ("names", "parents", "offsets", "end_parents", "end_offsets", "translation", "rotations", "fps", "bones")
_MORE = ("stance", "ancestor_names", "ancestor_translations", "ancestor_rotations")
_ROOM, _SWELL = 16 * 2**20, 10  # bytes that arrays may take, whatever the file's size, and times its size
_LARGEST = 1e12


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a ``.npz`` file as a take in metres, Y up.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        ``skeleton`` is a file with the joints' offsets, for poses. Without it they are those of an array
        ``joint_offsets``, shape ``(22, 3)``, in the file, or of an average body, which is noted.

    Returns
    -------
    Loaded

    Raises
    ------
    FormatError
        The archive is another, holds objects, or claims more than the file can hold.
    """
    path = Path(path)
    options = options or ReadOptions()
    arrays = _arrays(path)
    try:
        if any(name.endswith("/rotations") for name in arrays):
            take = Take(path.stem, _tracks(path, arrays, options))
            return Loaded(take)
        motion, up, notes = motion_of_poses(path, arrays, options)
    except (FormatError, RequestError):
        raise
    except (ValueError, TypeError, KeyError) as error:
        raise FormatError(path, f"its arrays do not make a motion: {str(error)[:120]}") from None
    converted = to_metres_y_up([motion], "metre", options.up or up)
    motion, flipped = righted(converted.motions[0])
    return Loaded(Take(path.stem, {"motion": motion}), (*notes, *converted.notes, *flipped))


def write(what: Take | Motion | Signal, path: str | Path, options: WriteOptions | None = None) -> None:
    """Write a motion, or every motion of a take, as arrays.

    Parameters
    ----------
    what : Take, Motion or Signal
    path : str or Path
        Written to exactly this path.
    options : WriteOptions, optional
        Not used.

    Raises
    ------
    RequestError
        There is no motion.
    """
    _, motions = named_motions(what, "NPZ")
    arrays: Arrays = {}
    for track, motion in motions.items():
        skeleton = motion.skeleton
        tree = (skeleton.names, skeleton.parents, skeleton.offsets, skeleton.end_parents, skeleton.end_offsets)
        values: tuple[Any, ...] = (*tree, motion.translation, motion.rotations, motion.fps)
        arrays |= {f"{track}/{field}": np.asarray(value) for field, value in zip(_FIELDS, values, strict=False)}
        if motion.bones is not None:
            arrays[f"{track}/bones"] = motion.bones
        arrays |= {f"{track}/{field}": value for field, value in _more(skeleton).items()}
    with Path(path).open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def _more(skeleton: Skeleton) -> Arrays:
    """A skeleton's stance and ancestors."""
    arrays: Arrays = {} if skeleton.stance is None else {"stance": skeleton.stance}
    if skeleton.ancestors:
        names, places, rotations = zip(*((n.name, n.translation, n.rotation) for n in skeleton.ancestors), strict=True)
        arrays |= {field: np.array(rows) for field, rows in zip(_MORE[1:], (names, places, rotations), strict=True)}
    return arrays


def _ancestors(parts: Arrays) -> tuple[Ancestor, ...]:
    if not set(_MORE[1:]) <= parts.keys():
        return ()
    names, places, rotations = (parts[field] for field in _MORE[1:])
    count = len(names)
    if places.shape != (count, 3) or rotations.shape != (count, 4):
        raise ValueError(f"{count} names of ancestors, but translations {places.shape}, rotations {rotations.shape}")
    if np.any(np.abs(np.linalg.norm(rotations, axis=1) - 1.0) > 1e-3):
        raise ValueError("expected unit quaternions as rotations of ancestors")
    return tuple(
        Ancestor(str(name), np.asarray(at, np.float64), np.asarray(facing, np.float64))
        for name, at, facing in zip(names, places, rotations, strict=True)
    )


def _tracks(path: Path, arrays: Arrays, options: ReadOptions) -> dict[str, Motion]:
    tracks = {}
    for track in [name.removesuffix("/rotations") for name in arrays if name.endswith("/rotations")]:
        parts = {field: arrays[f"{track}/{field}"] for field in _FIELDS + _MORE if f"{track}/{field}" in arrays}
        missing = [field for field in _FIELDS[:-1] if field not in parts]
        if missing:
            raise FormatError(path, f"track {track!r} has no {', '.join(missing)}")
        if any(not np.all(np.abs(parts[f].astype(np.float64)) < _LARGEST) for f in parts if "names" not in f):
            raise FormatError(path, f"track {track!r}: expected finite numbers, none of them huge")
        names = tuple(str(name) for name in parts["names"].ravel())
        parents, offsets, end_parents, end_offsets = (parts[field] for field in _FIELDS[1:5])
        tree = (names, parents, offsets, end_parents, end_offsets)
        skeleton = Skeleton(*tree, stance=parts.get("stance"), ancestors=_ancestors(parts))
        fps = options.fps or float(parts["fps"])
        motion = Motion(skeleton, parts["translation"], parts["rotations"], fps, parts.get("bones"))
        tracks[track] = to_metres_y_up([motion], options.units or "metre", options.up or "y", options.keep).motions[0]
    return tracks


def _arrays(path: Path) -> Arrays:
    """The arrays that have a meaning, read only where they can be as large as they say."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = [m for m in archive.infolist() if _wanted(m.filename.removesuffix(".npy"))]
            size = path.stat().st_size
            if any(member.compress_size > size for member in members):  # else memory would be taken before it is missed
                raise FormatError(path, "an array is longer than the file; is it cut short?")
            headers = {member.filename: _header(path, archive, member) for member in members}
            numbers = sum(max(header.count * 8, header.size) for header in headers.values())  # they are made doubles
            if numbers > _ROOM + _SWELL * size:
                raise FormatError(path, f"its arrays unpack to {numbers} bytes, too many for a file of {size} bytes")
            return {m.filename.removesuffix(".npy"): _array(path, archive, m, headers[m.filename]) for m in members}
    except FormatError:
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, struct.error, ValueError) as error:
        raise FormatError(path, f"expected a NumPy archive: {str(error)[:80]}") from None


def _wanted(name: str) -> bool:
    return name in SMPL_ARRAYS or name.rpartition("/")[2] in _FIELDS + _MORE


def _header(path: Path, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> ArrayHeader:
    with archive.open(member) as file:
        return parse_header(path, member.filename, file.read(LONGEST_HEADER), member.file_size)


def _array(path: Path, archive: zipfile.ZipFile, member: zipfile.ZipInfo, header: ArrayHeader) -> npt.NDArray[Any]:
    with archive.open(member) as file:
        file.read(header.start)
        body = file.read(header.size)
    if len(body) != header.size:
        raise FormatError(path, f"{member.filename}: expected {header.size} bytes, found {len(body)}")
    return values_of(header, body)
