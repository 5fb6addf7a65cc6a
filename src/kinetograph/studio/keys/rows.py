"""The rows of a project's keys as keys: poses found in a library or a file, hands and feet put where they are to be."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.formats.keys_json import find_pose
from kinetograph.keys import Key, PartFromRoot, PartInWorld, key_at
from kinetograph.library import Library
from kinetograph.motion import Motion, cut
from kinetograph.post import JointLimits, JointRange, beyond, ends_of, limb_joints, put_ends
from kinetograph.studio.project import KeyRow
from kinetograph.studio.room import FILES, Room

FURTHEST = 10_000.0
"""Metres from the origin within which keys are."""
MISSED = 1e-3
"""Metres from where it was put beyond which an end is said to be out of reach."""


def key_labels(rows: Sequence[KeyRow]) -> tuple[str, ...]:
    """What messages call the keys: their names, or ``key 1``, ...; with their numbers where names are the same.

    Parameters
    ----------
    rows : sequence of KeyRow

    Returns
    -------
    tuple of str
    """
    names = [row.name or f"key {number}" for number, row in enumerate(rows, start=1)]
    counts = Counter(names)
    return tuple(name if counts[name] == 1 else f"{name} ({i})" for i, name in enumerate(names, start=1))


def file_of(row: KeyRow) -> str | None:
    """The name of the file that a pose is in; None for a take, or for what names no pose."""
    name, separator, _ = row.pose.rpartition("@")
    return name if separator and name and not name.startswith("take:") else None


def _metres(row: KeyRow) -> Iterator[float]:
    """All lengths of a row."""
    for place in (row.position, *row.moved.values(), *(part.position for part in row.parts)):
        yield from place or ()


def key_of(row: KeyRow, label: str, library: Library, room: Room) -> Key:
    """A row as a key.

    Parameters
    ----------
    row : KeyRow
    label : str
        What messages call it.
    library : Library
        Where takes are found.
    room : Room
        Where files are found.

    Returns
    -------
    Key

    Raises
    ------
    RequestError
        For a pose that is not there, and for values that no key has.
    FormatError
        For a file that cannot be read.
    """
    if (name := file_of(row)) is not None:
        room.file(name)
    for value in _metres(row):
        if not abs(value) <= FURTHEST:
            raise RequestError(f"{label}: expected a place within {FURTHEST:g} m, found {value:g}")
    clip, second = find_pose(row.pose, label, room.folder / FILES, library)
    time = (row.time, row.time) if isinstance(row.time, int | float) else row.time
    heading = None if row.heading is None else math.radians(row.heading)
    place, parts = row.position, _parts(row, label)
    key = key_at(clip, second, time=time, position=place, heading=heading, roles=row.roles, label=label, parts=parts)
    return replace(key, clip=_moved(key, row)) if row.moved else key


def _parts(row: KeyRow, label: str) -> tuple[PartFromRoot, ...]:
    kinds = {"root": PartFromRoot, "world": PartInWorld}
    try:
        return tuple(kinds[part.within](part.role, part.position, part.orientation) for part in row.parts)
    except RequestError as error:
        raise RequestError(f"{label}: {error}") from None


def _moved(key: Key, row: KeyRow) -> Motion:
    try:
        return put_ends(key.clip, key.frame, row.moved)
    except RequestError as error:
        raise RequestError(f"{key.label}: {error}") from None


def said_of(row: KeyRow, key: Key, ranges: Sequence[JointRange]) -> tuple[str, ...]:
    """What a person should know of hands and feet that were moved: out of reach, or joints bent further than seen.

    Parameters
    ----------
    row : KeyRow
    key : Key
        Of the row.
    ranges : sequence of JointRange
        Those of the library's recordings; none where the key has another skeleton.

    Returns
    -------
    tuple of str
        One line each.
    """
    lines = []
    for role, place in row.moved.items():
        short = float(np.linalg.norm(ends_of(key.clip, key.frame)[role] - np.array(place)))
        if short > MISSED:
            lines.append(f"{key.label}: {_words(role)} is out of reach, {100 * short:.0f} cm from where it was put")
        lines += [f"{key.label}: {line}" for line in _overbent(key, limb_joints(key.clip.skeleton, role), ranges)]
    return tuple(lines)


def _overbent(key: Key, limb: Mapping[int, str], ranges: Sequence[JointRange]) -> list[str]:
    """Which joints of a limb are bent further than in any recording, and by how much."""
    pose = cut(key.clip, key.frame, key.frame + 1)
    own = [limits for limits in ranges if limits.joint in limb]
    over = np.degrees(beyond(pose, own)[0] - JointLimits.margin)
    return [
        f"{_words(limb[limits.joint])} is bent {degrees + np.degrees(JointLimits.margin):.0f} degrees further than in "
        "any recording"
        for limits, degrees in zip(own, over, strict=True)
        if degrees > 0
    ]


def _words(role: str) -> str:
    return f"the {role.replace('_', ' ')}"
