from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

import naive_sensor
from kinetograph.errors import DataError, RequestError
from kinetograph.learn.continuity import PathSearch, best_paths, init_paths, step_paths
from kinetograph.learn.embedding import embed, fit_lle, local_weights
from kinetograph.learn.interpolation import fit_rbf, local_widths
from kinetograph.learn.mixture import fit_mixture, join_small
from kinetograph.learn.posterior import Gaussian, classes_of, fit_gaussian, levenberg_marquardt, mixed
from kinetograph.learn.reduction import fit_pca
from kinetograph.learn.smoothing import smooth_path
from kinetograph.learn.trust import learn_strengths


def swiss_roll(count: int = 800) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    angle, across = 1.5 * np.pi * (1 + 2 * rng.uniform(size=count)), 10 * rng.uniform(size=count)
    return np.stack([angle * np.cos(angle), across, angle * np.sin(angle)], axis=1), angle


def test_pca_of_a_plane_needs_two_components_and_loses_nothing():
    rng = np.random.default_rng(0)
    data = rng.normal(size=(200, 2)) @ rng.normal(size=(2, 6)) + 3.0
    pca = fit_pca(data, 0.999)
    assert pca.dimensions == 2
    assert pca.share == pytest.approx(1.0)
    np.testing.assert_allclose(pca.decode(pca.encode(data)), data, atol=1e-9)
    np.testing.assert_allclose(pca.basis.T @ pca.basis, np.eye(2), atol=1e-12)
    with pytest.raises(DataError, match="keep a share of variance below 1 or 1 to 6 components, found 7"):
        fit_pca(data, 7)


def test_lle_unrolls_the_swiss_roll_where_pca_cannot():
    data, angle = swiss_roll()

    def agreement(coordinates):
        design = np.c_[coordinates, np.ones(len(angle))]
        fitted = design @ np.linalg.lstsq(design, angle, rcond=None)[0]
        return np.corrcoef(fitted, angle)[0, 1] ** 2

    assert agreement(embed(data, 2, 12, 1e-3)) > 0.9
    assert agreement(fit_pca(data, 2).encode(data)) < 0.5


def test_lle_embeds_new_points_by_their_neighbours_and_brings_them_back():
    data, _ = swiss_roll()
    lle = fit_lle(data, 2, (8, 12), (1e-3, 1e-2))
    assert lle.neighbours in (8, 12)
    assert lle.error < 1.0
    middle = data[:50]
    np.testing.assert_allclose(lle.decode(lle.encode(middle)), middle, atol=1.5)
    with pytest.raises(RequestError, match="by 12 neighbours needs more than 10 examples"):
        embed(data[:10], 2, 12, 1e-3)


@given(st.integers(0, 1000))
def test_reconstruction_weights_sum_to_one_and_do_not_see_shifts(seed):
    rng = np.random.default_rng(seed)
    points, near = rng.normal(size=(4, 3)), rng.normal(size=(4, 5, 3))
    weights = local_weights(points, near, 1e-3)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    np.testing.assert_allclose(local_weights(points + 7.0, near + 7.0, 1e-3), weights, atol=1e-6)


def test_the_mixture_finds_how_many_clusters_there_are():
    rng = np.random.default_rng(0)
    centres = np.array([[0, 0], [8, 0], [0, 8]])
    data = np.concatenate([rng.normal(size=(150, 2)) + c for c in centres])
    mixture = fit_mixture(data, 2, 10, rng)
    assert len(mixture) == 3
    labels = mixture.classify(data)
    assert all(np.bincount(labels[i * 150 : (i + 1) * 150]).max() > 145
               for i in range(3))  # fmt: skip
    assert mixture.weights.sum() == pytest.approx(1.0)


def test_small_clusters_go_to_the_nearest_large_one():
    labels = np.array([0] * 10 + [1] * 2 + [2] * 10)
    means = np.array([[0.0], [9.0], [10.0]])
    assert join_small(labels, means, 5).tolist() == [0] * 10 + [1] * 12
    assert join_small(labels, means, 50).tolist() == [0] * 22


