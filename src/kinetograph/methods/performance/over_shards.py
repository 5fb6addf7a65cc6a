"""The model of a library in shards, or in ranges of takes: a control becomes a motion, and recordings stay."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.left_out import together
from kinetograph.library import Library, Shards, contents
from kinetograph.methods.bodies import choose_takes, notes_on
from kinetograph.methods.performance.control import Control, read_control, walkable
from kinetograph.methods.performance.control_points import GroundPath
from kinetograph.methods.performance.fitted import Fitted, fitted_for
from kinetograph.methods.performance.realization import realize
from kinetograph.methods.performance.rules import Rule
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.sharded import ShardedFit, fit_shards
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take
from kinetograph.work import HERE, Workers, hands


@dataclass(frozen=True, eq=False)
class ShardedModel:
    """Libraries made ready for one configuration, each in a process of its own.

    Parameters
    ----------
    sharded : ShardedFit
    """

    sharded: ShardedFit

    @property
    def fitted(self) -> Fitted:
        """What the shards have told; it holds no recordings."""
        return self.sharded.fitted

    @property
    def method(self) -> PerformanceSettings:
        """The configuration that was fitted."""
        return self.fitted.settings

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know of how the libraries were read."""
        return self.fitted.notes

    def holding(self, takes: Iterable[str]) -> ShardedModel:
        """The same with the recordings of some takes."""
        return replace(self, sharded=replace(self.sharded, fitted=self.sharded.with_takes(takes)))

    def read(self, control: Take | Signal | Motion) -> Control:
        """See `PerformanceModel.read`. Raises RequestError for handholds that the control names."""
        read = read_control(self.method, control)
        if read.handholds:
            raise RequestError("handholds that the control names need all recordings at once: use one library")
        drawn = read.partner is None and isinstance(self.method.control_points, GroundPath)
        return walkable(read, self.fitted.fastest) if drawn and not self.method.keep_time else read

    def interpret(
        self, control: Control | Signal | Motion, progress: Progress | None = None, rules: Sequence[Rule] = ()
    ) -> SegmentalPath:
        """The best sequence of segments of all shards; see `PerformanceModel.interpret`."""
        read = control if isinstance(control, Control) else self.read(control)
        sharded = replace(self.sharded, fitted=fitted_for(self.sharded.fitted, read))
        return sharded.interpret(at_rate(read.points, read.fps, self.method.rate), progress, rules)

    def synthesize(
        self, control: Take | Signal | Motion, progress: Progress | None = None, rules: Sequence[Rule] = ()
    ) -> Synthesis:
        """A motion that performs a control; see `PerformanceModel.synthesize`.

        Parameters
        ----------
        control : Take or Signal or Motion
        progress : Progress, optional
            Called with the steps done and their number.
        rules : sequence of Rule
            What is pinned or forbidden.

        Returns
        -------
        Synthesis

        Raises
        ------
        RequestError
            As `PerformanceModel.synthesize` does.
        """
        read = self.read(control)
        path = self.interpret(read, progress, rules)
        return realize(fitted_for(self.sharded.with_recordings(path), read), read, path)


@contextmanager
def over_shards(
    method: PerformanceSettings,
    library: Library,
    workers: Workers | Executor = HERE,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
) -> Iterator[ShardedModel]:
    """Fit a method to a library in shards, each in a process of its own for the block.

    Parameters
    ----------
    method : PerformanceSettings
    library : Library
        Shards, or one library, which is divided into ranges of takes, one for each who works; they read its folder.
    workers : Workers or Executor
        With fewer processes than shards, one holds several.
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the track to make.

    Yields
    ------
    ShardedModel

    Raises
    ------
    RequestError
        For a name to leave out that is not there, and where no take has a segment.
    """
    chosen = choose_takes(library, method.bodies, exclude=exclude, track=track)
    if chosen.others:
        raise RequestError(
            f"{len(chosen.others)} takes of other skeletons would be brought over, which shards do not; "
            "leave them out, or retarget them before they are added"
        )
    libraries, names = _divided(library, chosen.names, workers)
    with fit_shards(method, libraries, workers, names=names, track=track) as sharded:
        fitted = sharded.fitted
        told = (*notes_on(chosen.left), *fitted.notes)
        whole = replace(fitted, notes=told, left_out=together(chosen.left, fitted.left_out))
        yield ShardedModel(replace(sharded, fitted=whole))


def _divided(
    library: Library, taken: Sequence[str], workers: Workers | Executor
) -> tuple[list[Library], list[dict[str, str]]]:
    """Libraries, and of each the takes that are used, by their names there their names here."""
    if isinstance(library, Shards):
        wanted = set(taken)
        names = [{own: name for own, name in part.items() if name in wanted} for part in library.parts]
        return list(library.libraries), names
    seconds = dict.fromkeys(taken, 0.0)
    for track in contents(library):
        if track.take in seconds:
            seconds[track.take] += track.duration
    ranges = [part for part in ranges_of(list(seconds.values()), hands(workers)) if part]
    return [library] * len(ranges), [{taken[i]: taken[i] for i in part} for part in ranges]


def ranges_of(sizes: Sequence[float], count: int) -> list[range]:
    """Neighbours together, in so many ranges of about the same size; some may be empty.

    >>> ranges_of([1.0, 1.0, 1.0, 3.0], 2)
    [range(0, 3), range(3, 4)]
    """
    middles = np.cumsum(sizes) - 0.5 * np.asarray(sizes)
    borders = np.searchsorted(middles, np.arange(1, count) * sum(sizes) / count)
    edges = [0, *borders.tolist(), len(sizes)]
    return [range(low, high) for low, high in itertools.pairwise(edges)]
