"""A plugin of pytest that writes which functions of the package each test calls, and how long it takes."""

from __future__ import annotations

import json
import os
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

_called: dict[str, set[str]] = defaultdict(set)
_seconds: dict[str, float] = defaultdict(float)
_known: dict[Any, str | None] = {}
_running: list[str] = [""]


def _name(code: Any) -> str | None:
    if code not in _known:
        path = code.co_filename
        inside = "/src/kinetograph/" in path and not code.co_name.startswith("<")
        _known[code] = f"{path.rpartition('/src/')[2]}:{code.co_name}:{code.co_firstlineno}" if inside else None
    return _known[code]


def _profile(frame: FrameType, event: str, argument: object) -> None:
    if event == "call" and (name := _name(frame.f_code)):
        _called[_running[0]].add(name)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Profile a test, with its fixtures."""
    _running[0] = test = item.nodeid.partition("[")[0]
    began = time.perf_counter()
    sys.setprofile(_profile)
    try:
        return (yield)
    finally:
        sys.setprofile(None)
        _seconds[test] += time.perf_counter() - began


def pytest_sessionfinish() -> None:
    """Write what was seen to the file that the environment names."""
    rows = {test: {"seconds": _seconds[test], "calls": sorted(_called[test])} for test in _seconds}
    Path(os.environ["KINETOGRAPH_CALLS"]).write_text(json.dumps(rows))
