"""What a section searched for by the segmental search: its model, its control and its rules, for questions about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinetograph.errors import RequestError
from kinetograph.studio.duet.making import MadeDuet
from kinetograph.studio.made import Made
from kinetograph.studio.project import Project, RuleRow
from kinetograph.studio.room import Room
from kinetograph.studio.walk.model import control_of, model_of, rules_of

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel
    from kinetograph.motion import Motion
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Piece, Synthesis


@dataclass(frozen=True, eq=False)
class Searched:
    """A search of a walk or a duet.

    Parameters
    ----------
    model : PerformanceModel
    control : Signal or Motion
    rules : tuple of RuleRow
    made : Made, optional
        What was made last.
    """

    model: PerformanceModel
    control: Signal | Motion
    rules: tuple[RuleRow, ...]
    made: Made | None

    @property
    def synthesis(self) -> Synthesis:
        """What was made last. Raises RequestError where there is nothing yet."""
        if self.made is None:
            raise RequestError("there is no walk yet; draw a path first")
        return self.made.synthesis

    def piece_at(self, second: float) -> Piece:
        """The piece at a time of what is shown. Raises RequestError for a time outside it."""
        motion = self.synthesis.motion
        if not 0 <= second <= motion.duration:
            raise RequestError(f"the motion lasts {motion.duration:.2f} s, found a time of {second:.2f} s")
        return self.synthesis.piece_at(round(second * motion.fps))

    def under(self, rules: tuple[RuleRow, ...]) -> Synthesis:
        """What is made under more rules, as ``kinetograph perform`` makes it."""
        from kinetograph.pipeline import perform_with

        return perform_with(self.model, self.control, rules=rules_of((*self.rules, *rules)))


def searched(project: Project, room: Room) -> Searched:
    """The search of the section that is shown.

    Parameters
    ----------
    project : Project
    room : Room

    Returns
    -------
    Searched

    Raises
    ------
    RequestError
        Where it has nothing to search for yet.
    """
    if project.mode == "duet":
        made = room.latest.get("duet")
        if not isinstance(made, MadeDuet) or made.model is None or made.dance is None:
            raise RequestError("there is no follower yet; choose a leader first")
        return Searched(made.model, made.dance.leader.motion, made.dance.duet.rules, made)
    if len(project.walk.path) < 2:
        raise RequestError("there is no walk yet; draw a path first")
    return Searched(model_of(project, room), control_of(project.walk), project.walk.rules, room.latest.get("walk"))
