"""What could be asked for in place of a request that cannot be met: the nearest time and the nearest place.

Both are found by the search itself and are tried out before they are named: asked for, they are met.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.synthesis import Synthesis

Attempt = Callable[[tuple[Key, ...]], tuple[Synthesis, bool]]
"""Makes a motion through keys, and says whether it is good enough; raises RequestError where there is none."""

LATER = (0.15, 0.35, 0.6, 1.0, 1.5, 2.2, 3.0, 4.0, 5.5, 7.5, 10.0)
"""Seconds later that are tried, one after another."""
FAR = LATER[2::2]
"""The same where a place is asked for, which takes longer to search."""
COARSE = 0.25
"""Seconds to which a least time is found where a place is asked for."""
SHARES = (0.97, 0.5, 0.0)
"""How far a path is bent from where it ends towards a place, as shares of how far it may be."""


@dataclass(frozen=True)
class Attempts:
    """Who tries requests.

    Parameters
    ----------
    quick : callable
        Searches less thoroughly, for all that is not said in the end.
    whole : callable
        Searches as a request is searched for.
    """

    quick: Attempt
    whole: Attempt


@dataclass(frozen=True, eq=False)
class Found:
    """A request that is met.

    Parameters
    ----------
    keys : tuple of Key
        What is asked for.
    result : Synthesis
    """

    keys: tuple[Key, ...]
    result: Synthesis


def tried(keys: tuple[Key, ...], attempt: Attempt) -> Found | None:
    """A request with its result, where it is met and no worse than recordings are."""
    try:
        result, good = attempt(keys)
    except RequestError:
        return None
    return Found(keys, result) if good else None


def at_time(keys: tuple[Key, ...], number: int, second: float) -> tuple[Key, ...]:
    """Keys with one of them at a second of the result."""
    return (*keys[:number], replace(keys[number], time=(second, second)), *keys[number + 1 :])


def least_time(
    keys: tuple[Key, ...],
    span: tuple[float, float],
    frame: float,
    attempts: Attempts,
    *,
    placed: bool = False,
) -> tuple[float, Found] | None:
    """The least second, of those tried, at which the last of some keys is met and nothing is worse than recorded.

    Parameters
    ----------
    keys : tuple of Key
    span : tuple of float
        Seconds from which on, itself included, and up to which it is looked for.
    frame : float
        Seconds of a frame, to which the result is exact.
    attempts : Attempts
    placed : bool
        Whether a place is asked for, which takes longer to search: the result is exact to `COARSE` seconds then.

    Returns
    -------
    second : float
    found : Found
        None in place of both where there is none.
    """
    (start, stop), last, met = span, len(keys) - 1, list[float]()
    bad, finest = start - frame, max(COARSE if placed else frame, frame)
    if stop > start:
        known = tried((*keys[:last], replace(keys[last], time=(start, stop))), attempts.quick)
        met += [] if known is None else [known.result.met[last]]
    for second in _seconds(start, met[0] - frame if met else stop, frame, FAR if placed else LATER):
        if tried(at_time(keys, last, second), attempts.quick) is not None:
            met.append(second)
            break
        bad = second
    while met and min(met) - bad > 1.5 * finest:  # between the last that is not met and the first that is
        middle = bad + frame * round(0.5 * (min(met) - bad) / frame)
        if tried(at_time(keys, last, middle), attempts.quick) is None:
            bad = middle
        else:
            met.append(middle)
    for second in sorted(met):
        found = tried(at_time(keys, last, second), attempts.whole)
        if found is not None:
            return second, found
    return None


def _seconds(start: float, stop: float, frame: float, steps: tuple[float, ...]) -> Iterator[float]:
    for later in (0.0, *steps):
        second = frame * round((start + later) / frame)
        if second > stop + 1e-9:
            return
        yield second


def nearest_place(
    keys: tuple[Key, ...], end: complex, reach: Callable[[complex], float], attempts: Attempts
) -> Found | None:
    """The place nearest to that of the last of some keys at which it is met, on the line from where a path ends.

    Parameters
    ----------
    keys : tuple of Key
    end : complex
        Where a path ends that comes as near as it can, z + i x in metres.
    reach : callable
        How far from a place a path may end.
    attempts : Attempts
    """
    key = keys[-1]
    assert key.position is not None
    gap = complex(key.position[1], key.position[0]) - end
    for share in SHARES:
        far = min(reach(end), abs(gap))
        for _ in range(8):  # how far it may be bent depends on where it is bent to
            far = min(reach(end + far * gap / max(abs(gap), 1e-9)), abs(gap))
        place = end + share * far * gap / max(abs(gap), 1e-9)
        x, z = round(float(place.imag), 2), round(float(place.real), 2)
        moved = (*keys[:-1], replace(key, position=(x, z)))
        found = tried(moved, attempts.whole) if tried(moved, attempts.quick) is not None else None
        if found is not None:
            return found
    return None


def in_words(position: tuple[float, float]) -> str:
    """A place as messages have it."""
    return f"({position[0]:.2f}, {position[1]:.2f})"


def metres_between(one: tuple[float, float], other: tuple[float, float]) -> float:
    """Metres between two places."""
    return float(np.hypot(one[0] - other[0], one[1] - other[1]))
