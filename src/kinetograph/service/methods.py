"""What may be asked for: by name, the parameters and what is done."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

METHODS: Mapping[str, tuple[str, str, str]] = {
    "add": ("recordings", "Add", "add"),
    "alike": ("recordings", "Alike", "alike"),
    "drop": ("recordings", "Drop", "drop"),
    "follow": ("walking", "Follow", "follow"),
    "inbetween": ("keying", "Inbetween", "inbetween"),
    "live": ("listening", "Live", "live"),
    "look": ("recordings", "Look", "look"),
    "render": ("rendering", "Render", "render"),
    "retarget": ("rigs", "Retarget", "retargeted"),
    "roles": ("rigs", "Roles", "roles"),
    "sense": ("sensing", "Sense", "sense"),
    "walk": ("walking", "Walk", "walk"),
}
"""Rooms of this package, what their parameters are, and what is called."""

ENDLESS = frozenset({"live"})
"""Those that go on until they are cancelled: they end where no more lines come."""


def method(name: str) -> tuple[type, Any]:
    """The parameters of a method, and what is called with them and a `Job`; its room is imported on first use."""
    room, params, run = METHODS[name]
    module = importlib.import_module(f"kinetograph.service.{room}")
    return getattr(module, params), getattr(module, run)
