"""The section duet: a leader, a take or a file, is answered by a follower made of the other takes of a library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from kinetograph.errors import RequestError
from kinetograph.library import Library, contents
from kinetograph.methods.performance import PerformanceModel, PointsByRole, Rule, partner_control, require_moves
from kinetograph.pipeline import perform_with
from kinetograph.progress import Progress
from kinetograph.segmentation import notation
from kinetograph.stopping import stoppable
from kinetograph.studio.duet.comparing import compared, held_by_others, measured
from kinetograph.studio.duet.leading import (
    Leader,
    couples,
    leader_of,
    leading_tracks,
    left_out,
    library_of,
    target_of,
)
from kinetograph.studio.floor import floor_of
from kinetograph.studio.made import Made, bodies, clip
from kinetograph.studio.messages import (
    AskHands,
    AskLeader,
    AskLeaders,
    ClipHeader,
    Hands,
    HandsRow,
    LeaderFacts,
    LeaderRow,
    LeaderTakes,
    Message,
    MoveRow,
    ShowLeader,
    Transcribe,
    Transcribed,
    blob,
)
from kinetograph.studio.project import Duet, Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Answer


@dataclass(frozen=True, eq=False)
class Dance:
    """What a duet asks for, read.

    Parameters
    ----------
    duet : Duet
    library : Library
    target : str
        The track that is made.
    leader : Leader
    """

    duet: Duet
    library: Library
    target: str
    leader: Leader

    @classmethod
    def of(cls, project: Project, room: Room) -> Dance:
        """The dance of a project that has a leader. Raises what `leader_of` and `library_of` do."""
        _, library = library_of(project, room)
        target = target_of(project.duet, library)
        return cls(project.duet, library, target, leader_of(project.duet, room, library, target))

    @property
    def rules(self) -> tuple[Rule, ...]:
        """What is pinned and forbidden."""
        return tuple(
            Rule(row.start, row.stop, take=row.take, source=row.source, forbid=row.forbid) for row in self.duet.rules
        )

    def model(self, room: Room, progress: Progress | None = None) -> PerformanceModel:
        """What ``perform --target`` fits, without the leader's own take; fitted once."""
        exclude = left_out(self.library, self.leader, self.target)
        method = replace(partner_control(), mirror=self.duet.mirror)
        track = _partner_track(self.library, self.target, self.leader, exclude)
        if track is not None and isinstance(method.control_points, PointsByRole):
            method = replace(method, control_points=replace(method.control_points, track=track))
        return room.fitted(
            self.library,
            ("duet", exclude, self.target, self.duet.mirror, track),
            lambda: method.fit(self.library, exclude=exclude, track=self.target, progress=progress),
        )


@dataclass(frozen=True, eq=False)
class MadeDuet(Made):
    """A follower, with what its moves are read from.

    Parameters
    ----------
    dance : Dance, optional
    model : PerformanceModel, optional
    """

    dance: Dance | None = None
    model: PerformanceModel | None = None


def make(project: Project, room: Room, progress: Progress) -> MadeDuet | None:
    """The follower of a leader, with the leader and, where it is known, the recorded follower.

    Parameters
    ----------
    project : Project
    room : Room
    progress : Progress
        Stops the work within a moment where it raises.

    Returns
    -------
    MadeDuet or None
        None without a leader.

    Raises
    ------
    KinetographError
        In one line: no library with partners, a leader that cannot be read, or one that cannot be followed.
    """
    if not project.duet.leader:
        return None
    return stoppable(lambda report: _made(project, room, report), progress)


def _made(project: Project, room: Room, progress: Progress) -> MadeDuet:
    dance = Dance.of(project, room)
    model = dance.model(room, progress)
    leader = dance.leader
    synthesis = perform_with(model, leader.motion, rules=dance.rules, progress=progress)
    holds = tuple(note for note in synthesis.annotations if note.kind == "handhold")
    comparison = compared(synthesis.motion, holds, leader)
    others = {"leader": leader.motion, **({} if leader.truth is None else {"truth": leader.truth})}
    return MadeDuet(
        (replace(synthesis, warnings=(*leader.notes, *synthesis.warnings)),),
        others=others,
        lanes=comparison.lanes,
        figures=comparison.figures,
        notes=held_by_others(holds, leader),
        dance=dance,
        model=model,
    )


def _partner_track(library: Library, target: str, leader: Leader, exclude: tuple[str, ...]) -> str | None:
    """The track that led in the library's takes, where a take has several: of the leader's name; None where not."""
    used = {take: tracks for take, tracks in leading_tracks(library, target).items() if take not in exclude}
    if all(len(tracks) == 1 for tracks in used.values()) and not _signals(library, used):
        return None
    return leader.person if all(leader.person in tracks for tracks in used.values()) else None


