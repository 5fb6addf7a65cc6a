"""Values as columns of numbers, text and arrays, so that a file of them can be read by memory map.

A value is a column of length one. A column of objects of one class becomes a column for each of their fields, one of
tuples the column of all their items and their lengths, and so on down to numbers, text and arrays, which lie end to
end. Thousands of small objects thus become a few arrays. Columns are listed so that each refers to earlier ones only;
what occurs twice is listed once, and comes back as one object.

Nothing is called to read one: classes are frozen dataclasses of this package, made without their constructors, since
what is packed has been checked when it was made; everything else is a number, text, a plain container or an array of
numbers.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, chain, pairwise
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[Any]
Node: TypeAlias = list[Any]
"""A column as JSON: its sort, and what it is made of; whole numbers are places of earlier columns, or of arrays."""

FEW = 16
"""Numbers up to which a column is written out in the list of columns."""
_CLASS = re.compile(r"kinetograph(\.\w+)*:\w+")
_SEQUENCES: dict[str, Callable[[Iterable[Any]], Any]] = {
    "tuple": tuple,
    "list": list,
    "set": set,
    "frozenset": frozenset,
}
_MAPPINGS: dict[str, Callable[[Any], Any]] = {"dict": dict, "mappingproxy": lambda pairs: MappingProxyType(dict(pairs))}
_NUMBERS = {bool: "|b1", int: "<i8", float: "<f8", complex: "<c16"}
_STORED = "biufcU"
"""Kinds of NumPy's types that are stored."""


class UnpackableError(TypeError):
    """A value of a type that is not stored."""


class UnreadableError(ValueError):
    """Columns that describe no value."""


@dataclass(frozen=True, eq=False)
class Packed:
    """Columns, and the arrays that they are made of.

    Parameters
    ----------
    nodes : list
        The columns; the value is the only item of the last one.
    arrays : list of (str, list of ndarray)
        Of each its type, and the parts that lie end to end.
    """

    nodes: list[Node] = field(default_factory=list)
    arrays: list[tuple[str, list[Array]]] = field(default_factory=list)

    @property
    def size(self) -> int:
        """Bytes of the arrays."""
        return sum(part.nbytes for _, parts in self.arrays for part in parts)


def pack(value: object) -> Packed:
    """A value as columns. Raises UnpackableError for what is not stored, such as a function."""
    packer = _Packer()
    try:
        packer.column([value])
    except RecursionError as error:
        raise UnpackableError("it is nested too deeply, or holds itself") from error
    return Packed(packer.nodes, packer.arrays)


def unpack(nodes: Sequence[Node], arrays: Sequence[Array]) -> Any:
    """The value of columns and of their arrays, each ``(N,)``. Raises UnreadableError where they describe none."""
    columns: list[list[Any]] = []
    try:
        for sort, *rest in nodes:
            columns.append(_READERS[sort](columns, arrays, *rest))
        (value,) = columns[-1]
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, ImportError) as error:
        raise UnreadableError(f"not columns of a value: {error}") from error
    return value


