"""Means and variances of single precision, in sums of double precision."""

from __future__ import annotations

import numpy as np
import pytest

from kinetograph.learn import fit_gaussian, fit_pca, spread_of
from kinetograph.learn.spread import BLOCK, covariance_of


@pytest.mark.parametrize("count", [1, 7, BLOCK, BLOCK + 1, 3 * BLOCK + 5])
def test_sums_are_of_double_precision_whatever_the_rows_are(count):
    rows = (1000.0 + np.random.default_rng(0).normal(size=(count, 3))).astype(np.float32)
    exact = rows.astype(np.float64)
    found = spread_of(rows)
    np.testing.assert_allclose(found.mean, exact.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(found.variance, exact.var(axis=0), rtol=1e-9, atol=1e-12)
    mean, covariance = covariance_of(rows)
    np.testing.assert_allclose(mean, exact.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(covariance, np.atleast_2d(np.cov(exact.T, bias=True)) if count > 1 else 0, atol=1e-9)


def test_components_and_gaussians_of_single_precision_are_those_of_double():
    rng = np.random.default_rng(1)
    rows = (rng.normal(size=(500, 5)) @ rng.normal(size=(5, 5)) + 3.0).astype(np.float32)
    one, two = fit_pca(rows, 0.9), fit_pca(rows.astype(np.float64), 0.9)
    np.testing.assert_allclose(one.basis, two.basis, atol=1e-9)
    np.testing.assert_allclose(fit_gaussian(rows).covariance, fit_gaussian(rows.astype(np.float64)).covariance)
