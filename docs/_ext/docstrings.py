"""Check the docstrings of all public names by numpydoc's own rules: ``python docs/_ext/docstrings.py``.

A public name is what `doors.py` says, and the public methods and properties of its classes. The rules are few:

- GL08, SS01, SS03, SS06: there is a docstring, and it begins with a summary of one line that ends with a full stop;
- GL06, GL07: sections have numpydoc's names, in numpydoc's order;
- PR01, PR02, PR03, PR10: the parameters are those of the signature, in its order. A docstring of one line, and one
  whose function has one or two parameters, may do without a list of them. A dataclass lists the fields that it adds.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from collections.abc import Iterator
from typing import Any

from numpydoc.validate import validate

import doors

CHECKS = ("GL06", "GL07", "GL08", "PR01", "PR02", "PR03", "PR10", "SS01", "SS03", "SS06")


def main() -> None:
    """Print a line per failure; exit status 1 where there is one."""
    failures = [failure for path, value in every_public() for failure in failures_of(path, value)]
    for failure in failures:
        print(failure)
    print(f"{len(failures)} failures in {sum(1 for _ in every_public())} public docstrings")
    sys.exit(1 if failures else 0)


def every_public() -> Iterator[tuple[str, Any]]:
    """Paths and objects: public classes and functions, and what is public in the classes."""
    for names in doors.documented().values():
        for public in names:
            if public.kind == "data":
                continue
            yield public.path, public.value
            if inspect.isclass(public.value):
                yield from _members(public.path, public.value)


def _members(path: str, cls: type) -> Iterator[tuple[str, Any]]:
    """Methods and properties that a class itself defines."""
    for name, value in vars(cls).items():
        code = inspect.isroutine(value) or isinstance(value, property | classmethod | staticmethod)
        if not name.startswith("_") and (code or type(value).__name__ == "cached_property"):
            yield f"{path}.{name}", getattr(cls, name) if inspect.isroutine(value) else value


def failures_of(path: str, value: Any) -> list[str]:
    """A line for each rule that a docstring breaks."""
    text = getattr(value, "__doc__", None) or ""
    errors = [(code, message) for code, message in validate(path)["errors"] if code in CHECKS]
    return [f"{path}: {code} {message}" for code, message in errors if not _excused(code, message, value, text)]


def _excused(code: str, message: str, value: Any, text: str) -> bool:
    """Whether a failure is within the house's rules: private or inherited fields, short docstrings without a list."""
    if code != "PR01":
        return False
    missing = {name for name in re.findall(r"'([^']+)'", message) if not name.startswith("_")}
    if dataclasses.is_dataclass(value):
        return missing <= _inherited(value)
    if "----------" in text:
        return not missing
    return len(text.strip().splitlines()) == 1 or len(missing) <= 2


def _inherited(cls: Any) -> set[str]:
    """The fields of the dataclasses that a class is derived from."""
    bases = [base for base in cls.__mro__[1:] if dataclasses.is_dataclass(base)]
    return {field.name for base in bases for field in dataclasses.fields(base)}


if __name__ == "__main__":
    main()
