from __future__ import annotations

import numpy as np
import pytest

from kinetograph.learn import fit_kernel_ridge, gram_of, inverse_of, kernel_width, left_out


def rows(seed: int, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    centres = rng.normal(size=(count, 3))
    return centres, np.stack([np.sin(centres[:, 0]), centres[:, 1] * centres[:, 2]], axis=1)


def estimated(centres: np.ndarray, targets: np.ndarray, queries: np.ndarray, ridge: float, width: float) -> np.ndarray:
    made = fit_kernel_ridge(centres, targets, ridge, width)
    return made.from_kernel(made.kernel(queries.astype(np.float32)))


@pytest.mark.parametrize("ridge", [1e-2, 1.0])
def test_residuals_of_groups_left_out_are_those_of_regressions_without_them(ridge: float) -> None:
    centres, targets = rows(0)
    away, width = targets - 0.3, 2.0  # any mean that does not depend on the group
    groups = [np.arange(0, 13), np.arange(13, 20), np.arange(20, 40)]
    inverse = inverse_of(gram_of(centres, width), ridge)
    residuals = left_out(inverse, inverse @ away, groups)
    for group in groups:
        rest = np.setdiff1d(np.arange(40), group)
        gram = gram_of(centres, width)
        weights = np.linalg.solve(gram[np.ix_(rest, rest)] + ridge * np.eye(len(rest)), away[rest])
        np.testing.assert_allclose(residuals[group], away[group] - gram[np.ix_(group, rest)] @ weights, atol=1e-9)


def test_rows_of_no_group_have_no_residual() -> None:
    centres, targets = rows(1)
    inverse = inverse_of(gram_of(centres, 2.0), 0.1)
    residuals = left_out(inverse, inverse @ targets, [np.arange(10)])
    assert np.isfinite(residuals[:10]).all()
    assert np.isnan(residuals[10:]).all()


def test_the_kernel_is_the_exponential_of_the_distance() -> None:
    centres, targets = rows(2)
    made = fit_kernel_ridge(centres, targets, 0.1, 1.7)
    query = np.array([[0.3, -0.2, 0.9]])
    wanted = np.exp(-np.linalg.norm(query - centres, axis=1) / 1.7)
    np.testing.assert_allclose(made.kernel(query.astype(np.float32))[0], wanted, atol=1e-5)


def test_with_hardly_a_ridge_centres_have_their_own_values_and_far_away_all_have_the_mean() -> None:
    centres, targets = rows(3)
    width = kernel_width(centres)
    np.testing.assert_allclose(estimated(centres, targets, centres, 1e-6, width), targets, atol=1e-3)
    far = estimated(centres, targets, np.full((1, 3), 1e4), 1e-6, width)
    np.testing.assert_allclose(far[0], targets.mean(axis=0), atol=1e-6)


def test_equal_centres_have_a_width_too() -> None:
    assert kernel_width(np.zeros((5, 2))) > 0
