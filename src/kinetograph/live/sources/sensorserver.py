"""SensorServer, an Android app: one sensor's values as JSON over a WebSocket, with gravity, as we have it."""

from __future__ import annotations

import json
from urllib.parse import quote

from kinetograph.errors import RequestError
from kinetograph.live.rows import Row, Vector

PORT = 8080
"""The port that the app listens on unless set otherwise."""
ACCELEROMETER, GYROSCOPE = "android.sensor.accelerometer", "android.sensor.gyroscope"


def address(host: str, port: int) -> str:
    """Where the app gives both sensors, as one stream."""
    kinds = quote(json.dumps([ACCELEROMETER, GYROSCOPE], separators=(",", ":")))
    return f"ws://{host}:{port}/sensors/connect?types={kinds}"


class Phone:
    """Makes rows of messages: each of the accelerometer has the latest angular velocity.

    Parameters
    ----------
    name : str
        What the sensor is called.
    """

    def __init__(self, name: str) -> None:
        if not name:
            raise RequestError("expected a name for the phone's sensor, such as right_wrist")
        self.name = name
        self._angular: Vector | None = None

    def receive(self, message: str | bytes) -> list[Row]:
        """The row of a message; none for other sensors and for what is damaged."""
        try:
            values = json.loads(message)
            kind = values.get("type", ACCELEROMETER)
            x, y, z = (float(value) for value in values["values"][:3])
            time = float(values["timestamp"]) / 1e9
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return []
        if kind == GYROSCOPE:
            self._angular = (x, y, z)
        return [Row(self.name, time, (x, y, z), self._angular)] if kind == ACCELEROMETER else []
