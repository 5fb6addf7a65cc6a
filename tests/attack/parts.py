"""What a part of the attack is, how all are found, and how one is run for a while."""

from __future__ import annotations

import importlib
import pkgutil
import shutil
import time
import traceback
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

SLOW = 30.0  # seconds for one attempt; about a hundred times what any takes


@dataclass(frozen=True)
class Outcome:
    """How one attempt ended: what was done, what came of it, and what is wrong with that, if anything."""

    kind: str
    answer: str
    fault: str = ""


class Part(Protocol):
    """One kind of attack."""

    name: str

    def prepare(self, folder: Path) -> Any:
        """Make what all attempts share."""

    def attempt(self, shared: Any, rng: np.random.Generator, folder: Path) -> Outcome:
        """Attack once, in a folder that is empty and is kept where there is a fault."""


@dataclass
class Tally:
    """What a part has come to."""

    runs: int = 0
    seconds: float = 0.0
    slowest: float = 0.0
    kinds: Counter[str] = field(default_factory=Counter)
    answers: Counter[str] = field(default_factory=Counter)
    faults: list[tuple[int, str, str]] = field(default_factory=list)


def all_parts() -> dict[str, Part]:
    """The parts by name, found among this package's modules."""
    package = __package__ or "attack"
    names = [module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)])]
    modules = [importlib.import_module(f"{package}.{name}") for name in names if not name.startswith(("_", "test_"))]
    return {part.name: part for module in modules if (part := getattr(module, "PART", None)) is not None}


def run(part: Part, seed: int, folder: Path, kept: Path, stop: Iterator[int]) -> Tally:
    """Make the attempts whose numbers ``stop`` gives; inputs of faults are moved to ``kept``."""
    tally = Tally()
    shared_folder = folder / f"{part.name}-shared"
    shared_folder.mkdir()
    shared = part.prepare(shared_folder)
    for number in stop:
        work = folder / f"{part.name}-{number}"
        work.mkdir()
        rng = np.random.default_rng([seed, zlib.crc32(part.name.encode()), number])
        start = time.perf_counter()
        try:
            outcome = part.attempt(shared, rng, work)
        except Exception:
            outcome = Outcome("?", "traceback", traceback.format_exc())
        took = time.perf_counter() - start
        if took > SLOW and not outcome.fault:
            outcome = Outcome(outcome.kind, outcome.answer, f"took {took:.1f} s")
        _count(tally, number, outcome, took)
        if outcome.fault:
            _keep(work, kept / f"{part.name}-{seed}-{number}", outcome)
        shutil.rmtree(work, ignore_errors=True)
    return tally


def _count(tally: Tally, number: int, outcome: Outcome, took: float) -> None:
    tally.runs += 1
    tally.seconds += took
    tally.slowest = max(tally.slowest, took)
    tally.kinds[outcome.kind] += 1
    tally.answers[outcome.answer] += 1
    if outcome.fault:
        tally.faults.append((number, outcome.kind, outcome.fault))


def _keep(work: Path, kept: Path, outcome: Outcome) -> None:
    kept.parent.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(work, kept, symlinks=True)
    (kept / "fault.txt").write_text(f"{outcome.kind}\n{outcome.answer}\n{outcome.fault}\n")
