"""Complete-linkage clustering under a distance threshold (Hsu 2004, section 4.4.2)."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError


def complete_linkage(distances: FloatArray, threshold: float) -> IntArray:
    """Clusters no two members of which are further apart than a threshold.

    Parameters
    ----------
    distances : ndarray, shape (N, N)
        Symmetric; any of them may be infinite.
    threshold : float

    Returns
    -------
    ndarray of int, shape (N,)
        Labels, numbered by first appearance.

    Raises
    ------
    DataError
        For distances that are not a symmetric matrix, and a threshold below 0 or infinite.

    Examples
    --------
    >>> d = np.abs(np.subtract.outer([0.0, 1.0, 5.0], [0.0, 1.0, 5.0]))
    >>> complete_linkage(d, 2.0).tolist()
    [0, 0, 1]
    """
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    distances = np.asarray(distances, dtype=np.float64)
    if distances.ndim != 2 or distances.shape[0] != distances.shape[1] or not np.allclose(distances, distances.T):
        raise DataError(f"distances must be a symmetric matrix, found shape {distances.shape}")
    if not 0 <= threshold < np.inf:
        raise DataError(f"a clustering threshold must be 0 or more, found {threshold}")
    if len(distances) < 2:
        return np.zeros(len(distances), dtype=np.int64)
    finite = distances[np.isfinite(distances)]
    apart = 10 * max(float(finite.max()), threshold, 1.0)
    condensed = squareform(np.where(np.isfinite(distances), distances, apart), checks=False)
    labels = fcluster(linkage(condensed, method="complete"), t=threshold, criterion="distance")
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse], dtype=np.int64)


def representatives(distances: FloatArray, labels: IntArray, rng: np.random.Generator | None = None) -> IntArray:
    """One member of each cluster.

    Parameters
    ----------
    distances : ndarray, shape (N, N)
    labels : ndarray of int, shape (N,)
    rng : numpy.random.Generator, optional
        Draws the members, as the thesis does; without it they are the medoids.

    Returns
    -------
    ndarray of int
        Indices of the members, ascending.
    """
    chosen = []
    for label in np.unique(labels):
        members = np.flatnonzero(labels == label)
        if rng is not None:
            chosen.append(int(rng.choice(members)))
        else:
            within = distances[np.ix_(members, members)]
            chosen.append(int(members[np.argmin(np.where(np.isfinite(within), within, 0.0).sum(axis=1))]))
    return np.array(sorted(chosen), dtype=np.int64)
