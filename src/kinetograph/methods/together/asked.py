"""What is asked along the time line of a control: keys at times, in windows or at places, moves, pieces, contacts."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.performance import Control, Rule
from kinetograph.take import Annotation

WEIGHT = 0.2
"""What a squared metre costs by which the recording that is shown differs from a key, m^2 s: more makes seams worse."""
EARLY = 0.05
"""Seconds by which a key may be later than the end of its control: times are often rounded."""


@dataclass(frozen=True, eq=False)
class AskedKey:
    """A key on a control, and where on it.

    Parameters
    ----------
    key : Key
        Its time, where it has one, is in seconds of the control.
    along : float, optional
        Metres along the path at which it is to be met.
    near : tuple of float, (x, z), optional
        It is to be met where the path is nearest to this place.
    weight : float
        What a squared metre costs by which the recording that is shown differs from it, m^2 s.

    Raises
    ------
    RequestError
        Unless exactly one of time, ``along`` and ``near`` is given, and the weight is 0 or more.
    """

    key: Key
    along: float | None = None
    near: tuple[float, float] | None = None
    weight: float = WEIGHT

    def __post_init__(self) -> None:
        given = [each for each in (self.key.time, self.along, self.near) if each is not None]
        if len(given) != 1:
            raise RequestError(
                f"{self.key.label}: on a path a key has a time, or a place along it ('at'): one of them, "
                f"found {len(given)}"
            )
        if not (np.isfinite(self.weight) and self.weight >= 0):
            raise RequestError(f"{self.key.label}: a weight is 0 or more, found {self.weight}")

    @property
    def placed(self) -> bool:
        """Whether it is met at a place along the control, whenever that is."""
        return self.key.time is None


@dataclass(frozen=True)
class Span:
    """A span of the control that is to begin or end with one foot.

    Parameters
    ----------
    start, stop : float
        Seconds of the control.
    first, last : str
        ``left`` or ``right``, the foot that is set down first or last in it; empty where either may be.
    """

    start: float
    stop: float
    first: str = ""
    last: str = ""

    def __str__(self) -> str:
        feet = " and ".join(f"the {side} foot {word}" for word in ("first", "last") if (side := getattr(self, word)))
        return f"{feet or 'any feet'} from {self.start:g} to {self.stop:g} s"


@dataclass(frozen=True, eq=False)
class Asked:
    """All that is asked of a motion besides its control.

    Parameters
    ----------
    keys : tuple of AskedKey
        In order of time.
    rules : tuple of Rule
        Pieces that are pinned or forbidden, and moves by name.
    feet : tuple of Span
    contacts : tuple of Annotation
        Feet that are to stay where they are, in seconds of the control.
    fill : bool, optional
        Around keys that no segment is like, recordings are played that have them: where keys ask for places, and the
        control waits; True for those that ask for times too, in their time; False for none.
    """

    keys: tuple[AskedKey, ...] = ()
    rules: tuple[Rule, ...] = ()
    feet: tuple[Span, ...] = ()
    contacts: tuple[Annotation, ...] = ()
    fill: bool | None = None

    def __bool__(self) -> bool:
        return bool(self.keys or self.rules or self.feet or self.contacts)


@dataclass(frozen=True)
class Several:
    """How many motions are made of a request.

    Parameters
    ----------
    count : int
        At most.
    alike : bool
        Whether they may share pieces, reuse being free.

    Raises
    ------
    RequestError
        Unless there is one or more.
    """

    count: int = 1
    alike: bool = False

    def __post_init__(self) -> None:
        if self.count < 1:
            raise RequestError(f"alternatives are 1 motion or more, found {self.count}")


def timed(asked: Sequence[AskedKey], control: Control) -> tuple[AskedKey, ...]:
    """Keys with their times: a place along the path becomes the time at which the path is there.

    Parameters
    ----------
    asked : sequence of AskedKey
    control : Control
        As it is performed.

    Raises
    ------
    RequestError
        For a key outside the control, and for keys out of order.
    """
    keys = tuple(_timed(each, control) for each in asked)
    for before, after in itertools.pairwise(keys):
        assert before.key.time is not None
        assert after.key.time is not None
        if after.key.time[1] <= before.key.time[0]:
            raise RequestError(
                f"keys are out of order: {after.key.label} is at {_seconds(after.key.time)}, but {before.key.label} "
                f"before it at {_seconds(before.key.time)}; sort them by time, and give no two the same"
            )
    return keys


def require_within(asked: Asked, control: Control) -> None:
    """Raise RequestError for a span that is not within the control.

    Parameters
    ----------
    asked : Asked
    control : Control
        As it is performed.
    """
    end = control.duration
    spans: tuple[Rule | Span | Annotation, ...] = (*asked.rules, *asked.feet, *asked.contacts)
    for each in spans:
        if each.start < 0 or each.stop > end + EARLY:
            what = each.label if isinstance(each, Annotation) else each
            outside = each.start if each.start < 0 else each.stop
            raise RequestError(f"{what}: {outside:g} s is outside the control, which lasts from 0 to {end:.2f} s")


def _timed(asked: AskedKey, control: Control) -> AskedKey:
    key, length = asked.key, control.duration
    if key.time is not None:
        if key.time[1] > length + EARLY:
            raise RequestError(
                f"{key.label}: {_seconds(key.time)} is outside the control, which lasts from 0 to {length:.2f} s"
            )
        return replace(asked, key=replace(key, time=(min(key.time[0], length), min(key.time[1], length))))
    second = _second_along(asked, control)
    return replace(asked, key=replace(key, time=(second, second)), along=None, near=None)


def _second_along(asked: AskedKey, control: Control) -> float:
    """When the middle of the control's points is at a place of it."""
    ground = middle_of(control.points)
    if asked.near is not None:
        return float(np.argmin(np.abs(ground - complex(asked.near[1], asked.near[0])))) / control.fps
    assert asked.along is not None
    gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(ground)))])
    if not 0 <= asked.along <= gone[-1] + 0.01:
        raise RequestError(
            f"{asked.key.label}: {asked.along:g} m along the path is outside it: it is {gone[-1]:.2f} m long"
        )
    return float(np.searchsorted(gone, min(asked.along, gone[-1]) - 1e-9)) / control.fps


def middle_of(points: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
    """Where the middle of control points ``(F, P, 3)`` is above the ground, z + i x in metres ``(F,)``."""
    middle = points.mean(axis=1)
    return np.asarray(middle[:, 2] + 1j * middle[:, 0])


def _seconds(time: tuple[float, float]) -> str:
    return f"{time[0]:g} s" if time[0] == time[1] else f"{time[0]:g} to {time[1]:g} s"
