"""Held-out walks: the hips of each take are performed with the other takes as the library (Hsu 2004, section 6.1)."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.baselines import RATE, Example, frame_by_frame, guide_of_path
from kinetograph.evaluation.labels import take_errors
from kinetograph.evaluation.leaving_out import Held, Outcome, Run, Without, hold_out, outcome
from kinetograph.evaluation.metrics import (
    accelerations,
    contact_speed,
    control_error,
    distinct_share,
    jerk,
    low_toe_speed,
    near_seams,
    position_errors,
)
from kinetograph.evaluation.recorded import Recorded, extremes, largest_accelerations
from kinetograph.evaluation.rows import NOT_A_NUMBER, mean_rows
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.library.fingerprints import of_takes
from kinetograph.methods.performance import GroundPath, PerformanceControl, PerformanceModel, points_of, with_settings
from kinetograph.motion import Motion, repeat, resample
from kinetograph.post.contacts import contacts_of
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
    without: Without = (),
    run: Run | None = None,
) -> list[WalkRow]:
    """Perform the hips of each take with the other takes as the library (section 6.1).

    A take that loops is played for 8 s or longer. The library is fitted once. Takes that cannot be evaluated, such as
    those without cuts, have no row; see `Run`.

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
    run : Run, optional
        Which takes are held out, and who evaluates them.

    Returns
    -------
    list of WalkRow
        One row per take and method.

    Raises
    ------
    RequestError
        Where no take can be evaluated.
    """
    return hold_out(_walk_rows, Held(library, of_takes(library), method, track, baselines), without, run)


def _walk_rows(held: Held) -> Outcome[WalkRow]:
    return outcome(held, _rows_of)


def _rows_of(held: Held) -> Iterator[WalkRow]:
    model, take = held.model(), held.library.take(held.take)
    _ = model.fitted.limits  # once for both methods
    yield _synthesized("segments", model, held, take)
    if held.baselines:
        nearest = with_settings(model.fitted, replace(held.method, continuity=0.0))
        yield _synthesized("nearest segment", PerformanceModel(nearest), held, take)
        yield from _frame_by_frame(held, take)


def held_out_motion(take: Take, track: str | None = None) -> Motion:
    """The motion of a take that is performed: as recorded, or a looping clip played for 8 s or longer."""
    motion = take.motion(track)
    loops = any(note.kind == "loop" and take.tracks[note.track] is motion for note in take.annotations)
    return repeat(motion, int(np.ceil(LOOPED / motion.duration))) if loops else motion


def mean_walks(rows: list[WalkRow]) -> list[WalkRow]:
    """The means over the takes, one row per method; pieces and seconds are sums."""
    return mean_rows(rows, summed=("seconds", "pieces"))


def walk_row(
    name: str,
    model: PerformanceModel,
    truth: Motion,
    result: Synthesis,
    seconds: float,
    recorded: Recorded | None = None,
) -> WalkRow:
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
    recorded : Recorded, optional
        What has been measured of recordings before.

    Returns
    -------
    WalkRow
    """
    seams = np.array([piece.start for piece in result.pieces[1:]])
    sources = [source for source in model.fitted.sources if not source.mirrored]
    measured = (recorded or Recorded(sources)).of(sources)
    frame_limit, joint_limit = largest_accelerations(measured)
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
        **extremes(result.motion, measured),
        distinct=distinct_share(result),
        most_used=result.statistics["most_used"],
        times_running=result.statistics["times_running"],
        times_real_time=truth.duration / seconds,
    )


def _synthesized(label: str, model: PerformanceModel, held: Held, take: Take) -> WalkRow:
    truth = held_out_motion(take, held.track)
    began = time.process_time()
    result = model.synthesize(truth)
    row = walk_row(take.name, model, truth, result, time.process_time() - began, held.whole.recorded)
    name, _ = take.named_motion(held.track)
    errors = take_errors(take, name, result.annotations, held.method.span)
    return replace(row, method=label, segment_errors=errors.segment_rate, pattern_errors=errors.pattern_rate)


def _frame_by_frame(held: Held, take: Take) -> list[WalkRow]:
    """The baselines that see a path: they need its left and right point."""
    if not isinstance(held.method.control_points, GroundPath):
        return []
    away, whole = held.excluded, held.whole
    examples = [whole.once(name, partial(_example, held, name)) for name in whole.usable if name not in away]
    truth = held_out_motion(take, held.track)
    guide = guide_of_path(held.method.control_points.points(truth), truth.fps)
    return [_row(take.name, label, answer(guide), truth) for label, answer in frame_by_frame(examples)]


def _example(held: Held, name: str) -> Example:
    motion = resample(held_out_motion(held.library.take(name), held.track), RATE)
    return guide_of_path(held.method.control_points.points(motion), RATE), joint_positions(motion)


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
