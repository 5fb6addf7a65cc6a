"""The mean of the examples whose readings are nearest: hard to beat where the library has nearly the same movement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, SingleArray
from kinetograph.learn import NeighbourLists, nearest_columns, nearest_listed
from kinetograph.methods.sensor.estimators import Estimate
from kinetograph.methods.sensor.examples import Examples

AROUND = 64
"""Examples that are averaged, with weights that fall to nothing at the furthest: a mean that does not jump."""
NEAREST = 8
"""Examples that say how near the library is."""


@dataclass(frozen=True, eq=False)
class Near:
    """What the nearest examples say of a frame.

    Parameters
    ----------
    estimate : Estimate
    distance : float
        Mean distance of the nearest ``NEAREST`` of them, in standard deviations of a reading.
    """

    estimate: Estimate
    distance: float


class NearestExamples:
    """The examples nearest to smoothed readings.

    Parameters
    ----------
    examples : Examples
    search : ndarray of float32, shape (C + B, N), or NeighbourLists
        Their smoothed readings, and more channels, which are ignored.
    """

    def __init__(self, examples: Examples, search: SingleArray | NeighbourLists) -> None:
        self._examples, self._search = examples, search
        rows = search.centres.shape[1] if isinstance(search, NeighbourLists) else len(search)
        self._more = np.zeros(rows - examples.readings.shape[1])

    def of(self, readings: FloatArray, valid: BoolArray) -> Near:
        """What those nearest to readings ``(C,)`` say, of which some are valid ``(C,)``."""
        query = np.concatenate([readings, self._more])
        weights = np.concatenate([valid / max(int(valid.sum()), 1), self._more])
        if isinstance(self._search, NeighbourLists):
            rows, squares = nearest_listed(self._search, query, weights, AROUND)
        else:
            rows, squares = nearest_columns(self._search, query, weights, AROUND)
        shares = squares.max() - squares + 1e-9
        shares /= shares.sum()
        poses = self._examples.poses[rows].astype(np.float64)
        pose, best = shares @ poses, int(np.argmin(squares))
        root = shares @ self._examples.root_features[rows].astype(np.float64)
        made = Estimate(pose, root, shares @ (poses - pose) ** 2, int(rows[best]), float(squares[best]))
        return Near(made, float(np.sqrt(np.sort(squares)[:NEAREST]).mean()))
