"""Scores of sensor control: errors of poses, jitter, and the time of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.evaluation.metrics import contact_speed, fastest_low_toe, sole_level
from kinetograph.kinematics import joint_positions
from kinetograph.methods.sensor import without_heading
from kinetograph.motion import Motion
from kinetograph.post import floor_height
from kinetograph.segmentation import detect_contacts
from kinetograph.take import Annotation

_FEET = ("slide_cm_s", "recorded_cm_s", "low_toe_cm_s", "sole_cm")
_AVERAGED = ("angle", "rms", "position_cm", "jitter", "p50_ms", "p99_ms", *_FEET)


@dataclass(frozen=True)
class SensorRow:
    """One method on one held-out take, or the mean over several.

    Parameters
    ----------
    method, group : str
    takes, frames : int
    angle : float
        Mean geodesic error over joints and frames in degrees, without the root's heading.
    rms : float
        The thesis' normalised RMS (7.1), over components of pose quaternions.
    position_cm : float
        Mean joint distance with the root at the origin.
    jitter : float
        Mean joint acceleration over the source's, likewise.
    p50_ms, p99_ms : float
        Processor time of a frame: median and 99 %.
    slide_cm_s, recorded_cm_s : float
        Mean ground speed of planted feet, as made and as recorded; not a number for poses without a root.
    low_toe_cm_s : float
        Largest ground speed of a toe in the lowest 30 % of its heights.
    sole_cm : float
        How far the lowest toe is over the recorded one, in the median over frames with planted feet: characters would
        float or sink by that.
    take, person : str
        The held-out take, and who moves in it; empty in means.
    """

    method: str
    group: str
    takes: int
    frames: int
    angle: float
    rms: float
    position_cm: float
    jitter: float
    p50_ms: float
    p99_ms: float
    slide_cm_s: float = float("nan")
    recorded_cm_s: float = float("nan")
    low_toe_cm_s: float = float("nan")
    sole_cm: float = float("nan")
    take: str = ""
    person: str = ""


def pose_errors(result: FloatArray, truth: FloatArray) -> FloatArray:
    """Geodesic errors in degrees, shape ``(F, J)``, of rotations ``(F, J, 4)``, without the root's heading."""
    return np.degrees(rot.angle_between(without_heading(result), without_heading(truth)))


def normalised_rms(result: FloatArray, truth: FloatArray, joints: IntArray | None = None) -> float:
    """Equation 7.1 over quaternion components, averaged over frames.

    The thesis converts quaternions to joint angles first and gives degrees per joint, but it says neither in which
    order the angles are nor what n is. Components of unit quaternions on one side of the sphere need neither.

    Parameters
    ----------
    result, truth : ndarray, shape (F, J, 4)
    joints : ndarray of int, optional
        Those that are compared; all by default.

    Returns
    -------
    float
    """
    which = slice(None) if joints is None else joints
    a, b = without_heading(result)[:, which], without_heading(truth)[:, which]
    b = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -b, b)
    return float(np.sqrt(np.mean((a - b) ** 2, axis=(1, 2))).mean())


def rooted_positions(motion: Motion, rotations: FloatArray) -> FloatArray:
    """Joint positions, shape ``(F, J, 3)`` metres, with the root at the origin and facing ahead."""
    still = Motion(motion.skeleton, np.zeros((len(rotations), 3)), without_heading(rotations), motion.fps)
    return joint_positions(still)


def score(
    method: str,
    group: str,
    result: FloatArray,
    truth: Motion,
    times: Sequence[float] = (),
    joints: IntArray | None = None,
) -> tuple[SensorRow, FloatArray]:
    """Compare a result with the held-out motion.

    Parameters
    ----------
    method, group : str
        Names for the row.
    result : ndarray, shape (F, J, 4)
    truth : Motion
    times : sequence of float
        Seconds that each frame took.
    joints : ndarray of int, optional
        Those that are compared; all by default.

    Returns
    -------
    row : SensorRow
    by_joint : ndarray, shape (J,)
        Mean error of each joint in degrees.
    """
    frames = min(len(result), len(truth))
    result, real = result[:frames], truth.rotations[:frames]
    which = slice(None) if joints is None else joints
    errors = pose_errors(result, real)[:, which]
    ours, theirs = (rooted_positions(truth, rotations)[:, which] for rotations in (result, real))
    p50, p99 = np.quantile(times, [0.5, 0.99]) * 1e3 if len(times) else (np.nan, np.nan)
    row = SensorRow(
        method,
        group,
        1,
        frames,
        float(errors.mean()),
        normalised_rms(result, real, joints),
        100 * float(np.linalg.norm(ours - theirs, axis=-1).mean()),
        over_source(ours, theirs),
        float(p50),
        float(p99),
    )
    return row, errors.mean(axis=0)


def with_feet(row: SensorRow, result: Motion, contacts: tuple[Annotation, ...], truth: Motion) -> SensorRow:
    """A row with what the feet of a result do.

    Parameters
    ----------
    row : SensorRow
    result : Motion
    contacts : tuple of Annotation
        Of its feet.
    truth : Motion

    Returns
    -------
    SensorRow
    """
    recorded = detect_contacts(truth)
    made = 100 * sole_level(result, contacts)
    return replace(
        row,
        slide_cm_s=100 * contact_speed(result, contacts),
        recorded_cm_s=100 * contact_speed(truth, recorded),
        low_toe_cm_s=100 * fastest_low_toe(result),
        sole_cm=made - 100 * (sole_level(truth, recorded) - floor_height(truth, recorded)),
    )


def over_source(ours: FloatArray, theirs: FloatArray) -> float:
    """The jitter of positions ``(F, J, 3)``: their mean acceleration over the source's."""
    return _acceleration(ours) / max(_acceleration(theirs), 1e-12)


def _acceleration(positions: FloatArray) -> float:
    """Mean size of second differences."""
    return float(np.linalg.norm(np.diff(positions, n=2, axis=0), axis=-1).mean())


def averaged(rows: Sequence[SensorRow], group: str) -> SensorRow:
    """The mean over takes of one method's rows, as a row of a group."""
    means: dict[str, Any] = {name: float(np.mean([getattr(row, name) for row in rows])) for name in _AVERAGED}
    frames = sum(row.frames for row in rows)
    return replace(rows[0], group=group, takes=len(rows), frames=frames, take="", person="", **means)
