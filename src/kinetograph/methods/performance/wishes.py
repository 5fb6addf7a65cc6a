"""What a body that is steered should do next: a place and a facing on the ground, predicted by damped springs.

Places on the ground are complex numbers ``z + i x``, facings angles from z to x: a facing ``a`` is the direction
``exp(i a)``.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray
from kinetograph.sampling import interpolate

HALF_LIFE = 0.2
"""Seconds in which half of a change of the stick is followed."""
STILL = 0.05
"""Metres per second below which a velocity is no facing."""
NEAR = 0.15
"""Metres from a goal within which a body keeps its facing."""
AROUND = 0.05
"""Seconds before and after, between which the velocity of a drawn path is measured."""


@dataclass(eq=False)
class WishedPath:
    """A point that follows a stick: its velocity and its facing are critically damped springs.

    Parameters
    ----------
    half_life : float
        Seconds.
    """

    half_life: float = HALF_LIFE
    place: complex = 0.0
    velocity: complex = 0.0
    acceleration: complex = 0.0
    facing: float = 0.0
    turning: float = 0.0
    _y: float = field(init=False)

    def __post_init__(self) -> None:
        self._y = 2.0 * np.log(2.0) / self.half_life

    def after(self, velocity: complex, facing: float, dt: float) -> WishedPath:
        """The point ``dt`` seconds later, exactly, under a stick that is held.

        Parameters
        ----------
        velocity : complex
            Metres per second.
        facing : float
            Radians; it is approached by the shorter way round.
        dt : float
            Seconds.

        Returns
        -------
        WishedPath
        """
        y, fade = self._y, float(np.exp(-self._y * dt))
        gap = self.velocity - velocity
        slope = self.acceleration + gap * y
        place = self.place + velocity * dt + gap / y + slope / y**2 - fade * (slope / y**2 + (gap + slope * dt) / y)
        new = velocity + fade * (gap + slope * dt)
        acceleration = fade * (self.acceleration - slope * y * dt)
        off = nearest_angle(self.facing - facing)
        rate = self.turning + off * y
        turned = facing + fade * (off + rate * dt)
        turning = fade * (self.turning - rate * y * dt)
        return WishedPath(self.half_life, place, new, acceleration, turned, turning)

    def moved(self, place: complex, velocity: complex, facing: float, dt: float) -> WishedPath:
        """The point where it is put, ``dt`` seconds later; its facing is a spring still."""
        return replace(self.after(velocity, facing, dt), place=place, velocity=velocity, acceleration=0j)

    @property
    def row(self) -> tuple[float, float, float]:
        """Its place ``z, x`` and its facing."""
        return self.place.real, self.place.imag, self.facing


class Wish(Protocol):
    """What a person wants of a body from now on."""

    def after(self, path: WishedPath, dt: float) -> WishedPath:
        """The wished point ``dt`` seconds later."""
        ...

    def later(self, dt: float) -> Wish:
        """The same wish ``dt`` seconds later."""
        ...


@dataclass(frozen=True)
class Stick:
    """A stick that is held.

    Parameters
    ----------
    velocity : complex
        Metres per second.
    facing : float, optional
        Radians; without one the body faces where it goes, and where it faced when it stops.
    """

    velocity: complex
    facing: float | None = None

    def after(self, path: WishedPath, dt: float) -> WishedPath:
        """See `Wish.after`."""
        facing = direction(self.velocity, path.facing) if self.facing is None else self.facing
        return path.after(self.velocity, facing, dt)

    def later(self, dt: float) -> Stick:
        """See `Wish.later`."""
        return self


@dataclass(frozen=True)
class Goal:
    """A point to go to and to stay at.

    Parameters
    ----------
    place : complex
        Metres.
    speed : float
        Metres per second on the way.
    """

    place: complex
    speed: float

    def after(self, path: WishedPath, dt: float) -> WishedPath:
        """See `Wish.after`."""
        velocity = towards(path.place, self.place, self.speed)
        near = abs(self.place - path.place) < NEAR
        return path.after(velocity, path.facing if near else direction(velocity, path.facing), dt)

    def later(self, dt: float) -> Goal:
        """See `Wish.later`."""
        return self


@dataclass(frozen=True, eq=False)
class PathRest:
    """The rest of a drawn path.

    Parameters
    ----------
    points : ndarray of complex, shape (N,)
        Metres, from ``-since`` seconds on; it stays at its end.
    fps : float
        Points per second.
    since : float
        Seconds.
    """

    points: ComplexArray
    fps: float
    since: float = 0.0

    def after(self, path: WishedPath, dt: float) -> WishedPath:
        """See `Wish.after`."""
        at = (self.since + dt + np.array([-AROUND, 0.0, AROUND])) * self.fps
        flat = interpolate(np.stack([self.points.real, self.points.imag], axis=1), at)
        before, here, behind = (complex(z, x) for z, x in flat)
        velocity = (behind - before) / (2 * AROUND)
        return path.moved(here, velocity, direction(velocity, path.facing), dt)

    def later(self, dt: float) -> PathRest:
        """See `Wish.later`."""
        return replace(self, since=self.since + dt)


def ahead(wish: Wish, path: WishedPath, unit: float, count: int) -> FloatArray:
    """Where the wished point will be at the ends of the next units.

    Parameters
    ----------
    wish : Wish
    path : WishedPath
    unit : float
        Seconds.
    count : int

    Returns
    -------
    ndarray, shape (count, 3)
        Places ``z, x`` and facings.
    """
    rows = []
    for _ in range(count):
        path, wish = wish.after(path, unit), wish.later(unit)
        rows.append(path.row)
    return np.array(rows)


def direction(velocity: complex, otherwise: float) -> float:
    """The facing of a velocity; of one below `STILL`, another."""
    return float(np.angle(velocity)) if abs(velocity) > STILL else otherwise


def nearest_angle(angle: float) -> float:
    """An angle without whole rounds, from -pi to pi."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def towards(place: complex, goal: complex, speed: float, braking: float = 0.5) -> complex:
    """The velocity that leads to a goal.

    Parameters
    ----------
    place, goal : complex
        Metres.
    speed : float
        Metres per second, kept until ``braking`` seconds before the goal.
    braking : float

    Returns
    -------
    complex
    """
    gap = goal - place
    away = abs(gap)
    return complex(gap / away * min(speed, away / braking)) if away > 1e-6 else 0j
