"""Requests that cannot be met, or only by motion that is worse than recordings are: what is said of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from kinetograph.errors import RequestError, TooSoonError, UnmetError
from kinetograph.keys import Key, PartInWorld
from kinetograph.learn import Goal, Route
from kinetograph.methods.keyframe.feasible import (
    Attempts,
    Found,
    at_time,
    in_words,
    least_time,
    metres_between,
    nearest_place,
)
from kinetograph.methods.keyframe.index import PoseIndex
from kinetograph.methods.keyframe.key_goals import pinned
from kinetograph.methods.keyframe.key_parts import Aim
from kinetograph.methods.keyframe.quality import Quality
from kinetograph.methods.keyframe.realize import path_ends
from kinetograph.post.assemble import PostSettings
from kinetograph.synthesis import Synthesis

SPARE, PLACED = 3, 2
"""Motions that are tried before a request is refused for how good they are, and where it asks for places."""
HURRY = 30.0
"""Cost of a second where the earliest time is looked for."""


class NoRouteError(RequestError):
    """Times and places that no route through the recordings meets."""


class Limits(Protocol):
    """Settings of a search that requests are refused by."""

    @property
    def longest(self) -> float:
        """Seconds of the longest interval."""

    @property
    def off_place(self) -> float:
        """Metres that a route may end away from a place."""

    @property
    def off_share(self) -> float:
        """Share of the distance between two places, in addition."""

    @property
    def force_timing(self) -> bool:
        """Whether motion that is worse than recordings is made all the same."""


class Searching(Protocol):
    """A search for motions from key to key."""

    @property
    def index(self) -> PoseIndex:
        """The recorded frames."""

    @property
    def settings(self) -> Limits:
        """Its settings."""

    def motions(self, keys: tuple[Key, ...], post: PostSettings) -> Iterator[tuple[Synthesis, Quality]]:
        """Different motions from key to key, however good they are, the best first."""

    def aims(self, keys: tuple[Key, ...]) -> tuple[Aim, ...]:
        """What is to be met at each key."""

    def goals(self, aims: tuple[Aim, ...]) -> tuple[list[Goal], list[float]]:
        """What keys ask of the search."""

    def routes(self, goals: list[Goal], haste: float | None = None) -> Iterator[Route]:
        """Different routes, the best first."""

    def narrowed(self) -> Searching:
        """The same search, quicker and less thorough."""


@dataclass(frozen=True, eq=False)
class Request:
    """Keys that cannot be met, up to the first that is not.

    Parameters
    ----------
    search : Searching
    keys : tuple of Key
        The last one is not met.
    post : PostSettings
    """

    search: Searching
    keys: tuple[Key, ...]
    post: PostSettings

    @property
    def attempts(self) -> Attempts:
        """Who tries requests in place of it."""
        return Attempts(partial(self._attempt, self.search.narrowed()), partial(self._attempt, self.search))

    def _attempt(self, search: Searching, keys: tuple[Key, ...]) -> tuple[Synthesis, bool]:
        """A motion through keys, and whether it would be given. Raises RequestError where there is none."""
        if self.search.settings.force_timing:
            return next(search.motions(keys, self.post))[0], True
        result, quality = _best(search, keys, self.post)
        return result, quality.good

    @property
    def placed(self) -> bool:
        """Whether it asks for places, which take longer to search for."""
        return are_placed(self.keys)

    @property
    def frame(self) -> float:
        """Seconds of a frame."""
        return 1.0 / self.search.index.fps

    @property
    def latest(self) -> float:
        """Seconds up to which it makes sense to look for a later time."""
        before = self.keys[-2].time
        return (before[1] if before is not None else self.asked) + self.search.settings.longest

    @property
    def asked(self) -> float:
        """The latest second at which the last key was to be met; 0 where its time is free."""
        time = self.keys[-1].time
        return 0.0 if time is None else time[1]


def _best(search: Searching, keys: tuple[Key, ...], post: PostSettings) -> tuple[Synthesis, Quality]:
    made = motions_through(search, keys, 1, post)
    return next((each for each in made if each[1].good), made[0])


def are_placed(keys: tuple[Key, ...]) -> bool:
    """Whether keys after the first ask for places."""
    return any(key.position is not None or _in_world(key) for key in keys[1:])


def _in_world(key: Key) -> bool:
    return any(isinstance(part, PartInWorld) and part.position is not None for part in key.parts)


def solve_or_refuse(search: Searching, keys: tuple[Key, ...], count: int, post: PostSettings) -> tuple[Synthesis, ...]:
    """Motions from key to key that are no worse than recordings are, the best first.

    Parameters
    ----------
    search : Searching
    keys : tuple of Key
    count : int
        How many different motions to look for.
    post : PostSettings
        How the pieces are joined.

    Raises
    ------
    RequestError
        Where there is none, with the nearest that can be asked for.
    """
    forced = search.settings.force_timing
    try:
        made = motions_through(search, keys, count, post)
    except (TooSoonError, NoRouteError) as error:
        if forced and isinstance(error, TooSoonError):
            raise
        raise _refused(_up_to_the_first_unmet(search, keys, post), error) from None
    if forced:
        return tuple(result if quality.good else _warned(result, quality) for result, quality in made)
    good = tuple(result for result, quality in made if quality.good)
    if good:
        return good[:count]
    return _at_other_times(search, keys, made[0], post)


def motions_through(
    search: Searching, keys: tuple[Key, ...], count: int, post: PostSettings
) -> list[tuple[Synthesis, Quality]]:
    """Motions through keys: as many as are asked for, and a few more while none of them is as good as recordings.

    Parameters
    ----------
    search : Searching
    keys : tuple of Key
    count : int
    post : PostSettings

    Raises
    ------
    RequestError
        Where there is none.
    """
    made = list[tuple[Synthesis, Quality]]()
    motions = search.motions(keys, post)
    spare = 1 if search.settings.force_timing else PLACED if are_placed(keys) else SPARE
    for _ in range(count + spare - 1):
        try:
            made.append(next(motions))
        except StopIteration:
            break
        if sum(quality.good for _, quality in made) >= count:
            break
    return made


def _warned(result: Synthesis, quality: Quality) -> Synthesis:
    return replace(result, warnings=(*result.warnings, f"at {quality.at:.2f} s {quality.words()}"))


def _at_other_times(
    search: Searching, keys: tuple[Key, ...], made: tuple[Synthesis, Quality], post: PostSettings
) -> tuple[Synthesis, ...]:
    """A motion that meets a key whose time is free a little later. Raises RequestError where there is none."""
    result, quality = made
    number = int(np.clip(np.searchsorted(result.met, quality.at - 1e-6), 1, len(keys) - 1))
    request, when = Request(search, keys[: number + 1], post), result.met[number]
    time = keys[number].time
    stop = result.met[number - 1] + search.settings.longest
    if time is None or time[1] > when + request.frame:
        within = stop if time is None else min(time[1], stop)
        later = _least(request, when + request.frame, within)
        if later is not None:
            return solve_or_refuse(search, at_time(keys, number, later[0]), 1, post)
    lasts = when - result.met[number - 1]
    what = f"from {keys[number - 1].label} to {keys[number].label} in {lasts:.2f} s {quality.words()}"
    found = None
    if time is not None:
        found = _least(request, time[1] + request.frame, request.latest)
    place = _nearest_place(request)
    raise _error(request, what, found, place)


def _least(request: Request, start: float, stop: float) -> tuple[float, Found] | None:
    """The least second from ``start`` to ``stop`` at which the last key is met by what is no worse than recorded."""
    return least_time(request.keys, (start, stop), request.frame, request.attempts, placed=request.placed)


def _up_to_the_first_unmet(search: Searching, keys: tuple[Key, ...], post: PostSettings) -> Request:
    """Keys up to the first that cannot be met after those before it."""
    for count in range(2, len(keys)):
        try:
            next(search.motions(keys[:count], post))
        except RequestError:
            return Request(search, keys[:count], post)
    return Request(search, keys, post)


def _refused(request: Request, error: RequestError) -> RequestError:
    """The error with the nearest time and place that can be asked for."""
    what = str(error)
    if isinstance(error, TooSoonError):
        start = request.asked + error.seconds
        found = _least(request, start, request.latest)
        return _error(request, what.removesuffix("; give it more time"), found, _nearest_place(request))
    key, place = request.keys[-1], None
    if key.position is not None:
        what = f"{key.label}: no route through the recordings leads to {in_words(key.position)}{_when(key)}"
        place = _nearest_place(request)
    start_at = _earliest(request)
    found = None
    if start_at is not None:
        found = _least(request, start_at, request.latest)
    return _error(request, what, found, place)


def _when(key: Key) -> str:
    if key.time is None:
        return ""
    low, high = key.time
    return f" at {low:g} s" if low == high else f" from {low:g} to {high:g} s"


def _error(request: Request, what: str, found: tuple[float, Found] | None, place: Found | None) -> RequestError:
    """An error that says what cannot be, and what can."""
    key, longest = request.keys[-1], request.search.settings.longest
    said = []
    if place is not None:
        nearest = place.keys[-1].position
        assert nearest is not None
        assert key.position is not None
        said.append(
            f"the nearest place then is {in_words(nearest)}, {metres_between(nearest, key.position):.2f} m away"
        )
    if found is not None:
        second, met = found
        lasts = second - met.result.met[-2]
        least = "a duration" if request.placed else "the least duration"
        said.append(f"{least} that is met, and no worse than the recordings, is {lasts:.2f} s")
        if len(request.keys) > 2:
            said[-1] += f", {key.label} at {second:.2f} s"
    else:
        said.append(
            f"no time that was tried, within {longest:g} s of the key before (longest), is met and no worse than the "
            "recordings"
        )
    if found is None and place is None:
        pinned_by = "leave the place or the heading free, or " if key.position or key.heading is not None else ""
        said.append(f"{pinned_by}add recordings that go between")
    text = f"{what}; {'; '.join(said)}"
    if " x as " in what:
        text += "; or force it (--force-timing)"
    nearest = None if place is None else place.keys[-1].position
    if found is not None and key.time is not None:
        return TooSoonError(text, key.label, found[0] - key.time[1], found[0], nearest)
    return UnmetError(text, key.label, None if found is None else found[0], nearest)


def _earliest(request: Request) -> float | None:
    """The earliest second after that asked for at which a route meets the last key, however good it is."""
    start = request.asked + request.frame
    if start > request.latest:
        return None
    later = replace(request.keys[-1], time=(start, request.latest))
    goals, _ = request.search.goals(request.search.aims((*request.keys[:-1], later)))
    route = next(request.search.routes(goals, HURRY), None)
    return None if route is None else route.clocks[-1] * request.frame


def _nearest_place(request: Request) -> Found | None:
    """The nearest place that the last key can have at its time; None where it has none, or no place is met."""
    search, keys = request.search, request.keys
    key = keys[-1]
    if key.position is None:
        return None
    goals, _ = search.goals(search.aims(keys))
    route = next(search.routes([*goals[:-1], replace(goals[-1], reach=np.inf)]), None)
    if route is None:
        return None
    aims = search.aims(keys)
    ends = path_ends(search.index, aims, route)
    before, settings = ends[-2], search.settings
    place, _ = pinned(aims[-2].key, first=len(keys) == 2)
    before = before if place is None else place

    def reach(at: complex) -> float:
        return settings.off_place + settings.off_share * abs(at - before)

    return nearest_place(keys, ends[-1], reach, request.attempts)
