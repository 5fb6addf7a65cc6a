"""Progress of long work: every function that takes a ``progress`` argument calls it with what is done and the total."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""Called with the units of work done and their total."""
