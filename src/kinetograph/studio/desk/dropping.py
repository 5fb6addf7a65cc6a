"""Files that are dropped onto the page: kept in the project's folder if they are what they are to be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from kinetograph.errors import KinetographError, RequestError
from kinetograph.formats.atomic import atomic_path
from kinetograph.studio.messages import FileHeader, Kept
from kinetograph.studio.room import FILES, Room, plain_name


def keep(room: Room, header: FileHeader, payload: bytes) -> Kept:
    """Keep a file.

    Parameters
    ----------
    room : Room
    header : FileHeader
        Its name, and what it is to be.
    payload : bytes

    Returns
    -------
    Kept
        The name that it has in the project: another where that name is taken by other bytes.

    Raises
    ------
    RequestError
        For a name that leads elsewhere, and for a file that is not what it is to be.
    """
    folder = room.folder / FILES
    folder.mkdir(parents=True, exist_ok=True)
    path = _free(folder / plain_name(header.name), payload)
    if not path.exists():
        with atomic_path(path, force=False) as draft:
            draft.write_bytes(payload)
            try:
                _CHECKS[header.role](draft)
            except KinetographError as error:
                text = str(error).replace(str(draft), header.name)
                raise RequestError(f"{header.name} is not kept as {_ROLES[header.role]}: {text}") from None
    return Kept(header.id, path.name, room.files())


def _free(path: Path, payload: bytes) -> Path:
    """The path, or one with a number after its name where another file has it."""
    stem, number = path.stem, 1
    while path.exists() and path.read_bytes() != payload:
        number += 1
        path = path.with_name(f"{stem}_{number}{path.suffix}")
    return path


def _character(path: Path) -> None:
    from kinetograph.formats import read_character

    if path.suffix.lower() not in (".glb", ".gltf", ".vrm"):
        raise RequestError(f"{path}: expected a .glb or .vrm file with a skin")
    read_character(path, [])


def _motion(path: Path) -> None:
    from kinetograph.formats import ReadOptions
    from kinetograph.pipeline import read_take

    read_take(path, ReadOptions())


def _recording(path: Path) -> None:
    from kinetograph.formats import ReadOptions
    from kinetograph.motion import Motion
    from kinetograph.pipeline import read_take

    tracks = read_take(path, ReadOptions())[0].tracks
    if not any(isinstance(track, Motion) for track in tracks.values()):
        raise RequestError(f"{path}: expected the motion of a skeleton, found only {', '.join(tracks)}")


def _readings(path: Path) -> None:
    from kinetograph.formats.readings import read_readings

    if path.suffix.lower() not in (".csv", ".txt", ".tsv"):
        raise RequestError(f"{path}: expected readings as a table, .csv")
    from kinetograph.pipeline import read_rows

    read_rows(path)
    read_readings(path, oriented=False)


def _layout(path: Path) -> None:
    from kinetograph.formats.readings import read_layout

    if path.suffix.lower() != ".toml":
        raise RequestError(f"{path}: expected a layout, .toml")
    read_layout(str(path))


_ROLES = {
    "character": "a character",
    "leader": "a leader",
    "recording": "a recording",
    "readings": "readings",
    "layout": "a layout",
}
_CHECKS: dict[str, Callable[[Path], None]] = {
    "character": _character,
    "leader": _motion,
    "recording": _recording,
    "readings": _readings,
    "layout": _layout,
}
