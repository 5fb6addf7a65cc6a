"""Hidden Markov models with discrete outputs: Viterbi in the log domain, both ends known if need be."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError, RequestError


def viterbi(
    transitions: FloatArray,
    outputs: FloatArray,
    observed: IntArray,
    *,
    initial: FloatArray | None = None,
    last: int | None = None,
) -> tuple[IntArray, float]:
    """The likeliest sequence of hidden states for what was observed.

    Parameters
    ----------
    transitions : ndarray, shape (M, M)
        Probabilities, indexed ``[from, to]``.
    outputs : ndarray, shape (M, K)
        b(symbol | state).
    observed : ndarray of int, shape (T,)
        Symbols.
    initial : ndarray, shape (M,), optional
        Probabilities of the first state, uniform without it; a single 1 makes the first state known.
    last : int, optional
        The last state, where it is known.

    Returns
    -------
    states : ndarray of int, shape (T,)
    score : float
        Log-likelihood of the states together with what was observed.

    Raises
    ------
    DataError
        For shapes that disagree.
    RequestError
        Where no sequence of states has any likelihood.

    Examples
    --------
    >>> a, b = np.array([[0.7, 0.3], [0.4, 0.6]]), np.array([[0.1, 0.4, 0.5], [0.6, 0.3, 0.1]])
    >>> states, score = viterbi(a, b, np.array([0, 1, 2]), initial=np.array([0.6, 0.4]))
    >>> states.tolist(), round(float(np.exp(score)), 5)
    ([1, 0, 0], 0.01344)
    """
    _check(transitions, outputs, observed)
    states = len(transitions)
    start = np.full(states, 1.0 / states) if initial is None else np.asarray(initial, dtype=np.float64)
    with np.errstate(divide="ignore"):
        score, back = _forward(np.log(transitions), np.log(outputs)[:, observed].T, np.log(start))
    final = int(score.argmax()) if last is None else last
    if not np.isfinite(score[final]):
        raise RequestError("no sequence of hidden states can give what was observed between these two ends")
    path = [final]
    for before in back[:0:-1]:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], dtype=np.int64), float(score[final])


def _check(transitions: FloatArray, outputs: FloatArray, observed: IntArray) -> None:
    states = len(transitions)
    if transitions.shape != (states, states) or len(outputs) != states or len(observed) == 0:
        raise DataError(
            f"expected transitions (M, M), outputs (M, K) and one observation or more, "
            f"found {transitions.shape}, {outputs.shape} and {len(observed)}"
        )


def _forward(transitions: FloatArray, emitted: FloatArray, initial: FloatArray) -> tuple[FloatArray, IntArray]:
    """Log-likelihoods ``(M,)`` of the best sequences that end in each state, and each step's state before, ``(T, M)``.

    transitions, emitted ``(T, M)`` and initial are in the log domain.
    """
    score = initial + emitted[0]
    back = np.zeros(emitted.shape, dtype=np.int64)
    for t in range(1, len(emitted)):
        total = score[:, None] + transitions
        back[t] = total.argmax(axis=0)
        score = total[back[t], np.arange(len(score))] + emitted[t]
    return score, back


def outputs_by_bayes(counts: FloatArray) -> FloatArray:
    """Output probabilities of examples over clusters, from counts of samples (section 3.4).

    Parameters
    ----------
    counts : ndarray, shape (M, K)
        How many samples of each example lie in each cluster.

    Returns
    -------
    ndarray, shape (M, K)
        b(cluster | example).

    Notes
    -----
    b(example | cluster) is the example's share of the cluster, every cluster is as likely as another, and
    b(cluster | example) is normalised by the example's marginal. A large cluster does not count more than a small one,
    as it would if the result were a mere share of the example's samples.

    Examples
    --------
    >>> outputs_by_bayes(np.array([[6.0, 2.0], [0.0, 2.0]])).round(3).tolist()
    [[0.667, 0.333], [0.0, 1.0]]
    """
    inside = counts / np.maximum(counts.sum(axis=0), 1.0) / counts.shape[1]
    marginal = inside.sum(axis=1, keepdims=True)
    return np.asarray(inside / np.where(marginal > 0, marginal, 1.0))
