"""Held-out protocols: what is tested on was never trained on."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import accelerations, contact_speed, control_error, joint_error, near_seams
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.motion import Motion
from kinetograph.post.contacts import contacts_of
from kinetograph.segmentation import detect_contacts
from kinetograph.synthesis import Synthesis

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class WalkRow:
    """One held-out take, whose hips were the control.

    control_cm, joint_cm: mean distances from the control and from the real performance. slide, slide_recorded: mean
    speed in m/s of planted feet, in the result and in the real performance. seam, seam_recorded: the largest joint
    acceleration within 0.2 s of a seam over the 99th percentile, inside the library's segments, of each frame's
    largest joint acceleration, for the result and for the real performance at the same instants. seam_all: the same
    over the 99th percentile of all joints' accelerations.
    """

    take: str
    seconds: float
    pieces: int
    control_cm: float
    joint_cm: float
    slide: float
    slide_recorded: float
    seam: float
    seam_recorded: float
    seam_all: float
    seam_all_recorded: float
    times_real_time: float


def leave_one_take_out(
    method: PerformanceControl, library: Library, *, track: str | None = None, progress: Progress | None = None
) -> list[WalkRow]:
    """Perform the hips of each take with the other takes as the library (Hsu 2004, section 6.1)."""
    rows = []
    names = library.names()
    for done, name in enumerate(names, start=1):
        model = method.fit(library, exclude=(name,), track=track)
        held_out = library.take(name).motion(track)
        began = time.perf_counter()
        result = model.synthesize(held_out)
        taken = time.perf_counter() - began
        rows.append(walk_row(name, model, held_out, result, taken))
        if progress:
            progress(done, len(names))
    return rows


def walk_row(name: str, model: PerformanceModel, truth: Motion, result: Synthesis, seconds: float) -> WalkRow:
    """The figures of one held-out take; ``seconds`` is how long its synthesis took."""
    seams = np.array([piece.start for piece in result.pieces[1:]])
    inside = [accelerations(source.motion) for source in model.sources if not source.mirrored]
    frame_limit = float(np.quantile(np.concatenate([a.max(axis=1) for a in inside]), 0.99))
    joint_limit = float(np.quantile(np.concatenate([a.ravel() for a in inside]), 0.99))
    ours, real = _largest_near(result.motion, seams), _largest_near(truth, seams)
    return WalkRow(
        take=name,
        seconds=truth.duration,
        pieces=len(result.pieces),
        control_cm=100 * control_error(result.motion, model.control_points(truth), truth.fps),
        joint_cm=100 * joint_error(result.motion, truth),
        slide=contact_speed(result.motion, contacts_of(result.annotations)),
        slide_recorded=contact_speed(truth, detect_contacts(truth)),
        seam=ours / frame_limit,
        seam_recorded=real / frame_limit,
        seam_all=ours / joint_limit,
        seam_all_recorded=real / joint_limit,
        times_real_time=truth.duration / seconds,
    )


def _largest_near(motion: Motion, seams: FloatArray) -> float:
    near = near_seams(len(motion), motion.fps, seams)
    return float(accelerations(motion)[near].max()) if near.any() else 0.0
