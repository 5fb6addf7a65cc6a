"""How well a body is steered: sticks that are the same for all, and what an animator and a player see."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, ComplexArray, FloatArray
from kinetograph.evaluation.metrics import accelerations
from kinetograph.kinematics import role_positions
from kinetograph.methods.performance.steering import Steering
from kinetograph.methods.performance.steering_frames import smoothed_track
from kinetograph.methods.performance.wishes import nearest_angle
from kinetograph.motion import Motion
from kinetograph.post.foot_lock import planted_roles

FPS = 60.0
"""Frames per second at which bodies are steered."""
SPEED = 1.0
"""Metres per second of a stick that is pushed."""
REACHED = 0.9
"""Share of a turn, a stop or a start after which it is reached."""


@dataclass(frozen=True, eq=False)
class StickScript:
    """A stick over time, and where its answer is timed.

    Parameters
    ----------
    name : str
    velocity : ndarray of complex, shape (F,)
        Metres per second, ``z + i x``.
    events : tuple of (str, int)
        What happens, ``90``, ``180``, ``stop`` or ``go``, and at which frame.
    """

    name: str
    velocity: ComplexArray
    events: tuple[tuple[str, int], ...] = ()


def sticks(seed: int, seconds: float = 60.0) -> tuple[StickScript, ...]:
    """Five sticks: wander, stop and go, turns of 90 and of 180 degrees, and circles.

    Parameters
    ----------
    seed : int
        Draws directions, speeds and times.
    seconds : float
        Of each.
    """
    rng = np.random.default_rng(seed)
    frames = round(seconds * FPS)
    wander, _ = _held(rng, frames, (1.0, 3.0), lambda _: _pushed(rng.uniform(0.3, 1.1), rng.uniform(-np.pi, np.pi)))
    start = rng.uniform(-np.pi, np.pi)
    go, when = _held(rng, frames, (2.5, 3.5), lambda k: _pushed(SPEED, start) if k % 2 == 0 else 0j)
    stops = tuple(("stop" if k % 2 else "go", f) for k, f in enumerate(when))
    made = [StickScript("wander", wander), StickScript("stop and go", go, stops[1:])]
    for degrees in (90, 180):
        angles = np.cumsum(np.append(start, rng.choice((-1, 1), 60) * np.deg2rad(degrees)))
        turns, when = _held(rng, frames, (3.0, 4.0), lambda k, a=angles: _pushed(SPEED, a[k]))  # type: ignore[misc]
        made.append(StickScript(f"turns of {degrees}", turns, tuple((str(degrees), f) for f in when[1:])))
    rates, _ = _held(rng, frames, (4.0, 8.0), lambda _: complex(rng.choice((-1, 1)) * rng.uniform(0.4, 1.2)))
    made.append(StickScript("circles", SPEED * np.exp(1j * (start + np.cumsum(rates.real) / FPS))))
    return tuple(made)


def _pushed(speed: float, direction: float) -> complex:
    return complex(speed * np.exp(1j * direction))


def _held(
    rng: np.random.Generator, frames: int, span: tuple[float, float], draw: Callable[[int], complex]
) -> tuple[ComplexArray, list[int]]:
    """Values that are each held for some seconds, and the frames at which they begin."""
    values, begins = np.empty(frames, dtype=np.complex128), []
    at = k = 0
    while at < frames:
        stop = at + round(rng.uniform(*span) * FPS)
        values[at:stop] = draw(k)
        begins.append(at)
        at, k = stop, k + 1
    return values, begins


@dataclass(frozen=True, eq=False)
class Steered:
    """What came of a stick.

    Parameters
    ----------
    stick : StickScript
    motion : Motion
    path : ndarray of complex, shape (F,)
        The wished path.
    planted : ndarray of bool, shape (F, R)
        Which of `kinetograph.post.planted_roles` are in contact in what plays.
    jumps : int
    taken : ndarray, shape (F,)
        Seconds of the processor that each step took.
    """

    stick: StickScript
    motion: Motion
    path: ComplexArray
    planted: BoolArray
    jumps: int
    taken: FloatArray


def steer_by(steering: Steering, stick: StickScript) -> Steered:
    """Steer a body by a stick, from its first frame to its last."""
    frames = len(stick.velocity)
    translation, rotations = np.empty((frames, 3)), np.empty((frames, len(steering.frames.repertoire.skeleton), 4))
    path, planted, taken = np.empty(frames, dtype=np.complex128), [], np.empty(frames)
    for frame, v in enumerate(stick.velocity):
        began = time.thread_time()
        pose = steering.step((v.imag, v.real), None, 1 / FPS)
        taken[frame] = time.thread_time() - began
        translation[frame], rotations[frame], path[frame] = *pose, steering.path.place
        planted.append(steering.planted)
    motion = Motion(steering.frames.repertoire.skeleton, translation, rotations, FPS)
    return Steered(stick, motion, path, np.array(planted), steering.jumps, taken)


@dataclass(frozen=True)
class SteeringScores:
    """What is measured of steered bodies.

    Parameters
    ----------
    path : float
        Mean distance of the root from the wished path on the ground, metres.
    quarter, half, stop, go : float
        Mean seconds until a turn of 90 or 180 degrees, a stop or a start is reached, to ``REACHED`` of it.
    toe : float
        Mean ground speed of planted toes, metres per second.
    acceleration : float
        99.9th percentile of the joints' accelerations, m/s^2.
    jumps : float
        Per second.
    mean_ms, p99_ms : float
        Milliseconds of the processor that a step takes.
    """

    path: float
    quarter: float
    half: float
    stop: float
    go: float
    toe: float
    acceleration: float
    jumps: float
    mean_ms: float
    p99_ms: float


def score_steering(results: Sequence[Steered]) -> SteeringScores:
    """The scores of some sticks together."""
    distances = [np.abs(_root(r.motion) - r.path) for r in results]
    waits: dict[str, list[float]] = {"90": [], "180": [], "stop": [], "go": []}
    for result in results:
        for kind, wait in responses(result):
            waits[kind].append(wait)
    quarter, half, stop, go = (float(np.mean(w)) if w else np.nan for w in waits.values())
    taken = np.concatenate([r.taken for r in results]) * 1e3
    return SteeringScores(
        float(np.mean(np.concatenate(distances))),
        *(quarter, half, stop, go),
        float(np.mean(np.concatenate([toe_speeds(r) for r in results]))),
        float(np.quantile(np.concatenate([accelerations(r.motion).ravel() for r in results]), 0.999)),
        sum(r.jumps for r in results) * FPS / sum(len(r.path) for r in results),
        float(taken.mean()),
        float(np.quantile(taken, 0.99)),
    )


def toe_speeds(result: Steered) -> FloatArray:
    """Ground speeds of toes between frames at both of which they are planted in what plays, metres per second."""
    roles = planted_roles(result.motion.skeleton)
    toes = [i for i, role in enumerate(roles) if role.endswith("toe")]
    if not toes:
        return np.zeros(1)
    points = role_positions(result.motion, [roles[i] for i in toes])[..., [0, 2]]
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=-1) * FPS
    return np.asarray(speeds[(result.planted[1:] & result.planted[:-1])[:, toes]])


def responses(result: Steered) -> list[tuple[str, float]]:
    """What the stick asked for, and the seconds until it was reached; until the next event where it was not."""
    place, facing = smoothed_track(result.motion)
    speed = np.abs(np.gradient(place)) * FPS
    waits = []
    frames = [f for _, f in result.stick.events] + [len(place)]
    for (kind, frame), until in zip(result.stick.events, frames[1:], strict=True):
        if until - frame < 2 * FPS:
            continue
        span = slice(frame, until)
        if kind == "stop":
            there = speed[span] < (1 - REACHED) * SPEED
        elif kind == "go":
            there = speed[span] > REACHED * SPEED
        else:
            wanted = float(np.angle(result.stick.velocity[frame]))
            off = np.array([abs(nearest_angle(a - wanted)) for a in facing[span]])
            there = off < (1 - REACHED) * np.deg2rad(float(kind))
        waits.append((kind, (int(np.argmax(there)) if there.any() else until - frame) / FPS))
    return waits


def _root(motion: Motion) -> ComplexArray:
    return np.asarray(motion.translation[:, 2] + 1j * motion.translation[:, 0])
