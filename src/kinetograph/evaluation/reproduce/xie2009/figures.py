"""Figures 7.5 and 7.6: RMS by frame, and poses next to the recording's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.reproduce.xie2009.methods import AHEAD, FRAME_BY_FRAME, PCA
from kinetograph.evaluation.sensor_folds import Fold
from kinetograph.evaluation.sensor_scores import normalised_rms, pose_errors
from kinetograph.motion import Motion

DRAWN = (PCA, FRAME_BY_FRAME, AHEAD)
"""The methods whose poses are drawn."""


def draw(fold: Fold, results: Mapping[str, FloatArray], folder: Path) -> None:
    """Draw both figures of a held-out take.

    Parameters
    ----------
    fold : Fold
    results : mapping
        Rotations, shape (F, J, 4), by method.
    folder : Path
    """
    _draw_rms(fold, results, folder / rms_picture(fold.take))
    frames = min(len(fold.truth), *(len(r) for r in results.values()))
    for name in DRAWN:
        _draw_poses(fold, name, results[name], frames, folder / pose_picture(fold.take, name))


def _draw_rms(fold: Fold, results: Mapping[str, FloatArray], path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for name, rotations in results.items():
        frames = min(len(rotations), len(fold.truth))
        by_frame = [normalised_rms(rotations[i : i + 1], fold.truth.rotations[i : i + 1]) for i in range(frames)]
        axes.plot(np.arange(frames) / fold.truth.fps, by_frame, lw=1, label=name)
    axes.set(title=fold.take, xlabel="seconds", ylabel="normalised RMS (7.1)", ylim=(0, None))
    axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


def _draw_poses(fold: Fold, name: str, rotations: FloatArray, frames: int, path: Path) -> None:
    from kinetograph.drawing import contact_sheet

    truth = replace(fold.truth, translation=fold.truth.translation[:frames], rotations=fold.truth.rotations[:frames])
    # the recording's root for both: figure 7.6 compares poses
    both = np.concatenate([truth.rotations[:, :1], rotations[:frames, 1:]], axis=1)
    result = Motion(truth.skeleton, truth.translation + np.array([1.2, 0, 0]), both, truth.fps)
    title = f"{fold.take}: recorded, and {name}, {float(pose_errors(both, truth.rotations).mean()):.1f} degrees"
    contact_sheet([truth, result], path, title=title, frames=12)


def rms_picture(take: str) -> str:
    """The file of a take's figure 7.5."""
    return f"{take}_rms.png"


def pose_picture(take: str, method: str) -> str:
    """The file of a take's figure 7.6 by one method."""
    return f"{take}_{method.split(', ')[1].replace(' ', '_')}.png"
