"""Readings and uncertainty as lanes and arrays of the page: thinned, since a page has fewer points than a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.skeleton import Skeleton
from kinetograph.studio.messages import JointsHeader, Lane, Span, blob

if TYPE_CHECKING:
    from kinetograph.methods.sensor import SensorSynthesis
    from kinetograph.sensing import Readings

MOST = 3000
"""Values of a lane: about three for every pixel of a wide page."""
RATE = 60.0
"""Hz at which readings are drawn."""
JOINT_RATE = 15.0
"""Hz, or a little more, of the uncertainty of joints."""


def signal_lane(name: str, role: str, values: FloatArray, unit: str, spans: tuple[Span, ...] = ()) -> Lane:
    """A lane of values at even times, thinned.

    Parameters
    ----------
    name, role : str
    values : ndarray, shape (F,)
    unit : str
    spans : tuple of Span

    Returns
    -------
    Lane
    """
    return Lane(name, role, spans, tuple(np.round(thinned(values, MOST), 2).tolist()), unit)


def thinned(values: FloatArray, most: int) -> FloatArray:
    """At most so many values at even times, the least and the largest of every bin in the order in which they come.

    Parameters
    ----------
    values : ndarray, shape (F,)
    most : int
        Even.

    Returns
    -------
    ndarray, shape (F,) or (most,)

    Examples
    --------
    >>> thinned(np.array([0.0, 0, 9, 0, 0, 0, -5, 0]), 4).tolist()
    [0.0, 9.0, 0.0, -5.0]
    """
    if len(values) <= most:
        return values
    edges = np.linspace(0, len(values), most // 2 + 1).round().astype(np.int64)
    bins = np.minimum(edges[:-1, None] + np.arange(int(np.diff(edges).max())), edges[1:, None] - 1)
    rows = np.arange(len(bins))
    least, largest = (bins[rows, pick(values[bins], axis=1)] for pick in (np.argmin, np.argmax))
    picked = np.sort(np.stack([least, largest], axis=1), axis=1)
    return np.asarray(values[picked].reshape(-1))


def reading_lanes(rows: Readings, names: tuple[str, ...], seconds: float) -> list[Lane]:
    """A lane for each of a layout's sensors that were heard: the magnitude of its force, and where it is missing.

    Parameters
    ----------
    rows : Readings
    names : tuple of str
        The layout's.
    seconds : float
        Of the motion that they gave.

    Returns
    -------
    list of Lane
    """
    from kinetograph.sensing import select_sensors, uniform

    worn = [name for name in names if name in rows.names]
    signal = uniform(select_sensors(rows, worn), RATE, seconds)
    force = np.linalg.norm(signal.values.reshape(len(signal), -1, 3), axis=2)
    lanes = []
    for index, name in enumerate(worn):
        valid = signal.valid[:, 3 * index]
        lanes.append(
            signal_lane(name.replace("_", " "), "readings", _filled(force[:, index], valid), "m/s²", _gaps(valid))
        )
    return lanes


def _filled(values: FloatArray, valid: BoolArray) -> FloatArray:
    """Values with straight lines over what is missing."""
    if valid.all() or not valid.any():
        return np.where(valid, values, 0.0)
    frames = np.arange(len(values))
    return np.interp(frames, frames[valid], values[valid])


def _gaps(valid: BoolArray) -> tuple[Span, ...]:
    """Spans in which readings are missing."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (~valid).astype(np.int8), [0]])))
    return tuple(
        Span(float(start) / RATE, float(stop) / RATE, "missing", "no readings for longer than gaps are filled")
        for start, stop in edges.reshape(-1, 2)
    )


def joint_values(number: int, synthesis: SensorSynthesis, skeleton: Skeleton) -> bytes:
    """The uncertainty of the joints of the body that is shown as a blob, at `JOINT_RATE` or a little more.

    Parameters
    ----------
    number : int
        Of the question.
    synthesis : SensorSynthesis
    skeleton : Skeleton
        The character's, or the motion's own.

    Returns
    -------
    bytes
    """
    motion = synthesis.motion
    every = max(int(motion.fps / JOINT_RATE), 1)
    values = synthesis.uncertainty[::every][:, joints_alike(skeleton, motion.skeleton)]
    header = JointsHeader(number, motion.fps / every, skeleton.names, len(values))
    return blob(header, values.astype("<f4").tobytes())


def joints_alike(skeleton: Skeleton, of: Skeleton) -> IntArray:
    """For each joint of a skeleton the one of another that it moves with: of its role or name, or its parent's.

    Parameters
    ----------
    skeleton, of : Skeleton

    Returns
    -------
    ndarray of int, shape (J,)
    """
    roles = {landmark.joint: role for role, landmark in skeleton.roles.items() if not landmark.offset.any()}
    alike = np.zeros(len(skeleton), dtype=np.int64)
    for joint, name in enumerate(skeleton.names):
        if name in of.names:
            alike[joint] = of.index(name)
        elif roles.get(joint) in of.roles:
            alike[joint] = of.roles[roles[joint]].joint
        elif joint:
            alike[joint] = alike[skeleton.parents[joint]]
    return alike
