"""Molina-Tanco & Hilton 2000: figures 2, 5, 6, 8 and 9, the numbers of section 4, and the next stage of section 5.

The paper's four recordings (standing up and then walking, running, walking and then running, walking; 465 frames) are
not published. CMU's that come nearest take their place where they are at hand (`ACTIONS`, 429 frames), else clips of
the sample (`CLIPS`).
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.keyframe import recorded_jumps, seam_jump
from kinetograph.evaluation.reproduce.molina_tanco2000 import figures
from kinetograph.formats import load
from kinetograph.keys import Key, key_at
from kinetograph.learn.kmeans import kmeans
from kinetograph.learn.reduction import fit_pca
from kinetograph.library import Library
from kinetograph.methods.keyframe.markov import PaperModel, PaperSettings, plan, pose_vectors
from kinetograph.methods.keyframe.model import KeyframeControl, KeyframeModel
from kinetograph.motion import Motion, cut, place
from kinetograph.samples import fetching as samples
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take

Report = Callable[[str], None]
ACTIONS = (("111_06", 240, 381), ("09_01", 0, 37), ("77_10", 180, 345), ("02_01", 0, 86))
"""Files of data/actions and their frames: standing up, running, setting off into a run, walking."""
CLIPS = (
    *("humanoid3d_getup_facedown", "humanoid3d_run", "humanoid3d_getup_faceup"),
    *("humanoid3d_walk", "humanoid3d_jump", "0walk_forward"),
)
SEEDS = 20
SIZES = tuple(range(5, 31, 5))
RUNS = 110


@dataclass(frozen=True)
class Numbers:
    """Section 4's numbers. seeds_solved: the share of K-means seeds for which the Markov chain has a path; share_at_15:
    of the variance, by 15 components.
    """

    examples_in_library: int
    frames_in_library: int
    dimensions: int
    components: int
    share: float
    share_at_15: float
    clusters: int
    seeds_solved: float
    clusters_passed: int
    frames: int
    examples_used: tuple[str, ...]
    seam_jump: float


@dataclass(frozen=True)
class Stage:
    """The next stage: a library of more examples. fit_seconds, pair_seconds: time; solved: share of the key pairs;
    examples_used: mean; seam_jump: median over pairs, over the recordings' 99th percentile.
    """

    examples: int
    frames: int
    clusters: int
    fit_seconds: float
    pair_seconds: float
    pairs: int
    solved: float
    examples_used: float
    seam_jump: float


def reproduce(folder: Path, data: Path | None = None, report: Report | None = None) -> dict[str, object]:
    """Write the figures and ``numbers.json`` to a folder; returns the numbers.

    data: a folder with ``actions/`` and, for the next stage, ``walks/`` and ``sports/``; None for the sample.
    """
    folder.mkdir(parents=True, exist_ok=True)
    say = report or (lambda text: None)
    library = Library.create(folder / "library")
    for take in _takes(data):
        library.add(take)
    names = library.names()
    keys = (_middle(library, names[0], 0.0), _middle(library, names[1], 0.5))
    model, solved = _first_solved(library, keys)
    result = model.synthesize(keys)
    numbers = _numbers(model, keys, result, solved)
    say(f"{numbers.clusters_passed} clusters, {numbers.frames} frames, {', '.join(numbers.examples_used)}")
    before, after = _two_facings(model)
    figures.draw_alignment(before, after, list(names), folder / "figure2.png")
    paper = _paper(model)
    figures.draw_space(paper.coordinates, list(names), folder / "figure5.png")
    figures.draw_errors(quantisation_errors(paper), folder / "figure6.png")
    path = paper.reduction.encode(pose_vectors(result.motion))
    figures.draw_space(paper.coordinates, list(names), folder / "figure8.png", result=path)
    _contact_sheet(result, folder / "figure9.png")
    found: dict[str, object] = {"section 4": asdict(numbers)}
    if data is not None:
        found["section 5"] = [asdict(stage) for stage in next_stage(folder, data, say)]
    (folder / "numbers.json").write_text(json.dumps(found, indent=1))
    return found


def _takes(data: Path | None) -> list[Take]:
    if data is not None:
        motions = [(name, load(data / "actions" / f"{name}.bvh").motion(), a, b) for name, a, b in ACTIONS]
        return [Take(name, {"motion": cut(motion, a, b)}) for name, motion, a, b in motions]
    clips = samples.where("deepmimic-clips") or samples.fetch("deepmimic-clips")
    loaded = [(name, load(clips / f"{name}.txt")) for name in CLIPS]
    return [Take(name.removeprefix("humanoid3d_"), take.tracks, take.annotations) for name, take in loaded]


def _middle(library: Library, name: str, share: float) -> Key:
    motion = library.take(name).motion()
    return key_at(motion, share * motion.duration, label=name)


def _paper(model: KeyframeModel) -> PaperModel:
    assert isinstance(model.learned, PaperModel)
    return model.learned


def _first_solved(library: Library, keys: tuple[Key, Key]) -> tuple[KeyframeModel, float]:
    """The model of the first seed whose chain leads from key to key, and the share of seeds that do."""
    solved: list[KeyframeModel] = []
    error: RequestError | None = None
    for seed in range(SEEDS):
        model = KeyframeControl(mode="paper").fit(library, rng=np.random.default_rng(seed))
        try:
            model.synthesize(keys)
            solved.append(model)
        except RequestError as refused:
            error = refused
    if not solved:
        assert error is not None
        raise error
    return solved[0], len(solved) / SEEDS


def _numbers(model: KeyframeModel, keys: tuple[Key, Key], result: Synthesis, solved: float) -> Numbers:
    paper = _paper(model)
    variances = paper.reduction.variances
    return Numbers(
        examples_in_library=len(model.examples),
        frames_in_library=sum(len(e.motion) for e in model.examples),
        dimensions=len(paper.reduction.mean),
        components=paper.reduction.dimensions,
        share=paper.reduction.share,
        share_at_15=float(variances[:15].sum() / variances.sum()),
        clusters=paper.settings.clusters,
        seeds_solved=solved,
        clusters_passed=len(plan(paper, *keys).clusters),
        frames=len(result.motion),
        examples_used=tuple(dict.fromkeys(piece.take for piece in result.pieces)),
        seam_jump=seam_jump(result, recorded_jumps(model.examples)),
    )


def quantisation_errors(paper: PaperModel) -> dict[int, list[float]]:
    """Accumulated errors by K, `RUNS` single runs of K-means shared among `SIZES`."""
    x = np.concatenate(paper.coordinates)
    rng = np.random.default_rng(0)
    sizes = [k for k in SIZES if k <= len(x)]
    return {k: [kmeans(x, k, rng, restarts=1).error for _ in range(RUNS // len(sizes))] for k in sizes}


def _two_facings(model: KeyframeModel) -> tuple[list[FloatArray], list[FloatArray]]:
    """The first two examples before and after alignment, each pair in components of its own.

    The second one is turned by a right angle first, as if it had been recorded facing there.
    """
    motions = [model.examples[0].motion, place(model.examples[1].motion, np.pi / 2, (0.0, 0.0, 0.0))]
    before = [rot.log(motion.rotations).reshape(len(motion), -1) for motion in motions]
    after = [pose_vectors(motion) for motion in motions]
    return _reduced(before), _reduced(after)


def _reduced(vectors: list[FloatArray]) -> list[FloatArray]:
    reduction = fit_pca(np.concatenate(vectors), 0.97)
    return [reduction.encode(v) for v in vectors]


def _contact_sheet(result: Synthesis, path: Path) -> None:
    from kinetograph.drawing.pictures import contact_sheet

    seams = [piece.start for piece in result.pieces[1:]]
    contact_sheet(result.motion, path, contacts=result.annotations, seams=seams, title="figure 9: the transition")


def next_stage(folder: Path, data: Path, say: Report) -> list[Stage]:
    """Section 5: the same with 50 and 100 examples, pieces of 4 s of recordings; K grows with their number."""
    pieces = _pieces(data)
    stages = []
    for count in (50, 100):
        if len(pieces) < count:
            break
        chosen = [pieces[i] for i in np.linspace(0, len(pieces) - 1, count).astype(int)]
        library = Library.create(folder / f"library{count}")
        for name, motion in chosen:
            library.add(Take(name, {"motion": motion}))
        stages.append(_judge_stage(library, clusters=count))
        say(f"{count} examples: {stages[-1]}")
    return stages


def _pieces(data: Path) -> list[tuple[str, Motion]]:
    files = [*sorted((data / "actions").glob("*.bvh")), *sorted((data / "walks").glob("15_*.bvh"))]
    found = []
    for file in files:
        motion = load(file).motion()
        length = int(4 * motion.fps)
        starts = range(0, max(len(motion) - length, 0) + 1, length)
        found += [(f"{file.stem}+{a}", cut(motion, a, min(a + length, len(motion)))) for a in starts]
    return found


def _judge_stage(library: Library, clusters: int, pairs: int = 60) -> Stage:
    began = time.perf_counter()
    method = KeyframeControl(mode="paper", paper=PaperSettings(clusters=clusters, restarts=3))
    model = method.fit(library)
    fitted = time.perf_counter()
    rng, names, recorded = np.random.default_rng(0), library.names(), recorded_jumps(model.examples)
    results = []
    for _ in range(pairs):
        a, b = (_middle(library, names[i], rng.random()) for i in rng.choice(len(names), 2, replace=False))
        try:
            results.append(model.synthesize([a, b]))
        except RequestError:
            continue
    taken = time.perf_counter() - fitted
    return Stage(
        examples=len(names),
        frames=sum(len(e.motion) for e in model.examples),
        clusters=clusters,
        fit_seconds=fitted - began,
        pair_seconds=taken / pairs,
        pairs=pairs,
        solved=len(results) / pairs,
        examples_used=float(np.mean([r.statistics["examples"] for r in results])) if results else 0.0,
        seam_jump=float(np.median([seam_jump(r, recorded) for r in results])) if results else 0.0,
    )
