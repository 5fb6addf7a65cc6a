"""Errors: one line each, saying what was expected, what was found, where, and what to try."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

_LONGEST = 1000  # letters of a message, of which a damaged file may have given any number


class KinetographError(Exception):
    """Base of every error that Kinetograph raises on purpose; its text is one line, of at most a thousand letters."""

    def __str__(self) -> str:
        text = " ".join(super().__str__().splitlines())  # a file's own names, and arrays, may hold line breaks
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 300]} ... {text[-295:]}"


class DataError(KinetographError, ValueError):
    """Arrays that break an invariant: a shape, a unit quaternion, a finite value."""


class RequestError(KinetographError, ValueError):
    """A request that cannot be met: an unknown name, an option out of range."""


class ExistsError(RequestError):
    """An output that exists already and may not be overwritten."""


class UnmetError(RequestError):
    """A key that cannot be met as it is asked for, and what is nearest to it that can.

    Parameters
    ----------
    message : str
    label : str
        What the key is called.
    time : float, optional
        The second of the result at which it can be met, else as asked for.
    position : tuple of float, (x, z), optional
        The place in metres at which it can be met, else as asked for.
    """

    def __init__(
        self, message: str, label: str, time: float | None = None, position: tuple[float, float] | None = None
    ) -> None:
        self.label, self.time, self.position = label, time, position
        super().__init__(message)

    def __reduce__(self) -> tuple[Any, ...]:
        return UnmetError, (self.args[0], self.label, self.time, self.position)


class TooSoonError(UnmetError):
    """A key that is to be met sooner than recordings lead to it.

    Parameters
    ----------
    message : str
    label : str
        What the key is called.
    seconds : float
        How much later it can be met.
    time : float, optional
        The second of the result at which it can be met; not known where nothing was tried.
    position : tuple of float, (x, z), optional
        The place in metres at which it can be met in time, where it asks for a place.
    """

    def __init__(
        self,
        message: str,
        label: str,
        seconds: float,
        time: float | None = None,
        position: tuple[float, float] | None = None,
    ) -> None:
        self.seconds = seconds
        super().__init__(message, label, time, position)

    def __reduce__(self) -> tuple[Any, ...]:
        return TooSoonError, (self.args[0], self.label, self.seconds, self.time, self.position)


class WorkError(KinetographError):
    """Work of other processes or machines that cannot go on: a cluster that is not there, workers that are lost."""


class LibraryError(KinetographError):
    """A library folder that is missing, damaged or of another version."""


class FetchError(KinetographError):
    """A download that failed: no network, a wrong hash, no room."""


class FormatError(KinetographError, ValueError):
    """A file that cannot be read, with the place in it where reading stopped.

    Parameters
    ----------
    path : str or Path
        The file.
    message : str
        What was expected, what was found and what to try.
    line, column : int, optional
        The line in the file and the byte in the line, counted from 1.

    Examples
    --------
    >>> str(FormatError("walk.bvh", "expected 96 values, found 95; is a line cut short?", line=7))
    'walk.bvh:7: expected 96 values, found 95; is a line cut short?'
    """

    def __init__(self, path: str | Path, message: str, *, line: int | None = None, column: int | None = None) -> None:
        self.path = Path(path)
        self.line, self.column = line, column
        where = ":".join(str(part) for part in (path, line, column) if part is not None)
        self._message = message
        super().__init__(f"{where}: {message}")

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(FormatError, line=self.line, column=self.column), (self.path, self._message)
