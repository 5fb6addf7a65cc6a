"""A small share of the attack, and that what it looks for is found where it is."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from tests.attack import __main__ as script
from tests.attack import harm
from tests.attack.parts import Outcome, all_parts, run

from kinetograph.library import takes

COUNTS = {"damage": 40, "kills": 2, "full_disk": 12, "files": 150, "rows": 4}


@pytest.mark.parametrize("name", sorted(all_parts()))
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_part_finds_nothing(name: str, tmp_path: Path) -> None:
    tally = run(all_parts()[name], 7, tmp_path, tmp_path / "kept", iter(range(COUNTS.get(name, 20))))
    assert tally.faults == []
    assert tally.runs == COUNTS.get(name, 20)
    assert sum(tally.kinds.values()) == sum(tally.answers.values()) == tally.runs


def test_damage_that_is_read_in_silence_is_found_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def trust(db: takes.sqlite3.Connection, take: int, name: str | None = None) -> object:
        return takes.digests.track_rows(db, take), takes.digests.note_rows(db, take)

    monkeypatch.setattr(takes, "require_sealed", trust)
    monkeypatch.setattr(harm, "KINDS", {"catalogue: edit": harm.edit})
    part, kept = all_parts()["damage"], tmp_path / "kept"
    tally = run(part, 1, tmp_path, kept, iter(range(60)))
    wrong = [number for number, _, fault in tally.faults if "is not what was written" in fault]
    assert wrong
    assert (kept / f"damage-1-{wrong[0]}" / "damaged").is_dir()
    (tmp_path / "again").mkdir()
    again = run(part, 1, tmp_path / "again", kept, iter([wrong[0]]))
    assert [fault for _, _, fault in again.faults] == [fault for n, _, fault in tally.faults if n == wrong[0]]


class Broken:
    name = "broken"

    def prepare(self, folder: Path) -> None:
        return None

    def attempt(self, shared: None, rng: np.random.Generator, folder: Path) -> Outcome:
        raise KeyError("a bug")


def test_a_traceback_is_a_fault_and_the_next_attempt_is_made(tmp_path: Path) -> None:
    tally = run(Broken(), 1, tmp_path, tmp_path / "kept", iter(range(3)))
    assert [number for number, _, _ in tally.faults] == [0, 1, 2]
    assert "KeyError: 'a bug'" in (tmp_path / "kept" / "broken-1-2" / "fault.txt").read_text()


def test_attempts_end_with_the_time_or_their_number() -> None:
    assert list(script.until(-np.inf, None)) == []
    assert list(script.until(np.inf, 3)) == [0, 1, 2]
    assert list(itertools.islice(script.until(np.inf, None), 2)) == [0, 1]
