from __future__ import annotations

import numpy as np
import pytest

from kinetograph.learn import Gate, Prior, fit_gate


def products_of(errors: np.ndarray) -> np.ndarray:
    """Inner products ``(N, K, K)`` of errors ``(N, K, D)``."""
    return np.einsum("nkd,nld->nkl", errors, errors)


def even(count: int) -> np.ndarray:
    return np.full(count, 1.0 / count)


def test_independent_errors_get_shares_by_their_inverse_variances() -> None:
    deviations = np.array([1.0, 2.0, 0.5])
    errors = np.random.default_rng(0).normal(size=(4000, 3, 5)) * deviations[:, None]
    gate, error = fit_gate(np.zeros((4000, 0)), products_of(errors), even(4000))
    wanted = deviations**-2 / (deviations**-2).sum()
    np.testing.assert_allclose(gate.shares(np.zeros((1, 0)))[0], wanted, atol=0.02)
    assert error == pytest.approx(5.0 / (deviations**-2).sum(), rel=0.05)


def test_no_shares_on_a_grid_are_better() -> None:
    rng = np.random.default_rng(1)
    errors = rng.normal(size=(60, 3, 4)) + rng.normal(size=(60, 1, 4))
    products = products_of(errors)
    _, error = fit_gate(np.zeros((60, 0)), products, even(60))
    steps = np.linspace(0.0, 1.0, 41)
    grid = [np.array([a, b, 1.0 - a - b]) for a in steps for b in steps if a + b <= 1.0]
    assert error <= min(float((products @ shares @ shares).mean()) for shares in grid) + 1e-3


def test_shares_follow_the_feature_that_says_which_is_right_and_stay_beyond_it() -> None:
    rng = np.random.default_rng(2)
    feature = rng.uniform(-1.0, 1.0, size=(2000, 1))
    errors = rng.normal(size=(2000, 2, 3))
    errors[:, 0] *= np.where(feature > 0, 0.1, 2.0)
    errors[:, 1] *= np.where(feature > 0, 2.0, 0.1)
    gate, error = fit_gate(feature, products_of(errors), even(2000))
    shares = gate.shares(np.array([[-0.8], [0.8], [1.0], [50.0]]))
    assert shares[0, 1] > 0.9
    assert shares[1, 0] > 0.9
    np.testing.assert_allclose(shares[2], shares[3], atol=1e-3)
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    assert error < 0.5 * fit_gate(np.zeros((2000, 0)), products_of(errors), even(2000))[1]


def test_little_evidence_leaves_shares_near_those_that_are_usual() -> None:
    errors = np.random.default_rng(3).normal(size=(8, 2, 3)) * np.array([1.0, 1.3])[:, None]
    usual = np.array([0.2, 0.8])
    free, drawn, tied = (
        fit_gate(np.zeros((8, 0)), products_of(errors), even(8), Prior(usual, strength))[0].shares(np.zeros((1, 0)))[0]
        for strength in (0.0, 0.1, 1e4)
    )
    np.testing.assert_allclose(tied, usual, atol=1e-3)
    assert abs(drawn[0] - usual[0]) < abs(free[0] - usual[0])


def test_one_more_estimate_changes_nothing_while_there_is_nothing_of_it() -> None:
    gate = Gate.constant(np.array([0.25, 0.75, 0.0]), 2)
    features = np.random.default_rng(4).normal(size=(5, 2))
    np.testing.assert_allclose(gate.shares(features), np.tile([0.25, 0.75, 0.0], (5, 1)), atol=1e-9)
    np.testing.assert_allclose(gate.widened().shares(features)[:, :3], gate.shares(features), atol=1e-9)
