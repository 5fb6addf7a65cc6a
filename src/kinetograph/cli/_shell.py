"""What every command shares: the terminal, progress, tables, errors."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from kinetograph.errors import RequestError
from kinetograph.progress import Progress

Units = Annotated[str | None, typer.Option(help="A file's unit of length: metre, centimetre, inch, ...")]
Up = Annotated[str | None, typer.Option(help="The file's upward axis: x, y or z.")]
Fps = Annotated[float | None, typer.Option(help="Frames a second, in place of the file's own.")]
Lenient = Annotated[bool, typer.Option("--lenient", help="Take what can be read of a damaged file.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object for machines instead of a table.")]
LibraryFolder = Annotated[Path, typer.Option("-l", "--library", help="The library's folder.")]


def note(text: str) -> None:
    """Say something on stderr, where it does not mix with results."""
    sys.stderr.write(f"{text}\n")


def result(values: dict[str, Any], as_json: bool, title: str = "") -> None:
    """End a command: a short table of names and values, or one JSON object."""
    if as_json:
        sys.stdout.write(json.dumps(values, default=str) + "\n")
        return
    rows = [(name.replace("_", " "), shown(value)) for name, value in values.items()]
    width = max((len(name) for name, _ in rows), default=0)
    if title:
        sys.stdout.write(f"{title}\n")
    for name, value in rows:
        sys.stdout.write(f"  {name:<{width}}  {value}\n")


def table(rows: Sequence[dict[str, Any]], as_json: bool, title: str = "") -> None:
    """End a command: rows of like columns, or one JSON array."""
    if as_json:
        sys.stdout.write(json.dumps(list(rows), default=str) + "\n")
        return
    if title:
        sys.stdout.write(f"{title}\n")
    if not rows:
        sys.stdout.write("  (nothing)\n")
        return
    columns = list(rows[0])
    cells = [[c.replace("_", " ") for c in columns], *([shown(row[c]) for c in columns] for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(columns))]
    for line in cells:
        sys.stdout.write("  " + "  ".join(f"{cell:<{w}}" for cell, w in zip(line, widths, strict=True)).rstrip() + "\n")


def shown(value: Any) -> str:
    """A value as a person reads it."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(shown(v) for v in value)
    return str(value)


@contextmanager
def progress_bar(label: str) -> Iterator[Progress]:
    """A callback of (done, total) that draws a bar on stderr, once work has taken a second and if a person looks on."""
    if not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import Progress as Bar

    began = time.monotonic()
    bar = Bar(console=Console(stderr=True), transient=True)
    task = bar.add_task(label, total=None)

    def update(done: int, total: int) -> None:
        if time.monotonic() - began > 1.0 and not bar.live.is_started:
            bar.start()
        bar.update(task, completed=done, total=total)

    try:
        yield update
    finally:
        bar.stop()


def announce_compilation() -> None:
    """Say that the kernels are about to be compiled, where no compiled copy of them is on disk."""
    from kinetograph.learn import _kernels

    cache = Path(str(_kernels.extend.stats.cache_path))
    source = Path(_kernels.__file__).stat().st_mtime
    copies = list(cache.glob("_kernels.extend-*.nbi"))
    if not any(copy.stat().st_mtime >= source for copy in copies):
        note("compiling the search for this processor, once (a few seconds)")


def parse_roles(given: Sequence[str] | None) -> dict[str, str]:
    """``role=joint`` options as a table. Raises RequestError."""
    roles = {}
    for item in given or ():
        role, separator, joint = item.partition("=")
        if not separator or not joint:
            raise RequestError(f"--role takes role=joint, as in left_toe=LeftToeBase; found {item!r}")
        roles[role.strip()] = joint.strip()
    return roles


def refuse_existing(paths: Sequence[Path], force: bool) -> None:
    """Raise RequestError, before any work is done, where an output exists and may not be overwritten."""
    for path in paths:
        if path.exists() and not force:
            raise RequestError(f"{path} exists; give --force to overwrite it, or another name")
        if not path.parent.is_dir():
            raise RequestError(f"{path}: the folder {path.parent} does not exist; make it first")


def numbered(path: Path, number: int) -> Path:
    """The file of one of several motions: the first has the name that was given."""
    return path if number == 1 else path.with_stem(f"{path.stem}_{number}")


def refuse_unknown_formats(outputs: Sequence[Path]) -> None:
    """Raise RequestError, before any work is done, where no writer knows an output's suffix."""
    from kinetograph.formats import WRITERS

    for path in outputs:
        if path.suffix.lower() not in WRITERS:
            known = ", ".join(sorted(WRITERS))
            raise RequestError(f"{path}: cannot write files of kind {path.suffix!r}; expected one of {known}")
