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
from kinetograph.evaluation.sensor import Fold, folds, normalised_rms, pose_errors, score, timed
from kinetograph.library import Library
from kinetograph.methods._sensor_local import LocalModels
from kinetograph.methods.sensor import LocalSettings, SensorControl, fit_examples
from kinetograph.motion import Motion
from kinetograph.sensing.virtual import simulate

Report = Callable[[str], None]
THESIS = """Table 7.1, PCA and interpolation: basketball shot 302 frames 0.41 in 5.78 s; tennis forehand 256, 0.21,
4.90 s; tennis backhand 206, 0.40, 3.94 s; middle block 160, 0.54, 3.07 s. Table 7.2, LLE: forehand 0.062, backhand
0.057. Figure 7.5, backhand: PCA 0.078, LLE 0.057 degrees a joint. Section 7.3: 300 frames take interpolation 5.87 s and
optimisation about 5 minutes, and interpolation has a serious jitter problem."""
_STYLE = "body{font:16px sans-serif;max-width:60em;margin:2em auto}td,th{padding:.2em .8em;text-align:left}"
NOT_COMPARABLE = """The RMS of equation 7.1 is over quaternion components here; the thesis names neither its angles
nor n, and gives the backhand by PCA as 0.40 in table 7.1 and 0.078 in figure 7.5. Its sensors are real and calibrated
by wearing them for the library as well; ours are simulated. Its test takes were captured together with its library.
Times are of other machines."""


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


def reproduce(
    output: str | Path, library: Library, *, takes: Sequence[str] = (), local: LocalSettings | None = None,
    report: Report = lambda text: None,
) -> list[TakeRow]:  # fmt: skip
    """Write ``index.html`` and its pictures to a new folder; the rows of its table.

    takes: to hold out, by default four that are spread over the library. Raises RequestError for a folder in use.
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
        fold = build()
        report(f"{fold.take}: {len(fold.truth)} frames")
        found = _methods(fold, settings)
        rows += [row for row, _ in found.values()]
        _draw(fold, {name: motion for name, (_, motion) in found.items()}, folder)
    (folder / "index.html").write_text(_page(rows, [row.take for row in rows[::3]]), encoding="utf-8")
    return rows


def _methods(fold: Fold, settings: LocalSettings) -> dict[str, tuple[TakeRow, FloatArray]]:
    """Rows and rotations of interpolation by PCA and by LLE, and of optimisation by PCA."""
    found = {}
    learnt: dict[str, LocalModels] = {}
    readings = simulate(fold.truth, SensorControl().layout, np.random.default_rng(0))
    for name, synthesis, reduction in (
        ("PCA, interpolation", "interpolation", "pca"),
        ("LLE, interpolation", "interpolation", "lle"),
        ("PCA, optimisation", "optimisation", "pca"),
    ):
        # section 7.3 compares both without postprocessing
        method = SensorControl(synthesis=synthesis, local=replace(settings, reduction=reduction), smoothing="none")
        model = fit_examples(method, fold.examples, np.random.default_rng(0), learnt.get(reduction))
        if model.local is not None:
            learnt[reduction] = model.local
        rotations, times = timed(model, readings)
        row = score(name, "all", rotations, fold.truth)[0]
        told = TakeRow(fold.take, name, row.frames, row.rms, row.angle, row.jitter, float(np.sum(times)))
        found[name] = told, rotations
    return found


def _draw(fold: Fold, results: dict[str, FloatArray], folder: Path) -> None:
    """Figures 7.5 and 7.6: RMS by frame, and poses side by side with the recording's."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from kinetograph.pictures import contact_sheet

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
    for name in ("PCA, interpolation", "PCA, optimisation"):
        # the recording's root for both: figure 7.6 compares poses
        both = np.concatenate([truth.rotations[:, :1], results[name][:frames, 1:]], axis=1)
        result = Motion(truth.skeleton, truth.translation + np.array([1.2, 0, 0]), both, truth.fps)
        title = f"{fold.take}: recorded, and {name}, {float(pose_errors(both, truth.rotations).mean()):.1f} degrees"
        contact_sheet([truth, result], folder / _picture(fold.take, name), title=title, frames=12)


def _picture(take: str, method: str) -> str:
    return f"{take}_{method.split(', ')[1]}.png"


def _page(rows: Sequence[TakeRow], takes: Sequence[str]) -> str:
    cells = "".join(
        f"<tr><td>{html.escape(r.take)}<td>{r.method}<td>{r.frames}<td>{r.rms:.3f}<td>{r.angle:.2f}<td>{r.jitter:.2f}"
        f"<td>{r.seconds:.2f}\n"
        for r in rows
    )
    pictures = "".join(
        f"<h3>{html.escape(take)}</h3>\n"
        + "".join(
            f'<p><img src="{html.escape(name)}" width="900" alt="{html.escape(name)}">\n'
            for name in (f"{take}_rms.png", _picture(take, ", interpolation"), _picture(take, ", optimisation"))
        )
        for take in takes
    )
    return (
        f"<!doctype html><meta charset='utf-8'><title>Xie 2009</title>\n<style>{_STYLE}</style>\n"
        "<h1>Xie 2009, chapter 7, on data at hand</h1>\n"
        "<table><tr><th>take<th>method<th>frames<th>RMS (7.1)<th>degrees<th>jitter<th>seconds\n"
        f"{cells}</table>\n<h2>The thesis</h2><p>{THESIS}\n<h2>Not comparable</h2><p>{NOT_COMPARABLE}\n"
        f"<h2>Figures 7.5 and 7.6</h2>\n{pictures}"
    )
