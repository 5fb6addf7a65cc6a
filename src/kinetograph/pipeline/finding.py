"""Finding takes of a library: by words, and by an example of the motion."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray, IntArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.formats import ReadOptions, read
from kinetograph.learn.windows import Windows, apart
from kinetograph.library import Library, folders_of, kept
from kinetograph.methods.relative_pose import BODY, REACH, leg_length, relative_joints
from kinetograph.motion import Motion, cut
from kinetograph.progress import Progress
from kinetograph.take import Take
from kinetograph.work import HERE, Workers, in_shards, require_seen

RATE = 10.0
"""Frames per second at which motions are compared."""
LONGEST = 8.0
"""Seconds of an example that are compared."""

_FEWEST = 4  # roles
_BLOCK = 32  # takes of a shard
_FINE = 30.0  # hertz: velocities are taken at this rate or more


def matches(words: str, names: Iterable[str]) -> bool:
    """Whether every word is found in one of some names.

    Parameters
    ----------
    words : str
        Words with spaces between. One with ``*``, ``?`` or ``[`` is a pattern for a whole name; another may stand
        anywhere in it. Small and capital letters are the same.
    names : iterable of str

    Returns
    -------
    bool

    Examples
    --------
    >>> [matches(words, ("15_01", "walk")) for words in ("15 wal", "15_*", "*_01 walk", "*_02", "")]
    [True, True, True, False, True]
    """
    folded = [name.casefold() for name in names]
    return all(any(_matches(word, name) for name in folded) for word in words.casefold().split())


def _matches(word: str, name: str) -> bool:
    return fnmatch.fnmatchcase(name, word) if any(c in word for c in "*?[") else word in name


# ---- by example ----


@dataclass(frozen=True)
class Found:
    """A window of a take that is like an example.

    Parameters
    ----------
    take, track : str
    start, stop : float
        Seconds of the take.
    distance : float
        Root mean square over the window of how far the parts of the body, as seen from the root, and what they move in
        `REACH` seconds, are from the example's: metres, on the example's body.
    """

    take: str
    track: str
    start: float
    stop: float
    distance: float


@dataclass(frozen=True, eq=False)
class Group:
    """Motions whose skeletons have the same roles.

    Parameters
    ----------
    roles : tuple of str
    tracks : tuple of (str, str)
        The take and the track of each motion.
    legs : ndarray, shape (E,)
        Metres of each one's leg.
    windows : Windows
        Their features at `RATE`, laid end to end, in lengths of the leg.
    """

    roles: tuple[str, ...]
    tracks: tuple[tuple[str, str], ...]
    legs: FloatArray
    windows: Windows


@dataclass(frozen=True, eq=False)
class ExampleIndex:
    """What examples are compared with; see `index_takes`.

    Parameters
    ----------
    groups : tuple
        The motions, by the roles that they have in common.
    """

    groups: tuple[Group, ...]


_Indexed = tuple[tuple[str, ...], tuple[str, str], float, SingleArray]


def index_takes(takes: Iterable[Take], count: int = 0, progress: Progress | None = None) -> ExampleIndex:
    """Make the motions of takes ready for search by example.

    Parameters
    ----------
    takes : iterable of Take
    count : int
        How many there are, for the progress.
    progress : Progress, optional

    Returns
    -------
    ExampleIndex
        Without motions whose skeleton has hardly any roles.
    """
    parts: list[_Indexed] = []
    for done, take in enumerate(takes, start=1):
        parts += _indexed(take)
        if progress:
            progress(done, count)
    return _grouped(parts)


def index_of(library: Library, workers: Workers | Executor = HERE, progress: Progress | None = None) -> ExampleIndex:
    """What examples are compared with, of a library; it is kept beside the library.

    Parameters
    ----------
    library : Library
    workers : Workers or Executor, optional
        Who reads the takes.
    progress : Progress, optional
        Called with the blocks of takes done and their number, where the index is not there yet.

    Returns
    -------
    ExampleIndex
    """

    def make() -> ExampleIndex:
        names = library.names()
        blocks = [(library, names[first : first + _BLOCK]) for first in range(0, len(names), _BLOCK)]
        done = in_shards(_index_block, blocks, workers, count=len(blocks), progress=progress)
        return _grouped([part for of_block in done for part in of_block])

    return kept(library, "examples", (RATE, _FINE, REACH, BODY), make)


def _index_block(block: tuple[Library, tuple[str, ...]]) -> list[_Indexed]:
    library, names = block
    require_seen(*folders_of(library))
    return [part for name in names for part in _indexed(library.take(name))]


def _indexed(take: Take) -> Iterator[_Indexed]:
    for name, motion in _motions(take):
        roles = tuple(role for role in BODY if role in motion.skeleton.roles)
        if len(roles) >= _FEWEST:
            yield roles, (take.name, name), leg_length(motion.skeleton), _features(motion, roles)


def _motions(take: Take) -> Iterator[tuple[str, Motion]]:
    return ((name, track) for name, track in take.tracks.items() if isinstance(track, Motion))


def _grouped(parts: Sequence[_Indexed]) -> ExampleIndex:
    by_roles: dict[tuple[str, ...], list[_Indexed]] = {}
    for part in parts:
        by_roles.setdefault(part[0], []).append(part)
    return ExampleIndex(tuple(_group(roles, of) for roles, of in by_roles.items()))


def _group(roles: tuple[str, ...], of: Sequence[_Indexed]) -> Group:
    rows = [each for *_, each in of]
    offsets = np.concatenate([[0], np.cumsum([len(each) for each in rows])])
    legs = np.array([leg for _, _, leg, _ in of])
    return Group(roles, tuple(track for _, track, _, _ in of), legs, Windows(np.concatenate(rows), offsets))


def _features(motion: Motion, roles: tuple[str, ...]) -> SingleArray:
    """Joints seen from the root and what they move in `REACH` seconds, ``(F, 6 R)`` in lengths of the leg."""
    stride = max(int(motion.fps // _FINE), 1)
    bones = None if motion.bones is None else motion.bones[::stride]
    thin = Motion(motion.skeleton, motion.translation[::stride], motion.rotations[::stride], motion.fps / stride, bones)
    pose, velocity = relative_joints(thin, roles)
    times = np.arange(int(motion.duration * RATE + 1e-6) + 1) / RATE
    frames = np.clip((times * thin.fps).round().astype(np.int64), 0, len(thin) - 1)
    both = np.concatenate([pose[frames], velocity[frames] * REACH], axis=2) / leg_length(motion.skeleton)
    return np.asarray(both.reshape(len(frames), -1), dtype=np.float32)


def find_alike(
    index: ExampleIndex,
    example: Motion,
    *,
    count: int = 50,
    each: int = 1,
    without: Found | None = None,
    among: Collection[str] | None = None,
) -> list[Found]:
    """The windows that are most like an example, wherever on the ground and in whichever direction they are.

    Parameters
    ----------
    index : ExampleIndex
    example : Motion
        Its first ``LONGEST`` seconds are compared.
    count : int
        How many are found.
    each : int
        How many of one track; they do not overlap.
    without : Found, optional
        A window that is left out, with those that overlap it: where the example comes from.
    among : collection of str, optional
        The takes that are looked through; without it, all.

    Returns
    -------
    list of Found
        The nearest first.

    Raises
    ------
    RequestError
        For an example whose skeleton has hardly any roles.
    """
    roles, query = _query(example)
    found = []
    for group in index.groups:
        squares = _squares(group, query, roles)
        if squares is not None:
            _leave_out(squares, group, len(query), without, among)
            chosen = apart(squares, group.windows.offsets, len(query), count, each)
            found += [((group, *one), float(squares[group.windows.offsets[one[0]] + one[1]])) for one in chosen]
    leg = leg_length(example.skeleton)
    nearest = sorted(found, key=lambda one: one[1])[:count]
    return [_described(one, len(query), leg) for one in nearest]


def distances_from(index: ExampleIndex, example: Motion) -> Iterator[tuple[Group, FloatArray, int]]:
    """How far every window of an index is from an example, as `find_alike` measures it.

    Parameters
    ----------
    index : ExampleIndex
    example : Motion
        Its first ``LONGEST`` seconds are compared.

    Yields
    ------
    group : Group
    distances : ndarray, shape (N,)
        Of the window that begins at each row of the group, metres; infinite where it would reach beyond its motion.
    width : int
        Rows of a window.

    Raises
    ------
    RequestError
        For an example whose skeleton has hardly any roles.
    """
    roles, query = _query(example)
    leg = leg_length(example.skeleton)
    for group in index.groups:
        squares = _squares(group, query, roles)
        if squares is not None:
            yield group, leg * np.sqrt(squares), len(query)


def _query(example: Motion) -> tuple[tuple[str, ...], SingleArray]:
    """The roles of an example, and its features."""
    roles = tuple(role for role in BODY if role in example.skeleton.roles)
    if len(roles) < _FEWEST:
        raise RequestError(f"motions are compared by roles; this skeleton has {', '.join(roles) or 'none'}: name more")
    return roles, _features(example, roles)[: int(LONGEST * RATE) + 1]


def _squares(group: Group, query: SingleArray, roles: tuple[str, ...]) -> FloatArray | None:
    """The squared distance of every window of a group; None where too few roles are common."""
    common = [role for role in roles if role in group.roles]
    if len(common) < _FEWEST:
        return None
    asked = query[:, _columns(roles, common)]
    windows = group.windows if len(common) == len(group.roles) else group.windows.columns(_columns(group.roles, common))
    return windows.distances(np.ascontiguousarray(asked)) / len(common)


def _leave_out(
    squares: FloatArray, group: Group, width: int, without: Found | None, among: Collection[str] | None
) -> None:
    """Make the distance infinite of what overlaps a window, and of other takes than some."""
    offsets = group.windows.offsets
    if without is not None and (without.take, without.track) in group.tracks:
        own = group.tracks.index((without.take, without.track))
        first = max(int(without.start * RATE) - width + 1, 0)
        last = int(without.stop * RATE) + 1
        squares[offsets[own] : offsets[own + 1]][first:last] = np.inf
    if among is not None:
        kept = np.array([take in among for take, _ in group.tracks], dtype=np.bool_)
        squares[~np.repeat(kept, np.diff(offsets))] = np.inf


def example_in(text: str, library: Library, options: ReadOptions | None = None) -> tuple[Motion, Found | None]:
    """The part of a motion that a person names, and where in the library it is.

    Parameters
    ----------
    text : str
        ``"FILE@2-4"`` or ``"take:NAME@2-4"``, in seconds.
    library : Library
    options : ReadOptions, optional
        For the motion file.

    Returns
    -------
    example : Motion
    own : Found or None
        None for a file.

    Raises
    ------
    RequestError
        For another text, a take that is not there, and a part beyond its end.
    """
    name, _, span = text.rpartition("@")
    match = re.fullmatch(r"(\d+(?:\.\d*)?|\.\d+)-(\d+(?:\.\d*)?|\.\d+)", span.strip())
    if not name or not match:
        raise RequestError(f"an example is FILE@2-4 or take:NAME@2-4, in seconds; found {text!r}")
    start, stop = float(match.group(1)), float(match.group(2))
    take = library.take(name.removeprefix("take:")) if name.startswith("take:") else read(Path(name), options).take
    track, motion = next(_motions(take), ("", None))
    if motion is None:
        raise RequestError(f"take {take.name!r} has no motion, only {', '.join(take.tracks)}")
    if not start < stop <= motion.duration + 0.5 / motion.fps:
        raise RequestError(f"{text!r}: expected a part of the {motion.duration:.2f} s of {take.name!r}")
    example = cut(motion, round(start * motion.fps), min(round(stop * motion.fps) + 1, len(motion)))
    return example, Found(take.name, track, start, stop, 0.0) if name.startswith("take:") else None


def _columns(roles: tuple[str, ...], chosen: Sequence[str]) -> IntArray:
    """The columns of features that belong to some of the roles."""
    return np.array([6 * roles.index(role) + column for role in chosen for column in range(6)])


def _described(found: tuple[tuple[Group, int, int], float], width: int, leg: float) -> Found:
    (group, motion, row), square = found
    take, track = group.tracks[motion]
    return Found(take, track, row / RATE, (row + width - 1) / RATE, leg * float(np.sqrt(square)))
