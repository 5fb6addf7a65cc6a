"""Kinetograph: new human motion out of recorded examples.

Three controls, one library of recordings: a performance (a drawn path, a partner), keyframes, body-worn sensors.
Heavy modules are imported on first use, so that ``import kinetograph`` stays quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_EXPORTS = {
    "Annotation": "take",
    "Key": "keys",
    "KeyframeControl": "methods.keyframe",
    "Landmark": "skeleton",
    "Library": "library",
    "Motion": "motion",
    "PerformanceControl": "methods.performance",
    "Piece": "synthesis",
    "Readings": "readings",
    "SensorControl": "methods.sensor",
    "Signal": "signal",
    "Skeleton": "skeleton",
    "Synthesis": "synthesis",
    "Take": "take",
    "load": "formats",
    "save": "formats",
}

__all__ = [
    "Annotation",
    "Key",
    "KeyframeControl",
    "Landmark",
    "Library",
    "Motion",
    "PerformanceControl",
    "Piece",
    "Readings",
    "SensorControl",
    "Signal",
    "Skeleton",
    "Synthesis",
    "Take",
    "__version__",
    "load",
    "save",
]


def __getattr__(name: str) -> Any:
    if name not in _EXPORTS:
        raise AttributeError(f"module 'kinetograph' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.{_EXPORTS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.formats import load, save
    from kinetograph.keys import Key
    from kinetograph.library import Library
    from kinetograph.methods.keyframe import KeyframeControl
    from kinetograph.methods.performance.model import PerformanceControl
    from kinetograph.methods.sensor.model import SensorControl
    from kinetograph.motion import Motion
    from kinetograph.readings import Readings
    from kinetograph.signal import Signal
    from kinetograph.skeleton import Landmark, Skeleton
    from kinetograph.synthesis import Piece, Synthesis
    from kinetograph.take import Annotation, Take
