"""Tracks, skeletons and annotations as rows of the catalogue, and back."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from kinetograph import rotations as rot
from kinetograph.library.digests import Damaged
from kinetograph.library.frame_files import Array, Span
from kinetograph.library.schema import digest_of_skeleton
from kinetograph.motion import Motion
from kinetograph.readings import Mounting, Readings
from kinetograph.signal import Signal
from kinetograph.skeleton import Ancestor, Landmark, Skeleton
from kinetograph.take import Annotation, Track

Reader = Callable[[Span], Array]


class _Joints(msgspec.Struct):
    """What is read of a skeleton's text where only its joints are asked for."""

    names: tuple[str, ...]
    parents: tuple[int, ...]


_VALUES = ("force", "angular", "orientation")
"""The arrays of readings that are rounded to float32."""
_decode = msgspec.json.Decoder(_Joints).decode


@dataclass(frozen=True)
class TrackRow:
    """A track as the catalogue has it.

    Parameters
    ----------
    id : int
        Its row.
    name : str
    kind : {"motion", "points", "channels", "readings"}
    fps : float
    frames : int
        Or rows of readings.
    skeleton : str or None
        The digest of a motion's skeleton.
    columns : tuple of str
        Of a signal, or the sensors of readings.
    units : str
        Of a signal, or how the sensors of readings were worn.
    spans : dict of str to Span
        Where its arrays lie.
    """

    id: int
    name: str
    kind: str
    fps: float
    frames: int
    skeleton: str | None
    columns: tuple[str, ...]
    units: str
    spans: dict[str, Span]


def track_arrays(track: Track) -> list[tuple[str, Array]]:
    """The arrays of a track as they are stored, each ``(F, ...)``, and their names."""
    if isinstance(track, Signal):
        arrays: list[tuple[str, Array]] = [("values", track.values.astype("<f8"))]
        if not track.valid.all():
            arrays.append(("valid", track.valid.astype("u1")))
        return arrays
    if isinstance(track, Readings):
        return _readings_arrays(track)
    arrays = [("translation", track.translation.astype("<f8")), ("rotations", track.rotations.astype("<f4"))]
    if track.bones is not None:
        arrays.append(("bones", track.bones.astype("<f4")))
    return arrays


def _readings_arrays(readings: Readings) -> list[tuple[str, Array]]:
    values = [(name, getattr(readings, name)) for name in _VALUES]
    given: list[tuple[str, Array]] = [(name, value.astype("<f4")) for name, value in values if value is not None]
    return [("times", readings.times.astype("<f8")), ("sensors", readings.sensors.astype("<u2")), *given]


def array_names(track: Track) -> tuple[str, ...]:
    """The names of a track's arrays."""
    if isinstance(track, Readings):
        return ("times", "sensors", *(name for name in _VALUES if getattr(track, name) is not None))
    if isinstance(track, Signal):
        return ("values",) if track.valid.all() else ("values", "valid")
    return ("translation", "rotations") if track.bones is None else ("translation", "rotations", "bones")


def insert_track(db: sqlite3.Connection, take: int, name: str, track: Track, spans: Iterable[Span]) -> int:
    """Add a track to a take.

    Parameters
    ----------
    db : sqlite3.Connection
    take : int
        The take's row.
    name : str
        The track's.
    track : Motion, Signal or Readings
    spans : iterable of Span
        Where its arrays lie.

    Returns
    -------
    int
        The track's row.
    """
    if isinstance(track, Readings):
        names = json.dumps(track.names)
        return _insert(db, take, name, ("readings", track.rate, len(track), None, names, _worn(track)), spans)
    if isinstance(track, Motion):
        return insert_motion(db, take, name, (track.skeleton, track.fps, len(track)), spans)
    kind = "points" if track.spatial else "channels"
    return _insert(db, take, name, (kind, track.fps, len(track), None, json.dumps(track.names), track.units), spans)


def insert_motion(
    db: sqlite3.Connection, take: int, name: str, what: tuple[Skeleton, float, int], spans: Iterable[Span]
) -> int:
    """Add a motion to a take.

    Parameters
    ----------
    db : sqlite3.Connection
    take : int
        The take's row.
    name : str
        The track's.
    what : tuple of Skeleton, float and int
        Skeleton, frames per second and number of frames.
    spans : iterable of Span
        Where its arrays lie.

    Returns
    -------
    int
        The track's row.
    """
    skeleton, fps, frames = what
    return _insert(db, take, name, ("motion", fps, frames, insert_skeleton(db, skeleton), None, None), spans)


def _worn(readings: Readings) -> str:
    """How sensors were worn, as text."""
    worn = readings.mounting
    if worn is None:
        return ""
    return json.dumps([worn.layout, worn.rotations.tolist(), worn.biases.tolist()])


def _insert(db: sqlite3.Connection, take: int, name: str, values: tuple[Any, ...], spans: Iterable[Span]) -> int:
    row = db.execute(
        "INSERT INTO tracks (take, name, kind, fps, frames, skeleton, columns, units) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
        (take, name, *values),
    ).lastrowid
    assert row is not None
    db.executemany(
        "INSERT INTO arrays VALUES (?, ?, ?, ?, ?, ?)",
        [(row, s.name, s.dtype, s.width, s.start, s.checksum) for s in spans],
    )
    return row


def tracks_of(rows: Iterable[Any]) -> list[TrackRow]:
    """The tracks of a take from its rows (`kinetograph.library.digests.track_rows`), whose digest has been checked."""
    return [_track_row(*row) for row in rows]


