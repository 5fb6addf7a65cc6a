"""Names of what two dancers do, found in their motion: stances and transitions (Hsu 2004, section 6.2).

A couple is in one of four stances: *open* or *closed*, apart or in embrace, each of them *crosshand* where they hold
right hands (or, its mirror image, left hands). It goes from one to the next by a *step*, an *inside turn* or an
*outside turn*. The thesis' inside turn goes towards the leader, whose left hand holds the follower's right one, which
is to the follower's left. Here it is every turn to the follower's left, anticlockwise from above, so that a mirror
image exchanges the two. Rotations are in the room: a couple that rotates in embrace turns too, and so does a follower
who walks around the leader.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion, unwrapped_headings
from kinetograph.segmentation.handholds import HANDS, detect_handholds
from kinetograph.take import Annotation

SYMBOLS = {
    "open": "o\N{COMBINING OVERLINE}",
    "closed": "\N{BLACK CIRCLE}\N{COMBINING OVERLINE}",
    "open crosshand": "o\N{COMBINING LOW LINE}",
    "closed crosshand": "\N{BLACK CIRCLE}\N{COMBINING LOW LINE}",
    "step": "\N{RIGHTWARDS ARROW}",
    "inside turn": "\N{CLOCKWISE TOP SEMICIRCLE ARROW}",
    "outside turn": "\N{ANTICLOCKWISE TOP SEMICIRCLE ARROW}",
}
"""The thesis' symbols of stances and transitions."""
_STANCE = "(open|closed)( crosshand)?"
_NAME = re.compile(f"(?P<before>{_STANCE}) (?P<transition>step|inside turn|outside turn) (?P<after>{_STANCE})")
_GRID = 400
"""Values at which a density is looked at between two bounds."""


@dataclass(frozen=True)
class StanceThresholds:
    """What parts one stance from another, and a turn from a step.

    Parameters
    ----------
    distance : float
        Metres between the chests on the ground; a couple that is nearer and faces is in closed stance.
    facing : float
        Radians by which each may face away from the other in closed stance.
    rotation : float
        Radians that a follower rotates by within a unit; more is a turn.
    found : tuple of str
        Those that are gaps in the measures of recordings; the others are as given.
    """

    distance: float = 0.55
    facing: float = np.pi / 3
    rotation: float = np.pi / 2
    found: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Gap:
    """Where the gap of a measure is looked for, and how smoothly."""

    least: float
    greatest: float
    width: float


_GAPS = {
    "distance": _Gap(0.35, 0.75, 0.03),
    "rotation": _Gap(np.radians(45), np.radians(180), np.radians(10)),
}


@dataclass(frozen=True, eq=False)
class Couple:
    """How two dancers stand to each other at some instants.

    Parameters
    ----------
    times : ndarray, shape (N,)
        Seconds.
    distance : ndarray, shape (N,)
        Metres between the chests on the ground, or the roots of skeletons without chest.
    facing : ndarray, shape (N,)
        Radians by which they face away from each other; of the two dancers, the larger.
    heading : ndarray, shape (N,)
        The follower's unwrapped heading, radians.
    crosshand : ndarray of bool, shape (N,)
        Whether a hand holds the partner's of the same side; of holds at once, the closest counts.
    """

    times: FloatArray
    distance: FloatArray
    facing: FloatArray
    heading: FloatArray
    crosshand: BoolArray

    @classmethod
    def of(
        cls, leader: Motion, follower: Motion, times: Sequence[float], holds: Iterable[Annotation] | None = None
    ) -> Couple:
        """Two dancers at some instants.

        Parameters
        ----------
        leader, follower : Motion
            Of one rate and length.
        times : sequence of float
            Seconds.
        holds : iterable of Annotation, optional
            Handholds of the follower, labelled ``follower's hand:leader's hand``; by default they are detected.

        Returns
        -------
        Couple

        Raises
        ------
        RequestError
            If the motions have two rates or lengths.
        """
        held = detect_handholds(follower, leader) if holds is None else tuple(holds)
        at = np.asarray(times, dtype=np.float64)
        frames = np.clip(np.round(at * follower.fps).astype(np.int64), 0, len(follower) - 1)
        headings = [unwrapped_headings(motion)[frames] for motion in (leader, follower)]
        across = _chest(follower)[frames] - _chest(leader)[frames]
        bearing = np.arctan2(across[:, 0], across[:, 2])
        facing = np.maximum(_angle(headings[0] - bearing), _angle(headings[1] - bearing - np.pi))
        crossed = _crossed(held, at, leader, follower) if held else at < 0
        return cls(at, np.hypot(across[:, 0], across[:, 2]), facing, headings[1], crossed)

    def stances(self, thresholds: StanceThresholds) -> list[str]:
        """The stance at every instant."""
        closed = (self.distance < thresholds.distance) & (self.facing < thresholds.facing)
        return [_stance(bool(near), bool(cross)) for near, cross in zip(closed, self.crosshand, strict=True)]

    def names(self, thresholds: StanceThresholds, span: int = 2) -> list[str]:
        """The names of the units from each instant to the one ``span`` later, ``N - span`` of them.

        Parameters
        ----------
        thresholds : StanceThresholds
        span : int
            Intervals that a unit goes on for.

        Returns
        -------
        list of str
            Stance before, transition and stance after: ``"open inside turn closed crosshand"``.
        """
        stances, rotated = self.stances(thresholds), self.rotated(span)
        transitions = np.where(np.abs(rotated) < thresholds.rotation, "step", np.where(rotated > 0, "inside turn", ""))
        return [
            f"{before} {transition or 'outside turn'} {after}"
            for before, transition, after in zip(stances, transitions, stances[span:], strict=False)
        ]

    def rotated(self, span: int) -> FloatArray:
        """Radians that the follower rotates by from each instant to the one ``span`` later, shape ``(N - span,)``."""
        return np.asarray(self.heading[span:] - self.heading[:-span])


