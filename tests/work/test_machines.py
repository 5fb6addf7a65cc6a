"""Reading in, cutting, naming and evaluating on a cluster: what it gives is what one process gives, whatever dies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import clusters
from kinetograph.errors import WorkError
from kinetograph.evaluation import Run, leave_one_take_out
from kinetograph.formats import save
from kinetograph.library import Library
from kinetograph.library.fingerprints import of_takes
from kinetograph.methods.performance import PerformanceControl
from kinetograph.pipeline import (
    CutSettings,
    Done,
    IngestSettings,
    find_recordings,
    ingest,
    label_partners,
    segment_library,
)
from kinetograph.take import Annotation, Take
from kinetograph.work import Workers
from walkers import walk


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[clusters.Machines]:
    pytest.importorskip("distributed", reason="Dask is not installed: pip install 'kinetograph[cluster]'")
    (tmp_path / "machines").mkdir()
    with clusters.machines(tmp_path / "machines") as made:
        yield made


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    for number in range(16):
        motion = walk(2.0, turn_rate=0.1 * number - 0.8)
        path = tmp_path / "recordings" / f"{number // 4}" / f"walk_{number}.bvh"
        path.parent.mkdir(parents=True, exist_ok=True)
        save(motion, path)
    return tmp_path / "recordings"


def test_reading_and_cutting_by_a_cluster_one_of_whose_workers_is_killed(
    recordings: Path, machines: clusters.Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Paths are given as people give them, from a folder in which the workers are not."""
    monkeypatch.chdir(recordings.parent)
    workers, killed = Workers(cluster=machines.address), list[int]()

    def kill(done: Done) -> None:
        if done.files >= 6 and not killed:
            killed.append(done.files)
            machines.kill()

    libraries = Library.create("here"), Library.create("there")
    one = ingest(libraries[0], find_recordings(["recordings"]).recordings)
    settings = IngestSettings(workers=workers)
    two = ingest(libraries[1], find_recordings(["recordings"]).recordings, settings=settings, progress=kill)
    assert killed
    assert (len(two.added), two.skipped) == (16, {})
    assert one.added == two.added
    cuts = [
        segment_library(each, "fixed", CutSettings(0.5), workers=w)
        for each, w in zip(libraries, (Workers(), workers), strict=True)
    ]
    assert cuts[0] == cuts[1]
    assert of_takes(libraries[0]) == of_takes(libraries[1])


def test_an_evaluation_by_a_cluster_one_of_whose_workers_is_killed(tmp_path: Path, machines: clusters.Machines) -> None:
    library = Library.create(tmp_path / "walks")
    for number in range(6):
        cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(9) / 2)
        library.add(Take(f"walk_{number}", {"motion": walk(4.0, turn_rate=0.2 * number - 0.5)}, cuts))
    method, killed = PerformanceControl(), list[int]()

    def kill(done: int, total: int) -> None:
        if done >= 2 and not killed:
            killed.append(done)
            machines.kill()

    here = leave_one_take_out(method, library)
    there = leave_one_take_out(method, library, run=Run(workers=Workers(cluster=machines.address), progress=kill))
    assert killed
    assert [repr(replace(row, times_real_time=0.0)) for row in here] == [
        repr(replace(row, times_real_time=0.0)) for row in there
    ]


def test_partners_are_named_alike_by_a_cluster(tmp_path: Path, machines: clusters.Machines) -> None:
    named = []
    for name, workers in (("here", Workers()), ("there", Workers(cluster=machines.address))):
        library = Library.create(tmp_path / name)
        for number in range(3):
            cuts = tuple(Annotation("follower", "cut", "", t, t) for t in np.arange(9) / 2)
            leader, follower = walk(4.0, turn_rate=0.3 * number), walk(4.0, turn_rate=-0.3 * number)
            library.add(Take(f"dance_{number}", {"leader": leader, "follower": follower}, cuts))
        named.append((label_partners(library, workers=workers), of_takes(library)))
    assert named[0] == named[1]


@pytest.mark.skipif(not Path("/proc/self/cwd").exists(), reason="needs a path that differs from process to process")
def test_a_worker_that_does_not_see_a_folder_is_named(
    recordings: Path, machines: clusters.Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``/proc/self/cwd`` is another folder for every process, as a disk may be that only one machine has."""
    monkeypatch.chdir(recordings.parent)
    seen, workers = Path("/proc/self/cwd"), Workers(cluster=machines.address)
    refused = r"{}: the worker tcp://127\.0\.0\.1:\d+ on \S+ does not see it; mount it there under this path"
    library = Library.create(seen / "walks")
    ingest(library, find_recordings([recordings]).recordings)
    with pytest.raises(WorkError, match=refused.format("/proc/self/cwd/walks")) as told:
        segment_library(library, "fixed", workers=workers)
    assert "\n" not in str(told.value)
    with pytest.raises(WorkError, match=refused.format("/proc/self/cwd/walks")):
        leave_one_take_out(PerformanceControl(), library, run=Run(workers=workers))
    found = [replace(each, folder=seen / "recordings") for each in find_recordings([recordings]).recordings]
    with pytest.raises(WorkError, match=refused.format("/proc/self/cwd/recordings")):
        ingest(Library.create(seen / "more"), found, settings=IngestSettings(workers=workers))
