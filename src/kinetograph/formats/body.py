"""The skin that a motion is written with: a character's where one is given, else capsules."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.character import Character, Skin, skin_heights
from kinetograph.errors import RequestError
from kinetograph.formats.capsules import TOE, rest_positions, stature
from kinetograph.formats.surface import body_surface
from kinetograph.motion import Motion, cut
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.stance import standing_character, to_standing
from kinetograph.take import Take

# linear colours: a light grey, blue and vermilion, which colour-blind people can tell apart
_PALETTE = (("middle", (0.55, 0.55, 0.55)), ("left", (0.03, 0.22, 0.50)), ("right", (0.62, 0.13, 0.03)))

_BLOCK = 4096  # frames whose soles are looked at together
_SOLES = (-0.02, 0.1)  # of the stature: a planted toe joint between these heights is over a floor at y = 0


def body_of(motion: Motion, character: Character | None = None) -> tuple[Skin, FloatArray]:
    """The skin that a motion is written with, and the rest positions of its joints.

    Parameters
    ----------
    motion : Motion
    character : Character, optional
        Whose skin to take; without one, a body of capsules.

    Returns
    -------
    skin : Skin
    rest : ndarray, shape (J, 3)
        Positions of the joints relative to the root, metres.

    Raises
    ------
    RequestError
        The skeleton is not the character's.
    """
    return skin_of(motion, character), rest_positions(motion.skeleton)


def dressed(motion: Motion, character: Character | None = None) -> tuple[Motion, Skin]:
    """A motion on a skeleton whose rest pose stands, as files with a bind pose hold it, and its skin in that pose.

    Parameters
    ----------
    motion : Motion
    character : Character, optional
        Whose skin to take; without one, a body of capsules.

    Returns
    -------
    motion : Motion
        The same in the world.
    skin : Skin

    Raises
    ------
    RequestError
        The skeleton is not the character's.
    """
    body = replace(body_character(motion, character), skeleton=motion.skeleton)
    return to_standing(motion), standing_character(body).skin


def skin_of(motion: Motion, character: Character | None = None) -> Skin:
    """The skin for a motion: the character's or, without one, a capsule per bone, with soles on the floor.

    Parameters
    ----------
    motion : Motion
    character : Character, optional

    Returns
    -------
    Skin

    Raises
    ------
    RequestError
        The skeleton is not the character's.
    """
    return body_character(motion, character).skin


def body_character(motion: Motion, character: Character | None = None) -> Character:
    """The character that a motion is written with: the given one or, without one, capsules with soles on the floor.

    Parameters
    ----------
    motion : Motion
    character : Character, optional

    Returns
    -------
    Character

    Raises
    ------
    RequestError
        The skeleton is not the character's.
    """
    if character is None:
        return capsule_character(motion.skeleton, sole_depth(motion))
    if not character.fits(motion.skeleton):
        raise RequestError(
            f"the motion's skeleton is not that of the character {character.name!r}; retarget the motion first"
        )
    return character


@functools.lru_cache(maxsize=16)
def capsule_character(skeleton: Skeleton, sole: float | None = None) -> Character:
    """A body of capsules for any skeleton.

    Parameters
    ----------
    skeleton : Skeleton
    sole : float, optional
        See `body_capsules`.

    Returns
    -------
    Character
    """
    surface = body_surface(skeleton, sole)
    joints = np.zeros((len(surface.points), 4), dtype=np.int64)
    joints[:, 0] = surface.joints
    weights = np.zeros((len(surface.points), 4))
    weights[:, 0] = 1.0
    skin = Skin(surface.points, surface.normals, surface.triangles, joints, weights, surface.sides, _PALETTE)
    return Character("capsules", skeleton, skin)


def sole_depth(motion: Motion) -> float | None:
    """How far below the toe joints capsules have their soles so that planted feet touch the floor, y = 0.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    float or None
        Metres, by the median over planted frames; None where no foot is planted near y = 0.
    """
    from kinetograph.segmentation import detect_contacts  # loads SciPy, which reading files does not need

    skeleton = motion.skeleton
    body = capsule_character(skeleton)
    times = np.arange(len(motion)) / motion.fps
    heights = [np.zeros(0)]
    for side in ("left", "right"):
        roles = [f"{side}_foot", f"{side}_toe"]
        if set(roles) <= skeleton.roles.keys():
            contacts = [note for note in detect_contacts(motion) if note.label in roles]
            planted = np.zeros(len(times), dtype=np.bool_)
            for note in contacts:
                planted[np.searchsorted(times, note.start) : np.searchsorted(times, note.stop, side="right")] = True
            joints = [skeleton.roles[role].joint for role in roles]
            points = np.flatnonzero(np.isin(body.skin.joints[:, 0], joints))
            for first in range(0, len(motion), _BLOCK):
                block = cut(motion, first, min(first + _BLOCK, len(motion)))
                heights.append(skin_heights(block, body.skin, points).min(axis=1)[planted[first : first + _BLOCK]])
    together = np.concatenate(heights)
    if not len(together):
        return None
    tall = stature(skeleton)
    depth = TOE * tall + float(np.median(together))
    return depth if _SOLES[0] * tall < depth < _SOLES[1] * tall else None


def named_motions(what: Take | Motion | Signal, kind: str) -> tuple[str, dict[str, Motion]]:
    """The name of what is written, and its motions.

    Parameters
    ----------
    what : Take, Motion or Signal
    kind : str
        The format's name, for errors.

    Returns
    -------
    name : str
        That of the take's animation where it has one, else the take's, or ``"motion"``.
    motions : dict of str to Motion
        By track.

    Raises
    ------
    RequestError
        There is no motion.
    """
    if isinstance(what, Motion):
        return "motion", {"motion": what}
    if isinstance(what, Signal):
        raise RequestError(f"{kind} files hold motions, found a signal; save it as .csv")
    motions = {track: value for track, value in what.tracks.items() if isinstance(value, Motion)}
    if not motions:
        raise RequestError(
            f"{kind} files hold motions, but take {what.name!r} has only the signals {', '.join(what.tracks)}"
        )
    return what.animation or what.name, motions
