"""Steering: a body that follows a stick, a goal point or the rest of a path, frame by frame.

Every tenth of a second a planner looks at what is wished for the next 1.5 s and decides whether what is playing goes on
or another frame follows; between decisions the body is corrected towards the wish, in part and slowly, turning about
the foot that is planted. Jumps are joined and planted feet held as `kinetograph.post.Player` does.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.performance.frame_planner import Playhead
from kinetograph.methods.performance.steered_body import SteeredBody, SteeringSettings
from kinetograph.methods.performance.steering_frames import UNIT, SteeringFrames
from kinetograph.methods.performance.wishes import (
    Goal,
    PathRest,
    Stick,
    Wish,
    WishedPath,
    ahead,
)
from kinetograph.post.inertialisation import Pose

TICK = 1_000_000_000
"""Ticks of a second: time is counted in whole nanoseconds."""
LONGEST = 1.0
"""Seconds of a step at most."""
FASTEST = 20.0
"""Metres per second of a stick at most: what is more was given in other units."""
LEASH = 0.5
"""Metres that the wished path is ahead of a body that cannot follow at most."""


class Chooser(Protocol):
    """Decides what a steered body plays."""

    @property
    def units(self) -> int:
        """How many units of wishes it looks at."""
        ...

    def choose(self, head: Playhead, wishes: FloatArray) -> int | None:
        """The row to jump to now, or None to go on; ``wishes`` are places ``z, x`` and facings, ``(units, 3)``."""
        ...


@dataclass(eq=False)
class Steering:
    """A body that is steered. Made by `PerformanceModel.steer`; `step` it frame by frame, for as long as it lasts.

    Parameters
    ----------
    frames : SteeringFrames
    chooser : Chooser
    settings : SteeringSettings
    place : tuple of (float, float)
        Metres, x and z, where the body stands at first.
    facing : float
        Radians from z to x, where it faces.
    """

    frames: SteeringFrames
    chooser: Chooser
    settings: SteeringSettings = field(default_factory=SteeringSettings)
    place: tuple[float, float] = (0.0, 0.0)
    facing: float = 0.0
    jumps: int = field(default=0, init=False)
    """How many jumps there were."""

    def __post_init__(self) -> None:
        self.path = WishedPath(self.settings.half_life, complex(self.place[1], self.place[0]), facing=self.facing)
        self.body = SteeredBody(self.frames, self.settings)
        self.body.jump(self.frames.calmest, self.path.place, self.path.facing)
        self._due = 0

    def step(self, velocity: npt.ArrayLike, facing: float | None, dt: float) -> Pose:
        """The pose ``dt`` seconds later, under a stick.

        Parameters
        ----------
        velocity : array_like, shape (2,) or (3,)
            Metres per second along the ground: x and z, or x, y and z.
        facing : float, optional
            Radians from z to x; None faces where it goes, and where it faced when it stops.
        dt : float
            Seconds, more than 0 and 1 at most.

        Returns
        -------
        Pose

        Raises
        ------
        RequestError
            For values that are not finite, another shape, or a step out of range.
        """
        if facing is not None and not np.isfinite(facing):
            raise RequestError(f"a facing is a finite number of radians, found {facing}")
        return self._run(Stick(_on_ground(velocity, "velocity", FASTEST), facing), dt)

    def step_to(self, goal: npt.ArrayLike, dt: float, *, speed: float = 1.2) -> Pose:
        """The pose ``dt`` seconds later, on the way to a goal point.

        Parameters
        ----------
        goal : array_like, shape (2,) or (3,)
            Metres: x and z, or x, y and z.
        dt : float
            Seconds, more than 0 and 1 at most.
        speed : float
            Metres per second on the way.

        Returns
        -------
        Pose

        Raises
        ------
        RequestError
            For values that are not finite, another shape, or out of range.
        """
        if not 0 < speed <= FASTEST:
            raise RequestError(f"speed must be more than 0 and {FASTEST:.0f} m/s at most, found {speed}")
        return self._run(Goal(_on_ground(goal, "goal"), speed), dt)

    def step_along(self, rest: npt.ArrayLike, fps: float, dt: float) -> Pose:
        """The pose ``dt`` seconds later, along the rest of a drawn path.

        Parameters
        ----------
        rest : array_like, shape (N, 2) or (N, 3)
            Where the path is from now on, metres: x and z, or x, y and z. It stays at its end.
        fps : float
            Points of the path per second.
        dt : float
            Seconds, more than 0 and 1 at most.

        Returns
        -------
        Pose

        Raises
        ------
        RequestError
            For values that are not finite, another shape, or out of range.
        """
        points = np.asarray(rest, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) == 0 or not np.isfinite(points).all():
            raise RequestError(f"a path is finite metres (N, 2) or (N, 3), found shape {points.shape}")
        if not 0 < fps < np.inf:
            raise RequestError(f"fps must be positive and finite, found {fps}")
        return self._run(PathRest(points[:, -1] + 1j * points[:, 0], float(fps)), dt)

    def _run(self, wish: Wish, dt: float) -> Pose:
        """Go on by ``dt`` seconds, decision by decision."""
        if not 0 < dt <= LONGEST:
            raise RequestError(f"a step is more than 0 and {LONGEST:.0f} s at most, found {dt}")
        left, pose = max(round(dt * TICK), 1), None
        while left > 0 or pose is None:
            if self._due <= 0:
                self._choose(ahead(wish, self.path, UNIT, self.chooser.units))
                self._due = round(UNIT * TICK)
            ticks = min(left, self._due)
            left, self._due = left - ticks, self._due - ticks
            part = ticks / TICK
            self.path = self._leashed(wish.after(self.path, part))
            wish = wish.later(part)
            pose = self.body.play(part, self.path)
        return pose

    @property
    def planted(self) -> BoolArray:
        """Which of `kinetograph.post.planted_roles` are in contact now in the recording that plays."""
        return self.body.planted

    def _choose(self, wishes: FloatArray) -> None:
        row = self.chooser.choose(self.body.playhead, wishes)
        if row is not None:
            self.body.jump(row, *self.body.stands())
            self.jumps += 1
        self.body.keep_up_with(complex(wishes[0, 0], wishes[0, 1]))

    def _leashed(self, path: WishedPath) -> WishedPath:
        """The wished path, no further from the body than it can make up."""
        gap = path.place - self.body.stands()[0]
        return path if abs(gap) <= LEASH else replace(path, place=path.place - gap * (1.0 - LEASH / abs(gap)))


def _on_ground(values: npt.ArrayLike, what: str, most: float = np.inf) -> complex:
    """``z + i x`` of a vector of two or three numbers."""
    given = np.asarray(values, dtype=np.float64)
    if given.shape not in ((2,), (3,)) or not np.isfinite(given).all() or np.abs(given).max() > most:
        limit = "" if most == np.inf else f", at most {most:.0f} m/s"
        raise RequestError(f"a {what} is finite numbers x, z or x, y, z in metres{limit}, found {values!r}")
    return complex(given[-1], given[0])
