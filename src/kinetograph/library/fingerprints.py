"""Digests that say whether what was made once still holds: of a configuration, of takes, and of the code."""

from __future__ import annotations

import functools
import hashlib
import platform
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph.library import catalogue
from kinetograph.library.shards import Shards
from kinetograph.library.store import Library

_ELSEWHERE = ("cli", "studio", "live", "drawing", "evaluation", "samples")
"""Packages that nothing which is kept is made by."""


def state(configuration: object) -> str:
    """A configuration as text, the same in every process. Raises TypeError for what has no such text.

    >>> state({"rate": 30.0, "names": ("a", "b"), "kinds": frozenset({"y", "x"})})
    "{'rate': 30.0, 'names': ('a', 'b'), 'kinds': {'x', 'y'}}"
    """
    return _state(configuration, False)


def summarize(configuration: object) -> str:
    """What of a configuration is not as by default, as text for people.

    >>> summarize(("timed", True, ()))
    "('timed', True, ())"
    """
    return _state(configuration, True)


def _state(value: Any, short: bool) -> str:
    if value is None or isinstance(value, str | bool | int | float | complex | Path):
        return repr(value.item() if isinstance(value, np.generic) else value)
    if is_dataclass(value) and not isinstance(value, type):
        return _state_fields(value, short)
    if isinstance(value, tuple | list):
        inside = ", ".join(_state(item, short) for item in value)
        return f"({inside})" if isinstance(value, tuple) else f"[{inside}]"
    if isinstance(value, set | frozenset):
        return f"{{{', '.join(sorted(_state(item, short) for item in value))}}}"
    if isinstance(value, Mapping):  # the order counts: roles, for one, are compared in it
        return f"{{{', '.join(f'{_state(k, short)}: {_state(v, short)}' for k, v in value.items())}}}"
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufcU":
        return f"array({value.dtype.str}, {value.shape}, {digest(np.ascontiguousarray(value).tobytes())})"
    if isinstance(value, np.generic):
        return repr(value.item())
    if isinstance(value, np.random.Generator):
        return _state(value.bit_generator.state, short)
    if isinstance(value, type):
        return f"{value.__module__}.{value.__qualname__}"
    raise TypeError(f"a {type(value).__qualname__} in a configuration has no text that is the same in every process")


def _state_fields(value: Any, short: bool) -> str:
    texts = [(one, _state(getattr(value, one.name), short)) for one in fields(value)]
    inside = ", ".join(f"{one.name}={text}" for one, text in texts if not (short and text == _default(one)))
    kind = type(value)
    return f"{kind.__qualname__ if short else f'{kind.__module__}.{kind.__qualname__}'}({inside})"


def _default(one: Field[Any]) -> str | None:
    """The text of a field's default; None where it has none."""
    if one.default is not MISSING:
        return _state(one.default, True)
    return None if one.default_factory is MISSING else _state(one.default_factory(), True)


def digest(*parts: str | bytes) -> str:
    """A digest of texts and bytes, 32 hexadecimal digits."""
    whole = hashlib.blake2b(digest_size=16)
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        whole.update(len(data).to_bytes(8, "little") + data)
    return whole.hexdigest()


def of_takes(library: Library) -> str:
    """The digest of the chosen takes in their order: frames, annotations and facts, by the catalogue's own digests."""
    names = library.names()
    if isinstance(library, Shards):
        parts = zip(library.libraries, library.parts, strict=True)
        rows = {here[own]: row for one, here in parts for own, row in _digests(one).items() if own in here}
    else:
        rows = _digests(library)
    return digest(*(text for name in names for text in (name, *map(str, rows.get(name, ("", ""))))))


def _digests(library: Library) -> dict[str, tuple[str, str]]:
    """Of every take of one library the digests of its frames and of what is noted of it."""
    with catalogue.reading(library.path) as db:
        return {row[0]: row[1:] for row in db.execute("SELECT name, digest, notes FROM takes")}


@functools.cache
def of_code() -> str:
    """The digest of what makes things: the source of the package, NumPy's version and the machine it runs on.

    Source and not only the version, so that a developer never gets what the code made before an edit.
    """
    folder = Path(__file__).parents[1]
    files = sorted(path for path in folder.rglob("*.py") if path.relative_to(folder).parts[0] not in _ELSEWHERE)
    sources = [part for path in files for part in (str(path.relative_to(folder)), path.read_bytes())]
    return digest(np.__version__, platform.machine(), *sources)
