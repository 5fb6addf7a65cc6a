"""Results of work in shards, on disk by content, so that a run goes on where it was stopped."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinetograph.errors import LibraryError
from kinetograph.library import fingerprints, kept_files
from kinetograph.library.kept_files import SUFFIX, About
from kinetograph.library.packing import UnpackableError, UnreadableError, pack


@dataclass(frozen=True)
class Results:
    """A folder of results, a file each, under a digest of the function, of this package's code, and of the item.

    Parameters
    ----------
    folder : Path
        It is made where it is not there.
    """

    folder: Path

    def key(self, function: Callable[[Any], Any], item: object) -> str:
        """What a result is called. Raises LibraryError for an item that has no text, such as an open file."""
        name = f"{function.__module__}.{function.__qualname__}"
        try:
            return fingerprints.digest(name, fingerprints.state(item), fingerprints.of_code())
        except TypeError as error:
            raise LibraryError(f"{self.folder}: results of {name} cannot be kept: {error}") from error

    def find(self, key: str) -> tuple[Any, ...]:
        """The result, alone in a tuple; an empty one where it is not there, or was not written by this user."""
        try:
            return (kept_files.read(self._path(key), self._secret()),)
        except (OSError, UnreadableError):
            return ()

    def keep(self, key: str, result: object) -> None:
        """Write a result, wholly or not at all. Raises LibraryError where that cannot be."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            kept_files.write(self._path(key), About("result", "", key, "", ""), pack(result), self._secret())
        except OSError as error:
            raise LibraryError(f"{self.folder}: cannot keep results here: {error.strerror}") from error
        except UnpackableError as error:
            raise LibraryError(f"{self.folder}: a result cannot be kept: {error}") from error

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{SUFFIX}"

    def _secret(self) -> bytes:
        secret = kept_files.user_key()
        if secret is None:
            raise LibraryError(f"{self.folder}: results need a key in the user's folder, which cannot be written")
        return secret
