"""Held-out evaluation of sensor control: whole takes are left out, never random frames.

Frames of one take that are neighbours in time are nearly the same; a split at random tests on what it was trained on.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor_baselines import BASELINES, baseline
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.methods.sensor.examples import Examples, build_examples, collect_motions
from kinetograph.methods.sensor.model import SYNTHESES, SensorControl, SensorModel, fit_examples
from kinetograph.methods.sensor.pose_space import without_heading
from kinetograph.motion import Motion, cut, resample
from kinetograph.progress import Progress
from kinetograph.sensing.layout import Layout, keep
from kinetograph.sensing.readings import Readings, rows_of
from kinetograph.sensing.uniform import uniform
from kinetograph.sensing.virtual import simulate_kinds

Motions = dict[tuple[str, str], Motion]


@dataclass(frozen=True)
class SensorRow:
    """One method on one held-out take, or the mean over several.

    angle: mean geodesic error over joints and frames in degrees, the root's heading left out. rms: the thesis'
    normalised RMS (7.1), over pose quaternions' components. position_cm: mean joint distance with the root at the
    origin. jitter: mean joint acceleration over the source's, likewise. p50_ms, p99_ms: processor
    time of a frame.
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


def pose_errors(result: FloatArray, truth: FloatArray) -> FloatArray:
    """Geodesic errors in degrees, shape ``(F, J)``, of rotations ``(F, J, 4)``, the root's heading left out."""
    return np.degrees(rot.angle_between(without_heading(result), without_heading(truth)))


def normalised_rms(result: FloatArray, truth: FloatArray) -> float:
    """Equation 7.1 over quaternion components, averaged over frames.

    The thesis says that quaternions are turned into joint angles first and gives values of degrees a joint, but neither
    the order of the angles nor what n is; components of unit quaternions on one side of the sphere need neither.
    """
    a, b = without_heading(result), without_heading(truth)
    b = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -b, b)
    return float(np.sqrt(np.mean((a - b) ** 2, axis=(1, 2))).mean())


def rooted_positions(motion: Motion, rotations: FloatArray) -> FloatArray:
    """Joint positions, shape ``(F, J, 3)`` metres, with the root at the origin and facing ahead."""
    still = Motion(motion.skeleton, np.zeros((len(rotations), 3)), without_heading(rotations), motion.fps)
    return joint_positions(still)


def score(
    method: str, group: str, result: FloatArray, truth: Motion, times: Sequence[float] = ()
) -> tuple[SensorRow, FloatArray]:
    """The figures of rotations ``(F, J, 4)`` and the mean error of each joint in degrees."""
    frames = min(len(result), len(truth))
    result, real = result[:frames], truth.rotations[:frames]
    errors = pose_errors(result, real)
    ours, theirs = rooted_positions(truth, result), rooted_positions(truth, real)
    p50, p99 = np.quantile(times, [0.5, 0.99]) * 1e3 if len(times) else (np.nan, np.nan)
    row = SensorRow(
        method,
        group,
        1,
        frames,
        float(errors.mean()),
        normalised_rms(result, real),
        100 * float(np.linalg.norm(ours - theirs, axis=-1).mean()),
        _shake(ours) / max(_shake(theirs), 1e-12),
        float(p50),
        float(p99),
    )
    return row, errors.mean(axis=0)


def _shake(positions: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(positions, n=2, axis=0), axis=-1).mean())


def timed(
    model: SensorModel, readings: Readings, clock: Callable[[], float] = time.thread_time
) -> tuple[FloatArray, list[float]]:
    """Rotations ``(F, J, 4)`` of a live run, fed a frame's readings at a time, and the seconds that each took.

    Seconds are of this thread's processor time, in which what else a machine is busy with does not count, unless
    another clock is given.
    """
    live = model.start()
    times = []
    bounds = np.searchsorted(
        readings.times, np.arange(1, int(readings.duration * model.method.rate) + 2) / model.method.rate
    )
    low = 0
    for high in bounds:
        rows = slice(low, int(high))
        part = rows_of(readings, rows)
        began = clock()
        live.step(part)
        times.append(clock() - began)
        low = int(high)
    return live.finish().motion.rotations, times


