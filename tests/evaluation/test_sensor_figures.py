"""The quick figures of docs/results/sensor.md, which hold on other machines within 2 %."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from kinetograph.evaluation import HeldOut, evaluate, group_means, together
from kinetograph.evaluation.real_sensors import neura
from kinetograph.evaluation.real_wrist import utd
from kinetograph.formats import ReadOptions
from kinetograph.library import Library
from kinetograph.methods.sensor import Continuity, SensorControl
from kinetograph.pipeline import read_take

PAGE = Path(__file__).parents[2] / "docs" / "results" / "sensor.md"
WITHIN = 0.02


def printed(recording: str) -> dict[str, float]:
    """The degrees of a recording by method, as the page has them."""
    table = PAGE.read_text().split("## Quick figures", 1)[1].split("\n## ", 1)[0]
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines() if line[:1] == "|"]
    names = [name.lower() for name in lines[0][1:]]
    (row,) = [line for line in lines if line[0] == recording]
    return {name: float(re.sub(r"[^0-9.]", "", cell)) for name, cell in zip(names, row[1:], strict=True)}


def test_the_quick_figures_of_sports(data_folder: Path, tmp_path: Path) -> None:
    folder = data_folder / "sports"
    if not folder.is_dir():
        pytest.skip("no recordings of sports: sports is missing")
    library = Library.create(tmp_path / "sports")
    for path in sorted([*folder.glob("124_*_amass30.bvh"), *folder.glob("86_*_amass30.bvh")]):
        library.add(read_take(path, ReadOptions())[0])
    held = HeldOut(only=("124_03_amass30",))
    scores = together(list(evaluate(library, SensorControl(), syntheses={"continuity": Continuity()}, held=held)))
    found = {mean.method: mean.angle for mean in group_means(scores.rows)}
    for name, degrees in printed("basketball 124_03").items():
        assert found[name] == pytest.approx(degrees, rel=WITHIN), name


@pytest.mark.parametrize("recording", ["neura's walk", "utd-mhad a7"])
def test_the_quick_figures_of_real_sensors(data_folder: Path, recording: str) -> None:
    folder = data_folder / "sensors"
    if not folder.is_dir():
        pytest.skip("no recordings of real sensors: sensors is missing")
    syntheses = {"continuity": Continuity()}
    walks = recording == "neura's walk"
    rows = neura(folder / "neura", syntheses=syntheses) if walks else utd(folder / "utd-mhad", 7, syntheses=syntheses)
    found = {row.method: row.angle for row in rows}
    for name, degrees in printed(recording).items():
        assert found[name] == pytest.approx(degrees, rel=WITHIN), name
