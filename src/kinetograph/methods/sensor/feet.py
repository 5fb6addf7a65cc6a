"""The feet of a whole result: still and on the ground while they are planted, off it while they move.

Poses that are averaged over examples of several steps put a foot on the ground that is on its way, and move one that
stands. Contacts are therefore those parts of a foot's stance in which it can be held still, and a foot that moves
along the ground is lifted as a step would lift it.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from kinetograph.arrays import FloatArray
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
_CLEAR = 0.04  # metres that a moving foot is lifted
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
    motion = clean_feet(motion, detect_contacts(motion))
    contacts = still_contacts(motion, detect_contacts(motion), model)
    motion = clean_feet(motion, contacts)
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


def _ground_speed(motion: Motion, role: str) -> FloatArray:
    """The speed of a role along the ground, ``(F,)``, in the faster of the steps to and from a frame."""
    step = np.linalg.norm(np.diff(role_positions(motion, (role,))[:, 0][:, [0, 2]], axis=0), axis=1) * motion.fps
    return np.asarray(np.maximum(np.append(step, 0.0), np.insert(step, 0, 0.0)))


def _rise(motion: Motion, model: RootModel, contacts: tuple[Annotation, ...], side: str) -> FloatArray:
    """Metres that a foot is moved up, ``(F,)``."""
    own = [i for i, role in enumerate(model.roles) if role.startswith(side)]
    if not own:
        return np.zeros(len(motion))
    roles = tuple(model.roles[i] for i in own)
    over = (role_positions(motion, roles)[..., 1] - model.ground[own]).min(axis=1)
    planted = np.logical_or.reduce([contact_mask(contacts, role, len(motion), motion.fps) for role in roles])
    speed = np.max([_ground_speed(motion, role) for role in roles], axis=0)
    return to_floor(np.where(planted, 0.0, _clearance(speed, motion.fps)) - over, runs(planted), motion.fps)


def _clearance(speed: FloatArray, fps: float) -> FloatArray:
    """Metres over the ground, ``(F,)``, that a foot of some speeds is lifted at least."""
    wanted = _CLEAR * smoothstep((speed - _SLOW) / (_FAST - _SLOW))
    window = max(round(_AHEAD * fps), 1)
    return np.asarray(gaussian_filter1d(maximum_filter1d(wanted, 2 * window + 1), 0.5 * window, mode="nearest"))
