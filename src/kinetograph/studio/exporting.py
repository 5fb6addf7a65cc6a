"""Files of what was made: by the writers of the command line, into a folder, next to what is there."""

from __future__ import annotations

import asyncio
import itertools
import math
import re
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import numpy as np

from kinetograph.character import Character
from kinetograph.errors import KinetographError, RequestError
from kinetograph.formats import WRITERS, WriteOptions, atomic_path, save, write_report
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.signal import Signal
from kinetograph.studio.made import Made, bodies
from kinetograph.studio.messages import Export, Exported, Failed, Message, Working
from kinetograph.studio.project import Project
from kinetograph.studio.room import EXPORTS, Room, plain_name
from kinetograph.studio.sections import Send
from kinetograph.take import Take

MOTIONS = tuple(sorted(WRITERS))
"""Suffixes of motion files."""

PAPERS = (".json", ".png")
"""Suffixes of a report and of a contact sheet."""

SEVERAL = (".fbx", ".glb", ".npz", ".usd", ".usda", ".usdc")
"""Suffixes of files that hold several bodies."""

WRITING = "writing files"
"""What a person reads meanwhile."""

_FILM_WEIGHT = 40  # of a film in the progress, compared with another file
_RATE = 30.0  # of a path in a contact sheet, hertz
_ABANDONED = 3600.0  # seconds after which the draft of a process that was killed is removed
_ONE_AT_A_TIME = threading.Lock()
_DRAFT = re.compile(r"\..*\.[0-9a-f]{12}\.\w+")


@dataclass(frozen=True)
class Wanted:
    """The files that are asked for.

    Parameters
    ----------
    suffixes : tuple of str
        As in ``(".bvh", ".glb")``.
    name : str
        Of the files, without a suffix.
    together : bool
        Write what is shown with it, such as its leader, where the format holds several bodies.
    force : bool
        Overwrite files that exist; else a number is put after the name.

    Raises
    ------
    RequestError
        For suffixes that cannot be written here, none, or a name that is no file's.
    """

    suffixes: tuple[str, ...]
    name: str
    together: bool = False
    force: bool = False

    def __post_init__(self) -> None:
        plain_name(self.name)
        object.__setattr__(self, "suffixes", tuple(dict.fromkeys(suffix.lower() for suffix in self.suffixes)))
        if not self.suffixes:
            raise RequestError(f"choose a format: {', '.join(suffixes())}")
        for suffix in self.suffixes:
            _refuse(suffix)


def films() -> tuple[str, ...]:
    """Suffixes of the films that this machine can make."""
    from kinetograph.drawing import find_ffmpeg

    return (".gif", ".mp4") if find_ffmpeg() else (".gif",)


def suffixes() -> tuple[str, ...]:
    """Suffixes of all files that can be written here."""
    return (*MOTIONS, *films(), *PAPERS)


def _refuse(suffix: str) -> None:
    if suffix == ".mp4" and suffix not in films():
        from kinetograph.drawing.video import ABSENT

        raise RequestError(ABSENT)
    if suffix not in suffixes():
        raise RequestError(f"cannot write files of kind {suffix!r}; expected one of {', '.join(suffixes())}")


