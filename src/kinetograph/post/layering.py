"""Layers: a part of the body as another motion has it, joined at the spine.

The driven part keeps its joints' rotations. The chest is brought to where it is in the layer, as seen from where the
body faces: first about the vertical, the hips following by the share that recordings show, then, by a share, about the
other axes; the spine's joints take equal parts. Mass that has moved is made up for by the hips, by the share that
recordings show, and the legs keep the feet where they were.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.filters import smoothed
from kinetograph.kinematics import forward, role_positions
from kinetograph.motion import Motion, sample
from kinetograph.post.balance import Following, facing_of, mass_above
from kinetograph.post.easing import smoothstep
from kinetograph.post.footskate import hip_drop
from kinetograph.post.limits import JointLimits, JointRange, limit_limbs
from kinetograph.post.reaching import held_feet, reach_limbs
from kinetograph.skeleton import ROLES, Skeleton
from kinetograph.synthesis import Piece

PARTS: dict[str, tuple[str, ...]] = {
    "arms": ("left arm", "right arm"),
    "left arm": ("left_collar", "left_shoulder", "left_elbow", "left_hand"),
    "right arm": ("right_collar", "right_shoulder", "right_elbow", "right_hand"),
    "head": ("neck", "head"),
    "upper body": ("arms", "head", "spine", "chest"),
}
"""Parts of the body by name: the roles and parts that they consist of, with all that hangs on them but the legs."""
FURTHEST = 0.15
"""Metres that hips are moved to keep the balance at most."""
CALM = 0.3
"""Width in seconds of the Gaussian that smooths how hips keep the balance."""


@dataclass(frozen=True, eq=False)
class Layer:
    """A part of the body that another motion drives.

    Parameters
    ----------
    motion : Motion
    parts : tuple of str
        Names of `PARTS`, or roles, each with what hangs on it.
    start : float
        Seconds of the result at which its first frame is.
    ease : float
        Seconds over which it comes and goes, where it begins later or ends earlier than the result.
    hold : bool
        Whether its first and last pose are held there instead.
    name : str
        What reports call it.
    pieces : tuple of Piece
        Where it comes from, in its own seconds.

    Raises
    ------
    RequestError
        For an ease below 0, a part that does not exist, and none.
    """

    motion: Motion
    parts: tuple[str, ...]
    start: float = 0.0
    ease: float = 0.3
    hold: bool = False
    name: str = "layer"
    pieces: tuple[Piece, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", tuple(self.parts))
        if not (np.isfinite(self.ease) and self.ease >= 0 and np.isfinite(self.start)):
            raise RequestError(f"layer {self.name!r}: ease must be 0 or more, found {self.ease:g}")
        unknown = [part for part in self.parts if part not in PARTS and part not in ROLES]
        if unknown or not self.parts:
            known = ", ".join(PARTS)
            raise RequestError(
                f"layer {self.name!r}: expected parts among {known}, or roles; found {unknown or 'none'}"
            )


@dataclass(frozen=True)
class LayerSettings:
    """How layers are joined to the rest of the body.

    Parameters
    ----------
    following : Following
        How hips follow; see `learn_following`.
    tilt : float
        Share of the chest's rotation about the ground's axes that is taken over, from 0 to 1.
    ranges : sequence of JointRange
        What limbs and spine may do at most.
    limits : JointLimits
        How far beyond they may go.
    """

    following: Following = field(default_factory=Following)
    tilt: float = 1.0
    ranges: Sequence[JointRange] = ()
    limits: JointLimits = field(default_factory=JointLimits)


def driven_joints(skeleton: Skeleton, parts: Sequence[str]) -> tuple[int, ...]:
    """The joints of some parts of the body, parents first.

    Parameters
    ----------
    skeleton : Skeleton
    parts : sequence of str
        Names of `PARTS`, or roles.

    Returns
    -------
    tuple of int

    Raises
    ------
    RequestError
        Where the skeleton has none of a part's roles, or the part has the root.
    """
    legs = _below(skeleton, [f"{side}_{limb}" for side in ("left", "right") for limb in ("hip", "knee", "foot")])
    chosen: set[int] = set()
    for part in parts:
        roles = [role for role in _roles_of(part) if role in skeleton.roles]
        joints = _below(skeleton, roles)
        joints = joints if part.split("_")[-1] in _LEG else joints - legs
        if not joints or 0 in joints:
            raise RequestError(
                f"a layer cannot drive {part!r} of this body; it has the roles {', '.join(skeleton.roles)}"
            )
        chosen |= joints
    return tuple(sorted(chosen))


_LEG = ("hip", "knee", "foot", "toe")


def _roles_of(part: str) -> list[str]:
    if part not in PARTS:
        return [part]
    return [role for each in PARTS[part] for role in ([each] if each == part else _roles_of(each))]


def _below(skeleton: Skeleton, roles: Sequence[str]) -> set[int]:
    """The joints of some roles and all that hangs on them."""
    found = {skeleton.roles[role].joint for role in roles if role in skeleton.roles}
    for joint in range(len(skeleton)):
        if int(skeleton.parents[joint]) in found:
            found.add(joint)
    return found


def layer_weights(layer: Layer, frames: int, fps: float) -> FloatArray:
    """How much of a layer each frame of a result has, ``(F,)``, from 0 to 1.

    Parameters
    ----------
    layer : Layer
    frames : int
        F.
    fps : float
    """
    times = np.arange(frames) / fps
    stop = layer.start + layer.motion.duration
    last, weights = (frames - 1) / fps, np.ones(frames)
    if layer.hold:
        return weights
    ease = max(layer.ease, 1e-9)
    if layer.start > 1e-9:
        weights *= smoothstep((times - layer.start) / ease)
    if stop < last - 1e-9:
        weights *= smoothstep((stop - times) / ease)
    return weights * ((times >= layer.start - 1e-9) & (times <= stop + 1e-9))


def with_layer(motion: Motion, layer: Layer, settings: LayerSettings | None = None) -> Motion:
    """A motion with a part of the body as a layer has it.

    Parameters
    ----------
    motion : Motion
    layer : Layer
        Its motion is of the same skeleton.
    settings : LayerSettings, optional

    Returns
    -------
    Motion
        Feet are where they were, unless the layer drives a leg.
    """
    settings = settings or LayerSettings()
    if len(layer.motion.skeleton) != len(motion.skeleton):
        raise RequestError(f"layer {layer.name!r}: expected the body of the motion; retarget the layer first")
    weights = layer_weights(layer, len(motion), motion.fps)
    on = weights > 0
    if not on.any():
        return motion
    times = np.clip(np.arange(len(motion)) / motion.fps - layer.start, 0.0, layer.motion.duration)
    other = sample(layer.motion, times, motion.fps)
    joints = driven_joints(motion.skeleton, layer.parts)
    rotations = motion.rotations.copy()
    own = np.asarray(joints)
    rotations[:, own] = rot.slerp(rotations[:, own], other.rotations[:, own], weights[:, None])
    placed = replace(motion, rotations=rotations)
    if _carries_arms(motion.skeleton, joints):
        placed = _joined(placed, (motion, other), joints, weights, settings)
        placed = _balanced(placed, motion, weights, settings)
    return _within(_standing_on(placed, motion, joints), motion, on, settings)


def _carries_arms(skeleton: Skeleton, joints: Sequence[int]) -> bool:
    """Whether a driven part is joined to the body at the chest."""
    arms = {f"{side}_shoulder" for side in ("left", "right")} & set(skeleton.roles)
    return any(skeleton.roles[role].joint in joints for role in arms)


def _spine(skeleton: Skeleton, joints: Sequence[int]) -> list[int]:
    """The joints that bring the driven part to where it is to be, from the root's child to the one that it hangs on.

    Where the driven part begins at the root's child, it is that one. None where shoulders are the root's children.
    """
    sides = [skeleton.roles.get(f"{side}_shoulder") for side in ("left", "right")]
    lines = [_line(skeleton, side.joint) for side in sides if side is not None and side.joint in joints]
    above = [joint for joint in lines[0] if joint not in joints]
    shared = [joint for joint in lines[0] if all(joint in line for line in lines)]
    return above or (shared[:1] if "spine" in skeleton.roles or "chest" in skeleton.roles else [])


def _line(skeleton: Skeleton, joint: int) -> list[int]:
    """A joint and those above it, from the root's child down."""
    line = []
    while joint > 0:
        line.append(joint)
        joint = int(skeleton.parents[joint])
    return line[::-1]


