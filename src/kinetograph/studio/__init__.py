"""The studio: a page on this machine, where a person draws paths, sets keys, chooses leaders and puts sensors on.

`read_project` opens what a person asked for; a `Desk` holds it, and `serve_studio` serves its page. The page's source
is in ``client``; it holds no algorithm. Rooms are imported on first use, so that a command loads what it needs.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

_ROOMS = {
    "Desk": "desk.desk",
    "Project": "project",
    "Sensors": "project",
    "Taken": "requests",
    "StudioSink": "serving.live_sink",
    "begin": "desk.beginning",
    "player_page": "sharing",
    "read_project": "project",
    "serve_studio": "serving.server",
    "request_of": "requests",
    "with_libraries": "desk.beginning",
    "with_request": "requests",
    "write_project": "project",
}

__all__ = [
    "Desk",
    "Project",
    "Sensors",
    "StudioSink",
    "Taken",
    "begin",
    "player_page",
    "read_project",
    "request_of",
    "serve_studio",
    "with_libraries",
    "with_request",
    "write_project",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'kinetograph.studio' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.studio.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.studio.desk.beginning import begin, with_libraries
    from kinetograph.studio.desk.desk import Desk
    from kinetograph.studio.project import Project, Sensors, read_project, write_project
    from kinetograph.studio.requests import Taken, request_of, with_request
    from kinetograph.studio.serving.live_sink import StudioSink
    from kinetograph.studio.serving.server import serve_studio
    from kinetograph.studio.sharing import player_page
