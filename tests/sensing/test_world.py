"""Orientations of other worlds, found by gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.sensing import (
    GRAVITY,
    Readings,
    World,
    as_said,
    channels,
    find_world,
    in_our_world,
    orientations_of_sensors,
)


def _worn(seed: int, still: float = 0.3) -> Readings:
    """A sensor that is turned about, in our world."""
    rng = np.random.default_rng(seed)
    rows = 200
    q = rot.normalize(rng.normal(size=4) + 0.3 * np.cumsum(rng.normal(size=(rows, 4)), axis=0))
    force = rot.rotate(rot.conjugate(q), np.array([0.0, GRAVITY, 0.0])) + still * rng.normal(size=(rows, 3))
    return Readings(("s",), np.arange(rows) / 60.0, np.zeros(rows, dtype=int), force, None, q)


def _as(world: World, readings: Readings) -> Readings:
    """The same readings as devices of another world give them."""
    q = readings.orientation
    assert q is not None
    if world.up == "z":
        q = rot.multiply(rot.about("x", np.pi / 2), q)
    return replace(readings, orientation=rot.conjugate(q) if world.inverse else q)


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("inverse", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_every_world_is_found_and_brought_to_ours(up: str, inverse: bool, seed: int) -> None:
    ours = _worn(seed)
    theirs = _as(World(up, inverse), ours)
    world = find_world(theirs)
    assert world == World(up, inverse)
    back = in_our_world(theirs, world)
    assert np.allclose(channels(back, ("tilt",)), channels(ours, ("tilt",)), atol=1e-9)


def test_orientations_that_disagree_with_gravity_are_refused() -> None:
    readings = _worn(0)
    rng = np.random.default_rng(1)
    wrong = replace(readings, orientation=rot.normalize(rng.normal(size=(len(readings), 4))))
    with pytest.raises(RequestError, match="do not agree with gravity"):
        find_world(wrong)


def test_a_named_axis_is_kept_to() -> None:
    theirs = _as(World("z"), _worn(2))
    assert find_world(theirs, "z") == World("z")
    with pytest.raises(RequestError, match="do not agree"):
        find_world(theirs, "y")
    with pytest.raises(RequestError, match="must be y or z"):
        find_world(theirs, "x")


def test_rows_that_never_rest_cannot_tell() -> None:
    fast = replace(_worn(0), force=np.full((200, 3), 30.0))
    with pytest.raises(RequestError, match="found 0"):
        find_world(fast)


def moving(world: World) -> Readings:
    """Readings of two sensors that rotate slowly in every way, with orientations of a world."""
    rng, times = np.random.default_rng(1), np.repeat(np.arange(400) / 100.0, 2)
    angles = gaussian_filter1d(rng.normal(size=(400, 2, 3)), 25, axis=0) * 8
    q = rot.exp(angles)
    between = rot.log(rot.multiply(rot.conjugate(q[:-1]), q[1:])) * 100.0
    angular = np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])
    q, angular = q.reshape(-1, 4), angular.reshape(-1, 3)
    force = rot.rotate(rot.conjugate(q), np.array([0.0, GRAVITY, 0.0]))
    from_ours = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])  # y up to z up
    q = rot.multiply(from_ours, q) if world.up == "z" else q
    facing = rot.conjugate(q) if world.inverse else q
    return Readings(("left", "right"), times, np.tile([0, 1], 400), force, angular, facing)


ALL = [World(up, inverse) for up in ("y", "z") for inverse in (False, True)]
KINDS = ("force", "tilt")


@pytest.mark.parametrize("world", ALL, ids=str)
def test_what_a_file_says_is_believed_where_gravity_agrees(world):
    ours, said = as_said(moving(world), world)
    np.testing.assert_allclose(channels(ours, KINDS), channels(moving(World()), KINDS), atol=1e-6)
    assert said == ()


@pytest.mark.parametrize("world", ALL, ids=str)
def test_what_a_file_does_not_say_is_found_by_gravity(world):
    ours, said = as_said(moving(world))
    np.testing.assert_allclose(channels(ours, KINDS), channels(moving(World()), KINDS), atol=1e-6)
    assert said == (() if world == World() else (f"orientations taken as {world}, as gravity shows",))


def test_a_file_that_says_another_world_than_gravity_is_corrected_with_a_note():
    ours, said = as_said(moving(World("z")), World("y"))
    np.testing.assert_allclose(channels(ours, KINDS), channels(moving(World()), KINDS), atol=1e-6)
    assert said == (
        "orientations are said to be y up, from sensor to world; gravity shows z up, from sensor to world: taken so",
    )
    given = moving(World())
    wild = rot.normalize(np.random.default_rng(0).normal(size=(len(given), 4)))
    with pytest.raises(RequestError, match="orientations do not agree with gravity in any world"):
        as_said(replace(given, orientation=wild), World("y"))


@pytest.mark.parametrize("world", ALL, ids=str)
def test_orientations_of_segments_become_those_of_sensors(world):
    given = moving(world)
    mounts = rot.exp(np.array([[1.5, -1.0, 0.6], [-0.8, 1.9, 0.4]]))[given.sensors]
    back = rot.conjugate(mounts)
    q = given.orientation
    turned = rot.multiply(mounts, q) if world.inverse else rot.multiply(q, back)
    ours, said = as_said(replace(given, orientation=turned))
    assert np.degrees(rot.angle_between(ours.orientation, moving(World()).orientation)).max() < 3.0
    assert len(said) == 1
    assert said[0].startswith("orientations are of segments, not of the sensors")


def test_orientations_that_no_gyroscope_agrees_with_are_refused():
    given = moving(World())
    noise = np.random.default_rng(0).normal(size=(len(given), 1))
    wrong = replace(given, angular=given.angular[:, [1, 2, 0]] * noise)
    with pytest.raises(RequestError, match=r"sensor 'left': orientations do not rotate as its gyroscope says"):
        orientations_of_sensors(wrong)


def test_one_axis_of_rotation_is_not_enough():
    given = moving(World())
    q = rot.about("x", np.repeat(np.sin(np.arange(400) / 20.0), 2))
    rates = np.repeat(np.cos(np.arange(400) / 20.0) * 5.0, 2)[:, None] * [1.0, 0.0, 0.0]
    with pytest.raises(RequestError, match="sensor 'left': it rotates about one axis only"):
        orientations_of_sensors(replace(given, orientation=q, angular=rates))


def test_a_file_that_says_its_world_is_believed_in_fast_movement_too():
    given = moving(World())
    fast = given.force + np.random.default_rng(0).normal(scale=6.0, size=given.force.shape)
    hasty = replace(given, force=9.81 * fast / np.linalg.norm(fast, axis=1, keepdims=True), angular=None)
    with pytest.raises(RequestError, match="orientations do not agree with gravity in any world"):
        as_said(hasty)
    ours, said = as_said(hasty, World())
    np.testing.assert_array_equal(ours.orientation, given.orientation)
    assert said == ()