def _joined(
    placed: Motion, bodies: tuple[Motion, Motion], joints: Sequence[int], weights: FloatArray, settings: LayerSettings
) -> Motion:
    """The motion with its chest where that of the layer is, as seen from where the bodies face."""
    base, other = bodies
    skeleton = placed.skeleton
    spine = _spine(skeleton, joints)
    if not spine:
        return placed
    there = spine[-1]
    turned = rot.about("y", facing_of(base) - facing_of(other))
    target = rot.multiply(turned, forward(other)[1][:, there])
    world = forward(placed)[1]
    gap = rot.multiply(target, rot.conjugate(world[:, there]))
    yaw = rot.heading(gap)
    rest = rot.log(rot.multiply(gap, rot.about("y", -yaw)))
    rotations = placed.rotations.copy()
    hips = rot.about("y", settings.following.turning * weights * yaw)
    rotations[:, 0] = rot.multiply(hips, rotations[:, 0])
    yaw = (1.0 - settings.following.turning) * weights * yaw
    wanted = {0: rotations[:, 0]}
    for number, joint in enumerate(spine, start=1):
        share = number / len(spine)
        bent = rot.exp(share * settings.tilt * weights[:, None] * rest)
        whole = rot.multiply(rot.multiply(bent, rot.about("y", share * yaw)), rot.multiply(hips, world[:, joint]))
        parent = int(skeleton.parents[joint])
        rotations[:, joint] = rot.multiply(rot.conjugate(wanted[parent]), whole)
        wanted[joint] = whole
    return _looking_on(replace(placed, rotations=rot.normalize(rotations)), base, joints, spine)


