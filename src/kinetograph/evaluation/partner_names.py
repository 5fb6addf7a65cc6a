"""Error rates of stances and transitions as they are seen in two dancers (Hsu 2004, section 6.2 and table 6.1).

The recorded and the made follower are named by one rule, at the same beats and with the same leader, as an observer
would name them: a unit is wrong where the two names differ. Nothing that pieces carry is used.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from kinetograph.errors import RequestError
from kinetograph.evaluation.labels import LabelErrors, label_errors
from kinetograph.library import Library
from kinetograph.motion import Motion, cut, resample
from kinetograph.pipeline import couple_of, unit_moves
from kinetograph.segmentation import Couple, StanceThresholds, find_thresholds, transition_of
from kinetograph.take import Annotation, Take


@dataclass(frozen=True)
class SeenErrors:
    """How often an observer sees something else than was recorded.

    Parameters
    ----------
    names : LabelErrors
        Of whole names: two stances and a transition.
    transitions : LabelErrors
        Of transitions alone: step, inside turn or outside turn.
    """

    names: LabelErrors
    transitions: LabelErrors


@dataclass(frozen=True, eq=False)
class Observer:
    """Who names dances, by one rule for all.

    Parameters
    ----------
    target : str
        The follower's track.
    span : int
        Cuts that a unit goes on for.
    thresholds : StanceThresholds
    """

    target: str
    span: int
    thresholds: StanceThresholds

    @classmethod
    def of(cls, library: Library, target: str, span: int) -> Observer | None:
        """One who has seen all the dances of a library; None where no take has two dancers and cuts.

        Parameters
        ----------
        library : Library
        target : str
            The follower's track.
        span : int
            Cuts that a unit goes on for.
        """
        couples = []
        for name in library.names():
            try:
                couples.append(couple_of(library.take(name), target, least=span + 1))
            except RequestError:  # a take that cannot be named is not judged
                continue
        return cls(target, span, find_thresholds(couples, span)) if couples else None

    def recorded(self, take: Take) -> tuple[Annotation, ...]:
        """The names of a take's units; none where it has not two dancers and cuts."""
        try:
            couple = couple_of(take, self.target, least=self.span + 1)
        except RequestError:
            return ()
        return unit_moves(couple, self.thresholds, self.target, self.span)

    def made(self, take: Take, leader: Motion, follower: Motion) -> tuple[Annotation, ...]:
        """The names of the same units with another follower, whose handholds are detected.

        Parameters
        ----------
        take : Take
            The recording, with the follower's cuts.
        leader : Motion
        follower : Motion
            The other follower.

        Returns
        -------
        tuple of Annotation
        """
        recorded = self.recorded(take)
        if not recorded:
            return ()
        cuts = sorted({note.start for note in take.annotated(self.target, "cut")})
        theirs = resample(follower, leader.fps)
        frames = min(len(leader), len(theirs))
        couple = Couple.of(cut(leader, 0, frames), cut(theirs, 0, frames), cuts)
        return unit_moves(couple, self.thresholds, self.target, self.span)

    def compare(self, take: Take, made: Iterable[Annotation]) -> SeenErrors:
        """How many of a take's units, and of its patterns of four, are named otherwise.

        Parameters
        ----------
        take : Take
        made : iterable of Annotation
            Names of the same units.

        Returns
        -------
        SeenErrors
        """
        recorded, made = self.recorded(take), tuple(made)
        units = [(note.start, note.stop) for note in recorded]
        transitions = label_errors(_transitions(recorded), _transitions(made), units)
        return SeenErrors(label_errors(recorded, made, units), transitions)

    def commonest(self, library: Library, take: Take) -> tuple[Annotation, ...]:
        """A take's units, each with the name that is commonest in the other takes.

        Parameters
        ----------
        library : Library
        take : Take

        Returns
        -------
        tuple of Annotation
        """
        others = [library.take(name) for name in library.names() if name != take.name]
        counts = Counter(note.label for other in others for note in self.recorded(other))
        name = counts.most_common(1)[0][0] if counts else ""
        return tuple(Annotation(n.track, n.kind, name, n.start, n.stop) for n in self.recorded(take))


def _transitions(notes: Iterable[Annotation]) -> list[Annotation]:
    return [replace(note, label=transition_of(note.label)) for note in notes]
