"""Models learn from readings that were captured with a take, where there are any."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph.library import Library
from kinetograph.methods.sensor import SensorControl
from kinetograph.sensing import (
    Readings,
    keep_sensors,
    mounting_of,
    preset,
    select_rows,
    select_sensors,
    shifted,
    simulate,
)
from kinetograph.take import Take
from walkers import walk

LAYOUT = keep_sensors(preset("ideal"), ("left_forearm", "right_forearm"))
MOTIONS = {"slow": walk(3.0, speed=0.7), "fast": walk(3.0, speed=1.4, period=0.8)}
METHOD = SensorControl(layout=LAYOUT)


def captured(motion_name: str = "slow") -> Readings:
    """Readings that no simulation gives: 3 m/s^2 along x too much."""
    readings = simulate(MOTIONS[motion_name], LAYOUT)
    return replace(readings, force=readings.force + np.array([3.0, 0.0, 0.0]))


def library(folder: Path, **tracks: Readings) -> Library:
    made = Library.create(folder / "library")
    for name, motion in MOTIONS.items():
        made.add(Take(name, {"motion": motion, **({"readings": tracks[name]} if name in tracks else {})}))
    return made


def of(model, name: str) -> np.ndarray:
    """Channels ``(F, S, 3)`` in m/s^2 of a take's examples."""
    examples = model.fitted.examples
    at = [take for take, _ in examples.takes].index(name)
    rows = examples.readings[examples.starts[at] : examples.starts[at + 1]]
    return (rows * examples.scale).reshape(len(rows), -1, 3)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    return METHOD.fit(library(tmp_path_factory.mktemp("simulated")))


def test_captured_readings_take_the_place_of_simulated_ones(tmp_path, simulated):
    model = METHOD.fit(library(tmp_path, slow=captured()))
    np.testing.assert_allclose(of(model, "slow") - of(simulated, "slow"), [[[3.0, 0, 0]] * 2] * 181, atol=1e-3)
    np.testing.assert_allclose(of(model, "fast"), of(simulated, "fast"), atol=1e-5)
    assert model.notes[-1] == "readings captured by worn sensors are used in 1 of 2 takes: slow (100%)"
    assert not any("captured" in line for line in simulated.notes)


def test_what_is_missing_is_simulated(tmp_path, simulated):
    one = select_sensors(captured(), ("right_forearm",))
    brief = select_rows(one, one.times <= 1.5)
    model = METHOD.fit(library(tmp_path, slow=brief))
    away = of(model, "slow") - of(simulated, "slow")
    np.testing.assert_allclose(away[:, 0], 0.0, atol=1e-5)
    np.testing.assert_allclose(away[:88, 1], [[3.0, 0, 0]] * 88, atol=1e-3)
    np.testing.assert_allclose(away[100:, 1], 0.0, atol=1e-5)
    assert "slow (25%)" in model.notes[-1]


def test_sensors_worn_in_another_manner_are_brought_to_the_layouts(tmp_path, simulated):
    askew = replace(LAYOUT, sensors=tuple(replace(s, rotation=[0.0, 1.0, 0.0, 0.0]) for s in LAYOUT.sensors))
    worn = replace(simulate(MOTIONS["slow"], askew), mounting=mounting_of(askew, askew.names))
    model = METHOD.fit(library(tmp_path, slow=worn))
    np.testing.assert_allclose(of(model, "slow"), of(simulated, "slow"), atol=1e-3)
    assert "slow (100%)" in model.notes[-1]


@pytest.mark.parametrize(
    ("readings", "kinds", "why"),
    [
        (captured(), ("force", "angular"), "as they lack angular: slow"),
        (simulate(MOTIONS["slow"], preset("phone")), ("force",), "as they are of hand, pocket, none of which layout"),
        (shifted(captured(), 50.0), ("force",), "as they are not of the time of the motion: slow"),
    ],
)
def test_captured_readings_that_do_not_fit_are_named(tmp_path, readings, kinds, why):
    model = replace(METHOD, kinds=kinds).fit(library(tmp_path, slow=readings))
    assert any(why in line for line in model.notes)
