"""Body-worn sensors: what they report, where they sit, how they are simulated, brought to one clock and calibrated."""

from kinetograph.sensing.calibration import Calibration, calibrate, calibrate_on_motion, mounted
from kinetograph.sensing.clock import ClockOffset, clock_offset
from kinetograph.sensing.device import Device
from kinetograph.sensing.free_calibration import calibrate_freely, calibrate_on_library
from kinetograph.sensing.layout import PRESETS, Layout, Sensor, preset
from kinetograph.sensing.readings import Readings
from kinetograph.sensing.uniform import Resampling, uniform
from kinetograph.sensing.virtual import simulate, specific_force

__all__ = [
    "PRESETS",
    "Calibration",
    "ClockOffset",
    "Device",
    "Layout",
    "Readings",
    "Resampling",
    "Sensor",
    "calibrate",
    "calibrate_freely",
    "calibrate_on_library",
    "calibrate_on_motion",
    "clock_offset",
    "mounted",
    "preset",
    "simulate",
    "specific_force",
    "uniform",
]
