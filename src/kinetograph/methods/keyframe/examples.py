"""From a library to the examples of keyframe control: recordings at one rate, on one skeleton."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion, repeat, resample
from kinetograph.segmentation import detect_contacts
from kinetograph.skeleton import Skeleton, opposite, same_shape
from kinetograph.take import Annotation, Take

if TYPE_CHECKING:
    from kinetograph.library import Library

CYCLES = 4
"""How often a looping clip is played."""


@dataclass(frozen=True, eq=False)
class Example:
    """A recording. take, track, mirrored: where it comes from; motion: at the method's rate; contacts: in its seconds;
    period: seconds of one cycle of a looping clip, which is played `CYCLES` times, else 0.
    """

    take: str
    track: str
    mirrored: bool
    motion: Motion
    contacts: tuple[Annotation, ...]
    period: float = 0.0


def collect_examples(
    library: Library, rate: float, *, mirror: bool = False, exclude: tuple[str, ...] = (), track: str | None = None
) -> tuple[Example, ...]:
    """Every take's motion as an example, on the skeleton of the first.

    Raises RequestError for a library without takes, or where skeletons have different joints.
    """
    found: list[Example] = []
    for name in library.names():
        if name not in exclude:
            found += _examples_of(library.take(name), rate, mirror, track, found[0].motion.skeleton if found else None)
    if not found:
        raise RequestError("the library has no take to use; add recordings, or exclude fewer")
    return tuple(found)


def _examples_of(
    take: Take, rate: float, mirrored: bool, track: str | None, skeleton: Skeleton | None
) -> list[Example]:
    motion = take.motion(track)
    name = next(key for key, value in take.tracks.items() if value is motion)
    if skeleton is not None:
        motion = adopt(motion, skeleton, f"take {take.name!r}")
    loops = any(note.kind == "loop" for note in take.annotated(name, "loop"))
    period = motion.duration if loops else 0.0
    long = repeat(motion, CYCLES) if loops else motion
    contacts = (() if loops else take.annotated(name, "contact")) or detect_contacts(long, track=name)
    even = resample(long, rate)
    found = [Example(take.name, name, False, even, contacts, period)]
    if mirrored:
        from kinetograph.mirroring import mirror

        swapped = tuple(Annotation(n.track, n.kind, opposite(n.label), n.start, n.stop) for n in contacts)
        found.append(Example(take.name, name, True, mirror(even), swapped, period))
    return found


def adopt(motion: Motion, skeleton: Skeleton, what: str) -> Motion:
    """A motion on another skeleton of the same joints: rotations are kept, the root's path scales with the legs.

    Raises RequestError, naming ``what``, where the joints differ.
    """
    if same_shape(motion.skeleton, skeleton):
        return motion if motion.bones is None else replace(motion, bones=None)
    if motion.skeleton.names != skeleton.names or not np.array_equal(motion.skeleton.parents, skeleton.parents):
        raise RequestError(
            f"{what} ({len(motion.skeleton)} joints) and the library's first take ({len(skeleton)} joints) have "
            "different skeletons; retarget it first, or put it in a library of its own"
        )
    scale = leg_length(skeleton) / leg_length(motion.skeleton)
    return Motion(skeleton, motion.translation * scale, motion.rotations, motion.fps)


def leg_length(skeleton: Skeleton) -> float:
    """Metres from hip to ankle along the left leg; the skeleton's height where it has no such leg."""
    if not {"left_hip", "left_foot"} <= skeleton.roles.keys():
        return max(skeleton.height, 1e-6)
    joint, top, length = skeleton.roles["left_foot"].joint, skeleton.roles["left_hip"].joint, 0.0
    while joint not in (top, -1):
        length += float(np.linalg.norm(skeleton.offsets[joint]))
        joint = int(skeleton.parents[joint])
    return max(length, 1e-6)


def mean_heading(angles: FloatArray) -> float:
    """The circular mean of angles in radians: the direction of the mean of their unit vectors.

    >>> round(float(np.degrees(mean_heading(np.radians([170.0, -170.0])))), 6)
    180.0
    """
    return float(np.angle(np.exp(1j * angles).mean()))
