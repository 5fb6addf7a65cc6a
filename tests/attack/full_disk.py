"""Operations on a library without room for them: they end in one line, and the library is as before."""

from __future__ import annotations

import os
import resource
import shutil
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from tests.attack import libraries
from tests.attack.libraries import Libraries
from tests.attack.parts import Outcome

from kinetograph.errors import KinetographError
from kinetograph.library import Library, back_up
from kinetograph.take import Annotation

_DONE, _REFUSED, _TRACEBACK = 0, 3, 4


def operation(word: str, library: Library, folder: Path, seed: int) -> Callable[[], object]:
    """A change as a function without arguments."""
    if word in ("add", "replace"):
        name = "take1" if word == "replace" else "more"
        return partial(library.add, libraries.take_of(name, seed), replace=word == "replace")
    if word == "annotate":
        notes = [Annotation("motion", "move", "x" * 400, 0.0, 0.1)] * (seed % 200)
        return partial(library.annotate, "take1", notes)
    if word == "remove":
        return partial(library.remove, "take1")
    return partial(back_up, library, folder / "copy") if word == "backup" else partial(library.check, repair=True)


def within(room: int, work: Callable[[], object]) -> int:
    """Do it in a child whose files may not be longer than ``room``; the child's exit status."""
    child = os.fork()
    if child == 0:
        code = _TRACEBACK
        try:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
            work()
            code = _DONE
        except KinetographError as error:
            code = _TRACEBACK if "\n" in str(error) else _REFUSED
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


class FullDisk:
    """The part."""

    name = "full_disk"

    def prepare(self, folder: Path) -> Libraries:
        return libraries.make(folder)

    def attempt(self, shared: Libraries, rng: np.random.Generator, folder: Path) -> Outcome:
        shutil.copytree(shared.now, folder / "library")
        library = Library.open(folder / "library")
        word = str(rng.choice(["add", "replace", "annotate", "remove", "repair", "backup"]))
        largest = max(path.stat().st_size for path in library.path.iterdir())
        room = int(rng.integers(0, int(largest * 1.5)))
        code = within(room, operation(word, library, folder, int(rng.integers(1000, 9000))))
        answer = {_DONE: "done", _REFUSED: "refused"}.get(code, f"exit {code}")
        return Outcome(word, answer, _fault(library, shared, word, code))


def _fault(library: Library, shared: Libraries, word: str, code: int) -> str:
    if code not in (_DONE, _REFUSED):
        return f"ended with {code}"
    if faults := library.check().damaged:
        return faults[0]
    for name, take in shared.truth.items():
        if code == _DONE and name == "take1" and word in ("replace", "annotate", "remove"):
            continue
        if not libraries.same(library.take(name), take):
            return f"take {name!r} is another one"
    if code == _REFUSED and set(library.names()) != set(shared.truth):
        return f"refused, and there are the takes {library.names()}"
    return "" if library.check(repair=True).sound else "not sound after a repair"


PART = FullDisk()
