"""The model of a library in shards: a control becomes a motion, and recordings stay where they are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, replace

from kinetograph.errors import RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.left_out import together
from kinetograph.library import Shards
from kinetograph.methods.bodies import choose_takes, notes_on
from kinetograph.methods.performance.control import Control, read_control, walkable
from kinetograph.methods.performance.control_points import GroundPath
from kinetograph.methods.performance.fitted import Fitted
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
from kinetograph.work import HERE, Workers


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
        return self.sharded.interpret(at_rate(read.points, read.fps, self.method.rate), progress, rules)

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
        return realize(self.sharded.with_recordings(path), read, path)


@contextmanager
def over_shards(
    method: PerformanceSettings,
    libraries: Shards,
    workers: Workers | Executor = HERE,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
) -> Iterator[ShardedModel]:
    """Fit a method to libraries in shards, each in a process of its own for the block.

    Parameters
    ----------
    method : PerformanceSettings
    libraries : Shards
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
    chosen = choose_takes(libraries, method.bodies, exclude=exclude, track=track)
    if chosen.others:
        raise RequestError(
            f"{len(chosen.others)} takes of other skeletons would be brought over, which shards do not; "
            "leave them out, or retarget them before they are added"
        )
    taken = set(chosen.names)
    names = [{own: name for own, name in part.items() if name in taken} for part in libraries.parts]
    with fit_shards(method, libraries.libraries, workers, names=names, track=track) as sharded:
        fitted = sharded.fitted
        told = (*notes_on(chosen.left), *fitted.notes)
        whole = replace(fitted, notes=told, left_out=together(chosen.left, fitted.left_out))
        yield ShardedModel(replace(sharded, fitted=whole))
