"""Section 5's next stage: the paper's solver on databases of 50 and 100 examples."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.evaluation.keyframe import key_miss, recorded_jumps, seam_jump
from kinetograph.evaluation.reproduce.molina_tanco2000.database import LONGEST, actions, key_within
from kinetograph.keys import Key
from kinetograph.library import Library
from kinetograph.methods.keyframe import ClusterChain, KeyframeControl, KeyframeModel
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take

SIZES = (50, 100)
"""Numbers of examples."""
PAIRS = 60
"""Random pairs of keys."""


@dataclass(frozen=True)
class Stage:
    """Figures of a database of more examples.

    Parameters
    ----------
    examples, frames : int
    clusters : int
        K.
    fit_seconds : float
        Processor time to learn the database.
    pair_seconds : float
        Processor time for one pair of keys.
    pairs : int
    solved : float
        Share of the pairs.
    examples_used : float
        Mean over the results.
    seam_jump : float
        Median over the results, see ``kinetograph.evaluation.keyframe.seam_jump``.
    worst_miss_mm : float
        Of all results, the furthest that a key is from the result, in millimetres.
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
    worst_miss_mm: float


def next_stage(folder: Path, data: Path, say: Callable[[str], None]) -> list[Stage]:
    """The same with more examples, each a whole recording of one action; K is their number.

    Parameters
    ----------
    folder : Path
        Where libraries are made.
    data : Path
        A folder with ``actions/`` and ``corpus/``; a stage for which it has too few recordings is left out.
    say : callable
        Called with one line about each stage.
    """
    named = actions(data)
    stages = []
    for count in SIZES:
        if len(named) < count:
            say(f"{count} examples: left out, {data} has {len(named)} recordings of at most {LONGEST:g} s")
            continue
        library = Library.create(folder / f"library{count}")
        for i in np.linspace(0, len(named) - 1, count).astype(int):
            name, motion = named[i]
            library.add(Take(name, {"motion": motion}))
        stages.append(_judge(library, clusters=count))
        say(f"{count} examples: {stages[-1]}")
    return stages


def _judge(library: Library, clusters: int) -> Stage:
    began = time.process_time()
    model = KeyframeControl(solver=ClusterChain(clusters=clusters, restarts=3)).fit(library)
    fitted = time.process_time()
    results = _random_pairs(library, model)
    taken = time.process_time() - fitted
    recorded = recorded_jumps(model.examples)
    made = [result for result, _ in results]
    return Stage(
        examples=len(model.examples),
        frames=sum(len(e.motion) for e in model.examples),
        clusters=clusters,
        fit_seconds=fitted - began,
        pair_seconds=taken / PAIRS,
        pairs=PAIRS,
        solved=len(made) / PAIRS,
        examples_used=float(np.mean([r.statistics["examples"] for r in made])) if made else np.nan,
        seam_jump=float(np.median([seam_jump(r, recorded) for r in made])) if made else np.nan,
        worst_miss_mm=max((_worst_miss(*pair) for pair in results), default=np.nan),
    )


def _worst_miss(result: Synthesis, keys: list[Key]) -> float:
    """Millimetres between the keys and the result, rounded to what arithmetic can tell."""
    frames = (0, len(result.motion) - 1)
    return round(1000 * max(key_miss(result, k, f) for k, f in zip(keys, frames, strict=True)), 6)


def _random_pairs(library: Library, model: KeyframeModel) -> list[tuple[Synthesis, list[Key]]]:
    """The pairs that are solved: random frames of two examples each."""
    rng, names = np.random.default_rng(0), library.names()
    results = []
    for _ in range(PAIRS):
        keys = [key_within(library, names[i], rng.random()) for i in rng.choice(len(names), 2, replace=False)]
        try:
            results.append((model.synthesize(keys), keys))
        except RequestError:
            continue
    return results
