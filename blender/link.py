# SPDX-License-Identifier: GPL-3.0-or-later
"""A running ``kinetograph serve --stdio``: requests go out, and answers come in, as one line of JSON each.

Nothing here knows Blender. Answers are read by a thread and handed on by `Link.pump`, which whoever waits calls: a
timer of the interface, or a loop.
"""

import contextlib
import json
import os
import queue
import subprocess
import threading
import time

PROTOCOL = 1
_PATIENCE = 30.0  # seconds until the first answer, in which everything may have to be read from a slow disk


class Trouble(Exception):
    """What went wrong, in one line for a person."""


class Ticket:
    """A request that is under way: how far it is, what was said and shown, and how it ended."""

    def __init__(self, number):
        self.number = number
        self.progress = (0, 1)
        self.notes = []
        self.events = []
        self.result = None
        self.error = None

    @property
    def done(self):
        return self.result is not None or self.error is not None


class Link:
    """A process of kinetograph, started on the first request and again where it has died."""

    def __init__(self, command):
        self.command = list(command)
        self.version = ""
        self._process = None
        self._lines = None
        self._said = []
        self._open = {}
        self._number = 0

    @property
    def alive(self):
        return self._process is not None and self._process.poll() is None

    def ask(self, method, params):
        """Send a request; its ticket fills in while `pump` is called."""
        if not self.alive:
            if self._process is not None:
                self._died()
            self._start()
        return self._send(method, params)

    def _send(self, method, params):
        self._number += 1
        ticket = Ticket(self._number)
        line = json.dumps({"id": ticket.number, "method": method, "params": params}) + "\n"
        self._open[ticket.number] = ticket
        try:
            self._process.stdin.write(line.encode())
            self._process.stdin.flush()
        except OSError:
            self._died()
        return ticket

    def pump(self):
        """Hand on what has arrived."""
        while self._lines is not None:
            try:
                line = self._lines.get_nowait()
            except queue.Empty:
                return
            if line is None:
                self._died()
                return
            self._take(line)

    def _take(self, line):
        try:
            answer = json.loads(line)
            ticket = self._open.get(answer["id"])
        except (ValueError, KeyError, TypeError):
            return
        if ticket is None:
            return
        if "progress" in answer:
            ticket.progress = tuple(answer["progress"])
        elif "note" in answer:
            ticket.notes.append(answer["note"])
        elif "event" in answer:
            ticket.events.append(answer["event"])
        else:
            ticket.error = answer["error"]["message"] if "error" in answer else None
            ticket.result = answer.get("result")
            del self._open[ticket.number]

    def cancel(self, ticket):
        """Give a request up: the process is asked to stop, and ended where it does not within a second."""
        if ticket.done or not self.alive:
            return
        self._send("cancel", {"id": ticket.number})
        end = time.monotonic() + 1.0
        while not ticket.done and time.monotonic() < end:
            self.pump()
            time.sleep(0.01)
        if not ticket.done:
            self.close()
        ticket.error = "cancelled"

    def close(self):
        """End the process."""
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        _end(process)
        self._fail("cancelled")

    def _start(self):
        """Start the process and agree on the protocol. Raises Trouble."""
        self._said, self._lines = [], queue.Queue()
        hidden = {"creationflags": subprocess.CREATE_NO_WINDOW} if os.name == "nt" else {}
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        try:
            self._process = subprocess.Popen([*self.command, "serve", "--stdio"], env=_environment(), **pipes, **hidden)
        except OSError as error:
            raise Trouble(f"{self.command[0]} cannot be started: {error.strerror or error}") from None
        threading.Thread(target=_listen, args=(self._process.stdout, self._lines), daemon=True).start()
        threading.Thread(target=_collect, args=(self._process.stderr, self._said), daemon=True).start()
        hello = self._send("hello", {"protocol": PROTOCOL})
        end = time.monotonic() + _PATIENCE
        while not hello.done and time.monotonic() < end:
            self.pump()
            time.sleep(0.01)
        if hello.error is not None or hello.result is None:
            said = " ".join(" ".join(self._said).split())
            self.close()
            raise Trouble(_no_hello(self.command[0], hello.error or "", said))
        self.version = hello.result.get("version", "")

    def _died(self):
        """The process has ended by itself."""
        process, self._process = self._process, None
        code = _end(process) if process is not None else None
        said = " ".join(self._said[-1:]).strip()
        self._fail(f"kinetograph ended unexpectedly ({_how(code)}); try again{': ' + said if said else ''}")

    def _fail(self, message):
        for ticket in self._open.values():
            ticket.error = ticket.error or message
        self._open.clear()


def _end(process):
    """End a process, and close what leads to it; how it ended."""
    if process.poll() is None:
        try:
            process.wait(0.2)  # it has closed its output, and is about to end
        except subprocess.TimeoutExpired:
            process.kill()
    for stream in (process.stdin, process.stdout, process.stderr):
        with contextlib.suppress(OSError):
            stream.close()
    return process.wait()


def _how(code):
    return f"it was killed by signal {-code}" if code is not None and code < 0 else f"status {code}"


def _no_hello(command, error, said):
    if "No such command" in said or "unrecognized" in said or "invalid choice" in said:
        return f"{command} is an older kinetograph, without serve --stdio: update it (pip install -U kinetograph)"
    if "protocol" in error:
        return error
    if "killed" in error:
        return error
    if said:
        return f"{command} is not a kinetograph that works: {said[-300:]}"
    return f"{command} did not answer as kinetograph does; name another in the preferences"


def _listen(stream, lines):
    try:
        for line in stream:
            lines.put(line.decode("utf-8", "replace"))
    except (OSError, ValueError):
        pass
    lines.put(None)


def _collect(stream, said):
    try:
        for line in stream:
            said.append(line.decode("utf-8", "replace").rstrip())
            del said[:-20]
    except (OSError, ValueError):
        pass


def _environment():
    """The environment without what is Blender's own Python's."""
    return {key: value for key, value in os.environ.items() if key not in ("PYTHONHOME", "PYTHONSTARTUP")}
