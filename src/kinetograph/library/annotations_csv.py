"""Annotations as a table that people edit: one row per annotation, ``take,track,kind,label,start,stop``, in seconds."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from kinetograph.errors import DataError, FormatError
from kinetograph.formats import atomic_path
from kinetograph.formats.texts import read_text
from kinetograph.library.info import TrackInfo
from kinetograph.library.store import Library, annotations_of, contents
from kinetograph.take import Annotation

HEADER = ("take", "track", "kind", "label", "start", "stop")
"""The columns of a table."""

Row = tuple[int, str, Annotation]


def export_annotations(library: Library, path: str | Path, *, kind: str | None = None) -> int:
    """Write a library's annotations as CSV; the file appears whole or not at all.

    Parameters
    ----------
    library : Library
    path : str or Path
    kind : str, optional
        Only annotations of this kind.

    Returns
    -------
    int
        How many there were.

    Raises
    ------
    RequestError
        The file cannot be made.
    FormatError
        The file cannot be written, as the disk is full.

    Notes
    -----
    Numbers keep every digit.
    """
    notes = [(take, note) for take in library.names() for note in annotations_of(library, take)]
    kept = [(take, note) for take, note in notes if kind in (None, note.kind)]
    rows = [(take, n.track, n.kind, n.label, repr(n.start), repr(n.stop)) for take, n in kept]
    try:
        with atomic_path(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([HEADER, *rows])
    except OSError as error:
        raise FormatError(path, f"could not be written: {error.strerror}") from error
    return len(rows)


def import_annotations(library: Library, path: str | Path) -> int:
    """Give a library the annotations of a CSV file.

    For every take, track and kind in the file, they replace those in the library; all others stay. A cut may leave
    ``stop`` empty. The whole file is checked first.

    Parameters
    ----------
    library : Library
    path : str or Path

    Returns
    -------
    int
        How many there were.

    Raises
    ------
    FormatError
        The file cannot be read, or does not fit the library; with the line.
    """
    rows = list(_read(Path(path)))
    tracks = {(track.take, track.name): track for track in contents(library)}
    for line, take, note in rows:
        _check(Path(path), line, take, note, tracks)
    for name, notes in _by_take(rows).items():
        library.annotate(name, notes)
    return len(rows)


def read_annotations(path: str | Path, take: str) -> tuple[Annotation, ...]:
    """Read the annotations of one take.

    Parameters
    ----------
    path : str or Path
    take : str
        The take's name; where the file has only one take, its annotations are read whatever its name.

    Returns
    -------
    tuple of Annotation

    Raises
    ------
    FormatError
        The file cannot be read, or has several other takes; with the line.
    """
    rows = list(_read(Path(path)))
    takes = sorted({name for _, name, _ in rows})
    if len(takes) > 1 and take not in takes:
        raise FormatError(path, f"expected annotations of take {take!r}, found those of {', '.join(takes)}")
    return tuple(note for _, name, note in rows if name == take or len(takes) == 1)


def read_times(path: str | Path) -> tuple[float, ...]:
    """Read seconds from the first column, one per line, as audio editors export beats.

    The first line may be a header; lines that begin with ``#`` are comments.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    tuple of float

    Raises
    ------
    FormatError
        A cell is not a number, or there is none; with the line.
    """
    times: list[float] = []
    for number, line in enumerate(_text(Path(path)).splitlines(), start=1):
        cell = re.split(r"[,;\t]", line)[0].strip()
        if not cell or cell.startswith("#"):
            continue
        try:
            time = float(cell)
        except ValueError:
            time = math.nan
        if math.isfinite(time) and time >= 0:
            times.append(time)
        elif times or re.match(r"[-+.\d]|nan|inf", cell.lower()):
            raise FormatError(path, f"expected seconds, 0 or more, in the first column, found {cell!r}", line=number)
    if not times:
        raise FormatError(path, "expected seconds, one per line, found none")
    return tuple(times)


def _read(path: Path) -> Iterator[Row]:
    reader = csv.reader(io.StringIO(_text(path), newline=""))
    line = 1
    try:
        header = tuple(cell.strip() for cell in next(reader, []))
        if header != HEADER:
            first = ",".join(header) or "nothing"
            raise FormatError(path, f"expected the header {','.join(HEADER)}, found {first}", line=1)
        line = reader.line_num + 1  # of the next row, which may run over several lines
        for cells in reader:
            if any(cells):
                yield _row(path, line, cells)
            line = reader.line_num + 1
    except csv.Error as error:
        raise FormatError(path, f"not a table of comma-separated values: {error}", line=line) from error


def _text(path: Path) -> str:
    return read_text(path, "a table of comma-separated values")  # spreadsheets write a byte-order mark


def _row(path: Path, line: int, cells: list[str]) -> Row:
    if len(cells) != len(HEADER):
        raise FormatError(path, f"expected {len(HEADER)} cells ({','.join(HEADER)}), found {len(cells)}", line=line)
    take, track, kind, label, start, stop = cells
    try:
        return line, take, Annotation(track, kind, label, float(start), float(stop.strip() or start))
    except DataError as error:
        raise FormatError(path, str(error), line=line) from error
    except ValueError as error:
        raise FormatError(path, f"expected seconds for start and stop, found {start!r}, {stop!r}", line=line) from error


def _check(path: Path, line: int, take: str, note: Annotation, tracks: Mapping[tuple[str, str], TrackInfo]) -> None:
    info = tracks.get((take, note.track))
    if info is None:
        of_take = [track for name, track in tracks if name == take]
        known = f"take {take!r} has {', '.join(of_take)}" if of_take else f"the library has no take {take!r}"
        raise FormatError(path, f"no track {note.track!r} of take {take!r}: {known}", line=line)
    if note.stop > info.frames / info.fps + 1e-6:
        end = f"{info.duration:.3f} s"
        raise FormatError(path, f"{note.stop} s lies after the end of track {note.track!r} at {end}", line=line)


def _by_take(rows: Iterable[Row]) -> dict[str, list[Annotation]]:
    grouped: dict[str, list[Annotation]] = {}
    for _, take, note in rows:
        grouped.setdefault(take, []).append(note)
    return grouped
