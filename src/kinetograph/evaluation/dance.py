"""Leave one dance out: each take's leader leads a follower made of the other takes (Hsu 2004, section 6.2)."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.baselines import RATE, Example, frame_by_frame, guide_of_partner
from kinetograph.evaluation.labels import take_errors
from kinetograph.evaluation.leaving_out import Held, Outcome, Run, Without, hold_out, outcome
from kinetograph.evaluation.metrics import (
    contact_speed,
    deepest_overlap,
    distinct_share,
    hold_errors,
    jerk,
    low_toe_speed,
    position_errors,
)
from kinetograph.evaluation.partner_names import Observer
from kinetograph.evaluation.recorded import Recorded, extremes
from kinetograph.evaluation.rows import NOT_A_NUMBER
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.library.fingerprints import of_takes
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, with_settings
from kinetograph.motion import Motion, cut, resample
from kinetograph.post.contacts import contacts_of
from kinetograph.segmentation import detect_contacts, detect_handholds
from kinetograph.take import Annotation, Take

_OF_SEGMENTS = (
    *("slide", "slide_recorded", "toes", "overlap_cm", "overlap_recorded_cm", "turning", "elbows"),
    *("below_cm", "fall", "distinct", "most_used", "times_running"),
    *("segment_errors", "pattern_errors", "seen_errors", "seen_patterns", "seen_transitions", "times_real_time"),
)
"""Figures that frame-by-frame methods do not have."""

COMMONEST = "commonest name"
"""The baseline of names: every unit is called what most units of the other takes are."""


@dataclass(frozen=True)
class DanceRow:
    """One held-out dance, or the mean of all, by one method.

    A figure that a method or a take does not have is not a number.

    Parameters
    ----------
    take, method : str
    joint_cm, relative_cm : float
        Mean distance of the follower's joints from the recorded follower's, in the room and relative to the root.
    hold_median_cm, hold_p95_cm : float
        Where the recording holds hands, by how much the distance of the two hands differs from the recorded one: median
        and 95th percentile.
    place_median_cm : float
        Where the recording holds hands, how far the hand is from where it was recorded.
    slide, slide_recorded : float
        Mean speed of planted feet in m/s, in the result and in the recording.
    toes : float
        Mean ground speed of toes while they are low (`low_toe_speed`), as a multiple of the recorded follower's.
    overlap_cm, overlap_recorded_cm : float
        How deep the torsos of the two dancers are in one another at most; negative where they are always apart.
    jerk : float
        Mean jerk of the joints, as a multiple of the recorded follower's.
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
    seen_errors, seen_patterns, seen_transitions : float
        Shares of the units, of the patterns and of the transitions alone that an `Observer` of the two dancers names
        otherwise than in the recording.
    times_real_time : float
        Duration of the take over the processor time of its synthesis.
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
    toes: float
    overlap_cm: float
    overlap_recorded_cm: float
    jerk: float
    turning: float
    elbows: float
    below_cm: float
    fall: float
    distinct: float
    most_used: float
    times_running: float
    segment_errors: float
    pattern_errors: float
    seen_errors: float
    seen_patterns: float
    seen_transitions: float
    times_real_time: float


def leave_one_dance_out(
    method: PerformanceControl,
    library: Library,
    target: str,
    *,
    baselines: bool = True,
    without: Without = (),
    run: Run | None = None,
) -> list[DanceRow]:
    """Let each take's leader lead a follower made of the other takes (section 6.2).

    The library is fitted once. Takes that cannot be evaluated, such as those whose control is a signal, have no row;
    see `Run`.

    Parameters
    ----------
    method : PerformanceControl
    library : Library
    target : str
        Name of the follower's track.
    baselines : bool
        Whether other methods are compared: the configured one, given which hands the recording holds and when;
        nearest segments without continuity; the commonest name of a unit for all; and the frame-by-frame ones.
    without : collection of str, or mapping of str to collection of str
        Takes that are neither held out nor in the library; or by held-out take those that are not in its library.
    run : Run, optional
        Which takes are held out, and who evaluates them.

    Returns
    -------
    list of DanceRow
        One row per take and method.

    Raises
    ------
    RequestError
        Where no take can be evaluated.
    """
    return hold_out(_dance_rows, Held(library, of_takes(library), method, target, baselines), without, run)


def _dance_rows(held: Held) -> Outcome[DanceRow]:
    return outcome(held, _rows_of)


def _rows_of(held: Held) -> Iterator[DanceRow]:
    target, library, whole = str(held.track), held.library, held.whole
    observer = whole.once("observer", lambda: Observer.of(library, target, held.method.span))
    others = tuple(name for name in whole.usable if name not in held.excluded)
    dance = replace(_Dance.of(held.method, library.take(held.take), target), observer=observer, others=others)
    model = held.model()
    yield _synthesized("segments", model, whole.recorded, dance)
    if held.baselines:
        yield _synthesized("holds given", model, whole.recorded, dance, holds_given=True)
        nearest = PerformanceModel(with_settings(model.fitted, replace(held.method, continuity=0.0)))
        yield _synthesized("nearest segment", nearest, whole.recorded, dance)
        yield from _commonest(library, dance)
        yield from _frame_by_frame(held, dance)


