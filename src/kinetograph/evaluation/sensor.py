"""Held-out evaluation of sensor control, from virtual readings; see `kinetograph.evaluation.sensor_folds`."""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.sensor_baselines import baselines
from kinetograph.evaluation.sensor_folds import Fold, HeldOut, folds
from kinetograph.evaluation.sensor_nested import candidates, choose
from kinetograph.evaluation.sensor_scores import SensorRow, score, with_feet
from kinetograph.library import Library, folders_of
from kinetograph.library.fingerprints import digest, of_takes, state
from kinetograph.methods.sensor import (
    SYNTHESES,
    Examples,
    Interpolation,
    LocalModels,
    LocalModelSettings,
    Optimisation,
    PoseSynthesis,
    SensorControl,
    SensorModel,
    SensorSynthesis,
    fit_examples,
)
from kinetograph.progress import Progress
from kinetograph.sensing import Readings, select_rows, uniform
from kinetograph.work import HERE, Workers, in_shards, require_seen


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
        synthesis = method.synthesis
        settings = synthesis.local if isinstance(synthesis, Interpolation | Optimisation) else None
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


@dataclass(frozen=True, eq=False)
class SensorScores:
    """The scores of held-out takes.

    Parameters
    ----------
    rows : tuple of SensorRow
        One a take and method, baselines and syntheses alike.
    joints : mapping
        The error of each joint in degrees, shape (T, J), by synthesis.
    chosen : tuple of str
        What was chosen for each that was left out, where settings were chosen anew.
    """

    rows: tuple[SensorRow, ...]
    joints: Mapping[str, FloatArray]
    chosen: tuple[str, ...] = ()


def together(parts: Sequence[SensorScores]) -> SensorScores:
    """The scores of several parts of an evaluation."""
    names = dict.fromkeys(name for part in parts for name in part.joints)
    joints = {name: np.concatenate([part.joints[name] for part in parts if name in part.joints]) for name in names}
    rows = tuple(row for part in parts for row in part.rows)
    return SensorScores(rows, joints, tuple(line for part in parts for line in part.chosen))


def evaluate(
    library: Library,
    method: SensorControl,
    *,
    syntheses: Mapping[str, PoseSynthesis] = SYNTHESES,
    held: HeldOut | None = None,
    nested: bool = False,
    workers: Workers | Executor = HERE,
    progress: Progress | None = None,
) -> Iterator[SensorScores]:
    """Hold takes out, and estimate each from virtual readings by the others.

    Parameters
    ----------
    library : Library
    method : SensorControl
        Its synthesis is replaced by each of ``syntheses``.
    syntheses : mapping
        By name.
    held : HeldOut, optional
    nested : bool
        Whether settings are also chosen anew for each that is left out, on the others, see
        ``kinetograph.evaluation.sensor_nested``; such rows are called ``"..., nested"``.
    workers : Workers or Executor
        Who works, take by take or person by person; figures do not depend on it, but for the times of frames.
    progress : Progress, optional
        Called with the folds done and their number.

    Yields
    ------
    SensorScores
        Those of one fold after another, for `together`.
    """
    held = held or HeldOut()
    content = digest(*map(str, folders_of(library)), of_takes(library), state(method), state(held))
    whole = _Whole(library, method, held, content)
    count = len(_folds_of(whole))
    estimate = partial(_scores, whole, dict(syntheses), nested)
    yield from in_shards(estimate, range(count), workers, count=count, progress=progress)


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


def _scores(whole: _Whole, syntheses: Mapping[str, PoseSynthesis], nested: bool, number: int) -> SensorScores:
    """The scores of one fold."""
    require_seen(*folders_of(whole.library))
    fold, method = _folds_of(whole)[number](), whole.method
    wanted, chosen = dict(syntheses), []
    for name, synthesis in syntheses.items():
        among = candidates(synthesis) if nested else {}
        if among:
            best = choose(method, fold.examples, among)
            wanted[f"{name}, nested"] = among[best]
            chosen.append(f"{fold.unit}: {name}: {best}, chosen on the others")
    return replace(scores_of(fold, method, wanted, whole.held), chosen=tuple(chosen))


def scores_of(fold: Fold, method: SensorControl, syntheses: Mapping[str, PoseSynthesis], held: HeldOut) -> SensorScores:
    """The scores of the takes of one fold, see `evaluate`."""
    readings = {take: fold.readings(take, method) for take in fold.truths}
    rows = [row for take in fold.truths for row in _baseline_rows(fold, take, method, readings[take])]
    joints: dict[str, list[FloatArray]] = {name: [] for name in syntheses}
    methods = {name: replace(method, synthesis=synthesis) for name, synthesis in syntheses.items()}
    for name, model in fitted_to(methods, fold.examples):
        for take, truth in fold.truths.items():
            made, times = timed(model, readings[take])
            row, by_joint = score(name, "all", made.motion.rotations, truth, times)
            rows.append(replace(with_feet(row, made.motion, made.annotations, truth), take=take))
            joints[name].append(by_joint)
    rows = [replace(row, group=held.groups.get(row.take, "all"), person=held.person(row.take)) for row in rows]
    return SensorScores(tuple(rows), {name: np.array(errors) for name, errors in joints.items()})


def _baseline_rows(fold: Fold, take: str, method: SensorControl, readings: Readings) -> list[SensorRow]:
    truth, examples = fold.truths[take], fold.examples
    signal = uniform(readings, method.rate, truth.duration, method.resampling, method.kinds)
    return [
        replace(score(name, "all", examples.space.decode(poses), truth)[0], take=take)
        for name, poses in baselines(examples, signal.values / examples.scale)
    ]
