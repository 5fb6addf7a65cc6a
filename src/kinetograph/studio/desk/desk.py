"""The desk: the one project that is open, the pages that show it, and what they ask for."""

from __future__ import annotations

import asyncio
import functools
import operator
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import msgspec

from kinetograph.errors import RequestError
from kinetograph.studio import registry as making
from kinetograph.studio.browsing import add_recording, with_recordings
from kinetograph.studio.desk.dropping import keep
from kinetograph.studio.desk.failures import failure
from kinetograph.studio.desk.history import History
from kinetograph.studio.desk.questions import Questions
from kinetograph.studio.desk.running import Runner
from kinetograph.studio.desk.solving import Solver
from kinetograph.studio.desk.welcome import welcome
from kinetograph.studio.messages import (
    Cancel,
    Edit,
    Message,
    Redo,
    Said,
    Solve,
    State,
    StopRun,
    Undo,
    Welcome,
    read_blob,
)
from kinetograph.studio.project import Mode, Project, write_project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Section

_TYPES = (Edit, Undo, Redo, Solve, Cancel, StopRun, *making.ANSWERS, *making.RUNS, *making.HEARD)
_DECODER: msgspec.json.Decoder[Message] = msgspec.json.Decoder(type=functools.reduce(operator.or_, _TYPES))
_PARTS = {
    field.name: field.type
    for field in msgspec.structs.fields(Project)
    if field.name in ("mode", "character", "walk", "keys", "duet", "sensors")
}


class Page(Protocol):
    """A page that is open."""

    def post(self, frame: Message | bytes) -> None:
        """Send a message or a binary frame, in the order of the calls."""
        ...


class Desk:
    """A project, its pages and its work.

    Parameters
    ----------
    path : Path
        The project's file.
    project : Project
        As it is at first.
    sections : mapping of str to Section
        What makes each section.
    """

    def __init__(self, path: Path, project: Project, sections: Mapping[Mode, Section] = making.SECTIONS) -> None:
        self.path = path
        self.history = History(project)
        self.room = Room(path.parent)
        self.solver = Solver(self.room, sections, self.post)
        self._pages: dict[Page, Runner] = {}
        self._questions = Questions()

    def post(self, frame: Message | bytes) -> None:
        """Send something to every page."""
        for page in list(self._pages):
            page.post(frame)

    def join(self, page: Page) -> None:
        """A page is open: it is sent what there is."""
        self._pages[page] = Runner(self.room, page.post)
        page.post(self.welcome())
        page.post(state_of(self.history))
        self.solver.make(self.history.project)

    def leave(self, page: Page) -> None:
        """A page is gone, and what it ran live ends."""
        self._pages.pop(page).stop()

    async def hear(self, page: Page, frame: str | bytes) -> None:
        """Do what a page asks for; what cannot be done is answered by one line. Nothing is raised."""
        try:
            if isinstance(frame, bytes):
                await self._keep(page, frame)
            else:
                await self._hear(page, _decoded(frame))
        except Exception as error:  # the server goes on
            page.post(failure(error))

    def replace(self, project: Project) -> None:
        """Change the project by something that is no edit, and tell every page."""
        self.history.replace(project)
        self._changed()
        self.post(self.welcome())
        self.solver.make(project)

    async def _hear(self, page: Page, message: Message) -> None:
        match message:
            case Edit():
                self._edit(page, message)
            case Undo() | Redo():
                step = self.history.undo if isinstance(message, Undo) else self.history.redo
                if step():
                    self._changed(page, message.number)
                else:
                    page.post(state_of(self.history, message.number))
                self.solver.make(self.history.project)
            case Solve():
                self.solver.make(self.history.project, again=True)
            case Cancel():
                self.solver.stop()
            case StopRun():
                self._pages[page].stop()
            case _ if type(message) in making.RUNS:
                self._pages[page].start(making.RUNS[type(message)], self.history.project, message)
            case _ if type(message) in making.HEARD:
                self._pages[page].hear(message)
            case _:
                answer = functools.partial(making.ANSWERS[type(message)], self.room, self.history.project, message)
                await self._questions.take(page, answer, getattr(message, "id", None))

    def _edit(self, page: Page, edit: Edit) -> None:
        changed = self.history.edit(edited(self.history.project, edit), edit.label[:80], edit.merge)
        if changed:
            self._changed(page, edit.number)
        else:
            page.post(state_of(self.history, edit.number))
        if edit.solve:
            self.solver.make(self.history.project)

    def _changed(self, by: Page | None = None, number: int = 0) -> None:
        """Save the project, and tell every page; the page that changed it is given its number again."""
        write_project(self.history.project, self.path)
        for page in list(self._pages):
            page.post(state_of(self.history, number if page is by else 0))

    async def _keep(self, page: Page, frame: bytes) -> None:
        """Take a file that was dropped; a recording is added to the project's own library of recordings."""
        header, payload = read_blob(frame)
        loop = asyncio.get_running_loop()

        def kept() -> Message:
            answer = keep(self.room, header, payload)
            said = add_recording(self.room, answer.name) if header.role == "recording" else None
            loop.call_soon_threadsafe(_tell, self, said)
            return answer

        await self._questions.take(page, kept, header.id)

    def welcome(self) -> Welcome:
        """What a page is sent first."""
        return welcome(self.history.project, self.room)


def _tell(desk: Desk, said: tuple[str, ...] | None) -> None:
    """Tell every page about a file that was kept, and what was guessed of a recording."""
    project = desk.history.project if said is None else with_recordings(desk.history.project)
    if project != desk.history.project:
        desk.replace(project)
    else:
        desk.post(desk.welcome())
    for line in said or ():
        desk.post(Said(line))


def state_of(history: History, number: int = 0) -> State:
    """The project as pages are sent it, with the number of the edit that this answers."""
    return State(history.project, history.revision, history.undo_label, history.redo_label, number)


def edited(project: Project, edit: Edit) -> Project:
    """A project after an edit.

    Parameters
    ----------
    project : Project
    edit : Edit

    Raises
    ------
    RequestError
        For a part that there is not, or a value that it cannot have.
    """
    if edit.part not in _PARTS:
        raise RequestError(f"an edit is of one of {', '.join(_PARTS)}; found {edit.part[:80]!r}")
    try:
        value = msgspec.convert(edit.value, _PARTS[edit.part])
    except msgspec.ValidationError as error:
        raise RequestError(f"{edit.part}: {error}") from None
    return msgspec.structs.replace(project, **{edit.part: value})


def _decoded(frame: str) -> Message:
    try:
        return _DECODER.decode(frame)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise RequestError(f"expected a message of the studio, found: {error}") from None
