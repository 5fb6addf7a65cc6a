"""Calibration without a recorded motion: by a standing pose, and by movement that is like a library's.

A sensor's rotation about a known direction is open at first. The reading along that direction and its size across it do
not depend on this rotation, and are enough to find the wearer's path through a library; the library's virtual sensors
along the path then serve as the reference of Wahba's problem, whose solution gives a better path. A few rounds suffice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import PathSearch, best_paths, init_paths, step_paths
from kinetograph.motion import Motion
from kinetograph.readings import Readings
from kinetograph.sensing.calibration import RATE, Calibration, as_others, calibrate_pairs, faultless, framed
from kinetograph.sensing.layout import Layout, Sensor, attach, keep_sensors
from kinetograph.sensing.readings import GRAVITY, check_units, select_rows
from kinetograph.sensing.rotation_fit import Pairs, fit_pairs
from kinetograph.sensing.virtual import simulate
from kinetograph.skeleton import Skeleton

ROUNDS = 8
"""Rounds of matching and of solving Wahba's problem."""
LAG = 6
"""Frames by which the matching looks back."""
LONGEST = 1800
"""Frames that are used at most."""
STILL = 1.0
"""m/s^2 by which the readings of somebody who stands still vary at most."""
LEAST_STILL = 1.0
"""Seconds of standing still that are worth finding."""
FEWEST = 5
"""Readings of each sensor that standing still needs."""
_HANGING = ("shoulder", "elbow", "hand", "hip", "knee")  # joints whose bones hang when a body stands


@dataclass(frozen=True, eq=False)
class LibraryReadings:
    """What a layout's sensors would have read on a library's bodies.

    Parameters
    ----------
    force : ndarray, shape (N, S, 3)
        In m/s^2.
    first : ndarray of bool, shape (N,)
        True where a recording begins.
    """

    force: FloatArray
    first: BoolArray


@dataclass(frozen=True, eq=False)
class Standing:
    """Readings at rest in a pose that is known.

    Parameters
    ----------
    read, wanted : ndarray, shape (S, 3)
        In m/s^2: what each sensor read, and what it should have read.
    """

    read: FloatArray
    wanted: FloatArray


def calibrate_on_library(
    readings: Readings, layout: Layout, motions: Sequence[Motion], still: tuple[float, float] | None = None
) -> Calibration:
    """Calibrate by movement that is like a library's motions, and by standing still, arms hanging.

    Half a minute, from the end of standing on, is used.

    Parameters
    ----------
    readings : Readings
    layout : Layout
    motions : sequence of Motion
        The library's, of one skeleton.
    still : pair of float, optional
        Seconds between which the wearer stood still.

    Returns
    -------
    Calibration

    Raises
    ------
    RequestError
        For sensors that the layout does not have, and as ``standing_still`` and `calibrate_freely`.
    """
    check_units(readings)
    worn = keep_sensors(layout, readings.names)
    library = examples_of(motions, worn)
    standing = still and standing_still(readings, worn, still, motions[0].skeleton, library)
    measured, valid = framed(readings, worn)
    first = round((still[1] if still else float(readings.times[0])) * RATE)
    rows = slice(first, first + LONGEST)
    return calibrate_freely(worn.names, measured[rows], library, valid[rows], standing)


def examples_of(motions: Sequence[Motion], layout: Layout) -> LibraryReadings:
    """What a layout's sensors would have read during motions."""
    forces = [framed(simulate(motion, faultless(layout)), layout)[0] for motion in motions]
    first = np.zeros(sum(len(force) for force in forces), dtype=np.bool_)
    first[np.cumsum([0, *(len(force) for force in forces[:-1])])] = True
    return LibraryReadings(np.concatenate(forces), first)


