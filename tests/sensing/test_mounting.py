"""Sensors worn in one manner, read as if they were worn in another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import DataError, RequestError
from kinetograph.sensing import (
    Layout,
    Mounting,
    Readings,
    mounting_of,
    preset,
    select_rows,
    select_sensors,
    simulate,
    worn_as,
)
from walkers import walk

IDEAL = preset("ideal")


def askew(seed: int) -> Layout:
    rng = np.random.default_rng(seed)
    sensors = tuple(replace(s, rotation=rot.exp(rng.normal(size=3)), bias=rng.normal(size=3)) for s in IDEAL.sensors)
    return replace(IDEAL, name=f"askew {seed}", sensors=sensors)


def rich(layout: Layout) -> Readings:
    return simulate(walk(2.0), layout, angular=True, tilt=True)


def test_readings_of_one_mounting_become_those_of_another():
    first, second = askew(1), askew(2)
    given = replace(rich(first), mounting=mounting_of(first, first.names))
    found, truth = worn_as(given, second), rich(second)
    np.testing.assert_allclose(found.force, truth.force, atol=1e-9)
    np.testing.assert_allclose(found.angular, truth.angular, atol=1e-9)
    assert np.max(rot.angle_between(found.orientation, truth.orientation)) < 1e-6
    assert np.abs(given.force - truth.force).max() > 1.0
    assert found.mounting.layout == "askew 2"


def test_readings_without_a_mounting_are_taken_as_the_layouts():
    given = rich(IDEAL)
    np.testing.assert_array_equal(worn_as(given, askew(1)).force, given.force)


def test_sensors_that_the_layout_lacks_are_left_out_and_the_order_is_its_own():
    first = askew(1)
    few = replace(IDEAL, sensors=IDEAL.sensors[4:1:-1])
    given = replace(rich(first), mounting=mounting_of(first, first.names))
    found, truth = worn_as(given, few), rich(few)
    assert found.names == few.names
    for index in range(3):
        mine, true = found.force[found.sensors == index], truth.force[truth.sensors == index]
        np.testing.assert_allclose(mine, true, atol=1e-9)
    with pytest.raises(RequestError, match=r"some of left_forearm, .*, found those of one"):
        worn_as(Readings(("one",), [0.0], [0], [[0.0, 9.81, 0.0]]), IDEAL)


def test_a_mounting_goes_with_its_sensors():
    given = replace(rich(askew(1)), mounting=mounting_of(askew(1), IDEAL.names))
    chosen = select_sensors(given, IDEAL.names[3:1:-1]).mounting
    np.testing.assert_array_equal(chosen.rotations, given.mounting.rotations[3:1:-1])
    assert select_rows(given, slice(5)).mounting is given.mounting
    with pytest.raises(DataError, match="8 sensors but the mounting of 2"):
        replace(given, mounting=chosen)
    with pytest.raises(DataError, match=r"biases of a mounting must be finite and \(S, 3\)"):
        Mounting("mine", np.zeros((2, 4)), np.zeros((1, 3)))