def find_thresholds(
    couples: Sequence[Couple], span: int = 2, thresholds: StanceThresholds | None = None
) -> StanceThresholds:
    """Thresholds in the gaps of some recordings' measures.

    A gap is the lowest density between plausible bounds (0.35 to 0.75 m, 45 to 180 degrees), where the density is at
    least half as high again on both sides of it. Distances are those of dancers who face each other; what facing means
    is given.

    Parameters
    ----------
    couples : sequence of Couple
    span : int
        Intervals that a unit goes on for.
    thresholds : StanceThresholds, optional
        Values for measures that have no gap.

    Returns
    -------
    StanceThresholds
    """
    chosen = thresholds or StanceThresholds()
    distances = np.concatenate([couple.distance[couple.facing < chosen.facing] for couple in couples])
    gaps = {
        "distance": _gap(distances, _GAPS["distance"]),
        "rotation": _gap(np.abs(np.concatenate([c.rotated(span) for c in couples])), _GAPS["rotation"]),
    }
    values = {name: gap for name, gap in gaps.items() if gap is not None}
    return replace(chosen, **values, found=tuple(values))


def notation(names: Iterable[str]) -> str:
    """Names of units in the thesis' notation, those that follow one another joined at the stance they share.

    Parameters
    ----------
    names : iterable of str
        As `Couple.names` gives them; another name stands as it is.

    Returns
    -------
    str

    Raises
    ------
    RequestError
        For no name at all.

    Examples
    --------
    >>> notation(["open step closed", "closed inside turn open"]) == "o\\u0305 \\u2192 \\u25cf\\u0305 \\u21b7 o\\u0305"
    True
    """
    parts: list[str] = []
    last = ""
    for name in names:
        match = _NAME.fullmatch(name)
        if match is None:
            parts.append(name)
            last = ""
            continue
        before, transition, after = (SYMBOLS[match[part]] for part in ("before", "transition", "after"))
        parts += [transition, after] if before == last else [before, transition, after]
        last = after
    if not parts:
        raise RequestError("notation needs a name or more, found none")
    return " ".join(parts)


def transition_of(name: str) -> str:
    """The transition in a unit's name as `Couple.names` gives it; another name is given back.

    Examples
    --------
    >>> transition_of("open inside turn closed crosshand")
    'inside turn'
    """
    match = _NAME.fullmatch(name)
    return match["transition"] if match else name


def _stance(closed: bool, crosshand: bool) -> str:
    return ("closed" if closed else "open") + (" crosshand" if crosshand else "")


def _chest(motion: Motion) -> FloatArray:
    return role_positions(motion, ("chest",))[:, 0] if "chest" in motion.skeleton.roles else motion.translation


def _angle(angles: FloatArray) -> FloatArray:
    """The sizes of angles, from 0 to pi."""
    return np.abs((angles + np.pi) % (2 * np.pi) - np.pi)


def _crossed(holds: Iterable[Annotation], at: FloatArray, leader: Motion, follower: Motion) -> BoolArray:
    """At which times ``at`` the hold that counts is of hands of one side: of holds at once, the closest as a whole."""
    own, theirs = (role_positions(motion, HANDS) for motion in (follower, leader))
    closest, crossed = np.full(len(at), np.inf), np.zeros(len(at), dtype=np.bool_)
    for note in holds:
        hands = note.label.split(":")
        if len(hands) != 2 or not set(hands) <= set(HANDS):
            continue
        first, second = (HANDS.index(hand) for hand in hands)
        span = slice(round(note.start * follower.fps), round(note.stop * follower.fps) + 1)
        apart = float(np.median(np.linalg.norm(own[span, first] - theirs[span, second], axis=1)))
        closer = (note.start <= at) & (at <= note.stop) & (apart < closest)
        closest[closer], crossed[closer] = apart, first == second
    return crossed


def _gap(values: FloatArray, where: _Gap) -> float | None:
    """The value of the lowest density between two bounds, or None where values do not fall into two groups there."""
    grid = np.linspace(0.0, max(float(values.max(initial=0.0)), where.greatest) + where.width, _GRID)
    density = np.exp(-0.5 * ((grid[:, None] - values) / where.width) ** 2).sum(axis=1)
    inside = np.flatnonzero((grid >= where.least) & (grid <= where.greatest))
    low = inside[int(np.argmin(density[inside]))]
    peaks = density[:low].max(initial=0.0), density[low + 1 :].max(initial=0.0)
    return float(grid[low]) if min(peaks) >= max(1.5 * density[low], 2.0) else None
