"""What is said about the project as a whole: edits, what is being made, and files."""

from __future__ import annotations

from typing import Any

import msgspec

from kinetograph.studio.messages.frames import Message
from kinetograph.studio.project import Mode, Project


class Edit(Message, frozen=True, tag="edit"):
    """A section, or a field, of the project in a new state.

    Parameters
    ----------
    part : str
        ``walk``, ``keys``, ``duet``, ``sensors``, ``mode`` or ``character``.
    value : object
        The whole part.
    label : str
        What undo calls it.
    merge : bool
        Whether it goes on from the edit before, as a slider's steps do: both are undone as one.
    solve : bool
        Whether the section is made anew.
    number : int
        Counts the page's edits; `State` has it again.
    """

    part: str
    value: Any
    label: str = "edit"
    merge: bool = False
    solve: bool = True
    number: int = 0


class Undo(Message, frozen=True, tag="undo"):
    """Take the last edit back; its number is answered as that of an edit."""

    number: int = 0


class Redo(Message, frozen=True, tag="redo"):
    """Make the edit that was taken back again; its number is answered as that of an edit."""

    number: int = 0


class Solve(Message, frozen=True, tag="solve"):
    """Make the section that is shown."""


class Cancel(Message, frozen=True, tag="cancel"):
    """Stop what is being made."""


class StopRun(Message, frozen=True, tag="stop_run"):
    """End what runs live."""


class LibraryRow(msgspec.Struct, frozen=True):
    """A library of the project: its takes, and what can be done with it."""

    name: str
    takes: int
    seconds: float
    tracks: tuple[str, ...]
    partners: bool


class Welcome(Message, frozen=True, tag="welcome"):
    """The first message to a page, sent again when what it says changes."""

    version: str
    formats: tuple[str, ...]
    films: tuple[str, ...]
    libraries: tuple[LibraryRow, ...]
    files: tuple[str, ...]


class State(Message, frozen=True, tag="state"):
    """The project, whenever it changes.

    Parameters
    ----------
    project : Project
    revision : int
        Counts its changes.
    undo, redo : str, optional
        What would be taken back or made again.
    number : int
        That of the edit which this answers, on the page that made it.
    """

    project: Project
    revision: int
    undo: str | None = None
    redo: str | None = None
    number: int = 0


class Working(Message, frozen=True, tag="working"):
    """Something is being made or fetched: how far it is; ``done`` is ``total`` at its end."""

    label: str
    done: float
    total: float
    section: Mode | None = None


class Nothing(Message, frozen=True, tag="nothing"):
    """A section asks for nothing that could be made yet."""

    section: Mode


class Failed(Message, frozen=True, tag="failed"):
    """Something could not be done, in one line."""

    message: str
    id: int | None = None
    section: Mode | None = None


class Said(Message, frozen=True, tag="said"):
    """Something a person should know, in one line."""

    message: str


class ClipHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="clip", omit_defaults=True):
    """The header of a blob whose payload is a GLB that answers a question: a ghost, an alternative, a take.

    Parameters
    ----------
    id : int
    name : str
    floor : float
        Metres.
    start : float
        The second of what is shown at which it begins.
    """

    id: int
    name: str = ""
    floor: float = 0.0
    start: float = 0.0


class LiveHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="live", omit_defaults=True):
    """The header of a blob whose payload is a body as GLB, which the pose frames after it move."""

    section: Mode
    floor: float = 0.0
    characters: tuple[str, ...] = ("motion",)


class Kept(Message, frozen=True, tag="kept"):
    """A file was taken into the project, under this name; the project's files."""

    id: int
    name: str
    files: tuple[str, ...]
