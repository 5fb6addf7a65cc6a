"""Write what is generated in the docs: cli.md from the commands themselves, and the README's picture.

``python docs/build.py`` does both, ``python docs/build.py cli`` only the first.
"""

from __future__ import annotations

import sys
from pathlib import Path

from typer.main import get_command

DOCS = Path(__file__).parent


def cli_reference() -> str:
    """The command line as Markdown."""
    from kinetograph.cli import app

    command = get_command(app)
    parts = ["# Command line\n\nWritten by `make docs` from the commands' own help.\n"]
    parts += _sections(command, "kinetograph")
    return "\n".join(parts).rstrip() + "\n"


def _sections(command, name: str) -> list[str]:
    parts = []
    for sub in sorted(getattr(command, "commands", {})):
        parts += _section(command.commands[sub], f"{name} {sub}")
    return parts


def _section(command, name: str) -> list[str]:
    if getattr(command, "commands", None):
        return _sections(command, name)
    lines = [f"## {name}\n", _paragraphs(command.help or ""), "", "| | |", "|---|---|"]
    for parameter in command.params:
        if parameter.name == "help":
            continue
        argument = parameter.param_type_name == "argument"
        label = (parameter.metavar or parameter.name.upper()) if argument else ", ".join(parameter.opts)
        default = parameter.default
        shown = f" Default: {default}." if default not in (None, False, True, ..., ()) and not argument else ""
        text = (getattr(parameter, "help", "") or "").replace("|", "\\|")
        lines.append(f"| `{label}` | {text}{shown} |")
    return [*lines, ""]


def _paragraphs(text: str) -> str:
    blocks = [" ".join(block.split()) for block in text.strip().split("\n\n")]
    return "\n\n".join(f"    {b[9:]}" if b.startswith("Example: ") else b for b in blocks)


def picture() -> None:
    """The README's picture, from clips that are free to show (MIT)."""
    import tempfile

    from kinetograph.cli.demo import sample_library
    from kinetograph.drawing import strobe
    from kinetograph.methods.performance.model import PerformanceControl
    from kinetograph.motion import cut
    from kinetograph.pipeline import perform, winding_path

    with tempfile.TemporaryDirectory() as folder:
        library = sample_library(Path(folder) / "walks")
        result = perform(winding_path(), library, PerformanceControl(mirror=True))
    strobe(cut(result.motion, 160, 372), DOCS / "images" / "walk.png", poses=9)


if __name__ == "__main__":
    (DOCS / "cli.md").write_text(cli_reference())
    if sys.argv[1:] != ["cli"]:
        (DOCS / "images").mkdir(exist_ok=True)
        picture()
