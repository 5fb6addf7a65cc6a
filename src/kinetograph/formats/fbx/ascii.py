"""FBX in text as the same tree of nodes as binary FBX."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from kinetograph.errors import FormatError
from kinetograph.formats.fbx.nodes import DEEPEST, MOST_NODES, Node, Value

_SPACE = re.compile(r"(?:[\s,]+|;[^\n]*)*")
_NAME = re.compile(r"([^\s:\"{},;*]+)[ \t]*:")
_ARRAY = re.compile(r"\*\s*(\d{1,12})\s*\{")
_LETTER = re.compile(r"\s*a\s*:")
_COMMENT = re.compile(r";[^\n]*")
_PLAIN = re.compile(r"[^:{}\";]+")
_LONG = 64  # values without quotes from here on are an array where they are numbers
_FEWEST_NODES, _BYTES_A_NODE = 10_000, 8
_NOT_A_NUMBER = re.compile(r"\d\.#(?:IND|Q?NAN|SNAN)\w*|nan\(\w*\)")


def parse(path: Path, data: bytes) -> Node:
    """The nodes of a file in text, below a node without a name. Raises FormatError."""
    return _Parser(path, data.decode("latin-1")).run()


class _Parser:
    """One pass over the text, with the open nodes on a list."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.text = path, text
        self.room = min(MOST_NODES, _FEWEST_NODES + len(text) // _BYTES_A_NODE)

    def run(self) -> Node:
        stack = [Node("")]
        position = self.skip(0)
        while position < len(self.text):
            if self.text[position] == "}":
                if len(stack) == 1:
                    self.fail(position, "a closing brace too many")
                stack.pop()
                position = self.skip(position + 1)
                continue
            name = _NAME.match(self.text, position)
            if name is None:
                self.fail(position, f"expected a name and a colon, found {self.text[position : position + 20]!r}")
            self.room -= 1
            if self.room < 0 or len(stack) > DEEPEST:
                self.fail(position, "more nodes, or deeper ones, than a file of this size has")
            node = Node(name[1])
            stack[-1].children.append(node)
            position, opened = self.values(node, name.end())
            if opened:
                stack.append(node)
        if len(stack) > 1:
            self.fail(position, f"the file ends inside {stack[-1].name!r}: it is cut short")
        return stack[0]

    def values(self, node: Node, position: int) -> tuple[int, bool]:
        """Read the values of a node: where reading continues, and whether nodes follow inside it."""
        while (position := self.skip(position)) < len(self.text):
            first = self.text[position]
            if first == "{":
                return self.skip(position + 1), True
            if first == "}" or _NAME.match(self.text, position):
                break
            if first == '"':
                stop = self.text.find('"', position + 1)
                if stop < 0:
                    self.fail(position, "a quotation mark without its other")
                string = self.text[position + 1 : stop].encode("latin-1").decode("utf-8", "replace")
                node.values.append(string.replace("&quot;", '"'))
                position = stop + 1
            elif first == "*":
                position = self.array(node, position)
            else:
                position = self.plain(node, position)
        return position, False

    def array(self, node: Node, position: int) -> int:
        """Read an array, ``*3 { a: 1,2,3 }``."""
        head, stop = _ARRAY.match(self.text, position), self.text.find("}", position)
        if head is None or stop < 0:
            self.fail(position, "an array without its numbers")
        text = self.text[head.end() : stop]
        text = _COMMENT.sub("", text) if ";" in text else text
        letter = _LETTER.match(text)
        numbers = _numbers(text[letter.end() if letter else 0 :].strip(" \t\r\n,"))
        if numbers is None or len(numbers) != int(head[1]):
            count = "other things" if numbers is None else len(numbers)
            self.fail(position, f"expected an array of {int(head[1])} numbers, found {count}")
        node.values.append(numbers)
        return stop + 1

    def plain(self, node: Node, position: int) -> int:
        """Read values up to the next name, brace or quotation mark."""
        found = _PLAIN.match(self.text, position)
        if found is None:
            self.fail(position, f"expected a value, found {self.text[position : position + 20]!r}")
        text, stop = found[0], found.end()
        if self.text[stop : stop + 1] == ":":
            text = text[: max(text.rfind(space) for space in " \t\r\n,") + 1]  # without the name
            if not text:
                self.fail(position, f"expected a value, found {self.text[position : position + 20]!r}")
            stop = position + len(text)
        text = text.strip(" \t\r\n,")
        numbers = _numbers(text) if text.count(",") >= _LONG else None
        node.values.extend([numbers] if numbers is not None else map(_value, text.split(",")))
        return stop

    def skip(self, position: int) -> int:
        """Where the next thing begins, after white space, commas and comments."""
        return _SPACE.match(self.text, position).end()  # type: ignore[union-attr]

    def fail(self, position: int, message: str) -> NoReturn:
        line = self.text.count("\n", 0, position) + 1
        raise FormatError(self.path, message, line=line)


def _numbers(text: str) -> npt.NDArray[Any] | None:
    """Numbers with commas between them; ``None`` where there are others."""
    if "#" in text or "(" in text:  # as C libraries write what is not a number
        text = _NOT_A_NUMBER.sub("nan", text.replace(".#INF", "e999"))
    dtype = np.float64 if any(mark in text for mark in ".eEnN") else np.int64
    try:
        numbers = np.fromstring(text, dtype, sep=",") if text else np.zeros(0)
    except ValueError:
        return None
    return numbers if not text or len(numbers) == text.count(",") + 1 else None


def _value(text: str) -> Value:
    """A number, or a word such as ``Y``."""
    text = text.strip()
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
