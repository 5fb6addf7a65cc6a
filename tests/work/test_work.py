"""Work in shards: the same results for any number of workers, whatever dies on the way."""

from __future__ import annotations

import pickle
import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import clusters
from kinetograph import errors
from kinetograph.errors import FormatError, RequestError, TooSoonError, UnmetError, WorkError
from kinetograph.work import HERE, Workers, in_shards, rooms
from kinetograph.work.cluster import Cluster


@pytest.fixture(scope="module")
def machines(tmp_path_factory: pytest.TempPathFactory) -> Iterator[clusters.Machines]:
    pytest.importorskip("distributed", reason="Dask is not installed: pip install 'kinetograph[cluster]'")
    with clusters.machines(tmp_path_factory.mktemp("cluster")) as made:
        yield made


def test_results_come_in_the_order_of_the_items_whoever_works() -> None:
    expected = [n * n for n in range(20)]
    assert list(in_shards(clusters.square, range(20), HERE)) == expected
    assert list(in_shards(clusters.square, range(20), Workers(2))) == expected
    with ThreadPoolExecutor(3) as threads:
        assert list(in_shards(clusters.square, range(20), threads)) == expected
        assert threads.submit(clusters.square, 3).result() == 9  # the caller's own is left open


def test_progress_counts_what_is_done() -> None:
    seen: list[tuple[int, int]] = []
    list(in_shards(clusters.square, range(3), count=3, progress=lambda done, total: seen.append((done, total))))
    assert seen == [(1, 3), (2, 3), (3, 3)]


def test_few_items_are_taken_ahead() -> None:
    taken: list[int] = []

    def items() -> Iterator[int]:
        for number in range(1000):
            taken.append(number)
            yield number

    results = in_shards(clusters.square, items(), Workers(2))
    next(results)
    assert len(taken) <= 6
    results.close()  # type: ignore[attr-defined]


def test_a_process_that_is_killed_is_survived(tmp_path: Path) -> None:
    markers = [str(tmp_path / str(n)) for n in range(4)]
    Path(markers[2]).touch()
    assert list(in_shards(clusters.dies_once, markers, Workers(2))) == ["0", "1", "2", "3"]


def test_work_that_kills_every_process_ends_in_one_line() -> None:
    results = in_shards(clusters.dies, range(6), Workers(2))
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(WorkError, match="died 3 times over the same work"):
        next(results)


def test_errors_pass_between_processes_as_they_are() -> None:
    with pytest.raises(FormatError, match=r"^a\.bvh:7: expected 3 values, found 2$"):
        list(in_shards(clusters.damaged, ["a.bvh"], Workers(2)))


@pytest.mark.parametrize("kind", [v for v in vars(errors).values() if isinstance(v, type) and issubclass(v, Exception)])
def test_every_error_can_be_pickled(kind: type[Exception]) -> None:
    made: Exception
    if kind is FormatError:
        made = FormatError("walk.bvh", "text", line=7, column=2)
    elif kind is TooSoonError:
        made = TooSoonError("text", "key", 0.5)
    elif kind is UnmetError:
        made = UnmetError("text", "key", 0.5, (1.0, 2.0))
    else:
        made = kind("text")
    copy = pickle.loads(pickle.dumps(made))
    assert type(copy) is kind
    assert str(copy) == str(made)
    assert vars(copy) == vars(made)


def test_a_room_is_one_process_and_rooms_are_several() -> None:
    with rooms(Workers(2), [Path("a"), Path("b")]) as (first, second):
        one = {first.submit(clusters.process, n).result() for n in range(3)}
        two = {second.submit(clusters.process, n).result() for n in range(3)}
    assert len(one) == len(two) == 1
    assert one != two


def test_a_room_whose_process_dies_is_opened_again(tmp_path: Path) -> None:
    with rooms(Workers(2), [Path("a"), Path("b")]) as (first, _):
        assert first.submit(clusters.dies_once, str(tmp_path / "marker")).result() == "marker"


@pytest.mark.parametrize("address", ["127.0.0.1:8786", "tcp://localhost", "0.1", "", "tcp://a b:1"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(RequestError, match="tcp://HOST:PORT"):
        Workers(cluster=address)


def test_processes_and_a_cluster_exclude_each_other() -> None:
    with pytest.raises(RequestError, match="give one of the two"):
        Workers(2, "tcp://127.0.0.1:8786")
    with pytest.raises(RequestError, match="1 process or more"):
        Workers(0)


def test_a_cluster_that_is_not_there_is_told_within_seconds() -> None:
    pytest.importorskip("distributed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    began = time.monotonic()
    with pytest.raises(WorkError, match=f"no cluster answers at tcp://127.0.0.1:{port}"):
        list(in_shards(clusters.square, range(3), Workers(cluster=f"tcp://127.0.0.1:{port}")))
    assert time.monotonic() - began < 10


def test_a_cluster_whose_worker_is_killed_gives_the_same(machines: clusters.Machines) -> None:
    results = in_shards(clusters.slowly, range(12), Workers(cluster=machines.address))
    first = [next(results) for _ in range(3)]
    machines.add()
    machines.kill()
    assert [*first, *results] == [n * n for n in range(12)]


def test_errors_pass_through_a_cluster(machines: clusters.Machines) -> None:
    with pytest.raises(FormatError, match=r"^a\.bvh:7: expected"):
        list(in_shards(clusters.damaged, ["a.bvh"], Workers(cluster=machines.address)))


def test_rooms_of_a_cluster_are_its_workers(machines: clusters.Machines, tmp_path: Path) -> None:
    machines.wait(2)
    with rooms(Workers(cluster=machines.address), [tmp_path, tmp_path]) as (first, second):
        one = {first.submit(clusters.process, n).result() for n in range(3)}
        two = {second.submit(clusters.process, n).result() for n in range(3)}
    assert len(one) == len(two) == 1
    assert one != two


def test_a_folder_that_no_worker_sees_is_named(machines: clusters.Machines, tmp_path: Path) -> None:
    workers = Workers(cluster=machines.address)
    with (
        pytest.raises(WorkError, match=r"gone: none of the workers at tcp://.* sees it; mount it"),
        rooms(workers, [tmp_path / "gone"]),
    ):
        pass


def test_a_cluster_without_workers_ends_in_one_line(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    with clusters.machines(tmp_path, 1) as machines:
        assert list(in_shards(clusters.square, [3], Workers(cluster=machines.address))) == [9]
        cluster = Cluster(machines.address, without=1.0)
        machines.kill()
        with pytest.raises(WorkError, match="has had no workers for 1 s"):
            cluster.wait(cluster.submit(clusters.square, 4))
        machines.stop()
        with pytest.raises(WorkError, match="is gone; start it"):
            cluster.wait(cluster.submit(clusters.square, 5))
        cluster.close(stop=True)
