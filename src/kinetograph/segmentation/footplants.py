"""Contacts of the feet with the ground, and the footplants at which a walk is cut (Hsu 2004, section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.segmentation.intervals import runs, with_hysteresis
from kinetograph.segmentation.uncut import UncutError, why_uncut
from kinetograph.take import Annotation

CONTACT_ROLES = ("left_foot", "left_toe", "right_foot", "right_toe")
"""The points of the feet whose contacts are detected."""


@dataclass(frozen=True)
class ContactThresholds:
    """When a point of a foot is planted; the second of each pair is looser, which keeps contacts from flickering.

    Parameters
    ----------
    height : tuple of float, (begin, stay)
        Metres above the point's own lowest level.
    speed : tuple of float, (begin, stay)
        Metres per second.
    shortest : float
        Seconds; briefer contacts are dropped.
    gap : float
        Seconds; briefer breaks are closed.
    smooth : float
        Seconds over which speed is measured.
    """

    height: tuple[float, float] = (0.04, 0.06)
    speed: tuple[float, float] = (0.35, 0.55)
    shortest: float = 0.1
    gap: float = 0.07
    smooth: float = 0.05


def detect_contacts(
    motion: Motion, thresholds: ContactThresholds | None = None, track: str = "motion"
) -> tuple[Annotation, ...]:
    """Contacts of ankles and toes with the ground.

    Parameters
    ----------
    motion : Motion
    thresholds : ContactThresholds, optional
    track : str
        The track of the motion.

    Returns
    -------
    tuple of Annotation
        Of kind ``"contact"``, labelled with the role; none for a skeleton without feet.
    """
    thresholds = thresholds or ContactThresholds()
    roles = [role for role in CONTACT_ROLES if role in motion.skeleton.roles]
    contacts: list[Annotation] = []
    for role, positions in zip(roles, np.moveaxis(role_positions(motion, roles), 1, 0), strict=True):
        for start, stop in runs(_planted(positions, motion.fps, thresholds)):
            contacts.append(Annotation(track, "contact", role, start / motion.fps, (stop - 1) / motion.fps))
    return tuple(sorted(contacts, key=lambda note: (note.start, note.label)))


def footplant_cuts(motion: Motion, contacts: tuple[Annotation, ...], shortest: float = 0.2) -> tuple[float, ...]:
    """Times at which either foot is planted.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
        See `detect_contacts`.
    shortest : float
        Seconds between cuts; of cuts that are closer, the first is kept.

    Returns
    -------
    tuple of float
        Seconds.

    Raises
    ------
    UncutError
        If there are fewer than two.
    """
    times = sorted(_plants(contacts, "left") + _plants(contacts, "right"))
    kept: list[float] = []
    for time in times:
        if not kept or time - kept[-1] >= shortest:
            kept.append(time)
    if len(kept) < 2:
        why = why_uncut(motion, contacts)
        found = f"found {len(kept)} footplant{'s' if len(kept) != 1 else ''} in {motion.duration:.1f} s"
        raise UncutError(f"{found}, expected 2 or more; {why}; cut by fixed length instead (--by fixed)", why)
    return tuple(kept)


def _plants(contacts: tuple[Annotation, ...], side: str) -> list[float]:
    """Starts of the intervals during which ankle or toe of one side is planted."""
    spans = sorted((note.start, note.stop) for note in contacts if note.label.startswith(side))
    starts: list[float] = []
    reach = -np.inf
    for start, stop in spans:
        if start > reach + 0.05 and start > 0:
            starts.append(start)
        reach = max(reach, stop)
    return starts


def _planted(positions: FloatArray, fps: float, thresholds: ContactThresholds) -> BoolArray:
    """Whether a point, shape ``(F, 3)``, is planted, with hysteresis in height and speed."""
    height = positions[:, 1] - np.quantile(positions[:, 1], 0.02)
    half = max(round(thresholds.smooth * fps / 2), 1)
    frames = np.arange(len(positions))
    ahead, behind = np.minimum(frames + half, len(frames) - 1), np.maximum(frames - half, 0)
    span = np.maximum(ahead - behind, 1)[:, None]
    speed = np.linalg.norm((positions[ahead] - positions[behind]) / span * fps, axis=1)
    begin = (height < thresholds.height[0]) & (speed < thresholds.speed[0])
    stay = (height < thresholds.height[1]) & (speed < thresholds.speed[1])
    return with_hysteresis(begin, stay, fps, thresholds.shortest, thresholds.gap)