def standing_still(
    readings: Readings, layout: Layout, between: tuple[float, float], skeleton: Skeleton, library: LibraryReadings
) -> Standing:
    """What sensors read while the wearer stood still, upright, arms hanging.

    The bones of arms and legs then hang, whatever their rotation about themselves; other parts are held as the
    library's bodies hold them on average.

    Parameters
    ----------
    readings : Readings
    layout : Layout
    between : pair of float
        Seconds.
    skeleton : Skeleton
        The library's.
    library : LibraryReadings

    Returns
    -------
    Standing

    Raises
    ------
    RequestError
        For no readings then, or a wearer who moved.
    """
    part = select_rows(readings, (readings.times >= between[0]) & (readings.times <= between[1]))
    read = np.zeros((len(layout.names), 3))
    for index, name in enumerate(readings.names):
        rows = part.force[part.sensors == index]
        if len(rows) < FEWEST:
            raise RequestError(
                f"sensor {name!r}: expected readings between {between[0]:g} and {between[1]:g} s, found {len(rows)}; "
                f"they last until {readings.duration:.1f} s"
            )
        moved = float(np.linalg.norm(rows.std(axis=0)))
        if moved > STILL:
            raise RequestError(
                f"sensor {name!r} moved between {between[0]:g} and {between[1]:g} s (by {moved:.1f} m/s^2, at most "
                f"{STILL:g}); name seconds in which the wearer stood still, arms hanging"
            )
        read[layout.names.index(name)] = rows.mean(axis=0)
    return Standing(read, GRAVITY * _upright(layout, skeleton, library))


def still_span(readings: Readings) -> tuple[float, float] | None:
    """The first seconds, ``LEAST_STILL`` or more, in which every sensor is still; None where there are none."""
    layout = Layout("heard", tuple(Sensor(name, "") for name in readings.names))
    force, valid = framed(readings, layout)
    width = round(LEAST_STILL * RATE)
    if len(force) < width:
        return None
    windows = np.lib.stride_tricks.sliding_window_view(force, width, axis=0)
    moved = np.linalg.norm(windows.std(axis=3), axis=2).max(axis=1)
    whole = np.lib.stride_tricks.sliding_window_view(valid.all(axis=1), width).all(axis=1)
    still = np.append((moved < STILL) & whole, [False])
    if not still.any():
        return None
    first = int(np.argmax(still))
    stop = first + int(np.argmin(still[first:])) + width - 1
    return first / RATE, stop / RATE


def _upright(layout: Layout, skeleton: Skeleton, library: LibraryReadings) -> FloatArray:
    """Upward directions, ``(S, 3)``, in the sensors' frames, of a body that stands with its arms hanging."""
    joints, _, mounts = attach(layout, skeleton)
    role_of = {landmark.joint: role for role, landmark in skeleton.roles.items()}
    up = _unit(library.force.mean(axis=0))
    for index, joint in enumerate(joints):
        bone = _bone(skeleton, int(joint)) if role_of.get(int(joint), "").endswith(_HANGING) else np.zeros(3)
        if np.linalg.norm(bone) > 1e-6:
            up[index] = rot.rotate(rot.conjugate(mounts[index]), -_unit(bone))
    return up


def _bone(skeleton: Skeleton, joint: int) -> FloatArray:
    """From a joint to the one that hangs on it, or else from its parent to it, at rest."""
    children = np.flatnonzero(skeleton.parents == joint)
    return np.asarray(skeleton.offsets[children[0] if len(children) else joint])


