"""Rows of a stream: the latest, and all that wait on disk."""

from __future__ import annotations

import tempfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph import rows as room
from kinetograph.errors import RequestError
from kinetograph.rows import KeptRows, LatestRows


@given(st.integers(1, 7), st.integers(1, 60), st.integers(1, 9))
def test_the_latest_rows_are_those_of_a_list(size: int, count: int, asked: int) -> None:
    rows, naive = LatestRows(size), []
    for i in range(count):
        rows.add(np.array([i, -i]))
        naive.append([i, -i])
    assert len(rows) == count
    assert rows.last(min(asked, size)).tolist() == naive[-min(asked, size) :]
    assert rows.since(rows.first).tolist() == naive[rows.first :]
    assert len(rows.since(rows.first)) <= 2 * size


def test_what_was_handed_out_stays_and_a_branch_goes_on_apart() -> None:
    rows = LatestRows(3)
    for i in range(6):
        rows.add(np.array([float(i)]))
    seen, branch = rows.last(3), rows.branch()
    for i in range(6, 20):
        branch.add(np.array([-1.0]))
        rows.add(np.array([float(i)]))
    assert seen.ravel().tolist() == [3, 4, 5]
    assert rows.last(2).ravel().tolist() == [18, 19]


def test_rows_that_wait_on_disk_come_back_as_they_were(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "IN_MEMORY", 10_000)
    given_rows = np.random.default_rng(0).normal(size=(3000, 5, 3))
    rows = KeptRows((5, 3))
    sizes = []
    for row in given_rows:
        rows.add(row)
        sizes.append(rows.nbytes)
        if len(sizes) == 1500:
            assert np.array_equal(rows.all(), given_rows[:1500])
    assert np.array_equal(rows.all(), given_rows)
    assert max(sizes) <= 10_000


def test_a_disk_without_room_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "IN_MEMORY", 100)

    def full(**_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tempfile, "TemporaryFile", full)
    rows = KeptRows((4,))
    for _ in range(3):
        rows.add(np.zeros(4))
    with pytest.raises(RequestError, match=r"No space left on device.*keep=False"):
        rows.add(np.zeros(4))