def export(
    made: Made, character: Character | None, folder: Path, wanted: Wanted, progress: Progress
) -> tuple[Path, ...]:
    """Write what was made: each file appears whole or not at all.

    Parameters
    ----------
    made : Made
    character : Character, optional
        Whose skin it wears.
    folder : Path
        Made where it does not exist.
    wanted : Wanted
    progress : Progress
        May raise, to stop: the file that is being written is then left out.

    Returns
    -------
    tuple of Path
        The files, in the order of their suffixes.

    Raises
    ------
    RequestError
        A format cannot hold the motion, or the folder cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RequestError(f"{folder}: cannot make this folder: {error.strerror}") from None
    _sweep(folder)
    worn = bodies({"motion": made.synthesis.motion, **made.others}, character, made.annotations)
    paths = free_paths(folder, wanted)
    weights = [_FILM_WEIGHT if path.suffix in films() else 1 for path in paths]
    for number, path in enumerate(paths):
        before, total = sum(weights[:number]), sum(weights)
        part = _part(progress, before, weights[number], total)
        part(0, 1)
        _write(made, path, _Dress(worn, character, wanted), part)
        part(1, 1)
    return paths


async def run(room: Room, project: Project, message: Export, inbox: asyncio.Queue[Message], send: Send) -> None:
    """Export what is shown: progress is sent while files are written, and whoever cancels it stops it.

    Parameters
    ----------
    room : Room
    project : Project
    message : Export
    inbox : asyncio.Queue
        Not used.
    send : callable
        Sends to the page.
    """
    stopped, loop = threading.Event(), asyncio.get_running_loop()

    def progress(done: float, total: float) -> None:
        if stopped.is_set():
            raise RequestError("the export was stopped")
        loop.call_soon_threadsafe(send, Working(WRITING, min(done, total - 1), total))

    try:
        paths = await asyncio.to_thread(_export, room, project, message, progress)
    except KinetographError as error:
        send(Failed(" ".join(str(error).split()), message.id))
    except asyncio.CancelledError:
        stopped.set()
        send(Failed("the export was stopped", message.id))
        raise
    else:
        send(Exported(message.id, tuple((path.name, f"/{EXPORTS}/{quote(path.name)}") for path in paths)))
    finally:
        send(Working(WRITING, 1, 1))


def _export(room: Room, project: Project, message: Export, progress: Progress) -> tuple[Path, ...]:
    made = room.latest.get(project.mode)
    if made is None:
        raise RequestError("there is nothing to export yet")
    wanted = Wanted(message.formats, message.name, message.together)
    with _ONE_AT_A_TIME:  # two that choose their names at once would choose the same
        return export(made, room.character(project.character), room.folder / EXPORTS, wanted, progress)


def free_paths(folder: Path, wanted: Wanted) -> tuple[Path, ...]:
    """Where the files go: ``name.bvh``, ``name.glb``, or with the first number that no file of them has.

    Parameters
    ----------
    folder : Path
    wanted : Wanted

    Returns
    -------
    tuple of Path
    """
    for number in itertools.count(1):
        name = wanted.name if number == 1 else f"{wanted.name}_{number}"
        paths = tuple(folder / f"{name}{suffix}" for suffix in wanted.suffixes)
        if wanted.force or not any(path.exists() for path in paths):
            return paths
    raise AssertionError


@dataclass(frozen=True)
class _Dress:
    """The bodies that are written, whose skin they wear, and what of them is wanted."""

    worn: Take
    character: Character | None
    wanted: Wanted

    def written(self, suffix: str) -> Take | Motion:
        """What a file holds."""
        alone = len(self.worn.tracks) == 1 or not self.wanted.together
        return self.worn.motion("motion") if alone or suffix not in SEVERAL else self.worn


def _write(made: Made, path: Path, dress: _Dress, progress: Progress) -> None:
    force = dress.wanted.force
    if path.suffix in MOTIONS:
        options = None if dress.character is None else WriteOptions(character=dress.character)
        save(dress.written(path.suffix), path, force=force, options=options)
    elif path.suffix == ".json":
        write_report(made.synthesis, path, force=force)
    elif path.suffix == ".png":
        from kinetograph.drawing import draw_synthesis

        with atomic_path(path, force=force) as draft:
            draw_synthesis(made.synthesis, draft, control(made), path.stem)
    else:
        from kinetograph.drawing import character_film

        shown = dress.worn if dress.wanted.together else dress.worn.motion("motion")
        with atomic_path(path, force=force) as draft:
            character_film(shown, draft, dress.character, seconds=math.inf, progress=progress)


def control(made: Made) -> Signal | Motion | None:
    """What a contact sheet shows besides: the path, or the leader."""
    if len(made.path) < 2:
        return made.others.get("leader")
    rows = np.array(made.path)
    times = np.arange(rows[0, 0], rows[-1, 0] + 1e-9, 1 / _RATE)
    x, z = (np.interp(times, rows[:, 0], rows[:, column]) for column in (1, 2))
    return Signal(np.stack([x, np.zeros_like(x), z], axis=1)[:, None], ("path",), "m", _RATE)


def _part(progress: Progress, before: int, weight: int, total: int) -> Progress:
    """The progress of one file as a part of that of all."""

    def report(done: int, of: int) -> None:
        progress(100 * before + 100 * weight * done // max(of, 1), 100 * total)

    return report


def _sweep(folder: Path) -> None:
    """Remove the drafts that processes left when they were killed."""
    for path in folder.iterdir():
        if _DRAFT.fullmatch(path.name) and time.time() - path.stat().st_mtime > _ABANDONED:
            path.unlink(missing_ok=True)
