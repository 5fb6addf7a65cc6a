"""The rotation and offset of one sensor that best explain its readings: Wahba's problem, solved robustly."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray

LARGEST_OFFSET = 2.0
"""m/s^2; a greater offset cannot be a sensor's and is left out."""
ROUNDS = 20
"""Rounds of reweighting."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """What one sensor measured, and what it should have measured.

    Parameters
    ----------
    measured, reference : ndarray, shape (F, 3)
        In m/s^2.
    uncalibrated : ndarray, shape (F, 3), optional
        The reference for readings that are not calibrated, where it is another one.
    standing : pair of ndarray, shape (3,), optional
        A reading at rest and its reference, with the weight of a third of the frames.
    biased : bool
        Whether the sensor may have an offset.
    """

    measured: FloatArray
    reference: FloatArray
    uncalibrated: FloatArray | None = None
    standing: tuple[FloatArray, FloatArray] | None = None
    biased: bool = True

    def part(self, rows: slice) -> Pairs:
        """Some of the frames."""
        return replace(self, measured=self.measured[rows], reference=self.reference[rows])


def wahba(measured: FloatArray, reference: FloatArray, weights: FloatArray | None = None) -> FloatArray:
    """The quaternion that best rotates vectors onto others, by Kabsch's singular value decomposition.

    Parameters
    ----------
    measured, reference : ndarray, shape (N, 3)
    weights : ndarray, shape (N,), optional

    Returns
    -------
    ndarray, shape (4,)

    Examples
    --------
    >>> q = rot.about("y", 0.3)
    >>> v = np.eye(3)
    >>> bool(np.allclose(wahba(v, rot.rotate(q, v)), q))
    True
    """
    w = np.ones(len(measured)) if weights is None else weights
    u, _, vt = np.linalg.svd(np.einsum("n,ni,nj->ij", w, reference, measured))
    handed = np.diag([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    return rot.from_matrix(u @ handed @ vt)


def fit_pairs(pairs: Pairs) -> tuple[FloatArray, FloatArray]:
    """Rotation ``(4,)`` and offset ``(3,)`` m/s^2 of one sensor, found in alternation."""
    measured, reference = pairs.measured, pairs.reference
    offset = np.zeros(3)
    rotation = rot.IDENTITY
    # foot impacts, which bones of no mass overstate, would otherwise decide
    for _ in range(ROUNDS):
        error = np.linalg.norm(rot.rotate(rotation, measured - offset) - reference, axis=1)
        weights = 1.0 / np.maximum(error, np.median(error) + 1e-9)
        rotation = _rotation(pairs, measured - offset, weights)
        if not pairs.biased:
            continue
        away = measured - rot.rotate(rot.conjugate(rotation), reference)
        offset = (weights[:, None] * away).sum(axis=0) / weights.sum()
        if np.linalg.norm(offset) > LARGEST_OFFSET:
            offset = np.zeros(3)
    return rotation, offset


def _rotation(pairs: Pairs, measured: FloatArray, weights: FloatArray) -> FloatArray:
    if pairs.standing is None:
        return wahba(measured, pairs.reference, weights)
    read, wanted = pairs.standing
    return wahba(
        np.concatenate([measured, read[None]]),
        np.concatenate([pairs.reference, wanted[None]]),
        np.append(weights, 0.5 * weights.sum()),
    )
