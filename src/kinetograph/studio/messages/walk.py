"""What is said about walks."""

from __future__ import annotations

import msgspec

from kinetograph.studio.messages.frames import Message
from kinetograph.studio.messages.made import PieceRow
from kinetograph.studio.project import RuleRow


class AskPace(Message, frozen=True, tag="ask_pace"):
    """How fast are the library's people? Answered by `Pace`; its model is fitted by then."""

    id: int


class NextBest(Message, frozen=True, tag="next_best"):
    """What could take the place of the piece at a time of the walk? Answered by `Candidates`.

    Parameters
    ----------
    id : int
    time : float
        Seconds.
    count : int
        Others at most.
    """

    id: int
    time: float
    count: int = 4


class AskWhy(Message, frozen=True, tag="ask_why"):
    """Why is the piece at a time of the walk there, and what else could be? Answered by `Why`."""

    id: int
    time: float


class CandidateClip(Message, frozen=True, tag="candidate_clip"):
    """The walk as a clip under rules besides its own: those of a candidate."""

    id: int
    rules: tuple[RuleRow, ...]


class PieceSource(Message, frozen=True, tag="piece_source"):
    """The recording behind the piece at a time of the walk, placed where the piece is, as a clip."""

    id: int
    time: float


class PlayTake(Message, frozen=True, tag="play_take"):
    """A take of the library as a clip, at its own pace, from where the path begins."""

    id: int
    take: str


class WalkLive(Message, frozen=True, tag="walk_live"):
    """A person begins to draw: a body is to follow."""


class WalkDrawn(Message, frozen=True, tag="walk_drawn"):
    """Points that were drawn since the last: seconds, and metres x and z."""

    points: tuple[tuple[float, float, float], ...]


class TakePace(msgspec.Struct, frozen=True):
    """A take of a library: how long it is, and its mean speed over the ground, metres per second."""

    name: str
    seconds: float
    speed: float


class Pace(Message, frozen=True, tag="pace"):
    """How fast the library's people walk, metres per second.

    Parameters
    ----------
    id : int
    slowest, fastest : float
        Between which a path is walked at its own times.
    usual : tuple of float
        The 5th, 50th and 95th percentiles of the steps that were recorded.
    stands : bool
        Whether there is a pose to hold where a path stands still.
    takes : tuple of TakePace
    """

    id: int
    slowest: float
    fastest: float
    usual: tuple[float, float, float]
    stands: bool
    takes: tuple[TakePace, ...]


class CandidateRow(msgspec.Struct, frozen=True):
    """A piece that could be at a time of the walk, and what the best walk with it costs.

    Parameters
    ----------
    take : str
    mirrored : bool
    source_start, source_stop : float
        Seconds of the take.
    start, stop : float
        Seconds of the walk.
    cost, interpretation, continuity, reuse : float
        What the whole walk costs, and the terms that this is the sum of.
    more : float
        How much more than the walk with the first.
    rules : tuple of RuleRow
        Besides the walk's own, under which it is the best.
    """

    take: str
    mirrored: bool
    source_start: float
    source_stop: float
    start: float
    stop: float
    cost: float
    interpretation: float
    continuity: float
    reuse: float
    more: float
    rules: tuple[RuleRow, ...]


class Candidates(Message, frozen=True, tag="candidates"):
    """What could be at a time of the walk; the first is what is there."""

    id: int
    time: float
    rows: tuple[CandidateRow, ...]


class WhyRow(msgspec.Struct, frozen=True):
    """A piece that could be at a time of the walk, with what the best walk with it is charged for.

    Parameters
    ----------
    take : str
    mirrored, chosen : bool
        Whether left and right are exchanged; whether it is there.
    source_start, source_stop : float
        Seconds of the take.
    start, stop : float
        Seconds of the walk.
    margin : float
        What the best walk with it costs above the optimum, reuse being free.
    terms : dict of str to float
        See `kinetograph.methods.performance.PieceTerms`.
    without : tuple of str
        The constraints and costs of which each one, taken away, would put it there.
    """

    take: str
    mirrored: bool
    chosen: bool
    source_start: float
    source_stop: float
    start: float
    stop: float
    margin: float
    terms: dict[str, float]
    without: tuple[str, ...]


class WithoutRow(msgspec.Struct, frozen=True):
    """What would be at a time of the walk without a constraint or a cost, and how much less the walk would cost."""

    constraint: str
    take: str
    mirrored: bool
    source_start: float
    source_stop: float
    saved: float


class Why(Message, frozen=True, tag="why"):
    """Why a piece is there: those with the least margins, and what would have to go for another to be there.

    Parameters
    ----------
    id : int
    time : float
        Seconds of the walk.
    rows : tuple of WhyRow
    without : tuple of WithoutRow
    span : (float, float), optional
        Seconds of a span that is filled around keys; there are no rows then.
    played : tuple of PieceRow
        The recordings of the span.
    layers : tuple of str
        What drives parts of the body.
    """

    id: int
    time: float
    rows: tuple[WhyRow, ...]
    without: tuple[WithoutRow, ...]
    span: tuple[float, float] | None = None
    played: tuple[PieceRow, ...] = ()
    layers: tuple[str, ...] = ()
