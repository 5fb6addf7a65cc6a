"""Products and sums that do not depend on what else is worked out with them."""

from __future__ import annotations

import numpy as np
import pytest

from kinetograph.learn import Affine, Alignment, Continued, Fixed, Ground, Rigid, Similarity
from kinetograph.learn.products import products, products_on_plane, weighted_sums


@pytest.mark.parametrize("kind", [float, complex])
def test_products_and_sums_are_those_of_numpy(kind: type) -> None:
    rng = np.random.default_rng(0)
    x, a, w = rng.normal(size=(7, 11)), rng.normal(size=(600, 11)), rng.uniform(size=11)
    if kind is complex:
        x, a = x + 1j * rng.normal(size=x.shape), a + 1j * rng.normal(size=a.shape)
    np.testing.assert_allclose(products(x, a), x @ a.T, atol=1e-12)
    np.testing.assert_allclose(weighted_sums(a, w), a @ w, atol=1e-12)


def test_products_on_the_plane_are_those_of_numpy() -> None:
    rng = np.random.default_rng(3)
    examples, weights = rng.normal(size=(301, 7, 3)), rng.random(7)
    windows = rng.normal(size=(4, 7)) + 1j * rng.normal(size=(4, 7))
    flat = examples[..., 2] + 1j * examples[..., 0]
    mean = flat @ weights / weights.sum()
    centred = flat - mean[:, None]
    product, spreads, means = products_on_plane(windows, examples, weights)
    np.testing.assert_allclose(product, windows @ (centred.conj() * weights).T, atol=1e-12)
    np.testing.assert_allclose(spreads, (np.abs(centred) ** 2 * weights).sum(axis=1), atol=1e-12)
    np.testing.assert_allclose(means, mean, atol=1e-13)
    some = products_on_plane(windows[1:2], examples[250:260], weights)
    assert np.array_equal(some[0], product[1:2, 250:260])


@pytest.mark.parametrize("group", [Ground(), Similarity(), Affine(), Rigid(), Fixed(), Continued()])
@pytest.mark.parametrize("part", [(0, 1), (5, 6), (3, 300), (255, 401)])
def test_an_example_is_aligned_in_the_same_way_with_whatever_others(group: Alignment, part: tuple[int, int]) -> None:
    rng = np.random.default_rng(1)
    windows, examples = (rng.normal(size=(n, 6, 2, 3)).cumsum(axis=1) for n in (9, 401))
    weights = np.full((6, 2), 0.05)
    costs, placed = group.align(windows, examples, weights)
    for few in (windows, windows[:1]):
        some, others = group.align(few, examples[slice(*part)], weights)
        assert np.array_equal(some, costs[: len(few), slice(*part)])
        rotation, shift = (vars(placed)[name][: len(few), slice(*part)] for name in ("rotation", "shift"))
        assert np.array_equal(vars(others)["rotation"], rotation)
        assert np.array_equal(vars(others)["shift"], shift)
