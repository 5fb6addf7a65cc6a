"""How the takes of a library were read: what else is told of them depends on which of them there are."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

from kinetograph.left_out import LeftOut, by_reason, left_out_lines, shortened, takes_counted, together
from kinetograph.methods.bodies import notes_on
from kinetograph.methods.performance.segments import Segment

MEND = "cut such takes by fixed length or by hand to use them (kinetograph library segment LIB --by fixed --takes NAME)"
"""What a person can do about takes without cuts."""


@dataclass(frozen=True, eq=False)
class TakesRead:
    """How the takes of a library were read.

    Parameters
    ----------
    builds : mapping of str to int
        The takes that were read, in order, each with the number of its skeleton as it was recorded.
    left : mapping of str to tuple of str
        Takes that were not read, by reason.
    failed : tuple of (str, str)
        Takes that have no cuts, in order, and why.
    cut_at : tuple of (str, str)
        Takes that had no cuts, in order, and what they were cut at.
    brought : tuple of str
        Takes that were brought over from another skeleton.
    calm : tuple of (float, Segment)
        The poses of which the calmest may be held, in the order of the recordings, and how calm they are.
    """

    builds: Mapping[str, int]
    left: LeftOut = field(default_factory=dict)
    failed: tuple[tuple[str, str], ...] = ()
    cut_at: tuple[tuple[str, str], ...] = ()
    brought: tuple[str, ...] = ()
    calm: tuple[tuple[float, Segment], ...] = ()

    @property
    def uncut(self) -> dict[str, tuple[str, ...]]:
        """Takes that have no cuts, by reason."""
        return by_reason(self.failed)

    @property
    def left_out(self) -> dict[str, tuple[str, ...]]:
        """All takes that are not used, by reason."""
        return together(self.left, self.uncut)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know, but for what it cost to bring takes over."""
        return (*notes_on(self.left), *cut_here(self.cut_at), *left_here(self.uncut))

    def without(self, takes: Collection[str]) -> TakesRead:
        """The same of the other takes; segments are numbered as before."""
        kept = {name: build for name, build in self.builds.items() if name not in takes}
        left = by_reason((name, why) for why, some in self.left.items() for name in some if name not in takes)
        failed, cut_at = (tuple(e for e in each if e[0] not in takes) for each in (self.failed, self.cut_at))
        return replace(self, builds=kept, left=left, failed=failed, cut_at=cut_at)


def cut_here(cut_at: Iterable[tuple[str, str]]) -> Iterable[str]:
    """What takes without cuts are cut at."""
    for cuts, takes in by_reason((name, cuts) for name, cuts in cut_at).items():
        were = "was" if len(takes) == 1 else "were"
        cut = f"{takes_counted(len(takes))} had no cuts and {were} cut at {cuts}"
        yield f"{cut} ({shortened(takes)}); library segment does so once"


def left_here(uncut: LeftOut) -> Iterable[str]:
    """Which takes are left out, why, and what a person can do about it."""
    lines = list(left_out_lines(uncut))
    return [*lines[:-1], f"{lines[-1]}; {MEND}"] if lines else ()
