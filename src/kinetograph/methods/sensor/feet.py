"""The feet of a whole result: still and on the ground while they are planted, off it while they move.

Poses that are averaged over examples of several steps put a foot on the ground that is on its way, and move one that
stands. Contacts are therefore those parts of a foot's stance in which it can be held still, and a foot that moves
along the ground is lifted as a step would lift it. Legs are bent no more than that needs: the body goes up or down with
the feet that stand, and a foot within a centimetre of the ground is left there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.kinematics import role_positions
from kinetograph.methods.sensor.root import RootModel
from kinetograph.motion import Motion
from kinetograph.post import LEG, clean_feet, contact_mask, has_limb, raise_feet, smoothstep, to_floor
from kinetograph.segmentation import detect_contacts, runs
from kinetograph.take import Annotation

_SIDES = ("left", "right")
_STILL = 0.3  # metres per second up to which a held point counts as planted
_LOW, _SPINS = 0.02, 0.45  # metres over the ground, and metres per second, of a point that a planted foot drags along
_SHORTEST = 0.06  # seconds of a plant
_CLEAR = 0.02  # metres that a moving foot is lifted
_NEAR = 0.01  # metres over or under the ground at which a planted foot is left
_LEVEL = 0.1  # seconds of a Gaussian over what the body goes up and down
_SLOW, _FAST = 0.1, 0.7  # metres per second at which lifting begins, and is complete
_AHEAD = 0.05  # seconds that a foot is lifted before it moves, and after


def finished_feet(motion: Motion, model: RootModel) -> tuple[Motion, tuple[Annotation, ...]]:
    """A motion with its feet held and lifted, and their contacts.

    Parameters
    ----------
    motion : Motion
    model : RootModel

    Returns
    -------
    motion : Motion
    contacts : tuple of Annotation
    """
    contacts = still_contacts(motion, detect_contacts(motion), model)
    motion = _levelled(clean_feet(motion, contacts), model, contacts)
    rises = {side: _rise(motion, model, contacts, side) for side in _SIDES if has_limb(motion, side, LEG)}
    return raise_feet(motion, rises), contacts


def still_contacts(motion: Motion, contacts: tuple[Annotation, ...], model: RootModel) -> tuple[Annotation, ...]:
    """The parts of contacts in which their point all but stands still, and the foot does not spin about it.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
    model : RootModel

    Returns
    -------
    tuple of Annotation
    """
    low = role_positions(motion, model.roles)[..., 1] - model.ground < _LOW
    speeds = np.stack([_ground_speed(motion, role) for role in model.roles], axis=1)
    kept: list[Annotation] = []
    for i, role in enumerate(model.roles):
        same = [k for k, other in enumerate(model.roles) if other[:4] == role[:4]]
        spins = (low[:, same] & (speeds[:, same] > _SPINS)).any(axis=1)
        mask = contact_mask(contacts, role, len(motion), motion.fps) & (speeds[:, i] < _STILL) & ~spins
        spans = [(a, b) for a, b in runs(mask) if (b - a) / motion.fps >= _SHORTEST]
        kept += [Annotation("motion", "contact", role, a / motion.fps, (b - 1) / motion.fps) for a, b in spans]
    return tuple(sorted(kept, key=lambda note: (note.start, note.label)))


def _levelled(motion: Motion, model: RootModel, contacts: tuple[Annotation, ...]) -> Motion:
    """The motion as high as its planted feet say, in the mean over them; between plants in a straight line."""
    heights, planted = [], []
    for side in _SIDES:
        if own := _of_side(model, side):
            heights.append(_over_ground(motion, model, own))
            planted.append(_is_planted(motion, model, own, contacts))
    if not np.any(planted):
        return motion
    count = np.sum(planted, axis=0)
    known = np.flatnonzero(count)
    over = np.where(planted, heights, 0.0).sum(axis=0)[known] / count[known]
    away = gaussian_filter1d(np.interp(np.arange(len(motion)), known, over), _LEVEL * motion.fps, mode="nearest")
    return replace(motion, translation=motion.translation - np.outer(away, [0.0, 1.0, 0.0]))


def _of_side(model: RootModel, side: str) -> list[int]:
    """The numbers of the points of one foot."""
    return [i for i, role in enumerate(model.roles) if role.startswith(side)]


def _over_ground(motion: Motion, model: RootModel, own: list[int]) -> FloatArray:
    """Height in metres, ``(F,)``, of the lowest of a foot's points over where it is when it is planted."""
    roles = tuple(model.roles[i] for i in own)
    return np.asarray((role_positions(motion, roles)[..., 1] - model.ground[own]).min(axis=1))


def _is_planted(motion: Motion, model: RootModel, own: list[int], contacts: tuple[Annotation, ...]) -> BoolArray:
    masks = [contact_mask(contacts, model.roles[i], len(motion), motion.fps) for i in own]
    return np.asarray(np.logical_or.reduce(masks))


def _ground_speed(motion: Motion, role: str) -> FloatArray:
    """The speed of a role along the ground, ``(F,)``, in the faster of the steps to and from a frame."""
    step = np.linalg.norm(np.diff(role_positions(motion, (role,))[:, 0][:, [0, 2]], axis=0), axis=1) * motion.fps
    return np.asarray(np.maximum(np.append(step, 0.0), np.insert(step, 0, 0.0)))


def _rise(motion: Motion, model: RootModel, contacts: tuple[Annotation, ...], side: str) -> FloatArray:
    """Metres that a foot is moved up, ``(F,)``."""
    own = _of_side(model, side)
    if not own:
        return np.zeros(len(motion))
    over, planted = _over_ground(motion, model, own), _is_planted(motion, model, own, contacts)
    speed = np.max([_ground_speed(motion, model.roles[i]) for i in own], axis=0)
    away = np.sign(over) * np.maximum(np.abs(over) - _NEAR, 0.0)
    up = np.where(planted, -away, _clearance(speed, motion.fps) - over)
    return to_floor(up, runs(planted), motion.fps)


def _clearance(speed: FloatArray, fps: float) -> FloatArray:
    """Metres over the ground, ``(F,)``, that a foot of some speeds is lifted at least."""
    wanted = _CLEAR * smoothstep((speed - _SLOW) / (_FAST - _SLOW))
    window = max(round(_AHEAD * fps), 1)
    return np.asarray(gaussian_filter1d(maximum_filter1d(wanted, 2 * window + 1), 0.5 * window, mode="nearest"))
