"""Imports point one way (the table of docs/design.md), and importing the package is quick and quiet."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import kinetograph

_PACKAGE = Path(kinetograph.__file__).parent
_MODULES = sorted(path for path in _PACKAGE.rglob("*.py") if path != _PACKAGE / "__init__.py")

_LAYERS = (
    {"__main__"},
    {"cli", "studio", "stream"},
    {"evaluation", "drawing"},
    {"pipeline"},
    {"methods", "post"},
    {"segmentation", "library", "samples", "formats", "markers"},
    {"take", "signal", "synthesis", "keys", "sensing"},
    {"kinematics", "motion", "mirroring", "skeleton", "roles", "character", "learn"},
    {"rotations", "sampling", "quaternion_kernels"},
    {"errors", "arrays", "progress"},
)
"""Top-level names from high to low. Names of one layer may import one another, but not in a circle."""

_RANK = {name: rank for rank, layer in enumerate(reversed(_LAYERS)) for name in layer}
_BODIES = {
    *("motion", "skeleton", "character", "kinematics", "roles", "mirroring"),
    *("take", "signal", "synthesis", "keys"),
}
_HEAVY = ("numba", "matplotlib", "scipy")


def _top(path: Path) -> str:
    """The name under kinetograph that a module belongs to."""
    return path.relative_to(_PACKAGE).parts[0].removesuffix(".py")


def _names(tree: ast.AST) -> set[str]:
    """The names under kinetograph that a module imports, at its top, in a function or for type checking."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: imports are absolute"
            found |= {f"{node.module}.{a.name}" for a in node.names} if node.module == "kinetograph" else {node.module}
    return {name.split(".")[1] for name in found if name and name.startswith("kinetograph.")}


def _imports(path: Path) -> set[str]:
    return _names(ast.parse(path.read_text())) - {"__version__", *kinetograph._EXPORTS}


def _graph() -> dict[str, set[str]]:
    graph: dict[str, set[str]] = {}
    for path in _MODULES:
        graph.setdefault(_top(path), set()).update(_imports(path) - {_top(path)})
    return graph


def _circle(graph: dict[str, set[str]]) -> list[str]:
    """Names that are left when those that import nothing of the rest are taken away again and again."""
    left = dict(graph)
    while leaves := [name for name in left if not left[name] & left.keys()]:
        for name in leaves:
            del left[name]
    return sorted(left)


def _id(path: Path) -> str:
    return str(path.relative_to(_PACKAGE))


def test_the_reader_of_imports_sees_every_kind() -> None:
    lines = ("from kinetograph import rotations as rot", "import kinetograph.motion", "def f():")
    text = "\n".join([*lines, "    from kinetograph.post.blend import join"])
    assert _names(ast.parse(text)) == {"rotations", "motion", "post"}


def test_a_circle_is_found() -> None:
    assert _circle({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}, "e": set()}) == ["a", "b", "c", "d"]
    assert _circle({"a": {"b"}, "b": set()}) == []


@pytest.mark.parametrize("path", _MODULES, ids=_id)
def test_imports_point_down(path: Path) -> None:
    here = _top(path)
    assert here in _RANK, f"{here} is in no layer: give it a place in the table of this test and in the design"
    above = sorted(name for name in _imports(path) if _RANK.get(name, -1) > _RANK[here])
    assert not above, f"{path.relative_to(_PACKAGE)} imports {', '.join(above)} from above its layer"


def test_no_layer_imports_in_a_circle() -> None:
    assert _circle(_graph()) == []


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
    calls = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Call)]
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
    assert set(kinetograph.__all__) == {"__version__", *kinetograph._EXPORTS}
    assert dir(kinetograph) == sorted(kinetograph.__all__)
    with pytest.raises(AttributeError, match="module 'kinetograph' has no attribute 'Nothing'"):
        kinetograph.Nothing  # noqa: B018
