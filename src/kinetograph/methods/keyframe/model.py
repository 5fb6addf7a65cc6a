"""Keyframe control: a motion from pose to pose, made of recordings (Molina-Tanco & Hilton 2000, and beyond).

Two modes with one interface. ``"paper"`` is the paper: clusters of poses, their Markov chain, and an HMM whose hidden
states are the examples. ``"search"`` goes over the frames themselves: it meets every key exactly, at the time and
place asked for, and changes recordings only where poses and velocities meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key, check_order
from kinetograph.methods.keyframe.around import solve_around
from kinetograph.methods.keyframe.examples import Example, collect_examples
from kinetograph.methods.keyframe.markov import PaperModel, PaperSettings, fit_paper, plan
from kinetograph.methods.keyframe.markov_motion import realize_paper
from kinetograph.methods.keyframe.realize import realize_walk
from kinetograph.methods.keyframe.search import SearchModel, SearchSettings, check_feasible, fit_search, goals_of, solve
from kinetograph.post.assemble import PostSettings
from kinetograph.skeleton import same_shape
from kinetograph.synthesis import Synthesis

if TYPE_CHECKING:
    from kinetograph.library import Library

__all__ = ["KeyframeControl", "KeyframeModel", "PaperSettings", "SearchSettings"]

MODES = ("search", "paper")
FAR = 0.15
"""Metres between a key and the nearest recorded frame above which a warning says so."""


@dataclass(frozen=True)
class KeyframeControl:
    """Configuration of keyframe control.

    mode: ``"search"`` or ``"paper"``. rate: frames a second of the examples and of the result. mirror: also use every
    recording mirrored. search, paper: parameters of either mode. post: how the search's pieces are joined.
    """

    mode: str = "search"
    rate: float = 30.0
    mirror: bool = False
    search: SearchSettings = field(default_factory=SearchSettings)
    paper: PaperSettings = field(default_factory=PaperSettings)
    post: PostSettings = field(default_factory=PostSettings)

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise RequestError(f"mode must be one of {', '.join(MODES)}, found {self.mode!r}")
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise RequestError(f"rate must be a positive number, found {self.rate}")

    def fit(
        self,
        library: Library,
        *,
        exclude: tuple[str, ...] = (),
        track: str | None = None,
        rng: np.random.Generator | None = None,
    ) -> KeyframeModel:
        """Learn a library. ``exclude`` leaves takes out, by name; ``rng`` seeds the clusters of the paper's mode.

        Raises RequestError for an empty library, or where takes have different joints.
        """
        examples = collect_examples(library, self.rate, mirror=self.mirror, exclude=exclude, track=track)
        if self.mode == "paper":
            return KeyframeModel(self, examples, fit_paper(examples, self.paper, rng or np.random.default_rng(0)))
        return KeyframeModel(self, examples, fit_search(examples, self.search))


@dataclass(frozen=True, eq=False)
class KeyframeModel:
    """A library made ready for one configuration."""

    method: KeyframeControl
    examples: tuple[Example, ...]
    learned: PaperModel | SearchModel

    def synthesize(self, keys: Sequence[Key]) -> Synthesis:
        """A motion from key to key. Raises RequestError where there is none, with the reason."""
        keys = tuple(keys)
        check_order(keys)
        if isinstance(self.learned, PaperModel):
            if len(keys) != 2:
                raise RequestError(f"the paper's mode goes between two keys, found {len(keys)}; use mode search")
            return realize_paper(self.learned, plan(self.learned, keys[0], keys[1]), (keys[0], keys[1]))
        return self._search(self.learned, keys, 1)[0]

    def alternatives(self, keys: Sequence[Key], count: int = 3) -> tuple[Synthesis, ...]:
        """Up to ``count`` different motions from key to key, the best first; each avoids the others' transitions.

        There are fewer where no further one is different. Raises RequestError as `synthesize`, and in the paper's mode.
        """
        keys = tuple(keys)
        check_order(keys)
        if isinstance(self.learned, PaperModel):
            raise RequestError("the paper's mode has one answer; alternatives are of mode search")
        return self._search(self.learned, keys, count)

    def synthesize_around(self, kept: Synthesis, span: tuple[float, float], keys: Sequence[Key]) -> Synthesis:
        """A result held from second to second, and the rest made anew through keys, every one with a time.

        Raises RequestError as `synthesize`, and for a span outside the result or keys within it.
        """
        return solve_around(kept, span, tuple(keys), self.synthesize)

    def _search(self, learned: SearchModel, keys: tuple[Key, ...], count: int) -> tuple[Synthesis, ...]:
        goals, nearest = goals_of(learned, keys)
        check_feasible(learned, keys, goals)
        walks = solve(learned, keys, goals, count)
        notes = _notes(learned, keys, nearest)
        return tuple(realize_walk(learned, keys, walk, self.method.post, notes) for walk in walks)


def _notes(model: SearchModel, keys: tuple[Key, ...], nearest: list[float]) -> tuple[str, ...]:
    notes = [
        f"{key.label}: the nearest recorded pose is {100 * gap:.0f} cm away; it is met by editing"
        for key, gap in zip(keys, nearest, strict=True)
        if gap > FAR
    ]
    skeleton = model.examples[0].motion.skeleton
    notes += [
        f"{key.label}: it has another skeleton; its pose is matched by role, not met joint by joint"
        for key in keys
        if not same_shape(key.clip.skeleton, skeleton, tolerance=0.02)
    ]
    return tuple(notes)
