"""The loop: lines are read, requests are worked on one after another, and none of them ends the process."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import msgspec

import kinetograph
from kinetograph.errors import KinetographError, RequestError
from kinetograph.progress import Progress
from kinetograph.service.job import Job
from kinetograph.service.methods import ENDLESS, METHODS, method
from kinetograph.service.protocol import PROTOCOL, Answers, Id, Request, id_in, read_request
from kinetograph.service.warm import Warm
from kinetograph.stopping import stoppable

_SELDOM = 0.1  # seconds between two lines of progress


class _Cancelled(Exception):
    """Raised inside a request that the client no longer wants."""


def serve(lines: Iterable[str], write: Callable[[str], None]) -> None:
    """Answer requests until there are no more lines; what was asked for by then is still answered, live sessions end.

    Parameters
    ----------
    lines : iterable of str
        One request each.
    write : callable
        Called with one line, without its end, from any thread.

    Raises
    ------
    OSError
        Where the client has gone.
    """
    server = _Server(Answers(write))
    worker = threading.Thread(target=server.work, daemon=True)
    worker.start()
    for line in lines:
        if line.strip():
            server.hear(line)
        if server.broken is not None:
            raise server.broken
    server.end()
    worker.join()
    if server.broken is not None:
        raise server.broken


class _Server:
    """Requests that wait, and the one that is worked on."""

    def __init__(self, answers: Answers) -> None:
        self.answers = answers
        self.broken: OSError | None = None
        self._waiting: queue.SimpleQueue[Request | None] = queue.SimpleQueue()
        self._cancelled: set[Id] = set()
        self._open: dict[Id, str] = {}
        self._warm = Warm()

    def hear(self, line: str) -> None:
        """Take in a line; what needs no work is answered at once."""
        try:
            request = read_request(line)
        except RequestError as error:
            self.answers.error(id_in(line), "RequestError", str(error))
            return
        if request.method == "hello":
            self._hello(request)
        elif request.method == "cancel":
            self._cancel(request)
        elif request.method not in METHODS:
            known = ", ".join(sorted(METHODS))
            self.answers.error(request.id, "UnknownMethod", f"unknown method {request.method!r}; expected {known}")
        else:
            self._open[request.id] = request.method
            self._waiting.put(request)

    def end(self) -> None:
        """No more lines will come."""
        self._cancelled |= {of for of, name in list(self._open.items()) if name in ENDLESS}
        self._waiting.put(None)

    def work(self) -> None:
        """Answer what waits, in order, until the end."""
        try:
            while (request := self._waiting.get()) is not None:
                self._answer(request)
                self._open.pop(request.id, None)
                self._cancelled.discard(request.id)
        except OSError as error:  # nobody reads the answers
            self.broken = error

    def _hello(self, request: Request) -> None:
        wanted = request.params.get("protocol")
        if wanted != PROTOCOL:
            self.answers.error(
                request.id,
                "Protocol",
                f"kinetograph {kinetograph.__version__} speaks protocol {PROTOCOL}, the client {wanted}: "
                "bring the older of the two up to date",
            )
            return
        known = {"protocol": PROTOCOL, "version": kinetograph.__version__, "methods": sorted(METHODS)}
        self.answers.result(request.id, known)

    def _cancel(self, request: Request) -> None:
        unwanted = request.params.get("id")
        found = unwanted in self._open
        if found:
            self._cancelled.add(unwanted)
        if request.id is not None:
            self.answers.result(request.id, {"cancelled": found})

    def _answer(self, request: Request) -> None:
        """Work on a request; whatever goes wrong is its answer."""
        progress = self._progress_of(request.id)
        try:
            progress(0, 1)
            result = stoppable(lambda report: self._result(request, report), progress)
        except _Cancelled:
            self.answers.error(request.id, "Cancelled", "cancelled")
        except KinetographError as error:
            self.answers.error(request.id, type(error).__name__, str(error))
        except OSError as error:
            where = f"{error.filename}: " if error.filename else ""
            self.answers.error(request.id, "OSError", f"{where}{error.strerror or error}")
        except MemoryError:
            self.answers.error(request.id, "MemoryError", "not enough memory; use fewer takes, or ask for less")
        except Exception as error:
            said = f"{type(error).__name__}: {error}"
            self.answers.error(request.id, "Failure", f"an error in kinetograph itself, {said}")
        else:
            self.answers.result(request.id, result)

    def _result(self, request: Request, progress: Progress) -> object:
        kind, run = method(request.method)
        try:
            params: Any = msgspec.convert(request.params, kind)
        except msgspec.ValidationError as error:
            raise RequestError(f"{request.method}: {error}") from None
        note, event = partial(self.answers.note, request.id), partial(self.answers.event, request.id)
        return run(params, Job(self._warm, progress, note, event))

    def _progress_of(self, of: Id) -> Progress:
        """Progress that tells the client now and then, and raises where the request is cancelled."""
        noted, latest = [time.monotonic()], [(0, 1)]

        def progress(done: int, total: int) -> None:
            if of in self._cancelled:
                raise _Cancelled
            now = time.monotonic()
            if (done, total) != latest[0] and now - noted[0] >= _SELDOM:
                noted[0], latest[0] = now, (done, total)
                self.answers.progress(of, done, total)

        return progress