@dataclass(frozen=True, eq=False)
class Fold:
    """A held-out motion at the method's rate, its group, and examples of all others."""

    take: str
    group: str
    truth: Motion
    examples: Examples


def folds(library: Library, method: SensorControl, groups: Mapping[str, str] | None, track: str | None,
          only: Sequence[str] = ()) -> list[Callable[[], Fold]]:  # fmt: skip
    """A fold a take, built when called; a library of one take is cut into five blocks with gaps of a second."""
    motions = collect_motions(library, (), track)
    if len(motions) == 1:
        motions = blocks(*next(iter(motions.items())))
    return folds_of(motions, method, groups, only)


def folds_of(motions: Motions, method: SensorControl, groups: Mapping[str, str] | None = None,
             only: Sequence[str] = ()) -> list[Callable[[], Fold]]:  # fmt: skip
    """A fold for each of several motions of one skeleton, built when called."""
    made = []
    for key in motions:
        if only and key[0] not in only:
            continue
        made.append(_fold(motions, key, method, (groups or {}).get(key[0], "all")))
    return made


def _fold(motions: Motions, key: tuple[str, str], method: SensorControl, group: str) -> Callable[[], Fold]:
    def build() -> Fold:
        rest = {other: motion for other, motion in motions.items() if other != key}
        rng = np.random.default_rng(method.seed)
        examples = build_examples(rest, method.layout, method.rate, method.resampling, rng, kinds=method.kinds)
        return Fold(key[0], group, resample(motions[key], method.rate), examples)

    return build


def blocks(key: tuple[str, str], motion: Motion, count: int = 5, gap: float = 1.0) -> Motions:
    """A motion in ``count`` parts, ``gap`` seconds left out between them."""
    edges = np.linspace(0, len(motion), count + 1).astype(np.int64)
    away = round(0.5 * gap * motion.fps)
    return {
        (f"{key[0]}[{i}]", key[1]): cut(motion, int(a) + away * (i > 0), int(b) - away * (i < count - 1))
        for i, (a, b) in enumerate(itertools.pairwise(edges))
    }


def evaluate(
    library: Library,
    method: SensorControl,
    *,
    syntheses: Sequence[str] = SYNTHESES,
    groups: Mapping[str, str] | None = None,
    track: str | None = None,
    only: Sequence[str] = (),
    progress: Progress | None = None,
) -> tuple[list[SensorRow], dict[str, FloatArray]]:
    """Rows by method and group, baselines and syntheses alike, and the default's error of each joint in degrees.

    groups: a name for each take, by which rows are averaged over frames. only: the takes to hold out.
    """
    rows: list[SensorRow] = []
    joints: dict[str, list[FloatArray]] = {}
    todo = folds(library, method, groups, track, only)
    for done, build in enumerate(todo, start=1):
        fold = build()
        readings = simulate_kinds(fold.truth, method.layout, method.kinds, np.random.default_rng(1000 + done))
        signal = uniform(readings, method.rate, fold.truth.duration, method.resampling, method.kinds)
        for name in BASELINES:
            poses = baseline(name, fold.examples, signal.values / fold.examples.scale)
            rows.append(score(name, fold.group, fold.examples.space.decode(poses), fold.truth)[0])
        local = None
        for synthesis in syntheses:
            own = replace(method, synthesis=synthesis)
            model = fit_examples(own, fold.examples, np.random.default_rng(method.seed), local)
            local = model.local or local  # interpolation and optimisation learn the same ones
            rotations, times = timed(model, readings)
            row, by_joint = score(synthesis, fold.group, rotations, fold.truth, times)
            rows.append(row)
            joints.setdefault(synthesis, []).append(by_joint)
        if progress:
            progress(done, len(todo))
    return averaged(rows), {name: np.mean(found, axis=0) for name, found in joints.items()}