def _looking_on(placed: Motion, base: Motion, joints: Sequence[int], spine: Sequence[int]) -> Motion:
    """The head looks where it did, unless it is driven: its neck takes back what the chest was rotated by."""
    roles = placed.skeleton.roles
    neck = next((roles[role].joint for role in ("neck", "head") if role in roles), 0)
    parent = int(placed.skeleton.parents[neck])
    if neck in joints or parent not in spine:
        return placed
    rotations = placed.rotations.copy()
    above = forward(placed)[1][:, parent]
    rotations[:, neck] = rot.multiply(rot.conjugate(above), forward(base)[1][:, neck])
    return replace(placed, rotations=rot.normalize(rotations))


def _balanced(placed: Motion, base: Motion, weights: FloatArray, settings: LayerSettings) -> Motion:
    """The motion with its hips moved so that, by a share, the mass above them stays where it was on the ground."""
    moved = (mass_above(placed) - mass_above(base)) * [1.0, 0.0, 1.0]
    shift = -settings.following.balance * smoothed(moved, CALM * placed.fps, axis=0)
    length = np.linalg.norm(shift, axis=1, keepdims=True)
    shift *= np.minimum(1.0, FURTHEST / np.maximum(length, 1e-9))
    return replace(placed, translation=placed.translation + weights[:, None] * shift)


def _standing_on(placed: Motion, base: Motion, joints: Sequence[int]) -> Motion:
    """The motion with its feet where they were, the hips as low as that takes; driven legs are left as they are."""
    held = held_feet(base, [], joints)
    offsets = {limb.role.split("_")[0]: role_positions(base, (limb.role,))[:, 0] for limb in held}
    offsets = {side: place - role_positions(placed, (f"{side}_foot",))[:, 0] for side, place in offsets.items()}
    lower = replace(placed, translation=placed.translation - hip_drop(placed, offsets))
    return reach_limbs(lower, held)


def _within(placed: Motion, base: Motion, on: BoolArray, settings: LayerSettings) -> Motion:
    """The motion with its legs within their limits, and its frames without a layer as they were."""
    legs = {placed.skeleton.roles[role].joint for role in placed.skeleton.roles if role.split("_")[-1] in _LEG}
    own = [limit for limit in settings.ranges if limit.joint in legs]
    held = limit_limbs(placed, own, _with_arms_of(base, placed, legs), settings.limits)
    rotations = np.where(on[:, None, None], held.rotations, base.rotations)
    translation = np.where(on[:, None], held.translation, base.translation)
    return replace(placed, rotations=rotations, translation=translation)


def _with_arms_of(base: Motion, placed: Motion, legs: set[int]) -> Motion:
    """The motion before legs were moved: those of the one, all else of the other."""
    rotations = placed.rotations.copy()
    own = sorted(legs)
    rotations[:, own] = base.rotations[:, own]
    return replace(placed, rotations=rotations)
