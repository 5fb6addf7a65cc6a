"""Mirroring: left and right exchange, and the world is reflected in the plane x = 0.

With S = diag(-1, 1, 1), a joint j with partner j' and world rotation G_j gives its partner the rotation
G'_j' = S G_j M_j^T, where the constant reflection M_j takes the frame of j to the frame of j' such that the bones of
j become the bones of j'. M_j is read from the rest offsets joint by joint, so the local axes of the two sides need
not be alike. Local rotations follow without kinematics: L'_j' = M_p L_j M_j^T with p the parent of j, and S for the
root's parent. Every M is S times a rotation R, so in quaternions L' = flip(R_p L conj(R_j)), flip being S . S.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.roles import JointName, find_roles, read_names
from kinetograph.skeleton import Skeleton, opposite

_S: FloatArray = np.diag([-1.0, 1.0, 1.0])
_SIMPLE: tuple[FloatArray, ...] = (
    *(_S, np.diag([1.0, 1.0, -1.0]), np.diag([1.0, -1.0, 1.0])),
    -np.eye(3),  # rigs whose right side has every axis reversed
)
_EXACT = 1e-4  # relative misfit that the digits of a file explain
_NEAR = 0.25  # relative misfit that the unlike sides of a real body explain
_GUESS_WEIGHT, _FIT_STEPS = 1e-3, 12
_FLAT = 0.05  # second singular value over the first, below which bones lie on one line


@dataclass(frozen=True, eq=False)
class MirrorPlan:
    """How motions of one skeleton are mirrored.

    Parameters
    ----------
    skeleton : Skeleton
    partners : ndarray of int, shape (J,)
        The joint on the other side of each joint; those of the midline are their own.
    reflections : ndarray, shape (J, 3, 3)
        The reflection that takes the frame of each joint to that of its partner.
    """

    skeleton: Skeleton
    partners: IntArray
    reflections: FloatArray

    def apply(self, motion: Motion) -> Motion:
        """The mirrored motion, on the same skeleton; mirroring it again gives the motion back.

        Parameters
        ----------
        motion : Motion

        Returns
        -------
        Motion

        Raises
        ------
        RequestError
            If the motion has other joints than the plan.
        """
        if motion.skeleton.names != self.skeleton.names:
            raise RequestError("this mirror plan is for a skeleton with other joints; make one for this motion's")
        frames = rot.from_matrix(_S @ self.reflections)
        above = np.concatenate([rot.identity(1), frames[self.skeleton.parents[1:]]])
        flipped = _flip(rot.multiply(rot.multiply(above, motion.rotations), rot.conjugate(frames)))
        props = _props(self.skeleton, self.partners)
        rotations = np.where(props[:, None], motion.rotations, flipped[:, self.partners])
        bones = motion.bones
        if bones is not None:
            bones = np.where(props[:, None], bones, self._bones(bones, motion.skeleton.offsets))
        return replace(motion, translation=motion.translation @ _S, rotations=rotations, bones=bones)

    def _bones(self, bones: FloatArray, offsets: FloatArray) -> FloatArray:
        """Bones that change their length keep their own rest offset and take over the other side's change."""
        above = np.concatenate([_S[None], self.reflections[self.skeleton.parents[1:]]])
        change = np.einsum("jab,fjb->fja", above, bones - offsets)
        return np.asarray(offsets + change[:, self.partners])


def mirror(motion: Motion) -> Motion:
    """A motion seen in a mirror: left and right are exchanged, and the world is reflected in the plane x = 0.

    Works on any skeleton whose sides are reflections of each other, whatever the axes of its joints. Joints are paired
    by role and, where they have none, by name.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    Motion

    Raises
    ------
    RequestError
        If a left or right joint has no partner.
    """
    return mirror_plan(motion.skeleton).apply(motion)


