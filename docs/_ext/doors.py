"""What is public: the names that the package's doors show, and those of its top-level modules.

A door is a package whose ``__init__`` has ``__all__``. Everything that is made of the public names (the API reference,
the check of docstrings) asks here, so that it follows the code.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
from dataclasses import dataclass
from typing import Any

ROOT = "kinetograph"
_LEFT_OUT = ("cli", "__main__")
"""Top-level names that are no API: the command line has a reference of its own."""


@dataclass(frozen=True)
class Public:
    """One public name.

    Parameters
    ----------
    module : str
        The door or module that shows it.
    name : str
        Its name there.
    home : str
        The module that defines it.
    value : object
        What it is.
    """

    module: str
    name: str
    home: str
    value: Any

    @property
    def path(self) -> str:
        """The full dotted path by which the reference calls it."""
        return f"{self.module}.{self.name}"

    @property
    def kind(self) -> str:
        """``class``, ``exception``, ``function`` or ``data``."""
        if inspect.isclass(self.value):
            return "exception" if issubclass(self.value, BaseException) else "class"
        return "function" if inspect.isroutine(self.value) else "data"


def public_names() -> dict[str, list[Public]]:
    """The public names by door or module, the root first; a name that several doors show is in each of them."""
    found = {module: _names(module) for module in _modules()}
    return {module: names for module, names in found.items() if names or module == ROOT}


def documented() -> dict[str, list[Public]]:
    """The same with every object once: at the door that is nearest to where it is defined; not at the root."""
    every = [public for module, names in public_names().items() if module != ROOT for public in names]
    chosen: dict[int | tuple[str, str], Public] = {}
    for public in every:
        key = _identity(public)
        if key not in chosen or _nearness(public) > _nearness(chosen[key]):
            chosen[key] = public
    out: dict[str, list[Public]] = {}
    for public in every:
        if chosen[_identity(public)] is public:
            out.setdefault(public.module, []).append(public)
    return out


def _identity(public: Public) -> tuple[str, str]:
    defined = getattr(public.value, "__qualname__", public.name) if public.kind != "data" else public.name
    return public.home, defined


def _nearness(public: Public) -> tuple[int, int]:
    """How much of the path to its home a door shares, then the shorter path."""
    shared = 0
    for a, b in zip(public.module.split("."), public.home.split("."), strict=False):
        if a != b:
            break
        shared += 1
    return shared, -len(public.module)


def _modules() -> list[str]:
    """Every door, and every module directly in the package."""
    root = importlib.import_module(ROOT)
    found = [ROOT]
    for info in pkgutil.walk_packages(root.__path__, f"{ROOT}."):
        top, *inner = info.name.split(".")[1:]
        private = any(part.startswith("_") for part in (top, *inner)) or info.name.endswith("kernels")
        if private or top in _LEFT_OUT:
            continue
        if (info.ispkg and hasattr(importlib.import_module(info.name), "__all__")) or not (info.ispkg or inner):
            found.append(info.name)
    return found


def _names(module: str) -> list[Public]:
    loaded = importlib.import_module(module)
    imported = _imports(loaded)
    listed = getattr(loaded, "__all__", None)
    names = listed if listed is not None else [n for n in _assigned(loaded) if not n.startswith("_")]
    out = []
    for name in names:
        if name.startswith("_"):
            continue
        value = getattr(loaded, name)
        is_code = inspect.isclass(value) or inspect.isroutine(value)
        home = value.__module__ if is_code else imported.get(name, module)
        out.append(Public(module, name, home, value))
    return out


def _assigned(module: Any) -> list[str]:
    """The names that a module itself defines, in the order of its source."""
    names: list[str] = []
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.append(node.name)
        elif isinstance(node, ast.Assign):
            names += [target.id for target in node.targets if isinstance(target, ast.Name)]
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            names.append(node.target.id)
    return names


def _imports(module: Any) -> dict[str, str]:
    """Where a door takes names from, imports under ``TYPE_CHECKING`` included."""
    nodes = ast.walk(ast.parse(inspect.getsource(module)))
    found = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module and not node.level]
    return {alias.asname or alias.name: str(node.module) for node in found for alias in node.names}
