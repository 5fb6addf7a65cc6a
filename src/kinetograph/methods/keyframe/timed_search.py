"""The timed search: recordings are changed where poses and velocities meet, and every key is met exactly.

It goes over the recorded frames themselves, where the paper goes over clusters of them, so that keys can ask for times
and places.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.learn import Goal, Route, SearchOptions, Way, bar, discourage, find_route
from kinetograph.methods.everyday import everyday_frames
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.filler import Familiar, familiar, tolls_between
from kinetograph.methods.keyframe.index import PoseIndex, build_index
from kinetograph.methods.keyframe.key_goals import goals_of, require_time
from kinetograph.methods.keyframe.key_parts import SHAPE, Aim, aim_of
from kinetograph.methods.keyframe.named import named_frames
from kinetograph.methods.keyframe.quality import Quality
from kinetograph.methods.keyframe.realize import realize_route
from kinetograph.methods.keyframe.refusing import NoRouteError, solve_or_refuse
from kinetograph.post.assemble import PostSettings
from kinetograph.skeleton import same_shape
from kinetograph.synthesis import Synthesis

UNLIKE = 20.0
"""What a transition costs more in an alternative to a route that has one like it: a quarter of a metre's gap."""
AROUND = 0.5
"""Seconds within which two transitions are alike."""
PACE, ROTATION, WAY = 1.2, 1.8, 1.5
"""How people usually go to a place: metres and radians in a second, and what that costs."""
FAR = 0.15
"""Metres between a key and the nearest recorded frame above which a warning says so."""


