"""The first half of a BVH file: the tree of joints and their channels."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from kinetograph.errors import FormatError
from kinetograph.formats.bvh.spellings import LARGEST, only_reading

MOST_JOINTS = 20_000
"""More joints than any character has: a file with more is damaged, and would take minutes to refuse later."""

_TOKEN = re.compile(rb"[{}]|[^\s{}]+")
_CHANNEL = re.compile(r"([xyz])(position|rotation|scale)\Z", re.IGNORECASE)
_END = -2
_PLAIN = re.compile(rb"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?", re.IGNORECASE)


class Token(NamedTuple):
    """A word of the file, its line counted from 1, and the bytes where it begins and ends."""

    text: bytes
    line: int
    begin: int
    end: int


@dataclass
class Node:
    """A joint as written.

    Parameters
    ----------
    name : str
    parent : int
        Index of the parent, -1 for a ROOT.
    line : int
        Where the joint begins.
    offset : tuple of float, optional
    channels : list of tuple of str
        Axis and kind, such as ``("z", "rotation")``.
    column : int
        The column of its first channel.
    ends : list of tuple of float
        Offsets of its end sites.
    """

    name: str
    parent: int
    line: int
    offset: tuple[float, float, float] | None = None
    channels: list[tuple[str, str]] = field(default_factory=list)
    column: int = 0
    ends: list[tuple[float, float, float]] = field(default_factory=list)


@dataclass(frozen=True)
class Hierarchy:
    """The first half of a file.

    Parameters
    ----------
    nodes : list of Node
        The joints in file order.
    width : int
        Number of channels.
    position, line : int
        The byte after the word MOTION, and its line.
    notes : tuple of str
        What is spelt in a way of its own.
    """

    nodes: list[Node]
    width: int
    position: int
    line: int
    notes: tuple[str, ...] = ()


def parse_hierarchy(path: Path, data: bytes) -> Hierarchy:
    """Read up to and including the word MOTION. Raises FormatError, with the line."""
    return _Parser(path, data).run()


class _Words:
    """The words of a file one after another, and errors that say where."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self.data = path, data
        self.tokens = _tokens(data)
        self.kept: Token | None = None
        self.last_line = 1
        self.depth = 0
        self.notes: list[str] = []

    def words_of_line(self, token: Token) -> list[Token]:
        """The words up to the end of the line or a brace: a joint's name may have spaces."""
        words: list[Token] = []
        while (following := self.peek()) is not None and following.line == token.line and following.text not in b"{}":
            words.append(self.next("a name"))
        return words

    def brace(self, token: Token) -> None:
        following = self.next("{")
        if following.text != b"{":
            raise self.error(following, f"expected {{ after {show(token.text)}, found {show(following.text)}")

    def number(self, what: str) -> float:
        return self.value(self.next(what), what)

    def value(self, token: Token, what: str) -> float:
        try:
            value = float(token.text)
        except ValueError:
            value = math.nan
        if not abs(value) <= LARGEST:
            raise self.error(token, f"expected {what}, a finite number, found {show(token.text)}")
        return value

    def offset(self) -> tuple[float, float, float]:
        """Three numbers; those of a line that are spelt in a way of their own where there is one reading."""
        words: list[Token] = []
        while len(words) < 3:
            token = self.next("an offset")
            words.append(token)
            if not _PLAIN.fullmatch(token.text):
                words += self.words_of_line(token)
                text = self.data[words[0].begin : words[-1].end]
                reading = only_reading(text.replace(b"\n", b" "), 3)
                if reading is None:
                    break
                self.notes.append(f"line {token.line}: {reading[0].name}: {show(text)} is read as an OFFSET")
                x, y, z = reading[1].tolist()
                return x, y, z
        x, y, z = (self.value(word, "an offset") for word in words[:3])
        return x, y, z

    def peek(self) -> Token | None:
        if self.kept is None:
            self.kept = next(self.tokens, None)
        return self.kept

    def next(self, expected: str) -> Token:
        token = self.peek()
        if token is None:
            message = f"the file ends where {expected} was expected (open braces: {self.depth}); is it cut short?"
            raise FormatError(self.path, message, line=self.last_line)
        self.kept, self.last_line = None, token.line
        return token

    def error(self, token: Token, message: str) -> FormatError:
        column = token.begin - self.data.rfind(b"\n", 0, token.begin)
        return FormatError(self.path, message, line=token.line, column=column)


