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
    """The likeliest hidden states, shape ``(T,)``, and their log-likelihood together with what was observed.

    transitions ``(M, M)``, indexed ``[from, to]``; outputs ``(M, K)``: b(symbol | state); observed ``(T,)`` symbols;
    initial ``(M,)``, uniform without it (one 1 makes the first state known); last: the known last state.

    Raises DataError for shapes that disagree, RequestError where no sequence of states has any likelihood.

    >>> a, b = np.array([[0.7, 0.3], [0.4, 0.6]]), np.array([[0.1, 0.4, 0.5], [0.6, 0.3, 0.1]])
    >>> states, score = viterbi(a, b, np.array([0, 1, 2]), initial=np.array([0.6, 0.4]))
    >>> states.tolist(), round(float(np.exp(score)), 5)
    ([1, 0, 0], 0.01344)
    """
    states = len(transitions)
    if transitions.shape != (states, states) or len(outputs) != states or len(observed) == 0:
        raise DataError(
            f"expected transitions (M, M), outputs (M, K) and one observation or more, "
            f"found {transitions.shape}, {outputs.shape} and {len(observed)}"
        )
    start = np.full(states, 1.0 / states) if initial is None else np.asarray(initial, dtype=np.float64)
    with np.errstate(divide="ignore"):
        log_a, log_b, score = np.log(transitions), np.log(outputs), np.log(start)
    score = score + log_b[:, observed[0]]
    back = np.zeros((len(observed), states), dtype=np.int64)
    for t in range(1, len(observed)):
        total = score[:, None] + log_a
        back[t] = total.argmax(axis=0)
        score = total[back[t], np.arange(states)] + log_b[:, observed[t]]
    final = int(score.argmax()) if last is None else last
    if not np.isfinite(score[final]):
        raise RequestError("no sequence of hidden states can give what was observed between these two ends")
    path = [final]
    for t in range(len(observed) - 1, 0, -1):
        path.append(int(back[t, path[-1]]))
    return np.array(path[::-1], dtype=np.int64), float(score[final])


def outputs_by_bayes(counts: FloatArray) -> FloatArray:
    """b(cluster | example), shape ``(M, K)``, from how many samples of each example lie in each cluster, ``(M, K)``.

    Section 3.4: b(example | cluster) is the example's share of the cluster, every cluster is as likely as another,
    and b(cluster | example) is normalised by the example's marginal. A large cluster does not count more than a small
    one, which a mere share of the example's samples would make it.

    >>> outputs_by_bayes(np.array([[6.0, 2.0], [0.0, 2.0]])).round(3).tolist()
    [[0.667, 0.333], [0.0, 1.0]]
    """
    inside = counts / np.maximum(counts.sum(axis=0), 1.0) / counts.shape[1]
    marginal = inside.sum(axis=1, keepdims=True)
    return np.asarray(inside / np.where(marginal > 0, marginal, 1.0))
