"""Requests that a person has met: keys made of takes that are held out, asked of the others.

Each request is two keys of one take. The first is a whole pose; of the second a part of the body, or the place, is
asked for at the time at which the person was there, so that every request is known to be feasible for a body. It is met
to a millimetre and half a degree by motion that is no worse than recordings are, or refused with the nearest that can
be asked for, which is then asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError, UnmetError
from kinetograph.evaluation.metrics import accelerations
from kinetograph.keys import Key, PartInWorld, key_at
from kinetograph.kinematics import forward
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel, adopt_named, collect_examples
from kinetograph.motion import Motion, cut, heading_at
from kinetograph.post import misses_of_parts
from kinetograph.progress import Progress
from kinetograph.synthesis import Synthesis

PARTS = ("left_hand", "right_hand", "left_foot", "right_foot", "head")
"""Parts of the body that are asked for."""
BETWEEN = (1.0, 4.0)
"""Seconds between the two keys, from and to."""
WINDOW = 0.5
"""Seconds before and after the time asked for, where a window is given."""
NEAR = 0.5
"""Seconds before and after a key in which accelerations are measured."""

Build = Callable[[Motion, float, float, np.random.Generator], Key]
"""The second key of a request, from a take, the second of its pose and when it is to be met."""


@dataclass(frozen=True)
class RequestFigures:
    """What became of requests of one kind.

    Parameters
    ----------
    kind : str
    requests, met : int
    refused : int
        All that are not met.
    nearest : int
        Those refused with the nearest time or place that can be asked for, or with how near a part comes.
    named : int
        Those of them that name a time or place.
    holds : int
        Those of them whose nearest time or place, asked for, is met.
    miss_mm, miss_degrees : float
        The largest miss of what is met.
    worst : float
        The largest jump or skate of what is met, as a share of the recordings' bound; above 1 is worse than recorded.
    acceleration : float
        The largest of a joint near a key, as a multiple of the recordings' 99.9th percentile.
    """

    kind: str
    requests: int
    met: int
    refused: int
    nearest: int
    named: int
    holds: int
    miss_mm: float
    miss_degrees: float
    worst: float
    acceleration: float


def key_requests(
    library: Library,
    count: int,
    *,
    held_out: Sequence[str],
    method: KeyframeControl | None = None,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> list[RequestFigures]:
    """What becomes of random requests that are known to be feasible.

    Parameters
    ----------
    library : Library
    count : int
        How many.
    held_out : sequence of str
        Names of the takes that requests are made of.
    method : KeyframeControl, optional
    rng : numpy.random.Generator, optional
        Draws takes, times and parts; the same ones without it.
    progress : Progress, optional
        Called for every request.

    Returns
    -------
    list of RequestFigures
        One per kind, and one of all.

    Raises
    ------
    RequestError
        Where no held-out take is long enough.
    """
    rng, method = rng or np.random.default_rng(0), method or KeyframeControl()
    names = library.names()
    model = method.fit(library, exclude=held_out)
    kept = tuple(name for name in names if name not in held_out)
    skeleton = model.examples[0].motion.skeleton
    takes = [example.motion for example in collect_examples(library, method.rate, exclude=kept)]
    takes = [adopt_named(take, skeleton, "a held-out take") for take in takes if take.duration > BETWEEN[0] + 0.1]
    if not takes:
        raise RequestError(f"no take of {', '.join(held_out)} is longer than {BETWEEN[0]:g} s, as a request needs")
    usual = float(np.quantile(np.concatenate([accelerations(e.motion).ravel() for e in model.examples]), 0.999))
    outcomes = []
    for number in range(count):
        kind = tuple(KINDS)[number % len(KINDS)]
        outcomes.append((kind, _outcome(model, *_drawn(takes, KINDS[kind], rng), usual)))
        if progress:
            progress(number + 1, count)
    rows = [_figures(kind, [o for k, o in outcomes if k == kind]) for kind in KINDS if count > 0]
    return [*rows, _figures("all", [o for _, o in outcomes])]


def _drawn(takes: Sequence[Motion], build: Build, rng: np.random.Generator) -> tuple[Key, Key]:
    """Two keys of a take."""
    weights = np.array([take.duration - BETWEEN[0] for take in takes])
    take = takes[rng.choice(len(takes), p=weights / weights.sum())]
    lasts = rng.uniform(BETWEEN[0], min(BETWEEN[1], take.duration))
    first = round(rng.uniform(0.0, take.duration - lasts) * take.fps)
    last = min(first + round(lasts * take.fps), len(take) - 1)
    time = (last - first) / take.fps
    return key_at(take, first / take.fps, label="first"), build(take, last / take.fps, time, rng)


def _roles(take: Motion, rng: np.random.Generator, count: int) -> tuple[str, ...]:
    known = [role for role in PARTS if role in take.skeleton.roles]
    return tuple(known[i] for i in sorted(rng.choice(len(known), count, replace=False)))


def _ground(take: Motion, second: float) -> tuple[float, float]:
    x, _, z = take.translation[round(second * take.fps)]
    return float(x), float(z)


def _one_part(take: Motion, second: float, time: float, rng: np.random.Generator) -> Key:
    return key_at(take, second, time=(time, time), roles=_roles(take, rng, 1), label="last")


def _two_parts(take: Motion, second: float, time: float, rng: np.random.Generator) -> Key:
    return key_at(take, second, time=(time, time), roles=_roles(take, rng, 2), label="last")


def _in_world(take: Motion, second: float, time: float, rng: np.random.Generator) -> Key:
    (role,) = _roles(take, rng, 1)
    frame, joint = round(second * take.fps), take.skeleton.landmark(role).joint
    positions, rotations = forward(cut(take, frame, frame + 1))
    x, y, z = (float(v) for v in positions[0, joint])
    q = tuple(float(v) for v in rotations[0, joint])
    part = PartInWorld(role, (x, y, z), (q[0], q[1], q[2], q[3]))
    heading, place = heading_at(take, frame), _ground(take, second)
    key = key_at(take, second, time=(time, time), position=place, heading=heading, roles=(role,), label="last")
    return replace(key, parts=(part,))


def _part_anywhere(take: Motion, second: float, time: float, rng: np.random.Generator) -> Key:
    (role,) = _roles(take, rng, 1)
    frame, joint = round(second * take.fps), take.skeleton.landmark(role).joint
    x, y, z = (float(v) for v in forward(cut(take, frame, frame + 1))[0][0, joint])
    key = key_at(take, second, time=(time, time), roles=(role,), label="last")
    return replace(key, parts=(PartInWorld(role, (x, y, z)),))


def _place(take: Motion, second: float, time: float, rng: np.random.Generator) -> Key:
    return key_at(take, second, time=(time, time), position=_ground(take, second), label="last")


def _place_in_a_window(take: Motion, second: float, time: float, rng: np.random.Generator) -> Key:
    window = (max(time - WINDOW, 0.5), time + WINDOW)
    return key_at(take, second, time=window, position=_ground(take, second), label="last")


KINDS: dict[str, Build] = {
    "one part": _one_part,
    "two parts": _two_parts,
    "part, place and heading": _in_world,
    "part in the world": _part_anywhere,
    "place at a time": _place,
    "place in a window": _place_in_a_window,
}
"""What is asked for."""


@dataclass(frozen=True)
class _Outcome:
    met: bool
    nearest: bool = False
    named: int = 0
    holds: int = 0
    miss_mm: float = 0.0
    miss_degrees: float = 0.0
    worst: float = 0.0
    acceleration: float = 0.0


def _outcome(model: KeyframeModel, first: Key, last: Key, usual: float) -> _Outcome:
    """What becomes of one request."""
    try:
        result = model.synthesize([first, last])
    except UnmetError as error:
        asked = _nearest(last, error)
        holds = sum(1 for key in asked if _is_met(model, first, key))
        return _Outcome(False, True, len(asked), holds)
    except RequestError:
        return _Outcome(False)
    apart, twisted = _misses(result, last)
    figures = result.statistics
    worst = max(figures[name] / figures[f"{name} in recordings"] for name in ("jump", "skate"))
    at = round(result.met[1] * result.motion.fps)
    reach = round(NEAR * result.motion.fps)
    near = accelerations(result.motion)[max(at - reach, 0) : at + reach]
    return _Outcome(True, False, 0, 0, 1000 * apart, float(np.degrees(twisted)), worst, float(near.max()) / usual)


def _nearest(key: Key, error: UnmetError) -> list[Key]:
    """The keys that an error names in place of one."""
    found = []
    if error.time is not None:
        found.append(replace(key, time=(error.time, error.time)))
    if error.position is not None:
        found.append(replace(key, position=error.position))
    return found


def _is_met(model: KeyframeModel, first: Key, key: Key) -> bool:
    try:
        apart, twisted = _misses(model.synthesize([first, key]), key)
    except RequestError:
        return False
    return apart <= 1e-3 and twisted <= np.radians(0.5)


def _misses(result: Synthesis, key: Key) -> tuple[float, float]:
    """Metres and radians by which a result misses its last key, at most."""
    frame = round(result.met[-1] * result.motion.fps)
    pose, own = cut(result.motion, frame, frame + 1), cut(key.clip, key.frame, key.frame + 1)
    apart, twisted = [0.0], [0.0]
    named = {part.role for part in key.parts}
    if roles := tuple(role for role in key.roles or () if role not in named):
        metres, radians = misses_of_parts(pose, own, roles)
        apart, twisted = [*apart, float(metres.max())], [*twisted, float(radians.max())]
    elif key.roles is None:
        metres, _ = misses_of_parts(pose, own, tuple(key.clip.skeleton.roles))
        apart.append(float(metres.max()))
    if key.position is not None:
        apart.append(float(np.hypot(*(pose.translation[0, [0, 2]] - np.array(key.position)))))
    positions, rotations = forward(pose)
    for part in key.parts:
        joint = pose.skeleton.landmark(part.role).joint
        if part.position is not None:
            apart.append(float(np.linalg.norm(positions[0, joint] - np.array(part.position))))
        if part.orientation is not None:
            twisted.append(_angle(rotations[0, joint], np.array(part.orientation)))
    return max(apart), max(twisted)


def _angle(one: FloatArray, other: FloatArray) -> float:
    """Angle between two rotations in radians."""
    return float(2.0 * np.arccos(min(abs(float(one @ other)), 1.0)))


def _figures(kind: str, outcomes: Sequence[_Outcome]) -> RequestFigures:
    met = [outcome for outcome in outcomes if outcome.met]

    def largest(name: str) -> float:
        return max((getattr(outcome, name) for outcome in met), default=float("nan"))

    return RequestFigures(
        kind,
        len(outcomes),
        len(met),
        len(outcomes) - len(met),
        sum(outcome.nearest for outcome in outcomes),
        sum(outcome.named for outcome in outcomes),
        sum(outcome.holds for outcome in outcomes),
        *(largest(name) for name in ("miss_mm", "miss_degrees", "worst", "acceleration")),
    )