def mirror_plan(skeleton: Skeleton) -> MirrorPlan:
    """How motions of a skeleton are mirrored.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    MirrorPlan

    Raises
    ------
    RequestError
        If a left or right joint has no partner.

    Examples
    --------
    >>> offsets = np.array([[0.0, 0, 0], [1, 0, 0], [-1, 0, 0]])
    >>> mirror_plan(Skeleton(("hips", "l_leg", "r_leg"), np.array([-1, 0, 0]), offsets)).partners.tolist()
    [0, 2, 1]
    """
    partners = _partners(skeleton)
    return MirrorPlan(skeleton, partners, _reflections(skeleton, partners))


def _flip(q: FloatArray) -> FloatArray:
    """The rotation seen in the mirror x = 0: S . S of a quaternion, shape ``(..., 4)``."""
    return np.asarray(q * np.array([1.0, 1.0, -1.0, -1.0]))


# ---- partners ----


def _partners(skeleton: Skeleton) -> IntArray:
    names = read_names(skeleton.names)
    by_role = _pairs_by_role(skeleton)
    by_name = {name: joint for joint, name in enumerate(names)}
    partners = np.arange(len(skeleton))
    for joint in range(1, len(skeleton)):
        parent = partners[skeleton.parents[joint]]
        partner = by_role.get(joint, by_name.get(names[joint].opposite) if names[joint].side else None)
        if partner is None and not names[joint].side and parent != skeleton.parents[joint]:
            partner = _same_child(skeleton, joint, int(parent))
        elif partner is None and names[joint].side:
            raise _no_partner(skeleton, names, joint, "none is named so")
        partner = joint if partner is None else partner
        if skeleton.parents[partner] != parent and partner != joint:
            raise _no_partner(skeleton, names, joint, f"{skeleton.names[partner]!r} hangs elsewhere in the tree")
        partners[joint] = partner
    return partners


def _no_partner(skeleton: Skeleton, names: tuple[JointName, ...], joint: int, why: str) -> RequestError:
    side = names[joint].side or "one"
    other = names[joint].opposite.side or "other"
    return RequestError(
        f"cannot mirror: expected a {other} partner of the {side} joint {skeleton.names[joint]!r}, {why}; "
        "rename the joints or name their roles with --role"
    )


def _pairs_by_role(skeleton: Skeleton) -> dict[int, int]:
    roles = {**find_roles(skeleton), **skeleton.roles}
    pairs: dict[int, int] = {}
    for role, landmark in roles.items():
        partner = roles.get(opposite(role))
        if opposite(role) != role and partner is not None and partner.joint != landmark.joint:
            pairs.setdefault(landmark.joint, partner.joint)
    return {joint: partner for joint, partner in pairs.items() if pairs.get(partner) == joint}


def _same_child(skeleton: Skeleton, joint: int, parent: int) -> int | None:
    """The partner of a joint below a limb whose name has no side: the other limb's child of the same rank, if any.

    Without one, a prop in one hand, the joint is its own partner: it stays where it is and keeps its own rotations.
    """
    here, there = skeleton.children[skeleton.parents[joint]], skeleton.children[parent]
    return there[here.index(joint)] if len(here) == len(there) else None


def _props(skeleton: Skeleton, partners: IntArray) -> BoolArray:
    """Which joints, shape ``(J,)``, hang on one limb without a partner on the other."""
    out = np.zeros(len(skeleton), dtype=np.bool_)
    for joint, parent in enumerate(skeleton.parents[1:], start=1):
        out[joint] = partners[joint] == joint and (partners[parent] != parent or out[parent])
    return out


# ---- reflections of frames ----


def _reflections(skeleton: Skeleton, partners: IntArray) -> FloatArray:
    """M of every joint, the same plain one where an unlike body allows, since it leaves rotations as they are."""
    bones = [_bones(skeleton, partners, joint) for joint in range(len(skeleton))]
    by_joint = _joint_by_joint(skeleton, partners, bones)
    if _worst(by_joint, bones) > _EXACT:
        for plain in _SIMPLE:
            everywhere = [plain] * len(skeleton)
            if _worst(everywhere, bones) <= _NEAR:
                return np.array(everywhere)
    return np.array(by_joint)


