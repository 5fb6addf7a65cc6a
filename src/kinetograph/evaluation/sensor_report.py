"""The page of an evaluation of sensor control and its numbers, written anew whenever something is done."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from kinetograph.errors import RequestError
from kinetograph.evaluation.intervals import Interval
from kinetograph.evaluation.reproduce.page import Section, Value, page, paragraph, table
from kinetograph.evaluation.sensor_means import SensorMean, is_baseline
from kinetograph.formats import atomic_path

PAGE, NUMBERS = "index.html", "results.json"
"""The files of a report."""
COLUMNS = (
    "method",
    "degrees",
    "gain over the best baseline",
    "best on",
    "RMS (7.1)",
    "position, cm",
    "jitter over the source's",
    "foot slide, cm/s",
)
"""What people are shown of a mean."""


@dataclass(frozen=True)
class Table:
    """A table of a report.

    Parameters
    ----------
    title : str
    rows : sequence of dict
        With the same keys.
    text : str
        What is to be known of it.
    """

    title: str
    rows: Sequence[Mapping[str, Any]]
    text: str = ""


def new_folder(folder: Path) -> Path:
    """A folder for a report. Raises RequestError where it is in use."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise RequestError(f"{folder} is not empty; name a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write_report(folder: Path, title: str, tables: Sequence[Table], numbers: Mapping[str, Any]) -> None:
    """Write the page and its numbers, each whole or not at all.

    Parameters
    ----------
    folder : Path
    title : str
    tables : sequence of Table
    numbers : mapping
        What the file of numbers has besides the tables.
    """
    sections = [Section(one.title, _parts(one)) for one in tables]
    everything = {**numbers, "tables": {one.title: [dict(row) for row in one.rows] for one in tables}}
    for name, text in ((PAGE, page(title, sections)), (NUMBERS, json.dumps(plain(everything), indent=1) + "\n")):
        with atomic_path(folder / name, force=True) as draft:
            draft.write_text(text, encoding="utf-8")


def _parts(one: Table) -> tuple[str, ...]:
    columns = list(one.rows[0]) if one.rows else []
    cells: list[list[Value]] = [[_cell(row[name]) for name in columns] for row in one.rows]
    texts = (paragraph(one.text),) if one.text else ()
    return (*texts, table("", [name.replace("_", " ") for name in columns], cells)) if cells else texts


def _cell(value: Any) -> Value:
    return value if isinstance(value, int | float | str) or value is None else str(value)


def plain(value: Any) -> Any:
    """A value for JSON: null for numbers that are not finite, texts for what it has no words for."""
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, str | int | bool) or value is None else str(value)


def rows_for_people(means: Sequence[SensorMean]) -> list[dict[str, Value]]:
    """The rows of the table that people read, by `COLUMNS`, after the group's name."""
    return [_for_people(mean) for mean in means]


def _for_people(mean: SensorMean) -> dict[str, Value]:
    angle = Interval(mean.angle, mean.angle_low, mean.angle_high)
    gain = Interval(mean.gain, mean.gain_low, mean.gain_high)
    best = mean.method == mean.best
    rival = is_baseline(mean.method)
    cells: tuple[Value, ...] = (
        mean.method,
        str(angle),
        "the best baseline" if best else str(gain),
        "" if rival else f"{mean.beaten} of {mean.takes}",
        mean.mean.rms,
        mean.mean.position_cm,
        mean.mean.jitter,
        mean.mean.slide_cm_s,
    )
    return {"group": mean.group, **dict(zip(COLUMNS, cells, strict=True))}


def rows_for_machines(means: Sequence[SensorMean]) -> list[dict[str, Any]]:
    """All figures of the means."""
    return [{**{k: v for k, v in asdict(mean).items() if k != "mean"}, **_others(mean)} for mean in means]


def _others(mean: SensorMean) -> dict[str, Any]:
    known = asdict(mean)
    named = {*known, "take", "person"}
    return {name: value for name, value in known["mean"].items() if name not in named}
