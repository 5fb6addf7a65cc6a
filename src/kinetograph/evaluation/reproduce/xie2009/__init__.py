"""Xie 2009: tables 7.1 and 7.2 and figures 7.5 and 7.6, on a library at hand, as one page.

The thesis' recordings (5,082 frames of tennis, basketball, golf and karate with real Wii remotes) are not published.
Here the sensors are simulated, one take is left out at a time, and every number stands beside the thesis' own.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.reproduce.xie2009.strokes import CLIP, Strokes, find_strokes, wide_layout
from kinetograph.evaluation.sensor import Fold, folds, folds_of, normalised_rms, pose_errors, score, timed
from kinetograph.library import Library
from kinetograph.methods.sensor.local_models import LocalModels
from kinetograph.methods.sensor.model import LocalSettings, SensorControl, fit_examples
from kinetograph.motion import Motion
from kinetograph.sensing.layout import Layout
from kinetograph.sensing.readings import GRAVITY
from kinetograph.sensing.virtual import simulate, specific_force

Report = Callable[[str], None]
TABLE_7_1 = (
    ("basketball shot", 302, 0.41, 5.78),
    ("tennis forehand", 256, 0.21, 4.90),
    ("tennis backhand", 206, 0.40, 3.94),
    ("karate middle block", 160, 0.54, 3.07),
)
"""The thesis: action, frames, RMS and seconds, by PCA and interpolation."""
TABLE_7_2 = (("tennis forehand", 256, 0.062), ("tennis backhand", 206, 0.057))
"""The thesis: action, frames and RMS, by LLE and interpolation."""
FIGURE_7_5 = """The thesis, tennis backhand: on average 0.078 degrees a joint by PCA and 0.057 by LLE."""
SECTION_7_3 = """The thesis: interpolation has a serious jitter problem and takes 5.87 s for about 300 frames of a
basketball shot; optimisation is smooth in most cases and takes around 5 minutes for them. It tells neither accuracy nor
jitter of optimisation in numbers."""
PCA, LLE = "PCA, interpolation", "LLE, interpolation"
FRAME_BY_FRAME, AHEAD = "PCA, optimisation", "PCA, optimisation ahead"
METHODS = {
    PCA: ("interpolation", "pca", "mean", 0.0),
    LLE: ("interpolation", "lle", "mean", 0.0),
    FRAME_BY_FRAME: ("optimisation", "pca", "mean", 0.0),
    AHEAD: ("optimisation", "pca", "density", 0.15),
}
"""Synthesis, reduction, choice of the cluster, seconds looked ahead; the last is not the thesis' but the default."""
_STYLE = "body{font:16px sans-serif;max-width:60em;margin:2em auto}td,th{padding:.2em .8em;text-align:left}"
NOT_COMPARABLE = """The RMS of equation 7.1 is over quaternion components here; the thesis names neither its angles
nor n, and gives the backhand by PCA as 0.40 in table 7.1 and 0.078 in figure 7.5. Its sensors are real and calibrated
by wearing them for the library as well; ours are simulated. Its test takes were captured together with its library.
Its tennis is forehands and backhands, ours, where there are any, serves: other strokes, by one player, few of them in
one recording of markers to which a body is fitted. Times are of other machines."""
NO_SERVES = "Tennis is left out: no folder of C3D recordings was named (--serves)."


@dataclass(frozen=True)
class TakeRow:
    """One held-out take by one method: its normalised RMS (7.1), error in degrees, jitter over the source's,
    seconds.
    """

    take: str
    method: str
    frames: int
    rms: float
    angle: float
    jitter: float
    seconds: float


@dataclass(frozen=True)
class ClipRow:
    """A stroke whose readings pass the device's range: the most g on any axis, the share of frames in which some axis
    clips, and a method's error in degrees by the device and by one that reaches farther.
    """

    take: str
    method: str
    most_g: float
    clipped: float
    angle: float
    wide: float


