"""Handholds: which hand of one dancer holds which hand of the other, from when to when."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.segmentation.intervals import runs, with_hysteresis
from kinetograph.take import Annotation

HANDS = ("left_hand", "right_hand")
"""The roles that can hold each other."""


@dataclass(frozen=True)
class HoldThresholds:
    """When two hands hold each other.

    Parameters
    ----------
    distance : tuple of float, (begin, stay)
        Metres between the wrists at which a hold begins, and up to which it stays; two hands lie between them.
    shortest : float
        Seconds; briefer holds are dropped.
    gap : float
        Seconds; briefer breaks are closed.
    """

    distance: tuple[float, float] = (0.24, 0.28)
    shortest: float = 0.3
    gap: float = 0.15


def detect_handholds(
    own: Motion, partner: Motion, thresholds: HoldThresholds | None = None, track: str = "motion"
) -> tuple[Annotation, ...]:
    """Handholds of two dancers, detected by distance alone.

    Hands that pass one another slowly may be taken for a hold: look the annotations over (``library annotate
    --export``).

    Parameters
    ----------
    own, partner : Motion
        Of one rate and length.
    thresholds : HoldThresholds, optional
    track : str
        The track of ``own``.

    Returns
    -------
    tuple of Annotation
        Of kind ``"handhold"``, labelled ``own hand:partner's hand``; none for characters without hands.

    Raises
    ------
    RequestError
        If the motions have two rates or lengths.
    """
    thresholds = thresholds or HoldThresholds()
    if own.fps != partner.fps or len(own) != len(partner):
        raise RequestError("handholds need two motions of one rate and length; resample one first")
    if not all(hand in m.skeleton.roles for hand in HANDS for m in (own, partner)):
        return ()
    ours, theirs = role_positions(own, HANDS), role_positions(partner, HANDS)
    holds = []
    for i, j in itertools.product(range(2), repeat=2):
        distance = np.linalg.norm(ours[:, i] - theirs[:, j], axis=1)
        begin, stay = (distance < limit for limit in thresholds.distance)
        label = f"{HANDS[i]}:{HANDS[j]}"
        for start, stop in runs(with_hysteresis(begin, stay, own.fps, thresholds.shortest, thresholds.gap)):
            holds.append(Annotation(track, "handhold", label, start / own.fps, (stop - 1) / own.fps))
    return tuple(sorted(holds, key=lambda note: (note.start, note.label)))
