"""What of a control is compared with the recordings: points on the ground for walks, points of a body for partners.

A control, and the recorded track that was the control of a take, are turned into the same points. The method sees
these points only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions, velocities
from kinetograph.methods.performance.ground_path import hips_on_ground, path_on_ground, path_speeds
from kinetograph.motion import Motion
from kinetograph.readings import Readings
from kinetograph.signal import Signal
from kinetograph.take import Take

LIMB_ENDS: Mapping[str, float] = MappingProxyType(
    {"left_toe": 1.0, "right_toe": 1.0, "left_hand": 1.0, "right_hand": 1.0, "chest": 1.0}
)


class ControlPoints(Protocol):
    """How control points are taken from a control."""

    def recorded(self, take: Take, target: str) -> Motion | Signal:
        """The track of a take that was the control where ``target`` is the track to be made."""

    def points(self, control: Motion | Signal) -> FloatArray:
        """Control points ``(F, P, 3)`` in metres, at the control's own rate."""

    def weights(self) -> FloatArray:
        """Weights ``(P,)`` of the points."""

    @property
    def frame_by_frame(self) -> bool:
        """Whether the points of a character's frame need that frame alone."""

    @property
    def spatial(self) -> bool:
        """Whether the points lie in space, where examples may be rotated and moved."""

    def warnings(self, points: FloatArray, fps: float, speeds: tuple[float, float]) -> tuple[str, ...]:
        """What a person should know of a control that the library cannot meet.

        Parameters
        ----------
        points : ndarray, shape (F, P, 3)
            The control's.
        fps : float
            Their rate.
        speeds : tuple of float
            The library's least and greatest, m/s.
        """


@dataclass(frozen=True)
class GroundPath:
    """Two points on the ground, left and right of a moving centre: a drawn path, or a walker's hips (section 6.1).

    Parameters
    ----------
    hip_distance : float
        Metres between the two points, which weighs facing against position.
    """

    hip_distance: float = 0.3

    def __post_init__(self) -> None:
        if not (np.isfinite(self.hip_distance) and self.hip_distance > 0):
            raise RequestError(f"hip_distance must be a positive number, found {self.hip_distance}")

    def recorded(self, take: Take, target: str) -> Motion | Signal:
        """The target itself: a walker's own hips."""
        return take.motion(target)

    def points(self, control: Motion | Signal) -> FloatArray:
        """See `ControlPoints`."""
        if isinstance(control, Motion):
            return hips_on_ground(control, self.hip_distance)
        return path_on_ground(control, self.hip_distance)

    def weights(self) -> FloatArray:
        """See `ControlPoints`."""
        return np.ones(2)

    @property
    def frame_by_frame(self) -> bool:
        """See `ControlPoints`."""
        return True

    @property
    def spatial(self) -> bool:
        """See `ControlPoints`."""
        return True

    def warnings(self, points: FloatArray, fps: float, speeds: tuple[float, float]) -> tuple[str, ...]:
        """Where a path asks, over half a second, for more or for less speed than the library has."""
        window = max(round(0.5 * fps), 1)
        path = path_speeds(points, fps)
        if len(path) < window:
            return ()
        asked = np.convolve(path, np.ones(window) / window, mode="valid")
        (slowest, fastest), warnings = speeds, []
        if asked.max() > fastest * 1.05:
            warnings.append(
                f"the path asks for {asked.max():.2f} m/s where the library's fastest segment gives {fastest:.2f} m/s: "
                f"performed as well as it can be; slow it down by {asked.max() / fastest:.1f} or add faster recordings"
            )
        if asked.min() < slowest * 0.95:
            warnings.append(
                f"the path slows to {asked.min():.2f} m/s where the library's slowest segment gives {slowest:.2f} m/s: "
                "the steps there are squeezed together; add recordings of slow walking and of standing"
            )
        return tuple(warnings)


