"""The figures of Molina-Tanco & Hilton 2000."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.keys import Key
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.methods.keyframe import Excerpt, TwoLevelModel
from kinetograph.motion import Motion, cut
from kinetograph.synthesis import Synthesis

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


def draw_states(model: TwoLevelModel, path: Path, *, passed: Sequence[int] = ()) -> None:
    """Figure 3: the states of the Markov chain in the plane of two components, and the transitions between them.

    Parameters
    ----------
    model : TwoLevelModel
    path : Path
        Picture to write.
    passed : sequence of int
        The states that a synthesis passes, which are drawn in colour.
    """
    figure = _figure(7.5, 6.5)
    axes = figure.add_subplot()
    points, labels = np.concatenate(model.coordinates), np.concatenate(model.labels)
    axes.scatter(points[:, 0], points[:, 1], c=[_COLOURS[k % len(_COLOURS)] for k in labels], s=4, alpha=0.35)
    steps = set(itertools.pairwise(passed))
    for a, b in np.argwhere(model.transitions > 0):
        if a == b:
            continue
        passes = (int(a), int(b)) in steps
        style = {"color": "#d55e00" if passes else "#888888", "lw": 2.5 if passes else 1.0}
        bent = {"arrowstyle": "-|>", "connectionstyle": "arc3,rad=0.15", "shrinkA": 9, "shrinkB": 9, **style}
        ends = model.quantiser.centres[[b, a], :2]
        axes.annotate("", xy=ends[0], xytext=ends[1], arrowprops=bent, zorder=3 if passes else 2)
    for number, (x, y) in enumerate(model.quantiser.centres[:, :2]):
        colour = "#d55e00" if number in passed else "#555555"
        box = {"boxstyle": "circle", "fc": "white", "ec": colour}
        axes.text(x, y, str(number), ha="center", va="center", fontsize=9, color=colour, bbox=box, zorder=4)
    axes.set(xlabel="first component", ylabel="second component", title="level 1: clusters and their transitions")
    _save(figure, path)


def draw_examples(model: TwoLevelModel, names: Sequence[str], path: Path, *, used: Sequence[Excerpt] = ()) -> None:
    """Figure 4: the hidden states of the HMM are the examples; what they put out, and the segments that clusters cut.

    Parameters
    ----------
    model : TwoLevelModel
    names : sequence of str
        Of the examples.
    path : Path
        Picture to write.
    used : sequence of Excerpt
        What a synthesis is made of, which is framed.
    """
    figure = _figure(11, 1.6 + 0.5 * len(names))
    left, right = figure.subplots(1, 2, width_ratios=(2, 3))
    shown = left.imshow(model.outputs, aspect="auto", cmap="Blues", vmin=0)
    left.set(title="b(cluster | example)", xlabel="cluster", yticks=range(len(names)), yticklabels=list(names))
    figure.colorbar(shown, ax=left)
    for row, labels in enumerate(model.labels):
        edges = [0, *(np.flatnonzero(np.diff(labels)) + 1), len(labels)]
        for start, stop in itertools.pairwise(edges):
            cluster = int(labels[start])
            right.barh(row, stop - start, left=start, color=_COLOURS[cluster % len(_COLOURS)], ec="white", alpha=0.6)
            right.text((start + stop) / 2, row, str(cluster), ha="center", va="center", fontsize=7)
    for excerpt in used:
        right.barh(excerpt.example, len(excerpt), left=excerpt.start, fc="none", ec="black", lw=2.5)
    right.set(title="motion segments by cluster; framed: what is used", xlabel="frame", yticks=[])
    right.set_ylim(len(names) - 0.5, -0.5)
    _save(figure, path)


def seen_from_side(pose: Motion) -> FloatArray:
    """Joints of a pose, ``(J, 2)`` metres forward of the root, square to its hips, and above the lowest joint."""
    left, right = role_positions(pose, ("left_hip", "right_hip"))[0]
    forward = np.array([right[2] - left[2], 0.0, left[0] - right[0]])
    points = joint_positions(pose)[0]
    ahead = (points - points[0]) @ forward / max(float(np.linalg.norm(forward)), 1e-9)
    return np.stack([ahead, points[:, 1] - points[:, 1].min()], axis=-1)


def draw_keys(keys: Sequence[Key], path: Path) -> None:
    """Figure 7: the keys, seen from their side.

    Parameters
    ----------
    keys : sequence of Key
    path : Path
        Picture to write.
    """
    figure = _figure(4 * len(keys), 4)
    for number, (key, axes) in enumerate(zip(keys, np.atleast_1d(figure.subplots(1, len(keys))), strict=True)):
        points = seen_from_side(cut(key.clip, key.frame, key.frame + 1))
        for joint, parent in enumerate(key.clip.skeleton.parents):
            if parent >= 0:
                axes.plot(*points[[parent, joint]].T, "-o", color=_COLOURS[number], lw=3, ms=3)
        axes.axhline(0, color="#bbbbbb", lw=1)
        axes.set(title=key.label, xlim=(-1.1, 1.1), ylim=(-0.1, 2.1), xlabel="forward (m)", aspect="equal")
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


def draw_transition(result: Synthesis, path: Path) -> None:
    """Figure 9: poses of the result, and its seams."""
    from kinetograph.drawing import contact_sheet

    seams = [piece.start for piece in result.pieces[1:]]
    contact_sheet(result.motion, path, contacts=result.annotations, seams=seams, title="figure 9: the transition")


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
