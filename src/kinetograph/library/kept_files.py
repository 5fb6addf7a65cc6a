"""Files of packed values: a header, what the file is about, the arrays, and the columns that they are part of.

A file counts only where it is the very one that this user wrote on this machine: the header has a code, made with a key
in the user's own folder, of the columns and of the file's number, size and time of change. A file that was brought from
elsewhere, or that anything has written to since, is no longer it, and is made anew. So nothing has to be read to trust
the arrays, whose numbers compiled kernels use as places in memory.
"""

from __future__ import annotations

import fcntl
import hashlib
import hmac
import mmap
import os
import secrets
import struct
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import msgspec
import numpy as np
import platformdirs

from kinetograph.library.packing import Array, Packed, UnreadableError, unpack

SUFFIX, DRAFT = ".kept", ".draft"
ALIGNMENT = 64
_MAGIC = b"kinetograph-kept"
_VERSION = 1
_HEADER = struct.Struct("<16sIIQQQ32s")
"""Magic, version, bytes of what the file is about, place and bytes of the columns, time of change, code."""
_TICK = 2_000_000_000
"""Nanoseconds to whose multiples times of change are set, which every file system keeps."""


@dataclass(frozen=True)
class About:
    """What a file is about.

    Parameters
    ----------
    name : str
        Of what was made.
    configuration : str
        Of what made it, as text for people.
    subject : str
        A digest of name, configuration and choice of takes.
    content : str
        A digest of the takes.
    code : str
        A digest of what made it.
    """

    name: str
    configuration: str
    subject: str
    content: str
    code: str


def user_key() -> bytes | None:
    """A number that only this user knows, made on first use; None where the user's folder cannot be written."""
    path = Path(platformdirs.user_data_dir("kinetograph")) / "keeping.key"
    try:
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            draft = path.with_name(f".{secrets.token_hex(6)}{DRAFT}")
            draft.touch(mode=0o600)
            draft.write_bytes(secrets.token_bytes(32))
            with suppress(FileExistsError):
                os.link(draft, path)  # another process may have been first
            draft.unlink()
        key = path.read_bytes()
    except OSError:
        return None
    return key if len(key) == 32 else None


def write(path: Path, about: About, packed: Packed, key: bytes) -> None:
    """Write a file, which appears whole or not at all. Raises OSError."""
    draft = path.with_name(f".{secrets.token_hex(6)}{DRAFT}")
    try:
        with draft.open("xb") as file:
            fcntl.flock(file, fcntl.LOCK_EX)  # see `abandoned`
            _fill(file, about, packed, key)
            draft.rename(path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def _fill(file: IO[bytes], about: About, packed: Packed, key: bytes) -> None:
    head = msgspec.json.encode(about)
    file.write(bytes(_HEADER.size) + head)
    table = [_write_parts(file, kind, parts) for kind, parts in packed.arrays]
    columns = msgspec.json.encode([packed.nodes, table])
    place = file.tell()
    file.write(columns)
    stamp = time.time_ns() // _TICK * _TICK
    parts = (_MAGIC, _VERSION, len(head), place, len(columns), stamp)
    code = _code(key, os.fstat(file.fileno()).st_ino, _HEADER.pack(*parts, bytes(32)), head, columns)
    file.seek(0)
    file.write(_HEADER.pack(*parts, code))
    file.flush()
    os.fsync(file.fileno())
    os.utime(file.fileno(), ns=(time.time_ns(), stamp))


def _write_parts(file: IO[bytes], kind: str, parts: list[Array]) -> tuple[str, int, int]:
    """Write the parts of an array end to end: its type, its place, and the number of values."""
    file.write(bytes(-file.tell() % ALIGNMENT))
    place, count = file.tell(), 0
    for part in parts:
        whole = np.ascontiguousarray(part, dtype=kind)
        file.write(whole.reshape(-1).view(np.uint8).data)
        count += whole.size
    return kind, place, count


def _code(key: bytes, number: int, *parts: bytes) -> bytes:
    made = hashlib.blake2b(number.to_bytes(8, "little"), key=key, digest_size=32)
    for part in parts:
        made.update(part)
    return made.digest()


def read(path: Path, key: bytes) -> Any:
    """The value in a file, its arrays by memory map; writing to them changes this process's copy only.

    Raises
    ------
    OSError
        There is no such file.
    UnreadableError
        It is not one that this user wrote here, or it has changed since.
    """
    with path.open("rb") as file:
        state = os.fstat(file.fileno())
        header, head = _heads(file)
        _, _, _, place, size, stamp, code = header
        if stamp != state.st_mtime_ns or place + size != state.st_size:
            raise UnreadableError(f"{path}: has changed since it was written")
        file.seek(place)
        columns = file.read(size)
        expected = _code(key, state.st_ino, _HEADER.pack(*header[:-1], bytes(32)), head, columns)
        if not hmac.compare_digest(code, expected):
            raise UnreadableError(f"{path}: was not written here by this user")
        mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)
    try:
        nodes, table = msgspec.json.decode(columns)
        arrays = [np.frombuffer(mapped, kind, count, offset) for kind, offset, count in table]
    except (msgspec.DecodeError, TypeError, ValueError) as error:
        raise UnreadableError(f"{path}: {error}") from error
    return unpack(nodes, arrays)


def _heads(file: IO[bytes]) -> tuple[tuple[Any, ...], bytes]:
    """The header, and the text of what the file is about. Raises UnreadableError."""
    first = file.read(_HEADER.size)
    header = _HEADER.unpack(first) if len(first) == _HEADER.size else (b"",)
    if header[0] != _MAGIC or header[1] != _VERSION:
        raise UnreadableError("not a file of packed values, or one of another version")
    return header, file.read(header[2])


def about(path: Path) -> About | None:
    """What a file says that it is about; None where it cannot be read."""
    try:
        with open(path, "rb", opener=_unnoted) as file:
            return msgspec.json.decode(_heads(file)[1], type=About)
    except (OSError, UnreadableError, msgspec.MsgspecError, UnicodeDecodeError):
        return None


def _unnoted(path: str, flags: int) -> int:
    """Open a file so that its time of use stays, where the system lets this user."""
    try:
        return os.open(path, flags | os.O_NOATIME)
    except PermissionError:
        return os.open(path, flags)


def touch(path: Path) -> None:
    """Note that a file has been read; its time of change stays."""
    with suppress(OSError):
        os.utime(path, ns=(time.time_ns(), path.stat().st_mtime_ns))


def abandoned(folder: Path) -> Iterator[Path]:
    """The drafts in a folder that nobody is writing any more."""
    for path in folder.glob(f".*{DRAFT}"):
        with suppress(OSError), path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield path
