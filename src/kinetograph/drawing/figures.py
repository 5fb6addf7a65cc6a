"""What pictures show: characters at chosen instants, as bones with widths and colours, and the floor's height."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.formats import Capsule, body_capsules
from kinetograph.kinematics import forward, landmark_positions
from kinetograph.motion import Motion
from kinetograph.rotations import rotate
from kinetograph.skeleton import Landmark
from kinetograph.take import Annotation, Take

CASTS = (("#444444", "#0072b2", "#d55e00"), ("#8a6d3b", "#009e73", "#aa4a9c"), ("#607080", "#56a0d3", "#c99700"))
"""Colours of each character: the middle, the left and the right of its body."""

_SLIM = {"torso": 0.7, "pelvis": 0.55, "collar": 0.6, "neck": 0.8, "head": 0.9}  # drawn width over the body's


@dataclass(frozen=True, eq=False)
class Cast:
    """The figures at chosen instants.

    Parameters
    ----------
    seconds : ndarray, shape (N,)
    segments : ndarray, shape (N, B, 2, 3)
        Both ends of the bones of all characters, metres.
    widths : ndarray, shape (B,)
        Metres.
    colours : ndarray, shape (B, 3)
    centres : ndarray, shape (N, 3)
        The characters' mean position on the floor.
    planted : tuple of ndarray, shape (K, 3)
        The points in contact at each instant.
    """

    seconds: FloatArray
    segments: FloatArray
    widths: FloatArray
    colours: FloatArray
    centres: FloatArray
    planted: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class Stage:
    """What a picture shows.

    Parameters
    ----------
    motions : tuple of Motion
    contacts : tuple of tuple of Annotation
        Of each motion.
    floor : float
        Height of the floor, metres.
    """

    motions: tuple[Motion, ...]
    contacts: tuple[tuple[Annotation, ...], ...]
    floor: float

    @property
    def duration(self) -> float:
        """Seconds of the longest motion."""
        return max(motion.duration for motion in self.motions)


def set_stage(what: Motion | Sequence[Motion] | Take, contacts: Sequence[Annotation]) -> Stage:
    """The motions to draw, the contacts of their feet, and the floor.

    Parameters
    ----------
    what : Motion, sequence of Motion or Take
    contacts : sequence of Annotation
        In addition to a take's own; those of kind ``"contact"`` belong to their track in a take, else to the first
        motion.

    Returns
    -------
    Stage

    Raises
    ------
    RequestError
        There is no motion.
    """
    if isinstance(what, Take):
        tracks = [name for name, track in what.tracks.items() if isinstance(track, Motion)]
        motions = tuple(what.motion(name) for name in tracks)
        notes = [n for n in (*what.annotations, *contacts) if n.kind == "contact"]
        of = tuple(tuple(n for n in notes if n.track == name) for name in tracks)
    else:
        motions = (what,) if isinstance(what, Motion) else tuple(what)
        of = (tuple(n for n in contacts if n.kind == "contact"), *((),) * (len(motions) - 1))
    if not motions:
        raise RequestError("there is no motion to draw; give at least one")
    lowest = min(float(forward(thin(m))[0][..., 1].min()) for m in motions)
    # y = 0 is the floor; a motion far from it gets one of its own, as the picture would be empty between the two
    return Stage(motions, of, 0.0 if abs(lowest) < 0.6 else lowest)


def thin(motion: Motion, most: int = 600) -> Motion:
    """At most ``most`` frames of a motion, evenly spaced, which is enough for its extent."""
    return pick(motion, np.unique(np.linspace(0, len(motion) - 1, most).round().astype(np.int64)))


def pick(motion: Motion, frames: IntArray) -> Motion:
    """The frames of a motion with these indices."""
    bones = None if motion.bones is None else motion.bones[frames]
    return replace(motion, translation=motion.translation[frames], rotations=motion.rotations[frames], bones=bones)


def frames_at(motion: Motion, seconds: FloatArray) -> IntArray:
    """The frames nearest to some seconds, ``(N,)``, held at both ends."""
    return np.clip((seconds * motion.fps).round().astype(np.int64), 0, len(motion) - 1)


def cast_at(stage: Stage, seconds: FloatArray) -> Cast:
    """The figures at some seconds, ``(N,)``, as lines to draw."""
    segments, widths, colours, centres = [], [], [], []
    planted: list[list[FloatArray]] = [[] for _ in seconds]
    for i, (motion, notes) in enumerate(zip(stage.motions, stage.contacts, strict=True)):
        chosen = pick(motion, frames_at(motion, seconds))
        bones = tuple(bone for bone in body_capsules(motion.skeleton) if bone.part != "heel")
        palette = [_rgb(colour) for colour in CASTS[i % len(CASTS)]]
        segments.append(bone_ends(chosen, bones))
        widths += [_SLIM.get(bone.part, 0.85) * sum(bone.radii) for bone in bones]
        colours += [palette[bone.side] for bone in bones]
        centres.append(chosen.translation)
        for note in notes:
            _add_planted(planted, chosen, note, seconds)
    ground = np.mean(centres, axis=0)
    ground[:, 1] = stage.floor
    points = tuple(np.array(places).reshape(-1, 3) for places in planted)
    return Cast(seconds, np.concatenate(segments, axis=1), np.array(widths), np.array(colours), ground, points)


def _rgb(colour: str) -> FloatArray:
    """``"#rrggbb"`` as three numbers from 0 to 1."""
    return np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def bone_ends(motion: Motion, bones: tuple[Capsule, ...]) -> FloatArray:
    """World ends ``(F, B, 2, 3)`` of the bones: joint to joint, and to the tips of the leaves."""
    positions, rotations = forward(motion)
    carriers = np.array([bone.joint for bone in bones])
    starts = np.array([bone.start for bone in bones])
    stops = np.array([bone.stop if bone.part == "head" else bone.tip for bone in bones])
    first = positions[:, carriers] + rotate(rotations[:, carriers], starts)
    last = positions[:, carriers] + rotate(rotations[:, carriers], stops)
    for i, bone in enumerate(bones):
        if bone.child >= 0 and bone.part != "head":  # follows bones that stretch
            last[:, i] = positions[:, bone.child]
    return np.stack([first, last], axis=2)


def _add_planted(planted: list[list[FloatArray]], motion: Motion, note: Annotation, seconds: FloatArray) -> None:
    landmark = find_landmark(motion, note.label)
    if landmark is None:
        return
    points = landmark_positions(motion, [landmark])[:, 0]
    slack = 0.5 / motion.fps
    for k in np.flatnonzero((seconds >= note.start - slack) & (seconds <= note.stop + slack)):
        planted[k].append(points[k])


def find_landmark(motion: Motion, label: str) -> Landmark | None:
    """The point that a contact's label names: a role, or a joint."""
    if label in motion.skeleton.roles:
        return motion.skeleton.roles[label]
    return Landmark(motion.skeleton.names.index(label)) if label in motion.skeleton.names else None
