"""How good a result is, measured as the recordings are, and what no recording does.

Two figures are compared with the recordings': how much velocities change from a frame to the next, as a multiple of
what 99 in 100 frames of the recordings there change by at most; and how fast planted feet move, over half a second, as
a multiple of the mean there. A result is worse than the recordings where one is beyond what 999 in 1,000 of their
frames have. What is as recorded is never worse, whatever it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.filters import running_max
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.methods.keyframe.examples import Example
from kinetograph.motion import Motion, cut
from kinetograph.post.footskate import contact_mask
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation

SPAN = 0.5
"""Seconds over which the speed of planted feet is averaged."""
AROUND = 0.4
"""Seconds before and after a piece in which its recording counts too: pieces are blended with what is there."""
LEAST_JUMP, LEAST_SLIDE = 0.05, 0.05
"""Metres per second below which no recording's own figures count: nobody sees these."""
LEAST_MOST = (1.3, 1.5)
"""The least that is taken for the most of both figures: recordings that are all alike say little of others."""
_USUAL, _RARE = 0.99, 0.999


@dataclass(frozen=True, eq=False)
class Ordinary:
    """What is ordinary in recordings.

    Parameters
    ----------
    jump : ndarray, shape (E,)
        The 99th percentile of each example's changes of velocity from a frame to the next, mean over the joints, m/s.
    slide : ndarray, shape (E,)
        Mean speed of each example's planted feet along the ground, m/s.
    most_jump, most_skate : float
        The 99.9th percentiles of all frames' figures, as multiples of their own example's.
    """

    jump: FloatArray
    slide: FloatArray
    most_jump: float
    most_skate: float


@dataclass(frozen=True)
class Quality:
    """How good a result is.

    Parameters
    ----------
    jump, skate : float
        See this module; multiples.
    jump_at, skate_at : float
        Seconds at which they are largest.
    most_jump, most_skate : float
        The recordings' own 99.9th percentiles.
    """

    jump: float
    skate: float
    jump_at: float
    skate_at: float
    most_jump: float
    most_skate: float

    @property
    def good(self) -> bool:
        """Whether nothing is worse than in the recordings."""
        return self.jump <= self.most_jump and self.skate <= self.most_skate

    @property
    def at(self) -> float:
        """Second at which it is worst."""
        return self.jump_at if self.jump / self.most_jump >= self.skate / self.most_skate else self.skate_at

    def words(self) -> str:
        """What is worse than in the recordings, for messages."""
        found = []
        if self.jump > self.most_jump:
            found.append(
                f"velocities jump {self.jump:.2f} x as much as usual, the recordings' at most {self.most_jump:.2f}"
            )
        if self.skate > self.most_skate:
            found.append(
                f"planted feet slide {self.skate:.2f} x as fast as usual, the recordings' at most {self.most_skate:.2f}"
            )
        return " and ".join(found)

    def statistics(self) -> dict[str, float]:
        """The figures as those of a `kinetograph.synthesis.Synthesis`."""
        return {
            "jump": self.jump,
            "jump in recordings": self.most_jump,
            "skate": self.skate,
            "skate in recordings": self.most_skate,
        }


def ordinary_of(examples: Sequence[Example]) -> Ordinary:
    """What is ordinary in some examples."""
    jumps, slides, rare_jumps, rare_slides = [], [], [np.zeros(0)], [np.zeros(0)]
    for example in examples:
        jump = jumps_of(example.motion)
        total, count = _planted(example.motion, example.contacts)
        jumps.append(max(float(np.quantile(jump, _USUAL)), LEAST_JUMP))
        slides.append(max(float(total.sum() / max(count.sum(), 1.0)), LEAST_SLIDE))
        rare_jumps.append(jump / jumps[-1])
        rare_slides.append(_averaged(total, count, example.motion.fps) / slides[-1])
    most = [float(np.quantile(np.concatenate(parts), _RARE)) for parts in (rare_jumps, rare_slides)]
    return Ordinary(np.array(jumps), np.array(slides), max(most[0], LEAST_MOST[0]), max(most[1], LEAST_MOST[1]))


def jumps_of(motion: Motion) -> FloatArray:
    """How much joints' velocities change at every frame, mean over the joints, shape ``(F,)`` m/s."""
    if len(motion) < 3:
        return np.zeros(len(motion))
    change = np.linalg.norm(np.diff(joint_positions(motion), n=2, axis=0), axis=-1).mean(axis=1)
    return np.pad(change * motion.fps, 1, mode="edge")


def slides_of(motion: Motion, contacts: Sequence[Annotation]) -> FloatArray:
    """How fast planted feet move along the ground, mean over half a second, shape ``(F,)`` m/s; 0 where none stands."""
    return _averaged(*_planted(motion, contacts), motion.fps)


