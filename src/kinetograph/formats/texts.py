"""Small texts that people write: decoded, and checked at the door against the types of their fields."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TypeVar

import msgspec

from kinetograph.errors import FormatError

T = TypeVar("T")


def read_text(path: Path, expected: str) -> str:
    """The text of a file in UTF-8, with or without a byte-order mark, or in UTF-16 with one.

    Parameters
    ----------
    path : Path
    expected : str
        What errors say was expected.

    Returns
    -------
    str

    Raises
    ------
    FormatError
        The file cannot be opened, or is not such a text; with the line.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    coding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        return data.decode(coding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = f"byte 0x{data[error.start]:02x}" if error.start < len(data) else "the end"
        message = f"expected {expected}, found {found}, which is not UTF-8 text; save it as UTF-8"
        raise FormatError(path, message, line=line) from None


def read_json(path: Path, kind: type[T], expected: str) -> T:
    """What is in a JSON file, as fields of the types that they must have.

    Parameters
    ----------
    path : Path
    kind : type
        A `msgspec.Struct`.
    expected : str
        What errors say was expected.

    Returns
    -------
    msgspec.Struct

    Raises
    ------
    FormatError
        The file cannot be opened, is not JSON, or has other fields.
    """
    text = read_text(path, expected)
    try:
        return msgspec.json.decode(text.encode(), type=kind)
    except (msgspec.DecodeError, RecursionError, ValueError) as error:
        raise FormatError(path, f"expected {expected}, found: {_short(error)}") from None


def read_toml(path: Path, kind: type[T], expected: str) -> T:
    """What is in a TOML file, as fields of the types that they must have; see `read_json`."""
    text = read_text(path, expected)
    try:
        return msgspec.convert(tomllib.loads(text), kind)
    except tomllib.TOMLDecodeError as error:
        raise FormatError(path, f"expected TOML: {_short(error)}") from None
    except (msgspec.ValidationError, RecursionError, ValueError) as error:
        raise FormatError(path, f"expected {expected}, found: {_short(error)}") from None


def _short(error: BaseException) -> str:
    """An error's text, of which a file may have written some."""
    if isinstance(error, RecursionError):
        return "brackets in brackets without end"
    text = str(error)
    return text if len(text) <= 200 else text[:197] + "..."
