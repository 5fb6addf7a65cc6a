"""The figures of docs/results/sensor.md are those of its file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "results"
PAGE, FIGURES = FOLDER / "sensor.md", FOLDER / "sensor.json"
SECTIONS = {"take": "Takes left out", "person": "People left out", "corpus": "With a corpus in the library"}


@pytest.fixture(scope="module")
def figures() -> dict[str, Any]:
    return json.loads(FIGURES.read_text())


def rows_of(section: str) -> list[str]:
    """The lines of the tables of a section."""
    text = PAGE.read_text().split(f"## {section}\n", 1)[1].split("\n## ", 1)[0]
    return [line.replace("**", "") for line in text.splitlines() if line.startswith("|")]


@pytest.mark.parametrize("table", SECTIONS)
def test_the_tables_of_held_out_takes_are_those_of_the_file(figures: dict[str, Any], table: str):
    rows = rows_of(SECTIONS[table])
    for method, of in figures[table].items():
        (row,) = [row for row in rows if row.startswith(f"| {method} |")]
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        for cell, group in zip(cells[1:4], ("golf", "karate", "basketball"), strict=True):
            assert cell.startswith(f"{of[group]:.2f} "), (method, group)
        assert cells[4].startswith(f"{of['every take']:.2f} ({of['low']:.2f} to {of['high']:.2f})"), method
        assert np.mean(list(of["takes"].values())) == pytest.approx(of["every take"], abs=1e-3)


def test_the_table_of_real_sensors_is_that_of_the_file(figures: dict[str, Any]):
    rows = rows_of("Real sensors")
    for recording, of in figures["real sensors"].items():
        if "guided" not in of:
            continue
        wanted = " | ".join(f"{of[m]:.2f}" for m in ("mean pose", "8 nearest frames, smoothed", "continuity", "guided"))
        assert any(row.startswith(f"| {recording} | {wanted} (") for row in rows), recording


def test_sweeps_are_those_of_the_file(figures: dict[str, Any]):
    rows = rows_of("Worse sensors, and fewer")
    for what, of in figures["sweeps"].items():
        order = sorted(of, key=float, reverse=what == "sensors")
        assert f"| degrees | {' | '.join(f'{of[value]:.2f}' for value in order)} |" in rows, what


def test_the_page_claims_no_more_than_its_figures(figures: dict[str, Any]):
    """Guided is below the best smoothed baseline in every table, and shakes no more than the source."""
    for table in SECTIONS:
        baseline = figures[table]["8 nearest frames, smoothed"]["every take"]
        assert figures[table]["guided"]["every take"] < baseline
    assert max(figures[table]["guided"]["jitter"] for table in ("take", "person")) < 1.0