def reproduce(
    output: str | Path, library: Library, *, takes: Sequence[str] = (), serves: str | Path | None = None,
    local: LocalSettings | None = None, report: Report = lambda text: None,
) -> list[TakeRow]:  # fmt: skip
    """Write ``index.html`` and its pictures to a new folder; the rows of its table.

    takes: to hold out, by default four that are spread over the library. serves: a folder of C3D files of markers;
    the strokes of each are a library of their own, one held out at a time, and what cannot be used is named on the
    page. Raises RequestError for a folder in use.
    """
    folder = Path(output)
    if folder.exists() and any(folder.iterdir()):
        raise RequestError(f"{folder} is not empty; name a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    names = library.names()
    held = tuple(takes) or tuple(names[i] for i in np.unique(np.linspace(0, len(names) - 1, 4).astype(int)))
    settings = local or LocalSettings()
    rows: list[TakeRow] = []
    for build in folds(library, SensorControl(), None, None, held):
        rows += _held_out(build(), settings, folder, report)
    strokes = Strokes({}, (NO_SERVES,)) if serves is None else find_strokes(serves)
    clipping: list[ClipRow] = []
    for motions in strokes.takes.values():
        wide = folds_of(motions, SensorControl(layout=wide_layout()))
        for build, build_wide in zip(folds_of(motions, SensorControl()), wide, strict=True):
            fold = build()
            mine = _held_out(fold, settings, folder, report)
            clipping += _clipping(fold, mine, _methods(build_wide(), settings, wide_layout()))
            rows += mine
    (folder / "index.html").write_text(_page(rows, clipping, strokes.notes), encoding="utf-8")
    return rows


def _held_out(fold: Fold, settings: LocalSettings, folder: Path, report: Report) -> list[TakeRow]:
    report(f"{fold.take}: {len(fold.truth)} frames")
    found = _methods(fold, settings, SensorControl().layout)
    _draw(fold, {name: motion for name, (_, motion) in found.items()}, folder)
    return [row for row, _ in found.values()]


def _clipping(fold: Fold, rows: Sequence[TakeRow], wide: dict[str, tuple[TakeRow, FloatArray]]) -> list[ClipRow]:
    layout = SensorControl().layout
    reach = np.abs(specific_force(fold.truth, layout)).max(axis=(1, 2))
    share = float(np.mean(reach > layout.device.span))
    most = float(reach.max()) / GRAVITY
    return [ClipRow(fold.take, row.method, most, share, row.angle, wide[row.method][0].angle) for row in rows]


def _methods(fold: Fold, settings: LocalSettings, layout: Layout) -> dict[str, tuple[TakeRow, FloatArray]]:
    """Rows and rotations of each of `METHODS`."""
    found = {}
    learnt: dict[tuple[str, str], LocalModels | None] = {}
    readings = simulate(fold.truth, layout, np.random.default_rng(0))
    for name, (synthesis, reduction, choice, ahead) in METHODS.items():
        # section 7.3 compares both without postprocessing
        local = replace(settings, reduction=reduction, choice=choice)
        method = SensorControl(layout=layout, synthesis=synthesis, local=local, smoothing="none", ahead=ahead)
        known = learnt.get((reduction, choice))
        model = fit_examples(method, fold.examples, np.random.default_rng(0), known)
        learnt[reduction, choice] = model.local
        rotations, times = timed(model, readings)
        row = score(name, "all", rotations, fold.truth)[0]
        told = TakeRow(fold.take, name, row.frames, row.rms, row.angle, row.jitter, float(np.sum(times)))
        found[name] = told, rotations
    return found


def _draw(fold: Fold, results: dict[str, FloatArray], folder: Path) -> None:
    """Figures 7.5 and 7.6: RMS by frame, and poses side by side with the recording's."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from kinetograph.drawing import contact_sheet

    figure = Figure(figsize=(9, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for name, rotations in results.items():
        frames = min(len(rotations), len(fold.truth))
        by_frame = [normalised_rms(rotations[i : i + 1], fold.truth.rotations[i : i + 1]) for i in range(frames)]
        axes.plot(np.arange(frames) / fold.truth.fps, by_frame, lw=1, label=name)
    axes.set(title=fold.take, xlabel="seconds", ylabel="normalised RMS (7.1)", ylim=(0, None))
    axes.legend(frameon=False)
    figure.savefig(folder / f"{fold.take}_rms.png", dpi=110)
    frames = min(len(fold.truth), *(len(r) for r in results.values()))
    truth = replace(fold.truth, translation=fold.truth.translation[:frames], rotations=fold.truth.rotations[:frames])
    for name in (PCA, FRAME_BY_FRAME, AHEAD):
        # the recording's root for both: figure 7.6 compares poses
        both = np.concatenate([truth.rotations[:, :1], results[name][:frames, 1:]], axis=1)
        result = Motion(truth.skeleton, truth.translation + np.array([1.2, 0, 0]), both, truth.fps)
        title = f"{fold.take}: recorded, and {name}, {float(pose_errors(both, truth.rotations).mean()):.1f} degrees"
        contact_sheet([truth, result], folder / _picture(fold.take, name), title=title, frames=12)


def _picture(take: str, method: str) -> str:
    return f"{take}_{method.split(', ')[1].replace(' ', '_')}.png"


def _page(rows: Sequence[TakeRow], clipping: Sequence[ClipRow], notes: Sequence[str]) -> str:
    takes = list(dict.fromkeys(row.take for row in rows))
    by = {(row.take, row.method): row for row in rows}
    pca, lle = ([by[take, method] for take in takes] for method in (PCA, LLE))
    parts = [
        f"<!doctype html><meta charset='utf-8'><title>Xie 2009</title>\n<style>{_STYLE}</style>",
        "<h1>Xie 2009, chapter 7, on data at hand</h1>",
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
        _table(("take", "method", "frames", "RMS (7.1)", "degrees", "jitter over the source's", "seconds"), [
            (r.take, r.method, r.frames, f"{r.rms:.3f}", f"{r.angle:.2f}", f"{r.jitter:.2f}", f"{r.seconds:.2f}")
            for r in rows
        ]),
        "<p>The last method of each take minimises the same terms over frames to come, and tells clusters by density.",
        "<h2>Tennis</h2>",
        *(f"<p>{html.escape(line)}" for line in notes),
        *_clip_table(clipping),
        f"<h2>Not comparable</h2><p>{NOT_COMPARABLE}",
        f"<h2>Figure 7.5: PCA and LLE</h2><p>{FIGURE_7_5}",
        *(_image(f"{take}_rms.png") for take in takes),
        "<h2>Figure 7.6: recorded and synthesised, side by side</h2>",
        *(_image(_picture(take, method)) for take in takes for method in (PCA, FRAME_BY_FRAME, AHEAD)),
    ]  # fmt: skip
    return "\n".join(parts) + "\n"


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
