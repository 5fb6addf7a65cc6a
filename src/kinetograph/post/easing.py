"""The smooth step, by which weights rise and fall."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray


def smoothstep(u: FloatArray) -> FloatArray:
    """The cubic from 0 at ``u <= 0`` to 1 at ``u >= 1``, level at both ends.

    Parameters
    ----------
    u : ndarray, shape (...)

    Returns
    -------
    ndarray, shape (...)

    Examples
    --------
    >>> smoothstep(np.array([-1.0, 0.25, 0.5, 2.0])).tolist()
    [0.0, 0.15625, 0.5, 1.0]
    """
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))
