"""Components, K-means, Markov chains and Viterbi: textbook answers, enumeration, invariants."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import naive_keyframe as naive
from kinetograph.errors import DataError, RequestError
from kinetograph.learn.distances import squared_distances, squared_distances_to
from kinetograph.learn.hmm import outputs_by_bayes, viterbi
from kinetograph.learn.markov import UnreachableError, count_transitions, likeliest_path
from kinetograph.learn.quantisation import kmeans
from kinetograph.learn.reduction import fit_pca

seeds = st.integers(0, 10_000)


def test_viterbi_gives_the_textbook_answer():
    # the healthy/fever example: normal, cold, dizzy -> healthy, healthy, fever with probability .01512
    a = np.array([[0.7, 0.3], [0.4, 0.6]])
    b = np.array([[0.5, 0.4, 0.1], [0.1, 0.3, 0.6]])
    states, score = viterbi(a, b, np.array([0, 1, 2]), initial=np.array([0.6, 0.4]))
    assert states.tolist() == [0, 0, 1]
    assert np.exp(score) == pytest.approx(0.01512)


@given(seeds, st.integers(1, 4), st.integers(1, 5), st.booleans())
def test_viterbi_is_what_enumeration_finds(seed: int, states: int, length: int, known: bool):
    rng = np.random.default_rng(seed)
    a, b = rng.dirichlet(np.ones(states), states), rng.dirichlet(np.ones(3), states)
    initial, observed = rng.dirichlet(np.ones(states)), rng.integers(3, size=length)
    last = int(rng.integers(states)) if known else None
    path, score = viterbi(a, b, observed, initial=initial, last=last)
    assert np.exp(score) == pytest.approx(naive.viterbi(a, b, observed, initial, last))
    assert last is None or path[-1] == last


def test_viterbi_survives_lengths_at_which_probabilities_underflow():
    a, b = np.array([[0.9, 0.1], [0.1, 0.9]]), np.array([[0.01, 0.02], [0.02, 0.01]])
    _, score = viterbi(a, b, np.zeros(5000, dtype=int))
    assert np.isfinite(score)
    assert score < -10_000


def test_viterbi_refuses_what_cannot_be():
    a, b = np.eye(2), np.ones((2, 1))
    with pytest.raises(RequestError, match="no sequence of hidden states"):
        viterbi(a, b, np.array([0, 0]), initial=np.array([1.0, 0.0]), last=1)
    with pytest.raises(DataError, match="expected transitions"):
        viterbi(a, b, np.array([], dtype=int))


def test_outputs_weigh_clusters_evenly():
    # two clusters, of 8 and 2 samples; the first example owns 6 of the large one and 1 of the small one
    b = outputs_by_bayes(np.array([[6.0, 1.0], [2.0, 1.0]]))
    assert b[0] == pytest.approx([0.75 / 1.25, 0.5 / 1.25])
    assert b.sum(axis=1) == pytest.approx([1, 1])


def test_transitions_are_counts_over_occurrences():
    p = count_transitions([np.array([0, 0, 1, 2]), np.array([2, 0])], 4)
    assert p[0].tolist() == pytest.approx([1 / 3, 1 / 3, 0, 0])
    assert p[1].tolist() == [0, 0, 1, 0]
    assert p[2].tolist() == [0.5, 0, 0, 0]
    assert not p[3].any()


@given(seeds, st.integers(2, 6))
def test_the_likeliest_path_is_what_enumeration_finds(seed: int, states: int):
    rng = np.random.default_rng(seed)
    p = rng.dirichlet(np.ones(states), states) * (rng.random((states, states)) < 0.6)
    start, stop = (int(s) for s in rng.integers(states, size=2))
    best = naive.likeliest_path(p, start, stop)
    if best == 0:
        with pytest.raises(UnreachableError, match="no path of the Markov chain"):
            likeliest_path(p, start, stop)
        return
    path, score = likeliest_path(p, start, stop)
    assert np.exp(score) == pytest.approx(best)
    assert (path[0], path[-1]) == (start, stop)
    assert (np.diff(path) != 0).all()


def test_an_unreachable_state_names_those_that_can_be_reached():
    p = np.array([[0.5, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(UnreachableError, match=r"from state 0 to 2; reachable: 0, 1") as caught:
        likeliest_path(p, 0, 2)
    assert caught.value.reachable.tolist() == [0, 1]


def test_components_find_the_plane_that_data_lie_in():
    rng = np.random.default_rng(0)
    plane = np.linalg.qr(rng.normal(size=(6, 2)))[0].T
    x = 3 + rng.normal(size=(50, 2)) * [5, 1] @ plane
    pca = fit_pca(x, 0.999)
    assert pca.basis.shape == (6, 2)
    assert pca.share == pytest.approx(1)
    assert pca.decode(pca.encode(x)) == pytest.approx(x)
    assert fit_pca(x, 0.9).basis.shape == (6, 1)


@given(seeds, st.floats(0.05, 0.999))
def test_components_keep_the_share_asked_for_and_no_more_than_needed(seed: int, share: float):
    x = np.random.default_rng(seed).normal(size=(20, 5)) * [5, 3, 1, 0.5, 0.1]
    pca = fit_pca(x, share)
    assert pca.share >= share - 1e-9
    one_less = pca.variances[: pca.dimensions - 1].sum() / pca.variances.sum()
    assert one_less < share


def test_components_refuse_nonsense():
    with pytest.raises(DataError, match=r"share of variance below 1 or 1 to 2 components, found 0"):
        fit_pca(np.ones((3, 2)), 0)
    with pytest.raises(DataError, match="components need rows"):
        fit_pca(np.ones(3), 0.9)


@given(seeds, st.integers(1, 6))
def test_kmeans_reports_its_error_and_is_a_fixed_point(seed: int, clusters: int):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(30, 2))
    quantiser = kmeans(x, clusters, rng, restarts=2)
    assert quantiser.error == pytest.approx(naive.quantisation_error(x, quantiser.centres))
    labels = quantiser.assign(x)
    assert set(labels) == set(range(clusters))
    for k in range(clusters):
        assert quantiser.centres[k] == pytest.approx(x[labels == k].mean(axis=0))


def test_kmeans_finds_blobs_and_is_repeatable():
    rng = np.random.default_rng(3)
    middles = np.array([[0, 0], [10, 0], [0, 10], [10, 10]])
    x = np.concatenate([m + rng.normal(scale=0.1, size=(20, 2)) for m in middles])
    runs = [kmeans(x, 4, np.random.default_rng(1)) for _ in range(2)]
    assert runs[0].error == runs[1].error < 5
    centres = sorted(np.round(runs[0].centres).tolist())
    assert centres == sorted(middles.tolist())


def test_kmeans_agrees_with_an_independent_library():
    cluster = pytest.importorskip("sklearn.cluster")
    x = np.random.default_rng(0).normal(size=(200, 4))
    theirs = cluster.KMeans(8, n_init=30, random_state=0).fit(x).inertia_
    assert kmeans(x, 8, np.random.default_rng(0), 30).error <= theirs * 1.01


def test_kmeans_copes_with_equal_rows_and_refuses_too_many_clusters():
    assert kmeans(np.ones((5, 2)), 3, np.random.default_rng(0)).error == 0
    with pytest.raises(DataError, match="expected 1 to 5 clusters"):
        kmeans(np.ones((5, 2)), 6, np.random.default_rng(0))


@given(seeds, st.integers(1, 5))
def test_distances_to_a_row_are_those_of_its_columns(seed: int, count: int):
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(7, 6)).astype(np.float32)
    row, columns = rng.normal(size=count).astype(np.float32), rng.choice(6, count, replace=False)
    squares = squared_distances_to(row, rows, columns)
    assert squares == pytest.approx(((rows[:, columns] - row) ** 2).sum(axis=1), rel=1e-5)
    assert squares == pytest.approx(squared_distances(rows[:, columns], row[None])[:, 0], rel=1e-3, abs=1e-4)
