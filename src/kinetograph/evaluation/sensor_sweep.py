"""Sensor control where one thing changes step by step: what is wrong with the sensors, or how far ahead is looked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.evaluation.intervals import interval
from kinetograph.evaluation.sensor_folds import Fold, HeldOut, folds
from kinetograph.evaluation.sensor_scores import score
from kinetograph.library import Library
from kinetograph.methods.sensor import Optimisation, SensorControl, fit_examples
from kinetograph.progress import Progress
from kinetograph.sensing import GRAVITY, Layout, keep_sensors

SWEEPS: Mapping[str, tuple[float, ...]] = {
    "loss": (0.0, 0.1, 0.2, 0.3),
    "offset": (0.0, 0.02, 0.05, 0.1),
    "span": (3.0, 8.0, 16.0),
    "sensors": (1, 2, 4, 6, 8),
    "ahead": (0.0, 0.05, 0.1, 0.15, 0.3),
}
"""Share of packets lost, seconds of clock offset, g at which readings clip, number of sensors, seconds looked ahead."""


@dataclass(frozen=True)
class SweepRow:
    """Error of one synthesis at one value of a sweep.

    Parameters
    ----------
    sweep : str
    value : float
    group : str
    angle, angle_low, angle_high : float
        Mean error over takes in degrees, and the bootstrap's 95 % interval of it.
    growth : float
        Over the sweep's first value, or over all sensors and the widest range.
    jitter : float
        Over the source's.
    """

    sweep: str
    value: float
    group: str
    angle: float
    angle_low: float
    angle_high: float
    growth: float
    jitter: float


def sweep(
    library: Library,
    method: SensorControl,
    what: str,
    *,
    held: HeldOut | None = None,
    progress: Progress | None = None,
) -> list[SweepRow]:
    """The configured synthesis under one of ``SWEEPS``.

    Losses and offsets are not known to the model; clipping and the sensors worn are.

    Parameters
    ----------
    library : Library
    method : SensorControl
    what : str
        A key of ``SWEEPS``.
    held : HeldOut, optional
    progress : Progress, optional
        Called with the runs done and their number.

    Returns
    -------
    list of SweepRow
        By group and value.

    Raises
    ------
    RequestError
        For another sweep, and for looking ahead by another synthesis than optimisation.
    """
    if what not in SWEEPS:
        raise RequestError(f"no sweep {what!r}; expected one of {', '.join(SWEEPS)}")
    held = held or HeldOut()
    values = SWEEPS[what]
    # what is learnt depends on the value where the sensors that are known do
    runs = [(value,) for value in values] if what in ("span", "sensors") else [values]
    found: dict[tuple[str, float], list[_Found]] = {}
    for index, some in enumerate(runs):
        todo = folds(library, _variant(method, what, some[0])[0], held)
        for done, build in enumerate(todo, start=1):
            for (take, value), one in _scored(build(), method, what, some).items():
                found.setdefault((held.groups.get(take, "all"), float(value)), []).append(one)
            if progress:
                progress(index * len(todo) + done, len(runs) * len(todo))
    return _rows(what, found)


def _scored(fold: Fold, method: SensorControl, what: str, values: Sequence[float]) -> dict[tuple[str, float], _Found]:
    """The errors of a fold's takes at some values, by take and value; one fit serves them."""
    fitted = fit_examples(_variant(method, what, values[0])[0], fold.examples, np.random.default_rng(method.seed))
    found = {}
    for value in values:
        used, worn = _variant(method, what, value)
        model = replace(fitted, method=used)
        for take, truth in fold.truths.items():
            row = score(what, "all", model.synthesize(fold.readings(take, worn)).motion.rotations, truth)[0]
            found[take, value] = _Found(fold.unit, row.angle, row.jitter)
    return found


@dataclass(frozen=True)
class _Found:
    unit: str
    angle: float
    jitter: float


def _rows(what: str, found: Mapping[tuple[str, float], Sequence[_Found]]) -> list[SweepRow]:
    means = {key: interval([f.angle for f in rows], [f.unit for f in rows]) for key, rows in found.items()}
    first = (max if what in ("sensors", "span") else min)(value for _, value in found)
    return [
        SweepRow(
            what,
            value,
            group,
            mean.mean,
            mean.low,
            mean.high,
            mean.mean / means[group, first].mean - 1.0,
            float(np.mean([one.jitter for one in found[group, value]])),
        )
        for (group, value), mean in sorted(means.items())
    ]


def _variant(method: SensorControl, what: str, value: float) -> tuple[SensorControl, SensorControl]:
    """What is fitted, and that of whose layout the readings are."""
    layout: Layout = method.layout
    if what == "ahead":
        if not isinstance(method.synthesis, Optimisation):
            raise RequestError("only optimisation looks ahead by seconds: give --synthesis optimisation")
        used = replace(method, synthesis=replace(method.synthesis, ahead=value))
        return used, used
    if what == "sensors":
        used = replace(method, layout=keep_sensors(layout, tuple(spread_out(layout.names)[: int(value)])))
        return used, used
    if what == "span":
        used = replace(method, layout=replace(layout, device=replace(layout.device, span=value * GRAVITY)))
        return used, used
    changed = {"loss": replace(layout.device, loss=value), "offset": replace(layout.device, offset=value)}
    return method, replace(method, layout=replace(layout, device=changed[what]))


def spread_out(names: Sequence[str]) -> list[str]:
    """Sensors in an order in which few of them cover the body: a forearm, the other side's shank, and so on."""
    wanted = ("right_forearm", "left_shank", "left_forearm", "right_shank", "right_upper_arm", "left_thigh")
    return [*(n for n in wanted if n in names), *(n for n in names if n not in wanted)]
