"""Progress of long work: every function that takes a ``progress`` argument calls it with what is done and the total.

Work that says in words what it has done or lacks takes a ``report`` argument, which is called with one line at a time.
"""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""Called with the units of work done and their total."""

Report = Callable[[str], None]
"""Called with a line of text."""
