"""Holds takes out of a library, runs the methods on them, and writes the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.reproduce.xie2009.figures import draw
from kinetograph.evaluation.reproduce.xie2009.methods import TakeRow, run_methods
from kinetograph.evaluation.reproduce.xie2009.page import ClipRow, page
from kinetograph.evaluation.reproduce.xie2009.strokes import Strokes, find_strokes, wide_layout
from kinetograph.evaluation.sensor_folds import Fold, HeldOut, folds, folds_of
from kinetograph.library import Library
from kinetograph.methods.sensor import LocalModelSettings, Motions, SensorControl
from kinetograph.sensing import GRAVITY, specific_force

Report = Callable[[str], None]
NO_SERVES = "Tennis is left out: no folder of C3D recordings was named (--serves)."


def reproduce(
    output: str | Path,
    library: Library,
    *,
    takes: Sequence[str] = (),
    serves: str | Path | None = None,
    local: LocalModelSettings | None = None,
    report: Report = lambda text: None,
) -> list[TakeRow]:
    """Write ``index.html`` and its pictures to a new folder.

    Parameters
    ----------
    output : str or Path
    library : Library
    takes : sequence of str
        To hold out; by default four that are spread over the library.
    serves : str or Path, optional
        A folder of C3D files of markers. The strokes of each are a library of their own, one held out at a time; what
        cannot be used is named on the page.
    local : LocalModelSettings, optional
    report : callable
        Called with a line for each take.

    Returns
    -------
    list of TakeRow
        The rows of the page's table.

    Raises
    ------
    RequestError
        For a folder in use.
    """
    folder = Path(output)
    if folder.exists() and any(folder.iterdir()):
        raise RequestError(f"{folder} is not empty; name a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    settings = local or LocalModelSettings()
    held = HeldOut(tuple(takes) or _spread(library.names()))
    rows: list[TakeRow] = []
    for build in folds(library, SensorControl(), held):
        rows += _held_out(build(), settings, folder, report)
    strokes = Strokes({}, (NO_SERVES,)) if serves is None else find_strokes(serves)
    clipping: list[ClipRow] = []
    for motions in strokes.takes.values():
        more, clips = _strokes(motions, settings, folder, report)
        rows += more
        clipping += clips
    (folder / "index.html").write_text(page(rows, clipping, strokes.notes), encoding="utf-8")
    return rows


def _spread(names: Sequence[str]) -> tuple[str, ...]:
    """Four of the names, spread over all."""
    return tuple(names[i] for i in np.unique(np.linspace(0, len(names) - 1, 4).astype(int)))


def _held_out(fold: Fold, settings: LocalModelSettings, folder: Path, report: Report) -> list[TakeRow]:
    report(f"{fold.take}: {len(fold.truth)} frames")
    results = run_methods(fold, settings, SensorControl().layout)
    draw(fold, {name: rotations for name, (_, rotations) in results.items()}, folder)
    return [row for row, _ in results.values()]


def _strokes(
    motions: Motions, settings: LocalModelSettings, folder: Path, report: Report
) -> tuple[list[TakeRow], list[ClipRow]]:
    """The strokes of one file, each held out, by the device and by one with a wider range."""
    rows: list[TakeRow] = []
    clipping: list[ClipRow] = []
    wide = folds_of(motions, SensorControl(layout=wide_layout()))
    for build, build_wide in zip(folds_of(motions, SensorControl()), wide, strict=True):
        fold = build()
        mine = _held_out(fold, settings, folder, report)
        clipping += _clipping(fold, mine, run_methods(build_wide(), settings, wide_layout()))
        rows += mine
    return rows, clipping


def _clipping(fold: Fold, rows: Sequence[TakeRow], wide: dict[str, tuple[TakeRow, FloatArray]]) -> list[ClipRow]:
    layout = SensorControl().layout
    reach = np.abs(specific_force(fold.truth, layout)).max(axis=(1, 2))
    share = float(np.mean(reach > layout.device.span))
    most = float(reach.max()) / GRAVITY
    return [ClipRow(fold.take, row.method, most, share, row.angle, wide[row.method][0].angle) for row in rows]
