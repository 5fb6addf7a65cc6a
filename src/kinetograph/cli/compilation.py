"""What is said before the search is compiled, which numba does once for every installation."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import kinetograph
from kinetograph.cli.output import note


@contextmanager
def compilation_announced() -> Iterator[None]:
    """Say that the search is about to be compiled, where no command of this installation has finished one.

    Notes
    -----
    numba keeps what it compiles next to the package's source, for one version of Python and of itself. So a file of our
    own in the user's cache, named after these, is left after the first search. Where it cannot be written, the
    announcement is repeated.
    """
    mark = compiled_mark()
    if mark.exists():
        yield
        return
    note("compiling the search for this processor, once (a few seconds)")
    yield
    with suppress(OSError):
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.touch()


def compiled_mark() -> Path:
    """The file that says that this installation's search is compiled."""
    import hashlib
    from importlib.metadata import version

    import platformdirs

    source = hashlib.sha256(str(Path(kinetograph.__file__).parent).encode()).hexdigest()[:8]
    parts = (kinetograph.__version__, f"numba{version('numba')}", str(sys.implementation.cache_tag), source)
    return Path(platformdirs.user_cache_dir("kinetograph")) / "compiled" / "-".join(parts)
