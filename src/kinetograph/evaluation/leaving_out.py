"""Leaving one take out: the library is fitted once, and every held-out take is taken out of that fit.

Takes are held out one by one, in this process or in several, each a pure function of its name. One that cannot be
evaluated is named with its reason, and the others go on.
"""

from __future__ import annotations

import functools
import shutil
import threading
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

from kinetograph.errors import DataError, RequestError
from kinetograph.evaluation.recorded import Recorded
from kinetograph.left_out import by_reason, left_out_lines, shortened
from kinetograph.library import Library, Results, folders_of, full_names
from kinetograph.library.fingerprints import digest, state
from kinetograph.library.keeping import keeping_folder
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, fit_without
from kinetograph.methods.performance.fit import why_left
from kinetograph.pipeline import fit_performance
from kinetograph.progress import Progress
from kinetograph.work import HERE, Workers, in_shards, require_seen

FOLDER = "evaluating"
"""Where rows of an evaluation that has not ended are kept, among what is kept of the library."""

Without = Collection[str] | Mapping[str, Collection[str]]
"""Takes that are neither held out nor in the library; or by held-out take those that are not in its library."""
Row = TypeVar("Row")


@dataclass(frozen=True)
class Run:
    """How an evaluation is run.

    Parameters
    ----------
    only : tuple of str
        The takes to hold out; all of them where it is empty.
    workers : Workers
        Who evaluates. The rows are the same, but for the times that they give.
    goes_on : bool
        Whether rows are kept in the library's folder until the evaluation ends, so that one that was stopped goes on
        where it was.
    progress : Progress, optional
        Called with the takes done and their number.
    note : callable, optional
        Called with a line for each reason for which takes could not be evaluated.
    """

    only: tuple[str, ...] = ()
    workers: Workers = HERE
    goes_on: bool = False
    progress: Progress | None = None
    note: Callable[[str], None] | None = None


@dataclass(frozen=True)
class Held:
    """A take that is held out of a library.

    Parameters
    ----------
    library : Library
    content : str
        A digest of the library's takes.
    method : PerformanceControl
    track : str or None
        Name of the track to make.
    baselines : bool
        Whether simpler methods are compared.
    never : tuple of str
        Takes that are not used at all.
    take : str
    away : tuple of str
        Takes that are not in its library, besides.
    """

    library: Library
    content: str
    method: PerformanceControl
    track: str | None
    baselines: bool
    never: tuple[str, ...] = ()
    take: str = ""
    away: tuple[str, ...] = ()

    @property
    def excluded(self) -> tuple[str, ...]:
        """All takes that are not in its library."""
        return tuple(dict.fromkeys((self.take, *self.away, *self.never)))

    @property
    def whole(self) -> Whole:
        """The fit of the whole library; of one at a time, it is kept in this process."""
        named = replace(self, take="", away=(), baselines=False)
        folders = map(str, folders_of(self.library))
        return _whole(_Key(named, digest(*folders, self.content, state((self.method, self.track)), *self.never)))

    def model(self) -> PerformanceModel:
        """The model that is fitted to the others. Raises RequestError where none of them can be used."""
        whole = self.whole.model
        away = set(self.excluded) - set(self.never)
        try:
            return fit_without(whole, self.library, away, track=self.track, never=self.never)
        except RequestError as error:
            raise RequestError(f"nothing is left to make it of: {error}") from error


class Whole:
    """A library that is fitted once, of which takes are left out.

    Parameters
    ----------
    held : Held
        Of which the take does not count.
    """

    def __init__(self, held: Held) -> None:
        self._held, self._lock = held, threading.RLock()
        self.known: dict[str, Any] = {}

    @property
    def model(self) -> PerformanceModel:
        """The model of all takes; of a whole library it is kept beside it."""
        model: PerformanceModel = self.once("the model of all takes", self._fit)
        return model

    def _fit(self) -> PerformanceModel:
        held = self._held
        if held.never:
            return held.method.fit(held.library, exclude=held.never, track=held.track)
        return fit_performance(held.method, held.library, track=held.track)

    @cached_property
    def recorded(self) -> Recorded:
        """What its recordings do at most."""
        return Recorded(self.model.fitted.sources)

    @property
    def usable(self) -> tuple[str, ...]:
        """The takes with the joints that are used, whether or not they have cuts."""
        read = self.model.fitted.read
        return () if read is None else tuple(read.builds)

    def once(self, name: str, make: Callable[[], Any]) -> Any:
        """What ``make()`` returns, made once by this name, in whichever thread of a cluster's worker."""
        with self._lock:
            if name not in self.known:
                self.known[name] = make()
            return self.known[name]


