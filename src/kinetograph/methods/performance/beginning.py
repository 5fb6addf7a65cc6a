"""How a motion begins: its first piece should face as the control does."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import Arrivals
from kinetograph.learn.placement import GroundPlacement
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.weights import weights

FIRST_FACING = 0.5
"""A weight, m^2 s per squared radian, that has walks begin facing as they are asked to, within some 10 degrees."""


def facing_first(fitted: Fitted, x: FloatArray, arrivals: Iterable[Arrivals]) -> Iterator[Arrivals]:
    """The arrivals of steps 1, 2, ..., dearer for states that the motion begins with and that face another way.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, 2, 3)
        A left and a right point at the search's rate.
    arrivals : iterable of Arrivals
    """
    longest = fitted.instances.longest
    for time, arrival in enumerate(arrivals, start=1):
        if time > longest:
            yield arrival
        else:
            dearer = fitted.settings.first_facing * _off(fitted, x[: time + 1]) ** 2
            yield replace(arrival, costs=arrival.costs + dearer)


def _off(fitted: Fitted, x: FloatArray) -> FloatArray:
    """By how many radians each state that ends at the last sample faces another way at the first; 0 if later begun."""
    settings, off = fitted.settings, np.zeros(len(fitted.instances.states))
    wanted = _across(x[0])
    for steps, examples in fitted.instances.controls.items():
        if steps < len(x) - 1:
            continue
        used = examples[:, -len(x) :]
        _, placed = settings.alignment.align(x[None], used, weights(settings, len(x)))
        if not isinstance(placed, GroundPlacement):
            raise RequestError(f"to begin facing a way, segments are placed on the ground; found {settings.alignment}")
        off[fitted.instances.members(steps)] = np.angle(placed.rotation[0] * _across(used[:, 0]) / wanted)
    return off


def _across(pair: FloatArray) -> FloatArray:
    """From right to left on the ground ``(..., 2, 3)``, as complex numbers ``z + i x``."""
    across = pair[..., 0, :] - pair[..., 1, :]
    return np.asarray(across[..., 2] + 1j * across[..., 0])
