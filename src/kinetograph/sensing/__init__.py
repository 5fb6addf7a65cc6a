"""Body-worn sensors, without any model of movement.

What sensors report (`Readings`), where they sit (`Layout`), how they are simulated (`simulate`), brought to one rate
(`uniform`, `LiveUniform`) and calibrated (`calibrate_on_motion`, `calibrate_on_library`). `SensorControl
<kinetograph.methods.sensor.SensorControl>` makes motion out of their readings.
"""

from kinetograph.readings import Mounting, Readings
from kinetograph.sensing.calibration import (
    Calibration,
    calibrate,
    calibrate_on_motion,
    faultless,
    motion_clock,
    mounted,
)
from kinetograph.sensing.clock import ClockOffset, clock_offset
from kinetograph.sensing.device import Device
from kinetograph.sensing.free_calibration import (
    LibraryReadings,
    Standing,
    calibrate_freely,
    calibrate_on_library,
    still_span,
)
from kinetograph.sensing.judging import Manner, Verdict, judged, verdict_on
from kinetograph.sensing.layout import PRESETS, Layout, Sensor, attach, keep_sensors, preset
from kinetograph.sensing.mounting import mounting_of, worn_as
from kinetograph.sensing.readings import (
    GRAVITY,
    KINDS,
    channels,
    check_names,
    check_units,
    kinds_of,
    may_leap,
    renumbered,
    select_rows,
    select_sensors,
    shifted,
)
from kinetograph.sensing.resampling import LiveUniform, Resampling, uniform
from kinetograph.sensing.segment_frames import orientations_of_sensors
from kinetograph.sensing.virtual import simulate, simulate_kinds, specific_force
from kinetograph.sensing.world import World, as_said, find_world, in_our_world

__all__ = [
    "GRAVITY",
    "KINDS",
    "PRESETS",
    "Calibration",
    "ClockOffset",
    "Device",
    "Layout",
    "LibraryReadings",
    "LiveUniform",
    "Manner",
    "Mounting",
    "Readings",
    "Resampling",
    "Sensor",
    "Standing",
    "Verdict",
    "World",
    "as_said",
    "attach",
    "calibrate",
    "calibrate_freely",
    "calibrate_on_library",
    "calibrate_on_motion",
    "channels",
    "check_names",
    "check_units",
    "clock_offset",
    "faultless",
    "find_world",
    "in_our_world",
    "judged",
    "keep_sensors",
    "kinds_of",
    "may_leap",
    "motion_clock",
    "mounted",
    "mounting_of",
    "orientations_of_sensors",
    "preset",
    "renumbered",
    "select_rows",
    "select_sensors",
    "shifted",
    "simulate",
    "simulate_kinds",
    "specific_force",
    "still_span",
    "uniform",
    "verdict_on",
    "worn_as",
]
