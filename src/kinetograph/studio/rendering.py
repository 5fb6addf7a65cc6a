"""A project without a browser: every section that asks for something is made and written into files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import get_args

import msgspec

from kinetograph.errors import KinetographError, RequestError
from kinetograph.formats import together
from kinetograph.progress import Progress
from kinetograph.studio import exporting
from kinetograph.studio.exporting import Wanted
from kinetograph.studio.made import Made
from kinetograph.studio.project import Mode, Project
from kinetograph.studio.registry import SECTIONS
from kinetograph.studio.room import Room

Watch = Callable[[str], AbstractContextManager[Progress]]
"""Gives the progress of a job by its name."""

MODES: tuple[Mode, ...] = get_args(Mode)


def render(
    project: Project, room: Room, sections: Iterable[Mode], watch: Watch
) -> tuple[dict[Mode, Made], dict[Mode, KinetographError]]:
    """Make the sections of a project that ask for something.

    Parameters
    ----------
    project : Project
    room : Room
        With the project's folder.
    sections : iterable of str
    watch : callable
        Gives the progress of what is made.

    Returns
    -------
    made : dict of str to Made
    failed : dict of str to KinetographError
        The sections that could not be made, and why.
    """
    made: dict[Mode, Made] = {}
    failed: dict[Mode, KinetographError] = {}
    for section in sections:
        if section not in SECTIONS:
            continue
        try:
            with watch(f"making {section}") as progress:
                result = SECTIONS[section](project, room, progress)
        except KinetographError as error:
            failed[section] = error
            continue
        if result is not None:
            room.latest[section] = made[section] = result
    return made, failed


def write(
    project: Project, room: Room, made: Mapping[Mode, Made], folder: Path, wanted: tuple[Wanted, ...], watch: Watch
) -> tuple[Path, ...]:
    """Write what was made of a project's sections, as the studio exports it.

    Parameters
    ----------
    project : Project
    room : Room
    made : mapping of str to Made
    folder : Path
    wanted : tuple of Wanted
        For each section that was made.
    watch : callable
        Gives the progress of what is written.

    Returns
    -------
    tuple of Path
    """
    character = room.character(project.character)
    paths: list[Path] = []
    for (section, result), each in zip(made.items(), wanted, strict=True):
        with together(), watch(f"writing {section}") as progress:
            paths += exporting.export(result, character, folder, each, progress)
    return tuple(paths)


def relocated(project: Project, places: Iterable[str]) -> Project:
    """The project with libraries in other folders.

    Parameters
    ----------
    project : Project
    places : iterable of str
        As in ``walks=/data/walks``.

    Returns
    -------
    Project

    Raises
    ------
    RequestError
        For text of another form, or a name that the project does not have.
    """
    libraries = dict(project.libraries)
    for place in places:
        name, separator, path = place.partition("=")
        if not separator or not path:
            raise RequestError(f"expected NAME=PATH, as in walks=/data/walks; found {place!r}")
        if name not in libraries:
            raise RequestError(f"the project has no library {name!r}; it has {', '.join(sorted(libraries)) or 'none'}")
        libraries[name] = str(Path(path).absolute())
    return msgspec.structs.replace(project, libraries=libraries)


def refuse_nothing(made: Mapping[Mode, Made], failed: Mapping[Mode, KinetographError], asked: Iterable[Mode]) -> None:
    """Raise RequestError where nothing was made of what was asked for by name, or of anything."""
    if missing := [section for section in asked if section not in made and section not in failed]:
        raise RequestError(f"the project's section {missing[0]!r} asks for nothing yet")
    if not made and not failed:
        raise RequestError(f"the project asks for nothing yet; open it with kinetograph studio ({', '.join(MODES)})")
