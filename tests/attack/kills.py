"""Writers killed at random moments: what was acknowledged is there, whole, and nothing else is."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tests.attack import neighbours
from tests.attack.parts import Outcome

from kinetograph.library import Library


@dataclass
class Shared:
    """The library that all attempts go on with, and what it should hold."""

    library: Library
    state: object


class Kills:
    """The part."""

    name = "kills"

    def prepare(self, folder: Path) -> Shared:
        return Shared(Library.create(folder / "library"), neighbours.crash().State())

    def attempt(self, shared: Shared, rng: np.random.Generator, folder: Path) -> Outcome:
        crash, library = neighbours.crash(), shared.library
        lines = crash.killed_writer(library.path, int(rng.integers(1 << 30)), float(rng.uniform(0.0, 0.1)))
        acknowledged, begun = crash.replay(shared.state, lines)
        word = lines[-1].split()[0] if lines[-1] == "done" else lines[-1].split()[1]
        shutil.copytree(library.path, folder / "left")
        try:
            found = crash.found_in(library)
            report = library.check(repair=bool(rng.random() < 0.5))
        except Exception as error:
            shared.library = Library.create(folder.parent / f"{folder.name}-anew")
            shared.state = crash.State()
            return Outcome(word, "damaged", repr(error))
        shared.state = found
        shutil.rmtree(library.path / "lost", ignore_errors=True)
        if report.damaged:
            return Outcome(word, "damaged", report.damaged[0])
        if found not in (acknowledged, begun):
            return Outcome(word, "another state", f"expected {acknowledged} or {begun}, found {found}")
        return Outcome(word, "as acknowledged" if found == acknowledged else "committed before the kill")


PART = Kills()
