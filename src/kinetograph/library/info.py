"""What a library holds, counted without reading frames."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinetograph.library import catalogue, storage
from kinetograph.library.digests import Damaged
from kinetograph.library.records import read_skeleton
from kinetograph.skeleton import plain_names

Joints = tuple[tuple[str, ...], tuple[int, ...]]
"""Names of joints without namespaces, and their parents."""
_TYPES = (str, str, str, float, int, int)


@dataclass(frozen=True)
class Info:
    """What a library holds.

    Parameters
    ----------
    takes, tracks : int
        How many there are.
    seconds : float
        Of all takes, each as long as its longest track.
    frames : int
        Of all tracks.
    skeletons : int
        Number of different ones.
    bytes : int
        On disk.
    annotations : mapping of str to int
        How many there are of each kind.
    """

    takes: int
    tracks: int
    seconds: float
    frames: int
    skeletons: int
    bytes: int
    annotations: Mapping[str, int]


@dataclass(frozen=True)
class TrackInfo:
    """One track of a library.

    Parameters
    ----------
    take, name : str
    kind : {"motion", "points", "channels"}
    fps : float
    frames : int
    columns : int
        Number of joints, points or channels.
    """

    take: str
    name: str
    kind: str
    fps: float
    frames: int
    columns: int

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.frames - 1) / self.fps


def count(folder: Path) -> Info:
    """Count what the library in a folder holds. Raises LibraryError."""
    with catalogue.reading(folder) as db:
        longest = "SELECT max((frames - 1) / fps) AS seconds FROM tracks GROUP BY take"
        takes, seconds = db.execute(f"SELECT count(*), total(seconds) FROM ({longest})").fetchone()
        tracks, frames = db.execute("SELECT count(*), ifnull(sum(frames), 0) FROM tracks").fetchone()
        (skeletons,) = db.execute("SELECT count(*) FROM skeletons").fetchone()
        kinds = dict(db.execute("SELECT kind, count(*) FROM annotations GROUP BY kind ORDER BY kind").fetchall())
        files = [folder / name for name in (catalogue.FILE_NAME, storage.read(db).file)]
        size = sum(file.stat().st_size for file in files if file.exists())
    return Info(takes, tracks, seconds, frames, skeletons, size, kinds)


def list_tracks(folder: Path) -> tuple[TrackInfo, ...]:
    """Every track of the library in a folder, by take. Raises LibraryError."""
    with catalogue.reading(folder) as db:
        rows = db.execute(
            "SELECT takes.name, tracks.name, kind, fps, frames, ifnull(json_array_length(columns), "
            "json_array_length(skeletons.body, '$.names')) FROM tracks JOIN takes ON takes.id = tracks.take "
            "LEFT JOIN skeletons ON skeletons.id = tracks.skeleton ORDER BY takes.id, tracks.id"
        )
        return tuple(_track_info(row) for row in rows)


def _track_info(row: tuple[Any, ...]) -> TrackInfo:
    """A row as it should be. Raises Damaged where it has other types, or no skeleton."""
    if tuple(map(type, row)) != _TYPES or row[3] <= 0:
        raise Damaged(f"the rows of take {row[0]!r} have changed since they were written")
    return TrackInfo(*row)


def list_labels(folder: Path) -> dict[str, tuple[tuple[str, str], ...]]:
    """The different annotations of every annotated take: kind and label, by take. Raises LibraryError."""
    found: dict[str, list[tuple[str, str]]] = {}
    with catalogue.reading(folder) as db:
        rows = db.execute(
            "SELECT DISTINCT takes.name, annotations.kind, label FROM annotations JOIN tracks ON tracks.id = "
            "annotations.track JOIN takes ON takes.id = tracks.take ORDER BY takes.id, annotations.kind, label"
        )
        for take, kind, label in rows:
            if not (isinstance(take, str) and isinstance(kind, str) and isinstance(label, str)):
                raise Damaged(f"the annotations of take {take!r} have changed since they were written")
            found.setdefault(take, []).append((kind, label))
    return {take: tuple(pairs) for take, pairs in found.items()}


def list_joints(folder: Path) -> tuple[tuple[str, str, Joints], ...]:
    """The joints of every motion of the library in a folder, without reading frames. Raises LibraryError.

    Returns
    -------
    tuple of (str, str, Joints)
        Take, track, and the names of the joints, without namespaces, with their parents.
    """
    with catalogue.reading(folder) as db:
        joints = {row: _joints(db, digest) for row, digest in db.execute("SELECT id, digest FROM skeletons").fetchall()}
        rows = db.execute(
            "SELECT takes.name, tracks.name, skeleton FROM tracks JOIN takes ON takes.id = tracks.take "
            "WHERE skeleton IS NOT NULL ORDER BY takes.id, tracks.id"
        )
        return tuple((str(take), str(track), joints.get(skeleton, ((), ()))) for take, track, skeleton in rows)


def list_skeletons(folder: Path) -> dict[str, list[tuple[int, list[str]]]]:
    """The motions of the library in a folder by their joints, without reading frames. Raises LibraryError.

    Returns
    -------
    dict of str to list of tuple of int and list of str
        By name of the track, one for each different set of joints: the number of joints, and the takes in order.
    """
    found: dict[str, dict[Joints, tuple[int, list[str]]]] = {}
    for take, track, joints in list_joints(folder):
        found.setdefault(track, {}).setdefault(joints, (len(joints[0]), []))[1].append(take)
    return {track: list(groups.values()) for track, groups in found.items()}


def _joints(db: sqlite3.Connection, digest: str) -> Joints:
    skeleton = read_skeleton(db, digest)
    return plain_names(skeleton.names), tuple(skeleton.parents.tolist())
