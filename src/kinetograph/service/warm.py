"""What stays loaded between requests: libraries by their folder, and the models that were fitted to them last."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from kinetograph.errors import RequestError
from kinetograph.library import Library, Selection
from kinetograph.pipeline import open_library
from kinetograph.synthesis import Synthesis

Fitted = TypeVar("Fitted")

_MODELS = 6
_RESULTS = 32


class Warm:
    """Libraries that are open, and models that are fitted."""

    def __init__(self) -> None:
        self._models: dict[tuple[str, ...], object] = {}
        self._results: dict[str, Synthesis] = {}
        self._numbers = itertools.count(1)

    def library(self, path: str, selection: Selection | None = None) -> Library:
        """A library, or a selection of its takes.

        Raises
        ------
        LibraryError, RequestError
            As `kinetograph.pipeline.open_library`.
        """
        return open_library(Path(path).expanduser(), selection)

    def fitted(self, library: Library, what: object, fit: Callable[[], Fitted]) -> Fitted:
        """A model, fitted only where it is not known or the library has changed.

        Parameters
        ----------
        library : Library
        what : object
            What is fitted, by how it is printed.
        fit : callable
        """
        key = (str(library.path), _state(library), repr(library.names()), repr(what))
        if key not in self._models:
            while len(self._models) >= _MODELS:
                self._models.pop(next(iter(self._models)))
            self._models[key] = fit()
        model = self._models.pop(key)
        self._models[key] = model  # those used longest ago come first
        return model  # type: ignore[return-value]

    def keep(self, synthesis: Synthesis) -> str:
        """What later requests call a result; only the latest are known."""
        while len(self._results) >= _RESULTS:
            self._results.pop(next(iter(self._results)))
        name = f"result {next(self._numbers)}"
        self._results[name] = synthesis
        return name

    def result(self, name: str) -> Synthesis:
        """An earlier result.

        Raises
        ------
        RequestError
            Where it is not known, or no longer.
        """
        if name not in self._results:
            raise RequestError(f"{name or 'that result'} is no longer known; make it once more, and lock the span then")
        return self._results[name]


def _state(library: Library) -> str:
    """When a library was last written to."""
    folder = Path(library.path)
    files = sorted(folder.glob("catalogue.sqlite")) or sorted(folder.glob("*/catalogue.sqlite"))
    stats = [path.stat() for path in files]
    return repr([(stat.st_mtime_ns, stat.st_size) for stat in stats])
