"""Takes that are near-repeats of others: held out, they show how well a library gives back what it has."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions
from kinetograph.learn import Ground
from kinetograph.library import Library
from kinetograph.motion import resample

SECONDS = 2.0
"""Length of the windows that are compared."""
RATE = 10.0
"""Frames per second at which they are compared."""
NEAR = 0.05
"""Metres: a take is a near-repeat if its windows are nearer than this to another take's, in the median.

Three salsa dances of one routine are 4.4 to 4.8 cm from each other, the other four 9 to 19 cm from any. Walks of one
person, which are no repeats, are 5.5 to 6.0 cm from each other.
"""


def repeat_distances(library: Library, track: str | None = None) -> dict[str, float]:
    """How far the windows of each take are from the nearest window of any other take.

    Windows of 2 s are placed on the ground where they fit best; their distance is the root mean square of that of their
    joints. Half of a take's windows are at most as far as the figure.

    Parameters
    ----------
    library : Library
    track : str, optional
        The track that is compared, where takes have several motions.

    Returns
    -------
    dict of str to float
        Metres by take; infinite for a take that is shorter than a window, and where no other is of its skeleton.
    """
    windows = {}
    for name in library.names():
        motion = library.take(name).motion(track)
        windows[name] = motion.skeleton.names, _windows(joint_positions(resample(motion, RATE)))
    return {name: _median_nearest(windows, name) for name in windows}


def near_repeats(distances: dict[str, float]) -> tuple[str, ...]:
    """The takes that are near-repeats of another, unless all are or none is."""
    near = tuple(name for name, distance in distances.items() if distance < NEAR)
    return near if len(near) < len(distances) else ()


def _windows(joints: FloatArray) -> FloatArray:
    """Windows ``(N, S, J, 3)`` of joints ``(F, J, 3)``, one from every frame on."""
    samples = round(SECONDS * RATE) + 1
    if len(joints) < samples:
        return np.zeros((0, samples, *joints.shape[1:]))
    return np.moveaxis(np.lib.stride_tricks.sliding_window_view(joints, samples, axis=0), -1, 1)


def _median_nearest(windows: dict[str, tuple[tuple[str, ...], FloatArray]], name: str) -> float:
    joints, own = windows[name]
    others = [theirs for other, (names, theirs) in windows.items() if other != name and names == joints]
    if not len(own) or not any(len(theirs) for theirs in others):
        return float("inf")
    weights = np.full(own.shape[1:3], 1.0 / (own.shape[1] * own.shape[2]))
    nearest = np.full(len(own), np.inf)
    for theirs in others:
        if len(theirs):
            nearest = np.minimum(nearest, Ground().align(own, theirs, weights)[0].min(axis=1))
    return float(np.sqrt(np.median(nearest)))
