"""Imports point one way (the table of docs/design.md), and importing the package is quick and quiet."""

from __future__ import annotations

import ast
import functools
import subprocess
import sys
from pathlib import Path

import pytest

import kinetograph

_PACKAGE = Path(kinetograph.__file__).parent
_MODULES = sorted(path for path in _PACKAGE.rglob("*.py") if path != _PACKAGE / "__init__.py")

_LAYERS = (
    {"__main__"},
    {"cli", "studio"},
    {"live", "service"},
    {"evaluation", "drawing"},
    {"pipeline"},
    {"methods", "post"},
    {"segmentation", "library", "samples", "formats", "markers"},
    {"take", "signal", "readings", "synthesis", "keys", "sensing"},
    {"kinematics", "motion", "mirroring", "skeleton", "roles", "body_shape", "stance", "character", "learn"},
    {"rotations", "rows", "sampling", "filters", "quaternion_kernels", "work"},
    {"errors", "arrays", "display", "left_out", "progress", "stopping"},
)
"""Top-level names from high to low. Names of one layer may import one another, but not in a circle."""

_RANK = {name: rank for rank, layer in enumerate(reversed(_LAYERS)) for name in layer}
_BODIES = {
    *("motion", "skeleton", "character", "kinematics", "roles", "body_shape", "mirroring"),
    *("take", "signal", "readings", "synthesis", "keys"),
}
_HEAVY = ("numba", "matplotlib", "scipy")


@functools.cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def _top(path: Path) -> str:
    """The name under kinetograph that a module belongs to."""
    return path.relative_to(_PACKAGE).parts[0].removesuffix(".py")