@dataclass(frozen=True, eq=False)
class _Dance:
    """A take of two dancers, both at the follower's rate."""

    take: Take
    target: str
    leader: Motion
    follower: Motion
    observer: Observer | None = None
    others: tuple[str, ...] = ()

    @classmethod
    def of(cls, method: PerformanceControl, take: Take, target: str) -> _Dance:
        follower = take.motion(target)
        recorded = method.control_points.recorded(take, target)
        if not isinstance(recorded, Motion):
            raise RequestError(
                f"take {take.name!r}: expected a character to control {target!r}, found a signal of "
                f"{', '.join(recorded.names[:4])}; evaluation compares partners"
            )
        return cls(take, target, resample(recorded, follower.fps), follower)

    @cached_property
    def holds(self) -> tuple[Annotation, ...]:
        noted = self.take.annotated(self.target, "handhold")
        if noted or len(self.leader) != len(self.follower):
            return noted
        return detect_handholds(self.follower, self.leader, track=self.target)

    def row(self, method: str, joints: FloatArray) -> DanceRow:
        """What can be said of joints ``(F, J, 3)`` alone."""
        truth = joint_positions(self.follower)
        frames = min(len(joints), len(truth))
        absolute, relative = position_errors(joints[:frames], truth[:frames])
        gaps, places = hold_errors(joints[:frames], truth[:frames], self.leader, self.follower, self.holds)
        return DanceRow(
            take=self.take.name,
            method=method,
            joint_cm=100 * absolute,
            relative_cm=100 * relative,
            hold_median_cm=_percent(gaps, 0.5),
            hold_p95_cm=_percent(gaps, 0.95),
            place_median_cm=_percent(places, 0.5),
            jerk=jerk(joints, self.follower.fps) / jerk(truth, self.follower.fps),
            **dict.fromkeys(_OF_SEGMENTS, NOT_A_NUMBER),
        )

    def seen(self, row: DanceRow, made: Iterable[Annotation]) -> DanceRow:
        """A row with the shares of units, patterns and transitions that are named otherwise."""
        if self.observer is None:
            return row
        errors = self.observer.compare(self.take, made)
        return replace(
            row,
            seen_errors=errors.names.segment_rate,
            seen_patterns=errors.names.pattern_rate,
            seen_transitions=errors.transitions.segment_rate,
        )


def _synthesized(
    label: str, model: PerformanceModel, recorded: Recorded, held: _Dance, *, holds_given: bool = False
) -> DanceRow:
    holds = tuple(replace(note, track="control") for note in held.holds) if holds_given else ()
    began = time.process_time()
    result = model.synthesize(Take(held.take.name, {"control": held.leader}, holds))
    taken = time.process_time() - began
    errors = take_errors(held.take, held.target, result.annotations, model.method.span)
    row = replace(
        held.row(label, joint_positions(resample(result.motion, held.follower.fps))),
        slide=contact_speed(result.motion, contacts_of(result.annotations)),
        slide_recorded=contact_speed(held.follower, detect_contacts(held.follower)),
        toes=low_toe_speed(result.motion) / low_toe_speed(held.follower),
        overlap_cm=100 * deepest_overlap(resample(result.motion, held.leader.fps), held.leader),
        overlap_recorded_cm=100 * deepest_overlap(held.follower, held.leader),
        **extremes(result.motion, recorded.of(model.fitted.sources)),
        distinct=distinct_share(result),
        most_used=result.statistics["most_used"],
        times_running=result.statistics["times_running"],
        segment_errors=errors.segment_rate,
        pattern_errors=errors.pattern_rate,
        times_real_time=held.follower.duration / taken,
    )
    return held.seen(row, held.observer.made(held.take, held.leader, result.motion)) if held.observer else row


def _commonest(library: Library, held: _Dance) -> list[DanceRow]:
    """A follower whose every unit has the commonest name, of which nothing else can be said."""
    if held.observer is None or not held.observer.recorded(held.take):
        return []
    figures = {name: NOT_A_NUMBER for name, kind in DanceRow.__annotations__.items() if kind == "float"}
    row = DanceRow(take=held.take.name, method=COMMONEST, **figures)
    return [held.seen(row, held.observer.commonest(library, held.take))]


def _frame_by_frame(held: Held, dance: _Dance) -> list[DanceRow]:
    def example(name: str) -> Example:
        return _example(_Dance.of(held.method, held.library.take(name), dance.target))

    examples = [held.whole.once(name, partial(example, name)) for name in dance.others]
    guide = guide_of_partner(dance.leader)
    return [dance.row(label, answer(guide)) for label, answer in frame_by_frame(examples)]


def _example(dance: _Dance) -> Example:
    leader, follower = (resample(motion, RATE) for motion in (dance.leader, dance.follower))
    frames = min(len(leader), len(follower))
    return guide_of_partner(cut(leader, 0, frames)), joint_positions(follower)[:frames]


def _percent(values: FloatArray, share: float) -> float:
    return 100 * float(np.quantile(values, share)) if len(values) else NOT_A_NUMBER
