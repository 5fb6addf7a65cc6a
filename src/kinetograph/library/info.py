"""What a library holds, counted without reading frames."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinetograph.library import catalogue, storage
from kinetograph.library.digests import Damaged
from kinetograph.library.records import joints_of
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
        Of all motions and signals.
    skeletons : int
        Number of different ones.
    bytes : int
        Of the whole library on disk.
    annotations : mapping of str to int
        How many there are of each kind.
    captured : int
        Takes with readings of sensors that were worn.
    """

    takes: int
    tracks: int
    seconds: float
    frames: int
    skeletons: int
    bytes: int
    annotations: Mapping[str, int]
    captured: int = 0


@dataclass(frozen=True)
class TrackInfo:
    """One track of a library.

    Parameters
    ----------
    take, name : str
    kind : {"motion", "points", "channels", "readings"}
    fps : float
        Of readings, rows per second of all sensors together.
    frames : int
        Or rows of readings.
    columns : int
        Number of joints, points, channels or sensors.
    """

    take: str
    name: str
    kind: str
    fps: float
    frames: int
    columns: int

    @property
    def each(self) -> float:
        """Frames, or rows of each sensor in the mean, per second."""
        return self.fps / self.columns if self.kind == "readings" else self.fps

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.frames - 1) / self.fps


def count(folder: Path, chosen: Sequence[str] | None = None) -> Info:
    """Count what the library in a folder holds, or what some of its takes do. Raises LibraryError."""
    with catalogue.reading(folder) as db:
        ids = "SELECT id FROM takes"
        given: tuple[str, ...] = ()
        if chosen is not None:
            ids, given = f"{ids} WHERE name IN (SELECT value FROM json_each(?))", (json.dumps(list(chosen)),)
        longest = f"SELECT max((frames - 1) / fps) AS seconds FROM tracks WHERE take IN ({ids}) GROUP BY take"
        tracks_in = f"FROM tracks WHERE take IN ({ids})"
        takes, seconds = db.execute(f"SELECT count(*), total(seconds) FROM ({longest})", given).fetchone()
        of_frames = "ifnull(sum(CASE kind WHEN 'readings' THEN 0 ELSE frames END), 0)"
        tracks, frames = db.execute(f"SELECT count(*), {of_frames} {tracks_in}", given).fetchone()
        worn = f"SELECT count(DISTINCT take) {tracks_in} AND kind = 'readings'"
        (captured,) = db.execute(worn, given).fetchone()
        (skeletons,) = db.execute(f"SELECT count(DISTINCT skeleton) {tracks_in}", given).fetchone()
        noted = f"FROM annotations WHERE track IN (SELECT id {tracks_in})"
        kinds = dict(db.execute(f"SELECT kind, count(*) {noted} GROUP BY kind ORDER BY kind", given).fetchall())
        files = [folder / name for name in (catalogue.FILE_NAME, storage.read(db).file)]
        size = sum(file.stat().st_size for file in files if file.exists())
    return Info(takes, tracks, seconds, frames, skeletons, size, kinds, captured)


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


def count_labels(folder: Path, kind: str) -> dict[str, dict[str, int]]:
    """How often each label of the annotations of a kind occurs, by take. Raises LibraryError."""
    found: dict[str, dict[str, int]] = {}
    with catalogue.reading(folder) as db:
        rows = db.execute(
            "SELECT takes.name, label, count(*) FROM annotations JOIN tracks ON tracks.id = annotations.track "
            "JOIN takes ON takes.id = tracks.take WHERE annotations.kind = ? GROUP BY takes.id, label",
            (kind,),
        )
        for take, label, number in rows:
            found.setdefault(str(take), {})[str(label)] = number
    return found


def list_joints(folder: Path) -> tuple[tuple[str, str, Joints], ...]:
    """The joints of every motion of the library in a folder, without reading frames. Raises LibraryError.

    Returns
    -------
    tuple of (str, str, Joints)
        Take, track, and the names of the joints, without namespaces, with their parents.
    """
    with catalogue.reading(folder) as db:
        listed = db.execute("SELECT id, digest, body FROM skeletons").fetchall()
        bare = {row: joints_of(digest, text) for row, digest, text in listed}
        plain = {joints: (plain_names(joints[0]), joints[1]) for joints in set(bare.values())}
        rows = db.execute(
            "SELECT takes.name, tracks.name, skeleton FROM tracks JOIN takes ON takes.id = tracks.take "
            "WHERE skeleton IS NOT NULL ORDER BY takes.id, tracks.id"
        )
        joints = {row: plain[named] for row, named in bare.items()}
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
