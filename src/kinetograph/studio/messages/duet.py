"""What is said about duets."""

from __future__ import annotations

import msgspec

from kinetograph.studio.messages.frames import Message


class AskLeaders(Message, frozen=True, tag="ask_leaders"):
    """Ask for the takes that can lead a duet: of a library, the project's unless given."""

    id: int
    library: str | None = None


class AskLeader(Message, frozen=True, tag="ask_leader"):
    """Ask who the leader of the project is."""

    id: int


class ShowLeader(Message, frozen=True, tag="show_leader"):
    """Ask for the leader of the project as a clip."""

    id: int


class AskHands(Message, frozen=True, tag="ask_hands"):
    """Ask which hands of the follower that was made last hold which of the leader's."""

    id: int


class Transcribe(Message, frozen=True, tag="transcribe"):
    """Ask for the moves of the follower that was made last."""

    id: int


class Rehearse(Message, frozen=True, tag="rehearse"):
    """Let the leader of the project dance now, and the follower answer live.

    Parameters
    ----------
    lag : float
        Seconds after which motion is decided.
    """

    lag: float = 0.5


class LeaderRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A take that can lead, and the people in it who can."""

    take: str
    seconds: float
    persons: tuple[str, ...]


class LeaderTakes(Message, frozen=True, tag="leader_takes"):
    """The takes of a library that can lead.

    Parameters
    ----------
    id : int
    library : str
    takes : tuple of LeaderRow
    target : str
        The track that is made unless another is named.
    targets : tuple of str
        The tracks that can be made.
    advice : str
        What to do where there is none.
    """

    id: int
    library: str
    takes: tuple[LeaderRow, ...] = ()
    target: str = ""
    targets: tuple[str, ...] = ()
    advice: str = ""


class LeaderFacts(Message, frozen=True, tag="leader_facts"):
    """The leader of the project.

    Parameters
    ----------
    id : int
    name : str
        Of the take or the file.
    seconds : float
    person : str
        Who of ``persons`` leads.
    persons : tuple of str
    truth : bool
        Whether the one who followed is known.
    notes : tuple of str
        What was guessed.
    """

    id: int
    name: str
    seconds: float
    person: str
    persons: tuple[str, ...] = ()
    truth: bool = False
    notes: tuple[str, ...] = ()


class HandsRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """Hands that hold each other: the joints, as the bodies that are shown call them.

    Parameters
    ----------
    start, stop : float
    own, theirs : str
        The follower's joint, and the leader's.
    met : bool
        Whether they are as near as hands that hold each other.
    """

    start: float
    stop: float
    own: str
    theirs: str
    met: bool = True


class Hands(Message, frozen=True, tag="hands"):
    """The handholds of the follower and the leader."""

    id: int
    holds: tuple[HandsRow, ...] = ()


class MoveRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A move of a transcript.

    Parameters
    ----------
    move : str
        Empty where the recordings name none.
    start, stop : float
    margin : float, optional
        What the best interpretation without it costs more, as a share; None where there is no other.
    notation : str
        The move in the thesis' symbols.
    """

    move: str
    start: float
    stop: float
    margin: float | None = None
    notation: str = ""


class Transcribed(Message, frozen=True, tag="transcribed"):
    """The moves of the follower in order, or what to do to have them."""

    id: int
    moves: tuple[MoveRow, ...] = ()
    advice: str = ""


class Rehearsed(Message, frozen=True, tag="rehearsed"):
    """How a rehearsal goes.

    Parameters
    ----------
    second : float
        Where the leader is now.
    seconds : float
        How long the leader dances.
    lag : float
        Seconds by which the follower shown is behind the leader.
    load : float
        Seconds of work for a second of dance; above 1, the leader has to wait.
    running : bool
        False at its end.
    error : float, optional
        Centimetres: at the end, the mean distance of joints from the recorded follower's.
    """

    second: float
    seconds: float
    lag: float
    load: float = 0.0
    running: bool = True
    error: float | None = None
