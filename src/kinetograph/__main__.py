"""The command ``kinetograph`` and ``python -m kinetograph``: interrupts are met before anything large is imported."""

from __future__ import annotations

import gc
import os
import signal
import sys
from types import FrameType

_received = [signal.SIGINT]
_OBJECTS = 50_000
"""Objects that are made between two looks for garbage: by default these take a tenth of a short command's time."""


def main() -> None:
    """Run the command line. SIGTERM is met as Ctrl-C is: outputs are whole or not there, and the status says which."""
    signal.signal(signal.SIGTERM, _interrupt)
    gc.set_threshold(_OBJECTS)
    if sys.stdout is None:  # closed by the shell: the first file that is opened would take its place
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    try:
        from kinetograph.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.exit(128 + _received[-1])
    except SystemExit as end:
        if end.code == 128 + signal.SIGINT:
            sys.exit(128 + _received[-1])
        raise


def _interrupt(number: int, frame: FrameType | None) -> None:
    _received.append(signal.Signals(number))
    raise KeyboardInterrupt


if __name__ == "__main__":
    main()
