"""Handholds: which hand of one dancer holds which hand of the other, from when to when."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.segmentation.footplants import intervals
from kinetograph.take import Annotation

HANDS = ("left_hand", "right_hand")


@dataclass(frozen=True)
class HoldThresholds:
    """When two hands hold each other. distance: metres between the wrists, to begin and to stay: two hands lie between
    them. shortest: seconds; briefer holds are dropped. gap: seconds; briefer breaks are closed.
    """

    distance: tuple[float, float] = (0.24, 0.28)
    shortest: float = 0.3
    gap: float = 0.15


def detect_handholds(
    own: Motion, partner: Motion, thresholds: HoldThresholds | None = None, track: str = "motion"
) -> tuple[Annotation, ...]:
    """Handholds as annotations of kind ``"handhold"`` on ``track``, labelled ``own hand:partner's hand``.

    Found by distance alone, so that hands which pass one another slowly may be taken for a hold: look them over
    (library annotate --export). Raises RequestError for motions of two rates or lengths; characters without hands
    have none.
    """
    thresholds = thresholds or HoldThresholds()
    if own.fps != partner.fps or len(own) != len(partner):
        raise RequestError("handholds need two motions of one rate and length; resample one first")
    if not all(hand in m.skeleton.roles for hand in HANDS for m in (own, partner)):
        return ()
    ours, theirs = role_positions(own, HANDS), role_positions(partner, HANDS)
    found = []
    for i, j in itertools.product(range(2), repeat=2):
        distance = np.linalg.norm(ours[:, i] - theirs[:, j], axis=1)
        held = distance < thresholds.distance[1]
        for start, stop in intervals(held):
            held[start:stop] = (distance[start:stop] < thresholds.distance[0]).any()
        for start, stop in intervals(~held):
            if start > 0 and stop < len(held) and (stop - start) / own.fps < thresholds.gap:
                held[start:stop] = True
        for start, stop in intervals(held):
            if (stop - start) / own.fps >= thresholds.shortest:
                label = f"{HANDS[i]}:{HANDS[j]}"
                found.append(Annotation(track, "handhold", label, start / own.fps, (stop - 1) / own.fps))
    return tuple(sorted(found, key=lambda note: (note.start, note.label)))
