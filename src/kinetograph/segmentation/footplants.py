"""Contacts of the feet with the ground, and the footplants at which a walk is cut (Hsu 2004, section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.take import Annotation

CONTACT_ROLES = ("left_foot", "left_toe", "right_foot", "right_toe")


@dataclass(frozen=True)
class ContactThresholds:
    """When a point of a foot is planted; the second of each pair is looser, which keeps contacts from flickering.

    height: metres above the point's own lowest level, to begin and to stay. speed: metres a second, likewise.
    shortest: seconds; briefer contacts are dropped. gap: seconds; briefer breaks are closed. smooth: seconds over
    which speed is measured.
    """

    height: tuple[float, float] = (0.04, 0.06)
    speed: tuple[float, float] = (0.35, 0.55)
    shortest: float = 0.1
    gap: float = 0.07
    smooth: float = 0.05


def detect_contacts(
    motion: Motion, thresholds: ContactThresholds | None = None, track: str = "motion"
) -> tuple[Annotation, ...]:
    """Contacts of ankles and toes with the ground as annotations of kind ``"contact"``, labelled with the role.

    A skeleton without feet has none.
    """
    thresholds = thresholds or ContactThresholds()
    roles = [role for role in CONTACT_ROLES if role in motion.skeleton.roles]
    found: list[Annotation] = []
    for role, positions in zip(roles, np.moveaxis(role_positions(motion, roles), 1, 0), strict=True):
        for start, stop in intervals(_planted(positions, motion.fps, thresholds)):
            found.append(Annotation(track, "contact", role, start / motion.fps, (stop - 1) / motion.fps))
    return tuple(sorted(found, key=lambda note: (note.start, note.label)))


def footplant_cuts(motion: Motion, contacts: tuple[Annotation, ...], shortest: float = 0.2) -> tuple[float, ...]:
    """Seconds at which a foot is planted, either foot; cuts less than ``shortest`` seconds apart become the first.

    Raises RequestError where no foot is ever planted.
    """
    times = sorted(_plants(contacts, "left") + _plants(contacts, "right"))
    kept: list[float] = []
    for time in times:
        if not kept or time - kept[-1] >= shortest:
            kept.append(time)
    if len(kept) < 2:
        raise RequestError(
            f"found {len(kept)} footplants in {motion.duration:.1f} s, expected 2 or more; "
            "is the ground at the feet's height? cut by fixed length instead (--by fixed)"
        )
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
    planted = np.zeros(len(positions), dtype=np.bool_)
    for start, stop in intervals(stay):
        planted[start:stop] = begin[start:stop].any()
    for start, stop in intervals(~planted):
        if start > 0 and stop < len(planted) and (stop - start) / fps < thresholds.gap:
            planted[start:stop] = True
    for start, stop in intervals(planted):
        if (stop - start) / fps < thresholds.shortest:
            planted[start:stop] = False
    return planted


def intervals(mask: BoolArray) -> list[tuple[int, int]]:
    """Runs of true as half-open intervals of frames."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
