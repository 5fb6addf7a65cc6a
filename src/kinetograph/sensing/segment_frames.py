"""Orientations that are of the segments on which sensors sit, made those of the sensors by what gyroscopes read.

Programs that know a body give quaternions of its segments, from the segment's frame to the world's, beside readings in
the sensors' own frames. The rotation between the two is constant: it takes the angular velocity that a gyroscope reads
to the one that the quaternions have.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.readings import Readings
from kinetograph.sensing.rotation_fit import wahba

MOVING = 0.5
"""rad/s from which on a row says how a sensor rotates."""
FEWEST = 50
"""Such rows that are needed of each sensor."""
SEVERAL = 0.005
"""Mean square of axes of rotation across the usual one, below which there is no other: 4 degrees."""
ALIKE = 0.8
"""Cosine between angular velocities that agree; of one frame it is above 0.9 in recordings of whole bodies."""


def orientations_of_sensors(readings: Readings, inverse: bool = False) -> Readings:
    """The same readings with orientations of the sensors in place of those of segments.

    Parameters
    ----------
    readings : Readings
        With orientations and angular velocities.
    inverse : bool
        Whether quaternions go from the world to the segment.

    Returns
    -------
    Readings
        With orientations from the sensors to the same world.

    Raises
    ------
    RequestError
        Without either, with too little movement, and where no constant rotation explains what gyroscopes read.
    """
    if readings.orientation is None or readings.angular is None:
        raise RequestError("expected readings with orientations and angular velocities, found none")
    q = rot.normalize(rot.conjugate(readings.orientation) if inverse else readings.orientation)
    facing = q.copy()
    for index, name in enumerate(readings.names):
        rows = np.flatnonzero(readings.sensors == index)
        facing[rows] = rot.multiply(q[rows], _mount(name, readings.times[rows], q[rows], readings.angular[rows]))
    return replace(readings, orientation=facing)


def _mount(name: str, times: FloatArray, q: FloatArray, angular: FloatArray) -> FloatArray:
    """Quaternion from the sensor's frame to the segment's."""
    rates = rot.log(rot.multiply(rot.conjugate(q[:-1]), q[1:])) / np.diff(times)[:, None]
    read = 0.5 * (angular[1:] + angular[:-1])
    moving = np.linalg.norm(read, axis=1) > MOVING
    if moving.sum() < FEWEST:
        raise RequestError(f"sensor {name!r}: expected {FEWEST} rows or more in which it rotates, found {moving.sum()}")
    read, rates = read[moving], rates[moving]
    axes = read / np.linalg.norm(read, axis=1, keepdims=True)
    if float(np.linalg.eigvalsh(axes.T @ axes / len(axes))[1]) < SEVERAL:
        raise RequestError(f"sensor {name!r}: it rotates about one axis only, which leaves its rotation about it open")
    mount = wahba(read, rates)
    sizes = np.sqrt((read**2).sum() * (rates**2).sum())
    alike = float((rot.rotate(mount, read) * rates).sum() / max(sizes, 1e-12))
    if alike < ALIKE:
        raise RequestError(
            f"sensor {name!r}: orientations do not rotate as its gyroscope says (likeness {alike:.2f}, 1 is the same)"
        )
    return mount
