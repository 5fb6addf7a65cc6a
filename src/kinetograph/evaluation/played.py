"""What a result does that the recordings which play in it do not do themselves."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import accelerations
from kinetograph.filters import running_max
from kinetograph.methods.keyframe import Example
from kinetograph.methods.performance import Source
from kinetograph.motion import Motion
from kinetograph.synthesis import Synthesis

AROUND = 0.15
"""Seconds before and after a frame in which a recording counts too."""


class Played:
    """Recordings that may play in results.

    Parameters
    ----------
    recordings : iterable of Source or Example
        Mirror images are passed over; of two of one take the first counts.
    """

    def __init__(self, recordings: Iterable[Source | Example]) -> None:
        self._motions: dict[str, Motion] = {}
        self._own: dict[str, FloatArray] = {}
        for each in recordings:
            if not each.mirrored:
                self._motions.setdefault(each.take, each.motion)

    def accelerations(self, made: Synthesis, usual: float) -> FloatArray:
        """The accelerations of all joints, as multiples of what is usual, or of what the recording that plays has.

        Parameters
        ----------
        made : Synthesis
        usual : float
            m/s^2.

        Returns
        -------
        ndarray, shape (F - 2, J)
            Multiples of the greater of both: of ``usual``, and of the greatest that the recording has around there.
        """
        found = accelerations(made.motion)
        limits = np.full(len(found), usual)
        for frame in range(len(found)):
            piece, second = made.piece_at(frame + 1), (frame + 1) / made.motion.fps
            limits[frame] = max(usual, self._at(piece.take, float(piece.source_time(np.array([second]))[0])))
        return np.asarray(found / limits[:, None])

    def _at(self, take: str, second: float) -> float:
        motion = self._motions.get(take)
        if motion is None or len(motion) < 3:
            return 0.0
        if take not in self._own:
            most = accelerations(motion).max(axis=1)
            self._own[take] = running_max(most, 2 * round(AROUND * motion.fps) + 1)
        own = self._own[take]
        return float(own[int(np.clip(round(second * motion.fps) - 1, 0, len(own) - 1))])
