# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that asks kinetograph: generators that yield ``(method, params)`` and are sent the answer, or None: go on later.

A task is driven by a timer of the interface (`Runner.step`) or by a loop that waits (`wait_for`). It changes nothing
in the scene before its last answer, and then all at once (`at_once`).
"""

import contextlib
import os
import tempfile
import time
import traceback

import bpy

from . import finding
from .link import Link, Trouble

_held = {"link": None, "command": None, "live": None}


def preferences():
    """The extension's preferences."""
    return bpy.context.preferences.addons[__package__].preferences


def managed_folder():
    """Where the extension makes an environment for kinetograph."""
    try:
        return bpy.utils.extension_path_user(__package__, path="environment", create=False)
    except (ValueError, AttributeError):  # installed as an add-on of the older kind
        return os.path.join(bpy.utils.user_resource("DATAFILES"), "kinetograph")


def link():
    """The running kinetograph of the preferences. Raises Trouble."""
    command = finding.command(preferences().command, managed_folder())
    if _held["link"] is None or _held["command"] != command:
        close()
        _held.update(link=Link(command), command=command)
    return _held["link"]


def live():
    """The session of sensors that goes on, or None; kinetograph does nothing else meanwhile."""
    return _held["live"]


def keep_live(session):
    """Know a session of sensors, or none."""
    _held["live"] = session


def close():
    """End the running kinetograph."""
    if _held["link"] is not None:
        _held["link"].close()
    _held.update(link=None, command=None)


def folder():
    """A folder for arrays, which Blender removes when it ends."""
    path = os.path.join(bpy.app.tempdir or tempfile.gettempdir(), "kinetograph")
    os.makedirs(path, exist_ok=True)
    return path


class Runner:
    """A task, and the request that it waits for."""

    def __init__(self, task):
        if live() is not None:
            raise Trouble("sensors are live; stop them first")
        self._task = task
        self._link = link()
        self._ticket = None
        self.notes = []
        self.message = None
        self.writing = False
        self._go_on(None)

    @property
    def done(self):
        return self.message is not None

    @property
    def progress(self):
        """The share of the present request that is done, 0 to 1."""
        done, total = self._ticket.progress if self._ticket else (0, 1)
        return done / max(total, 1)

    @property
    def said(self):
        """The latest note."""
        return self._ticket.notes[-1] if self._ticket is not None and self._ticket.notes else ""

    def events(self):
        """What has arrived to be shown since the last call."""
        events = []
        if self._ticket is not None:
            events, self._ticket.events = self._ticket.events, []
        return events

    def step(self):
        """Hand on answers that have arrived, or do a slice of work; whether the task is done. Raises Trouble."""
        self._link.pump()
        if self.writing:
            self._go_on(None)
        while not self.done and not self.writing and self._ticket.done:
            if self._ticket.error is not None:
                self._stop()
                raise Trouble(self._ticket.error)
            self._go_on(self._ticket.result)
        return self.done

    def cancel(self):
        """Give it up."""
        if self._ticket is not None:
            self._link.cancel(self._ticket)
        self.writing = False
        self._stop()

    def _stop(self):
        self._task.close()

    def _go_on(self, answer):
        try:
            asked = self._task.send(answer)
        except StopIteration as end:
            self.message, self.writing = end.value or "done", False
            return
        except Trouble:
            raise
        except Exception as error:
            traceback.print_exc()
            raise Trouble(f"an error in the extension: {type(error).__name__}: {error}") from None
        self.writing = asked is None
        if self.writing:
            return
        if self._ticket is not None:
            self.notes += self._ticket.notes
        self._ticket = self._link.ask(*asked)


def wait_for(task):
    """Do a task, and wait for it; its last words. Raises Trouble."""
    runner = Runner(task)
    try:
        while not runner.step():
            if not runner.writing:
                time.sleep(0.002)
    except KeyboardInterrupt:
        runner.cancel()
        raise
    return runner.message


_KINDS = ("objects", "armatures", "actions")


@contextlib.contextmanager
def at_once():
    """Changes to the scene, all or none: what was made by then is removed where something goes wrong."""
    before = {kind: set(getattr(bpy.data, kind)) for kind in _KINDS}
    layer = bpy.context.view_layer
    active, chosen = layer.objects.active, list(bpy.context.selected_objects)
    playing = {
        thing: (thing.animation_data.action, getattr(thing.animation_data, "action_slot", None))
        for thing in bpy.data.objects
        if thing.animation_data is not None
    }
    try:
        yield
    except BaseException:
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        for kind in _KINDS:
            for made in set(getattr(bpy.data, kind)) - before[kind]:
                getattr(bpy.data, kind).remove(made)
        for thing, (action, slot) in playing.items():
            thing.animation_data.action = action
            if slot is not None:
                thing.animation_data.action_slot = slot
        for thing in bpy.context.selected_objects:
            thing.select_set(thing in chosen)
        layer.objects.active = active
        raise


def named(name, kind="object"):
    """An object by its name. Raises Trouble."""
    thing = bpy.data.objects.get(name)
    if thing is None:
        raise Trouble(f"there is no {kind} called {name!r}" if name else f"choose a {kind}")
    return thing
