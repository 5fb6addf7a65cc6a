"""Held-out in-betweening by LAFAN1's protocol (Harvey et al. 2020): ten past frames, a gap, the first frame after it.

L2Q and L2P are means over frames of the Euclidean distance of all joints' world quaternions and of their normalised
world positions; NPSS compares power spectra over time. All three are taken over the gap's frames only. Windows are
placed so that their last past frame stands over the origin and faces along z.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.plausibility import below_recordings, fastest_fall
from kinetograph.kinematics import forward, joint_positions, on_ground
from kinetograph.motion import Motion, concatenate, cut, heading_at, transform

PAST = 10
"""Frames of a window before its gap."""
STRIDE = 40
"""Frames from one window to the next."""
Filler = Callable[[Motion, int], Motion]
"""Given a window and the gap's frames (it may look at `PAST` frames and the last one), the whole window filled."""


@dataclass(frozen=True)
class Score:
    """Figures of one method at one gap; lower is better.

    Parameters
    ----------
    npss, l2q, l2p : float
        See this module.
    windows : int
        How many were scored.
    refused : int
        How many of them the method refused; these are filled by interpolation.
    below_cm : float
        How far a point of the body is below the floor, and below where it is lowest in the true windows, at most.
    fall : float
        The fastest fall of the centre of mass, as a multiple of free fall.
    """

    npss: float
    l2q: float
    l2p: float
    windows: int
    refused: int = 0
    below_cm: float = 0.0
    fall: float = 0.0


def windows_of(motion: Motion, gap: int, stride: int = STRIDE) -> list[Motion]:
    """Windows of `PAST` frames, a gap and one more frame, every ``stride`` frames; see this module for their place."""
    length = PAST + gap + 1
    return [_centred(cut(motion, low, low + length)) for low in range(0, len(motion) - length + 1, stride)]


def _centred(window: Motion) -> Motion:
    rotation = rot.about("y", -heading_at(window, PAST - 1))
    shift = -on_ground(rot.rotate(rotation, window.translation[PAST - 1]))
    return transform(window, rotation, shift)


def zero_velocity(window: Motion, gap: int) -> Motion:
    """The baseline that holds the last past pose."""
    return _with_gap(window, gap, np.zeros(gap))


def interpolation(window: Motion, gap: int) -> Motion:
    """The baseline that goes evenly from the last past pose to the pose after the gap."""
    return _with_gap(window, gap, np.arange(1, gap + 1) / (gap + 1))


def _with_gap(window: Motion, gap: int, u: FloatArray) -> Motion:
    inside = slice(PAST, PAST + gap)
    a, b = PAST - 1, PAST + gap
    root, rotations = window.translation.copy(), window.rotations.copy()
    root[inside] = (1 - u)[:, None] * root[a] + u[:, None] * root[b]
    rotations[inside] = rot.slerp(window.rotations[a], window.rotations[b], u[:, None])
    return replace(window, translation=root, rotations=rotations)


def position_scale(motions: Sequence[Motion], gap: int) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation, each of shape ``(J, 3)`` metres, of the training windows' joints.

    Raises
    ------
    RequestError
        Where no motion is as long as a window.
    """
    windows = [w for motion in motions for w in windows_of(motion, gap)]
    if not windows:
        raise RequestError(f"no training clip is as long as a window of {PAST + gap + 1} frames")
    points = np.concatenate([joint_positions(w) for w in windows])
    return points.mean(axis=0), np.maximum(points.std(axis=0), 1e-3)


def score(filler: Filler, windows: Sequence[Motion], gap: int, scale: tuple[FloatArray, FloatArray]) -> Score:
    """A method's figures over windows.

    Parameters
    ----------
    filler : callable
        The method; windows that it refuses with a RequestError are filled by interpolation.
    windows : sequence of Motion
    gap : int
        Frames.
    scale : tuple of ndarray, shape (J, 3)
        See `position_scale`.
    """
    truths, guesses, refused = [], [], 0
    for window in windows:
        try:
            filled = filler(window, gap)
        except RequestError:
            filled, refused = interpolation(window, gap), refused + 1
        truths.append(window)
        guesses.append(filled)
    truth, guess = (_world(motions, gap) for motions in (truths, guesses))
    spread = [(points - scale[0]) / scale[1] for points in (truth[0], guess[0])]
    return Score(
        npss=npss(truth[1], guess[1]),
        l2q=_l2(truth[1], guess[1]),
        l2p=_l2(*(s.reshape(*s.shape[:2], -1) for s in spread)),
        windows=len(truths),
        refused=refused,
        below_cm=100 * below_recordings(concatenate(guesses), truths),
        fall=max(map(fastest_fall, guesses), default=0.0),
    )


def _world(motions: list[Motion], gap: int) -> tuple[FloatArray, FloatArray]:
    """World positions ``(W, gap, J, 3)`` and quaternions ``(W, gap, 4 J)``, without jumps of sign from the past on."""
    points, rotations = zip(*(forward(m) for m in motions), strict=True)
    inside = slice(PAST, PAST + gap)
    first = np.stack(rotations)
    first = np.where(first[:, :1, :, :1] < 0, -first, first)
    q = rot.unroll(first, axis=1)[:, inside]
    return np.stack(points)[:, inside], q.reshape(*q.shape[:2], -1)


def _l2(truth: FloatArray, guess: FloatArray) -> float:
    return float(np.linalg.norm(truth - guess, axis=-1).mean())


def npss(truth: FloatArray, guess: FloatArray) -> float:
    """Normalised power spectrum similarity (Gopalakrishnan et al. 2019); 0 is the same.

    Parameters
    ----------
    truth, guess : ndarray, shape (W, T, D)
        Signals.

    Notes
    -----
    The earth mover's distance between the two spectra of each signal, weighted by the true one's power. As in LAFAN1's
    own code the power is that of the real parts.

    Examples
    --------
    >>> wave = np.sin(np.linspace(0, 6, 30))[None, :, None]
    >>> npss(wave, wave)
    0.0
    """
    powers = [np.square(np.real(np.fft.fft(x, axis=1))) for x in (truth, guess)]
    totals = [p.sum(axis=1) for p in powers]
    shares = [p / np.maximum(t, 1e-12)[:, None] for p, t in zip(powers, totals, strict=True)]
    moved = np.abs(np.cumsum(shares[0], axis=1) - np.cumsum(shares[1], axis=1)).sum(axis=1)
    return float(np.average(moved, weights=totals[0])) if totals[0].sum() > 0 else 0.0
