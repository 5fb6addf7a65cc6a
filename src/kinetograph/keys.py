"""Keys: poses that a motion is to pass through, and when and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.motion import Motion, sample


@dataclass(frozen=True)
class PartFromRoot:
    """Where a part of the body is to be, as seen from the root.

    Parameters
    ----------
    role : str
        The part, one of `kinetograph.skeleton.ROLES`.
    position : tuple of float, (x, y, z), optional
        Metres from the root's place on the ground, in the frame of the root's heading: x to the left, z ahead. As in
        the key's pose unless given.
    orientation : tuple of float, (w, x, y, z), optional
        Unit quaternion of the part's joint in the same frame, the identity as at rest. Free unless given.

    Raises
    ------
    RequestError
        For neither of both, and for numbers that are not finite.
    """

    role: str
    position: tuple[float, float, float] | None = None
    orientation: tuple[float, float, float, float] | None = None

    def __post_init__(self) -> None:
        if self.position is None and self.orientation is None:
            raise RequestError(f"{self.role}: expected a position, an orientation or both, found neither")
        for name, count in (("position", 3), ("orientation", 4)):
            value = getattr(self, name)
            if value is not None and (len(value) != count or not np.isfinite(value).all()):
                raise RequestError(f"{self.role}: a part's {name} is {count} finite numbers, found {value}")
        if self.orientation is not None:
            size = float(np.linalg.norm(self.orientation))
            if abs(size - 1.0) > 1e-2:
                raise RequestError(
                    f"{self.role}: an orientation is a unit quaternion (w, x, y, z), found {size:g} long"
                )
            object.__setattr__(self, "orientation", tuple(float(v) / size for v in self.orientation))


@dataclass(frozen=True)
class PartInWorld(PartFromRoot):
    """Where a part of the body is to be in the world of the result.

    Parameters
    ----------
    role : str
        The part, one of `kinetograph.skeleton.ROLES`.
    position : tuple of float, (x, y, z), optional
        Metres, Y up. As in the key's pose unless given.
    orientation : tuple of float, (w, x, y, z), optional
        Unit quaternion of the part's joint, the identity as at rest. Free unless given.
    """


@dataclass(frozen=True, eq=False)
class Key:
    """A pose to be met.

    Parameters
    ----------
    clip : Motion
        Holds the pose; the neighbours of its frame, where there are any, give the velocity of the pose.
    frame : int, optional
        The frame of the pose in the clip.
    time : tuple of float, (earliest, latest), optional
        Seconds after the first key between which it is to be met; free unless given.
    position : tuple of float, (x, z), optional
        Where the root joint is to be above the ground, in metres; free unless given.
    heading : float, optional
        Heading of the root in radians, see `kinetograph.rotations.heading`; free unless given.
    roles : tuple of str, optional
        The parts of the body that count: each is met where it is in the pose as seen from the root, and rotated as
        there. The whole pose unless given, and where so many count, or a knee and its foot, that there is hardly
        another.
    label : str, optional
        What messages call it.
    parts : tuple of PartFromRoot or PartInWorld, optional
        Parts that are to be elsewhere than in the pose.

    Raises
    ------
    RequestError
        If the frame is outside the clip, times are negative or out of order, no joint plays one of the roles, or a
        part is given twice.
    """

    clip: Motion
    frame: int = 0
    time: tuple[float, float] | None = None
    position: tuple[float, float] | None = None
    heading: float | None = None
    roles: tuple[str, ...] | None = None
    label: str = "key"
    parts: tuple[PartFromRoot, ...] = ()

    def __post_init__(self) -> None:
        if not 0 <= self.frame < len(self.clip):
            raise RequestError(
                f"{self.label}: frame {self.frame} is outside its clip, which has frames 0 to {len(self.clip) - 1}"
            )
        if self.time is not None:
            low, high = float(self.time[0]), float(self.time[1])
            if not (np.isfinite(low) and np.isfinite(high) and 0 <= low <= high):
                raise RequestError(f"{self.label}: a time window is 0 <= earliest <= latest seconds, found {self.time}")
            object.__setattr__(self, "time", (low, high))
        for role in (*(self.roles or ()), *(part.role for part in self.parts)):
            self.clip.skeleton.landmark(role)
        named = [part.role for part in self.parts]
        if twice := [role for role in named if named.count(role) > 1]:
            raise RequestError(f"{self.label}: {twice[0]} is given two places; leave one out")


def key_at(
    clip: Motion,
    second: float,
    *,
    time: tuple[float, float] | None = None,
    position: tuple[float, float] | None = None,
    heading: float | None = None,
    roles: tuple[str, ...] | None = None,
    label: str = "key",
    parts: tuple[PartFromRoot, ...] = (),
) -> Key:
    """A key from the pose of a clip at a given second, with the half second on either side of it.

    Parameters
    ----------
    clip : Motion
    second : float
        Seconds in the clip.
    time, position, heading, roles, label, parts
        As those of `Key`.

    Returns
    -------
    Key

    Raises
    ------
    RequestError
        If the second is outside the clip.
    """
    if not 0 <= second <= clip.duration + 1e-6:
        raise RequestError(f"{label}: {second:g} s is outside its clip, which lasts from 0 to {clip.duration:.3f} s")
    before = int(np.floor(min(second, 0.5) * clip.fps + 1e-6))
    after = int(np.floor(min(clip.duration - second, 0.5) * clip.fps + 1e-6))
    times = second + np.arange(-before, max(after, 0) + 1) / clip.fps
    return Key(sample(clip, times, clip.fps), before, time, position, heading, roles, label, parts)


def check_order(keys: tuple[Key, ...]) -> None:
    """Check that there are two keys or more, in an order that their times allow.

    Parameters
    ----------
    keys : tuple of Key

    Raises
    ------
    RequestError
        If there are fewer than two, or one would have to be met before an earlier one.
    """
    if len(keys) < 2:
        raise RequestError(f"keyframe control goes from one key to another: expected 2 keys or more, found {len(keys)}")
    earliest, before = 0.0, keys[0].label
    for number, key in enumerate(keys, start=1):
        if key.time is None:
            continue
        if number > 1 and key.time[1] <= earliest:
            raise RequestError(
                f"keys are out of order: {key.label} (number {number}) is to be met by {key.time[1]:g} s, "
                f"but {before} not before {earliest:g} s; sort them by time"
            )
        earliest, before = max(earliest, key.time[0]), key.label
