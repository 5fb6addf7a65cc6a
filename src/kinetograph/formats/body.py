"""The skin that a motion is written with: a character's where one is given, else capsules."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.character import Character, Skin
from kinetograph.errors import RequestError
from kinetograph.formats.capsules import rest_positions
from kinetograph.formats.surface import body_surface
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

# linear colours: a light grey, blue and vermilion, which colour-blind people can tell apart
_PALETTE = (("middle", (0.55, 0.55, 0.55)), ("left", (0.03, 0.22, 0.50)), ("right", (0.62, 0.13, 0.03)))


def body_of(skeleton: Skeleton, character: Character | None = None) -> tuple[Skin, FloatArray]:
    """The skin that a motion of a skeleton is written with, and the rest positions of its joints.

    Parameters
    ----------
    skeleton : Skeleton
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
    return skin_of(skeleton, character), rest_positions(skeleton)


def skin_of(skeleton: Skeleton, character: Character | None = None) -> Skin:
    """The skin for a skeleton: the character's or, without one, a capsule per bone.

    Parameters
    ----------
    skeleton : Skeleton
    character : Character, optional

    Returns
    -------
    Skin

    Raises
    ------
    RequestError
        The skeleton is not the character's.
    """
    if character is not None:
        if not character.fits(skeleton):
            raise RequestError(
                f"the motion's skeleton is not that of the character {character.name!r}; retarget the motion first"
            )
        return character.skin
    surface = body_surface(skeleton)
    joints = np.zeros((len(surface.points), 4), dtype=np.int64)
    joints[:, 0] = surface.joints
    weights = np.zeros((len(surface.points), 4))
    weights[:, 0] = 1.0
    return Skin(surface.points, surface.normals, surface.triangles, joints, weights, surface.sides, _PALETTE)


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
        The take's, or ``"motion"``.
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
    return what.name, motions
