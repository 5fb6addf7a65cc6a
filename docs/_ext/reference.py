"""Sphinx extension: writes the pages of the API reference and of the command line, and resolves links between names.

The pages are written anew before every build, from the doors (`doors.py`) and from the commands' help
(`commands.py`), into files that git ignores; nothing generated is committed.
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.pycode import ModuleAnalyzer
from sphinx.util.inspect import TypeAliasForwardRef, stringify_signature
from sphinx.util.nodes import make_refnode

import commands
import doors

GROUPS = (
    ("Methods", ("methods", "pipeline", "evaluation", "learn")),
    ("Data", ("motion", "signal", "take", "synthesis", "keys", "skeleton", "roles", "character", "library", "samples")),
    ("Recordings and files", ("formats", "segmentation", "markers", "sensing")),
    ("Pictures", ("drawing",)),
    ("Operations on motion", ("kinematics", "mirroring", "post", "rotations", "sampling")),
)
"""How the index of the reference is ordered; what is in none of the groups comes last."""


# Pages


def write_pages(app: Sphinx) -> None:
    """The command line's page, an index of the API, and a page for every door and module."""
    source = Path(app.srcdir)
    _write(source / "cli.md", commands.reference())
    folder = source / "api"
    documented = doors.documented()
    pages = {module: _page(module, names) for module, names in documented.items()}
    pages["index"] = _index(documented)
    for old in set(folder.glob("*.rst")) - {folder / f"{name}.rst" for name in pages}:
        old.unlink()
    for name, text in pages.items():
        _write(folder / f"{name}.rst", text)


