"""A follower that was made, compared with the recorded one and with the hands of the leader."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import hold_errors, position_errors
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.motion import Motion, cut, resample, sample, unwrapped_headings
from kinetograph.post import contact_mask
from kinetograph.segmentation import HANDS, HoldThresholds
from kinetograph.studio.duet.leading import Leader
from kinetograph.studio.messages import Figure, Lane, Span
from kinetograph.take import Annotation

FACING = np.radians(45.0)
"""By how much a follower may face another way than the recorded one and still be said to face right."""
REACH = HoldThresholds().distance[1]
"""Metres between the wrists up to which hands are taken to hold each other."""
_RATE = 30.0  # values of a lane per second


@dataclass(frozen=True, eq=False)
class Comparison:
    """What a person sees of how well a follower follows.

    Parameters
    ----------
    lanes : tuple of Lane
    figures : tuple of Figure
    """

    lanes: tuple[Lane, ...] = ()
    figures: tuple[Figure, ...] = ()


@dataclass(frozen=True)
class Hold:
    """A handhold of a follower and a leader.

    Parameters
    ----------
    note : Annotation
        When.
    own, theirs : str
        The roles of the follower's hand and of the leader's.
    apart : float
        Metres between the wrists, in the median.
    """

    note: Annotation
    own: str
    theirs: str
    apart: float

    @property
    def met(self) -> bool:
        """Whether they are as near as hands that hold each other."""
        return self.apart <= REACH

    @property
    def span(self) -> Span:
        """As a lane shows it."""
        own, theirs = (role.removesuffix("_hand") for role in (self.own, self.theirs))
        said = f"the follower's {own} hand and the leader's {theirs} hand, {100 * self.apart:.0f} cm apart"
        label = _said(self.note.label)
        if self.met:
            return Span(self.note.start, self.note.stop, label, f"{said}; held")
        return Span(self.note.start, self.note.stop, f"missed: {label}", f"{said}; not met")


def compared(made: Motion, holds: tuple[Annotation, ...], leader: Leader) -> Comparison:
    """A follower compared with what is known.

    Parameters
    ----------
    made : Motion
    holds : tuple of Annotation
        The handholds of the motion that was made.
    leader : Leader

    Returns
    -------
    Comparison
    """
    found = measured(made, holds, leader.motion)
    figures = _met(found)
    lanes = _lanes("hand", {hold.note: hold.span for hold in found})
    lanes += _lanes("recorded", {note: Span(note.start, note.stop, _said(note.label)) for note in leader.holds})
    truth = leader.truth
    if truth is not None and truth.skeleton.names == made.skeleton.names:
        errors = _Errors.of(made, truth)
        lanes.append(Lane("error", "error", values=_thinned(100 * errors.distance, truth.fps), unit="cm"))
        figures = (*errors.figures, *_held(errors, leader, truth), *figures)
    return Comparison(tuple(lanes), figures)


def held_by_others(holds: tuple[Annotation, ...], leader: Leader) -> tuple[Annotation, ...]:
    """The handholds of the leader, with the follower made and the recorded one, and those of the recorded one.

    Parameters
    ----------
    holds : tuple of Annotation
        Of the follower that was made, labelled ``own hand:partner's hand``.
    leader : Leader
    """
    of_leader = [replace(note, track="leader", label=_turned(note.label)) for note in (*holds, *leader.holds)]
    return (*of_leader, *(replace(note, track="truth") for note in leader.holds if leader.truth is not None))


def _turned(label: str) -> str:
    """A handhold as the partner sees it.

    >>> _turned("left_hand:right_hand")
    'right_hand:left_hand'
    """
    own, _, theirs = label.partition(":")
    return f"{theirs}:{own}"


@dataclass(frozen=True, eq=False)
class _Errors:
    """Joints made and recorded, ``(F, J, 3)`` at the recorded rate, and how often the body faces as recorded."""

    joints: FloatArray
    recorded: FloatArray
    facing: float

    @classmethod
    def of(cls, made: Motion, truth: Motion) -> _Errors:
        made = resample(made, truth.fps)
        frames = min(len(made), len(truth))
        away = unwrapped_headings(cut(made, 0, frames)) - unwrapped_headings(cut(truth, 0, frames))
        facing = float((np.abs(np.angle(np.exp(1j * away))) <= FACING).mean())
        return cls(joint_positions(made)[:frames], joint_positions(truth)[:frames], facing)

    @property
    def distance(self) -> FloatArray:
        """The mean distance of the joints at each frame, metres."""
        return np.asarray(np.linalg.norm(self.joints - self.recorded, axis=-1).mean(axis=-1))

    @property
    def figures(self) -> tuple[Figure, ...]:
        absolute, relative = position_errors(self.joints, self.recorded)
        title = f"Mean distance of joints from the recorded follower's; {100 * relative:.1f} cm relative to the root"
        degrees = f"{np.degrees(FACING):.0f} degrees"
        return (
            Figure("from the recording", f"{100 * absolute:.1f} cm", title),
            Figure("facing right", f"{100 * self.facing:.0f} %", f"Frames that face as recorded, within {degrees}"),
        )


def _held(errors: _Errors, leader: Leader, truth: Motion) -> tuple[Figure, ...]:
    """How far apart hands are that the recording holds, against there."""
    if not leader.holds or not _has_hands(leader.motion, truth):
        return ()
    partner = resample(leader.motion, truth.fps)
    frames = min(len(errors.joints), len(partner))
    gaps, _ = hold_errors(errors.joints[:frames], errors.recorded[:frames], partner, truth, leader.holds)
    if not len(gaps):
        return ()
    worst = 100 * float(np.quantile(gaps, 0.95))
    title = f"By how much the distance of hands held differs from the recorded one: median; p95 {worst:.1f} cm"
    return (Figure("handholds", f"{100 * float(np.median(gaps)):.1f} cm", title),)


def measured(made: Motion, holds: tuple[Annotation, ...], leader: Motion) -> list[Hold]:
    """The handholds of a follower and a leader in the order of time, and how far apart the hands are.

    Parameters
    ----------
    made : Motion
    holds : tuple of Annotation
        Labelled ``own hand:partner's hand``.
    leader : Motion

    Returns
    -------
    list of Hold
        None of bodies without hands.
    """
    if not holds or not _has_hands(made, leader):
        return []
    ours = role_positions(made, HANDS)
    theirs = role_positions(sample(leader, np.arange(len(made)) / made.fps, made.fps), HANDS)
    found = []
    for note in sorted(holds, key=lambda note: (note.start, note.label)):
        mine, their = (HANDS.index(role) for role in note.label.split(":"))
        inside = contact_mask((note,), note.label, len(made), made.fps)
        if inside.any():
            gaps = np.linalg.norm(ours[inside, mine] - theirs[inside, their], axis=-1)
            found.append(Hold(note, HANDS[mine], HANDS[their], float(np.median(gaps))))
    return found


def _lanes(name: str, spans: Mapping[Annotation, Span]) -> list[Lane]:
    """A lane for the handholds of each hand of the follower."""
    lanes = []
    for hand in HANDS:
        held = tuple(span for note, span in spans.items() if note.label.startswith(f"{hand}:"))
        if held:
            lanes.append(Lane(f"{hand.removesuffix('_hand')} {name}", "handholds", held))
    return lanes


def _met(holds: list[Hold]) -> tuple[Figure, ...]:
    """How many handholds meet."""
    if not holds:
        return ()
    title = f"Handholds whose wrists are within {100 * REACH:.0f} cm, half of the time or more"
    return (Figure("hands met", f"{sum(hold.met for hold in holds)} of {len(holds)}", title),)


def _has_hands(*motions: Motion) -> bool:
    return all(hand in motion.skeleton.roles for hand in HANDS for motion in motions)


def _said(label: str) -> str:
    """``left_hand:right_hand`` as a person reads it.

    >>> _said("left_hand:right_hand")
    'left in right'
    """
    mine, _, theirs = label.partition(":")
    return f"{mine.removesuffix('_hand')} in {theirs.removesuffix('_hand')}"


def _thinned(values: FloatArray, fps: float) -> tuple[float, ...]:
    """Values at ``fps``, at 30 Hz or less, from the first to the last."""
    count = min(len(values), max(round((len(values) - 1) / fps * _RATE) + 1, 2))
    at = np.linspace(0, len(values) - 1, count)
    return tuple(np.round(np.interp(at, np.arange(len(values)), values), 3).tolist())
