"""What a page is sent first: the libraries of the project and its files."""

from __future__ import annotations

from kinetograph import __version__
from kinetograph.errors import KinetographError
from kinetograph.library import contents
from kinetograph.studio import exporting
from kinetograph.studio.messages import LibraryRow, Welcome
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room


def welcome(project: Project, room: Room) -> Welcome:
    """What a page is sent first.

    Parameters
    ----------
    project : Project
    room : Room

    Returns
    -------
    Welcome
    """
    rows = [row for name in project.libraries if (row := _row(project, room, name)) is not None]
    return Welcome(__version__, exporting.MOTIONS, exporting.films(), tuple(rows), room.files())


def _row(project: Project, room: Room, name: str) -> LibraryRow | None:
    """A library; None where it cannot be opened, which is said when it is used."""
    try:
        tracks = contents(room.library(project.libraries, name))
    except KinetographError:
        return None
    takes = {track.take: track.frames / track.fps for track in tracks}
    names = tuple(sorted({track.name for track in tracks}))
    return LibraryRow(name, len(takes), sum(takes.values()), names, len(tracks) > len(takes))
