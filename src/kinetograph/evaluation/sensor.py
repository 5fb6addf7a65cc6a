"""Held-out evaluation of sensor control: whole takes are left out, never random frames.

Frames of one take that are neighbours in time are nearly the same; a random split would test on what it was trained on.
"""

from __future__ import annotations

import functools
import itertools
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from functools import cached_property, partial

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor_baselines import BASELINES, baseline
from kinetograph.evaluation.sensor_scores import SensorRow, averaged, score, with_feet
from kinetograph.library import Library, folders_of
from kinetograph.library.fingerprints import digest, of_takes, state
from kinetograph.methods.sensor import (
    SYNTHESES,
    Continuity,
    Examples,
    Interpolation,
    LocalModels,
    LocalModelSettings,
    Motions,
    Optimisation,
    SensorControl,
    SensorModel,
    SensorSynthesis,
    example_motions,
    fit_examples,
)
from kinetograph.methods.sensor.examples import ExamplePart, example_parts, examples_of_parts
from kinetograph.motion import Motion, cut, resample
from kinetograph.progress import Progress
from kinetograph.sensing import Readings, select_rows, simulate_kinds, uniform
from kinetograph.work import HERE, Workers, in_shards, require_seen


@dataclass(frozen=True, eq=False)
class Fold:
    """A held-out take, and examples of all others.

    Parameters
    ----------
    take : str
    group : str
    truth : Motion
        The held-out motion at the method's rate.
    examples : Examples
    """

    take: str
    group: str
    truth: Motion
    examples: Examples


@dataclass(frozen=True)
class HeldOut:
    """Which takes are held out, one at a time.

    Parameters
    ----------
    only : sequence of str
        Names of takes; all by default.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    groups : mapping
        A name for each take, by which rows are averaged over frames; ``"all"`` by default.
    copies : mapping
        By held-out take the takes that it is not estimated from.
    """

    only: Sequence[str] = ()
    track: str | None = None
    groups: Mapping[str, str] = field(default_factory=dict)
    copies: Mapping[str, Sequence[str]] = field(default_factory=dict)


def folds(library: Library, method: SensorControl, held: HeldOut) -> list[Callable[[], Fold]]:
    """One fold per take; a library of one take is cut into five blocks with gaps of a second.

    Parameters
    ----------
    library : Library
    method : SensorControl
    held : HeldOut

    Returns
    -------
    list of callable
        Each builds its fold when called.
    """
    motions = example_motions(library, track=held.track)
    if len(motions) == 1:
        motions = blocks(*next(iter(motions.items())))
    return folds_of(motions, method, held)


def folds_of(motions: Motions, method: SensorControl, held: HeldOut | None = None) -> list[Callable[[], Fold]]:
    """One fold per motion, of one skeleton all, each built when called.

    Parameters
    ----------
    motions : mapping of (str, str) to Motion
        By take and track.
    method : SensorControl
    held : HeldOut, optional

    Raises
    ------
    RequestError
        For a take to hold out that is not there.
    """
    held = held or HeldOut()
    names, parts = [take for take, _ in motions], _Parts(motions, method)
    if unknown := sorted(set(held.only) - set(names)):
        raise RequestError(f"no take {unknown[0]!r} to hold out; there are {', '.join(dict.fromkeys(names))}")
    return [
        partial(_fold, parts, key, held.copies.get(key[0], ()), held.groups.get(key[0], "all"))
        for key in motions
        if not held.only or key[0] in held.only
    ]


@dataclass(frozen=True, eq=False)
class _Parts:
    """What motions give to examples, simulated once for all folds."""

    motions: Motions
    method: SensorControl

    @cached_property
    def of_motions(self) -> tuple[ExamplePart, ...]:
        rng = np.random.default_rng(self.method.seed)
        return tuple(example_parts(self.motions.items(), self.method.setup, rng))


def _fold(parts: _Parts, key: tuple[str, str], away: Sequence[str], group: str) -> Fold:
    rest = (part for part in parts.of_motions if part.key != key and part.key[0] not in away)
    examples = examples_of_parts(rest, parts.method.setup)
    return Fold(key[0], group, resample(parts.motions[key], parts.method.rate), examples)


def blocks(key: tuple[str, str], motion: Motion, count: int = 5, gap: float = 1.0) -> dict[tuple[str, str], Motion]:
    """A motion in several parts.

    Parameters
    ----------
    key : (str, str)
        Take and track.
    motion : Motion
    count : int
        Number of parts.
    gap : float
        Seconds left out between them.

    Returns
    -------
    dict
        Parts by take and track; the takes are called ``name[0]``, ``name[1]``, ...
    """
    edges = np.linspace(0, len(motion), count + 1).astype(np.int64)
    away = round(0.5 * gap * motion.fps)
    return {
        (f"{key[0]}[{i}]", key[1]): cut(motion, int(a) + away * (i > 0), int(b) - away * (i < count - 1))
        for i, (a, b) in enumerate(itertools.pairwise(edges))
    }


