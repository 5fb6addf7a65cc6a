"""Damaged catalogues and frames: no take is read wrong in silence, and nothing that is there is lost.

The library is damaged, used, checked and repaired. A take that is read must be what it was, or an error; a check must
not call the library sound where a take is missing or of another state. Then a good catalogue is put back: every take
whose bytes had survived the damage must be read again.
"""

from __future__ import annotations

import shutil
from contextlib import suppress
from pathlib import Path

import numpy as np
from tests.attack import harm, libraries
from tests.attack.libraries import Libraries
from tests.attack.parts import Outcome

from kinetograph.errors import KinetographError
from kinetograph.library import Library, annotations_of, contents, labels, skeletons
from kinetograph.library.catalogue import FILE_NAME
from kinetograph.take import Take


def reads(path: Path, shared: Libraries) -> tuple[dict[str, Take], set[str]]:
    """Every take that can be read, of those there were and are; and the first words of errors, each of one line."""
    errors: set[str] = set()
    found: dict[str, Take] = {}
    names = {name for takes in shared.takes for name in takes}
    with suppress(KinetographError):
        library = Library.open(path)
        with suppress(KinetographError):
            names |= set(library.names())
        for name in sorted(names):
            try:
                found[name] = library.take(name)
            except KinetographError as error:
                errors.add(" ".join(str(error).replace(str(path), "").split()[:4]))
    return found, errors


def counts(path: Path, shared: Libraries) -> None:
    """All else that is asked of a library; errors are ours or faults."""
    with suppress(KinetographError):
        library = Library.open(path)
        for count in (library.info, lambda: contents(library), lambda: labels(library), lambda: skeletons(library)):
            with suppress(KinetographError):
                count()
        for name in shared.truth:
            with suppress(KinetographError):
                annotations_of(library, name)


def wrong(found: dict[str, Take], shared: Libraries) -> str:
    """What is wrong with takes that were read; empty where each is what it has been at some time."""
    for name, take in found.items():
        if not any(libraries.same(take, version) for version in shared.versions(name)):
            return f"take {name!r} was read, and is not what was written"
    return ""


def right(found: dict[str, Take], shared: Libraries) -> set[str]:
    """The takes that are as they are now."""
    return {name for name, take in shared.truth.items() if name in found and libraries.same(found[name], take)}


def checked(path: Path, shared: Libraries, repair: bool) -> str:
    """What is wrong with what a check says; empty where it is called sound rightly, or not."""
    try:
        report = Library.open(path).check(repair=repair)
    except KinetographError:
        return ""
    if not report.sound:
        return ""
    found, _ = reads(path, shared)
    if set(found) == set(shared.truth) == right(found, shared):
        return ""
    return "" if repair else "called sound, and takes are missing or older"


def put_back(damaged: Path, shared: Libraries) -> set[str]:
    """The takes that are read once a good catalogue is in the place of what there is, and was used for a repair."""
    for stale in damaged.glob(f"{FILE_NAME}*"):
        shutil.rmtree(stale) if stale.is_dir() else stale.unlink()
    shutil.copy(shared.now / FILE_NAME, damaged / FILE_NAME)
    with suppress(KinetographError):
        Library.open(damaged).check(repair=True)
    found, _ = reads(damaged, shared)
    return right(found, shared)


class Damage:
    """The part."""

    name = "damage"

    def prepare(self, folder: Path) -> Libraries:
        return libraries.make(folder)

    def attempt(self, shared: Libraries, rng: np.random.Generator, folder: Path) -> Outcome:
        work, spare = folder / "library", folder / "spare"
        shutil.copytree(shared.now, work)
        kinds = harm.harm(work, shared, rng)
        kind = " + ".join(kinds)
        if {"catalogue: of_another_library", "frames: of_another_library"} <= set(kinds):
            return Outcome("several", "another library")
        if {"catalogue: of_another_time", "frames: of_another_time"} <= set(kinds):
            return Outcome("several", "an older copy")
        shutil.copytree(work, folder / "damaged")
        recoverable = set(shared.truth)
        if any(kind.startswith("frames") for kind in kinds):
            shutil.copytree(work, spare)
            recoverable = put_back(spare, shared)
        counts(work, shared)
        found, errors = reads(work, shared)
        fault = wrong(found, shared) or checked(work, shared, repair=False)
        fault = fault or _used(work, shared, rng) or checked(work, shared, repair=True)
        again, _ = reads(work, shared)
        fault = fault or wrong({n: t for n, t in again.items() if not n.startswith("new")}, shared)
        if not fault and (gone := set(found) - set(again)):
            fault = f"{', '.join(sorted(gone))}: read before the repair, and not after it"
        if not fault and (lost := recoverable - put_back(work, shared)):
            fault = f"{', '.join(sorted(lost))}: lost, though the bytes were there"
        refused = len(shared.truth) - len(right(found, shared))
        answer = "refused" if not found else "all read" if not refused else "some read"
        return Outcome(
            kinds[0] if len(kinds) == 1 else "several", answer, fault and f"{kind}: {fault} {sorted(errors)}"
        )


def _used(work: Path, shared: Libraries, rng: np.random.Generator) -> str:
    """Sometimes the library is added to before it is repaired; what was added must be read."""
    if rng.random() < 0.7:
        return ""
    take = libraries.take_of("new", int(rng.integers(1000, 2000)))
    try:
        library = Library.open(work)
        library.add(take)
    except KinetographError:
        return ""
    try:
        read = library.take("new")
    except KinetographError as error:
        return f"added and not read: {error}"
    return "" if read.annotations == take.annotations else "added and read wrong"


PART = Damage()
