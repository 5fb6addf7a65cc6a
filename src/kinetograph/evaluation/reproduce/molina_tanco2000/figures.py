"""The figures of Molina-Tanco & Hilton 2000."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")


def draw_alignment(before: Sequence[FloatArray], after: Sequence[FloatArray], names: Sequence[str], path: Path) -> None:
    """Figure 2: two principal components of the examples before and after their mean heading is taken out.

    Parameters
    ----------
    before, after : sequence of ndarray, shape (F, M)
        Coordinates of each example.
    names : sequence of str
    path : Path
        Picture to write.
    """
    figure = _figure(10, 4.6)
    for number, (title, examples) in enumerate((("before alignment", before), ("after", after)), start=1):
        axes = figure.add_subplot(1, 2, number)
        for colour, name, points in zip(_COLOURS, names, examples, strict=False):
            axes.plot(points[:, 0], points[:, 1], color=colour, lw=1.5, label=name)
        axes.set(title=title, xlabel="first component", ylabel="second component")
        axes.legend(frameon=False)
    _save(figure, path)


def draw_space(
    examples: Sequence[FloatArray], names: Sequence[str], path: Path, *, result: FloatArray | None = None
) -> None:
    """Figures 5 and 8: three principal components of the examples and, thick, of a result.

    Parameters
    ----------
    examples : sequence of ndarray, shape (F, M)
        Coordinates of each example.
    names : sequence of str
    path : Path
        Picture to write.
    result : ndarray, shape (F, M), optional
        Coordinates of the result.
    """
    figure = _figure(7, 6)
    axes = figure.add_subplot(projection="3d")
    for colour, name, points in zip(_COLOURS, names, examples, strict=False):
        axes.plot(*_three(points).T, color=colour, lw=1.2, alpha=0.9 if result is None else 0.45, label=name)
    if result is not None:
        axes.plot(*_three(result).T, color="black", lw=3, label="synthesis")
    axes.legend(frameon=False)
    _save(figure, path)


def draw_errors(errors: Mapping[int, Sequence[float]], path: Path) -> None:
    """Figure 6: the accumulated quantisation error of single runs of K-means by K, their mean and spread.

    Parameters
    ----------
    errors : mapping of int to sequence of float
        The errors of the runs, by K.
    path : Path
        Picture to write.
    """
    figure = _figure(7, 4.6)
    axes = figure.add_subplot()
    sizes = np.array(list(errors))
    for size, runs in errors.items():
        axes.plot([size] * len(runs), runs, "o", color="#56b4e9", ms=3, alpha=0.6)
    mean, spread = (np.array([f(runs) for runs in errors.values()]) for f in (np.mean, np.std))
    axes.errorbar(sizes, mean, spread, color="#0072b2", capsize=4, label="mean and standard deviation")
    axes.set(xlabel="K", ylabel="accumulated quantisation error", ylim=(0, None))
    axes.legend(frameon=False)
    _save(figure, path)


def _three(points: FloatArray) -> FloatArray:
    """The first three columns, zeros where there are fewer."""
    return np.pad(points, ((0, 0), (0, max(0, 3 - points.shape[1]))))[:, :3]


def _figure(width: float, height: float) -> Figure:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _save(figure: Figure, path: Path) -> None:
    from kinetograph.formats import atomic_path

    with atomic_path(path, force=True) as draft:
        figure.savefig(draft, dpi=110, format="png")