def calibrate_freely(
    names: tuple[str, ...],
    measured: FloatArray,
    library: LibraryReadings,
    valid: BoolArray | None = None,
    standing: Standing | None = None,
) -> Calibration:
    """Rotations from a few seconds of movement that is like a library's, without a recording of it.

    Residuals are from the nearest path through the library: that of calibrated readings, and that of raw ones.

    Parameters
    ----------
    names : tuple of str
    measured : ndarray, shape (F, S, 3)
        In m/s^2, at 60 Hz.
    library : LibraryReadings
    valid : ndarray of bool, shape (F, S), optional
    standing : Standing, optional
        Without it each sensor's mean, mostly gravity, is assumed to point where the library's does.

    Returns
    -------
    Calibration

    Raises
    ------
    RequestError
        As `calibrate`.
    """
    mask = np.ones(measured.shape[:2], dtype=np.bool_) if valid is None else valid
    raw = _followed(library, library.force, measured, mask)
    rotations, reference = _settled(measured, library, mask, standing)
    pairs = [_pairs(s, measured, reference, raw, mask, standing) for s in range(len(names))]
    half = len(measured) // 2
    parts = [_settled(measured[rows], library, mask[rows], standing)[0] for rows in (slice(half), slice(half, None))]
    # where one half alone gives another rotation, that of the whole is not reliable either
    apart = np.max([rot.angle_between(rotations, part) for part in parts], axis=0)
    frames = len(reference)
    still = None if standing is None else (standing.read, standing.wanted)
    return calibrate_pairs(names, pairs, as_others(measured[:frames], reference, mask[:frames], still), apart)


def _settled(
    measured: FloatArray, library: LibraryReadings, mask: BoolArray, standing: Standing | None
) -> tuple[FloatArray, FloatArray]:
    """Rotations ``(S, 4)`` after ``ROUNDS``, and the library's force along the path that they lead to."""
    mean = (measured * mask[..., None]).sum(axis=0) / np.maximum(mask.sum(axis=0), 1)[:, None]
    here, there = (mean, library.force.mean(axis=0)) if standing is None else (standing.read, standing.wanted)
    reference = _followed(library, _invariant(library.force, there), _invariant(measured, here), mask)
    for _ in range(ROUNDS):
        pairs = [_pairs(s, measured, reference, reference, mask, standing) for s in range(measured.shape[1])]
        rotations = np.array([fit_pairs(own)[0] if len(own.measured) else rot.IDENTITY for own in pairs])
        reference = _followed(library, library.force, rot.rotate(rotations, measured), mask)
    return rotations, reference


def _pairs(
    sensor: int, measured: FloatArray, reference: FloatArray, raw: FloatArray, mask: BoolArray,
    standing: Standing | None,
) -> Pairs:  # fmt: skip
    used = mask[: len(reference), sensor]
    return Pairs(
        measured[: len(reference), sensor][used],
        reference[used, sensor],
        raw[used, sensor],
        None if standing is None else (standing.read[sensor], standing.wanted[sensor]),
        biased=False,
    )


def _invariant(force: FloatArray, axis: FloatArray) -> FloatArray:
    """What rotations about ``axis``, ``(S, 3)``, leave: the part along it, and the size across, ``(F, S, 2)``."""
    along = np.einsum("fsi,si->fs", force, _unit(axis))
    across = np.sqrt(np.maximum((force**2).sum(axis=2) - along**2, 0.0))
    return np.stack([along, across], axis=2)


def _followed(library: LibraryReadings, features: FloatArray, query: FloatArray, mask: BoolArray) -> FloatArray:
    """The library's force, ``(F - LAG, S, 3)``, along the paths whose features ``(N, S, k)`` are like a query's."""
    flat = features.reshape(len(features), -1)
    scale = np.maximum(flat.std(axis=0), 0.5)
    each = np.repeat(mask, features.shape[2], axis=1)
    examples = np.ascontiguousarray((flat / scale).T, dtype=np.float32)
    search = PathSearch(examples, library.first, float(np.exp(-1.0 / (0.3 * RATE))), 0.1, 2.0, LAG)
    state, out = init_paths(search), []
    for values, valid in zip(query.reshape(len(query), -1) / scale, each, strict=True):
        state = step_paths(search, state, values, valid / max(int(valid.sum()), 1))
        passed, shares = best_paths(search, state, 32, 0.5)
        out.append(np.einsum("k,ksi->si", shares, library.force[passed]))
    return np.array(out[LAG:])


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))
