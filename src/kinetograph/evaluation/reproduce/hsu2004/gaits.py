"""Held-out walks performed from their hips and from their path alone, and how their gaits keep the real phase."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.errors import KinetographError
from kinetograph.evaluation.metrics import joint_error
from kinetograph.evaluation.phase import (
    STEP,
    Locking,
    Phase,
    ankles_apart,
    foot_agreement,
    gait_phase,
    locking,
    plant_phase,
)
from kinetograph.evaluation.reproduce.hsu2004.sway import CalmPath
from kinetograph.library import Library
from kinetograph.methods.performance import GroundPath, PerformanceControl, PerformanceModel
from kinetograph.motion import Motion, cut

HIPS, PATH = "hips", "path alone"
SIGMAS = (0.0, 0.15, 0.3, 0.45, 0.6, 0.9)
"""Seconds over which hips are smoothed."""

Models = Mapping[tuple[str, str], PerformanceModel]
"""Models by the take that is held out and the control."""


@dataclass(frozen=True, eq=False)
class Walked:
    """A held-out walk performed.

    Parameters
    ----------
    take : str
    control : str
        Which control was used.
    real, made : Motion
    kept : Locking
        How the made gait keeps the phase of the real one.
    """

    take: str
    control: str
    real: Motion
    made: Motion
    kept: Locking

    @property
    def phases(self) -> tuple[Phase, Phase]:
        """Of the made and of the real gait."""
        return gait_phase(self.made), gait_phase(self.real)


def methods() -> dict[str, PerformanceControl]:
    """The two controls that are compared."""
    return {
        HIPS: PerformanceControl(reuse=0.0, stand=False),
        PATH: PerformanceControl(reuse=0.0, stand=False, control_points=CalmPath()),
    }


def fit_all(library: Library) -> Models:
    """A model for each take, of the others, and for each control."""
    return {
        (name, control): method.fit(library, exclude=(name,))
        for name in library.names()
        for control, method in methods().items()
    }


def walk_again(model: PerformanceModel, name: str, control: str, motion: Motion) -> Walked | None:
    """Perform a walk with a model of the other takes; None where a gait has no phase."""
    try:
        made = model.synthesize(motion).motion
        kept = locking(gait_phase(made), gait_phase(motion), np.random.default_rng(0))
    except KinetographError:
        return None
    return Walked(name, control, motion, made, kept)


def in_phase_by_footplants(walked: Walked) -> float:
    """The share of the time in phase by the times of footplants, without the ankles' swing."""
    made, real = plant_phase(walked.made), plant_phase(walked.real)
    frames = min(len(made), len(real))
    difference = np.abs(np.angle(np.exp(1j * (made[:frames] - real[:frames]))))
    known = difference[~np.isnan(difference)]
    return float((known < np.pi / 2).mean()) if len(known) else float("nan")


def in_step_by_length(
    takes: Sequence[tuple[str, Motion]], models: Models, count: int, lengths: Sequence[float]
) -> list[tuple[float, int, float, float]]:
    """How many excerpts come out in step, by their length.

    An excerpt is in step if its ankles swing as the real ones do rather than oppositely.

    Parameters
    ----------
    takes : sequence of tuple
        Names and motions.
    models : mapping
    count : int
        Excerpts of each take, spread evenly over it.
    lengths : sequence of float
        Seconds.

    Returns
    -------
    list of tuple
        The length, the number of excerpts, and the shares in per cent that are in step, by hips and by path.
    """
    rows = []
    for length in lengths:
        in_step: dict[str, list[bool]] = {HIPS: [], PATH: []}
        for name, motion in takes:
            for excerpt in _excerpts(motion, length, count):
                for control, agreed in in_step.items():
                    made = models[name, control].synthesize(excerpt).motion
                    agreed.append(foot_agreement(made, excerpt) > 0)
        if in_step[HIPS]:
            hips, path = (100 * float(np.mean(in_step[control])) for control in (HIPS, PATH))
            rows.append((length, len(in_step[HIPS]), hips, path))
    return rows


def _excerpts(motion: Motion, length: float, count: int) -> list[Motion]:
    """Excerpts in which the person walks at least half of the time."""
    frames = int(length * motion.fps) + 1
    if frames > len(motion):
        return []
    starts = np.unique(np.linspace(0, len(motion) - frames, count).astype(int))
    excerpts = [cut(motion, int(a), int(a) + frames) for a in starts]
    return [m for m in excerpts if np.mean(np.abs(ankles_apart(m)) > STEP) > 0.5]


def in_phase_by_smoothing(
    library: Library, takes: Sequence[tuple[str, Motion]]
) -> list[tuple[float, float, float, float]]:
    """How long gaits are in phase, by how much the hips of control and library are smoothed.

    Parameters
    ----------
    library : Library
    takes : sequence of tuple
        Names and motions.

    Returns
    -------
    list of tuple
        The Gaussian's seconds, the sway that is left of one stride per second in per cent, and means over the takes: in
        phase in per cent, joint error in cm.
    """
    rows = []
    for sigma in SIGMAS:
        method = PerformanceControl(
            reuse=0.0, stand=False, control_points=CalmPath(seconds=sigma) if sigma else GroundPath()
        )
        walked = [walk_again(method.fit(library, exclude=(name,)), name, "", motion) for name, motion in takes]
        known = [w for w in walked if w is not None]
        if known:
            joints = float(np.mean([100 * joint_error(w.made, w.real) for w in known]))
            share = 100 * float(np.mean([w.kept.in_phase for w in known]))
            rows.append((sigma, 100 * float(np.exp(-2 * (np.pi * sigma) ** 2)), share, joints))
    return rows
