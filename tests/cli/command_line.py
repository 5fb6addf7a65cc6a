"""Commands as a person gives them: in a process of their own, or within this one, which is quicker."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from typer.testing import CliRunner, Result

from kinetograph.cli import app
from kinetograph.errors import KinetographError


def run(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own, without a terminal."""
    command = [sys.executable, "-m", "kinetograph", *map(str, arguments)]
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, cwd=cwd)


def invoke(*arguments: object) -> Result:
    """A command within this process; the library's errors are in the result's ``exception``."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, KinetographError | SystemExit):
        raise result.exception
    return result


def answer(*arguments: object) -> Result:
    """A command within this process that succeeds; the library's errors are raised."""
    result = invoke(*arguments)
    if isinstance(result.exception, KinetographError):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result
