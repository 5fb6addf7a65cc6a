"""Layers as a request has them: takes, motion files, readings and keys that drive a part of the body."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from kinetograph.errors import RequestError
from kinetograph.formats import KeySources, read
from kinetograph.formats.keys_json import key_of_row
from kinetograph.formats.readings import read_layout
from kinetograph.formats.request_json import LayerRow
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl
from kinetograph.methods.performance import only_track
from kinetograph.methods.sensor import SensorControl
from kinetograph.motion import Motion, cut
from kinetograph.pipeline.inbetweening import fit_keyframe, inbetween_with
from kinetograph.pipeline.layering import sense_layer
from kinetograph.pipeline.libraries import open_library
from kinetograph.pipeline.sensing import read_rows
from kinetograph.post import Layer
from kinetograph.sensing import kinds_of
from kinetograph.signal import Signal
from kinetograph.synthesis import Piece

SHORTEST = 0.2
"""Seconds that a layer lasts at least."""
MOST = 1e6
"""Seconds that its times are less than."""


def layer_of(row: LayerRow, library: Library, sources: KeySources) -> Layer:
    """The layer of a row.

    Parameters
    ----------
    row : LayerRow
    library : Library
        Where readings and keys take poses from, unless the row has another.
    sources : KeySources
        Where files are, and how they are read.

    Raises
    ------
    RequestError
        Unless it has a motion, readings or keys, one of them; for parts that do not exist, and as each of them does.
    FormatError
        For a file that cannot be read.
    """
    for name in ("start", "second", "ease"):
        if not 0 <= getattr(row, name) < MOST:
            raise RequestError(f"a layer's {name} is 0 s or more, found {getattr(row, name)}")
    given = [name for name in ("motion", "readings", "keys") if getattr(row, name)]
    parts = " and ".join(row.parts)
    if len(given) != 1:
        found = ", ".join(given) or "none"
        raise RequestError(f"the layer of {parts}: expected a motion, readings or keys, one of them, found {found}")
    folders = (row.library,) if isinstance(row.library, str) else row.library
    own = open_library([sources.folder / each for each in folders]) if folders else library
    made = {"motion": _motion_layer, "readings": _readings_layer, "keys": _keys_layer}[given[0]](row, own, sources)
    return replace(_part_of(made, row), start=row.start, ease=row.ease, hold=row.hold)


def _part_of(layer: Layer, row: LayerRow) -> Layer:
    """The seconds of a layer that are used."""
    if row.second == 0 and row.seconds is None:
        return layer
    motion = layer.motion
    first = round(row.second * motion.fps)
    last = len(motion) - 1 if row.seconds is None else min(first + round(row.seconds * motion.fps), len(motion) - 1)
    if (last - first) / motion.fps < SHORTEST:
        raise RequestError(
            f"the layer of {' and '.join(row.parts)}: {layer.name} lasts {motion.duration:.2f} s, and a layer needs "
            f"{SHORTEST:g} s of it, found {max((last - first) / motion.fps, 0):.2f} s from {row.second:.2f} s on"
        )
    since, until = first / motion.fps, last / motion.fps
    pieces = tuple(_piece_part(each, since, until) for each in layer.pieces if since < each.stop and each.start < until)
    return replace(layer, motion=cut(motion, first, last + 1), pieces=pieces)


def _piece_part(piece: Piece, since: float, until: float) -> Piece:
    """What of a piece is within some seconds, on a clock that begins with them."""
    start, stop = max(piece.start, since), min(piece.stop, until)
    first, last = (piece.source_start,) * 2 if piece.held else piece.source_time([start, stop]).tolist()
    return replace(piece, source_start=first, source_stop=last, start=start - since, stop=stop - since)


def _take_layer(row: LayerRow, library: Library) -> Layer:
    name = row.motion.removeprefix("take:")
    tracks = library.take(name).tracks
    track, motion = next((track, each) for track, each in tracks.items() if isinstance(each, Motion))
    piece = Piece(name, track, 0.0, motion.duration, 0.0, motion.duration)
    return Layer(motion, row.parts, name=name, pieces=(piece,))


def _motion_layer(row: LayerRow, library: Library, sources: KeySources) -> Layer:
    if row.motion.startswith("take:"):
        return _take_layer(row, library)
    motion = motion_or_path(row.motion, sources)
    if isinstance(motion, Signal):
        raise RequestError(f"the layer of {' and '.join(row.parts)}: expected a motion, found a path in {row.motion}")
    return Layer(motion, row.parts, name=Path(row.motion).name)


def _readings_layer(row: LayerRow, library: Library, sources: KeySources) -> Layer:
    readings, said = read_rows(sources.folder / row.readings)
    for line in said if sources.note else ():
        assert sources.note is not None
        sources.note(f"{row.readings}: {line}")
    beside = sources.folder / row.layout
    method = SensorControl(layout=read_layout(str(beside) if beside.exists() else row.layout), kinds=kinds_of(readings))
    return replace(sense_layer(readings, row.parts, library, method, note=sources.note), name=Path(row.readings).name)


def _keys_layer(row: LayerRow, library: Library, sources: KeySources) -> Layer:
    own = replace(sources, library=library)
    keys = tuple(key_of_row(each, each.name or f"key {number}", own) for number, each in enumerate(row.keys, 1))
    (made,) = inbetween_with(fit_keyframe(KeyframeControl(), library, note=sources.note), keys)
    return Layer(made.motion, row.parts, name="keys", pieces=made.pieces)


def motion_or_path(name: str, sources: KeySources) -> Signal | Motion:
    """What a file of a request holds, or a motion in memory of that name.

    Parameters
    ----------
    name : str
    sources : KeySources
    """
    if name in sources.motions:
        return sources.motions[name]
    loaded = read(sources.folder / name, sources.options)
    for line in loaded.notes if sources.note else ():
        assert sources.note is not None
        sources.note(f"{name}: {line}")
    return only_track(loaded.take)
