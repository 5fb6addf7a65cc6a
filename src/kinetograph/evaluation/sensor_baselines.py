"""What sensor control has to beat: estimates of a pose from one frame of readings, without a model of movement.

Each but the mean pose is also smoothed by the methods' own window, with its delay: unsmoothed, a baseline shakes, which
flatters the methods in jitter and in error alike.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.sensor import Examples, WindowSmoothing

BASELINES = ("mean pose", "nearest frame", "8 nearest frames", "linear ridge")
"""The baselines' names."""
SMOOTHED = ", smoothed"
"""How the name of a smoothed baseline ends."""


def baselines(
    examples: Examples, readings: FloatArray, smoothing: WindowSmoothing | None = None
) -> Iterator[tuple[str, FloatArray]]:
    """The poses of every baseline, as it is and smoothed.

    Parameters
    ----------
    examples : Examples
    readings : ndarray, shape (F, C)
        Divided by the examples' scale.
    smoothing : WindowSmoothing, optional
        The thesis' window of eight frames by default.

    Yields
    ------
    name : str
    poses : ndarray, shape (F, D)
        Pose vectors.
    """
    for name in BASELINES:
        poses = baseline(name, examples, readings)
        yield name, poses
        if name != "mean pose":
            yield name + SMOOTHED, smoothed(poses, smoothing or WindowSmoothing())


def smoothed(poses: FloatArray, window: WindowSmoothing) -> FloatArray:
    """The means of pose vectors ``(F, D)`` over a window; at the ends it holds fewer frames."""
    frames = np.arange(len(poses))
    sums = np.concatenate([np.zeros((1, poses.shape[1])), np.cumsum(poses, axis=0)])
    start = np.maximum(frames - window.behind, 0)
    stop = np.minimum(frames + window.ahead + 1, len(poses))
    return np.asarray((sums[stop] - sums[start]) / (stop - start)[:, None])


def baseline(name: str, examples: Examples, readings: FloatArray) -> FloatArray:
    """Poses by one of `BASELINES`.

    Parameters
    ----------
    name : str
    examples : Examples
    readings : ndarray, shape (F, C)
        Divided by the examples' scale.

    Returns
    -------
    ndarray, shape (F, D)
        Pose vectors.

    Raises
    ------
    RequestError
        For an unknown baseline.
    """
    if name == "mean pose":
        return np.repeat(examples.poses.mean(axis=0, dtype=np.float64)[None], len(readings), axis=0)
    if name in ("nearest frame", "8 nearest frames"):
        count = 1 if name == "nearest frame" else min(8, len(examples))
        near = np.asarray(cKDTree(examples.readings).query(readings, count)[1]).reshape(len(readings), -1)
        return np.asarray(examples.poses[near].mean(axis=1, dtype=np.float64))
    if name == "linear ridge":
        return ridge(examples.readings.astype(np.float64), examples.poses.astype(np.float64), readings)
    raise RequestError(f"no baseline {name!r}; expected one of {', '.join(BASELINES)}")


def ridge(inputs: FloatArray, outputs: FloatArray, new: FloatArray, weight: float = 1e-3) -> FloatArray:
    """Linear regression with an intercept and a penalty on the slopes.

    Parameters
    ----------
    inputs : ndarray, shape (N, C)
    outputs : ndarray, shape (N, D)
    new : ndarray, shape (F, C)
    weight : float
        Penalty per frame.

    Returns
    -------
    ndarray, shape (F, D)
    """
    centre, middle = inputs.mean(axis=0), outputs.mean(axis=0)
    x = inputs - centre
    slopes = np.linalg.solve(x.T @ x + weight * len(x) * np.eye(x.shape[1]), x.T @ (outputs - middle))
    return np.asarray(middle + (new - centre) @ slopes)
