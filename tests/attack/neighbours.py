"""Modules of other tests that the attack uses: they lie in folders that are no packages."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

_TESTS = Path(__file__).parent.parent


def _from(folder: str, name: str) -> Any:
    path = str(_TESTS / folder)
    if path not in sys.path:
        sys.path.append(path)
    return importlib.import_module(name)


def crash() -> Any:
    """How writers are killed, and what a library then should hold."""
    return _from("library", "test_crash")


def mutations() -> Any:
    """How files are damaged."""
    return _from("formats", "mutations")


def walkers() -> Any:
    """A figure that walks."""
    return _from("", "walkers")
