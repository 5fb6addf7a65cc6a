"""Copies of takes in a library: two fits, two numbers, cut out, mirrored, shifted in time, at another rate or place."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.learn.near_copies import Lookup, Match, Nearness, Sequences, joined, matches
from kinetograph.library import Library, folders_of
from kinetograph.library.fingerprints import of_takes
from kinetograph.pipeline.finding import RATE, Group, index_of
from kinetograph.progress import Progress
from kinetograph.skeleton import opposite
from kinetograph.work import HERE, Workers, in_shards, require_seen

WHOLE = 0.95
"""The share of a take that counts as all of it."""
_BLOCK = 16  # motions of a shard


@dataclass(frozen=True)
class Copy:
    """Two takes that are copies of each other for some time.

    Parameters
    ----------
    take, track : str
    other, other_track : str
    mirrored : bool
        Whether one is like the other's mirror image.
    start, other_start : float
        Seconds into each take at which they begin to agree.
    seconds : float
        How long they do, in time of the first.
    speed : float
        How much faster the other plays; 1 but for clocks and changes of speed.
    distance : float
        Root mean square of what parts of the body, as seen from the root, and what they move in 0.2 s, differ by:
        metres on the first body.
    holds : str
        ``"both"`` where they are copies all through, or the name of the take that holds all of the other; else empty.
    """

    take: str
    track: str
    other: str
    other_track: str
    mirrored: bool
    start: float
    other_start: float
    seconds: float
    speed: float
    distance: float
    holds: str


def find_copies(
    library: Library,
    nearness: Nearness | None = None,
    workers: Workers | Executor = HERE,
    progress: Progress | None = None,
) -> tuple[Copy, ...]:
    """All pairs of takes of a library that are copies of each other, or of parts of each other.

    Takes whose skeletons have the same roles are compared. What stands still is no copy of anything.

    Parameters
    ----------
    library : Library
    nearness : Nearness, optional
        What counts as a copy.
    workers : Workers or Executor, optional
        Who compares.
    progress : Progress, optional
        Called with the shards done and their number.

    Returns
    -------
    tuple of Copy
        The longest first.
    """
    index = index_of(library, workers)
    used = nearness or Nearness()
    shards = [
        (library, number, range(first, min(first + _BLOCK, len(group.tracks))), used)
        for number, group in enumerate(index.groups)
        for first in range(0, len(group.tracks), _BLOCK)
    ]
    found: dict[int, list[Match]] = {}
    done = in_shards(_compare, shards, workers, count=len(shards), progress=progress)
    for (_, number, _, _), some in zip(shards, done, strict=True):
        found.setdefault(number, []).extend(some)
    copies = [copy for number, some in found.items() for copy in _described(index.groups[number], joined(some))]
    return tuple(sorted(copies, key=lambda copy: -copy.seconds))


def copies_of(library: Library, take: str, nearness: Nearness | None = None) -> tuple[str, ...]:
    """The other takes of a library that are copies of a take, or of a part of it, or hold one.

    Parameters
    ----------
    library : Library
    take : str
    nearness : Nearness, optional
        What counts as a copy.

    Returns
    -------
    tuple of str
        In the library's order.

    Raises
    ------
    RequestError
        The library has no such take.
    """
    names = library.names()
    if take not in names:
        raise RequestError(f"{library.path}: no take {take!r} to compare with others")
    found: set[str] = set()
    for number, group in enumerate(index_of(library).groups):
        own = [motion for motion, (name, _) in enumerate(group.tracks) if name == take]
        lookup = _lookup(library, number) if own else None
        if lookup:
            found |= {group.tracks[each.second][0] for each in matches(lookup, own, nearness)}
    return tuple(name for name in names if name in found - {take})


def copies_among(library: Library, takes: Iterable[str] = ()) -> dict[str, tuple[str, ...]]:
    """The copies of some takes of a library, or of all, by take; those that have none are left out.

    Parameters
    ----------
    library : Library
    takes : iterable of str, optional

    Returns
    -------
    dict of str to tuple of str

    Raises
    ------
    RequestError
        The library has no such take.
    """
    found = {take: copies_of(library, take) for take in tuple(takes) or library.names()}
    return {take: copies for take, copies in found.items() if copies}


def _compare(shard: tuple[Library, int, range, Nearness]) -> list[Match]:
    library, number, motions, nearness = shard
    require_seen(*folders_of(library))
    lookup = _lookup(library, number)
    return list(matches(lookup, motions, nearness, later=True)) if lookup else []


def _lookup(library: Library, number: int) -> Lookup | None:
    return _made_lookup(_Held(library, of_takes(library)), number)


@dataclass(frozen=True)
class _Held:
    """A library as it was when its takes had these digests."""

    library: Library
    digests: str

    def __hash__(self) -> int:
        return hash(self.digests)


@functools.lru_cache(maxsize=2)
def _made_lookup(held: _Held, number: int) -> Lookup | None:
    """What the motions of a group are compared by; one is kept for as long as the library stays as it is."""
    return Lookup.of(_sequences(index_of(held.library).groups[number]))


def _sequences(group: Group) -> Sequences:
    swap = [
        group.roles.index(opposite(role)) if opposite(role) in group.roles else i for i, role in enumerate(group.roles)
    ]
    return Sequences(group.windows.rows, group.windows.offsets, np.array(swap))


def _described(group: Group, found: Sequence[Match]) -> Iterator[Copy]:
    lengths = np.diff(group.windows.offsets)
    for each in found:
        (take, track), (other, other_track) = group.tracks[each.first], group.tracks[each.second]
        if take == other:
            continue
        rows = each.stop - each.start
        whole = rows >= WHOLE * lengths[each.first]
        whole_other = rows * each.speed >= WHOLE * lengths[each.second]
        holds = "both" if whole and whole_other else other if whole else take if whole_other else ""
        starts = each.start / RATE, max(each.speed * each.start + each.shift, 0.0) / RATE
        yield Copy(
            *(take, track, other, other_track, each.mirrored, *starts, (rows - 1) / RATE, each.speed),
            *(float(group.legs[each.first]) * each.distance, holds),
        )
