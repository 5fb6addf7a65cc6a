"""Results on disk: a run that is stopped goes on where it was, and nothing else is taken for a result."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import clusters
from kinetograph.errors import LibraryError
from kinetograph.library import Results
from kinetograph.work import Workers, in_shards

DONE: list[int] = []


def noted(number: int) -> tuple[int, float]:
    DONE.append(number)
    if number == 3 and len(DONE) == 4:
        raise KeyboardInterrupt
    return number, number / 7


@dataclass(frozen=True)
class Item:
    name: str
    rows: tuple[int, ...]


def test_a_run_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    DONE.clear()
    store = Results(tmp_path / "results")
    with pytest.raises(KeyboardInterrupt):
        list(in_shards(noted, range(6), store=store))
    assert list(in_shards(noted, range(6), store=store)) == [(n, n / 7) for n in range(6)]
    assert DONE == [0, 1, 2, 3, 3, 4, 5]
    assert list(in_shards(noted, range(6), store=store)) == [(n, n / 7) for n in range(6)]
    assert DONE == [0, 1, 2, 3, 3, 4, 5]


def test_processes_find_what_one_has_kept(tmp_path: Path) -> None:
    store = Results(tmp_path)
    first = list(in_shards(clusters.square, range(5), store=store))
    for path in tmp_path.iterdir():
        assert path.stat().st_size > 0
    assert list(in_shards(clusters.square, range(8), Workers(2), store=store)) == [*first, 25, 36, 49]
    assert len(list(tmp_path.iterdir())) == 8


def test_keys_differ_by_function_and_item() -> None:
    store = Results(Path("anywhere"))
    items = (Item("a", (1, 2)), Item("a", (1, 3)), Item("b", (1, 2)))
    keys = {store.key(function, item) for function in (noted, clusters.square) for item in items}
    assert len(keys) == 6
    assert store.key(noted, Item("a", (1, 2))) in keys


def test_a_damaged_result_is_made_again(tmp_path: Path) -> None:
    store = Results(tmp_path)
    list(in_shards(clusters.square, range(3), store=store))
    (first, *_) = sorted(tmp_path.iterdir())
    first.write_bytes(first.read_bytes()[:-1] + b"x")
    assert list(in_shards(clusters.square, range(3), store=store)) == [0, 1, 4]


def test_what_cannot_be_kept_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(LibraryError, match="cannot be kept"):
        Results(tmp_path).key(noted, object())
    (tmp_path / "file").write_text("")
    with pytest.raises(LibraryError, match="cannot keep results here"):
        Results(tmp_path / "file").keep("key", np.arange(3))
