"""What work reads must be seen where it is done, which may be another machine."""

from __future__ import annotations

import os
import platform
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from kinetograph.errors import WorkError


def require_seen(*paths: Path) -> None:
    """Raise WorkError for a folder that is not there, with what it is missing on: for the start of work on it."""
    for path in paths:
        if not path.exists():
            raise WorkError(
                f"{path}: the worker {_here()} does not see it; mount it there under this path, "
                "or stop that worker, and give the same command again"
            )


def _here() -> str:
    """This process as people find it: its address where it works for a cluster, and its machine."""
    name = f"process {os.getpid()}"
    if "distributed" in sys.modules:
        import distributed

        module: Any = distributed  # which has no types
        with suppress(ValueError):  # of a process that works for no cluster
            name = str(module.get_worker().address)
    return f"{name} on {platform.node()}"
