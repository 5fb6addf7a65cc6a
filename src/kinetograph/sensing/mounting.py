"""How sensors are worn: readings of sensors worn in one manner, as sensors worn in another would have given them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.readings import Mounting, Readings
from kinetograph.sensing.layout import Layout, keep_sensors
from kinetograph.sensing.readings import select_sensors


def mounting_of(layout: Layout, names: tuple[str, ...]) -> Mounting:
    """How a layout's sensors of some names are worn. Raises RequestError for a name that it does not have."""
    worn = {sensor.name: sensor for sensor in keep_sensors(layout, names).sensors}
    rotations = np.array([worn[name].rotation for name in names])
    return Mounting(layout.name, rotations, np.array([worn[name].bias for name in names]))


def worn_as(readings: Readings, layout: Layout) -> Readings:
    """What a layout's sensors would have read in place of those that were worn.

    Parameters
    ----------
    readings : Readings
        Without a mounting, they are taken as those of the layout's sensors.
    layout : Layout

    Returns
    -------
    Readings
        Of the sensors that the layout has too, in its order.

    Raises
    ------
    RequestError
        For readings of none of them.
    """
    names = tuple(name for name in layout.names if name in readings.names)
    if not names:
        wanted, there = ", ".join(layout.names), ", ".join(readings.names)
        raise RequestError(f"expected readings of some of {wanted}, found those of {there}")
    own = select_sensors(readings, names)
    if own.mounting is None:
        return own
    new = mounting_of(layout, names)
    across = rot.multiply(rot.conjugate(new.rotations), own.mounting.rotations)[own.sensors]
    force = rot.rotate(across, own.force - own.mounting.biases[own.sensors]) + new.biases[own.sensors]
    angular = None if own.angular is None else rot.rotate(across, own.angular)
    facing = None if own.orientation is None else rot.multiply(own.orientation, rot.conjugate(across))
    return replace(own, force=force, angular=angular, orientation=facing, mounting=new)
