"""Reading arrays of positions: their shape, their set of joints, their rate, and a motion fitted to them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.conventions import guess_units, righted, to_metres_y_up, unit_factor
from kinetograph.formats.npy.features import WIDTHS, positions_of_features
from kinetograph.formats.npy.sets import JointSet, bones_vary, choose_set
from kinetograph.formats.numpy_arrays import parse_array
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.motion import Motion
from kinetograph.rotations import identity
from kinetograph.take import Take

_LARGEST = 1e6
_ELASTIC = 0.15  # of their lengths: bones that vary by more are noted


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a ``.npy`` file as a take in metres, Y up, with the track ``motion``.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        ``markers`` names the set of joints.

    Returns
    -------
    Loaded

    Raises
    ------
    FormatError
        The array has another shape, or a rate is needed.
    RequestError
        The set of joints is unknown.
    """
    path, options = Path(path), options or ReadOptions()
    values = parse_array(path, path.name, path.read_bytes())
    if values.dtype.kind not in "fiu":
        raise FormatError(path, f"expected positions of joints, found an array of {values.dtype}")
    notes: list[str] = []
    positions = _positions(path, np.asarray(values, dtype=np.float64), notes)
    joints = choose_set(path, positions, options.markers, notes)
    fps = _rate(path, options, joints, notes)
    places = joints.joints(positions)
    if (vary := bones_vary(joints, positions)) > _ELASTIC:
        notes.append(
            f"bones vary by {100 * vary:.0f} % of their lengths: are these positions, as {joints.title} has them?"
        )
    units = options.units or _units(places, joints, fps, notes)
    motion = _fitted(places * unit_factor(units), joints, fps, notes)
    converted = to_metres_y_up([motion], "metre", options.up)
    upright, flipped = righted(converted.motions[0])
    return Loaded(Take(path.stem, {"motion": upright}), (*notes, *converted.notes, *flipped))


def _positions(path: Path, values: FloatArray, notes: list[str]) -> FloatArray:
    """Positions ``(F, J, 3)`` of an array in any of its shapes."""
    shape = values.shape
    while values.ndim > 2 and values.shape[0] == 1 and (values.ndim > 3 or values.shape[-1] in WIDTHS):
        values = values[0]
    if not np.all(np.abs(values) < _LARGEST):
        raise FormatError(path, "expected finite numbers as positions")
    if values.ndim == 2 and values.shape[1] in WIDTHS and len(values):
        notes.append(f"{values.shape[1]} numbers per frame: features of HumanML3D, of which the positions are read")
        return positions_of_features(values)
    if values.ndim == 3 and values.shape[1] == 3 and values.shape[2] != 3:  # joints, axes, frames
        values = values.transpose(2, 0, 1)
    if values.ndim != 3 or values.shape[-1] != 3 or not len(values):
        raise FormatError(path, f"expected positions (frames, joints, 3) or features (frames, 263), found {shape}")
    return values


def _rate(path: Path, options: ReadOptions, joints: JointSet, notes: list[str]) -> float:
    fps = options.fps if options.fps is not None else joints.fps
    if fps is None:
        raise FormatError(path, f"positions of {joints.title} say no rate; give it with --fps")
    if not (np.isfinite(fps) and 0 < fps < 1e5):
        raise RequestError(f"fps must be a positive number, found {fps}")
    if options.fps is None:
        notes.append(f"rate not given: {fps:g} frames per second, as in {joints.title}; say another with --fps")
    return float(fps)


def _units(places: FloatArray, joints: JointSet, fps: float, notes: list[str]) -> str:
    """The units guessed from the size of the body."""
    # joints are where the root's translation and one bone each put them, so that no fit is needed for a size
    skeleton = joints.skeleton
    parents = np.maximum(skeleton.parents, 0)
    bones = places - places[:, parents]
    still = Motion(skeleton, places[:, 0], identity(len(places), len(skeleton)), fps, bones)
    units, note = guess_units([still])
    notes.append(note)
    return units


def _fitted(places: FloatArray, joints: JointSet, fps: float, notes: list[str]) -> Motion:
    from kinetograph.markers import fit_positions  # compiled kernels, which reading other files does not need

    fit = fit_positions(places, joints.skeleton, fps)
    misses = 1000.0 * fit.misses
    notes.append(
        f"joints of {joints.title}: rotations fitted to positions, which bones of constant length miss by "
        f"{misses.mean():.1f} mm in the mean, {misses.max():.1f} at most"
    )
    return fit.motion
