"""Libraries in shards: the optimum, its proof and the motion are those of one library with the same takes."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import clusters
from kinetograph.errors import LibraryError, RequestError
from kinetograph.library import Library, Selection, Shards, annotations_of, contents, labels, shards_in, skeletons
from kinetograph.methods.performance import PerformanceControl, Rule, ShardedModel, over_shards
from kinetograph.motion import Motion
from kinetograph.pipeline import fit_performance
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation, Take
from kinetograph.work import HERE, Workers
from walkers import walk

TAKES = (("straight", 0.0, 1.0), ("left", 0.6, 1.0), ("right", -0.6, 1.1), ("bent", 0.25, 0.9), ("veer", -0.2, 1.3))
OF_SHARDS = (("straight",), ("left", "right", "bent"), ("veer",))


def take(name: str, turn: float, speed: float) -> Take:
    motion = walk(6.0, turn_rate=turn, speed=speed)
    rows = np.arange(len(motion.rotations))
    wave = 1e-3 * np.sin(rows / 7 + turn * 9)[:, None]
    motion = replace(motion, translation=motion.translation + wave)
    contacts = [
        Annotation("motion", "contact", f"{side}_toe", t, t + 0.4) for side in ("left", "right") for t in (1, 2)
    ]
    cuts = [Annotation("motion", "cut", "", t, t) for t in np.arange(13) / 2]
    return Take(name, {"motion": motion}, (*cuts, *contacts))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("shards")
    takes = {name: take(name, turn, speed) for name, turn, speed in TAKES}
    one = Library.create(made / "one")
    for name in takes:
        one.add(takes[name])
    for number, names in enumerate(OF_SHARDS):
        shard = Library.create(made / "several" / f"shard{number}")
        for name in names:
            shard.add(takes[name])
    return made


@pytest.fixture(scope="module")
def shards(folder: Path) -> Shards:
    return Shards.of(shards_in(folder / "several"))


@pytest.fixture(scope="module")
def control() -> Signal:
    t = np.arange(200) / 30
    clock = np.minimum(t, 3.5)
    return Signal(np.stack([0.6 * np.sin(clock), 0 * t, clock], axis=1)[:, None], ("centre",), "m", 30.0)


def same(a: Synthesis, b: Synthesis) -> None:
    """Whether two syntheses are equal, bit by bit."""
    assert a.pieces == b.pieces
    assert (a.cost, a.costs, a.warnings) == (b.cost, b.costs, b.warnings)
    assert {**a.statistics, "pairs": 0} == {**b.statistics, "pairs": 0}
    assert np.array_equal(a.motion.translation, b.motion.translation)
    assert np.array_equal(a.motion.rotations, b.motion.rotations)


METHODS = (
    PerformanceControl(),
    PerformanceControl(reuse=0.0, mirror=True),
    PerformanceControl(reuse=0.0, span=2, stand=False),
)


@pytest.mark.parametrize("method", METHODS)
def test_shards_give_what_one_library_gives(
    folder: Path, shards: Shards, control: Signal, method: PerformanceControl
) -> None:
    model = method.fit(Library.open(folder / "one"))
    with over_shards(method, shards) as sharded:
        assert sharded.fitted.own_cost == model.fitted.own_cost
        assert sharded.fitted.speeds == model.fitted.speeds
        assert sharded.fitted.fastest == model.fitted.fastest
        assert np.array_equal(sharded.fitted.basis, model.fitted.basis)
        assert np.array_equal(sharded.fitted.instances.states, model.fitted.instances.states)
        ours, theirs = sharded.interpret(control), model.interpret(control)
        assert (ours.score, ours.proved, ours.pairs) == (theirs.score, theirs.proved, theirs.pairs)
        assert ours.states.tolist() == theirs.states.tolist()
        same(sharded.synthesize(control), model.synthesize(control))


def test_limits_of_bodies_are_those_of_one_library(folder: Path, shards: Shards) -> None:
    one = PerformanceControl().fit(Library.open(folder / "one")).fitted.limits
    with over_shards(PerformanceControl(), shards) as sharded:
        whole = sharded.fitted.limits
    assert (whole.turning, whole.elbows, whole.overlap) == (one.turning, one.elbows, one.overlap)
    assert np.array_equal(whole.clearance, one.clearance)
    for a, b in zip(whole.joints, one.joints, strict=True):
        for name in ("mean", "axes", "low", "high"):
            assert np.array_equal(getattr(a, name), getattr(b, name))


def test_rules_and_what_is_left_out_hold_over_shards(folder: Path, shards: Shards, control: Signal) -> None:
    rules = [Rule(1.0, 2.0, take="left"), Rule(2.5, 3.5, take="straight", forbid=True)]
    model = PerformanceControl().fit(Library.open(folder / "one"), exclude=("bent",))
    with over_shards(PerformanceControl(), shards, exclude=("bent",)) as sharded:
        same(sharded.synthesize(control, rules=rules), model.synthesize(control, rules=rules))


def test_processes_and_threads_give_the_same(shards: Shards, control: Signal) -> None:
    made = []
    with ThreadPoolExecutor(2) as threads:
        for workers in (HERE, Workers(2), threads):
            with over_shards(PerformanceControl(), shards, workers) as sharded:
                made.append(sharded.synthesize(control))
    same(made[0], made[1])
    same(made[0], made[2])


@pytest.mark.parametrize("count", [1, 2, 9])
def test_one_library_is_divided_among_those_who_work(
    folder: Path, control: Signal, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[ShardedModel.__module__], "hands", lambda workers: count)
    one = Library.open(folder / "one")
    with over_shards(PerformanceControl(), one) as model:
        assert len(model.sharded.several.shards) == min(count, len(TAKES))
        same(model.synthesize(control), PerformanceControl().fit(one).synthesize(control))


def test_several_libraries_are_fitted_as_one(folder: Path, shards: Shards, control: Signal) -> None:
    method = PerformanceControl(mirror=True)
    one = method.fit(Library.open(folder / "one"))
    same(fit_performance(method, shards).synthesize(control), one.synthesize(control))
    assert list((folder / "several" / "shard0" / "kept").glob("performance-*"))


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[clusters.Machines]:
    pytest.importorskip("distributed", reason="Dask is not installed: pip install 'kinetograph[cluster]'")
    with clusters.machines(tmp_path) as made:
        yield made


def test_a_cluster_one_of_whose_workers_is_killed_gives_the_same(
    shards: Shards, control: Signal, machines: clusters.Machines
) -> None:
    with over_shards(PerformanceControl(), shards) as sharded:
        expected = sharded.synthesize(control)
    killed = []

    def kill(done: int, total: int) -> None:
        if done > total // 2 and not killed:
            killed.append(done)
            machines.kill()

    with over_shards(PerformanceControl(), shards, Workers(cluster=machines.address)) as sharded:
        made = sharded.synthesize(control, progress=kill)
    assert killed
    same(made, expected)


def test_shards_read_as_one_library(folder: Path, shards: Shards) -> None:
    one = Library.open(folder / "one")
    assert shards.names() == one.names()
    assert np.array_equal(motion_of(shards, "bent").translation, motion_of(one, "bent").translation)
    assert {t.take: t.frames for t in contents(shards)} == {t.take: t.frames for t in contents(one)}
    assert labels(shards) == labels(one)
    assert sum(len(takes) for _, takes in skeletons(shards)["motion"]) == len(TAKES)
    assert annotations_of(shards, "veer") == annotations_of(one, "veer")
    chosen = shards.only(Selection(("*t",), without=("left",)))
    assert chosen.names() == ("straight", "right", "bent")


def test_names_that_clash_are_told_apart_by_their_shard(tmp_path: Path) -> None:
    for name, turn in (("monday", 0.0), ("tuesday", 0.6)):
        library = Library.create(tmp_path / name)
        library.add(take("walk", turn, 1.0))
        library.add(take(f"on_{name}", turn, 1.0))
    shards = Shards.of(shards_in(tmp_path))
    assert shards.names() == ("monday/walk", "on_monday", "tuesday/walk", "on_tuesday")
    assert shards.take("tuesday/walk").name == "tuesday/walk"
    shards.annotate("tuesday/walk", [Annotation("motion", "move", "turn", 0.0, 1.0)], kind="move")
    assert Library.open(tmp_path / "tuesday").take("walk").annotated("motion", "move")
    assert not Library.open(tmp_path / "monday").take("walk").annotated("motion", "move")
    with pytest.raises(RequestError, match="take 'walk' may be monday/walk, tuesday/walk"):
        shards.take("walk")


def test_a_shard_that_is_missing_or_strange_is_named(folder: Path, tmp_path: Path) -> None:
    there = folder / "several" / "shard0"
    with pytest.raises(LibraryError, match=r"shard 2 of 2: .*gone: not a library: no such folder"):
        Shards.of([there, tmp_path / "gone"])
    with pytest.raises(LibraryError, match="the same shard is named 2 times"):
        Shards.of([there, there])
    (tmp_path / "folder" / "empty").mkdir(parents=True)
    (tmp_path / "folder" / "whole").symlink_to(there)
    with pytest.raises(LibraryError, match="empty: no library, among 1 that are"):
        shards_in(tmp_path / "folder")


def motion_of(library: Library, name: str) -> Motion:
    return library.take(name).motion("motion")


def test_handholds_of_the_control_and_clusters_are_refused(shards: Shards) -> None:
    refused = pytest.raises(RequestError, match="segments of several shards cannot be clustered")
    with refused, over_shards(PerformanceControl(cluster=0.1), shards):
        pass
    with over_shards(PerformanceControl(), shards) as sharded:
        assert isinstance(sharded, ShardedModel)
        held = Take("held", {"motion": walk(4.0)}, (Annotation("motion", "handhold", "left_hand:right_hand", 0, 1),))
        with pytest.raises(RequestError, match="need all recordings at once"):
            sharded.read(held)
