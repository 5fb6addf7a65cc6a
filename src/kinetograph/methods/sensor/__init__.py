"""Sensor control (Xie 2009): a few body-worn accelerometers drive a whole body."""

from kinetograph.methods.sensor.model import SensorControl, SensorModel, SensorSynthesis

__all__ = ["SensorControl", "SensorModel", "SensorSynthesis"]
