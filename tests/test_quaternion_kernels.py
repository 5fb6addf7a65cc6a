"""The compiled quaternion arithmetic against that of whole arrays."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kinetograph import quaternion_kernels as kernels
from kinetograph import rotations as rot

_SEEDS = st.integers(0, 2**32 - 1)


@given(_SEEDS)
def test_products_inverses_and_rotated_vectors_agree(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rot.normalize(rng.normal(size=(2, 4)))
    v = rng.normal(size=3)
    product, inverse, rotated = np.empty(4), np.empty(4), np.empty(3)
    kernels.multiply(a, b, product)
    kernels.conjugate(a, inverse)
    kernels.rotate(a, v, rotated)
    np.testing.assert_allclose(product, rot.multiply(a, b), atol=1e-15)
    np.testing.assert_array_equal(inverse, rot.conjugate(a))
    np.testing.assert_allclose(rotated, rot.rotate(a, v), atol=1e-14)
