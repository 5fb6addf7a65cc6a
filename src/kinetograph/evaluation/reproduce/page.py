"""A page in one file: headings, paragraphs, tables, and pictures as part of it."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Value = str | float | int | None
"""A cell of a table."""
DASH = "-"
"""Is printed for what is not a number."""
_STYLE = """body{font:16px/1.45 sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:1em 0}.wide{overflow-x:auto}
td,th{padding:.2em .6em;font-size:15px;text-align:right;border-bottom:1px solid #ddd}
.text{text-align:left;white-space:nowrap}
th{white-space:normal!important;border-bottom:2px solid #888;vertical-align:bottom}
caption{text-align:left;font-weight:bold;padding:.3em 0}img{max-width:100%;height:auto}
h2{margin-top:2.2em;border-top:1px solid #bbb;padding-top:.6em}
.paper{color:#7a3b00}.missing{background:#fff3d6;padding:.4em .8em}"""


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Parameters
    ----------
    title : str
        Its heading.
    parts : tuple of str
        Its pieces of HTML.
    numbers : mapping
        The numbers that are printed in it.
    """

    title: str
    parts: tuple[str, ...] = ()
    numbers: Mapping[str, object] = field(default_factory=dict)


def page(title: str, sections: Sequence[Section]) -> str:
    """The whole document, as HTML."""
    body = "\n".join(
        f'<h2 id="{_anchor(s.title)}">{html.escape(s.title)}</h2>\n' + "\n".join(s.parts) for s in sections
    )
    contents = " · ".join(f'<a href="#{_anchor(s.title)}">{html.escape(s.title)}</a>' for s in sections)
    return (
        f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n<h1>{html.escape(title)}</h1>\n<p>{contents}</p>\n{body}\n</html>\n"
    )


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph of plain text; ``kind`` is ``"paper"`` for what the paper says, ``"missing"`` for what is missing."""
    flowing = html.escape(" ".join(text.split()))
    return f'<p class="{kind}">{flowing}</p>' if kind else f"<p>{flowing}</p>"


def bullets(items: Sequence[str]) -> str:
    """A list of plain texts."""
    return "<ul>" + "".join(f"<li>{html.escape(item)}</li>" for item in items) + "</ul>"


def table(caption: str, columns: Sequence[str], rows: Sequence[Sequence[Value]]) -> str:
    """A table.

    Parameters
    ----------
    caption : str
    columns : sequence of str
    rows : sequence of sequence
        Numbers are printed as `shown` does; columns that hold only texts are aligned to the left.

    Returns
    -------
    str
        HTML.
    """
    kinds = [' class="text"' if all(isinstance(row[i], str) for row in rows) else "" for i in range(len(columns))]
    head = "".join(f"<th{kind}>{html.escape(column)}" for kind, column in zip(kinds, columns, strict=True))
    body = "\n".join(
        "<tr>" + "".join(f"<td{kind}>{html.escape(shown(value))}" for kind, value in zip(kinds, row, strict=True))
        for row in rows
    )
    inner = f"<caption>{html.escape(caption)}</caption>\n<tr>{head}\n{body}\n"
    return f'<div class="wide"><table>{inner}</table></div>'


def records(columns: Sequence[str], rows: Sequence[Sequence[Value]]) -> list[dict[str, Value]]:
    """The rows of a table as dictionaries by column."""
    return [dict(zip(columns, row, strict=True)) for row in rows]


def shown(value: Value) -> str:
    """A value as it is printed: three digits, more where the number has more before its point."""
    if value is None or (isinstance(value, float) and value != value):
        return DASH
    if not isinstance(value, float):
        return str(value)
    if abs(value) >= 100:
        return f"{value:.0f}"
    return f"{value:.3g}"


def with_recorded(ours: float, recorded: float) -> str:
    """A figure, and that of the recording in brackets."""
    return DASH if ours != ours else f"{shown(ours)} ({shown(recorded)})"


def picture(figure: Figure, caption: str) -> str:
    """A matplotlib figure, inside the page."""
    stream = io.BytesIO()
    figure.savefig(stream, dpi=100, format="png")
    return _image(stream.getvalue(), caption)


def drawn(draw: Callable[[Path], object], caption: str) -> str:
    """What ``draw`` writes to the path of a ``.png``, inside the page."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        draw(path)
        return _image(path.read_bytes(), caption)


def _image(data: bytes, caption: str) -> str:
    text = html.escape(caption)
    encoded = base64.b64encode(data).decode("ascii")
    return f'<figure><img alt="{text}" src="data:image/png;base64,{encoded}"><figcaption>{text}</figcaption></figure>'


def _anchor(title: str) -> str:
    return "".join(c if c.isalnum() else "-" for c in title.lower())
