"""Keyframe control: its configuration, and a library learned by it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key, check_order
from kinetograph.left_out import LeftOut
from kinetograph.library import Library
from kinetograph.methods.bodies import Bodies
from kinetograph.methods.keyframe.around import solve_around
from kinetograph.methods.keyframe.examples import Example, examples_of
from kinetograph.methods.keyframe.live import LiveKeys
from kinetograph.methods.keyframe.solver import FittedSolver, Solver
from kinetograph.methods.keyframe.timed_search import TimedSearch
from kinetograph.methods.recordings import gather
from kinetograph.post.assemble import PostSettings
from kinetograph.progress import Progress
from kinetograph.synthesis import Synthesis


@dataclass(frozen=True)
class KeyframeControl:
    """Configuration of keyframe control.

    Parameters
    ----------
    solver : TimedSearch or ClusterChain
        What leads from key to key: a search that meets every key at its time and place, or the paper's two levels.
    rate : float
        Frames per second of the examples and of the result.
    mirror : bool
        Also use every recording with left and right exchanged.
    post : PostSettings
        How the timed search's pieces are joined.
    bodies : Bodies
        Which skeleton is used of a library that has several.

    Raises
    ------
    RequestError
        For a solver that is none, or a rate that is not positive.

    Examples
    --------
    >>> KeyframeControl(solver=TimedSearch(meet=0.5)).solver.meet
    0.5
    """

    solver: Solver = field(default_factory=TimedSearch)
    rate: float = 30.0
    mirror: bool = False
    post: PostSettings = field(default_factory=PostSettings)
    bodies: Bodies = field(default_factory=Bodies)

    def __post_init__(self) -> None:
        if isinstance(self.solver, type) or not isinstance(self.solver, Solver):
            raise RequestError(f"solver must be TimedSearch(...) or ClusterChain(...), found {self.solver!r}")
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise RequestError(f"rate must be a positive number, found {self.rate}")

    def fit(
        self,
        library: Library,
        *,
        exclude: Iterable[str] = (),
        track: str | None = None,
        rng: np.random.Generator | None = None,
        progress: Progress | None = None,
    ) -> KeyframeModel:
        """Learn a library.

        Parameters
        ----------
        library : Library
        exclude : iterable of str
            Names of takes to leave out.
        track : str, optional
            Name of the motions' track; needed where takes have several motions.
        rng : numpy.random.Generator, optional
            Draws the first centres of the cluster chain's clusters; the same ones without it.
        progress : Progress, optional
            Called for every take that is read.

        Raises
        ------
        RequestError
            For a name to leave out that is not there, and for a library without takes to use.
        """
        gathered = gather(library, self.bodies, exclude=exclude, track=track, progress=progress)
        examples = examples_of(gathered.recordings, self.rate, mirror=self.mirror)
        fitted = self.solver.fit(examples, rng or np.random.default_rng(0))
        return KeyframeModel(self, examples, fitted, gathered.notes, gathered.left)


@dataclass(frozen=True, eq=False)
class KeyframeModel:
    """A library learned by one configuration.

    Parameters
    ----------
    method : KeyframeControl
    examples : tuple of Example
    fitted : FittedSolver
        What the method's solver learned of the examples.
    notes : tuple of str
        What a person should know of how the library was read.
    left_out : mapping of str to tuple of str
        Takes of the library that are not used, by reason.
    """

    method: KeyframeControl
    examples: tuple[Example, ...]
    fitted: FittedSolver
    notes: tuple[str, ...] = ()
    left_out: LeftOut = field(default_factory=dict)

    def synthesize(self, keys: Sequence[Key]) -> Synthesis:
        """A motion from key to key.

        Parameters
        ----------
        keys : sequence of Key
            Two or more, in order of time.

        Raises
        ------
        RequestError
            Where there is none, with the reason.
        """
        return self.alternatives(keys, 1)[0]

    def start(self, now: bool = True) -> LiveKeys:
        """Begin a live run: ``step(key)`` gives the frames up to it, ``finish()`` the whole.

        Parameters
        ----------
        now : bool
            Whether motion to each key is settled when the key is set; otherwise all keys are waited for.

        Returns
        -------
        LiveKeys

        Raises
        ------
        RequestError
            For a cluster chain, which meets no times.
        """
        if now and not self.fitted.meets_times:
            raise RequestError("the cluster chain needs all keys at once; use the timed search (--mode search)")
        return LiveKeys(self.synthesize, now)

    def alternatives(self, keys: Sequence[Key], count: int = 3) -> tuple[Synthesis, ...]:
        """Different motions from key to key, the best first; each avoids transitions like those of the ones before.

        Parameters
        ----------
        keys : sequence of Key
            Two or more, in order of time.
        count : int
            The most motions; there are fewer where no further one is different.

        Raises
        ------
        RequestError
            As `synthesize`, and for several motions of a cluster chain.
        """
        keys = tuple(keys)
        check_order(keys)
        return self.fitted.solve(keys, count, self.method.post)

    def synthesize_around(self, held: Synthesis, span: tuple[float, float], keys: Sequence[Key]) -> Synthesis:
        """A span of a result held, and the rest made anew through keys.

        Parameters
        ----------
        held : Synthesis
            A result of this model.
        span : tuple of float
            Seconds of the result from which and to which it is held.
        keys : sequence of Key
            Each with a time, before or after the span.

        Raises
        ------
        RequestError
            As `synthesize`, for a span outside the result or keys within it, and for a cluster chain.
        """
        return self.alternatives_around(held, span, keys, 1)[0]

    def alternatives_around(
        self, held: Synthesis, span: tuple[float, float], keys: Sequence[Key], count: int = 3
    ) -> tuple[Synthesis, ...]:
        """A span of a result held, and the rest made in different ways, the best first.

        Parameters
        ----------
        held : Synthesis
            A result of this model.
        span : tuple of float
            Seconds of the result from which and to which it is held.
        keys : sequence of Key
            Each with a time, before or after the span.
        count : int
            The most motions.

        Raises
        ------
        RequestError
            As `synthesize_around`.
        """
        if not self.fitted.meets_times:
            raise RequestError(
                "the cluster chain leaves times free; to hold a span use the timed search (--mode search)"
            )
        return solve_around(held, span, tuple(keys), lambda around: self.alternatives(around, count))
