"""The states that a project went through, to take edits back and make them again."""

from __future__ import annotations

from dataclasses import dataclass, field

from kinetograph.studio.project import Project

KEPT = 200
"""Edits that can be taken back."""


@dataclass
class History:
    """A project and its past.

    Parameters
    ----------
    project : Project
        As it is now.
    """

    project: Project
    revision: int = 0
    _done: list[tuple[str, Project]] = field(default_factory=list)
    _undone: list[tuple[str, Project]] = field(default_factory=list)

    @property
    def undo_label(self) -> str | None:
        """What `undo` would take back."""
        return self._done[-1][0] if self._done else None

    @property
    def redo_label(self) -> str | None:
        """What `redo` would make again."""
        return self._undone[-1][0] if self._undone else None

    def edit(self, project: Project, label: str, merge: bool = False) -> bool:
        """Make an edit; whether it changed anything.

        Parameters
        ----------
        project : Project
            As it is after it.
        label : str
            What undo calls it.
        merge : bool
            Whether it goes on from an edit of the same label, and is taken back with that.
        """
        if project == self.project:
            return False
        if not (merge and self.undo_label == label and not self._undone):
            self._done.append((label, self.project))
            del self._done[:-KEPT]
        self._undone.clear()
        self._become(project)
        return True

    def undo(self) -> bool:
        """Take the last edit back; whether there was one."""
        return self._step(self._done, self._undone)

    def redo(self) -> bool:
        """Make the edit that was taken back again; whether there was one."""
        return self._step(self._undone, self._done)

    def replace(self, project: Project) -> None:
        """Change the project by something that is no edit: a library that was fetched."""
        self._become(project)

    def _step(self, source: list[tuple[str, Project]], target: list[tuple[str, Project]]) -> bool:
        if not source:
            return False
        label, project = source.pop()
        target.append((label, self.project))
        self._become(project)
        return True

    def _become(self, project: Project) -> None:
        self.project = project
        self.revision += 1
