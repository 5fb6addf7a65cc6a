"""Held-out walks: the hips of each take are performed with the other takes as the library (Hsu 2004, section 6.1)."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.baselines import FRAME_BY_FRAME, RATE, Example, guide_of_path
from kinetograph.evaluation.labels import take_errors
from kinetograph.evaluation.metrics import (
    accelerations,
    contact_speed,
    control_error,
    distinct_share,
    fastest_of,
    jerk,
    low_toe_speed,
    near_seams,
    position_errors,
)
from kinetograph.evaluation.plausibility import below_recordings, fall_ratio
from kinetograph.evaluation.rows import NOT_A_NUMBER, mean_rows
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.methods.performance import GroundPath, PerformanceControl, PerformanceModel, points_of
from kinetograph.motion import Motion, repeat, resample
from kinetograph.post.contacts import contacts_of
from kinetograph.post.elbows import elbow_speed
from kinetograph.post.turning import turning_speed
from kinetograph.progress import Progress
from kinetograph.segmentation import detect_contacts
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take

LOOPED = 8.0
"""Seconds for which a held-out clip that loops is played: one cycle is too short a control."""

_OF_SEGMENTS = (
    *("control_cm", "slide", "slide_recorded", "toes", "distinct", "most_used", "times_running"),
    *("segment_errors", "pattern_errors", "times_real_time"),
    *("seam", "seam_recorded", "seam_all", "seam_all_recorded", "turning", "elbows", "below_cm", "fall"),
)
"""Figures that frame-by-frame methods do not have."""


@dataclass(frozen=True)
class WalkRow:
    """One held-out take, whose hips were the control, by one method.

    A figure that a method or a take does not have is not a number. Frame-by-frame baselines stand on the control by
    construction.

    Parameters
    ----------
    take, method : str
    seconds : float
        Duration of the take.
    pieces : int
        Pieces of the result.
    control_cm : float
        Mean ground distance of the hips from the control.
    joint_cm, relative_cm : float
        Mean distance of the joints from those of the real performance, in the room and relative to the root.
    slide, slide_recorded : float
        Mean speed of planted feet in m/s, in the result and in the real performance.
    toes : float
        Mean ground speed of toes while they are low (`low_toe_speed`), as a multiple of the real performance's.
    jerk : float
        Mean jerk of the joints, as a multiple of the real performance's.
    seam, seam_recorded : float
        The largest joint acceleration within 0.2 s of a seam, of the result and of the real performance at the same
        instants, as a multiple of a limit: the 99th percentile, inside the library's segments, of each frame's largest
        joint acceleration.
    seam_all, seam_all_recorded : float
        The same as multiples of the 99th percentile of all joints' accelerations.
    turning, elbows : float
        The fastest turn of the body and the fastest bend of an elbow, as multiples of the recordings' fastest.
    below_cm : float
        How far a point of the body is below the floor, and below where it is lowest in the recordings, at most.
    fall : float
        The fastest fall of the centre of mass, as a multiple of the recordings' fastest, or of free fall if that is
        faster.
    distinct : float
        Seconds of recordings used, as a share of the seconds made.
    most_used, times_running : float
        The share of the pieces that the one used most often has, and how many times running one or a pair of them is
        used.
    segment_errors, pattern_errors : float
        Shares of the labelled segments, and of the patterns they make up, that are another move (`label_errors`).
    times_real_time : float
        Duration of the take over the processor time of its synthesis.
    """

    take: str
    method: str
    seconds: float
    pieces: int
    control_cm: float
    joint_cm: float
    relative_cm: float
    slide: float
    slide_recorded: float
    toes: float
    jerk: float
    seam: float
    seam_recorded: float
    seam_all: float
    seam_all_recorded: float
    turning: float
    elbows: float
    below_cm: float
    fall: float
    distinct: float
    most_used: float
    times_running: float
    segment_errors: float
    pattern_errors: float
    times_real_time: float


def leave_one_take_out(
    method: PerformanceControl,
    library: Library,
    *,
    track: str | None = None,
    baselines: bool = False,
    without: Collection[str] | Mapping[str, Collection[str]] = (),
    progress: Progress | None = None,
) -> list[WalkRow]:
    """Perform the hips of each take with the other takes as the library (section 6.1).

    A take that loops is played for 8 s or longer.

    Parameters
    ----------
    method : PerformanceControl
    library : Library
    track : str, optional
        Name of the track to make, where takes have several motions.
    baselines : bool
        Whether simpler methods are compared: nearest segments without continuity, and frame-by-frame ones.
    without : collection of str, or mapping of str to collection of str
        Takes that are neither held out nor in the library; or by held-out take those that are not in its library.
    progress : Progress, optional
        Called with the takes done and their number.

    Returns
    -------
    list of WalkRow
        One row per take and method.
    """
    rows = []
    names = [name for name in library.names() if isinstance(without, Mapping) or name not in without]
    for done, name in enumerate(names, start=1):
        held = _Held(library, library.take(name), track, left_out_for(without, name))
        rows.append(_synthesized("segments", method, held))
        if baselines:
            rows.append(_synthesized("nearest segment", replace(method, continuity=0.0), held))
            rows += _frame_by_frame(method, held)
        if progress:
            progress(done, len(names))
    return rows


def left_out_for(without: Collection[str] | Mapping[str, Collection[str]], name: str) -> tuple[str, ...]:
    """The takes that are not in the library of a held-out take."""
    return tuple(without.get(name, ()) if isinstance(without, Mapping) else without)


def held_out_motion(take: Take, track: str | None = None) -> Motion:
    """The motion of a take that is performed: as recorded, or a looping clip played for 8 s or longer."""
    motion = take.motion(track)
    loops = any(note.kind == "loop" and take.tracks[note.track] is motion for note in take.annotations)
    return repeat(motion, int(np.ceil(LOOPED / motion.duration))) if loops else motion


def mean_walks(rows: list[WalkRow]) -> list[WalkRow]:
    """The means over the takes, one row per method; pieces and seconds are sums."""
    return mean_rows(rows, summed=("seconds", "pieces"))


def walk_row(name: str, model: PerformanceModel, truth: Motion, result: Synthesis, seconds: float) -> WalkRow:
    """The figures of one held-out take.

    Parameters
    ----------
    name : str
        Name of the take.
    model : PerformanceModel
        Fitted to the other takes.
    truth : Motion
        The real performance.
    result : Synthesis
    seconds : float
        How long the synthesis took.

    Returns
    -------
    WalkRow
    """
    seams = np.array([piece.start for piece in result.pieces[1:]])
    sources = [source.motion for source in model.fitted.sources if not source.mirrored]
    inside = [accelerations(motion) for motion in sources]
    frame_limit = float(np.quantile(np.concatenate([a.max(axis=1) for a in inside]), 0.99))
    joint_limit = float(np.quantile(np.concatenate([a.ravel() for a in inside]), 0.99))
    ours, real = _largest_near(result.motion, seams), _largest_near(truth, seams)
    return replace(
        _row(name, "segments", joint_positions(resample(result.motion, truth.fps)), truth),
        control_cm=100 * control_error(result.motion, points_of(model.method, truth), truth.fps),
        pieces=len(result.pieces),
        slide=contact_speed(result.motion, contacts_of(result.annotations)),
        slide_recorded=contact_speed(truth, detect_contacts(truth)),
        toes=low_toe_speed(result.motion) / low_toe_speed(truth),
        seam=ours / frame_limit,
        seam_recorded=real / frame_limit,
        seam_all=ours / joint_limit,
        seam_all_recorded=real / joint_limit,
        turning=turning_speed(result.motion) / fastest_of(turning_speed, sources),
        elbows=elbow_speed(result.motion) / fastest_of(elbow_speed, sources),
        below_cm=100 * below_recordings(result.motion, sources),
        fall=fall_ratio(result.motion, sources),
        distinct=distinct_share(result),
        most_used=result.statistics["most_used"],
        times_running=result.statistics["times_running"],
        times_real_time=truth.duration / seconds,
    )


@dataclass(frozen=True, eq=False)
class _Held:
    """A take that is held out of a library, with others that are not used at all."""

    library: Library
    take: Take
    track: str | None
    without: tuple[str, ...]

    @property
    def excluded(self) -> tuple[str, ...]:
        return (self.take.name, *self.without)


def _synthesized(label: str, method: PerformanceControl, held: _Held) -> WalkRow:
    take, track = held.take, held.track
    model = method.fit(held.library, exclude=held.excluded, track=track)
    truth = held_out_motion(take, track)
    began = time.process_time()
    result = model.synthesize(truth)
    row = walk_row(take.name, model, truth, result, time.process_time() - began)
    name, _ = take.named_motion(track)
    errors = take_errors(take, name, result.annotations, method.span)
    return replace(row, method=label, segment_errors=errors.segment_rate, pattern_errors=errors.pattern_rate)


def _frame_by_frame(method: PerformanceControl, held: _Held) -> list[WalkRow]:
    """The baselines that see a path: they need its left and right point."""
    if not isinstance(method.control_points, GroundPath):
        return []
    others = [held.library.take(name) for name in held.library.names() if name not in held.excluded]
    examples = [_example(method, other, held.track) for other in others]
    truth = held_out_motion(held.take, held.track)
    guide = guide_of_path(method.control_points.points(truth), truth.fps)
    return [_row(held.take.name, label, fit(examples)(guide), truth) for label, fit in FRAME_BY_FRAME]


def _example(method: PerformanceControl, take: Take, track: str | None) -> Example:
    motion = resample(held_out_motion(take, track), RATE)
    return guide_of_path(method.control_points.points(motion), RATE), joint_positions(motion)


def _row(name: str, method: str, joints: FloatArray, truth: Motion) -> WalkRow:
    """What can be said of joints ``(F, J, 3)`` alone, at the rate of the truth."""
    real = joint_positions(truth)
    frames = min(len(joints), len(real))
    absolute, relative = position_errors(joints[:frames], real[:frames])
    return WalkRow(
        take=name,
        method=method,
        seconds=truth.duration,
        pieces=0,
        joint_cm=100 * absolute,
        relative_cm=100 * relative,
        jerk=jerk(joints, truth.fps) / jerk(real, truth.fps),
        **dict.fromkeys(_OF_SEGMENTS, NOT_A_NUMBER),
    )


def _largest_near(motion: Motion, seams: FloatArray) -> float:
    near = near_seams(len(motion), motion.fps, seams)
    return float(accelerations(motion)[near].max()) if near.any() else 0.0
