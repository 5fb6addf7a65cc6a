"""Outputs that appear whole or not at all, also several together."""

from __future__ import annotations

import os
import secrets
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from kinetograph.errors import ExistsError, RequestError

_Waiting = list[tuple[Path, Path, int]]  # drafts, what they replace, and the drafts' open descriptors
_waiting: ContextVar[_Waiting | None] = ContextVar("_waiting", default=None)


@contextmanager
def together() -> Iterator[None]:
    """Outputs that are written within the block appear when it ends, all at once; after an error none does."""
    if _waiting.get() is not None:
        yield
        return
    waiting: _Waiting = []
    token = _waiting.set(waiting)
    try:
        yield
        with _unbroken():
            for draft, path, _ in waiting:
                os.replace(draft, path)
    finally:
        _waiting.reset(token)
        for draft, _, descriptor in waiting:
            os.close(descriptor)
            with suppress(FileNotFoundError):
                draft.unlink()


@contextmanager
def atomic_path(path: str | Path, *, force: bool = True) -> Iterator[Path]:
    """Give a temporary file in the folder of ``path``, which replaces ``path`` when the block ends without an error.

    The file is created on entry and removed after an error, which leaves ``path`` as it was. One that a process left
    behind that was killed while it wrote the same output is removed as well.

    Parameters
    ----------
    path : str or Path
        The file to write.
    force : bool
        Overwrite a file that exists.

    Yields
    ------
    Path
        The temporary file, with the same suffix.

    Raises
    ------
    RequestError
        The path exists and ``force`` is false, it is a folder, or its folder cannot be written to.
    """
    path = Path(path)
    if path.is_dir():
        raise RequestError(f"{path}: expected the name of a file, found a folder")
    if not force and path.exists():
        raise ExistsError(f"{path}: exists already; overwrite it with --force or choose another name")
    stem, waiting = f".{path.stem[:80]}.", _waiting.get()
    draft = path.with_name(f"{stem}{secrets.token_hex(6)}{path.suffix}")
    kept, descriptor = False, -1
    try:
        try:
            # not tempfile: its files can be read by their owner only
            descriptor = os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        except OSError as error:
            raise RequestError(f"{path}: cannot write here: {error.strerror}") from None
        _hold(descriptor)
        _remove_stale(path, stem, draft)
        yield draft
        with suppress(FileNotFoundError):
            draft.chmod(path.stat().st_mode & 0o777)
        if waiting is None:
            os.replace(draft, path)
        else:
            waiting.append((draft, path, descriptor))
            kept = True
    finally:
        if not kept:
            if descriptor >= 0:
                os.close(descriptor)
            with suppress(FileNotFoundError):
                draft.unlink()


@contextmanager
def _unbroken() -> Iterator[None]:
    """Interrupts wait until the block ends."""
    if threading.current_thread() is not threading.main_thread():  # only the main thread is interrupted
        yield
        return
    received: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, lambda number, _: received.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        if received:
            signal.raise_signal(received[0])


def _hold(descriptor: int) -> bool:
    """Lock a draft for as long as it is open; False where another process has it, or files cannot be locked."""
    try:
        import fcntl
    except ImportError:  # not on Windows
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _remove_stale(path: Path, stem: str, own: Path) -> None:
    """Remove drafts of an output that no process has open."""
    for name in os.listdir(path.parent):
        middle = name.removeprefix(stem).removesuffix(path.suffix)
        if not name.startswith(stem) or len(middle) != 12 or set(middle) - set("0123456789abcdef") or name == own.name:
            continue
        with suppress(OSError):
            descriptor = os.open(path.with_name(name), os.O_RDONLY)
            try:
                if _hold(descriptor):
                    path.with_name(name).unlink()
            finally:
                os.close(descriptor)
