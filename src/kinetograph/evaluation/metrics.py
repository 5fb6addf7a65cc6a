"""Metrics of motions in SI units: distances, speeds of feet, accelerations, jerk, hands held."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions, role_positions, velocities
from kinetograph.motion import Motion, cut
from kinetograph.post.footskate import contact_mask
from kinetograph.post.torsos import has_torso, overlaps, torso_of
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation


def joint_error(result: Motion, truth: Motion) -> float:
    """Mean distance between the same joints of two motions, over their common frames.

    Parameters
    ----------
    result, truth : Motion
        Of one skeleton and one rate.

    Returns
    -------
    float
        Metres.

    Raises
    ------
    RequestError
        For motions of two skeletons or rates.
    """
    if result.skeleton.names != truth.skeleton.names or result.fps != truth.fps:
        raise RequestError("joint error compares motions of one skeleton and one rate; retarget or resample first")
    frames = min(len(result), len(truth))
    difference = joint_positions(result)[:frames] - joint_positions(truth)[:frames]
    return float(np.linalg.norm(difference, axis=-1).mean())


def control_distances(result: Motion, control: FloatArray, fps: float, clock: FloatArray | None = None) -> FloatArray:
    """Ground distance between the midpoint of the hips and that of control points, at every frame.

    Parameters
    ----------
    result : Motion
    control : ndarray, shape (F, P, 3)
        Control points, metres.
    fps : float
        Rate of the control points, Hz.
    clock : ndarray, shape (F,), optional
        Seconds of the control that frames are at, see `kinetograph.synthesis.Synthesis`; their own where it is empty
        or left out.

    Returns
    -------
    ndarray, shape (F,)
        Metres, at the frames of the result.
    """
    hips = role_positions(result, ("left_hip", "right_hip")).mean(axis=1)
    wanted = control.mean(axis=1)
    at = (np.arange(len(hips)) / result.fps if clock is None or not len(clock) else clock) * fps
    x, z = (np.interp(at, np.arange(len(wanted)), wanted[:, i]) for i in (0, 2))
    return np.asarray(np.hypot(hips[:, 0] - x, hips[:, 2] - z))


def control_error(result: Motion, control: FloatArray, fps: float) -> float:
    """The mean of `control_distances`, in metres."""
    return float(control_distances(result, control, fps).mean())


def contact_speed(motion: Motion, contacts: tuple[Annotation, ...]) -> float:
    """Mean ground speed of feet and toes between frames at both of which they are in contact.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
        When a role touches the ground; the label is the role.

    Returns
    -------
    float
        Metres per second; 0 without contacts.
    """
    speeds = []
    for role in sorted({note.label for note in contacts}):
        mask = contact_mask(contacts, role, len(motion), motion.fps)
        points = role_positions(motion, (role,))[:, 0]
        step = np.diff(points[:, [0, 2]], axis=0) * motion.fps
        speeds.append(np.linalg.norm(step, axis=1)[mask[1:] & mask[:-1]])
    together = np.concatenate(speeds) if speeds else np.zeros(0)
    return float(together.mean()) if len(together) else 0.0


def low_toe_speed(motion: Motion) -> float:
    """Mean ground speed of toes in the lowest 30 % of their heights, in m/s; not a number without toes."""
    roles = [role for role in ("left_toe", "right_toe") if role in motion.skeleton.roles]
    if not roles or len(motion) < 2:
        return float("nan")
    toes = role_positions(motion, roles)
    speed = np.linalg.norm(np.gradient(toes[..., [0, 2]], 1 / motion.fps, axis=0), axis=-1)
    return float(speed[toes[..., 1] <= np.quantile(toes[..., 1], 0.3, axis=0)].mean())


def deepest_overlap(motion: Motion, partner: Motion) -> float:
    """How deep two torsos are in one another at most, in metres; not a number where a skeleton has no torso.

    It is negative where bodies are always apart. The motions have one rate; their common frames count.
    """
    if not (has_torso(motion.skeleton) and has_torso(partner.skeleton)):
        return float("nan")
    frames = min(len(motion), len(partner))
    return float(overlaps(torso_of(cut(motion, 0, frames)), torso_of(cut(partner, 0, frames))).max())


def fastest_low_toe(motion: Motion) -> float:
    """The largest ground speed in m/s of a toe in the lowest 30 % of its heights; 0 for a skeleton without toes."""
    roles = [role for role in ("left_toe", "right_toe") if role in motion.skeleton.roles]
    if not roles:
        return 0.0
    toes = role_positions(motion, roles)
    speeds = np.linalg.norm(velocities(toes[..., [0, 2]], motion.fps), axis=-1)
    return float(speeds[toes[..., 1] <= np.quantile(toes[..., 1], 0.3, axis=0)].max())


def sole_level(motion: Motion, contacts: tuple[Annotation, ...]) -> float:
    """The median height in metres of the lowest planted joint of the feet; 0 without contacts.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
        Labelled with the role.

    Returns
    -------
    float
    """
    roles = sorted({note.label for note in contacts if note.label in motion.skeleton.roles})
    if not roles:
        return 0.0
    masks = np.stack([contact_mask(contacts, role, len(motion), motion.fps) for role in roles], axis=1)
    lowest = np.where(masks, role_positions(motion, roles)[..., 1], np.inf).min(axis=1)
    return float(np.median(lowest[np.isfinite(lowest)])) if np.isfinite(lowest).any() else 0.0


def accelerations(motion: Motion) -> FloatArray:
    """Accelerations of the joints in m/s^2, shape ``(F - 2, J)``, by second differences."""
    return np.asarray(np.linalg.norm(np.diff(joint_positions(motion), n=2, axis=0), axis=-1) * motion.fps**2)


def near_seams(frames: int, fps: float, seams: FloatArray, within: float = 0.2) -> BoolArray:
    """Which of the frames 1 to F - 2 are near a seam.

    Parameters
    ----------
    frames : int
        F.
    fps : float
    seams : ndarray
        Times of the seams, seconds.
    within : float
        Seconds from a seam.

    Returns
    -------
    ndarray of bool, shape (F - 2,)
    """
    times = np.arange(1, frames - 1) / fps
    if len(seams) == 0:
        return np.zeros(len(times), dtype=np.bool_)
    return np.asarray(np.abs(times[:, None] - np.asarray(seams)[None]).min(axis=1) <= within + 1e-9)


def position_errors(joints: FloatArray, truth: FloatArray) -> tuple[float, float]:
    """Mean distances of joints from where they should be.

    Parameters
    ----------
    joints, truth : ndarray, shape (F, J, 3)
        Positions in metres; the first joint is the root.

    Returns
    -------
    absolute : float
        Metres.
    relative : float
        Metres, of positions relative to the root.
    """
    absolute = np.linalg.norm(joints - truth, axis=-1).mean()
    relative = np.linalg.norm((joints - joints[:, :1]) - (truth - truth[:, :1]), axis=-1).mean()
    return float(absolute), float(relative)


def jerk(joints: FloatArray, fps: float) -> float:
    """Mean jerk in m/s^3 of joints ``(F, J, 3)`` at ``fps``, by third differences."""
    return float(np.linalg.norm(np.diff(joints, n=3, axis=0), axis=-1).mean() * fps**3)


def hold_errors(
    joints: FloatArray, truth: FloatArray, partner: Motion, own: Motion, holds: tuple[Annotation, ...]
) -> tuple[FloatArray, FloatArray]:
    """How far held hands are from where they should be, over the N frames and hands held in the recording.

    Parameters
    ----------
    joints, truth : ndarray, shape (F, J, 3)
        Positions of the joints of ``own``, as made and as recorded, metres.
    partner : Motion
    own : Motion
        The recorded motion.
    holds : tuple of Annotation
        The handholds of the recording, labelled ``own hand:partner's hand``, in its seconds.

    Returns
    -------
    gaps : ndarray, shape (N,)
        By how much the distance of the two hands differs from the recorded one, metres.
    places : ndarray, shape (N,)
        How far the hand is from where it was recorded, metres.
    """
    gaps, places = [np.zeros(0)], [np.zeros(0)]
    for label in sorted({note.label for note in holds}):
        mine, theirs = label.split(":")
        held = contact_mask(tuple(n for n in holds if n.label == label), label, len(joints), own.fps)
        hand = own.skeleton.landmark(mine).joint
        other = role_positions(partner, (theirs,))[: len(joints), 0][held]
        made, real = joints[held, hand], truth[held, hand]
        gaps.append(np.abs(np.linalg.norm(made - other, axis=1) - np.linalg.norm(real - other, axis=1)))
        places.append(np.linalg.norm(made - real, axis=1))
    return np.concatenate(gaps), np.concatenate(places)


def fastest_of(speed: Callable[[Motion], float], motions: Iterable[Motion]) -> float:
    """The largest of the speeds of some motions, as ``speed`` measures them; not a number where it is 0."""
    return max((speed(motion) for motion in motions), default=0.0) or float("nan")


def distinct_share(result: Synthesis) -> float:
    """Seconds of recordings that a result uses, each counted once, as a share of the result's own seconds."""
    step = 1 / 30
    used = set()
    for piece in result.pieces:
        ticks = np.arange(round(piece.source_start / step), round(piece.source_stop / step))
        used |= {(piece.take, piece.track, piece.mirrored, int(t)) for t in ticks}
    return len(used) * step / max(result.motion.duration, step)
