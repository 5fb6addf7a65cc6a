"""From a library to the recordings that a method learns from: one collector for all methods.

A name to leave out that the library does not have is refused, a looping clip is played several times, recordings of
another skeleton are left out or brought over, and every recording is put on the skeleton of the first.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import PurePosixPath

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions
from kinetograph.left_out import LeftOut, together
from kinetograph.library import Facts, Library, facts_of
from kinetograph.methods.bodies import Bodies, bring_over, choose_takes, cost_lines, notes_on
from kinetograph.methods.relative_pose import leg_length
from kinetograph.motion import Motion, repeat
from kinetograph.post.retargeting_error import RetargetingError
from kinetograph.progress import Progress
from kinetograph.segmentation import detect_contacts
from kinetograph.skeleton import Skeleton, opposite, plain_names, same_shape
from kinetograph.take import Annotation, Take

ALIKE = 0.05
"""Metres by which the bones of two recordings may differ and still count as one build."""

SIDES = (("left", "right"), ("inside", "outside"))
"""Words in the names of moves that are each other's mirror image."""

LABELS = ("move", "style")
"""Kinds of annotations by which people name what is done, and how."""

CYCLES = 4
"""How often a looping clip is played: what is cut from its second cycle has real motion on both sides."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A motion of a take.

    Parameters
    ----------
    take : Take
    track : str
        Name of the motion's track.
    motion : Motion
        As recorded, or a looping clip played `CYCLES` times.
    period : float
        Seconds of one cycle of a looping clip, else 0.
    facts : Facts
        What is known of the take.
    """

    take: Take
    track: str
    motion: Motion
    period: float = 0.0
    facts: Facts = field(default_factory=Facts)

    @property
    def name(self) -> str:
        """The take's name."""
        return self.take.name

    def contacts(self) -> tuple[Annotation, ...]:
        """The contacts that the take is annotated with; found in the motion where there are none, or it loops."""
        noted = () if self.period else self.take.annotated(self.track, "contact")
        return noted or detect_contacts(self.motion, track=self.track)


@dataclass(frozen=True, eq=False)
class Gathered:
    """The recordings of a library that a method uses.

    Parameters
    ----------
    recordings : tuple of Recording
        All with the same joints.
    left : mapping of str to tuple of str
        Takes that are left out, by reason.
    notes : tuple of str
        What a person should know of both, a line each.
    brought : tuple of str
        Takes that were brought over from other skeletons.
    """

    recordings: tuple[Recording, ...]
    left: LeftOut = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    brought: tuple[str, ...] = ()


def collect(
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    progress: Progress | None = None,
) -> tuple[Recording, ...]:
    """Every take's motion, as it was recorded; of several skeletons, those of most seconds. See `gather`."""
    return gather(library, exclude=exclude, track=track, progress=progress).recordings


def gather(
    library: Library,
    bodies: Bodies | None = None,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    progress: Progress | None = None,
) -> Gathered:
    """Every take's motion, as it was recorded or, where it has another skeleton and that is asked for, brought over.

    Parameters
    ----------
    library : Library
    bodies : Bodies, optional
        Which skeleton is used where there are several, and whether takes of others are brought over or left out.
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    progress : Progress, optional

    Returns
    -------
    Gathered

    Raises
    ------
    RequestError
        For a name to leave out that is not there, and for a library without takes to use.
    """
    chosen = choose_takes(library, bodies, exclude=exclude, track=track)
    skeleton = library.take(chosen.first).motion(chosen.tracks[chosen.first]).skeleton if chosen.others else None
    facts = facts_of(library)
    found: list[Recording] = []
    costs: dict[str, tuple[Skeleton, RetargetingError]] = {}
    failed: dict[str, tuple[str, ...]] = {}
    for done, name in enumerate(chosen.names, start=1):
        take = library.take(name)
        recording = Recording(
            take, chosen.tracks[name], take.motion(chosen.tracks[name]), facts=facts.get(name, Facts())
        )
        if skeleton is not None and name in chosen.others:
            try:
                recording, cost = brought_over(recording, skeleton)
                costs[name] = cost
                found.append(recording)
            except RequestError as error:
                failed = together(failed, {f"which cannot be brought over: {error}": (name,)})
        else:
            found.append(recording)
        if progress:
            progress(done, len(chosen.names))
    left = together(chosen.left, failed)
    told = cost_lines(costs, skeleton) if skeleton is not None else ()
    return Gathered(tuple(found), left, (*notes_on(left), *told), tuple(costs))


