"""Orientations of other worlds, found by gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.sensing import GRAVITY, Readings, World, channels, find_world, in_our_world


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