@dataclass(frozen=True)
class PointsByRole:
    """Points of another character by the roles they play (section 6.2), or the points of a signal.

    Parameters
    ----------
    roles : mapping of str to float
        Weights by role, or by the name of a signal's point.
    velocity : float
        Seconds by which velocity is weighed against position. A point becomes two, this far ahead of it and behind it
        at its own velocity, which adds ``velocity ** 2`` times the squared difference of velocities to that of
        positions.
    track : str, optional
        Track of the library's takes that was the control; without it, the only other one than the target.
    """

    roles: Mapping[str, float] = field(default_factory=lambda: LIMB_ENDS)
    velocity: float = 0.0
    track: str | None = None

    def __post_init__(self) -> None:
        if not self.roles or not all(np.isfinite(w) and w > 0 for w in self.roles.values()):
            raise RequestError(f"control points need positive weights by role, found {dict(self.roles)}")
        if not (np.isfinite(self.velocity) and self.velocity >= 0):
            raise RequestError(f"velocity must be 0 s or more, found {self.velocity}")
        object.__setattr__(self, "roles", MappingProxyType(dict(self.roles)))

    def recorded(self, take: Take, target: str) -> Motion | Signal:
        """The partner's track. Raises RequestError, naming the tracks there are."""
        return _other_track(take, target, self.track)

    def points(self, control: Motion | Signal) -> FloatArray:
        """See `ControlPoints`. Raises RequestError for a role, or a signal's point, that is not there."""
        positions = role_positions(control, tuple(self.roles)) if isinstance(control, Motion) else self._named(control)
        if not self.velocity:
            return positions
        ahead = self.velocity * velocities(positions, control.fps)
        return np.concatenate([positions + ahead, positions - ahead], axis=1)

    def _named(self, control: Signal) -> FloatArray:
        missing = [role for role in self.roles if role not in control.names]
        if not control.spatial or missing:
            raise RequestError(
                f"the control has no point {', '.join(missing)}; its columns are {', '.join(control.names[:8])}"
            )
        return control.values[:, [control.names.index(role) for role in self.roles]]

    def weights(self) -> FloatArray:
        """See `ControlPoints`."""
        weights = np.array(list(self.roles.values()), dtype=np.float64)
        return np.tile(0.5 * weights, 2) if self.velocity else weights

    @property
    def frame_by_frame(self) -> bool:
        """See `ControlPoints`."""
        return self.velocity == 0

    @property
    def spatial(self) -> bool:
        """See `ControlPoints`."""
        return True

    def warnings(self, points: FloatArray, fps: float, speeds: tuple[float, float]) -> tuple[str, ...]:
        """Nothing: a partner's speed is not bound to that of the one who is led."""
        return ()


@dataclass(frozen=True)
class Channels:
    """Channels of a signal that lie in no space, such as features of speech (chapter 7).

    The target stays where it was recorded, or goes on from where it is: the alignment is `Fixed` or `Continued`.

    Parameters
    ----------
    channels : mapping of str to float
        Weights by name: what a unit of each counts compared with a metre of continuity.
    track : str, optional
        See `PointsByRole`.
    """

    channels: Mapping[str, float]
    track: str | None = None

    def __post_init__(self) -> None:
        if not self.channels or not all(np.isfinite(w) and w > 0 for w in self.channels.values()):
            raise RequestError(f"channels need positive weights by name, found {dict(self.channels)}")
        object.__setattr__(self, "channels", MappingProxyType(dict(self.channels)))

    def recorded(self, take: Take, target: str) -> Motion | Signal:
        """The other track than the target. Raises RequestError, naming the tracks there are."""
        return _other_track(take, target, self.track)

    def points(self, control: Motion | Signal) -> FloatArray:
        """A channel a point, ``(F, C, 3)``, on the first axis. Raises RequestError for a channel that is not there."""
        names = control.names if isinstance(control, Signal) and not control.spatial else ()
        missing = [name for name in self.channels if name not in names]
        if missing or isinstance(control, Motion):
            found = f"its channels are {', '.join(names[:8])}" if names else "it has none"
            raise RequestError(f"the control has no channel {', '.join(missing)}; {found}")
        points = np.zeros((len(control), len(self.channels), 3))
        points[..., 0] = control.values[:, [names.index(name) for name in self.channels]]
        return points

    def weights(self) -> FloatArray:
        """See `ControlPoints`."""
        return np.array(list(self.channels.values()), dtype=np.float64)

    @property
    def frame_by_frame(self) -> bool:
        """See `ControlPoints`."""
        return True

    @property
    def spatial(self) -> bool:
        """See `ControlPoints`."""
        return False

    def warnings(self, points: FloatArray, fps: float, speeds: tuple[float, float]) -> tuple[str, ...]:
        """Nothing: channels have no speed that a body could lack."""
        return ()


def _other_track(take: Take, target: str, wanted: str | None) -> Motion | Signal:
    """The track that was the control of ``target``: the one wanted or the only other. Raises RequestError."""
    others = {n: t for n, t in take.tracks.items() if n != target and not isinstance(t, Readings)}
    if wanted is None and len(others) == 1:
        return next(iter(others.values()))
    if wanted is None or wanted not in others:
        there = ", ".join(others) or "none"
        expected = "one other track" if wanted is None else f"a track {wanted!r}"
        raise RequestError(f"take {take.name!r}: expected {expected} to control {target!r}, found {there}")
    return others[wanted]
