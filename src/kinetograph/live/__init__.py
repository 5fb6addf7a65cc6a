"""Live sessions: sources of devices, through a model, to sinks, frame by frame.

`parse_source` and `parse_sink` make sources and sinks of what a person writes, a driver holds the model, and `Session`
joins them. Rooms are imported on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

_ROOMS = {
    "Clock": "session",
    "Driver": "session",
    "ListenDriver": "recording",
    "PathDriver": "performing",
    "RecordDriver": "recording",
    "SensorDriver": "sensing",
    "Session": "session",
    "Sink": "sinks",
    "StreamSource": "sources",
    "parse_sink": "sinks",
    "parse_source": "sources",
    "qr_code": "sources.phone_server",
    "qr_modules": "sources.phone_server",
    "speed_of": "sources",
}

__all__ = [
    "Clock",
    "Driver",
    "ListenDriver",
    "PathDriver",
    "RecordDriver",
    "SensorDriver",
    "Session",
    "Sink",
    "StreamSource",
    "parse_sink",
    "parse_source",
    "qr_code",
    "qr_modules",
    "speed_of",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'kinetograph.live' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.live.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.live.performing import PathDriver
    from kinetograph.live.recording import ListenDriver, RecordDriver
    from kinetograph.live.sensing import SensorDriver
    from kinetograph.live.session import Clock, Driver, Session
    from kinetograph.live.sinks import Sink, parse_sink
    from kinetograph.live.sources import StreamSource, parse_source, speed_of
    from kinetograph.live.sources.phone_server import qr_code, qr_modules
