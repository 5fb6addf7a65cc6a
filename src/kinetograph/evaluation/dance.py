"""Leave one dance out: each take's leader leads a follower made of the other takes (Hsu 2004, section 6.2)."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.baselines import FRAME_BY_FRAME, RATE, Example, guide_of_partner
from kinetograph.evaluation.labels import NOT_A_NUMBER, take_errors
from kinetograph.evaluation.metrics import (
    contact_speed,
    distinct_share,
    hold_errors,
    jerk,
    mean_figures,
    position_errors,
)
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl
from kinetograph.motion import Motion, cut, resample
from kinetograph.post.contacts import contacts_of
from kinetograph.progress import Progress
from kinetograph.segmentation import detect_contacts, detect_handholds
from kinetograph.take import Annotation, Take


@dataclass(frozen=True)
class DanceRow:
    """One held-out dance, or the mean of all, by one method.

    joint_cm, relative_cm: mean distance of the follower's joints from the recorded follower's, in the room and
    relative to the root. hold_median_cm, hold_p95_cm: where the recording holds hands, how much further the hand is
    from the leader's than it was recorded; place_median_cm: how far it is from where it was recorded. slide: mean
    speed of planted feet in m/s. jerk: mean of the joints' jerk over the recorded follower's. distinct: seconds of
    recording used over seconds made. segment_errors, pattern_errors: shares of the labelled segments, and of the
    patterns they make up, that are another move (`label_errors`). A measure that a method or a take has none of is
    not a number.
    """

    take: str
    method: str
    joint_cm: float
    relative_cm: float
    hold_median_cm: float
    hold_p95_cm: float
    place_median_cm: float
    slide: float
    slide_recorded: float
    jerk: float
    distinct: float
    segment_errors: float
    pattern_errors: float
    times_real_time: float


def leave_one_dance_out(
    method: PerformanceControl,
    library: Library,
    target: str,
    *,
    baselines: bool = True,
    progress: Progress | None = None,
) -> list[DanceRow]:
    """A row for each take and method: the configured one, and the baselines.

    These are the configured one told which hands the recording holds, and when, which it does not know otherwise;
    nearest segments without continuity; and the frame-by-frame ones.
    """
    rows, names = [], library.names()
    for done, name in enumerate(names, start=1):
        take = library.take(name)
        rows.append(_synthesized("segments", method, library, take, target))
        if baselines:
            rows.append(_synthesized("holds told", method, library, take, target, told=True))
            rows.append(_synthesized("nearest segment", replace(method, continuity=0.0), library, take, target))
            rows += _frame_by_frame(method, library, take, target)
        if progress:
            progress(done, len(names))
    return rows


def mean_rows(rows: list[DanceRow]) -> list[DanceRow]:
    """The means over the takes, a row for each method."""
    means = []
    for method in dict.fromkeys(row.method for row in rows):
        mine = [row for row in rows if row.method == method]
        values = mean_figures(mine)
        means.append(DanceRow(take="mean", method=method, **values))
    return means


def _dancers(method: PerformanceControl, take: Take, target: str) -> tuple[Motion, Motion]:
    follower = take.motion(target)
    recorded = method.control_points.recorded(take, target)
    if not isinstance(recorded, Motion):
        raise RequestError(
            f"take {take.name!r}: expected a character to control {target!r}, found a signal of "
            f"{', '.join(recorded.names[:4])}; evaluation compares partners"
        )
    return resample(recorded, follower.fps), follower


def _synthesized(
    label: str, method: PerformanceControl, library: Library, take: Take, target: str, *, told: bool = False
) -> DanceRow:
    model = method.fit(library, exclude=(take.name,), track=target)
    leader, follower = _dancers(method, take, target)
    holds = tuple(replace(n, track="control") for n in _holds(take, target, leader, follower)) if told else ()
    began = time.perf_counter()
    result = model.synthesize(Take(take.name, {"control": leader}, holds))
    taken = time.perf_counter() - began
    row = _row(take.name, label, joint_positions(resample(result.motion, follower.fps)), leader, follower, take, target)
    errors = take_errors(take, target, result.annotations, method.span)
    return replace(
        row,
        slide=contact_speed(result.motion, contacts_of(result.annotations)),
        slide_recorded=contact_speed(follower, detect_contacts(follower)),
        distinct=distinct_share(result),
        segment_errors=errors.segment_rate,
        pattern_errors=errors.pattern_rate,
        times_real_time=follower.duration / taken,
    )


def _frame_by_frame(method: PerformanceControl, library: Library, take: Take, target: str) -> list[DanceRow]:
    examples = [_example(method, library.take(name), target) for name in library.names() if name != take.name]
    leader, follower = _dancers(method, take, target)
    return [
        _row(take.name, label, fit(examples)(guide_of_partner(leader)), leader, follower, take, target)
        for label, fit in FRAME_BY_FRAME
    ]


def _example(method: PerformanceControl, take: Take, target: str) -> Example:
    leader, follower = (resample(motion, RATE) for motion in _dancers(method, take, target))
    frames = min(len(leader), len(follower))
    return guide_of_partner(cut(leader, 0, frames)), joint_positions(follower)[:frames]


def _row(
    take: str, method: str, joints: FloatArray, leader: Motion, follower: Motion, held_out: Take, target: str
) -> DanceRow:
    truth = joint_positions(follower)
    frames = min(len(joints), len(truth))
    absolute, relative = position_errors(joints[:frames], truth[:frames])
    holds = _holds(held_out, target, leader, follower)
    gaps, places = hold_errors(joints[:frames], truth[:frames], leader, follower, holds)
    return DanceRow(
        take=take,
        method=method,
        joint_cm=100 * absolute,
        relative_cm=100 * relative,
        hold_median_cm=_percent(gaps, 0.5),
        hold_p95_cm=_percent(gaps, 0.95),
        place_median_cm=_percent(places, 0.5),
        slide=NOT_A_NUMBER,
        slide_recorded=NOT_A_NUMBER,
        jerk=jerk(joints, follower.fps) / jerk(truth, follower.fps),
        distinct=NOT_A_NUMBER,
        segment_errors=NOT_A_NUMBER,
        pattern_errors=NOT_A_NUMBER,
        times_real_time=NOT_A_NUMBER,
    )


def _holds(take: Take, target: str, leader: Motion, follower: Motion) -> tuple[Annotation, ...]:
    noted = take.annotated(target, "handhold")
    frames = min(len(leader), len(follower))
    if noted or frames < max(len(leader), len(follower)):
        return noted
    return detect_handholds(follower, leader, track=target)


def _percent(values: FloatArray, share: float) -> float:
    return 100 * float(np.quantile(values, share)) if len(values) else NOT_A_NUMBER