class _Packer:
    """Columns on the way; values are held, so that no two have the same identity."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.arrays: list[tuple[str, list[Array]]] = []
        self._known: dict[tuple[int, ...], int] = {}
        self._held: list[list[Any]] = []

    def column(self, values: list[Any]) -> int:
        """The place of a column, which is listed if it is not yet."""
        key = tuple(map(id, values))
        if key not in self._known:
            node = self._node(values)
            self._held.append(values)
            self._known[key] = len(self.nodes)
            self.nodes.append(node)
        return self._known[key]

    def _node(self, values: list[Any]) -> Node:
        if not values:
            return ["none", 0]
        sorts = list(map(_sort_of, values))
        alike = dict.fromkeys(sorts)
        if len(alike) > 1:
            return self._mixed(values, sorts, list(alike))
        kind = type(values[0])
        if kind is type(None):
            return ["none", len(values)]
        if kind in _NUMBERS:
            return self._numbers(values, kind)
        same = values if kind is str else list(map(id, values))
        unique = dict(zip(same, values, strict=True))
        if len(unique) == 1 < len(values):
            return ["same", len(values), self.column(values[:1])]
        if len(unique) < len(values):
            places = {key: place for place, key in enumerate(unique)}
            return ["pick", self._integers([places[key] for key in same]), self.column(list(unique.values()))]
        return self._of_kind(values, kind)

    def _of_kind(self, values: list[Any], kind: type) -> Node:
        if kind is str:
            return ["plain", values]
        if kind is np.ndarray:
            return self._arrays(values)
        if issubclass(kind, np.generic):
            return ["scalars", self._array(np.array(values).dtype.str, [np.array(values)])]
        lengths = self._integers(list(map(len, values))) if kind.__name__ in {*_SEQUENCES, *_MAPPINGS} else 0
        if kind in _SEQUENCES.values():
            parts = [sorted(value, key=repr) if kind in (set, frozenset) else value for value in values]
            return ["items", kind.__name__, lengths, self.column(list(chain.from_iterable(parts)))]
        if kind in (dict, MappingProxyType):
            keys = self.column(list(chain.from_iterable(values)))
            return ["pairs", kind.__name__, lengths, keys, self.column([v for one in values for v in one.values()])]
        return self._objects(values, kind)

    def _mixed(self, values: list[Any], sorts: list[Any], alike: list[Any]) -> Node:
        which = {sort: number for number, sort in enumerate(alike)}
        numbers = [which[sort] for sort in sorts]
        groups: list[list[Any]] = [[] for _ in alike]
        for number, value in zip(numbers, values, strict=True):
            groups[number].append(value)
        return ["mixed", self._integers(numbers), [self.column(group) for group in groups]]

    def _numbers(self, values: list[Any], kind: type) -> Node:
        if kind is int and not all(-(2**63) <= value < 2**63 for value in values):
            raise UnpackableError("it has a whole number of more than 64 bits")
        if len(values) <= FEW and kind is not complex and (kind is not float or all(map(math.isfinite, values))):
            return ["plain", values]
        return ["numbers", self._array(_NUMBERS[kind], [np.array(values, dtype=_NUMBERS[kind])])]

    def _arrays(self, values: list[Array]) -> Node:
        first = values[0]
        turned = _by_columns(first)
        parts = [value.T if turned else value for value in values]
        shape = first.shape[1:] if first.ndim else None
        lengths = self._integers([len(value) if first.ndim else 1 for value in values])
        return ["arrays", self._array(_stored(first), parts), lengths, shape, turned]

    def _objects(self, values: list[Any], kind: type) -> Node:
        if not (_CLASS.fullmatch(_class_name(kind)) and _is_stored(kind)):
            raise UnpackableError(f"it holds a {kind.__module__}.{kind.__qualname__}, which is not kept")
        names = [one.name for one in dataclasses.fields(kind)]
        columns = [self.column([getattr(value, name) for value in values]) for name in names]
        for name in _derived(kind):
            if all(name in vars(value) for value in values):
                mark = len(self.nodes), len(self.arrays)
                try:
                    columns.append(self.column([vars(value)[name] for value in values]))
                    names.append(name)
                except UnpackableError:
                    self._forget(*mark)
        return ["objects", _class_name(kind), len(values), names, columns]

    def _forget(self, nodes: int, arrays: int) -> None:
        """Take back what has been listed since."""
        del self.nodes[nodes:], self.arrays[arrays:]
        self._known = {key: place for key, place in self._known.items() if place < nodes}

    def _integers(self, values: list[int]) -> list[int] | int:
        """Whole numbers as they are, where they are few, or the place of their array."""
        if len(values) <= FEW:
            return values
        numbers = np.array(values, dtype=np.int64)
        return self._array(np.min_scalar_type(int(numbers.max())).str, [numbers])

    def _array(self, kind: str, parts: list[Array]) -> int:
        self.arrays.append((kind, parts))
        return len(self.arrays) - 1


def _sort_of(value: object) -> Any:
    """What values of one column have in common: their type, and of arrays all but the first side of their shape."""
    if type(value) is np.ndarray:
        return value.dtype.str, value.ndim, value.shape[1:], _by_columns(value)
    return type(value)


def _by_columns(array: Array) -> bool:
    return array.ndim > 1 and array.flags.f_contiguous and not array.flags.c_contiguous


def _stored(array: Array) -> str:
    if array.dtype.kind not in _STORED:
        raise UnpackableError(f"it holds an array of {array.dtype}, which is not kept")
    return array.dtype.str


def _class_name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


def _is_stored(kind: type) -> bool:
    parameters = getattr(kind, "__dataclass_params__", None)
    return parameters is not None and bool(parameters.frozen)


def _derived(kind: type) -> list[str]:
    """The properties of a class that are computed once."""
    return [
        name for one in kind.__mro__ for name, what in vars(one).items() if isinstance(what, functools.cached_property)
    ]


# ---- reading ----

_Columns: TypeAlias = list[list[Any]]
_Arrays: TypeAlias = Sequence[Array]


def _none(_columns: _Columns, _arrays: _Arrays, count: int) -> list[Any]:
    return [None] * count


def _plain(_columns: _Columns, _arrays: _Arrays, values: list[Any]) -> list[Any]:
    if not all(type(value) in (bool, int, float, str) for value in values):
        raise UnreadableError("expected numbers or text")
    return values


def _read_numbers(_columns: _Columns, arrays: _Arrays, place: int) -> list[Any]:
    return list(_at(arrays, place).tolist())


def _read_scalars(_columns: _Columns, arrays: _Arrays, place: int) -> list[Any]:
    return list(_at(arrays, place))


def _pick(columns: _Columns, arrays: _Arrays, places: list[int] | int, column: int) -> list[Any]:
    of = _at(columns, column)
    return [_at(of, place) for place in _read_integers(arrays, places)]


def _same(columns: _Columns, _arrays: _Arrays, count: int, column: int) -> list[Any]:
    (value,) = _at(columns, column)
    return [value] * count


def _read_mixed(columns: _Columns, arrays: _Arrays, numbers: list[int] | int, groups: list[int]) -> list[Any]:
    each = [iter(_at(columns, column)) for column in groups]
    return [next(_at(each, number)) for number in _read_integers(arrays, numbers)]


def _read_items(columns: _Columns, arrays: _Arrays, kind: str, lengths: list[int] | int, column: int) -> list[Any]:
    make = _SEQUENCES[kind]
    return [make(part) for part in _parts(_at(columns, column), _read_integers(arrays, lengths))]


def _read_pairs(
    columns: _Columns, arrays: _Arrays, kind: str, lengths: list[int] | int, keys: int, values: int
) -> list[Any]:
    pairs = list(zip(_at(columns, keys), _at(columns, values), strict=True))
    return [_MAPPINGS[kind](part) for part in _parts(pairs, _read_integers(arrays, lengths))]


def _read_arrays(
    _columns: _Columns,
    arrays: _Arrays,
    place: int,
    lengths: list[int] | int,
    shape: list[int] | None,
    turned: bool,
) -> list[Array]:
    whole = _at(arrays, place)
    if shape is None:
        return [whole[row : row + 1].reshape(()) for row in range(len(_read_integers(arrays, lengths)))]
    width, counts = math.prod(shape), _read_integers(arrays, lengths)
    borders = list(accumulate(counts, initial=0))
    if min(counts, default=0) < 0 or min(shape, default=0) < 0 or borders[-1] * width != len(whole):
        raise UnreadableError("an array has other lengths than its rows")
    cut = [whole[a * width : b * width] for a, b in pairwise(borders)]
    if turned:
        return [part.reshape((*reversed(shape), count)).T for part, count in zip(cut, counts, strict=True)]
    return [part.reshape((count, *shape)) for part, count in zip(cut, counts, strict=True)]


def _read_objects(
    columns: _Columns, _arrays: _Arrays, kind: str, count: int, names: list[str], fields: list[int]
) -> list[Any]:
    made = _class_of(kind)
    stated = {one.name for one in dataclasses.fields(made)}
    if not (stated <= set(names) <= stated | set(_derived(made))):
        raise UnreadableError(f"{kind} has other fields")
    rows = zip(*(_at(columns, one) for one in fields), strict=True) if names else ((),) * count
    objects: list[Any] = []
    for row in rows:
        one: Any = object.__new__(made)
        one.__dict__.update(zip(names, row))  # noqa: B905, as rows have as many items as there are columns
        objects.append(one)
    if len(objects) != count:
        raise UnreadableError(f"expected {count} of {kind}, found {len(objects)}")
    return objects


def _class_of(name: str) -> Any:
    """A frozen dataclass of this package by its module and name. Raises UnreadableError for anything else."""
    if not _CLASS.fullmatch(name):
        raise UnreadableError(f"{name!r} is no class of kinetograph")
    module, _, attribute = name.partition(":")
    kind = getattr(importlib.import_module(module), attribute, None)
    if not (isinstance(kind, type) and _class_name(kind) == name and _is_stored(kind)):
        raise UnreadableError(f"{name!r} is no frozen dataclass of kinetograph")
    return kind


def _read_integers(arrays: _Arrays, values: list[int] | int) -> list[int]:
    return list(_at(arrays, values).tolist()) if isinstance(values, int) else values


def _at(of: Any, place: int) -> Any:
    if not 0 <= place < len(of):
        raise UnreadableError(f"{place} lies outside 0 to {len(of) - 1}")
    return of[place]


def _parts(values: list[Any], lengths: list[int]) -> list[list[Any]]:
    borders = list(accumulate(lengths, initial=0))
    if min(lengths, default=0) < 0 or borders[-1] != len(values):
        raise UnreadableError("items have other lengths than stated")
    return [values[a:b] for a, b in pairwise(borders)]


_READERS: dict[str, Callable[..., list[Any]]] = {
    "none": _none,
    "plain": _plain,
    "numbers": _read_numbers,
    "scalars": _read_scalars,
    "pick": _pick,
    "same": _same,
    "mixed": _read_mixed,
    "items": _read_items,
    "pairs": _read_pairs,
    "arrays": _read_arrays,
    "objects": _read_objects,
}