@dataclass(frozen=True)
class TimedSearch:
    """Configuration of the timed search, the default solver.

    Parameters
    ----------
    meet : float
        Metres that poses and velocities may be apart where one recording is left for another.
    shortest : float
        Seconds that a recording is played at least.
    scale : float
        Metres of distance at a seam that cost 1.
    fee : float
        What every seam costs in addition.
    pose_scale : float
        Metres between a key and a recorded frame that cost 1.
    candidates : int
        Frames tried for a key.
    slack : float
        Metres by which a candidate may be further off than the nearest frame.
    warp : float
        Largest share by which the interval between two keys may be stretched or squeezed in time.
    longest : float
        Seconds of the longest interval between two keys.
    haste : float
        Cost of a second, where durations are free.
    beam : int
        States kept at each step.
    off_place, off_share : float
        Metres, and share of the distance between two pinned places, that a route may end away from a place before it is
        bent there.
    decay : float
        Seconds over which the edit that meets a key fades.
    begin_unasked, unasked : float
        Cost of beginning what neither of two keys asks for, and of a second of it, see
        ``kinetograph.methods.keyframe.filler``; 0 for both lets any recording fill in.
    moves : tuple of str
        What to go by in place of standing, walking and turning: names of takes, labels of moves and styles, words of
        these, or patterns. Other motion counts as unasked.
    without : tuple of str
        What not to use, named likewise.
    force_timing : bool
        Make a motion that is worse than the recordings all the same, with a warning, where there is no better one.

    Raises
    ------
    RequestError
        For a parameter out of its range.
    """

    meet: float = 0.65
    shortest: float = 0.3
    scale: float = 0.08
    fee: float = 0.5
    pose_scale: float = 0.08
    candidates: int = 96
    slack: float = 0.1
    warp: float = SearchOptions.warp
    longest: float = 12.0
    haste: float = 0.1
    beam: int = SearchOptions.beam
    off_place: float = 0.3
    off_share: float = 0.3
    decay: float = 0.5
    begin_unasked: float = 30.0
    unasked: float = 10.0
    moves: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    force_timing: bool = False

    def __post_init__(self) -> None:
        for name in ("meet", "shortest", "scale", "pose_scale", "longest", "decay"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise RequestError(f"{name} must be a positive number, found {getattr(self, name)}")
        if not 0 <= self.warp < 0.5:
            raise RequestError(f"warp is a share of the time from 0 to below 0.5, found {self.warp}")
        if not (self.begin_unasked >= 0 and self.unasked >= 0):
            raise RequestError(
                f"begin_unasked and unasked are costs of 0 or more, found {self.begin_unasked} and {self.unasked}"
            )
        if self.beam < 1 or self.candidates < 1:
            raise RequestError("expected a beam and candidates of 1 or more")

    def fit(self, examples: tuple[Example, ...], rng: np.random.Generator) -> FittedTimedSearch:
        """Build the index of the examples' frames; nothing is left to chance, and ``rng`` is not used.

        Raises
        ------
        RequestError
            For a move that nothing is called by, and where no frames are left.
        """
        index = build_index(examples, meet=self.meet, shortest=self.shortest, scale=self.scale, fee=self.fee)
        return self._of_index(examples, index)

    def refit(self, examples: tuple[Example, ...], fitted: FittedTimedSearch) -> FittedTimedSearch:
        """As `fit`, from what was fitted to the same examples before.

        Parameters
        ----------
        examples : tuple of Example
        fitted : FittedTimedSearch
            Its index is used again where it is the same, as it is for other moves.

        Returns
        -------
        FittedTimedSearch

        Raises
        ------
        RequestError
            As `fit`.
        """
        before = fitted.settings
        shared = all(getattr(self, name) == getattr(before, name) for name in ("meet", "shortest", "scale", "fee"))
        if not shared or before.without:
            return self.fit(examples, np.random.default_rng(0))
        if (self.moves, self.without) == (before.moves, before.without):
            return replace(fitted, settings=self)
        return self._of_index(examples, fitted.index)

    def everyday(self) -> TimedSearch:
        """The configuration of a fit that serves all moves: what is used again of it, and defaults for the rest."""
        return TimedSearch(meet=self.meet, shortest=self.shortest, scale=self.scale, fee=self.fee)

    def _of_index(self, examples: tuple[Example, ...], index: PoseIndex) -> FittedTimedSearch:
        barred = named_frames(examples, self.without)
        if barred.all():
            raise RequestError(f"without {', '.join(self.without)} nothing is left to use")
        index = replace(index, graph=bar(index.graph, barred), barred=barred) if barred.any() else index
        compared = self._familiar(examples, index)
        fitted = FittedTimedSearch(self, index, compared)
        # compiled kernels are loaded by their first call: not while someone waits for an answer
        fitted.goals((Aim(Key(examples[0].motion)),))
        goal, features = Goal(np.zeros(1, dtype=np.int64), np.zeros(1)), index.features
        find_route(index.graph, [goal, goal], features.ground, features.facing, SearchOptions(longest=0))
        return fitted

    def _familiar(self, examples: tuple[Example, ...], index: PoseIndex) -> Familiar:
        """How far the frames are from the moves that are asked for, or from everyday motion."""
        if self.moves:
            walking = running = named_frames(examples, self.moves)
        else:
            walking, running = (
                np.concatenate(parts)
                for parts in zip(*(everyday_frames(example.motion) for example in examples), strict=True)
            )
        free = ~index.barred
        return familiar(index.features.together(), index.graph.last, walking & free, running & free, index.fps)


@dataclass(frozen=True, eq=False)
class FittedTimedSearch:
    """The timed search over a library's examples.

    Parameters
    ----------
    settings : TimedSearch
    index : PoseIndex
        Features and transitions of every frame.
    familiar : Familiar
        How far every frame is from what needs no asking.
    """

    settings: TimedSearch
    index: PoseIndex
    familiar: Familiar

    @property
    def meets_times(self) -> bool:
        """True: keys are met at their times and places."""
        return True

    def solve(self, keys: tuple[Key, ...], count: int, post: PostSettings) -> tuple[Synthesis, ...]:
        """Motions from key to key, the best first; each avoids transitions like those before.

        Parameters
        ----------
        keys : tuple of Key
            Two or more, in order.
        count : int
            How many different motions to look for.
        post : PostSettings
            How the pieces are joined.

        Raises
        ------
        RequestError
            Where the times and places asked for leave none, or none that is not worse than the recordings, with the
            nearest that can be asked for.
        """
        return solve_or_refuse(self, keys, count, post)

    def motions(self, keys: tuple[Key, ...], post: PostSettings) -> Iterator[tuple[Synthesis, Quality]]:
        """Different motions from key to key, however good they are, the best first; each is made when it is asked for.

        Parameters
        ----------
        keys : tuple of Key
        post : PostSettings
            How the pieces are joined.

        Raises
        ------
        RequestError
            Where the times and places asked for leave none, with the reason.
        """
        settings = self.settings
        aims = self.aims(keys)
        goals, nearest = self.goals(aims)
        require_time(self.index, keys, goals, warp=settings.warp, longest=settings.longest, meet=settings.meet)
        warnings, number = _warnings(keys, nearest, self.index), -1
        for number, route in enumerate(self.routes(goals)):  # noqa: B007
            yield realize_route(self.index, aims, route, post, decay=settings.decay, warnings=warnings)
        if number < 0:
            raise NoRouteError(_no_route(keys))

    def aims(self, keys: tuple[Key, ...]) -> tuple[Aim, ...]:
        """What is to be met at each key."""
        return tuple(aim_of(key, self.index.skeleton, first=number == 0) for number, key in enumerate(keys))

    def goals(self, aims: tuple[Aim, ...]) -> tuple[list[Goal], list[float]]:
        """What keys ask of the search, and the metres between each and the recorded pose that is nearest to it."""
        settings = self.settings
        goals, nearest = goals_of(
            self.index,
            aims,
            candidates=settings.candidates,
            slack=settings.slack,
            scale=settings.pose_scale,
            reach=(settings.off_place, settings.off_share),
        )
        if settings.begin_unasked or settings.unasked:
            fees = (settings.begin_unasked, settings.unasked, self.index.fps)
            tolls = [tolls_between(self.familiar, a, b, *fees) for a, b in itertools.pairwise(goals)]
            goals = [goals[0], *(replace(goal, tolls=toll) for goal, toll in zip(goals[1:], tolls, strict=True))]
        return goals, nearest

    def routes(self, goals: list[Goal], haste: float | None = None) -> Iterator[Route]:
        """Different routes, the best first.

        Parameters
        ----------
        goals : list of Goal
        haste : float, optional
            Cost of a second, in place of that of the settings.
        """
        options, features, fps = self._options(goals), self.index.features, self.index.fps
        options = options if haste is None else replace(options, step_fee=haste / fps)
        graph, known = self.index.graph, list[Route]()
        while True:
            route = find_route(graph, goals, features.ground, features.facing, options)
            if route is None or route.segments in [other.segments for other in known]:
                return
            known.append(route)
            yield route
            used = np.array([segment.edge for segment in route.segments if segment.edge >= 0], dtype=np.int64)
            graph = discourage(graph, used, UNLIKE, round(AROUND * fps))

    def narrowed(self) -> FittedTimedSearch:
        """The same search with a quarter of the beam."""
        return replace(self, settings=replace(self.settings, beam=max(self.settings.beam // 4, 1)))

    def _options(self, goals: list[Goal]) -> SearchOptions:
        settings, fps = self.settings, self.index.fps
        free = any(goal.window[0] != goal.window[1] for goal in goals[1:])
        return SearchOptions(
            beam=settings.beam,
            warp=settings.warp,
            step_fee=settings.haste / fps if free else 0.0,
            longest=round(settings.longest * fps),
            speed=self.index.speed,
            way=Way(PACE / fps, ROTATION / fps, WAY / fps),
        )


def _no_route(keys: tuple[Key, ...]) -> str:
    pins = [key.label for key in keys[1:] if key.position is not None or key.heading is not None]
    what = f"the places of {', '.join(pins)} and the times" if pins else "the times"
    return (
        f"no route through the recordings meets {what} asked for; leave one of them free, give a window of time, "
        "or add recordings"
    )


def _warnings(keys: tuple[Key, ...], nearest: list[float], index: PoseIndex) -> tuple[str, ...]:
    """What a person should know of keys whose nearest recorded poses are so many metres away."""
    far = [
        f"{key.label}: the nearest recorded pose is {100 * gap:.0f} cm away; it is met by editing"
        for key, gap in zip(keys, nearest, strict=True)
        if gap > FAR
    ]
    foreign = [
        f"{key.label}: it has another skeleton; its pose is matched by role, not met joint by joint"
        for key in keys
        if not same_shape(key.clip.skeleton, index.skeleton, tolerance=SHAPE)
    ]
    return (*far, *foreign)