def _planted(motion: Motion, contacts: Sequence[Annotation]) -> tuple[FloatArray, FloatArray]:
    """The mean speed of planted points from each frame to the next, and 1 where there are any, ``(F,)`` each."""
    total, count = np.zeros(len(motion)), np.zeros(len(motion))
    for role in sorted({note.label for note in contacts if note.label in motion.skeleton.roles}):
        mask = contact_mask(tuple(contacts), role, len(motion), motion.fps)
        points = role_positions(motion, (role,))[:, 0]
        speed = np.linalg.norm(np.diff(points[:, [0, 2]], axis=0), axis=1) * motion.fps
        both = mask[1:] & mask[:-1]
        total[:-1] += np.where(both, speed, 0.0)
        count[:-1] += both
    return total / np.maximum(count, 1.0), np.minimum(count, 1.0)


def _averaged(total: FloatArray, count: FloatArray, fps: float) -> FloatArray:
    """Means over spans of time, 0 where feet are planted for less than half of one."""
    span = max(round(SPAN * fps), 1)
    window = np.ones(span)
    sums, counts = (np.convolve(values, window)[(span - 1) // 2 :][: len(values)] for values in (total, count))
    return np.asarray(np.where(counts >= 0.5 * span, sums / np.maximum(counts, 1.0), 0.0))


def quality_of(
    motion: Motion,
    contacts: Sequence[Annotation],
    made_of: Sequence[tuple[Piece, int]],
    examples: Sequence[Example],
    ordinary: Ordinary,
) -> Quality:
    """How good a motion is by what it is made of.

    Parameters
    ----------
    motion : Motion
    contacts : sequence of Annotation
    made_of : sequence of (Piece, int)
        The pieces, each with the index of its example.
    examples : sequence of Example
    ordinary : Ordinary
        That of the examples.
    """
    made = {"jump": jumps_of(motion), "skate": slides_of(motion, contacts)}
    usual, recorded = _usual(motion, made_of, ordinary), _recorded(motion, made_of, examples)
    most = {"jump": ordinary.most_jump, "skate": ordinary.most_skate}
    figures = {}
    for name, values in made.items():
        ratio = values / usual[name]
        as_recorded = values <= 1.05 * recorded[name]
        ratio = np.where(as_recorded, np.minimum(ratio, most[name]), ratio)
        worst = int(np.argmax(ratio))
        figures[name] = (float(ratio[worst]), worst / motion.fps)
    (jump, jump_at), (skate, skate_at) = figures["jump"], figures["skate"]
    return Quality(jump, skate, jump_at, skate_at, most["jump"], most["skate"])


def _usual(motion: Motion, made_of: Sequence[tuple[Piece, int]], ordinary: Ordinary) -> Mapping[str, FloatArray]:
    """What is usual around each frame, ``(F,)`` each: of the recordings that are blended there, the larger."""
    times = np.arange(len(motion)) / motion.fps
    usual = {"jump": np.zeros(len(motion)), "skate": np.zeros(len(motion))}
    for piece, example in made_of:
        near = (times >= piece.start - AROUND - 1e-9) & (times <= piece.stop + AROUND + 1e-9)
        usual["jump"][near] = np.maximum(usual["jump"][near], ordinary.jump[example])
        usual["skate"][near] = np.maximum(usual["skate"][near], ordinary.slide[example])
    return usual


def _recorded(
    motion: Motion, made_of: Sequence[tuple[Piece, int]], examples: Sequence[Example]
) -> Mapping[str, FloatArray]:
    """The largest figures of each frame's recording around the frame that it came from, ``(F,)`` each."""
    times, fps = np.arange(len(motion)) / motion.fps, motion.fps
    recorded = {"jump": np.zeros(len(motion)), "skate": np.zeros(len(motion))}
    for piece, owner in made_of:
        example, faster = examples[owner], max(1.0 / piece.stretch, 1.0)
        inside = (times >= piece.start - 1e-9) & (times <= piece.stop + 1e-9)
        source = np.round(piece.source_time(times[inside]) * fps).astype(np.int64)
        low = max(int(source.min(initial=0)) - round(SPAN * fps), 0) if len(source) else 0
        span = cut(example.motion, low, min(int(source.max(initial=0)) + round(SPAN * fps) + 1, len(example.motion)))
        notes = [n for n in example.contacts if n.stop * fps >= low]
        moved = [Annotation(n.track, n.kind, n.label, max(n.start - low / fps, 0.0), n.stop - low / fps) for n in notes]
        at = np.clip(source - low, 0, len(span) - 1)
        jumps = faster**2 * running_max(jumps_of(span), 5)[at]
        slides = faster * running_max(slides_of(span, moved), 5)[at]
        recorded["jump"][inside] = np.maximum(recorded["jump"][inside], jumps)
        recorded["skate"][inside] = np.maximum(recorded["skate"][inside], slides)
    return recorded
