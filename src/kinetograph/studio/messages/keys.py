"""What is said about keys."""

from __future__ import annotations

import msgspec

from kinetograph.studio.messages.frames import Message
from kinetograph.studio.project import KeyRow


class KeyPose(Message, frozen=True, tag="key_pose"):
    """Asks for the pose of a key as a clip of one frame: the root above the origin, with the heading 0."""

    id: int
    row: KeyRow


class KeyEnds(Message, frozen=True, tag="key_ends"):
    """Asks where the hands and feet of a key are (`EndPlaces`)."""

    id: int
    row: KeyRow


class KeysMet(Message, frozen=True, tag="keys_met"):
    """Asks when and where the project's keys are met in what is shown (`Met`)."""

    id: int


class Alternative(Message, frozen=True, tag="alternative"):
    """Asks for one of the motions through the keys as a clip; the first is number 0."""

    id: int
    number: int


class KeyTrouble(Message, frozen=True, tag="key_trouble"):
    """Asks which of the project's keys cannot be met (`Trouble`)."""

    id: int


class EndPlaces(Message, frozen=True, tag="end_places"):
    """Where the hands and feet of a key are.

    Parameters
    ----------
    id : int
    ends : dict of str to (float, float, float)
        By role: metres from the root's place on the ground, in the frame of the root's heading.
    roles : tuple of str
        The parts of the body that may count.
    position : (float, float)
        Where the root is in its recording, metres x and z.
    heading : float
        Of the root in its recording, degrees.
    said : tuple of str
        What a person should know of them.
    positions : dict of str to (float, float, float)
        Where every part that may count is, in metres as those of hands and feet.
    orientations : dict of str to (float, float, float, float)
        The rotation of each part's joint in the same frame, a unit quaternion w, x, y, z.
    """

    id: int
    ends: dict[str, tuple[float, float, float]]
    roles: tuple[str, ...]
    position: tuple[float, float]
    heading: float
    said: tuple[str, ...] = ()
    positions: dict[str, tuple[float, float, float]] = msgspec.field(default_factory=dict)
    orientations: dict[str, tuple[float, float, float, float]] = msgspec.field(default_factory=dict)


class MetRow(msgspec.Struct, frozen=True):
    """When and where a key is met: seconds, metres x and z of the root, and its heading in degrees."""

    time: float
    position: tuple[float, float]
    heading: float


class Met(Message, frozen=True, tag="met"):
    """When and where the keys are met, one row per key."""

    id: int
    rows: tuple[MetRow, ...]


class Trouble(Message, frozen=True, tag="trouble"):
    """Why keys cannot be met.

    Parameters
    ----------
    id : int
    message : str
        Empty where they can.
    row : int, optional
        The key that it is about.
    seconds : float, optional
        How much later that key can be met.
    force : bool
        Whether the motion can be made all the same.
    """

    id: int
    message: str = ""
    row: int | None = None
    seconds: float | None = None
    force: bool = False
