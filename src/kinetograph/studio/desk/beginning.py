"""What is done once the page can be opened: libraries are found, and models fitted before they are asked for."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Mapping
from pathlib import Path

import msgspec

from kinetograph.errors import KinetographError
from kinetograph.studio import registry as making
from kinetograph.studio.desk.desk import Desk
from kinetograph.studio.messages import Failed, Said, Working
from kinetograph.studio.project import Project

FETCHING = "fetching the sample recordings"
READYING = "getting ready; the first time, the search is compiled for this processor"

_USUAL = 40.0  # seconds that this takes the first time


def with_libraries(project: Project, folders: Mapping[str, Path], base: Path) -> Project:
    """A project with libraries before those that it has.

    Parameters
    ----------
    project : Project
    folders : mapping of str to Path
        By name.
    base : Path
        The project's folder: what lies within it is named from there, so that the folder can be moved.

    Returns
    -------
    Project
    """
    named = {name: _from(folder, base) for name, folder in folders.items()}
    kept = {name: folder for name, folder in project.libraries.items() if folder not in named.values()}
    return msgspec.structs.replace(project, libraries={**named, **{n: f for n, f in kept.items() if n not in named}})


async def begin(desk: Desk) -> None:
    """Fetch the sample where a project has no library, then fit the models of what is shown.

    Parameters
    ----------
    desk : Desk
    """
    if not desk.history.project.libraries:
        await _fetch(desk)
    await _warm(desk)


async def _fetch(desk: Desk) -> None:
    from kinetograph.studio.sample import sample_libraries

    loop = asyncio.get_running_loop()

    def progress(done: int, total: int) -> None:
        loop.call_soon_threadsafe(desk.post, Working(FETCHING, done, total))

    try:
        found = await asyncio.to_thread(sample_libraries, progress)
    except (KinetographError, OSError) as error:
        desk.post(Failed(f"the sample cannot be fetched: {' '.join(str(error).split())}"))
        return
    desk.post(Working(FETCHING, 1, 1))
    desk.replace(with_libraries(desk.history.project, found, desk.path.parent))


async def _warm(desk: Desk) -> None:
    """Fit the models that will be asked for; what cannot be fitted is said when it is asked for."""
    for prepare in making.PREPARE:
        task = asyncio.create_task(asyncio.to_thread(prepare, desk.history.project, desk.room))
        seconds = 0.0
        while not (await asyncio.wait({task}, timeout=1.0))[0]:
            seconds += 1.0
            desk.post(Working(READYING, seconds, max(_USUAL, seconds + 1.0)))
        if seconds:
            desk.post(Working(READYING, 1, 1))
        error = task.exception()
        if isinstance(error, KinetographError):
            desk.post(Said(" ".join(str(error).split())))
        elif error is not None:
            raise error


def _from(folder: Path, base: Path) -> str:
    whole, base = folder.resolve(), base.resolve()
    return os.fspath(whole.relative_to(base)) if whole.is_relative_to(base) else os.fspath(whole)