class _Parser:
    """One pass over the words, with the open joints on a list, as depth may exceed Python's stack."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.words = _Words(path, data)
        self.nodes: list[Node] = []
        self.open: list[int] = []
        self.width = 0

    def run(self) -> Hierarchy:
        while True:
            self.words.depth = len(self.open)
            token = self.words.next("MOTION")
            word = token.text.lower()
            if word in (b"motion", b"motion:") and not self.open:
                if not self.nodes:
                    raise self.words.error(token, "expected a ROOT before MOTION, found none")
                return Hierarchy(self.nodes, self.width, token.end, token.line, tuple(self.words.notes))
            self.statement(word, token)

    def statement(self, word: bytes, token: Token) -> None:
        inside = bool(self.open) and self.open[-1] != _END
        if word == b"root" and not self.open:
            self.joint(token, -1)
        elif word == b"joint" and inside:
            self.joint(token, self.open[-1])
        elif word in (b"end", b"endsite") and inside:
            self.words.words_of_line(token)
            self.words.brace(token)
            self.open.append(_END)
        elif word == b"offset" and self.open:
            self.offset(token)
        elif word == b"channels" and self.open:
            self.channels(token)
        elif word == b"}" and self.open:
            self.close(token)
        elif word != b"hierarchy" or self.nodes:
            raise self.words.error(token, f"expected {self.expected()}, found {show(token.text)}")

    def joint(self, token: Token, parent: int) -> None:
        words = self.words.words_of_line(token)
        name = _decode(self.words.data[words[0].begin : words[-1].end]) if words else "joint"
        self.words.brace(token)
        if len(self.nodes) == MOST_JOINTS:
            raise self.words.error(token, f"more than {MOST_JOINTS} joints; is this file damaged?")
        self.open.append(len(self.nodes))
        self.nodes.append(Node(name, parent, token.line))

    def offset(self, token: Token) -> None:
        offset = self.words.offset()
        if self.open[-1] == _END:
            self.nodes[self.open[-2]].ends.append(offset)
        else:
            self.nodes[self.open[-1]].offset = offset

    def channels(self, token: Token) -> None:
        count = self.words.number("the number of channels")
        channels: list[tuple[str, str]] = []
        while (following := self.words.peek()) is not None:
            match = _CHANNEL.match(_decode(following.text))
            if match is None:
                break
            channels.append((match[1].lower(), match[2].lower()))
            self.words.next("a channel")
        if count != len(channels):
            after = "" if following is None else f", then {show(following.text)}"
            raise self.words.error(
                token, f"expected {count:g} channels such as Xposition or Zrotation, found {len(channels)}{after}"
            )
        if self.open[-1] == _END:
            if channels:
                raise self.words.error(token, "an End Site can have no channels; write it as a JOINT")
            return
        node = self.nodes[self.open[-1]]
        if node.channels:
            raise self.words.error(token, f"joint {node.name!r} has CHANNELS twice")
        moves = [axis for axis, kind in channels if kind == "position"]
        angles = [axis for axis, kind in channels if kind == "rotation"]
        if len(set(moves)) != len(moves) or len(angles) > 3:
            raise self.words.error(token, "expected at most 3 rotations and one position per axis, found more")
        node.channels, node.column = channels, self.width
        self.width += len(channels)

    def close(self, token: Token) -> None:
        closed = self.open.pop()
        if closed != _END and self.nodes[closed].offset is None:
            node = self.nodes[closed]
            raise FormatError(self.words.path, f"joint {node.name!r} has no OFFSET; add one", line=node.line)

    def expected(self) -> str:
        if not self.open:
            return "ROOT or MOTION" if self.nodes else "HIERARCHY or ROOT"
        return "OFFSET or }" if self.open[-1] == _END else "OFFSET, CHANNELS, JOINT, End Site or }"


def _tokens(data: bytes) -> Iterator[Token]:
    begin, line = 0, 1
    while begin < len(data):
        stop = data.find(b"\n", begin)
        stop = len(data) if stop < 0 else stop
        for match in _TOKEN.finditer(data, begin, stop):
            yield Token(match[0], line, match.start(), match.end())
        begin, line = stop + 1, line + 1


def _decode(text: bytes) -> str:
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def show(text: bytes) -> str:
    """A word for a message: on one line, and short."""
    word = _decode(text)
    return repr(word if len(word) <= 40 else word[:37] + "...")
