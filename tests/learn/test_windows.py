"""Windows of sequences that are like another one, against the sum of squares itself."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from kinetograph.learn import Windows


@pytest.mark.parametrize(("lengths", "width"), [((7, 1, 12, 3), 3), ((5, 5), 1), ((4,), 6), ((2, 30), 30)])
def test_distances_are_those_of_every_window(lengths: tuple[int, ...], width: int) -> None:
    rng = np.random.default_rng(5)
    rows = rng.normal(size=(sum(lengths), 4)).astype(np.float32)
    query = rng.normal(size=(width, 4)).astype(np.float32)
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    expected = np.full(len(rows), np.inf)
    for start, stop in itertools.pairwise(offsets):
        for row in range(start, stop - width + 1):
            expected[row] = ((rows[row : row + width] - query) ** 2).sum() / width
    np.testing.assert_allclose(Windows(rows, offsets).distances(query), expected, atol=1e-5)


def test_some_columns_alone_are_compared() -> None:
    rows = np.array([[0, 9], [1, 9]], dtype=np.float32)
    some = Windows(rows, np.array([0, 2])).columns(np.array([0]))
    assert some.distances(np.array([[1]], dtype=np.float32)).tolist() == [1.0, 0.0]
