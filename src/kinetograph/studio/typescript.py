"""The types of the page, generated from the messages: ``python -m kinetograph.studio.typescript``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, get_args

import msgspec
from msgspec import inspect

from kinetograph.formats.keys_json import PartRow
from kinetograph.studio import messages, project

DECLARATIONS = Path(__file__).parent / "client" / "messages.d.ts"
"""The file that is generated."""

_PLAIN = {
    inspect.IntType: "number",
    inspect.FloatType: "number",
    inspect.StrType: "string",
    inspect.BoolType: "boolean",
    inspect.NoneType: "null",
    inspect.AnyType: "any",
}


def declarations() -> str:
    """The types of every message and of the project, in the order in which they are defined.

    Returns
    -------
    str
    """
    kinds = [*_of_requests(), *_structs(project), *_structs(messages)]
    said = [kind.__name__ for kind in kinds if issubclass(kind, messages.Message) and kind is not messages.Message]
    union = "\n  | ".join(said)
    parts = [
        "// Generated from the Python classes by: python -m kinetograph.studio.typescript",
        "// Fields with a question mark have a default there, and may be left out.",
        f"/** The sections of a project. */\nexport type Mode = {_literals(project.Mode)};",
        *(_interface(kind) for kind in kinds if kind is not messages.Message),
        f"export type AnyMessage =\n  | {union};",
    ]
    return "\n\n".join(parts) + "\n"


def _structs(module: Any) -> list[type[msgspec.Struct]]:
    return [
        each
        for name, each in vars(module).items()
        if isinstance(each, type)
        and issubclass(each, msgspec.Struct)
        and each.__module__.startswith(module.__name__)
        and not name.startswith("_")
    ]


def _of_requests() -> list[type[msgspec.Struct]]:
    """The rows of requests that a project has."""
    return [PartRow, *(each for each in vars(project).values() if isinstance(each, type) and _requested(each))]


def _requested(kind: type) -> bool:
    return issubclass(kind, msgspec.Struct) and kind.__module__.startswith("kinetograph.formats")


def _named(kind: type) -> str:
    """The name of a class on the page: rows of requests are told apart from the studio's own."""
    return f"Request{kind.__name__}" if _requested(kind) else kind.__name__


def _interface(kind: type[msgspec.Struct]) -> str:
    info = inspect.type_info(kind)
    assert isinstance(info, inspect.StructType)
    lines = [f"  {info.tag_field}: {_literal(info.tag)};"] if info.tag_field else []
    lines += [f"  {field.encode_name}{'' if field.required else '?'}: {_type(field.type)};" for field in info.fields]
    summary = (kind.__doc__ or "").strip().splitlines()[0]
    return "\n".join([f"/** {summary} */", f"export interface {_named(kind)} {{", *lines, "}"])


def _type(kind: inspect.Type) -> str:
    if type(kind) in _PLAIN:
        return _PLAIN[type(kind)]
    match kind:
        case inspect.LiteralType():
            return " | ".join(_literal(value) for value in kind.values)
        case inspect.UnionType():
            return " | ".join(dict.fromkeys(_type(each) for each in kind.types))
        case inspect.TupleType():
            return f"[{', '.join(_type(each) for each in kind.item_types)}]"
        case inspect.VarTupleType() | inspect.ListType() | inspect.CollectionType():
            inner = _type(kind.item_type)
            return f"({inner})[]" if "|" in inner else f"{inner}[]"
        case inspect.DictType():
            return f"Record<{_type(kind.key_type)}, {_type(kind.value_type)}>"
        case inspect.StructType():
            return _named(kind.cls)
    raise TypeError(f"no type of the page for {kind}")


def _literals(kind: Any) -> str:
    return " | ".join(_literal(value) for value in get_args(kind))


def _literal(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


if __name__ == "__main__":
    DECLARATIONS.write_text(declarations(), encoding="utf-8")
    sys.stdout.write(f"wrote {DECLARATIONS}\n")
