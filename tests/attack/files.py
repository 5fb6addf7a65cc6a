"""Mutated files of every format that is read: a take or one line of an error, soon."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tests.attack import neighbours
from tests.attack.parts import Outcome

from kinetograph.errors import KinetographError
from kinetograph.formats import read


@dataclass(frozen=True)
class Shared:
    """Good files by name, in a folder that has what they refer to."""

    folder: Path
    good: dict[str, bytes]


def good_files(folder: Path) -> dict[str, bytes]:
    """What every function named ``..._files`` of the formats' mutations gives, long files apart."""
    mutations = neighbours.mutations()
    makers: list[Callable[[Path], dict[str, bytes]]] = [
        value
        for name, value in sorted(vars(mutations).items())
        if name.endswith("_files") and not name.startswith(("_", "long")) and callable(value)
    ]
    return {name: data for make in makers for name, data in make(folder).items()}


class Files:
    """The part."""

    name = "files"

    def prepare(self, folder: Path) -> Shared:
        return Shared(folder, good_files(folder))

    def attempt(self, shared: Shared, rng: np.random.Generator, folder: Path) -> Outcome:
        mutations = neighbours.mutations()
        name = sorted(shared.good)[int(rng.integers(0, len(shared.good)))]
        good = shared.good[name]
        inside = good[:2] == b"PK" and rng.random() < 0.7
        data = mutations.mutate_archive(good, rng) if inside else mutations.mutate(good, rng)
        for file in shared.folder.glob("*.asf"):
            (folder / file.name).write_bytes(file.read_bytes())
        (folder / name).write_bytes(data)
        try:
            read(folder / name)
        except KinetographError as error:
            return Outcome(Path(name).suffix, "refused", "an error of several lines" if "\n" in str(error) else "")
        return Outcome(Path(name).suffix, "read")


PART = Files()
