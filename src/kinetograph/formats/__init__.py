"""Files of motions, signals, keys and sensor readings: readers and writers, chosen by the file's suffix.

Whatever a file's own units and axes, what is read is in metres, Y up, right-handed; no other package converts. The
readers of keys and of sensor readings are imported on first use, so that reading a motion stays quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from kinetograph.formats.atomic import atomic_path, together
from kinetograph.formats.body import body_of, capsule_character, dressed
from kinetograph.formats.capsules import Capsule, body_capsules, rest_positions, stature
from kinetograph.formats.files import READERS, WRITERS, load, read, read_character, save, stream
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions, WriteOptions
from kinetograph.formats.stances import with_stances

if TYPE_CHECKING:
    from kinetograph.formats.keys_json import KeySources, find_pose, key_from_text, read_keys, read_keys_from
    from kinetograph.formats.readings import read_layout, read_readings, write_layout, write_readings
    from kinetograph.formats.report_json import write_report
    from kinetograph.formats.request_json import Request, read_request, write_request
    from kinetograph.formats.sensor_recordings import (
        merge_sensors,
        read_kinect,
        read_qmt,
        read_utd,
        read_vicon_rotations,
        read_xsens,
    )

_LATER = {
    "KeySources": "keys_json",
    "Request": "request_json",
    "find_pose": "keys_json",
    "key_from_text": "keys_json",
    "merge_sensors": "sensor_recordings",
    "read_keys": "keys_json",
    "read_keys_from": "keys_json",
    "read_kinect": "sensor_recordings",
    "read_layout": "readings",
    "read_qmt": "sensor_recordings",
    "read_readings": "readings",
    "read_request": "request_json",
    "read_utd": "sensor_recordings",
    "read_vicon_rotations": "sensor_recordings",
    "read_xsens": "sensor_recordings",
    "write_layout": "readings",
    "write_readings": "readings",
    "write_report": "report_json",
    "write_request": "request_json",
}

__all__ = [
    "READERS",
    "WRITERS",
    "Capsule",
    "KeySources",
    "Loaded",
    "ReadOptions",
    "Request",
    "WriteOptions",
    "atomic_path",
    "body_capsules",
    "body_of",
    "capsule_character",
    "dressed",
    "find_pose",
    "key_from_text",
    "load",
    "merge_sensors",
    "read",
    "read_character",
    "read_keys",
    "read_keys_from",
    "read_kinect",
    "read_layout",
    "read_qmt",
    "read_readings",
    "read_request",
    "read_utd",
    "read_vicon_rotations",
    "read_xsens",
    "rest_positions",
    "save",
    "stature",
    "stream",
    "together",
    "unique",
    "with_stances",
    "write_layout",
    "write_readings",
    "write_report",
    "write_request",
]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_LATER[name]}"), name)
