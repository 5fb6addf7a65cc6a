"""Holds takes out of a library, runs the methods on them, and writes the page."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.reproduce.xie2009.figures import draw
from kinetograph.evaluation.reproduce.xie2009.methods import Runs, TakeRow, run_methods
from kinetograph.evaluation.reproduce.xie2009.page import ClipRow, means, page
from kinetograph.evaluation.reproduce.xie2009.strokes import Strokes, find_strokes, wide_layout
from kinetograph.evaluation.sensor_folds import Fold, HeldOut, folds, folds_of
from kinetograph.formats import atomic_path
from kinetograph.library import Library
from kinetograph.methods.sensor import LocalModelSettings, SensorControl
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
    seeds: int = 1,
    report: Report = lambda text: None,
) -> list[TakeRow]:
    """Write ``index.html``, its pictures and ``numbers.json`` to a new folder, anew after every take.

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
    seeds : int
        Seeds of the mixture over which rows are means; the page has the range.
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
    made = _Made(folder, Runs(local or LocalModelSettings(), seeds), report)
    for build in folds(library, SensorControl(), HeldOut(tuple(takes) or _spread(library.names()))):
        made.add(build())
    strokes = Strokes({}, (NO_SERVES,)) if serves is None else find_strokes(serves)
    made.notes = strokes.notes
    made.write()
    for motions in strokes.takes.values():
        wide = folds_of(motions, SensorControl(layout=wide_layout()))
        for build, build_wide in zip(folds_of(motions, SensorControl()), wide, strict=True):
            made.add(build(), build_wide)
    return made.rows


@dataclass
class _Made:
    """What is done, and the folder that it is written to.

    Parameters
    ----------
    folder : Path
    runs : Runs
    report : callable
    rows, clipping : list
        Of all takes, and of strokes.
    notes : tuple of str
        On the strokes.
    """

    folder: Path
    runs: Runs
    report: Report
    rows: list[TakeRow] = field(default_factory=list)
    clipping: list[ClipRow] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    def add(self, fold: Fold, build_wide: Callable[[], Fold] | None = None) -> None:
        """Run the methods on a held-out take, and on a stroke by a device with a wider range as well."""
        self.report(f"{fold.take}: {len(fold.truth)} frames")
        library = "strokes" if build_wide else "library"
        results = run_methods(fold, self.runs, library)
        draw(fold, {name: rotations for name, (_, rotations) in results.items()}, self.folder)
        mine = [row for row, _ in results.values()]
        self.rows += mine
        if build_wide:
            self.clipping += _clipping(fold, mine, run_methods(build_wide(), replace(self.runs, layout=wide_layout())))
        self.write()

    def write(self) -> None:
        """Write the page and its numbers."""
        numbers = {"takes": [asdict(row) for row in self.rows], "clipping": [asdict(row) for row in self.clipping]}
        text = json.dumps({**numbers, "means": means(self.rows), "notes": list(self.notes)}, indent=1) + "\n"
        shown = page(self.rows, self.clipping, self.notes)
        for name, content in (("numbers.json", text), ("index.html", shown)):
            with atomic_path(self.folder / name, force=True) as draft:
                draft.write_text(content, encoding="utf-8")


def _spread(names: Sequence[str]) -> tuple[str, ...]:
    """Four of the names, spread over all."""
    return tuple(names[i] for i in np.unique(np.linspace(0, len(names) - 1, 4).astype(int)))


def _clipping(fold: Fold, rows: Sequence[TakeRow], wide: dict[str, tuple[TakeRow, FloatArray]]) -> list[ClipRow]:
    layout = SensorControl().layout
    reach = np.abs(specific_force(fold.truth, layout)).max(axis=(1, 2))
    share = float(np.mean(reach > layout.device.span))
    most = float(reach.max()) / GRAVITY
    return [ClipRow(fold.take, row.method, most, share, row.angle, wide[row.method][0].angle) for row in rows]