def test_radial_functions_are_the_sum_of_the_equation():
    rng = np.random.default_rng(2)
    points, values = rng.normal(size=(40, 3)), rng.normal(size=(40, 2))
    rbf = fit_rbf(points, values, ridge=1e-3)
    query = rng.normal(size=3)
    expected = naive_sensor.radial(rbf.centres, rbf.widths, rbf.weights, rbf.mean, query)
    np.testing.assert_allclose(rbf(query[None])[0], expected, atol=1e-9)
    value, jacobian = rbf.with_jacobian(query)
    np.testing.assert_allclose(value, expected, atol=1e-9)
    step = 1e-6
    numeric = [(rbf((query + step * e)[None])[0] - rbf((query - step * e)[None])[0]) / (2 * step) for e in np.eye(3)]
    np.testing.assert_allclose(jacobian, np.array(numeric).T, atol=1e-5)


def test_radial_functions_interpolate_without_a_ridge_and_are_well_conditioned_with_one():
    points = np.linspace(0, 6, 25)[:, None]
    values = np.sin(points)
    exact, safe = fit_rbf(points, values, ridge=1e-9), fit_rbf(points, values, ridge=1e-2)
    np.testing.assert_allclose(exact(points), values, atol=1e-3)
    assert safe.condition <= 25 / 1e-2 + 1 < exact.condition


def test_repeated_points_do_not_make_widths_vanish():
    points = np.array([[0.0], [0.0], [0.0], [1.0], [2.0]])
    assert local_widths(points, 2, 1.0).min() > 0


def test_gaussians_fill_what_is_missing_with_the_regression_line():
    rng = np.random.default_rng(0)
    x = rng.normal(size=4000)
    data = np.stack([x, 2 * x + 1 + 0.01 * rng.normal(size=4000)], axis=1)
    model = fit_gaussian(data, 1e-6)
    filled = model.fill(np.array([3.0, np.nan]), np.array([True, False]))
    np.testing.assert_allclose(filled, [3.0, 7.0], atol=0.05)
    np.testing.assert_allclose(model.fill(np.zeros(2), np.zeros(2, dtype=bool)), model.mean)
    w = model.whitening()
    np.testing.assert_allclose(w.T @ w, np.linalg.inv(model.covariance), rtol=1e-6)


@given(st.integers(0, 1000), st.booleans())
def test_classes_are_distinguished_by_scipys_densities(seed, whole):
    rng = np.random.default_rng(seed)
    parts = [fit_gaussian(rng.normal(size=(30, 4)) @ rng.normal(size=(4, 4)), 1e-2) for _ in range(3)]
    shares = rng.dirichlet(np.ones(3))
    valid = np.ones(4, dtype=bool) if whole else np.array([True, False, True, True])
    value = rng.normal(size=4)
    expected = [
        np.log(share) + multivariate_normal(p.mean[valid], p.covariance[np.ix_(valid, valid)]).logpdf(value[valid])
        for p, share in zip(parts, shares, strict=True)
    ]
    densities = classes_of(parts, shares).log_densities(value, valid)
    np.testing.assert_allclose(densities - densities[0], np.array(expected) - expected[0], atol=1e-8)


@given(st.integers(0, 1000), st.integers(1, 9), st.integers(0, 2))
def test_a_smooth_path_is_the_least_squares_one(seed, length, given_rows):
    rng = np.random.default_rng(seed)
    means, before = rng.normal(size=(length, 3)), rng.normal(size=(given_rows, 3))
    precisions = rng.uniform(0.1, 2.0, size=(length, 3)) * (rng.uniform(size=(length, 3)) > 0.2) + 1e-3
    weights = rng.uniform(0.1, 30.0, size=3)
    expected = naive_sensor.smooth_path(means, precisions, weights, before)
    np.testing.assert_allclose(smooth_path(means, precisions, weights, before), expected, atol=1e-5)


