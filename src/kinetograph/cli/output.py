"""What commands say and write: notes, tables, progress, and the files of a synthesis."""

from __future__ import annotations

import json
import math
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinetograph.cli.options import Written, numbered
from kinetograph.errors import ExistsError, RequestError
from kinetograph.progress import Progress

if TYPE_CHECKING:
    from kinetograph.motion import Motion
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Synthesis


# ---- what is said ----


def note(text: str) -> None:
    """Say something on stderr, where it does not mix with results."""
    sys.stderr.write(f"{text}\n")


def notes(texts: Iterable[str], about: object = None) -> None:
    """Say several things, each after the name of what it is about, if any."""
    for text in texts:
        note(text if about is None else f"{about}: {text}")


def result(values: dict[str, Any], as_json: bool, title: str = "") -> None:
    """End a command: a short table of names and values, or one JSON object."""
    if as_json:
        sys.stdout.write(_json(values))
        return
    rows = [(name.replace("_", " "), shown(value)) for name, value in values.items()]
    width = max((len(name) for name, _ in rows), default=0)
    if title:
        sys.stdout.write(f"{title}\n")
    for name, value in rows:
        sys.stdout.write(f"  {name:<{width}}  {value}\n")


def _json(values: Any) -> str:
    """A line of JSON; null for numbers that are not finite, which it has no words for."""
    return json.dumps(_finite(values), default=str, allow_nan=False) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def table(rows: Sequence[dict[str, Any]], as_json: bool, title: str = "") -> None:
    """End a command: rows that have the same columns, or one JSON array."""
    if as_json:
        sys.stdout.write(_json(list(rows)))
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
    """A value as text for people.

    >>> shown([0.123456, "walk"])
    '0.1235, walk'
    """
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(shown(v) for v in value)
    return str(value)


_MOST = 10  # groups that people are shown


def grouped(why: Mapping[str, str], what: str) -> list[str]:
    """Lines on things and the reason that each has, of which many have the same one; the most frequent first.

    >>> grouped({"a": "it is 1 s long", "b": "it is 2 s long", "c": "damaged"}, "not cut")
    ['2 not cut: it is 1 s long: a, b', '1 not cut: damaged: c']
    """
    groups: dict[str, tuple[str, list[str]]] = {}
    for name, reason in why.items():
        groups.setdefault(without_numbers(reason), (reason, []))[1].append(name)
    ordered = sorted(groups.values(), key=lambda group: -len(group[1]))
    lines = [f"{len(names)} {what}: {reason}: {first_of(names)}" for reason, names in ordered[:_MOST]]
    rest = sum(len(names) for _, names in ordered[_MOST:])
    return [*lines, f"{rest} {what} for other reasons; --json lists all"] if rest else lines


def without_numbers(text: str) -> str:
    """A text that is the same for texts that differ in numbers only."""
    return re.sub(r"[0-9][0-9.,:]*", "0", text)


def first_of(names: Sequence[str], most: int = 3) -> str:
    """The first of many names.

    >>> first_of(["a", "b", "c", "d"])
    'a, b, c and 1 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


@contextmanager
def progress_bar(label: str) -> Iterator[Progress]:
    """A callback of (done, total) that draws a bar on stderr, after a second of work and only on a terminal."""
    with detailed_bar(label) as update:
        yield lambda done, total: update(done, total, "")


@contextmanager
def detailed_bar(label: str) -> Iterator[Callable[[int, int, str], None]]:
    """The same with a text after the bar; the time that is left is shown, too."""
    if not sys.stderr.isatty():
        yield lambda done, total, text: None
        return
    from rich.console import Console
    from rich.progress import Progress as Bar
    from rich.progress import TextColumn

    began = time.monotonic()
    columns = (*Bar.get_default_columns(), TextColumn("{task.fields[text]}"))
    bar = Bar(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(label, total=None, text="")

    def update(done: int, total: int, text: str) -> None:
        if time.monotonic() - began > 1.0 and not bar.live.is_started:
            bar.start()
        bar.update(task, completed=done, total=total, text=text)

    try:
        yield update
    finally:
        bar.stop()


# ---- what is written ----


def refuse_existing(paths: Iterable[Path], force: bool) -> None:
    """Raise RequestError, before any work is done, where an output exists and may not be overwritten."""
    for path in paths:
        if path.exists() and not force:
            raise ExistsError(f"{path} exists; give --force to overwrite it, or another name")
        if not path.parent.is_dir():
            raise RequestError(f"{path}: the folder {path.parent} does not exist; make it first")


def refuse_unknown_formats(outputs: Iterable[Path]) -> None:
    """Raise RequestError, before any work is done, where no writer knows an output's suffix."""
    from kinetograph.formats import WRITERS

    for path in outputs:
        if path.suffix.lower() not in WRITERS:
            known = ", ".join(sorted(WRITERS))
            raise RequestError(f"{path}: cannot write files of kind {path.suffix!r}; expected one of {known}")


def write_text(text: str, path: Path, force: bool) -> None:
    """Write a file, whole or not at all."""
    from kinetograph.formats.atomic import atomic_path

    with atomic_path(path, force=force) as draft:
        draft.write_text(text)


def write_synthesis(
    synthesis: Synthesis,
    written: Written,
    control: Signal | Motion | None,
    title: str,
    number: int = 1,
    more: Mapping[str, object] | None = None,
) -> None:
    """The motion in every format that was asked for, its picture and its report.

    Parameters
    ----------
    synthesis : Synthesis
        What is written.
    written : Written
        Where to.
    control : Signal, Motion or None
        What the picture shows besides.
    title : str
        The picture's title.
    number : int
        Which of several syntheses it is, from 1.
    more : mapping of str to object, optional
        What the report says besides.
    """
    from kinetograph.drawing import draw_synthesis
    from kinetograph.formats import save, together, write_report

    with together():
        for path in written.output:
            save(synthesis.motion, numbered(path, number), force=written.force)
        if written.picture:
            draw_synthesis(synthesis, numbered(written.picture, number), control, title)
        if written.report:
            write_report(synthesis, numbered(written.report, number), force=written.force, more=more)


SHOWN = ("gap", "handhold", "constraints", "most_used", "times_running")
"""How the names of the statistics begin that end a command."""


def summarize(synthesis: Synthesis) -> dict[str, Any]:
    """The figures of a synthesis that end a command."""
    takes = {piece.take for piece in synthesis.pieces}
    return {
        "seconds": synthesis.motion.duration,
        "frames": len(synthesis.motion),
        "pieces": len(synthesis.pieces),
        "takes_used": len(takes),
        "cost": synthesis.cost,
        **({"optimal": bool(synthesis.statistics["optimal"])} if "optimal" in synthesis.statistics else {}),
        **{name: value for name, value in synthesis.statistics.items() if name.startswith(SHOWN)},
        **{f"cost_of_{name}": value for name, value in synthesis.costs.items()},
    }


def left_out(synthesis: Synthesis, as_json: bool) -> dict[str, Any]:
    """All takes that a synthesis leaves out, by reason, where a machine reads it; people get a line for each reason."""
    listed = {why: list(takes) for why, takes in synthesis.left_out.items()}
    return {"left_out": listed} if as_json and listed else {}
