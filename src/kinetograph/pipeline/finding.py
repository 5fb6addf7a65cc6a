"""Finding takes of a library: by words, and by an example of the motion."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import IntArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn.windows import Windows
from kinetograph.methods.keyframe.features import BODY, REACH, relative_joints
from kinetograph.methods.recordings import leg_length
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.take import Take

RATE = 10.0
"""Frames per second at which motions are compared."""
LONGEST = 8.0
"""Seconds of an example that are compared."""

_FEWEST = 4  # roles
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
class _Group:
    """Motions whose skeletons have the same roles: their features, laid end to end, in lengths of the leg."""

    roles: tuple[str, ...]
    tracks: tuple[tuple[str, str], ...]
    windows: Windows


@dataclass(frozen=True, eq=False)
class ExampleIndex:
    """What examples are compared with; see `index_takes`.

    Parameters
    ----------
    groups : tuple
        The motions, by the roles that they have in common.
    """

    groups: tuple[_Group, ...]


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
    parts: dict[tuple[str, ...], list[tuple[tuple[str, str], SingleArray]]] = {}
    for done, take in enumerate(takes, start=1):
        for name, motion in _motions(take):
            roles = tuple(role for role in BODY if role in motion.skeleton.roles)
            if len(roles) >= _FEWEST:
                parts.setdefault(roles, []).append(((take.name, name), _features(motion, roles)))
        if progress:
            progress(done, count)
    return ExampleIndex(tuple(_group(roles, of) for roles, of in parts.items()))


def _motions(take: Take) -> Iterator[tuple[str, Motion]]:
    return ((name, track) for name, track in take.tracks.items() if isinstance(track, Motion))


def _group(roles: tuple[str, ...], of: Sequence[tuple[tuple[str, str], SingleArray]]) -> _Group:
    rows = [each for _, each in of]
    offsets = np.concatenate([[0], np.cumsum([len(each) for each in rows])])
    return _Group(roles, tuple(track for track, _ in of), Windows(np.concatenate(rows), offsets))


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


def find_alike(index: ExampleIndex, example: Motion, *, count: int = 50, without: Found | None = None) -> list[Found]:
    """The windows that are most like an example, wherever on the ground and in whichever direction they are.

    Parameters
    ----------
    index : ExampleIndex
    example : Motion
        Its first ``LONGEST`` seconds are compared.
    count : int
        How many are found, one of each track.
    without : Found, optional
        A window that is left out, with those that overlap it: where the example comes from.

    Returns
    -------
    list of Found
        The nearest first.

    Raises
    ------
    RequestError
        For an example whose skeleton has hardly any roles.
    """
    roles = tuple(role for role in BODY if role in example.skeleton.roles)
    if len(roles) < _FEWEST:
        raise RequestError(f"motions are compared by roles; this skeleton has {', '.join(roles) or 'none'}: name more")
    query = _features(example, roles)[: int(LONGEST * RATE) + 1]
    found = [each for group in index.groups for each in _nearest(group, query, roles, without)]
    leg = leg_length(example.skeleton)
    nearest = sorted(found, key=lambda each: each[1])[:count]
    return [_described(each, len(query), leg) for each in nearest]


def _nearest(
    group: _Group, query: SingleArray, roles: tuple[str, ...], without: Found | None
) -> Iterator[tuple[tuple[_Group, int, int], float]]:
    """The best window of each motion of a group: the group, the motion and its row, and the squared distance."""
    common = [role for role in roles if role in group.roles]
    if len(common) < _FEWEST:
        return
    asked = query[:, _columns(roles, common)]
    windows = group.windows if len(common) == len(group.roles) else group.windows.columns(_columns(group.roles, common))
    squares = windows.distances(np.ascontiguousarray(asked)) / len(common)
    starts = windows.offsets[:-1]
    if without is not None and (without.take, without.track) in group.tracks:
        own = group.tracks.index((without.take, without.track))
        first = max(int(without.start * RATE) - len(query) + 1, 0)
        last = int(without.stop * RATE) + 1
        squares[starts[own] : windows.offsets[own + 1]][first:last] = np.inf
    for motion in np.flatnonzero(np.isfinite(np.minimum.reduceat(squares, starts))).tolist():
        best = int(squares[starts[motion] : windows.offsets[motion + 1]].argmin())
        yield (group, motion, best), float(squares[starts[motion] + best])


def _columns(roles: tuple[str, ...], chosen: Sequence[str]) -> IntArray:
    """The columns of features that belong to some of the roles."""
    return np.array([6 * roles.index(role) + column for role in chosen for column in range(6)])


def _described(found: tuple[tuple[_Group, int, int], float], width: int, leg: float) -> Found:
    (group, motion, row), square = found
    take, track = group.tracks[motion]
    return Found(take, track, row / RATE, (row + width - 1) / RATE, leg * float(np.sqrt(square)))
