"""From a library to the examples of keyframe control: recordings at one rate, on one skeleton."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.library import Library
from kinetograph.methods.recordings import (
    LABELS,
    Recording,
    adopt,
    collect,
    looped,
    mirrored_annotations,
    same_joints,
)
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion, resample
from kinetograph.progress import Progress
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation


@dataclass(frozen=True, eq=False)
class Example:
    """A recording made ready for keyframe control: a *motion example* of the paper.

    Parameters
    ----------
    take, track : str
        Where it comes from.
    mirrored : bool
        Whether left and right are exchanged.
    motion : Motion
        At the method's rate, on the skeleton of the library's first take, its bones rigid.
    contacts : tuple of Annotation
        In the motion's seconds.
    period : float
        Seconds of one cycle of a looping clip, which is played several times; else 0.
    labels : tuple of Annotation
        The moves and styles that people named, in seconds of one cycle.
    """

    take: str
    track: str
    mirrored: bool
    motion: Motion
    contacts: tuple[Annotation, ...]
    period: float = 0.0
    labels: tuple[Annotation, ...] = ()


def collect_examples(
    library: Library,
    rate: float,
    *,
    mirror: bool = False,
    exclude: Iterable[str] = (),
    track: str | None = None,
    progress: Progress | None = None,
) -> tuple[Example, ...]:
    """Every take's motion as an example, on the skeleton of the first.

    Parameters
    ----------
    library : Library
    rate : float
        Frames per second of the examples.
    mirror : bool
        Also make an example of every motion with left and right exchanged.
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    progress : Progress, optional
        Called for every take that is read.

    Raises
    ------
    RequestError
        For a name to leave out that is not there, and for a library without takes to use.
    """
    recordings = collect(library, exclude=exclude, track=track, progress=progress)
    return examples_of(recordings, rate, mirror=mirror)


def examples_of(recordings: Sequence[Recording], rate: float, *, mirror: bool = False) -> tuple[Example, ...]:
    """Recordings of the same joints as examples, on the skeleton of the first.

    Parameters
    ----------
    recordings : sequence of Recording
    rate : float
        Frames per second of the examples.
    mirror : bool
        Also make an example of every motion with left and right exchanged.
    """
    skeleton = recordings[0].motion.skeleton
    examples: list[Example] = []
    for recording in recordings:
        examples.append(_example(recording, skeleton, rate))
        if mirror:
            examples.append(_mirrored(examples[-1]))
    return tuple(examples)


def _example(recording: Recording, skeleton: Skeleton, rate: float) -> Example:
    adopted = looped(replace(recording, motion=rigid(adopt(recording.motion, skeleton))))
    even = resample(adopted.motion, rate)
    labels = tuple(note for kind in LABELS for note in recording.take.annotated(recording.track, kind))
    return Example(recording.name, recording.track, False, even, adopted.contacts(), adopted.period, labels)


def _mirrored(example: Example) -> Example:
    contacts = tuple(mirrored_annotations(example.contacts))
    labels = tuple(mirrored_annotations(example.labels))
    return replace(example, mirrored=True, motion=mirror(example.motion), contacts=contacts, labels=labels)


def rigid(motion: Motion) -> Motion:
    """The motion with every bone as in the skeleton, where a file moved joints against their parents."""
    return motion if motion.bones is None else replace(motion, bones=None)


def adopt_named(motion: Motion, skeleton: Skeleton, name: str) -> Motion:
    """A motion that is no take of the library, on the library's skeleton, its bones rigid.

    Parameters
    ----------
    motion : Motion
        With the skeleton's joints; see ``kinetograph.methods.recordings.adopt`` for bones of other lengths.
    skeleton : Skeleton
    name : str
        What an error calls the motion.

    Raises
    ------
    RequestError
        Where the joints differ.
    """
    if not same_joints(motion.skeleton, skeleton):
        raise RequestError(
            f"{name} ({len(motion.skeleton)} joints) and the library's first take ({len(skeleton)} joints) have "
            "different skeletons; retarget it first, or put it in a library of its own"
        )
    return rigid(adopt(motion, skeleton))


def mean_heading(angles: FloatArray) -> float:
    """The circular mean of angles in radians: the direction of the mean of their unit vectors.

    Examples
    --------
    >>> round(float(np.degrees(mean_heading(np.radians([170.0, -170.0])))), 6)
    180.0
    """
    return float(np.angle(np.exp(1j * angles).mean()))