def fitted_to(methods: Mapping[str, SensorControl], examples: Examples) -> Iterator[tuple[str, SensorModel]]:
    """A model for each of several configurations of one setup.

    Those whose settings of local models are the same share the local models.

    Parameters
    ----------
    methods : mapping
        Configurations by name.
    examples : Examples

    Yields
    ------
    name : str
    model : SensorModel
    """
    learnt: dict[LocalModelSettings, LocalModels] = {}
    for name, method in methods.items():
        settings = None if isinstance(method.synthesis, Continuity) else method.synthesis.local
        known = learnt.get(settings) if settings else None
        model = fit_examples(method, examples, np.random.default_rng(method.seed), known)
        if settings and model.fitted.local:
            learnt[settings] = model.fitted.local
        yield name, model


def timed(
    model: SensorModel, readings: Readings, clock: Callable[[], float] = time.thread_time
) -> tuple[SensorSynthesis, list[float]]:
    """Run a model live, with the readings of one frame at a time.

    Parameters
    ----------
    model : SensorModel
    readings : Readings
    clock : callable
        Gives seconds; by default of this thread's processor time, in which other work of a busy machine does not count.

    Returns
    -------
    result : SensorSynthesis
    times : list of float
        Seconds that each frame took.
    """
    live = model.start()
    times = []
    rate = model.method.rate
    bounds = np.searchsorted(readings.times, np.arange(1, int(readings.duration * rate) + 2) / rate)
    low = 0
    for high in bounds:
        part = select_rows(readings, slice(low, int(high)))
        began = clock()
        live.step(part)
        times.append(clock() - began)
        low = int(high)
    return live.finish(), times


def evaluate(
    library: Library,
    method: SensorControl,
    *,
    syntheses: Mapping[str, Continuity | Interpolation | Optimisation] = SYNTHESES,
    held: HeldOut | None = None,
    workers: Workers | Executor = HERE,
    progress: Progress | None = None,
) -> tuple[list[SensorRow], dict[str, FloatArray]]:
    """Hold takes out, and estimate each from virtual readings by the others.

    Parameters
    ----------
    library : Library
    method : SensorControl
        Its synthesis is replaced by each of ``syntheses``.
    syntheses : mapping
        By name.
    held : HeldOut, optional
    workers : Workers or Executor
        Who estimates. Rows are the same, but for the times that they give.
    progress : Progress, optional
        Called with the takes done and their number.

    Returns
    -------
    rows : list of SensorRow
        By method and group, baselines and syntheses alike.
    joints : dict
        The error of each joint in degrees, shape (J,), by synthesis.
    """
    held = held or HeldOut()
    content = digest(*map(str, folders_of(library)), of_takes(library), state(method), state(held))
    whole = _Whole(library, method, held, content)
    methods = {name: replace(method, synthesis=synthesis) for name, synthesis in syntheses.items()}
    count = len(_folds_of(whole))
    rows: list[SensorRow] = []
    joints: dict[str, list[FloatArray]] = {name: [] for name in methods}
    estimate = partial(_estimated, whole, methods)
    for some, by_joint in in_shards(estimate, range(count), workers, count=count, progress=progress):
        rows += some
        for name, errors in by_joint.items():
            joints[name].append(errors)
    return averaged(rows), {name: np.mean(errors, axis=0) for name, errors in joints.items()}


@dataclass(frozen=True)
class _Whole:
    """What is evaluated, as it was when this was its digest."""

    library: Library = field(compare=False)
    method: SensorControl = field(compare=False)
    held: HeldOut = field(compare=False)
    digest: str


_ONCE = threading.Lock()


def _folds_of(whole: _Whole) -> list[Callable[[], Fold]]:
    with _ONCE:  # for the threads of a cluster's worker
        return _kept_folds(whole)


@functools.lru_cache(maxsize=1)
def _kept_folds(whole: _Whole) -> list[Callable[[], Fold]]:
    return folds(whole.library, whole.method, whole.held)


def _estimated(
    whole: _Whole, methods: Mapping[str, SensorControl], number: int
) -> tuple[list[SensorRow], dict[str, FloatArray]]:
    """Rows of one held-out take, and the error of each joint by synthesis."""
    require_seen(*folders_of(whole.library))
    fold, method = _folds_of(whole)[number](), whole.method
    readings = simulate_kinds(fold.truth, method.layout, method.kinds, np.random.default_rng(1001 + number))
    rows, joints = _baseline_rows(fold, method, readings), {}
    for name, model in fitted_to(methods, fold.examples):
        made, times = timed(model, readings)
        row, joints[name] = score(name, fold.group, made.motion.rotations, fold.truth, times)
        rows.append(with_feet(row, made, fold.truth))
    return rows, joints


def _baseline_rows(fold: Fold, method: SensorControl, readings: Readings) -> list[SensorRow]:
    signal = uniform(readings, method.rate, fold.truth.duration, method.resampling, method.kinds)
    rows = []
    for name in BASELINES:
        poses = baseline(name, fold.examples, signal.values / fold.examples.scale)
        rows.append(score(name, fold.group, fold.examples.space.decode(poses), fold.truth)[0])
    return rows


def grouped(names: Sequence[str], patterns: Sequence[str]) -> dict[str, str]:
    """The group of each take.

    Parameters
    ----------
    names : sequence of str
        The takes.
    patterns : sequence of str
        Each ``group=glob``.

    Returns
    -------
    dict
        Groups by take; takes that no pattern matches are of the group ``other``.

    Raises
    ------
    RequestError
        For what is no such pattern.

    Examples
    --------
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