def _signals(library: Library, takes: Mapping[str, tuple[str, ...]]) -> bool:
    """Whether some of the takes have tracks that are no motions."""
    return any(track.kind != "motion" and track.take in takes for track in contents(library))


# ---- answers ----


def _leaders(room: Room, project: Project, message: AskLeaders) -> LeaderTakes:
    """The takes that can lead, in the library that is named or the first with partners; or what to do."""
    named = project.duet.library if message.library is None else message.library
    asked = _with_duet(project, library=named)
    try:
        name, library = library_of(asked, room)
    except RequestError as error:
        return LeaderTakes(message.id, named, advice=str(error))
    return _takes(message.id, name, library, _target_of_any(asked.duet, library))


def _target_of_any(duet: Duet, library: Library) -> str:
    """The track that is made, whatever is asked for: one of the library's."""
    try:
        return target_of(duet, library)
    except RequestError:
        return target_of(Duet(), library)


def _with_duet(project: Project, **fields: object) -> Project:
    """A project with another duet."""
    return msgspec.structs.replace(project, duet=msgspec.structs.replace(project.duet, **fields))


def _takes(number: int, name: str, library: Library, target: str) -> LeaderTakes:
    seconds = {(track.take, track.name): (track.frames - 1) / track.fps for track in contents(library)}
    rows = tuple(
        LeaderRow(take, max(seconds[take, person] for person in persons), persons)
        for take, persons in leading_tracks(library, target).items()
    )
    targets = tuple(sorted({track for tracks in couples(library).values() for track in tracks}))
    return LeaderTakes(number, name, rows, target, targets)


def _leader_facts(room: Room, project: Project, message: AskLeader) -> LeaderFacts:
    """Who the leader of the project is: the people in the file, and what was guessed."""
    leader = _leader(project, room)
    motion = leader.motion
    return LeaderFacts(
        message.id, leader.name, motion.duration, leader.person, leader.persons, leader.truth is not None, leader.notes
    )


def _leader_clip(room: Room, project: Project, message: ShowLeader) -> bytes:
    """The leader alone, to look at while the follower is being made."""
    leader = _leader(project, room)
    character = room.character(project.character)
    take = bodies({"leader": leader.motion}, character)
    return blob(ClipHeader(message.id, leader.name, floor_of(take.motion("leader"), character)), clip(take, character))


def _leader(project: Project, room: Room) -> Leader:
    if not project.duet.leader:
        raise RequestError("choose a leader first")
    return Dance.of(project, room).leader


def _transcript(room: Room, project: Project, message: Transcribe) -> Transcribed:
    """The moves of what was made last, with their margins; stopped where something else has been made since."""
    made = room.latest.get("duet")
    if not isinstance(made, MadeDuet) or made.dance is None or made.model is None:
        raise RequestError("there is no follower to transcribe; choose a leader first")
    try:
        require_moves(made.model.fitted)
    except RequestError:
        return Transcribed(message.id, advice=_LABEL)

    def still_wanted(done: int, total: int) -> None:
        if room.latest.get("duet") is not made:
            raise RequestError("another follower has been made since")

    moves = made.model.transcribe(made.dance.leader.motion, made.dance.rules, still_wanted)
    return Transcribed(
        message.id,
        tuple(
            MoveRow(
                move.move,
                move.start,
                move.stop,
                move.margin if np.isfinite(move.margin) else None,
                notation([move.move]) if move.move else "",
            )
            for move in moves
        ),
    )


def _hands(room: Room, project: Project, message: AskHands) -> Hands:
    """The joints of the hands that hold each other in what was made last, on the bodies that are shown."""
    made = room.latest.get("duet")
    if made is None:
        raise RequestError("there is no follower yet; choose a leader first")
    follower, leader = made.synthesis.motion, made.others["leader"]
    character = room.character(project.character)
    own, theirs = (character.skeleton if character else motion.skeleton for motion in (follower, leader))
    notes = tuple(note for note in made.synthesis.annotations if note.kind == "handhold")
    return Hands(
        message.id,
        tuple(
            HandsRow(
                hold.note.start,
                hold.note.stop,
                own.names[own.landmark(hold.own).joint],
                theirs.names[theirs.landmark(hold.theirs).joint],
                hold.met,
            )
            for hold in measured(follower, notes, leader)
        ),
    )


_LABEL = (
    "the library names no moves, so that there is no transcript; name them: kinetograph library label LIB --by partner"
)

ANSWERS: Mapping[type[Message], Answer] = {
    AskLeaders: _leaders,
    AskLeader: _leader_facts,
    ShowLeader: _leader_clip,
    AskHands: _hands,
    Transcribe: _transcript,
}
"""What the page asks of a duet."""