@dataclass(frozen=True)
class _Key:
    """A library and method as they were when this was their digest."""

    held: Held = field(compare=False)
    digest: str


def _whole(key: _Key) -> Whole:
    with _WHOLES:  # two threads that ask for the first time get the same
        return _whole_of(key)


_WHOLES = threading.Lock()


@functools.lru_cache(maxsize=1)
def _whole_of(key: _Key) -> Whole:
    return Whole(key.held)


@dataclass(frozen=True)
class Outcome(Generic[Row]):
    """The rows of a held-out take, or why there are none.

    Parameters
    ----------
    rows : tuple
    why : str
    """

    rows: tuple[Row, ...]
    why: str = ""


def outcome(held: Held, rows: Callable[[Held], Iterable[Row]]) -> Outcome[Row]:
    """The rows of a held-out take, or why it cannot be evaluated."""
    require_seen(*folders_of(held.library))
    try:
        return Outcome(tuple(rows(held)))
    except (RequestError, DataError) as error:
        return Outcome((), why_left(held.take, error))


def hold_out(
    function: Callable[[Held], Outcome[Row]], held: Held, without: Without, run: Run | None = None
) -> list[Row]:
    """The rows of every held-out take.

    Parameters
    ----------
    function : callable
        At the top of a module: the outcome of one take.
    held : Held
        The library and the method.
    without : collection of str, or mapping of str to collection of str
    run : Run, optional

    Returns
    -------
    list

    Raises
    ------
    RequestError
        For a take that is not there, and where none can be evaluated.
    """
    run = run or Run()
    held = replace(held, never=() if isinstance(without, Mapping) else tuple(sorted(without)))
    names, failed = _evaluable(held, run.only)
    items = [replace(held, take=name, away=left_out_for(without, name)) for name in names]
    folder = _folder(held, run)
    store = None if folder is None else Results(folder)
    rows: list[Row] = []
    work = in_shards(function, items, run.workers, count=len(items), progress=run.progress, store=store)
    for item, one in zip(items, work, strict=True):
        rows += one.rows
        failed += [(item.take, one.why)] if one.why else []
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
    lines = list(left_out_lines(by_reason(failed)))
    if not rows:
        raise RequestError(f"no take can be evaluated; {'; '.join(lines) or 'the library has none'}")
    if run.note:
        for line in lines:
            run.note(line.replace("left out", "not evaluated", 1))
    return rows


def _folder(held: Held, run: Run) -> Path | None:
    """Where the rows of this evaluation are kept until it ends; None where they are not kept."""
    folder = keeping_folder(held.library) if run.goes_on else None
    return None if folder is None else folder / FOLDER / digest(state(held), *run.only)


def _evaluable(held: Held, only: tuple[str, ...]) -> tuple[list[str], list[tuple[str, str]]]:
    """The takes to hold out, and those that cannot be because nothing can be made of them, with why."""
    library = held.library
    wanted = full_names(library, only) or library.names()
    if unknown := sorted(set(wanted) - set(library.names())):
        raise RequestError(f"no take {unknown[0]!r} to hold out; there are {shortened(library.names()) or 'none'}")
    left = {name: why for why, names in held.whole.model.fitted.left_out.items() for name in names}
    names = [name for name in wanted if name not in held.never]
    return [name for name in names if name not in left], [(name, left[name]) for name in names if name in left]


def left_out_for(without: Without, name: str) -> tuple[str, ...]:
    """The takes that are not in the library of a held-out take besides those that are never used."""
    return tuple(without.get(name, ())) if isinstance(without, Mapping) else ()
