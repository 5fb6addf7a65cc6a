"""What a section searched for: its model, its control and what is asked along it, for questions about it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kinetograph.errors import RequestError
from kinetograph.studio.duet.making import MadeDuet
from kinetograph.studio.fitting import sources_of
from kinetograph.studio.made import Made
from kinetograph.studio.project import Project, RuleRow
from kinetograph.studio.requests import walk_request
from kinetograph.studio.room import Room
from kinetograph.studio.walk.model import control_of, model_of

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel
    from kinetograph.methods.together import Asked
    from kinetograph.motion import Motion
    from kinetograph.pipeline import Rendered
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Piece, Synthesis


@dataclass(frozen=True, eq=False)
class Searched:
    """A search of a walk or a duet.

    Parameters
    ----------
    model : PerformanceModel
    control : Signal or Motion
    asked : Asked
        Along the control.
    made : Made, optional
        What was made last.
    """

    model: PerformanceModel
    control: Signal | Motion
    asked: Asked
    made: Made | None

    @property
    def synthesis(self) -> Synthesis:
        """What was made last. Raises RequestError where there is nothing yet."""
        if self.made is None:
            raise RequestError("there is no walk yet; draw a path first")
        return self.made.synthesis

    @property
    def rendered(self) -> Rendered:
        """What was made last, with what it was made of. Raises RequestError where there is nothing yet."""
        from kinetograph.pipeline import Rendered

        return Rendered(self.synthesis, self.control, self.model, self.asked)

    def piece_at(self, second: float) -> Piece:
        """The piece at a time of what is shown. Raises RequestError for a time outside it."""
        motion = self.synthesis.motion
        if not 0 <= second <= motion.duration:
            raise RequestError(f"the motion lasts {motion.duration:.2f} s, found a time of {second:.2f} s")
        return self.synthesis.piece_at(round(second * motion.fps))

    def under(self, rules: tuple[RuleRow, ...]) -> Synthesis:
        """What is made under more rules, as ``kinetograph perform`` makes it."""
        from kinetograph.methods.performance import Rule
        from kinetograph.pipeline import perform_asked

        more = tuple(Rule(r.start, r.stop, take=r.take, source=r.source, forbid=r.forbid) for r in rules)
        return perform_asked(self.model, self.control, replace(self.asked, rules=(*self.asked.rules, *more)))


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
    from kinetograph.methods.together import Asked
    from kinetograph.pipeline.requesting import asked_of

    if project.mode == "duet":
        made = room.latest.get("duet")
        if not isinstance(made, MadeDuet) or made.model is None or made.dance is None:
            raise RequestError("there is no follower yet; choose a leader first")
        return Searched(made.model, made.dance.leader.motion, Asked(rules=made.dance.rules), made)
    if len(project.walk.path) < 2:
        raise RequestError("there is no walk yet; draw a path first")
    library = room.library(project.libraries, project.walk.library)
    asked = asked_of(walk_request(project), sources_of(room, library))
    return Searched(model_of(project, room), control_of(project, room), asked, room.latest.get("walk"))
