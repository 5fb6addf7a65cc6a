"""The objects of an FBX document, their properties, and the connections between them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from kinetograph.formats.fbx.nodes import Node

Properties = dict[str, list[Any]]
Link = tuple[int, str]
"""The other end of a connection, and the property that it goes to, empty where it goes to the object."""


class Objects:
    """Objects by id, and what is connected to what.

    Parameters
    ----------
    root : Node
        The document, as in version 7.
    """

    def __init__(self, root: Node) -> None:
        objects, connections = root.child("Objects"), root.child("Connections")
        self.nodes = {node.values[0]: node for node in objects.children if _is_object(node)} if objects else {}
        self.above: dict[int, list[Link]] = {}
        self.below: dict[int, list[Link]] = {}
        for node in connections.children if connections else ():
            row = node.values
            if node.name in ("C", "Connect") and len(row) >= 3 and isinstance(row[1], int) and isinstance(row[2], int):
                key = str(row[3]) if len(row) > 3 else ""
                self.above.setdefault(row[1], []).append((row[2], key))
                self.below.setdefault(row[2], []).append((row[1], key))

    def all(self, kind: str) -> list[int]:
        """The ids of the objects of a kind, in the order of the file."""
        return [key for key, node in self.nodes.items() if node.name == kind]

    def name(self, key: int) -> str:
        """The name of an object, without its kind."""
        name = str(self.nodes[key].values[1])
        return name.partition("\x00")[0] if "\x00" in name else name.partition("::")[2] if "::" in name else name

    def properties(self, key: int) -> Properties:
        """The properties that an object itself gives."""
        return properties(self.nodes.get(key))

    def under(self, key: int, kind: str) -> Iterator[Link]:
        """The objects of a kind that are connected to an object, in the order of the connections."""
        return ((child, to) for child, to in self.below.get(key, ()) if self.is_a(child, kind))

    def is_a(self, key: int, kind: str) -> bool:
        """Whether there is an object of that id and kind."""
        return key in self.nodes and self.nodes[key].name == kind


def properties(node: Node | None) -> Properties:
    """The values of a node's table of properties, by their names."""
    table = node.child("Properties70") if node else None
    rows = (row.values for row in table.children if row.name == "P" and len(row.values) > 4) if table else ()
    return {str(row[0]): row[4:] for row in rows}


def number(values: Properties, key: str, default: float) -> float:
    """A property of one number, or else ``default``."""
    found = (values.get(key) or [default])[0]
    return float(found) if isinstance(found, int | float) and abs(found) < 1e15 else default


def _is_object(node: Node) -> bool:
    kinds = [type(value) for value in node.values[:3]]
    return kinds == [int, str, str]
