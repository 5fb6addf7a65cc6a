"""The page of tables and figures, next to the thesis' own numbers."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinetograph.evaluation.intervals import interval
from kinetograph.evaluation.reproduce.xie2009.figures import DRAWN, pose_picture, rms_picture
from kinetograph.evaluation.reproduce.xie2009.methods import LLE, PCA, TakeRow
from kinetograph.evaluation.reproduce.xie2009.strokes import CLIP
from kinetograph.methods.sensor import SensorControl
from kinetograph.sensing import GRAVITY

TABLE_7_1 = (
    ("basketball shot", 302, 0.41, 5.78),
    ("tennis forehand", 256, 0.21, 4.90),
    ("tennis backhand", 206, 0.40, 3.94),
    ("karate middle block", 160, 0.54, 3.07),
)
"""The thesis: action, frames, RMS and seconds, by PCA and interpolation."""
TABLE_7_2 = (("tennis forehand", 256, 0.062), ("tennis backhand", 206, 0.057))
"""The thesis: action, frames and RMS, by LLE and interpolation."""
FIGURE_7_5 = """The thesis, tennis backhand: on average 0.078 degrees per joint by PCA and 0.057 by LLE."""
SECTION_7_3 = """The thesis: interpolation has a serious jitter problem and takes 5.87 s for about 300 frames of a
basketball shot; optimisation is smooth in most cases and takes around 5 minutes for them. It gives neither accuracy nor
jitter of optimisation in numbers."""
NOT_COMPARABLE = """The RMS of equation 7.1 is over quaternion components here; the thesis names neither its angles
nor n, and gives the backhand by PCA as 0.40 in table 7.1 and 0.078 in figure 7.5. Its sensors are real and calibrated
by wearing them for the library as well; ours are simulated. Its test takes were captured together with its library.
Its tennis is forehands and backhands, ours, where there are any, serves: other strokes, by one player, few of them in
one recording of markers to which a body is fitted. Times are of other machines."""
_STYLE = "body{font:16px sans-serif;max-width:60em;margin:2em auto}td,th{padding:.2em .8em;text-align:left}"


@dataclass(frozen=True)
class ClipRow:
    """A stroke whose readings pass the device's range.

    Parameters
    ----------
    take, method : str
    most_g : float
        The most on any axis, in g.
    clipped : float
        Share of frames in which some axis clips.
    angle, wide : float
        The method's error in degrees, by the device and by one with a wider range.
    """

    take: str
    method: str
    most_g: float
    clipped: float
    angle: float
    wide: float


def page(rows: Sequence[TakeRow], clipping: Sequence[ClipRow], notes: Sequence[str]) -> str:
    """The whole page as HTML.

    Parameters
    ----------
    rows : sequence of TakeRow
    clipping : sequence of ClipRow
    notes : sequence of str
        On the tennis strokes.

    Returns
    -------
    str
    """
    takes = list(dict.fromkeys(row.take for row in rows))
    parts = [
        f"<!doctype html><meta charset='utf-8'><title>Xie 2009</title>\n<style>{_STYLE}</style>",
        "<h1>Xie 2009, chapter 7, on data at hand</h1>",
        *_tables(rows),
        "<h2>Tennis</h2>",
        *(f"<p>{html.escape(line)}" for line in notes),
        *_clip_table(clipping),
        f"<h2>Not comparable</h2><p>{NOT_COMPARABLE}",
        f"<h2>Figure 7.5: PCA and LLE</h2><p>{FIGURE_7_5}",
        *(_image(rms_picture(take)) for take in takes),
        "<h2>Figure 7.6: recorded and synthesised, side by side</h2>",
        *(_image(pose_picture(take, method)) for take in takes for method in DRAWN),
    ]
    return "\n".join(parts) + "\n"


def _tables(rows: Sequence[TakeRow]) -> list[str]:
    pca, lle = ([row for row in rows if row.method == method] for method in (PCA, LLE))
    return [
        "<h2>Table 7.1: PCA and interpolation</h2>",
        _table(("", "action", "frames", "RMS (7.1)", "seconds"), [
            *(("thesis", *line) for line in TABLE_7_1),
            *(("here", r.take, r.frames, f"{r.rms:.3f}", f"{r.seconds:.2f}") for r in pca),
        ]),
        "<h2>Table 7.2: LLE and interpolation</h2>",
        _table(("", "action", "frames", "RMS (7.1)"), [
            *(("thesis", *line) for line in TABLE_7_2),
            *(("here", r.take, r.frames, f"{r.rms:.3f}") for r in lle),
        ]),
        f"<h2>Section 7.3: interpolation and optimisation, without postprocessing</h2><p>{SECTION_7_3}",
        _table(("take", "method", "frames", "RMS (7.1)", "degrees", "by seed", "jitter over the source's", "seconds"), [
            (r.take, r.method, r.frames, f"{r.rms:.3f}", f"{r.angle:.2f}", f"{r.least:.2f} to {r.most:.2f}",
             f"{r.jitter:.2f}", f"{r.seconds:.2f}")
            for r in rows
        ]),
        "<p>Means over takes of one library, with the bootstrap's 95 % interval:",
        _table(("library", "method", "takes", "RMS (7.1)", "degrees", "jitter"), [
            (m["library"], m["method"], m["takes"], f"{m['rms']:.3f}", m["degrees"], f"{m['jitter']:.2f}")
            for m in means(rows)
        ]),
        "<p>The last method of each take minimises the same terms over later frames, and chooses clusters by density.",
    ]  # fmt: skip


def means(rows: Sequence[TakeRow]) -> list[dict[str, Any]]:
    """The means over the takes of a library, by method, where it has several takes.

    Parameters
    ----------
    rows : sequence of TakeRow

    Returns
    -------
    list of dict
    """
    alike: dict[tuple[str, str], list[TakeRow]] = {}
    for row in rows:
        alike.setdefault((row.library, row.method), []).append(row)
    return [
        {
            "library": library,
            "method": method,
            "takes": len(same),
            "rms": float(np.mean([row.rms for row in same])),
            "angle": float(np.mean([row.angle for row in same])),
            "degrees": str(interval([row.angle for row in same])),
            "jitter": float(np.mean([row.jitter for row in same])),
        }
        for (library, method), same in alike.items()
        if len(same) > 1
    ]


def _clip_table(rows: Sequence[ClipRow]) -> list[str]:
    if not rows:
        return []
    span = SensorControl().layout.device.span / GRAVITY
    header = ("take", "method", "most g", "frames that clip", f"degrees, {span:g} g", f"degrees, {CLIP * span:g} g")
    return [
        "<p>A library of their own, one stroke left out at a time, few as they are.",
        f"<p>Strokes pass the {span:g} g at which the device clips; so do the library's readings:",
        _table(header, [
            (r.take, r.method, f"{r.most_g:.1f}", f"{r.clipped:.0%}", f"{r.angle:.2f}", f"{r.wide:.2f}") for r in rows
        ]),
    ]  # fmt: skip


def _table(header: Sequence[str], lines: Sequence[Sequence[object]]) -> str:
    cells = [f"<tr>{''.join(f'<td>{html.escape(str(cell))}' for cell in line)}" for line in lines]
    return "\n".join([f"<table><tr>{''.join(f'<th>{html.escape(name)}' for name in header)}", *cells, "</table>"])


def _image(name: str) -> str:
    return f'<p><img src="{html.escape(name)}" width="900" alt="{html.escape(name)}">'