def _worst(reflections: list[FloatArray], bones: list[tuple[FloatArray, FloatArray]]) -> float:
    return max(_misfit(m, *pair) for m, pair in zip(reflections, bones, strict=True))


def _joint_by_joint(
    skeleton: Skeleton, partners: IntArray, bones: list[tuple[FloatArray, FloatArray]]
) -> list[FloatArray]:
    """M of every joint by itself; those that bones on one line leave open follow their limb, or else their parent."""
    known = [_determined(*pair) for pair in bones]
    out: list[FloatArray] = []
    for joint, (here, there) in enumerate(bones):
        guesses = [m for j in _relatives(skeleton, partners, joint) if (m := known[j]) is not None]
        own = known[joint]
        m = _likeliest(here, there, [*guesses, *_SIMPLE]) if own is None else own
        known[joint] = m
        known[partners[joint]] = m.T  # mirroring twice is the identity
        out.append(m)
    return out


def _bones(skeleton: Skeleton, partners: IntArray, joint: int) -> tuple[FloatArray, FloatArray]:
    """Bones below a joint and their partners below its partner, both ``(B, 3)``."""
    partner = partners[joint]
    props = _props(skeleton, partners)
    children = [child for child in skeleton.children[joint] if not props[child]]
    ends, other_ends = (skeleton.end_offsets[skeleton.end_parents == j] for j in (joint, partner))
    if len(ends) != len(other_ends) or (partner == joint and len(ends) > 1):
        ends = other_ends = np.zeros((0, 3))
    here = np.concatenate([skeleton.offsets[children], ends])
    return here, np.concatenate([skeleton.offsets[partners[children]], other_ends])


def _relatives(skeleton: Skeleton, partners: IntArray, joint: int) -> list[int]:
    """Joints whose frames are likely to mirror alike: of a limb those further out first, of the trunk the parent."""
    parent = [int(skeleton.parents[joint])] if joint else []
    limb = partners[joint] != joint
    below: list[int] = [joint]
    for j in below:
        below.extend(child for child in skeleton.children[j] if (partners[child] != child) == limb)
    return below[1:] + parent if limb else parent + below[1:]


def _misfit(m: FloatArray, here: FloatArray, there: FloatArray) -> float:
    """How far ``m`` takes bones from their partners, relative to their length."""
    size = float(np.linalg.norm(here) + np.linalg.norm(there)) / 2
    return float(np.linalg.norm(here @ m.T - there)) / size if size > 0 else 0.0


def _determined(here: FloatArray, there: FloatArray) -> FloatArray | None:
    """The reflection that takes bones to their partners, or None where the bones lie on one line and leave it open."""
    spread = np.linalg.svd(here, compute_uv=False)
    if len(spread) < 2 or spread[1] <= _FLAT * spread[0]:
        return None
    return _likeliest(here, there, sorted(_SIMPLE, key=lambda m: _misfit(m, here, there)))


def _likeliest(here: FloatArray, there: FloatArray, guesses: list[FloatArray]) -> FloatArray:
    """The first guess that fits exactly, or else an exact fit, or else the first guess that fits a real body."""
    for guess in guesses:
        if _misfit(guess, here, there) <= _EXACT:
            return guess
    fitted = _fit(here, there, guesses[0])
    if _misfit(fitted, here, there) <= _EXACT:
        return fitted
    return next((guess for guess in guesses if _misfit(guess, here, there) <= _NEAR), fitted)


def _fit(here: FloatArray, there: FloatArray, guess: FloatArray) -> FloatArray:
    """The improper orthogonal matrix nearest to taking ``here`` to ``there``, and where that is open, to ``guess``."""
    moment = there.T @ here / np.sum((here * here + there * there) / 2)
    m = guess
    for _ in range(_FIT_STEPS):  # the guess weighs little, and less with every step
        u, _, vt = np.linalg.svd(moment + _GUESS_WEIGHT * m)
        u[:, 2] *= -np.sign(np.linalg.det(u @ vt))
        m = u @ vt
    return m
