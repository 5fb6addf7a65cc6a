"""What is said about sensors."""

from __future__ import annotations

from typing import Literal

import msgspec

from kinetograph.studio.messages.frames import Message
from kinetograph.studio.project import Mode


class JointUncertainty(Message, frozen=True, tag="joint_uncertainty"):
    """Ask for the uncertainty of every joint of what was sensed last; answered by a blob with a `JointsHeader`."""

    id: int


class Listen(Message, frozen=True, tag="listen"):
    """Sense live: what the section's source sends drives a body."""


class Calibrate(Message, frozen=True, tag="calibrate"):
    """Calibrate the sensors of the section's layout, and save the layout as a file of the project.

    Parameters
    ----------
    source : str
        A file of the project with readings, or what is listened to live.
    still : (float, float), optional
        Of a file: the seconds between which its wearer stands still.
    ready, standing, moving : float
        Live: seconds before standing still, of standing still, and of moving as in the library.
    layout : str
        The file that is written, ending in .toml.
    """

    source: str
    still: tuple[float, float] | None = None
    ready: float = 3.0
    standing: float = 4.0
    moving: float = 20.0
    layout: str = "worn.toml"


class CallSensors(Message, frozen=True, tag="call_sensors"):
    """Call sensors by other names from now on, while listening.

    Parameters
    ----------
    names : dict of str to str
        Names of the layout by the names under which sensors are heard.
    """

    names: dict[str, str]


class HeardRow(msgspec.Struct, frozen=True):
    """What is heard of a sensor: rows a second, the share that was lost, rows that came late, and its latest force.

    Parameters
    ----------
    sensor : str
    rate : float
        Hz.
    lost : str
        Per cent.
    late : int
    force : float
        Its magnitude, m/s^2.
    known : bool
        Whether the layout has a sensor of that name.
    """

    sensor: str
    rate: float
    lost: str
    late: int
    force: float
    known: bool


class Heard(Message, frozen=True, tag="heard"):
    """Who is heard, once a second, and the layout's sensors."""

    rows: tuple[HeardRow, ...]
    sensors: tuple[str, ...]


class PhoneLink(Message, frozen=True, tag="phone_link"):
    """The link that a phone has to open, and its QR code.

    Parameters
    ----------
    link : str
    code : tuple of str
        Rows of ``1`` for dark and ``0`` for light modules; none without the extra.
    """

    link: str
    code: tuple[str, ...] = ()


class LiveEnded(Message, frozen=True, tag="live_ended"):
    """What ran live has come to its end, after so many frames."""

    section: Mode
    frames: int


class CalibrationStep(Message, frozen=True, tag="calibration_step"):
    """Where a calibration is: what the wearer does now, and the seconds that are left of it.

    Parameters
    ----------
    step : str
    left, total : float
        Seconds.
    """

    step: Literal["ready", "still", "moving", "solving"]
    left: float
    total: float


class CalibratedRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """How a sensor was calibrated.

    Parameters
    ----------
    sensor : str
    verdict : str
        ``good``, ``fair``, ``put it on again`` or ``not heard``.
    before, residual : float
        m/s^2, without and with calibration.
    like : float
        How much like another sensor's its readings are: 1 is as much as like its own.
    other : str
        That other sensor.
    apart : float
        Degrees between the rotations that halves of the movement give.
    rotated : float
        Degrees from the layout.
    """

    sensor: str
    verdict: str
    before: float = 0.0
    residual: float = 0.0
    like: float = 0.0
    other: str = ""
    apart: float = 0.0
    rotated: float = 0.0


class Calibrated(Message, frozen=True, tag="calibrated"):
    """Sensors that were calibrated.

    Parameters
    ----------
    layout : str
        The file that was written; empty where calibration is worse than none for every sensor.
    rows : tuple of CalibratedRow
    files : tuple of str
        The project's.
    """

    layout: str
    rows: tuple[CalibratedRow, ...]
    files: tuple[str, ...]


class JointsHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="joints"):
    """The header of a blob whose payload is a value for every joint at even times, as float32.

    Parameters
    ----------
    id : int
    fps : float
    joints : tuple of str
        Names of the joints, in order.
    frames : int
    """

    id: int
    fps: float
    joints: tuple[str, ...]
    frames: int
