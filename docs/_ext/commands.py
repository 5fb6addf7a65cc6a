"""The reference of the command line, as Markdown, from the commands' own help.

``python docs/_ext/commands.py`` prints it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

from typer.main import get_command

INTRODUCTION = """# Command line

`kinetograph --help` lists the commands, `kinetograph COMMAND --help` says what one does. Every command that prints a
table takes `--json`. The exit status is 0 where the work is done, 1 where it could not be done (one line on stderr
says why, and what to try), 2 where the command line is wrong. No file is overwritten without `--force`. This page is
made from the commands' own help.
"""


def reference() -> str:
    """The page."""
    parts = [INTRODUCTION, *(section(name, command) for name, command in every_command())]
    return "\n".join(parts).rstrip() + "\n"


def every_command() -> Iterator[tuple[str, Any]]:
    """Full names and commands, by name; groups are not among them."""
    from kinetograph.cli import app

    yield from _inside("kinetograph", get_command(app))


def _inside(name: str, command: Any) -> Iterator[tuple[str, Any]]:
    for sub in sorted(command.commands):
        inner = command.commands[sub]
        if getattr(inner, "commands", None):
            yield from _inside(f"{name} {sub}", inner)
        else:
            yield f"{name} {sub}", inner


def section(name: str, command: Any) -> str:
    """One command: what it does, its examples, and a table of its options for every group of them."""
    lines = [f"## {name}", "", *text_of(command)]
    groups: dict[str, list[Any]] = {}
    for parameter in options_of(command):
        groups.setdefault(getattr(parameter, "rich_help_panel", None) or "Options", []).append(parameter)
    for heading, parameters in groups.items():
        lines += ["", f"| {heading} | |", "|---|---|", *(f"| `{label(p)}` | {description(p)} |" for p in parameters)]
    return "\n".join([*lines, ""])


def text_of(command: Any) -> list[str]:
    """The paragraphs of a command's help, and its examples after them."""
    lines: list[str] = []
    shown: list[str] = []
    for block in (command.help or "").strip().split("\n\n"):
        before, *examples = " ".join(block.split()).split("Example: ")
        lines += [before.strip(), ""] if before.strip() else []
        shown += [f"$ {example.strip()}" for example in examples]
    return [*lines, "```console", *shown, "```", ""] if shown else lines


def examples_of(command: Any) -> list[str]:
    """The command lines that a command's help shows."""
    return [line.removeprefix("$ ") for line in text_of(command) if line.startswith("$ ")]


def options_of(command: Any) -> list[Any]:
    """Arguments and options, without ``--help``."""
    return [parameter for parameter in command.params if parameter.name != "help"]


def label(parameter: Any) -> str:
    """How a parameter is written: its metavar, or the option's names."""
    if parameter.param_type_name == "argument":
        return str(parameter.metavar or parameter.name.upper())
    return ", ".join((*parameter.opts, *parameter.secondary_opts))


def description(parameter: Any) -> str:
    """A parameter's help and its default."""
    text = str(getattr(parameter, "help", "") or "").replace("|", "\\|")
    default = parameter.default
    plain = parameter.param_type_name == "argument" or callable(default) or default in (None, False, True, ..., ())
    return text if plain else f"{text} Default: {default}."


if __name__ == "__main__":
    sys.stdout.write(reference())
