"""The faults that may be put into a file: an operator for another, a number for its neighbour, a condition negated."""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

_COMPARE: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
}
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Fault:
    """A fault: what stands at a place in a file, and what is put there.

    Parameters
    ----------
    path : Path
    function : str
        The function that it is in, and the line of its ``def``, as ``name:line``.
    line : int
    start, stop : int
        Bytes of the file.
    before, after : str
        Expressions.
    """

    path: Path
    function: str
    line: int
    start: int
    stop: int
    before: str
    after: str

    def source(self) -> bytes:
        """The file with the fault in it."""
        data = self.path.read_bytes()
        return data[: self.start] + f"({self.after})".encode() + data[self.stop :]

    def __str__(self) -> str:
        return f"{self.path}:{self.line} in {self.function.partition(':')[0]}: {self.before}  ->  {self.after}"


def faults_in(path: Path) -> list[Fault]:
    """Every fault that may be put into the functions of a file; what raises errors or is only typed is left alone."""
    data = path.read_bytes()
    starts = [0]
    for line in data.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for function, node in _expressions(ast.parse(data)):
        before = ast.unparse(node)
        for after in _mutated(node):
            at = starts[node.lineno - 1] + node.col_offset
            to = starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
            found.append(Fault(path, function, node.lineno, at, to, before, after))
    return found


def drawn(paths: list[Path], count: int, seed: int) -> list[Fault]:
    """Faults of some files, drawn at random, every place as likely as any other."""
    every = [fault for path in sorted(paths) for fault in faults_in(path)]
    return random.Random(seed).sample(every, min(count, len(every)))


def _expressions(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    todo: list[tuple[str, ast.AST]] = [("", tree)]
    while todo:
        function, node = todo.pop()
        if isinstance(node, ast.expr) and function:
            yield function, node
        if isinstance(node, ast.keyword) and node.arg == "strict":  # an assertion that lengths agree
            continue
        for name, value in ast.iter_fields(node):
            if name in ("decorator_list", "annotation", "returns", "type_params", "values") and not isinstance(
                node, ast.BoolOp | ast.Dict
            ):
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, _FUNCTIONS):
                    todo.append((function or f"{child.name}:{child.lineno}", child))
                elif isinstance(child, ast.AST) and not isinstance(child, ast.Raise | ast.JoinedStr | ast.Import):
                    todo.append((function, child))


def _mutated(node: ast.expr) -> Iterator[str]:
    match node:
        case ast.Compare(left, [operator], right):
            yield ast.unparse(ast.Compare(left, [_COMPARE[type(operator)]()], right))
        case ast.BoolOp(operator, values):
            yield ast.unparse(ast.BoolOp(ast.And() if isinstance(operator, ast.Or) else ast.Or(), values))
        case ast.BinOp(left, operator, right) if type(operator) in _ARITHMETIC and not _is_text(left, right):
            yield ast.unparse(ast.BinOp(left, _ARITHMETIC[type(operator)](), right))
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            yield ast.unparse(operand)
        case ast.Constant(bool() as value):
            yield str(not value)
        case ast.Constant(int() | float() as value):
            yield repr(value + 1 if isinstance(value, int) else 2 * value or 1.0)
        case ast.IfExp(test, body, orelse):
            yield ast.unparse(ast.IfExp(ast.UnaryOp(ast.Not(), test), body, orelse))
        case _:
            return


def _is_text(*operands: ast.expr) -> bool:
    """Whether an operand is text, of which no other operator makes anything."""
    return any(isinstance(o, ast.JoinedStr) or isinstance(getattr(o, "value", 0), str) for o in operands)
