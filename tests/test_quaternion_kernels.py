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


@given(_SEEDS, st.booleans())
def test_poses_in_the_world_are_those_of_whole_arrays_bit_by_bit(seed: int, stretched: bool) -> None:
    rng = np.random.default_rng(seed)
    parents = np.array([-1, *(int(rng.integers(0, joint)) for joint in range(1, 7))])
    local = rot.normalize(rng.normal(size=(5, 7, 4)))
    bones = rng.normal(size=(5 if stretched else 1, 7, 3))
    places, turned = np.zeros((5, 7, 3)), np.zeros((5, 7, 4))
    places[:, 0], turned[:, 0] = rng.normal(size=(5, 3)), local[:, 0]
    expected, rotated = places.copy(), turned.copy()
    for joint in range(1, 7):
        above = parents[joint]
        expected[:, joint] = expected[:, above] + rot.rotate(rotated[:, above], bones[:, joint])
        rotated[:, joint] = rot.multiply(rotated[:, above], local[:, joint])
    kernels.forward(parents, bones, np.arange(1, 7), local, places, turned)
    np.testing.assert_array_equal(places, expected)
    np.testing.assert_array_equal(turned, rotated)
