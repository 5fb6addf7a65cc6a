"""What a control may do next: what controls like it did in the recordings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.learn import PreparedExamples
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.methods.performance.weights import weights

PAST = 1.0
"""Seconds of a control that are compared."""
AHEAD = 1.0
"""Seconds that are forecast."""
NEAREST = 4
"""Continuations whose mean is the forecast."""


@dataclass(frozen=True, eq=False)
class Continuations:
    """Windows of the recorded controls, and how each went on.

    Parameters
    ----------
    fitted : Fitted
    windows : PreparedExamples
        N windows of S samples.
    ends : ndarray, shape (N, P, 3)
        Their last samples.
    futures : ndarray, shape (N, H, P, 3)
        The samples after them.
    past : int
        S.
    """

    fitted: Fitted
    windows: PreparedExamples
    ends: FloatArray
    futures: FloatArray
    past: int

    @classmethod
    def of(cls, fitted: Fitted, past: float = PAST, ahead: float = AHEAD) -> Continuations | None:
        """All windows of the recordings, None where none is long enough."""
        rate = fitted.settings.rate
        before, after = max(round(past * rate), 1) + 1, max(round(ahead * rate), 1)
        whole = []
        for source in fitted.sources:
            points = at_rate(source.control_points, source.motion.fps, rate)
            if len(points) >= before + after:
                view = np.lib.stride_tricks.sliding_window_view(points, before + after, axis=0)
                whole.append(np.moveaxis(view, -1, 1))
        if not whole:
            return None
        windows = np.concatenate(whole)
        examples = np.ascontiguousarray(windows[:, :before])
        prepared = fitted.settings.alignment.prepare(examples, weights(fitted.settings, before))
        return cls(fitted, prepared, examples[:, -1], np.ascontiguousarray(windows[:, before:]), before)

    def after(self, samples: FloatArray) -> FloatArray | None:
        """How a control may go on.

        Parameters
        ----------
        samples : ndarray, shape (T, P, 3)
            Control points at the search's rate, the latest last.

        Returns
        -------
        ndarray, shape (H, P, 3), or None
            None before enough of the control has been seen.
        """
        if len(samples) < self.past:
            return None
        costs, placement = self.windows.align(samples[-self.past :])
        best = np.argsort(costs[0])[:NEAREST]
        share = 1.0 / (costs[0][best] + 1e-9)
        moves = []
        for index in best.tolist():
            rotation, _ = placement.transform(0, index)
            move = self.futures[index] - self.ends[index]
            moves.append(rot.rotate(rotation, move * placement.scale(0, index)))
        return np.asarray(samples[-1] + np.average(moves, axis=0, weights=share))