def _name(path: Path, package: Path = _PACKAGE) -> str:
    """The dotted name of a module."""
    parts = [package.name, *path.relative_to(package).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(tree: ast.AST) -> list[tuple[str, str]]:
    """What of kinetograph is imported, at the top, in a function or for type checking: modules, and names in them.

    The name is empty where a whole module is imported.
    """
    imports = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imports += [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: imports are absolute"
            imports += [(node.module or "", alias.name) for alias in node.names]
    return [(module, name) for module, name in imports if module.split(".")[0] == "kinetograph"]


def _tops(tree: ast.AST) -> set[str]:
    """The names under kinetograph that a module imports."""
    dotted = [f"{module}.{name}" for module, name in _imported(tree)]
    return {name.split(".")[1] for name in dotted} - {"", *kinetograph.__all__}


def _imports(path: Path) -> set[str]:
    return _tops(_tree(path))


def _graph() -> dict[str, set[str]]:
    graph: dict[str, set[str]] = {}
    for path in _MODULES:
        graph.setdefault(_top(path), set()).update(_imports(path) - {_top(path)})
    return graph


def _module_graph(package: Path) -> dict[str, set[str]]:
    """The modules of a package and, for each, the modules that it imports."""
    paths = {_name(path, package): path for path in package.rglob("*.py")}
    graph: dict[str, set[str]] = {}
    for module, path in paths.items():
        dotted = [(f"{a}.{b}", a) for a, b in _imported(ast.parse(path.read_text()))]
        graph[module] = {whole if whole in paths else outer for whole, outer in dotted} - {module}
    return graph


def _reachable(graph: dict[str, set[str]], start: str) -> set[str]:
    """Names that one step or more lead to."""
    seen: set[str] = set()
    row = {start}
    while row:
        row = {name for here in row for name in graph.get(here, ())} - seen
        seen |= row
    return seen


def _circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Groups of names that import each other, directly or through others."""
    reach = {name: _reachable(graph, name) for name in graph}
    circles = {frozenset(other for other in reach[name] if name in reach[other]) for name in graph}
    return sorted(sorted(circle) for circle in circles if circle)


def _id(path: Path) -> str:
    return str(path.relative_to(_PACKAGE))


def test_the_reader_of_imports_sees_every_kind() -> None:
    lines = ("from kinetograph import rotations as rot", "import kinetograph.motion", "def f():")
    tree = ast.parse("\n".join([*lines, "    from kinetograph.post.blend import join"]))
    assert _tops(tree) == {"rotations", "motion", "post"}
    assert ("kinetograph.post.blend", "join") in _imported(tree)


def test_a_circle_is_found() -> None:
    assert _circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}, "e": set()}) == [["b", "c"]]
    assert _circles({"a": {"b"}, "b": set()}) == []


def test_a_circle_of_modules_is_found_wherever_its_imports_stand(tmp_path: Path) -> None:
    package = tmp_path / "kinetograph"
    for name, text in {
        "__init__.py": "",
        "facade.py": "from kinetograph.rooms import Kitchen",
        "plan.py": "def draw():\n    from kinetograph.facade import front",
        "rooms/__init__.py": "from kinetograph.rooms.kitchen import Kitchen",
        "rooms/kitchen.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from kinetograph import plan",
        "street.py": "import kinetograph.facade",
    }.items():
        (package / name).parent.mkdir(exist_ok=True)
        (package / name).write_text(text)
    circle = ["facade", "plan", "rooms", "rooms.kitchen"]
    assert _circles(_module_graph(package)) == [[f"kinetograph.{name}" for name in circle]]
    (package / "plan.py").write_text("")
    assert _circles(_module_graph(package)) == []


@pytest.mark.parametrize("path", _MODULES, ids=_id)
def test_imports_point_down(path: Path) -> None:
    here = _top(path)
    assert here in _RANK, f"{here} is in no layer: give it a place in the table of this test and in the design"
    above = sorted(name for name in _imports(path) if _RANK.get(name, -1) > _RANK[here])
    assert not above, f"{path.relative_to(_PACKAGE)} imports {', '.join(above)} from above its layer"


def test_no_layer_imports_in_a_circle() -> None:
    assert _circles(_graph()) == []


def test_no_module_imports_in_a_circle() -> None:
    circles = _circles(_module_graph(_PACKAGE))
    assert not circles, "; ".join(" and ".join(circle) for circle in circles)


def _private(tree: ast.AST) -> list[str]:
    """What is imported from kinetograph by a name with an underscore before it."""
    dotted = [f"{module}.{name}".rstrip(".") for module, name in _imported(tree)]
    return [name for name in dotted if any(p.startswith("_") and not p.startswith("__") for p in name.split("."))]


def test_private_names_are_seen() -> None:
    lines = ("from kinetograph import __version__", "from kinetograph.post import join")
    private = ("from kinetograph.cli import _shell", "import kinetograph.a._b", "from kinetograph.c import d, _e")
    tree = ast.parse("\n".join([*lines, *private]))
    assert _private(tree) == ["kinetograph.cli._shell", "kinetograph.a._b", "kinetograph.c._e"]


@pytest.mark.parametrize("path", _MODULES, ids=_id)
def test_private_names_stay_within_their_package(path: Path) -> None:
    away = [name for name in _private(_tree(path)) if name.split(".")[1] != _top(path)]
    assert not away, f"{_id(path)} imports {', '.join(away)}; export it from its package's door without an underscore"


def test_tests_use_public_names_kernels_aside() -> None:
    tests = Path(__file__).parent
    wrong: dict[str, list[str]] = {}
    for path in tests.rglob("*.py"):
        names = [name for name in _private(_tree(path)) if "_kernels" not in name]
        if names and not path.name.startswith("naive"):
            wrong[str(path.relative_to(tests))] = names
    assert not wrong, f"make them public in their module, or test them through what is: {wrong}"


# ---- sizes ----

_LONG = 40
"""Lines of a function, its docstring aside."""
_MANY = 10
"""Methods and properties of a class, special methods aside."""
_LONG_ON_PURPOSE = {
    "kinetograph.learn._certified_kernels.extend": "its innermost loops: 1.7 times as long with calls",
    "kinetograph.learn._group_kernels.scan_group": "its innermost loops, which a call per head slows down by a fifth",
}
"""Compiled functions that are longer, and why."""


def _lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    first = function.body[0]
    text = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str)
    docstring = (first.end_lineno or 0) - first.lineno + 1 if text else 0
    return (function.end_lineno or 0) - function.lineno + 1 - docstring


def _long_functions(tree: ast.AST) -> dict[str, int]:
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    return {function.name: _lines(function) for function in functions if _lines(function) > _LONG}


def _large_classes(tree: ast.AST) -> dict[str, int]:
    counts = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            members = [n.name for n in node.body if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
            counts[node.name] = len([name for name in members if not name.startswith("__")])
    return {name: count for name, count in counts.items() if count > _MANY}


def test_sizes_are_measured_without_docstrings_and_special_methods() -> None:
    body = "\n".join(["    x = 1"] * 39)
    assert _long_functions(ast.parse(f'def f():\n    """One.\n\n    Two.\n    """\n{body}')) == {}
    assert _long_functions(ast.parse(f"def f():\n    x = 0\n{body}")) == {"f": 41}
    methods = "\n".join(f"    def f{i}(self): ..." for i in range(10))
    assert _large_classes(ast.parse(f"class A:\n    def __len__(self): ...\n{methods}")) == {}
    assert _large_classes(ast.parse(f"class A:\n    def _f(self): ...\n{methods}")) == {"A": 11}


@pytest.mark.parametrize("path", _MODULES, ids=_id)
def test_functions_and_classes_are_small(path: Path) -> None:
    tree = _tree(path)
    long = {f"{_name(path)}.{function}": lines for function, lines in _long_functions(tree).items()}
    too_long = {function: lines for function, lines in long.items() if function not in _LONG_ON_PURPOSE}
    assert not too_long, f"functions of more than {_LONG} lines: {too_long}"
    assert not _large_classes(tree), f"classes of more than {_MANY} methods: {_large_classes(tree)}"


def test_exceptions_to_the_sizes_are_needed() -> None:
    long = {f"{_name(path)}.{name}" for path in _MODULES for name in _long_functions(_tree(path))}
    assert set(_LONG_ON_PURPOSE) <= long, f"no longer needed: {sorted(set(_LONG_ON_PURPOSE) - long)}"


# ---- what a layer may do ----


def test_learning_sees_arrays_only() -> None:
    assert _graph()["learn"] <= {"arrays", "errors", "progress", "rotations", "sampling"}
    assert not _graph()["learn"] & _BODIES


def test_pictures_sit_above_formats() -> None:
    assert _RANK["drawing"] > _RANK["formats"]
    for name, imported in _graph().items():
        if name not in ("__main__", "cli", "studio", "stream", "evaluation"):
            assert "drawing" not in imported, f"{name} draws pictures"


def test_nothing_below_imports_the_command_line() -> None:
    for name, imported in _graph().items():
        assert name in ("__main__", "cli") or "cli" not in imported, f"{name} imports the command line"


@pytest.mark.parametrize("path", [p for p in _MODULES if _top(p) not in ("__main__", "cli")], ids=_id)
def test_the_library_does_not_print(path: Path) -> None:
    calls = [n for n in ast.walk(_tree(path)) if isinstance(n, ast.Call)]
    assert not [n.lineno for n in calls if isinstance(n.func, ast.Name) and n.func.id == "print"]


def _modules_after(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(*{{m.split('.')[0] for m in sys.modules}})"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


def test_importing_the_package_loads_nothing_heavy() -> None:
    loaded = _modules_after("import kinetograph")
    assert "kinetograph" in loaded
    assert not loaded & {*_HEAVY, "numpy"}


def test_the_core_loads_nothing_heavy() -> None:
    loaded = _modules_after("import kinetograph as kg; kg.Motion, kg.Signal, kg.Take, kg.Synthesis, kg.load")
    assert "numpy" in loaded
    assert not loaded & set(_HEAVY)


def test_every_export_is_there() -> None:
    for name in kinetograph.__all__:
        assert getattr(kinetograph, name) is not None
    assert dir(kinetograph) == sorted(kinetograph.__all__)
    with pytest.raises(AttributeError, match="module 'kinetograph' has no attribute 'Nothing'"):
        kinetograph.Nothing  # noqa: B018


def test_type_checkers_see_every_export() -> None:
    tree = _tree(_PACKAGE / "__init__.py")
    assert {name for _, name in _imported(tree)} == set(kinetograph.__all__) - {"__version__"}
