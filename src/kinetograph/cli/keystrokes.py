"""Keys pressed in a terminal, and when."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from kinetograph.errors import RequestError

BOUNCE = 0.05  # seconds; taps closer than this are one
_ESCAPE, _BACK, _END = 0x1B, b"\x7f\x08", b"\r\nq"

Draw = Callable[[float, int], None]
Wait = Callable[[int, float], bool]


@contextmanager
def single_keys(file: int) -> Iterator[None]:
    """Have a terminal send every key at once and show none; afterwards it is as before.

    Raises
    ------
    RequestError
        For a file that is no terminal.
    """
    if not os.isatty(file):
        raise RequestError("tapping needs a terminal to press keys in; give the times in a file instead (--from CSV)")
    try:
        import termios
        import tty
    except ImportError:
        message = "tapping does not work in this system's terminals; give the times in a file (--from CSV)"
        raise RequestError(message) from None
    before = termios.tcgetattr(file)
    try:
        tty.setcbreak(file)
        termios.tcflush(file, termios.TCIFLUSH)
        yield
    finally:
        with suppress(termios.error):  # it may be gone
            termios.tcsetattr(file, termios.TCSADRAIN, before)


def pressed(file: int, seconds: float) -> bool:
    """Whether a key is pressed within ``seconds``; returns as soon as one is."""
    return bool(select.select([file], [], [], max(seconds, 0.0))[0])


def taps(
    file: int,
    duration: float,
    draw: Draw,
    *,
    rate: float = 15.0,
    clock: Callable[[], float] = time.monotonic,
    wait: Wait = pressed,
) -> list[float]:
    """Seconds from now at which keys are pressed, for ``duration`` seconds or until Enter or q.

    Backspace removes the last one; keys that send several characters at once (arrows) are ignored.

    Parameters
    ----------
    file : int
        The terminal's descriptor.
    duration : float
        Seconds.
    draw : callable
        Called with the time and the number of taps.
    rate : float
        Calls of ``draw`` per second.
    clock : callable
        The time in seconds.
    wait : callable
        Waits for a key of a file for some seconds; whether there is one.

    Raises
    ------
    RequestError
        Where the terminal goes away.
    """
    began, times, ended = clock(), list[float](), False
    while not ended and (now := clock() - began) < duration:
        draw(now, len(times))
        if wait(file, min(1.0 / rate, duration - now)):
            times, ended = _pressed(times, clock() - began, _read(file))
    return times


def _pressed(times: list[float], now: float, keys: bytes) -> tuple[list[float], bool]:
    """The taps after some keys, and whether these end the tapping."""
    if keys[0] == _ESCAPE:
        return times, False
    for key in keys:
        if key in _END:
            return times, True
        if key in _BACK:
            times = times[:-1]
        elif not times or now - times[-1] >= BOUNCE:
            times = [*times, now]
    return times, False


def _read(file: int) -> bytes:
    try:
        keys = os.read(file, 64)
    except OSError:
        keys = b""
    if not keys:
        raise RequestError("the terminal went away while a take was tapped; nothing was written")
    return keys
