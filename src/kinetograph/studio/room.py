"""What the sections of a project work with: its folder, its libraries opened once, and models fitted once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, TypeVar

from kinetograph.character import Character
from kinetograph.errors import RequestError
from kinetograph.library import Library
from kinetograph.studio.made import Made
from kinetograph.studio.project import Mode

Fitted = TypeVar("Fitted")

EXPORTS = "exports"
"""The folder of what was exported."""

FILES = "files"
"""The folder, in a project's own, of the files that were dropped onto the page."""

_KEPT = 6  # models


class _Model:
    """A model that is fitted once."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.fitted = False
        self.value: Any = None


class Room:
    """A project's folder, its libraries and models.

    Parameters
    ----------
    folder : Path
        The project's folder.

    Attributes
    ----------
    latest : dict of str to Made
        What was made last of each section.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.latest: dict[Mode, Made] = {}
        self._lock = threading.RLock()
        self._models: dict[Hashable, _Model] = {}
        self._characters: dict[str, Character] = {}

    def library(self, libraries: dict[str, str], name: str) -> Library:
        """A library of a project by its name, or the first.

        Parameters
        ----------
        libraries : dict of str to str
            The project's.
        name : str
            ``""`` for the first.

        Returns
        -------
        Library

        Raises
        ------
        RequestError
            Where there is none of that name.
        """
        from kinetograph.pipeline import open_library

        if not libraries:
            raise RequestError("the project has no library; name one: kinetograph studio LIBRARY")
        if name and name not in libraries:
            raise RequestError(f"the project has no library {name!r}; it has {', '.join(sorted(libraries))}")
        return open_library(self.folder / libraries[name or next(iter(libraries))])

    def fitted(self, library: Library, key: Hashable, fit: Callable[[], Fitted]) -> Fitted:
        """A model, fitted on first use and again when its library has changed.

        Parameters
        ----------
        library : Library
        key : hashable
            All that the fit depends on, besides the library.
        fit : callable
            Fits it.
        """
        whole = (library.path, _state(library), key)
        with self._lock:
            model = self._models.pop(whole, None) or _Model()
            while len(self._models) >= _KEPT:
                self._models.pop(next(iter(self._models)))
            self._models[whole] = model  # the one used last is dropped last
        with model.lock:  # whoever asks meanwhile waits for the same one, and nobody for another
            if not model.fitted:
                model.value = fit()
                model.fitted = True
            found: Fitted = model.value
            return found

    def file(self, name: str) -> Path:
        """A file of the project.

        Raises
        ------
        RequestError
            For a name that is no plain file name, or where there is no such file.
        """
        path = self.folder / FILES / plain_name(name)
        if not path.is_file():
            raise RequestError(f"the project has no file {name!r}; drop it onto the page")
        return path

    def files(self) -> tuple[str, ...]:
        """The names of the project's files."""
        folder = self.folder / FILES
        return tuple(sorted(path.name for path in folder.iterdir())) if folder.is_dir() else ()

    def character(self, name: str) -> Character | None:
        """The character of a name: None for capsules, the sample's for ``human``, else a file of the project."""
        from kinetograph.formats.gltf import read_character
        from kinetograph.samples import human

        if not name:
            return None
        with self._lock:
            if name not in self._characters:
                self._characters[name] = human() if name == "human" else read_character(self.file(name), [])
            return self._characters[name]


def plain_name(name: str) -> str:
    """The name, if it is that of a file in a folder and leads nowhere else.

    Raises
    ------
    RequestError
        Otherwise.
    """
    wrong = not name or name != name.strip() or name.startswith(".") or len(name.encode()) > 200
    if wrong or any(c in '/\\:*?"<>|' or ord(c) < 32 for c in name):
        raise RequestError(f"expected the name of a file without a folder, found {name!r}")
    return name


def _state(library: Library) -> tuple[int, ...]:
    """What changes when a library does."""
    states = [path.stat() for path in sorted(library.path.iterdir()) if path.suffix == ".sqlite"]
    return tuple(number for each in states for number in (each.st_mtime_ns, each.st_size))
