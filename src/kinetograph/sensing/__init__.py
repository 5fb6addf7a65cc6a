"""Body-worn sensors: what they report, where they sit, how they are simulated, brought to one clock and calibrated."""

from kinetograph.sensing.calibration import Calibration, calibrate
from kinetograph.sensing.clock import ClockOffset, clock_offset
from kinetograph.sensing.device import Device
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
    "clock_offset",
    "preset",
    "simulate",
    "specific_force",
    "uniform",
]
