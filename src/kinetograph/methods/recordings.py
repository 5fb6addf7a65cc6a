"""From a library to the recordings that a method learns from: one collector for all methods.

A name to leave out that the library does not have is refused, a looping clip is played several times, and every
recording is put on the skeleton of the first.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.motion import Motion, repeat
from kinetograph.progress import Progress
from kinetograph.segmentation import detect_contacts
from kinetograph.skeleton import Skeleton, opposite, same_shape
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
    """

    take: Take
    track: str
    motion: Motion
    period: float = 0.0

    @property
    def name(self) -> str:
        """The take's name."""
        return self.take.name

    def contacts(self) -> tuple[Annotation, ...]:
        """The contacts that the take is annotated with; found in the motion where there are none, or it loops."""
        noted = () if self.period else self.take.annotated(self.track, "contact")
        return noted or detect_contacts(self.motion, track=self.track)


def collect(
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    progress: Progress | None = None,
) -> tuple[Recording, ...]:
    """Every take's motion, as it was recorded.

    Parameters
    ----------
    library : Library
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    progress : Progress, optional

    Raises
    ------
    RequestError
        For a name to leave out that is not there, for a library without takes to use, and for skeletons of
        different joints.
    """
    left_out = tuple(exclude)
    names = library.names()
    if unknown := sorted(set(left_out) - set(names)):
        raise RequestError(f"no take {unknown[0]!r} to leave out; there are {', '.join(names) or 'none'}")
    found = []
    for done, name in enumerate(names, start=1):
        if name not in left_out:
            take = library.take(name)
            found.append(Recording(take, *take.named_motion(track)))
        if progress:
            progress(done, len(names))
    if not found:
        raise RequestError("the library has no take to use; add recordings, or exclude fewer")
    require_same_joints(found)
    return tuple(found)


def require_same_joints(recordings: Iterable[Recording]) -> None:
    """Raise RequestError where recordings have skeletons of different joints."""
    first: Recording | None = None
    for recording in recordings:
        first = first or recording
        if not same_joints(first.motion.skeleton, recording.motion.skeleton):
            raise RequestError(
                f"takes {first.name!r} ({len(first.motion.skeleton)} joints) and {recording.name!r} "
                f"({len(recording.motion.skeleton)} joints) have different skeletons; retarget one of them first, "
                "or put it in a library of its own"
            )


def same_joints(a: Skeleton, b: Skeleton) -> bool:
    """Whether two skeletons have the same joints, whatever the lengths of their bones."""
    return a.names == b.names and np.array_equal(a.parents, b.parents)


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
    if same_shape(motion.skeleton, skeleton):
        return motion
    if scaled and not same_shape(motion.skeleton, skeleton, tolerance=ALIKE):
        scale = leg_length(skeleton) / leg_length(motion.skeleton)
        return Motion(skeleton, motion.translation * scale, motion.rotations, motion.fps)
    rebuilt = replace(motion, skeleton=skeleton, bones=None)
    rise = np.array([0.0, _floor(motion) - _floor(rebuilt), 0.0])
    return replace(rebuilt, translation=rebuilt.translation + rise)


def leg_length(skeleton: Skeleton) -> float:
    """Metres from hip to ankle along the left leg; the skeleton's height where it has no such leg."""
    if not {"left_hip", "left_foot"} <= skeleton.roles.keys():
        return max(skeleton.height, 1e-6)
    joint, top, length = skeleton.roles["left_foot"].joint, skeleton.roles["left_hip"].joint, 0.0
    while joint not in (top, -1):
        length += float(np.linalg.norm(skeleton.offsets[joint]))
        joint = int(skeleton.parents[joint])
    return max(length, 1e-6)


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
    swapped = {**dict(sides), **{b: a for a, b in sides}}
    for note in annotations:
        if note.kind in LABELS:
            yield replace(note, label=_words_swapped(note.label, swapped))
        else:
            yield replace(note, label=":".join(opposite(role) for role in note.label.split(":")))


def _words_swapped(name: str, swapped: Mapping[str, str]) -> str:
    """A name with its words replaced, whatever joins them; a capital letter stays one."""

    def swap(match: re.Match[str]) -> str:
        word = match.group()
        other = swapped.get(word.lower(), word)
        return other.capitalize() if word[0].isupper() and other != word else other

    return re.sub(r"[^\W_]+", swap, name)
