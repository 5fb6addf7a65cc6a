"""What a page is sent where something fails."""

from __future__ import annotations

import sys
import traceback

from kinetograph.errors import KinetographError
from kinetograph.studio.messages import Failed
from kinetograph.studio.project import Mode


def failure(error: Exception, number: int | None = None, section: Mode | None = None) -> Failed:
    """An error in one line. One that is a fault of the program, after which it goes on, is printed as well.

    Parameters
    ----------
    error : Exception
    number : int, optional
        Of the question that it answers.
    section : str, optional
        What could not be made.
    """
    if isinstance(error, KinetographError):
        return Failed(" ".join(str(error).split()), number, section)
    traceback.print_exception(error, file=sys.stderr)
    return Failed(f"a fault of the program: {type(error).__name__}: {error}", number, section)
