"""The lines that are exchanged.

A request is ``{"id": 1, "method": "walk", "params": {...}}``, with any number or text as its id. Its answers repeat the
id: lines with ``"progress": [done, total]``, with ``"note": "..."`` or, in a live session, ``"event": {...}`` while it
is worked on, and at the end one with ``"result"`` or with ``"error": {"kind": ..., "message": ...}``. A line that is no
request is answered with the id null.
The first request is ``hello``, with the protocol's number.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import msgspec

from kinetograph.errors import RequestError

PROTOCOL = 1
"""Raised where an older client or server would not understand the other."""

Id = int | str | None


class Request(msgspec.Struct, forbid_unknown_fields=True):
    """A line of a client.

    Parameters
    ----------
    method : str
    id : int or str, optional
        Repeated in the answers.
    params : dict, optional
    """

    method: str
    id: Id = None
    params: dict[str, Any] = msgspec.field(default_factory=dict)


def read_request(line: str) -> Request:
    """A line as a request.

    Raises
    ------
    RequestError
        For text that is no request.
    """
    try:
        return msgspec.json.decode(line.encode("utf-8", "replace"), type=Request)
    except (msgspec.MsgspecError, RecursionError) as error:
        found = line.strip()[:60]
        raise RequestError(
            f'expected a line of JSON, {{"id": 1, "method": "hello", "params": {{}}}}, found {found!r}: {error}'
        ) from None


def id_in(line: str) -> Id:
    """The id of a line that is no request, where it has one; None otherwise."""
    try:
        found = msgspec.json.decode(line.encode("utf-8", "replace"))
    except (msgspec.MsgspecError, RecursionError):
        return None
    given = found.get("id") if isinstance(found, dict) else None
    return given if isinstance(given, int | str) else None


class Answers:
    """The lines that go to the client, whole and in order, from any thread.

    Parameters
    ----------
    write : callable
        Called with one line, without its end.
    """

    def __init__(self, write: Callable[[str], None]) -> None:
        self._write = write
        self._lock = threading.Lock()

    def result(self, of: Id, value: object) -> None:
        """The end of a request that succeeded."""
        self._line({"id": of, "result": value})

    def error(self, of: Id, kind: str, message: str) -> None:
        """The end of a request that failed."""
        self._line({"id": of, "error": {"kind": kind, "message": " ".join(message.split())}})

    def progress(self, of: Id, done: int, total: int) -> None:
        """How far a request is."""
        self._line({"id": of, "progress": [done, total]})

    def note(self, of: Id, text: str) -> None:
        """What a person should know while a request is worked on."""
        self._line({"id": of, "note": " ".join(text.split())})

    def event(self, of: Id, value: object) -> None:
        """What a request has to show before its end."""
        self._line({"id": of, "event": value})

    def _line(self, fields: dict[str, object]) -> None:
        text = msgspec.json.encode(fields).decode()
        with self._lock:
            self._write(text)
