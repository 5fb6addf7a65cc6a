"""Which world orientations are in: found by gravity, since sensors at rest read it upwards."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.readings import Readings
from kinetograph.sensing.readings import GRAVITY

UPS = ("y", "z")
"""Axes of a world that may point up."""
_CALM = 0.1  # of gravity, by which the magnitude of a calm row differs from it at most
_ROWS = 10  # calm rows that are enough to decide
_FITS = 0.9  # mean cosine between up and what calm rows read, in the right world
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
