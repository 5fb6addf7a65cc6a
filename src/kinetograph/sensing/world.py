"""Which world orientations are in: found by gravity, since sensors at rest read it upwards."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.readings import Readings
from kinetograph.sensing.readings import GRAVITY
from kinetograph.sensing.segment_frames import orientations_of_sensors

UPS = ("y", "z")
"""Axes of a world that may point up."""
_CALM = 0.1  # of gravity, by which the magnitude of a calm row differs from it at most
_ROWS = 10  # calm rows that are enough to decide
_FITS = 0.9  # mean cosine between up and what calm rows read, in the right world
_CLOSE = 0.1  # of that cosine, by which another world may agree better than the one that is said
_LEAST = 0.5  # of it, below which not even that world is believed
_FROM_Z = np.array([np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0])  # z up to y up


@dataclass(frozen=True)
class World:
    """What orientations mean.

    Parameters
    ----------
    up : {"y", "z"}
        The world's axis that points up.
    inverse : bool
        Whether quaternions go from the world to the sensor rather than from the sensor to the world.
    """

    up: str = "y"
    inverse: bool = False

    def __str__(self) -> str:
        return f"{self.up} up, from {'world to sensor' if self.inverse else 'sensor to world'}"


def find_world(readings: Readings, up: str | None = None) -> World:
    """The world in which calm rows read gravity upwards.

    Parameters
    ----------
    readings : Readings
        With orientations.
    up : {"y", "z"}, optional
        The axis that points up, where it is known.

    Returns
    -------
    World

    Raises
    ------
    RequestError
        Without orientations, with too few calm rows, and where no world fits.
    """
    if up is not None and up not in UPS:
        raise RequestError(f"the upward axis of sensors must be y or z, found {up!r}")
    if readings.orientation is None:
        raise RequestError("expected readings with orientations, columns qw,qx,qy,qz, found none")
    size = np.linalg.norm(readings.force, axis=1)
    calm = np.abs(size - GRAVITY) < _CALM * GRAVITY
    if calm.sum() < _ROWS:
        raise RequestError(
            f"which way up orientations are is found from rows near 9.81 m/s^2: expected {_ROWS}, found {calm.sum()}; "
            "begin with a moment of standing still, or use --use force"
        )
    upward = readings.force[calm] / size[calm, None]
    q = rot.normalize(readings.orientation[calm])
    worlds = [World(axis, inverse) for inverse in (False, True) for axis in (UPS if up is None else (up,))]
    scores = [_agreement(world, q, upward) for world in worlds]
    best = int(np.argmax(np.round(scores, 2)))  # of equals the first: the usual direction
    if scores[best] < _FITS:
        tried = ", ".join(f"{world}: {score:.2f}" for world, score in zip(worlds, scores, strict=True))
        raise RequestError(
            f"orientations do not agree with gravity in any world (1 is perfect; {tried}); use --use force without them"
        )
    return worlds[best]


def as_said(readings: Readings, said: World | None = None, up: str | None = None) -> tuple[Readings, tuple[str, ...]]:
    """Readings with orientations from the sensor to a world with Y up, whatever their file says, if gravity says so.

    Parameters
    ----------
    readings : Readings
        With orientations as a file has them.
    said : World, optional
        What the file says of them; without it, gravity decides.
    up : {"y", "z"}, optional
        The axis that points up, where a person says it.

    Returns
    -------
    readings : Readings
    notes : tuple of str
        What was found by gravity, or taken as usual of a handful of rows, and where the file is wrong.

    Raises
    ------
    RequestError
        Where gravity at rest agrees with no world, and where nothing is said and too few rows are calm.
    """
    given = World(up or said.up, said.inverse) if said is not None else None
    if given is not None and (count_calm(readings) < _ROWS or _is_likely(readings, given)):
        return in_our_world(readings, given), ()
    if len(readings) < _ROWS:
        world = World(up or "y")
        return in_our_world(readings, world), (f"orientations taken as {world}: {len(readings)} rows cannot show it",)
    try:
        world = find_world(readings, up)
    except RequestError:
        if readings.angular is None or count_calm(readings) < _ROWS:
            raise
        return _of_segments(readings, up)
    if given is not None:
        return in_our_world(readings, world), (f"orientations are said to be {given}; gravity shows {world}: taken so",)
    return in_our_world(readings, world), () if world == World() else (
        f"orientations taken as {world}, as gravity shows",
    )


def _is_likely(readings: Readings, given: World) -> bool:
    """Whether no other world agrees better with gravity: in fast movement none agrees well."""
    scores = [agreement_with(readings, World(up, inverse)) for up in UPS for inverse in (False, True)]
    own = agreement_with(readings, given)
    return own >= _FITS or (own >= _LEAST and own >= max(scores) - _CLOSE)


def _of_segments(readings: Readings, up: str | None) -> tuple[Readings, tuple[str, ...]]:
    """Readings whose orientations are of segments rather than of sensors."""
    for inverse in (False, True):
        with suppress(RequestError):
            own = orientations_of_sensors(readings, inverse)
            world = find_world(own, up)
            line = "orientations are of segments, not of the sensors; brought to the sensors' frames by gyroscopes"
            return in_our_world(own, world), (f"{line}, {world}, as gravity shows",)
    find_world(readings, up)  # says how little each world agrees
    raise AssertionError("a world was found after all")


def count_calm(readings: Readings) -> int:
    """The number of rows that read little more than gravity."""
    return int(_calm(readings).sum())


def _calm(readings: Readings) -> BoolArray:
    size = np.linalg.norm(readings.force, axis=1)
    return np.asarray(np.abs(size - GRAVITY) < _CALM * GRAVITY)


def agreement_with(readings: Readings, world: World) -> float:
    """Mean cosine between up and what calm rows read, were their orientations of a world; 1 is perfect."""
    calm = _calm(readings)
    upward = readings.force[calm] / np.linalg.norm(readings.force[calm], axis=1, keepdims=True)
    assert readings.orientation is not None
    return _agreement(world, rot.normalize(readings.orientation[calm]), upward)


def in_our_world(readings: Readings, world: World) -> Readings:
    """The same readings with orientations from the sensor to a world with Y up.

    Parameters
    ----------
    readings : Readings
    world : World
        What their orientations mean.

    Returns
    -------
    Readings
    """
    if readings.orientation is None or world == World():
        return readings
    q = rot.conjugate(readings.orientation) if world.inverse else readings.orientation
    return replace(readings, orientation=rot.multiply(_FROM_Z, q) if world.up == "z" else q)


def _agreement(world: World, q: FloatArray, upward: FloatArray) -> float:
    """Mean cosine between up and what calm rows read, ``(R, 3)``, were they in that world."""
    turned = rot.rotate(rot.conjugate(q) if world.inverse else q, upward)
    return float(turned[:, "xyz".index(world.up)].mean())
