"""Sensor control where one thing about the sensors gets worse and worse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor_folds import HeldOut, folds
from kinetograph.evaluation.sensor_scores import score
from kinetograph.library import Library
from kinetograph.methods.sensor import SensorControl, fit_examples
from kinetograph.progress import Progress
from kinetograph.sensing import GRAVITY, Layout, keep_sensors

SWEEPS: Mapping[str, tuple[float, ...]] = {
    "loss": (0.0, 0.1, 0.2, 0.3),
    "offset": (0.0, 0.02, 0.05, 0.1),
    "span": (3.0, 8.0, 16.0),
    "sensors": (1, 2, 4, 6, 8),
}
"""Share of packets lost, seconds of clock offset, g at which readings clip, number of sensors."""


@dataclass(frozen=True)
class SweepRow:
    """Error of one synthesis at one value of a sweep.

    Parameters
    ----------
    sweep : str
    value : float
    angle : float
        Mean error in degrees.
    growth : float
        Over the sweep's first value, or over all sensors and the widest range.
    """

    sweep: str
    value: float
    angle: float
    growth: float


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

    Raises
    ------
    RequestError
        For another sweep.
    """
    if what not in SWEEPS:
        raise RequestError(f"no sweep {what!r}; expected one of {', '.join(SWEEPS)}")
    means: dict[float, float] = {}
    for index, value in enumerate(SWEEPS[what]):
        layout = _variant(method.layout, what, value)
        used = replace(method, layout=layout) if what in ("span", "sensors") else method
        todo = folds(library, used, held or HeldOut())
        errors: list[float] = []
        for done, build in enumerate(todo, start=1):
            fold = build()
            model = fit_examples(used, fold.examples, np.random.default_rng(method.seed))
            read = replace(used, layout=layout)
            made = {take: model.synthesize(fold.readings(take, read)).motion for take in fold.truths}
            errors += [score(what, "all", made[take].rotations, truth)[0].angle for take, truth in fold.truths.items()]
            if progress:
                progress(index * len(todo) + done, len(SWEEPS[what]) * len(todo))
        means[value] = float(np.mean(errors))
    first = means[max(means)] if what in ("sensors", "span") else means[min(means)]
    return [SweepRow(what, float(value), angle, angle / first - 1.0) for value, angle in means.items()]


def _variant(layout: Layout, what: str, value: float) -> Layout:
    if what == "sensors":
        order = spread_out(layout.names)
        return keep_sensors(layout, tuple(order[: int(value)]))
    if what == "span":
        return replace(layout, device=replace(layout.device, span=value * GRAVITY))
    changed = {"loss": replace(layout.device, loss=value), "offset": replace(layout.device, offset=value)}
    return replace(layout, device=changed[what])


def spread_out(names: Sequence[str]) -> list[str]:
    """Sensors in an order in which few of them cover the body: a forearm, the other side's shank, and so on."""
    wanted = ("right_forearm", "left_shank", "left_forearm", "right_shank", "right_upper_arm", "left_thigh")
    return [*(n for n in wanted if n in names), *(n for n in names if n not in wanted)]
