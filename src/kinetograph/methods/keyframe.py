"""Keyframe control: a motion from pose to pose, made of recordings (Molina-Tanco & Hilton 2000, and beyond).

Two modes with one interface. ``"paper"`` is the paper: clusters of poses, their Markov chain, and an HMM whose hidden
states are the examples. ``"search"`` goes over the frames themselves: it meets every key exactly, at the time and
place asked for, and changes recordings only where poses and velocities meet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key, check_order
from kinetograph.methods._examples import Example, collect_examples
from kinetograph.methods._paper_model import PaperModel, PaperSettings, fit_paper, plan
from kinetograph.methods._paper_motion import realize_paper
from kinetograph.synthesis import Synthesis

if TYPE_CHECKING:
    from kinetograph.library import Library

Progress = Callable[[int, int], None]
MODES = ("search", "paper")


@dataclass(frozen=True)
class KeyframeControl:
    """Configuration of keyframe control.

    mode: ``"search"`` or ``"paper"``. rate: frames a second of the examples and of the result. mirror: also use every
    recording mirrored. paper: parameters of the paper's mode.
    """

    mode: str = "search"
    rate: float = 30.0
    mirror: bool = False
    paper: PaperSettings = field(default_factory=PaperSettings)

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
        rng = rng or np.random.default_rng(0)
        return KeyframeModel(self, examples, fit_paper(examples, self.paper, rng))


@dataclass(frozen=True, eq=False)
class KeyframeModel:
    """A library made ready for one configuration."""

    method: KeyframeControl
    examples: tuple[Example, ...]
    learned: PaperModel

    def synthesize(self, keys: Sequence[Key], progress: Progress | None = None) -> Synthesis:
        """A motion from key to key. Raises RequestError where there is none, with the reason."""
        keys = tuple(keys)
        check_order(keys)
        if len(keys) != 2:
            raise RequestError(f"the paper's mode goes between two keys, found {len(keys)}; use mode search")
        return realize_paper(self.learned, plan(self.learned, keys[0], keys[1]), (keys[0], keys[1]))