def brought_over(recording: Recording, skeleton: Skeleton) -> tuple[Recording, tuple[Skeleton, RetargetingError]]:
    """A recording on another skeleton by roles; the skeleton that it had, and what that cost.

    Raises RequestError for a skeleton without hips or legs.
    """
    motion = recording.motion
    alone = sum(isinstance(track, Motion) for track in recording.take.tracks.values()) == 1
    notes = tuple(note for note in recording.take.annotations if note.track == recording.track)
    made, cost = bring_over(motion, skeleton, notes, alone=alone)
    take = replace(recording.take, tracks={**recording.take.tracks, recording.track: made})
    return replace(recording, take=take, motion=made), (motion.skeleton, cost)


def person_of(recording: Recording) -> str:
    """Who moves in a recording: its subject, or else the folder part of its name; empty where neither is known."""
    folder = PurePosixPath(recording.name).parent
    return recording.facts.subject or ("" if str(folder) == "." else str(folder))


def same_joints(a: Skeleton, b: Skeleton) -> bool:
    """Whether two skeletons have the same joints, whatever the lengths of their bones."""
    return plain_names(a.names) == plain_names(b.names) and np.array_equal(a.parents, b.parents)


def looped(recording: Recording) -> Recording:
    """A recording that its take says loops, played `CYCLES` times; any other as it is."""
    if not recording.take.annotated(recording.track, "loop"):
        return recording
    motion = recording.motion
    return replace(recording, motion=repeat(motion, CYCLES), period=motion.duration)


def adopt(motion: Motion, skeleton: Skeleton, *, scaled: bool = True) -> Motion:
    """A motion on another skeleton of the same joints; rotations are kept.

    A body of nearly the same build is lifted to stand on the floor that it stood on. That of another build has its
    root's path scaled with the legs, unless ``scaled`` is false, as where it must stay with a partner.
    """
    if motion.skeleton.names != skeleton.names:  # of another namespace
        motion = replace(motion, skeleton=replace(motion.skeleton, names=skeleton.names))
    if same_shape(motion.skeleton, skeleton):
        return motion
    if scaled and not same_shape(motion.skeleton, skeleton, tolerance=ALIKE):
        scale = leg_length(skeleton) / leg_length(motion.skeleton)
        return Motion(skeleton, motion.translation * scale, motion.rotations, motion.fps)
    rebuilt = replace(motion, skeleton=skeleton, bones=None)
    rise = np.array([0.0, _floor(motion) - _floor(rebuilt), 0.0])
    return replace(rebuilt, translation=rebuilt.translation + rise)


def _floor(motion: Motion) -> float:
    """The height in metres that a body stands on: of its lowest joint, in the frames where that is lowest."""
    lowest: FloatArray = joint_positions(motion)[..., 1].min(axis=1)
    return float(np.quantile(lowest, 0.05))


def mirrored_annotations(
    annotations: Iterable[Annotation], sides: Sequence[tuple[str, str]] = SIDES
) -> Iterator[Annotation]:
    """Annotations of the mirrored motion.

    Every role in a label, as in ``left_hand:right_hand``, changes sides, and so does every word of a move's or a
    style's name that is one of a pair.

    Parameters
    ----------
    annotations : iterable of Annotation
    sides : sequence of (str, str)
        Words that are each other's mirror image.

    Examples
    --------
    >>> notes = [Annotation("motion", "handhold", "left_hand:right_hand", 0, 1)]
    >>> notes.append(Annotation("motion", "move", "Turn left", 0, 1))
    >>> [note.label for note in mirrored_annotations(notes)]
    ['right_hand:left_hand', 'Turn right']
    """
    for note in annotations:
        if note.kind in LABELS:
            yield replace(note, label=swapped_sides(note.label, sides))
        else:
            yield replace(note, label=":".join(opposite(role) for role in note.label.split(":")))


def swapped_sides(name: str, sides: Sequence[tuple[str, str]] = SIDES) -> str:
    """A name with the words replaced that are one of a pair, whatever joins them; a capital letter stays one.

    Parameters
    ----------
    name : str
    sides : sequence of (str, str)
        Words that are each other's mirror image.

    Examples
    --------
    >>> swapped_sides("Turn_left01")
    'Turn_right01'
    """
    swapped = {**dict(sides), **{b: a for a, b in sides}}

    def swap(match: re.Match[str]) -> str:
        word = match.group()
        other = swapped.get(word.lower(), word)
        return other.capitalize() if word[0].isupper() and other != word else other

    return re.sub(r"[^\W\d_]+", swap, name)
