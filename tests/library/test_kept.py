"""What is made of a library comes back from disk as it was made, or is made anew; nothing foreign is read."""

from __future__ import annotations

import dataclasses
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph.errors import LibraryError
from kinetograph.library import (
    Facts,
    Library,
    Selection,
    back_up,
    clear,
    describe_takes,
    entries,
    fingerprints,
    kept,
    kept_files,
    limit_of,
    set_limit,
)
from kinetograph.library.packing import Packed, UnpackableError, UnreadableError, pack, unpack
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark, Skeleton
from kinetograph.take import Annotation, Take


@pytest.fixture(autouse=True)
def own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("XDG_DATA_HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(variable, str(tmp_path / variable))
    monkeypatch.delenv("KINETOGRAPH_KEEP", raising=False)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library.create(tmp_path / "some")
    for name in ("one", "two"):
        made.add(Take(name, {"speed": Signal([[1.0], [2.0]], ("speed",), "m/s", 30.0)}))
    return made


class Counted:
    """Makes a value, and counts how often."""

    def __init__(self, value: Any) -> None:
        self.value, self.calls = value, 0

    def __call__(self) -> Any:
        self.calls += 1
        return self.value


def _values() -> Any:
    return MappingProxyType({"numbers": np.arange(1000.0), "names": ("a", "b"), "one": 1})


def _same(a: Any, b: Any) -> bool:
    """Whether two values are the same, down to types, orders and bits."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        alike = a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
        return alike and (a.size == 0 or a.ndim < 2 or a.flags.c_contiguous == b.flags.c_contiguous)
    if isinstance(a, frozenset):
        return bool(a == b)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(_same, a, b))
    if isinstance(a, dict | MappingProxyType):
        return list(a) == list(b) and all(_same(a[key], b[key]) for key in a)
    if dataclasses.is_dataclass(a):
        return all(_same(getattr(a, one.name), getattr(b, one.name)) for one in dataclasses.fields(a))
    return bool(repr(a) == repr(b))


def _round_trip(value: Any) -> Any:
    packed = pack(value)
    arrays = [np.concatenate([np.ravel(part) for part in parts]).astype(kind) for kind, parts in packed.arrays]
    return unpack(packed.nodes, arrays)


# ---- packing ----

_ARRAYS = hnp.arrays(
    st.sampled_from([np.dtype(kind) for kind in ("f8", "f4", "i8", "u1", "?", "c16", "U3")]),
    hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
)
_NOTES = st.builds(Annotation, st.text(max_size=3), st.just("cut"), st.text(max_size=2), st.just(0.0), st.floats(0, 9))
_PLAIN = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(),
    st.complex_numbers(),
    st.text(max_size=5),
    _ARRAYS,
    _ARRAYS.map(np.asfortranarray),
    _NOTES,
    st.floats().map(np.float64),
    st.frozensets(st.integers(0, 9), max_size=4),
)
_NESTED = st.recursive(
    _PLAIN,
    lambda inner: st.one_of(
        st.lists(inner, max_size=20),
        st.lists(inner, max_size=4).map(tuple),
        st.dictionaries(st.text(max_size=3), inner, max_size=4),
        st.dictionaries(st.integers(0, 9), inner, max_size=4).map(MappingProxyType),
        st.builds(Landmark, st.integers(0, 9), inner),
    ),
    max_leaves=25,
)


@given(_NESTED)
def test_values_come_back_as_they_were(value: Any) -> None:
    assert _same(_round_trip(value), value)


@given(st.lists(_NOTES, min_size=2, max_size=40), st.data())
def test_what_occurs_twice_comes_back_as_one_object(notes: list[Annotation], data: st.DataObject) -> None:
    order = data.draw(st.lists(st.integers(0, len(notes) - 1), min_size=1, max_size=60))
    value = (tuple(notes), [notes[i] for i in order], {"again": notes})
    back = _round_trip(value)
    assert _same(back, value)
    assert all(back[1][a] is back[1][b] for a in range(len(order)) for b in range(a) if order[a] == order[b])


def test_many_objects_take_few_arrays() -> None:
    notes = tuple(Annotation("motion", "contact", "left_toe", i / 30, i / 30 + 1) for i in range(5000))
    packed = pack(notes)
    assert len(packed.nodes) < 20
    assert packed.size < 5000 * 8 * 2 + 100


def test_a_motion_and_its_skeleton_come_back() -> None:
    skeleton = Skeleton(("hips", "head"), np.array([-1, 0]), np.eye(2, 3), roles={"head": Landmark(1)})
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (4, 2, 1))
    takes = [
        Take(str(i), {"motion": Motion(skeleton, np.zeros((4 + i, 3)), np.repeat(rotations[:1], 4 + i, 0), 30.0)})
        for i in range(3)
    ]
    back = _round_trip(takes)
    assert [len(take.motion()) for take in back] == [4, 5, 6]
    assert back[0].motion().skeleton is back[2].motion().skeleton
    assert back[0].motion().skeleton.roles["head"].joint == 1
    assert isinstance(back[0].tracks, MappingProxyType)


def test_properties_that_were_computed_come_along() -> None:
    skeleton = Skeleton(("hips", "head"), np.array([-1, 0]), np.zeros((2, 3)))
    assert "children" not in vars(_round_trip(skeleton))
    assert skeleton.children == ((1,), ())
    assert vars(_round_trip(skeleton))["children"] == ((1,), ())


@dataclass(frozen=True)
class Foreign:
    value: int = 0


@pytest.mark.parametrize(
    "value", [print, object(), Foreign(), np.array([None]), 2**70, [2**70] * 50, type, lambda: 0, b"bytes"]
)
def test_what_is_not_stored_is_said(value: Any) -> None:
    with pytest.raises(UnpackableError):
        pack((1, [value]))


def test_a_value_that_holds_itself_is_refused() -> None:
    loop: list[Any] = []
    loop.append(loop)
    with pytest.raises(UnpackableError, match="itself"):
        pack(loop)


@pytest.mark.parametrize(
    "node",
    [
        ["objects", "os:system", 1, [], []],
        ["objects", "kinetograph.library.store:Path", 1, [], []],
        ["objects", "kinetograph.cli.output:note", 1, [], []],
        ["objects", "kinetograph.nowhere:Thing", 1, [], []],
        ["objects", "kinetograph.take:Take.motion", 1, [], []],
        ["objects", "kinetograph.take:Annotation", 1, ["track"], [0]],
        ["objects", "kinetograph.take:Annotation", 1, ["__class__"], [0]],
        ["items", "print", [1], 0],
        ["items", "tuple", [5], 0],
        ["items", "tuple", [-1, 2], 0],
        ["pick", [7], 0],
        ["pick", [-1], 0],
        ["pick", [0], 9],
        ["numbers", 4],
        ["numbers", -1],
        ["arrays", 0, [1000], [], False],
        ["arrays", 0, [-1, 4], [], False],
        ["plain", [{"a": 1}]],
        ["eval", "1"],
        [],
        "none",
        ["none"],
        ["none", 2],
    ],
    ids=repr,
)
def test_columns_that_describe_no_value_are_refused(node: Any) -> None:
    with pytest.raises(UnreadableError):
        unpack([["plain", [1]], node], [np.zeros(3)])


# ---- keeping ----


def test_a_value_is_made_once(library: Library) -> None:
    make = Counted(_values())
    first, second = (kept(library, "values", ("a", 1.5), make) for _ in range(2))
    assert make.calls == 1
    assert _same(first, make.value)
    assert _same(second, make.value)
    assert second["numbers"].flags.writeable
    second["numbers"][:] = 0  # this process's copy only
    assert _same(kept(library, "values", ("a", 1.5), make), make.value)
    assert [(entry.name, entry.configuration) for entry in entries(library)] == [("values", "('a', 1.5)")]


def test_another_configuration_or_name_is_another_value(library: Library) -> None:
    for number, (name, configuration) in enumerate([("a", (1,)), ("a", (1.0,)), ("a", ("1",)), ("b", (1,))]):
        assert kept(library, name, configuration, lambda number=number: number) == number
    assert len(entries(library)) == 4


def test_another_state_of_a_generator_is_another_value(library: Library) -> None:
    rng = np.random.default_rng(0)
    make = Counted(1)
    kept(library, "a", (rng,), make)
    kept(library, "a", (np.random.default_rng(0),), make)
    assert make.calls == 1
    rng.random()
    kept(library, "a", (rng,), make)
    assert make.calls == 2


_CHANGES: dict[str, Callable[[Library], object]] = {
    "add": lambda lib: lib.add(Take("three", {"speed": Signal([[1.0]], ("speed",), "m/s", 30.0)})),
    "replace": lambda lib: lib.add(
        Take("two", {"speed": Signal([[1.5], [2.0]], ("speed",), "m/s", 30.0)}), replace=True
    ),
    "remove": lambda lib: lib.remove("one"),
    "annotate": lambda lib: lib.annotate("one", [Annotation("speed", "cut", "", 0.0, 0.0)]),
    "describe": lambda lib: describe_takes(lib, {"one": Facts(subject="Justin")}),
}


@pytest.mark.parametrize("change", _CHANGES)
def test_a_change_of_the_takes_makes_it_stale(library: Library, change: str) -> None:
    make = Counted(_values())
    kept(library, "values", (), make)
    kept(library, "others", (), make)
    old = {entry.path for entry in entries(library)}
    _CHANGES[change](library)
    kept(library, "values", (), make)
    assert make.calls == 3
    names = [entry.name for entry in entries(library)]
    assert sorted(names) == ["others", "values"]  # the stale one of the same name is gone
    assert len(old & {entry.path for entry in entries(library)}) == 1


def test_choices_of_takes_do_not_drop_each_other(library: Library) -> None:
    make = Counted(1)
    for _ in range(2):
        for one in ("one", "two"):
            kept(library.only(Selection((one,))), "values", (), make)
    assert make.calls == 2
    kept(library.only(Selection(without=("two",))), "values", (), make)
    assert make.calls == 2  # the same takes, however they are chosen


def test_another_state_of_the_code_makes_it_anew(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    make = Counted(1)
    kept(library, "values", (), make)
    monkeypatch.setattr(fingerprints, "of_code", lambda: "edited")
    kept(library, "values", (), make)
    assert make.calls == 2
    assert len(entries(library)) == 2  # another installation may use the first one
    day_ago = time.time() - 2 * 86_400
    for entry in entries(library):
        os.utime(entry.path, (day_ago, entry.path.stat().st_mtime))
    monkeypatch.setattr(fingerprints, "of_code", lambda: "edited again")
    kept(library, "values", (), make)
    assert len(entries(library)) == 1


def test_a_digest_is_the_same_in_every_process(library: Library) -> None:
    code = (
        "import numpy as np; from kinetograph.library import fingerprints, Library; "
        "from kinetograph.methods.performance import PerformanceControl as P; "
        f"print(fingerprints.state((P(), frozenset('abcdef'), np.arange(3))), fingerprints.of_code(), "
        f"fingerprints.of_takes(Library.open({str(library.path)!r})))"
    )
    runs = [
        subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=True
        ).stdout
        for seed in ("1", "2")
    ]
    assert runs[0] == runs[1]


# ---- files that do not count ----


def _path(library: Library) -> Path:
    (entry,) = entries(library)
    return entry.path


def _damages() -> Iterator[tuple[str, Callable[[Path], object]]]:
    def written(path: Path, place: int, data: bytes) -> None:
        with path.open("r+b") as file:
            file.seek(place)
            file.write(data)

    yield "emptied", lambda path: path.write_bytes(b"")
    yield "cut", lambda path: os.truncate(path, path.stat().st_size // 2)
    yield "cut by one", lambda path: os.truncate(path, path.stat().st_size - 1)
    yield "longer", lambda path: path.write_bytes(path.read_bytes() + b"x")
    yield "header", lambda path: written(path, 20, b"\xff\xff")
    yield "array", lambda path: written(path, 1000, b"\x00" * 8)
    yield "columns", lambda path: written(path, path.stat().st_size - 30, b"[[[[")
    yield "pickle", lambda path: path.write_bytes(pickle.dumps([1, 2]))


@pytest.mark.parametrize(("what", "damage"), list(_damages()))
def test_a_damaged_file_is_made_anew(library: Library, what: str, damage: Callable[[Path], object]) -> None:
    make = Counted(_values())
    kept(library, "values", (), make)
    damage(_path(library))
    assert _same(kept(library, "values", (), make), make.value)
    assert make.calls == 2
    kept(library, "values", (), make)
    assert make.calls == 2


@settings(max_examples=60)
@given(data=st.data())
def test_no_byte_can_be_changed_behind_the_time_of_change(data: st.DataObject, tmp_path_factory: Any) -> None:
    """Whoever resets the time of change needs the user's key for all but the arrays' bytes."""
    folder = tmp_path_factory.mktemp("kept")
    about, key = kept_files.About("a", "", "", "", ""), bytes(32)
    path = folder / "a.kept"
    kept_files.write(path, about, pack((1, "text", (2.5, None))), key)
    assert kept_files.read(path, key) == (1, "text", (2.5, None))
    whole, state = bytearray(path.read_bytes()), path.stat()
    whole[data.draw(st.integers(0, len(whole) - 1))] ^= data.draw(st.integers(1, 255))
    path.write_bytes(whole)
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))
    with pytest.raises(UnreadableError):
        kept_files.read(path, key)


def test_a_file_of_another_user_or_another_place_does_not_count(library: Library, tmp_path: Path) -> None:
    make = Counted(1)
    kept(library, "values", (), make)
    path = _path(library)
    state, copy = path.stat(), path.with_suffix(".copy")
    copy.write_bytes(path.read_bytes())  # another file, of the same bytes and times, as an archive unpacks it
    os.utime(copy, ns=(state.st_atime_ns, state.st_mtime_ns))
    copy.rename(path)
    kept(library, "values", (), make)
    assert make.calls == 2
    with pytest.raises(UnreadableError, match="not written here by this user"):
        kept_files.read(_path(library), b"another user's key, 32 bytes long")


def test_a_crafted_file_runs_nothing(library: Library) -> None:
    make = Counted(1)
    kept(library, "values", (), make)
    path = _path(library)
    crafted = Packed([["objects", "os:system", 1, ["command"], [0]]])
    about = kept_files.about(path)
    assert about is not None
    kept_files.write(path, about, crafted, bytes(32))  # a stranger does not know the key
    assert kept(library, "values", (), make) == 1
    key = kept_files.user_key()
    assert key is not None
    kept_files.write(path, about, crafted, key)  # and with it, classes of this package are all there is
    assert kept(library, "values", (), make) == 1
    assert make.calls == 3


# ---- when keeping fails ----


def test_what_cannot_be_kept_is_returned_with_a_note(library: Library) -> None:
    said: list[str] = []
    make = Counted((print,))
    assert kept(library, "values", (), make, note=said.append) == (print,)
    assert "is not kept: it holds a" in said[0]
    assert kept(library, "values", (print,), lambda: 3) == 3  # nor what it is made with
    assert not entries(library)


def test_a_full_disk_costs_the_keeping_only(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    said: list[str] = []
    assert _same(kept(library, "values", (), Counted(_values()), note=said.append), _values())
    assert "No space left on device" in said[0]
    assert not list((library.path / "kept").iterdir())


def test_a_library_that_changes_meanwhile_is_not_kept(library: Library) -> None:
    def make() -> int:
        library.remove("one")
        return 1

    said: list[str] = []
    assert kept(library, "values", (), make, note=said.append) == 1
    assert "changed meanwhile" in said[0]
    assert not entries(library)


def test_keeping_can_be_switched_off_or_moved(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = Counted(1)
    monkeypatch.setenv("KINETOGRAPH_KEEP", "0")
    assert [kept(library, "values", (), make) for _ in range(2)] == [1, 1]
    assert make.calls == 2
    assert not (library.path / "kept").exists()
    monkeypatch.setenv("KINETOGRAPH_KEEP", str(tmp_path / "elsewhere"))
    assert [kept(library, "values", (), make) for _ in range(2)] == [1, 1]
    assert make.calls == 3
    assert not (library.path / "kept").exists()
    assert (tmp_path / "elsewhere") in _path(library).parents


def test_a_read_only_library_is_kept_in_the_users_folder(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: library.path != Path(path) and access(path, mode))
    make = Counted(1)
    assert [kept(library, "values", (), make) for _ in range(2)] == [1, 1]
    assert make.calls == 1
    assert (tmp_path / "XDG_CACHE_HOME") in _path(library).parents


def test_without_a_folder_for_the_key_nothing_is_kept(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "file"))
    assert kept(library, "values", (), lambda: 2) == 2
    assert not entries(library)


# ---- bounds ----


def test_what_was_not_used_for_longest_goes_first(library: Library) -> None:
    for number in range(4):
        kept(library, f"v{number}", (), lambda number=number: np.full(10_000, number))
        os.utime(_path_of(library, f"v{number}"), (number, _path_of(library, f"v{number}").stat().st_mtime))
    kept(library, "v0", (), lambda: 1 / 0)  # used again
    set_limit(library, 2 * _path_of(library, "v0").stat().st_size + 100)
    assert sorted(entry.name for entry in entries(library)) == ["v0", "v3"]
    assert kept(library, "v4", (), lambda: np.full(10_000, 4))[0] == 4
    assert sorted(entry.name for entry in entries(library)) == ["v0", "v4"]
    assert limit_of(library) == limit_of(Library.open(library.path))
    said: list[str] = []
    kept(library, "large", (), lambda: np.zeros(100_000), note=said.append)
    assert "there is room for 0 MB" in said[0]


def _path_of(library: Library, name: str) -> Path:
    return next(entry.path for entry in entries(library) if entry.name == name)


def test_clearing_frees_all(library: Library) -> None:
    make = Counted(np.zeros(1000))
    kept(library, "values", (), make)
    (library.path / "kept" / ".0123.draft").write_bytes(b"left by a killed process")
    assert clear(library) > 8000
    assert not list((library.path / "kept").iterdir())
    kept(library, "values", (), make)
    assert make.calls == 2


def test_a_library_and_its_copies_do_not_mind(library: Library, tmp_path: Path) -> None:
    kept(library, "values", (), Counted(1))
    assert library.check().sound
    assert library.check(repair=True).sound
    copy = back_up(library, tmp_path / "copy")
    assert not (copy.path / "kept").exists()
    with pytest.raises(LibraryError, match="already holds a library"):
        Library.create(library.path)


# ---- several processes ----


def _keep(path: Path, number: int) -> int:
    found = kept(Library.open(path), "values", (), lambda: np.full(200_000, 7.0))
    return int(found.sum()) + 0 * number


def test_several_makers_at_once_all_succeed(library: Library) -> None:
    with multiprocessing.get_context("spawn").Pool(3) as pool:
        assert pool.starmap(_keep, [(library.path, number) for number in range(6)]) == [1_400_000] * 6
    assert len(list((library.path / "kept").iterdir())) == 1


_KILLED = """
import os, sys, time
import numpy as np
from kinetograph.library import Library, kept
fsync = os.fsync
def slow(descriptor):
    print("writing", flush=True)
    time.sleep(60)
os.fsync = slow
kept(Library.open(sys.argv[1]), "values", (), lambda: np.zeros(100_000))
"""


def test_a_killed_writer_leaves_nothing_that_counts(library: Library) -> None:
    process = subprocess.Popen([sys.executable, "-c", _KILLED, str(library.path)], stdout=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stdout.readline() == b"writing\n"
    kept(library, "others", (), lambda: 1)
    drafts = list((library.path / "kept").glob(".*"))
    assert len(drafts) == 1  # that of a writer that lives stays
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert [entry.name for entry in entries(library)] == ["others"]
    assert kept(library, "values", (), lambda: 5) == 5
    assert not list((library.path / "kept").glob(".*"))


def test_a_reader_keeps_what_is_dropped(library: Library) -> None:
    found = kept(library, "values", (), lambda: np.arange(100_000))
    clear(library)
    assert found.sum() == sum(range(100_000))


def test_settings_are_told_by_what_differs() -> None:
    note = Annotation("motion", "cut", "", 0.0, 1.0)
    assert fingerprints.summarize(note) == "Annotation(track='motion', kind='cut', label='', start=0.0, stop=1.0)"
    assert fingerprints.summarize(Facts(subject="Ann")) == "Facts(subject='Ann')"
    assert "content=''" in fingerprints.state(Facts(subject="Ann"))
    assert fingerprints.state(replace(note, label="b")) != fingerprints.state(note)
