"""Means of sensor control over takes, with how sure they are, and what they gain over the best baseline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.evaluation.intervals import interval
from kinetograph.evaluation.sensor_baselines import BASELINES, SMOOTHED
from kinetograph.evaluation.sensor_scores import SensorRow, averaged


@dataclass(frozen=True)
class SensorMean:
    """One method over the takes of one group.

    Parameters
    ----------
    group, method : str
    takes, people : int
    angle, angle_low, angle_high : float
        Mean error over takes in degrees, and the bootstrap's 95 % interval of it.
    best : str
        The baseline of the least error, smoothed or not.
    gain, gain_low, gain_high : float
        By how many degrees the error is below that baseline's on the same takes; negative where it is above.
    beaten : int
        Takes on which the error is below that of every baseline.
    mean : SensorRow
        Of the other figures.
    """

    group: str
    method: str
    takes: int
    people: int
    angle: float
    angle_low: float
    angle_high: float
    best: str
    gain: float
    gain_low: float
    gain_high: float
    beaten: int
    mean: SensorRow


def is_baseline(method: str) -> bool:
    """Whether a name is one of a baseline, smoothed or not."""
    return method.removesuffix(SMOOTHED) in BASELINES


def group_means(rows: Sequence[SensorRow], by_person: bool = False) -> list[SensorMean]:
    """The means over takes, by group and method; over all groups as well, where there are several.

    Parameters
    ----------
    rows : sequence of SensorRow
        One a take and method.
    by_person : bool
        Whether people are drawn in the bootstrap, with all their takes, in place of takes: where people were left out.

    Returns
    -------
    list of SensorMean
    """
    groups = list(dict.fromkeys(row.group for row in rows))
    out = [mean for group in groups for mean in _of_group([r for r in rows if r.group == group], group, by_person)]
    return out + (_of_group(list(rows), "every group", by_person) if len(groups) > 1 else [])


def _of_group(rows: list[SensorRow], group: str, by_person: bool) -> list[SensorMean]:
    methods = list(dict.fromkeys(row.method for row in rows))
    errors = {name: {row.take: row.angle for row in rows if row.method == name} for name in methods}
    rivals = [name for name in methods if is_baseline(name)]
    best = min(rivals, key=lambda name: np.mean(list(errors[name].values())), default="")
    people = {row.take: row.person for row in rows}
    out = []
    for name in methods:
        takes = list(errors[name])
        units = [people[take] if by_person else take for take in takes]
        angle = interval([errors[name][take] for take in takes], units)
        gain = interval([errors[best][take] - errors[name][take] if best else np.nan for take in takes], units)
        beaten = sum(all(errors[name][take] < errors[rival][take] for rival in rivals) for take in takes)
        mean = averaged([row for row in rows if row.method == name], group)
        out.append(
            SensorMean(
                group,
                name,
                len(takes),
                len(set(people.values())),
                angle.mean,
                angle.low,
                angle.high,
                best,
                gain.mean,
                gain.low,
                gain.high,
                beaten,
                mean,
            )
        )
    return out
