"""Phones as sensors: a page that they open, and the rows that it sends back over a WebSocket.

The page asks the browser for device motion: specific force with gravity, and angular velocity. A phone reaches it by a
link with a token; browsers give motion to pages over HTTPS only, the loopback apart.
"""

from __future__ import annotations

import json
from importlib.resources import files

from kinetograph.live.rows import Row, Vector

PORT = 8765
"""The port that the page is served on unless set otherwise."""


def page() -> bytes:
    """The page, as it is served."""
    return files("kinetograph.live.sources").joinpath("phone.html").read_bytes()


def welcome(sensors: tuple[str, ...]) -> str:
    """The first message to a phone: where it may be worn."""
    return json.dumps({"sensors": list(sensors)})


def rows(message: str | bytes) -> list[Row]:
    """The row of a message; none for what is damaged."""
    try:
        values = json.loads(message)
        sensor, time = str(values["sensor"])[:80], float(values["t"])
        force, rate = _vector(values["force"]), values.get("rate")
        angular = None if rate is None else _vector(rate)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError):
        return []
    return [Row(sensor, time, force, angular)]


def _vector(values: list[float]) -> Vector:
    x, y, z = values
    return float(x), float(y), float(z)
