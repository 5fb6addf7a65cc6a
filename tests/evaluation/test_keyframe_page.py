"""The figures of docs/results/keyframe.md are those of its file, and the quick ones are made again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from kinetograph.evaluation.reproduce import molina_tanco2000

FOLDER = Path(__file__).parents[2] / "docs" / "results"
PAGE, FIGURES = FOLDER / "keyframe.md", FOLDER / "keyframe.json"


@pytest.fixture(scope="module")
def figures() -> dict[str, Any]:
    return json.loads(FIGURES.read_text())


def _rows(text: str) -> list[str]:
    return [" ".join(line.split()) for line in text.splitlines() if line.startswith("|")]


def test_the_page_has_the_figures_of_its_file(figures: dict[str, Any]):
    rows = _rows(PAGE.read_text())
    sample, real = (figures[f"reproduction, {name}"]["section 4"] for name in ("sample", "recordings"))
    both = (real, sample)
    assert f"| frames of the result | 71 | {real['frames']} | {sample['frames']} |" in rows
    assert f"| clusters passed | 10 | {real['clusters_passed']} | {sample['clusters_passed']} |" in rows
    assert f"| examples used | 2 | {' | '.join(str(len(n['examples_used'])) for n in both)} |" in rows
    assert f"| worst seam's jump | | {' | '.join(format(n['seam_jump'], '.2f') for n in both)} |" in rows
    seeds = " | ".join(f"{20 * n['seeds_solved']:.0f} of 20" for n in both)
    assert f"| seeds of K-means with a path | | {seeds} |" in rows
    parts = [f"{n['components']}, {n['share']:.1%} (15: {n['share_at_15']:.1%})".replace("%", " %") for n in both]
    assert f"| components, share of variance | about 15, > 97 % | {' | '.join(parts)} |" in rows
    for stage in figures["reproduction, recordings"]["section 5"]:
        solved, jump, miss = stage["solved"], stage["seam_jump"], stage["worst_miss_mm"]
        head = f"| {stage['examples']} | {stage['frames']:,} | {100 * solved:.0f} % | {jump:.2f} | {miss:.0f} mm |"
        assert any(row.startswith(head) for row in rows), head
    for place in ("first", "last"):
        own = figures["own frames"][place]
        cells = f"{own['pairs']} | {own['refused']} | {100 * own['missed']:.0f} % | {own['worst_mm']:.0f}"
        assert f"| {place} | {cells} |" in rows


def test_the_table_of_pairs_is_that_of_its_file(figures: dict[str, Any]):
    rows = _rows(PAGE.read_text())
    for solver, name in (("search", "search"), ("paper", "cluster chain")):
        of = figures["pairs"][solver]
        jump, skate = (", ".join(f"{value:.2f}" for value in of[column]) for column in ("jump", "skate"))
        row = f"| {name} | {of['solved']} of {of['pairs']} | {jump} | {skate} | {100 * of['untouched']:.0f} % |"
        assert any(found.startswith(row) for found in rows), row


def test_the_table_of_gaps_is_that_of_its_file(figures: dict[str, Any]):
    rows = _rows(PAGE.read_text())
    for gap, of in figures["gaps"].items():
        for column, digits in (("npss", ".4f"), ("l2q", ".2f"), ("l2p", ".2f")):
            methods = ("zero velocity", "interpolation", "keyframe")
            hold, even, ours = (format(of[method][column], digits) for method in methods)
            cell = f"{hold}, {even}, **{ours}**"
            assert any(row.startswith(f"| {gap} |") and cell in row for row in rows), (gap, cell)


def test_the_samples_figures_are_made_again(tmp_path: Path, clips_folder: Path, figures: dict[str, Any]):
    assert clips_folder.is_dir()
    molina_tanco2000.reproduce(tmp_path / "page", effort=molina_tanco2000.Effort(frames=20))
    made = json.loads((tmp_path / "page" / "numbers.json").read_text())
    known = figures["reproduction, sample"]
    numbers = made["section 4"]
    for name, value in known["section 4"].items():
        assert numbers[name] == (pytest.approx(value, rel=0.02) if isinstance(value, float) else value), name
    errors = made["figure 6"]
    assert errors["runs"] == known["figure 6"]["runs"] == 110
    assert errors["mean"] == pytest.approx(known["figure 6"]["mean"], rel=0.02)
