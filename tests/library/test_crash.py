"""Writers killed at random moments: what was acknowledged is there, whole, and nothing else is."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from crash_writer import SKELETON, take_of

from kinetograph import rotations as rot
from kinetograph.library import Library, Report
from kinetograph.take import Take

WRITER = Path(__file__).with_name("crash_writer.py")
KILLS = int(os.environ.get("KINETOGRAPH_KILLS", "25"))


@dataclass(frozen=True)
class State:
    """What a library should hold: the version of each take's arrays, and the version of its note."""

    takes: dict[str, int] = field(default_factory=dict)
    notes: dict[str, int] = field(default_factory=dict)

    def after(self, word: str, name: str, version: int) -> State:
        takes, notes = dict(self.takes), dict(self.notes)
        if word in ("add", "replace"):
            takes[name] = version
        if word in ("replace", "remove"):
            notes.pop(name, None)
        if word == "remove":
            del takes[name]
        if word == "annotate":
            notes[name] = version
        return State(takes, notes)


def killed_writer(folder: Path, seed: int, delay: float) -> list[str]:
    """Run a writer for ``delay`` seconds after its first change; the lines that it finished saying."""
    with subprocess.Popen([sys.executable, str(WRITER), str(folder), str(seed)], stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        first = child.stdout.readline()
        time.sleep(delay)
        child.kill()
        rest = child.stdout.read()
    said = (first + rest).decode()
    return said[: said.rindex("\n")].split("\n")  # a kill may fall into a line


def replay(state: State, lines: list[str]) -> tuple[State, State]:
    """The state that was acknowledged, and the one if the last change, begun but not acknowledged, went through."""
    begun = state
    for line in lines:
        if line == "done":
            state = begun
        else:
            _, word, name, version = line.split()
            begun = state.after(word, name, int(version))
    return state, begun


def found_in(library: Library) -> State:
    takes, notes = {}, {}
    for name in library.names():
        take = library.take(name)
        (version,) = take.annotated("motion", "version")
        takes[name] = int(version.label)
        assert_same_bits(take, take_of(name, takes[name]))
        for note in take.annotated("hands", "note"):
            notes[name] = int(note.label)
    return State(takes, notes)


def assert_same_bits(read: Take, written: Take) -> None:
    motion, signal, skeleton = read.motion(), read.signal(), read.motion().skeleton
    rounded = rot.normalize(written.motion().rotations.astype(np.float32).astype(np.float64))
    np.testing.assert_array_equal(motion.translation, written.motion().translation)
    np.testing.assert_array_equal(motion.rotations, rounded)
    np.testing.assert_array_equal(signal.values, written.signal().values)
    np.testing.assert_array_equal(signal.valid, written.signal().valid)
    for name in ("times", "sensors", "force"):
        np.testing.assert_array_equal(getattr(read.readings(), name), getattr(written.readings(), name))
    assert skeleton.names == SKELETON.names
    np.testing.assert_array_equal(skeleton.offsets, SKELETON.offsets)


def test_killed_writers_leave_what_they_acknowledged(tmp_path: Path) -> None:
    rng = np.random.default_rng(20041)
    library = Library.create(tmp_path / "library")
    state, halfway, through, orphans = State(), 0, 0, 0
    for seed in range(KILLS):
        lines = killed_writer(library.path, seed, float(rng.uniform(0.0, 0.08)))
        acknowledged, begun = replay(state, lines)
        library = Library.open(library.path)
        state = found_in(library)
        assert state in (acknowledged, begun)
        report = library.check()
        assert not report.damaged
        halfway += lines[-1] != "done"
        through += state != acknowledged
        orphans += report.orphaned > 0
        if seed % 2:  # every other writer goes on with what the last one left
            repaired = library.check(repair=True)
            assert repaired == Report(report.orphaned, report.orphaned, (), repaired.moved)
            assert library.check() == Report(0, 0, ())
            assert found_in(library) == state
    print(f"{KILLS} kills, {halfway} in a change, {through} of them after its commit, {orphans} with orphaned bytes")
    assert halfway > KILLS // 10, "the writers were idle when killed: the test shows nothing"
    assert orphans > 0


def test_a_writer_killed_between_frames_and_catalogue(tmp_path: Path) -> None:
    script = (
        "import os, signal, sys; sys.path.insert(0, sys.argv[2])\n"
        "from crash_writer import take_of\n"
        "from kinetograph.library import Library, storage\n"
        "storage.extend = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        "Library.open(sys.argv[1]).add(take_of('lost', 1))\n"
    )
    library = Library.create(tmp_path / "library")
    library.add(take_of("kept", 1))
    done = subprocess.run([sys.executable, "-c", script, str(library.path), str(WRITER.parent)], check=False)
    assert done.returncode == -9
    assert library.names() == ("kept",)
    size = sum(a.nbytes for a in (take_of("lost", 1).motion().translation, take_of("lost", 1).signal().values))
    report = library.check()
    assert report.orphaned > size
    library.add(take_of("next", 1))  # follows the orphaned bytes
    assert library.check(repair=True).damaged == ()
    assert library.check() == Report(0, 0, ())
    assert found_in(library).takes == {"kept": 1, "next": 1}


def test_two_processes_that_add_at_once_both_succeed(tmp_path: Path) -> None:
    library = Library.create(tmp_path / "library")
    writers = [
        subprocess.Popen([sys.executable, str(WRITER), str(library.path), prefix, "15"]) for prefix in ("left", "right")
    ]
    assert [writer.wait(60) for writer in writers] == [0, 0]
    assert set(library.names()) == {f"{prefix}{i}" for prefix in ("left", "right") for i in range(15)}
    assert len(found_in(library).takes) == 30
    assert library.check() == Report(0, 0, ())
    assert library.info().skeletons == 1
