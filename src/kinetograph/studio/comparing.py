"""A follower that was made, compared with the recorded one and with the hands of the leader."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import hold_errors, position_errors
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.motion import Motion, cut, resample, sample, unwrapped_headings
from kinetograph.post import contact_mask
from kinetograph.segmentation import HANDS, HoldThresholds
from kinetograph.studio.leading import Leader
from kinetograph.studio.messages import Figure, Lane, Span
from kinetograph.take import Annotation

FACING = np.radians(45.0)
"""By how much a follower may face another way than the recorded one and still be said to face right."""
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
    lane, figures = _hands(made, holds, leader.motion)
    lanes = [lane] if lane.spans else []
    if leader.holds:
        spans = tuple(Span(note.start, note.stop, _said(note.label)) for note in leader.holds)
        lanes.append(Lane("hands recorded", "handholds", spans))
    truth = leader.truth
    if truth is not None and truth.skeleton.names == made.skeleton.names:
        errors = _Errors.of(made, truth)
        lanes.append(Lane("error", "error", values=_thinned(100 * errors.distance, truth.fps), unit="cm"))
        figures = (*errors.figures, *_held(errors, leader, truth), *figures)
    return Comparison(tuple(lanes), figures)


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


def _hands(made: Motion, holds: tuple[Annotation, ...], leader: Motion) -> tuple[Lane, tuple[Figure, ...]]:
    """The lane of the hands that are held, and how many of them meet."""
    if not holds or not _has_hands(made, leader):
        return Lane("hands", "handholds"), ()
    ours = role_positions(made, HANDS)
    theirs = role_positions(sample(leader, np.arange(len(made)) / made.fps, made.fps), HANDS)
    reach = HoldThresholds().distance[1]
    spans, met = [], 0
    for note in sorted(holds, key=lambda note: (note.start, note.label)):
        mine, their = (HANDS.index(role) for role in note.label.split(":"))
        inside = contact_mask((note,), note.label, len(made), made.fps)
        if not inside.any():
            continue
        apart = float(np.median(np.linalg.norm(ours[inside, mine] - theirs[inside, their], axis=-1)))
        meets = apart <= reach
        met += meets
        said = f"the follower's {_hand(mine)} hand and the leader's {_hand(their)} hand, {100 * apart:.0f} cm apart"
        label = _said(note.label) if meets else f"missed: {_said(note.label)}"
        spans.append(Span(note.start, note.stop, label, f"{said}; {'held' if meets else 'not met'}"))
    title = f"Handholds whose wrists are within {100 * reach:.0f} cm, half of the time or more"
    return Lane("hands", "handholds", tuple(spans)), (Figure("hands met", f"{met} of {len(spans)}", title),)


def _has_hands(*motions: Motion) -> bool:
    return all(hand in motion.skeleton.roles for hand in HANDS for motion in motions)


def _hand(index: int) -> str:
    return HANDS[index].removesuffix("_hand")


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