def averaged(rows: Sequence[SensorRow]) -> list[SensorRow]:
    """Rows of the same method and group as one, averaged over takes."""
    found: dict[tuple[str, str], list[SensorRow]] = {}
    for row in rows:
        found.setdefault((row.group, row.method), []).append(row)
    out = []
    for (group, method), same in found.items():
        means = {
            name: float(np.mean([getattr(r, name) for r in same]))
            for name in ("angle", "rms", "position_cm", "jitter", "p50_ms", "p99_ms")
        }
        out.append(SensorRow(method, group, sum(r.takes for r in same), sum(r.frames for r in same), **means))
    return out


def grouped(names: Sequence[str], patterns: Sequence[str]) -> dict[str, str]:
    """The group of each take by patterns ``group=glob``; takes that none matches are of the group ``other``.

    >>> grouped(["64_01", "86_14"], ["golf=64_*"])
    {'64_01': 'golf', '86_14': 'other'}
    """
    groups: dict[str, str] = {}
    for item in patterns:
        group, separator, pattern = item.partition("=")
        if not separator or not pattern:
            raise RequestError(f"a group is name=pattern, as in golf=64_*; found {item!r}")
        groups |= {name: group for name in names if name not in groups and fnmatchcase(name, pattern)}
    return {name: groups.get(name, "other" if patterns else "all") for name in names}


SWEEPS: Mapping[str, tuple[float, ...]] = {
    "loss": (0.0, 0.1, 0.2, 0.3),
    "offset": (0.0, 0.02, 0.05, 0.1),
    "span": (3.0, 8.0, 16.0),
    "sensors": (1, 2, 4, 6, 8),
}
"""Share of packets lost, seconds of clock offset, g at which readings clip, number of sensors."""


@dataclass(frozen=True)
class SweepRow:
    """Error of one synthesis where one thing about the sensors is worse; growth: over the sweep's first value, or
    over all sensors."""

    sweep: str
    value: float
    angle: float
    growth: float


def sweep(
    library: Library,
    method: SensorControl,
    what: str,
    *,
    track: str | None = None,
    only: Sequence[str] = (),
    progress: Progress | None = None,
) -> list[SweepRow]:
    """The configured synthesis under one of `SWEEPS`: losses and offsets are not known to the model, clipping and the
    sensors worn are."""
    totals: dict[float, list[float]] = {value: [] for value in SWEEPS[what]}
    known = what in ("span", "sensors")
    variants = {value: _variant(method.layout, what, value) for value in SWEEPS[what]}
    steps = len(variants)
    for index, (value, layout) in enumerate(variants.items()):
        used = replace(method, layout=layout) if known else method
        todo = folds(library, used, None, track, only)
        for done, build in enumerate(todo, start=1):
            fold = build()
            model = fit_examples(used, fold.examples, np.random.default_rng(method.seed))
            readings = simulate_kinds(fold.truth, layout, method.kinds, np.random.default_rng(1000 + done))
            result = model.synthesize(readings).motion.rotations
            totals[value].append(score(used.synthesis, "all", result, fold.truth)[0].angle)
            if progress:
                progress(index * len(todo) + done, steps * len(todo))
    means = {value: float(np.mean(found)) for value, found in totals.items()}
    first = means[max(means)] if what in ("sensors", "span") else means[min(means)]
    return [SweepRow(what, float(value), angle, angle / first - 1.0) for value, angle in means.items()]


def _variant(layout: Layout, what: str, value: float) -> Layout:
    if what == "sensors":
        order = spread_out(layout.names)
        return keep(layout, tuple(order[: int(value)]))
    if what == "span":
        return replace(layout, device=replace(layout.device, span=value * 9.81))
    changed = {"loss": replace(layout.device, loss=value), "offset": replace(layout.device, offset=value)}
    return replace(layout, device=changed[what])


def spread_out(names: Sequence[str]) -> list[str]:
    """Sensors in an order in which few of them cover the body: a forearm, the other side's shank, and so on."""
    wanted = ("right_forearm", "left_shank", "left_forearm", "right_shank", "right_upper_arm", "left_thigh")
    return [*(n for n in wanted if n in names), *(n for n in names if n not in wanted)]