def _track_row(
    row: int,
    name: str,
    kind: str,
    fps: float,
    frames: int,
    _: object,
    columns: str | None,
    units: str | None,
    *more: Any,
) -> TrackRow:
    skeleton, arrays = more
    if not all(isinstance(array[4], int) for array in arrays):  # where an array lies is in no digest
        raise Damaged(f"where the arrays of track {name!r} lie has changed since it was written")
    spans = {a[0]: Span(a[0], a[1], a[2], frames, a[4], a[3]) for a in arrays}
    names = () if columns is None else tuple(json.loads(columns))
    return TrackRow(row, name, kind, fps, frames, skeleton, names, units or "", spans)


def build_track(row: TrackRow, skeleton: Skeleton | None, read: Reader) -> Track:
    """The track of a row.

    Parameters
    ----------
    row : TrackRow
    skeleton : Skeleton or None
        A motion's; ``None`` for a signal.
    read : callable
        Returns the array of a span, shape ``(F, width)``.

    Returns
    -------
    Motion, Signal or Readings
    """
    arrays = {name: read(span) for name, span in row.spans.items()}
    if row.kind == "readings":
        return _readings(row, arrays)
    if skeleton is None:
        shape = (row.frames, len(row.columns))
        values = arrays["values"].reshape(*shape, 3) if row.kind == "points" else arrays["values"]
        valid = arrays["valid"].astype(np.bool_) if "valid" in arrays else np.ones(shape, dtype=np.bool_)
        return Signal(values, row.columns, row.units, row.fps, valid)
    rotations = arrays["rotations"].astype(np.float64).reshape(row.frames, len(skeleton), 4)
    bones = arrays["bones"].astype(np.float64).reshape(row.frames, -1, 3) if "bones" in arrays else None
    return Motion(skeleton, arrays["translation"], rot.normalize(rotations), row.fps, bones)


def _readings(row: TrackRow, arrays: dict[str, Array]) -> Readings:
    values = (None if name not in arrays else arrays[name].astype(np.float64) for name in _VALUES)
    force, angular, orientation = values
    assert force is not None  # every reading has one
    worn = Mounting(*json.loads(row.units)) if row.units else None
    return Readings(row.columns, arrays["times"], arrays["sensors"], force, angular, orientation, worn)


def insert_skeleton(db: sqlite3.Connection, skeleton: Skeleton) -> int:
    """The row of a skeleton; equal skeletons, roles included, share one."""
    more: dict[str, object] = {}
    if skeleton.stance is not None:
        more["stance"] = skeleton.stance.tolist()
    if skeleton.ancestors:
        more["ancestors"] = [[n.name, n.translation.tolist(), n.rotation.tolist()] for n in skeleton.ancestors]
    body = json.dumps(
        {
            "names": skeleton.names,
            "parents": skeleton.parents.tolist(),
            "offsets": skeleton.offsets.tolist(),
            "end_parents": skeleton.end_parents.tolist(),
            "end_offsets": skeleton.end_offsets.tolist(),
            "roles": {role: [int(p.joint), *map(float, p.offset)] for role, p in skeleton.roles.items()},
            **more,
        }
    )
    digest = digest_of_skeleton(body)
    # the text too, where what is there has been damaged
    db.execute(
        "INSERT INTO skeletons (digest, body) VALUES (?, ?) ON CONFLICT (digest) DO UPDATE SET body = excluded.body "
        "WHERE body <> excluded.body",
        (digest, body),
    )
    return int(db.execute("SELECT id FROM skeletons WHERE digest = ?", (digest,)).fetchone()[0])


def joints_of(digest: str, text: str) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """The names of a skeleton's joints and their parents, from its row. Raises Damaged where that has changed."""
    _require_same(digest, text)
    joints = _decode(text)
    return joints.names, joints.parents


def _require_same(digest: str, text: str) -> None:
    if digest_of_skeleton(text) != digest:
        raise Damaged("a skeleton has changed since it was written")


def read_skeleton(db: sqlite3.Connection, digest: str) -> Skeleton:
    """The skeleton of a digest. Raises Damaged where it has changed since it was written."""
    (text,) = db.execute("SELECT body FROM skeletons WHERE digest = ?", (digest,)).fetchone() or ("",)
    _require_same(digest, text)
    body = json.loads(text)
    return Skeleton(
        tuple(body["names"]),
        np.array(body["parents"], dtype=np.int64),
        np.array(body["offsets"], dtype=np.float64),
        np.array(body["end_parents"], dtype=np.int64),
        np.array(body["end_offsets"], dtype=np.float64).reshape(-1, 3),
        {role: Landmark(place[0], np.array(place[1:])) for role, place in body["roles"].items()},
        np.array(body["stance"], dtype=np.float64) if "stance" in body else None,
        tuple(Ancestor(name, np.array(at), np.array(facing)) for name, at, facing in body.get("ancestors", ())),
    )


def insert_annotations(db: sqlite3.Connection, tracks: dict[str, int], annotations: Iterable[Annotation]) -> None:
    """Add annotations; ``tracks`` gives the row of each track's name."""
    db.executemany(
        "INSERT INTO annotations (track, kind, label, start, stop) VALUES (?, ?, ?, ?, ?)",
        [(tracks[note.track], note.kind, note.label, float(note.start), float(note.stop)) for note in annotations],
    )
