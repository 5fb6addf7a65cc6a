"""Each of some forty kinds of motion there and back in each format: positions, names, rate, tracks, animation."""

from __future__ import annotations

from pathlib import Path

import mutations
import pytest
import round_trips

SUFFIXES = (".bvh", ".glb", ".fbx", ".usdc")
OWED = {(suffix, case): "ends have no place yet" for suffix in SUFFIXES[1:] for case in ("ends", "several ends")}
"""What a format does not give back yet, and why."""


def trips() -> list[object]:
    return [
        pytest.param(
            case,
            suffix,
            id=f"{case}{suffix}",
            marks=[pytest.mark.xfail(reason=OWED[suffix, case], strict=True)] if (suffix, case) in OWED else [],
        )
        for suffix in SUFFIXES
        for case, make in round_trips.CASES.items()
        if suffix in make().only
    ]


@pytest.fixture(scope="module")
def formats(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """The formats that can be read and written here."""
    return set(SUFFIXES) if mutations.usd_files(tmp_path_factory.mktemp("usd")) else {*SUFFIXES} - {".usdc"}


@pytest.mark.parametrize(("case", "suffix"), trips())
def test_a_motion_comes_back(tmp_path: Path, formats: set[str], case: str, suffix: str) -> None:
    if suffix not in formats:
        pytest.skip(f"{suffix} cannot be read here")
    outcome = round_trips.outcome(round_trips.CASES[case](), tmp_path / f"take{suffix}")
    assert {what: lost for what, lost in outcome.lost.items() if what != "animation"} == {}


@pytest.mark.parametrize("suffix", SUFFIXES[1:])
def test_the_animation_keeps_its_name(tmp_path: Path, formats: set[str], suffix: str) -> None:
    if suffix not in formats:
        pytest.skip(f"{suffix} cannot be read here")
    outcome = round_trips.outcome(round_trips.CASES["plain"](), tmp_path / f"take{suffix}")
    assert outcome.animation == []


def test_a_comparison_sees_what_is_lost(tmp_path: Path) -> None:
    case = round_trips.CASES["ends"]()
    motion = case.take.motion()
    changed = round_trips.one(round_trips.scaled(round_trips.named(motion, str.lower), 1.001))
    assert set(round_trips.compared(case, round_trips.loaded_of(changed), ".glb").lost) == {
        "positions",
        "names",
        "animation",
    }
    slower = round_trips.one(round_trips.base(fps=29.0))
    assert "rate" in round_trips.compared(case, round_trips.loaded_of(slower), ".bvh").lost
    both = round_trips.CASES["two tracks"]()
    assert "tracks" in round_trips.compared(both, round_trips.loaded_of(case), ".bvh").lost
