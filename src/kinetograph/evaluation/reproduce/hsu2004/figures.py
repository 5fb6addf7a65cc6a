"""The figures of Hsu 2004's reproduction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, RED, GREEN = "#0072b2", "#d55e00", "#009e73"
_COLOURS = (BLUE, RED, GREEN, "#cc79a7", "#e69f00")


def draw_differences(tracks: Sequence[tuple[str, FloatArray, FloatArray]]) -> Figure:
    """Wrapped differences of phase over time, one panel per track.

    Parameters
    ----------
    tracks : sequence of tuple
        Names, times in seconds, and differences in radians.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = _panels(9, 2.3 * len(tracks), len(tracks))
    for axis, colour, (name, times, difference) in zip(axes, _COLOURS, tracks, strict=False):
        axis.axhspan(-90, 90, color="#e8f1e8", zorder=0)
        axis.plot(times, np.rad2deg(difference), ".", ms=2, color=colour)
        axis.set(title=name, ylabel="degrees", ylim=(-180, 180), yticks=(-180, -90, 0, 90, 180))
    axes[-1].set_xlabel("seconds; shaded: in phase")
    return figure


def draw_sway(centres: FloatArray, mean: FloatArray, spread: FloatArray) -> Figure:
    """Sideways sway and rotation of the hips by the phase of the gait; see `sway.sway_by_phase`."""
    figure, axes = _panels(9, 3.0, 2, across=True)
    for i, (axis, label) in enumerate(zip(axes, ("cm to the left", "degrees to the left"), strict=True)):
        axis.fill_between(
            np.rad2deg(centres), mean[:, i] - spread[:, i], mean[:, i] + spread[:, i], color=_COLOURS[i], alpha=0.2
        )
        axis.plot(np.rad2deg(centres), mean[:, i], color=_COLOURS[i])
        axis.set(xlabel="phase of the gait, degrees", ylabel=label, xticks=(-180, -90, 0, 90, 180))
    return figure


def draw_excerpts(rows: Sequence[tuple[float, int, float, float]]) -> Figure:
    """Shares of excerpts in step by their length; see `gaits.in_step_by_length`."""
    figure, (axis,) = _panels(7, 3.4, 1)
    axis.axhline(50, color="#888888", ls=":", label="chance")
    lengths = np.array([row[0] for row in rows])
    for k, (name, colour) in enumerate((("hips", BLUE), ("path alone", RED))):
        shares = np.array([row[2 + k] for row in rows]) / 100
        low, high = _wilson(shares, np.array([row[1] for row in rows]))
        bars = 100 * np.array([shares - low, high - shares])
        axis.errorbar(
            lengths * (1 + 0.03 * k), 100 * shares, np.maximum(bars, 0), color=colour, capsize=3, marker="o", label=name
        )
    axis.set(xscale="log", xlabel="seconds of control", ylabel="in step, %", ylim=(0, 105))
    axis.set_xticks(lengths, [f"{s:g}" for s in lengths])
    axis.minorticks_off()
    axis.legend(frameon=False, loc="lower right")
    return figure


def draw_growth(
    lengths: Sequence[float], times: Mapping[str, Sequence[float]], lines: Mapping[str, tuple[float, float]]
) -> Figure:
    """Time against length of the control, with the lines fitted.

    Parameters
    ----------
    lengths : sequence of float
        Seconds of control.
    times : mapping of str to sequence of float
        Processor seconds by search.
    lines : mapping of str to tuple of float
        Slope and intercept by search.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (axis,) = _panels(7, 3.4, 1)
    at = np.array(lengths)
    for colour, (name, taken) in zip(_COLOURS, times.items(), strict=False):
        slope, intercept = lines[name]
        axis.plot(at, taken, "o", color=colour, label=name)
        axis.plot(at, slope * at + intercept, color=colour, lw=1)
    axis.set(xlabel="seconds of control", ylabel="processor seconds", xlim=(0, None), ylim=(0, None))
    axis.legend(frameon=False)
    return figure


def draw_curves(x: Sequence[float], curves: Mapping[str, Sequence[float]], xlabel: str) -> Figure:
    """Several measures over one setting, one panel per measure.

    Parameters
    ----------
    x : sequence of float
        The setting's values, which are drawn evenly spaced.
    curves : mapping of str to sequence of float
        The measures by name.
    xlabel : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = _panels(9.5, 2.8, len(curves), across=True)
    for colour, axis, (name, values) in zip(_COLOURS, axes, curves.items(), strict=False):
        axis.plot(range(len(x)), values, "o-", color=colour)
        axis.set(xlabel=xlabel, title=name, ylim=(0, None))
        axis.set_xticks(range(len(x)), [f"{value:g}" for value in x], rotation=45)
    return figure


def _wilson(share: FloatArray, count: FloatArray, z: float = 1.96) -> tuple[FloatArray, FloatArray]:
    """Wilson's 95 % interval of shares of ``count``."""
    middle = (share + z**2 / (2 * count)) / (1 + z**2 / count)
    half = z * np.sqrt(share * (1 - share) / count + z**2 / (4 * count**2)) / (1 + z**2 / count)
    return middle - half, middle + half


def _panels(width: float, height: float, count: int, across: bool = False) -> tuple[Figure, list[Axes]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    shape = (1, count) if across else (count, 1)
    return figure, [figure.add_subplot(*shape, i + 1) for i in range(count)]