def test_shrinkage_is_learnt_where_estimates_are_noise_and_not_where_they_are_right():
    rng = np.random.default_rng(0)
    truth, cases = rng.normal(size=(400, 4)), np.repeat(np.arange(4), 100)
    away = truth + np.array([0.0, 0.0, 3.0, 3.0]) * rng.normal(size=truth.shape)
    uncertainty = np.full(400, 0.5)
    strengths = learn_strengths(away, truth, uncertainty, np.array([0, 0, 1, 1]), cases)
    assert strengths[0] == 0.0
    assert strengths[1] >= 1.5
    # one case whose estimates are wild, against three that are right
    wild = np.where((cases == 0)[:, None], truth + 5 * rng.normal(size=truth.shape), truth + 0.01)
    assert learn_strengths(wild, truth, uncertainty, np.zeros(4, dtype=int), cases).tolist() == [0.0]


def test_mixing_gaussians_adds_the_spread_of_their_means():
    one = Gaussian(np.array([-1.0]), np.array([[0.5]]))
    other = Gaussian(np.array([1.0]), np.array([[0.5]]))
    both = mixed([one, other], np.array([0.5, 0.5]))
    assert both.mean.tolist() == [0.0]
    assert both.covariance.tolist() == [[1.5]]


def test_levenberg_marquardt_finds_the_bottom_of_rosenbrocks_valley():
    def residuals(x):
        r = np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])
        return r, np.array([[-20 * x[0], 10.0], [-1.0, 0.0]])

    solution = levenberg_marquardt(residuals, np.array([-1.2, 1.0]), most=200, tolerance=1e-12)
    np.testing.assert_allclose(solution.value, [1.0, 1.0], atol=1e-4)


@given(st.integers(0, 500), st.floats(0.5, 0.99), st.floats(0.0, 0.5), st.floats(0.1, 3.0))
def test_path_costs_are_those_of_the_naive_recursion(seed, decay, warp, jump):
    rng = np.random.default_rng(seed)
    examples, queries = rng.normal(size=(30, 2)), rng.normal(size=(12, 2))
    first = np.zeros(30, dtype=bool)
    first[[0, 11, 12]] = True
    search = PathSearch(examples.T.astype(np.float32), first, decay, warp, jump)
    state = init_paths(search)
    for query in queries:
        state = step_paths(search, state, query, np.full(2, 0.5))
    expected = naive_sensor.path_costs(examples, queries, first, decay, warp, jump)
    np.testing.assert_allclose(state.costs, expected, atol=2e-4)


def test_a_replayed_stretch_is_found_and_traced_back():
    rng = np.random.default_rng(0)
    examples = np.cumsum(rng.normal(size=(200, 3)), axis=0) * 0.3
    first = np.zeros(200, dtype=bool)
    first[[0, 100]] = True
    search = PathSearch(examples.T.astype(np.float32), first, 0.9, 0.1, 2.0, lag=4)
    state = init_paths(search)
    for i in range(120, 160):
        state = step_paths(search, state, examples[i] + rng.normal(scale=0.05, size=3), np.full(3, 1 / 3))
    passed, shares = best_paths(search, state, 5, 0.2)
    assert passed[np.argmax(shares)] == 159 - 4
    assert shares.sum() == pytest.approx(1.0)


def test_channels_without_weight_are_not_looked_at():
    examples = np.random.default_rng(0).normal(size=(40, 2))
    search = PathSearch(examples.T.astype(np.float32), np.ones(40, dtype=bool), 0.9, 0.1, 2.0)
    one, other = (
        step_paths(search, init_paths(search), np.array([0.3, bad]), np.array([1.0, 0.0])).costs for bad in (0.0, 1e6)
    )
    np.testing.assert_array_equal(one, other)