def _write(path: Path, text: str) -> None:
    """Write a file where its text has changed, so that Sphinx reads again only what is new."""
    path.parent.mkdir(exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def _title(text: str, line: str = "=") -> list[str]:
    return [text, line * len(text), ""]


def _index(documented: dict[str, list[doors.Public]]) -> str:
    lines = [*_title("API reference"), *_root(documented)]
    left = list(documented)
    for heading, tops in GROUPS:
        mine = [module for top in tops for module in left if module.split(".")[1] == top]
        lines += _section(heading, mine)
        left = [module for module in left if module not in mine]
    return "\n".join([*lines, *_section("Small modules", left)])


def _root(documented: dict[str, list[doors.Public]]) -> list[str]:
    """What ``import kinetograph as kg`` shows."""
    canonical = {(public.home, public.name): public.path for names in documented.values() for public in names}
    shown = [canonical[public.home, public.name] for public in doors.public_names()[doors.ROOT]]
    text = (
        "Every name that a package's door (its ``__init__``) shows, and the public names of the modules at the top. "
        "These are what ``import kinetograph as kg`` gives at once:"
    )
    return [text, "", *_summary(shown)]


def _section(heading: str, modules: list[str]) -> list[str]:
    if not modules:
        return []
    lines = [*_title(heading, "-"), ".. list-table::", "   :widths: 35 65", ""]
    for module in modules:
        first = (importlib.import_module(module).__doc__ or "").strip().split("\n\n")[0]
        lines += [f"   * - :doc:`{module} <{module}>`", f"     - {' '.join(first.split())}"]
    toctree = [".. toctree::", "   :hidden:", "", *(f"   {module}" for module in modules), ""]
    return [*lines, "", *toctree]


def _page(module: str, names: list[doors.Public]) -> str:
    lines = [*_title(module), f".. py:module:: {module}", f".. currentmodule:: {module}", ""]
    lines += [inspect.getdoc(importlib.import_module(module)) or "", ""]
    code = [public for public in names if public.kind != "data"]
    lines += _summary([public.name for public in code])
    for heading, kinds in (("Classes", ("class", "exception")), ("Functions", ("function",)), ("Data", ("data",))):
        group = [public for public in names if public.kind in kinds]
        if group:
            lines += [*_title(heading, "-"), *(line for public in group for line in _entry(public))]
    return "\n".join([*lines, *_examples([public.path for public in code])])


def _summary(paths: list[str]) -> list[str]:
    if not paths:
        return []
    return [".. autosummary::", "   :nosignatures:", "", *(f"   ~{path}" for path in paths), ""]


def _examples(paths: list[str]) -> list[str]:
    """The gallery's examples that use one of some names, below a heading; nothing where there are none."""
    if not paths:
        return []
    return [f".. minigallery:: {' '.join(paths)}", "   :add-heading: Examples", "   :heading-level: -", ""]


def _entry(public: doors.Public) -> list[str]:
    if public.kind == "data":
        return _data(public)
    lines = [f".. auto{public.kind}:: {public.path}"]
    if public.kind != "function":
        lines.append("   :members:")
    return [*lines, ""]


def _data(public: doors.Public) -> list[str]:
    """A constant or the name of a type, with the docstring that stands below it where it is defined."""
    analyzer = ModuleAnalyzer.for_module(public.home)
    analyzer.analyze()
    lines = [f".. py:data:: {public.name}"]
    if annotation := analyzer.annotations.get(("", public.name)):
        lines.append(f"   :type: {annotation}")
    if public.home != public.module:
        lines.append(f"   :canonical: {public.home}.{public.name}")
    docs = analyzer.attr_docs.get(("", public.name)) or [_means(public)]
    return [*lines, "", *(f"   {line}" for line in docs), ""]


def _means(public: doors.Public) -> str:
    """What a name without a docstring is: a type's other name, or a value."""
    text = repr(public.value)
    return f"Is ``{text if len(text) < 90 else type(public.value).__name__}``."


# Signatures


class _Elided:
    def __repr__(self) -> str:
        return "..."


def tidy_signature(
    app: Sphinx, what: str, name: str, value: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str, str | None] | None:
    """The signature as it is written in the code, its types unevaluated; for a dataclass without private fields.

    What a factory makes by default is shown as ``...``.
    """
    if not signature or not (inspect.isroutine(value) or dataclasses.is_dataclass(value)):
        return None
    made = inspect.signature(value)
    shown = []
    for parameter in made.parameters.values():
        if not parameter.name.startswith("_") and parameter.name not in ("self", "cls"):
            factory = type(parameter.default).__name__ == "_HAS_DEFAULT_FACTORY_CLASS"
            shown.append(parameter.replace(default=_Elided()) if factory else parameter)
    text = stringify_signature(made.replace(parameters=shown), show_return_annotation=False, unqualified_typehints=True)
    result = None if inspect.isclass(value) else made.return_annotation
    return text, result if isinstance(result, str) else None


# Links


class Names:
    """What a name between backticks can mean: the names that the reference has, by every ending of their paths."""

    def __init__(self, env: BuildEnvironment) -> None:
        self.domain = env.domains["py"]
        self.paths: dict[str, set[str]] = {}
        for path, entry in self.domain.objects.items():
            if not entry.aliased:
                parts = path.split(".")
                for i in range(len(parts)):
                    self.paths.setdefault(".".join(parts[i:]), set()).add(path)

    def find(self, target: str, module: str) -> str | None:
        """The one name that a target can mean from inside a module; None where it is none, or not clear which."""
        target = target.removeprefix(f"{doors.ROOT}.") if target not in self.paths else target
        entry = self.domain.objects.get(f"{doors.ROOT}.{target}")
        if entry is not None:  # the canonical path of a name that a door shows
            return f"{doors.ROOT}.{target}"
        found = self.paths.get(target, set())
        if len(found) > 1:
            found = {path for path in found if path.startswith(f"{module}.")} or found
        if len(found) == 1:
            return next(iter(found))
        owner, dot, field = target.rpartition(".")
        if dot and not found and (path := self.find(owner, module)) and _has_field(path, field):
            return path
        return None


def _has_field(path: str, name: str) -> bool:
    """Whether a path is a dataclass with that field, which has no entry of its own: it is among the parameters."""
    module, _, last = path.rpartition(".")
    try:
        value = getattr(importlib.import_module(module), last, None)
    except ModuleNotFoundError:
        return False
    return dataclasses.is_dataclass(value) and name in {field.name for field in dataclasses.fields(value)}


def _is_ours(target: str) -> bool:
    """Whether a name, by its last part, is one of the package's, such as a class of a room or a type variable."""
    last = target.rpartition(".")[2]
    ours = [module for name, module in list(sys.modules.items()) if name.startswith(f"{doors.ROOT}.")]
    return any(hasattr(module, last) for module in ours)


def resolve(app: Sphinx, env: BuildEnvironment, node: Any, content: Any) -> nodes.Node | None:
    """Link a name of ours that Sphinx does not find by itself, since it is short or the name at another door.

    The type of a parameter that no door shows stands there without a link: a model's inner parts are nobody's to make.
    """
    if node.get("refdomain") != "py":
        return None
    names = getattr(env, "kinetograph_names", None)
    if names is None:
        names = env.kinetograph_names = Names(env)  # type: ignore[attr-defined]
    path = names.find(node["reftarget"], node.get("py:module") or "")
    if path is None:
        return content if node["reftype"] == "class" and _is_ours(node["reftarget"]) else None
    entry = names.domain.objects[path]
    return make_refnode(app.builder, node["refdoc"], entry.docname, entry.node_id, content, path)


def _forget(app: Sphinx, env: BuildEnvironment) -> None:
    env.kinetograph_names = None  # type: ignore[attr-defined]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # type: ignore[method-assign]  # as it is written
    app.connect("builder-inited", write_pages, priority=100)
    app.connect("env-updated", _forget)
    app.connect("autodoc-process-signature", tidy_signature)
    app.connect("missing-reference", resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
