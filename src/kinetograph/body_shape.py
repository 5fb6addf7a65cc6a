"""Arms, legs, neck and head of a body whose names say nothing, from the shape of its tree.

A limb is a chain with two long bones of like length that follow each other, of which each may be cut into pieces by
joints that twist. Legs are the pair of like limbs nearer the root, arms a pair further on, and left is up x forward,
where feet or knees point forward. Hair, skirts, fingers and wings are chains too: of all pairs of pairs the one whose
lengths are most like a person's is taken.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.skeleton import Skeleton

_ALIKE = 0.06  # relative difference of the lengths of two sides
_UNEVEN = 2.5  # thigh over shank, upper arm over forearm, and their inverses, stay below this
_LONGEST = 12  # joints of a chain that are looked at
_MOST_CHAINS, _MOST_LIMBS = (
    16,
    4,
)  # the longest chains of a joint, and the likeliest limbs of a chain, that are looked at
_MOST_PAIRS = 60  # of limbs
_WORST = 30.0  # sum of squares, in standard deviations, beyond which no pair of pairs is a person
_TOP_OF_HEAD = 0.16  # of a leg: the last bone of a neck is longer where it ends at the top of the head
# a person's proportions as logarithms: mean and standard deviation, wide enough for children and cartoons
_HALVES = (0.05, 0.25)  # upper over lower bone
_BENT_PIECES = 0.04  # how far a twisting joint lies beside its bone, of the bone
_SKIPPED = 0.8  # the cost of a joint inside a bone
_HELD = 8.0  # the most that what comes after a limb costs, as a hand may hold something
_ARM_LENGTH = (np.log(0.7), 0.3)  # arm over leg
_TRUNK = (np.log(0.6), 0.4)  # hips to chest over leg
_SHORTER = (0.0, 0.35)  # leg over the longest limb


@dataclass(frozen=True)
class _Kind:
    """What comes before the upper joint of a limb and after the lower one, of its two bones: means and deviations."""

    before: tuple[float, float]
    after: tuple[float, float]


_LEG = _Kind((0.0, 0.15), (0.25, 0.2))  # a foot
_ARM = _Kind((0.2, 0.25), (0.3, 0.25))  # a collar bone, a hand


@dataclass(frozen=True, eq=False)
class Limb:
    """The three joints of a leg or an arm.

    Parameters
    ----------
    before : tuple of int
        The joints of its chain above the upper one, such as a collar bone.
    upper, middle, lower : int
        Hip, knee and ankle, or shoulder, elbow and wrist.
    tip : ndarray, shape (3,)
        Where the chain goes on from the lower joint; that joint where it ends there.
    length, thick : float
        Of the two bones, and of the upper one.
    cost : float
        How unlike a person's it is.
    """

    before: tuple[int, ...]
    upper: int
    middle: int
    lower: int
    tip: FloatArray
    length: float
    thick: float
    cost: float


_Pair = tuple[int, Limb, Limb]


@dataclass(frozen=True, eq=False)
class WorldPose:
    """Where the joints of a body are and how they are rotated.

    Parameters
    ----------
    positions : ndarray, shape (J, 3)
    rotations : ndarray, shape (J, 4)
    """

    positions: FloatArray
    rotations: FloatArray


def standing_pose(skeleton: Skeleton) -> WorldPose:
    """The stance of a skeleton, or else its rest pose, relative to the root."""
    positions = np.zeros((len(skeleton), 3))
    rotations = rot.identity(len(skeleton)) if skeleton.stance is None else skeleton.stance.copy()
    for joint, parent in enumerate(skeleton.parents[1:].tolist(), start=1):
        positions[joint] = positions[parent] + rot.rotate(rotations[parent], skeleton.offsets[joint])
        rotations[joint] = rot.multiply(rotations[parent], rotations[joint])
    return WorldPose(positions, rotations)


def limbs_by_shape(skeleton: Skeleton, pose: WorldPose | None = None) -> dict[str, int]:
    """The joints of arms and legs by role, empty where no two pairs of limbs are like a person's.

    Parameters
    ----------
    skeleton : Skeleton
    pose : WorldPose, optional
        In which it stands; its stance, or else its rest pose, by default.

    Returns
    -------
    dict of str to int
        Empty, too, where sides do not show, as the body may face either way.
    """
    tree = _Tree(skeleton, pose or standing_pose(skeleton))
    places = tree.places
    found = _best_pairs(tree, _pairs(tree, _LEG), _pairs(tree, _ARM))
    if found is None:
        return {}
    (_, *legs), (chest, *arms) = found
    up = places[chest] - np.mean([places[leg.lower] for leg in legs], axis=0)
    left = np.cross(up, _forward(places, legs, up))
    if not np.any(left):
        return {}
    sides = _sided(places, legs, left, ("hip", "knee", "foot"))
    return sides | _sided(places, arms, left, ("shoulder", "elbow", "hand")) if sides else {}


def neck_by_shape(skeleton: Skeleton, chest: int, limbs: dict[str, int], pose: WorldPose | None = None) -> list[int]:
    """Neck and head, or what of them shows, of a body whose limbs are known.

    Parameters
    ----------
    skeleton : Skeleton
    chest : int
        Where the arms meet.
    limbs : dict of str to int
        Joints by role.
    pose : WorldPose, optional
        As for `limbs_by_shape`.

    Returns
    -------
    list of int
        None, the neck, or the neck and the head.
    """
    tree = _Tree(skeleton, pose or standing_pose(skeleton))
    places = tree.places
    taken = {joint for limb in limbs.values() for joint in (limb, *tree.above(limb))}
    feet = [limbs[role] for role in ("left_foot", "right_foot") if role in limbs]
    if not feet:
        return []
    up = places[chest] - np.mean([places[foot] for foot in feet], axis=0)
    leg = float(np.linalg.norm(up)) / 1.5
    free = [child for child in skeleton.children[chest] if child not in taken]
    rises = {child: max(float((places[j] - places[chest]) @ up) for j in (child, *tree.below(child))) for child in free}
    rises = {child: rise for child, rise in rises.items() if rise > 0.1 * leg * np.linalg.norm(up)}
    if not rises:
        return []
    neck = max(rises, key=lambda child: rises[child])
    line = [neck]
    while len(below := [j for j in skeleton.children[line[-1]] if np.any(skeleton.offsets[j])]) == 1:
        line.append(below[0])
    if len(line) > 2 and not below and np.linalg.norm(skeleton.offsets[line[-1]]) > _TOP_OF_HEAD * leg:
        line.pop()
    return [neck, line[-1]] if len(line) > 1 else [neck]


def longest_chain(skeleton: Skeleton, starts: Sequence[int]) -> int:
    """Of some joints the one on which the longest chain hangs, its own bone included."""
    tree = _Tree(skeleton, standing_pose(skeleton))
    return max(starts, key=lambda joint: tree.reach[joint] + tree.bones[joint])


def _forward(places: FloatArray, legs: Sequence[Limb], up: FloatArray) -> FloatArray:
    """Where the feet point or, without feet, the knees; zero where neither shows it."""
    ahead = np.mean([leg.tip - places[leg.lower] for leg in legs], axis=0)
    if np.linalg.norm(np.cross(up, ahead)) >= 0.3 * np.linalg.norm(up) * np.linalg.norm(ahead) and np.any(ahead):
        return np.asarray(ahead)
    # no feet, or feet along the legs
    knees = np.mean([places[leg.middle] - 0.5 * (places[leg.upper] + places[leg.lower]) for leg in legs], axis=0)
    size = float(np.mean([leg.length for leg in legs]))
    return np.asarray(knees) if np.linalg.norm(np.cross(up, knees)) > 0.01 * size * np.linalg.norm(up) else np.zeros(3)


def _sided(places: FloatArray, limbs: Sequence[Limb], left: FloatArray, parts: Sequence[str]) -> dict[str, int]:
    across = places[limbs[0].upper] - places[limbs[1].upper]
    cosine = float(across @ left) / (float(np.linalg.norm(across) * np.linalg.norm(left)) or 1.0)
    if abs(cosine) < 0.7:
        return {}
    out: dict[str, int] = {}
    for side, limb in zip(("left", "right"), limbs if cosine > 0 else limbs[::-1], strict=True):
        out |= {f"{side}_{part}": j for part, j in zip(parts, (limb.upper, limb.middle, limb.lower), strict=True)}
        if "elbow" in parts and limb.before:
            out[f"{side}_collar"] = limb.before[-1]
    return out


class _Tree:
    """A skeleton's joints in its standing pose, and the longest chain that hangs on each."""

    def __init__(self, skeleton: Skeleton, pose: WorldPose) -> None:
        self.skeleton, self.places, self.facing = skeleton, pose.positions, pose.rotations
        self.bones = np.linalg.norm(skeleton.offsets, axis=1)
        self.reach = np.zeros(len(skeleton))
        for joint in range(len(skeleton) - 1, 0, -1):
            parent = skeleton.parents[joint]
            self.reach[parent] = max(self.reach[parent], self.reach[joint] + self.bones[joint])

    def above(self, joint: int) -> Iterator[int]:
        """The joint's parent, that one's parent, up to the root."""
        while (joint := int(self.skeleton.parents[joint])) >= 0:
            yield joint

    def below(self, joint: int) -> Iterator[int]:
        """The descendants of a joint."""
        todo = list(self.skeleton.children[joint])
        while todo:
            joint = todo.pop()
            yield joint
            todo.extend(self.skeleton.children[joint])

    def chain(self, start: int) -> list[int]:
        """The longest chain from a joint down."""
        chain = [start]
        while len(chain) < _LONGEST and (below := self.skeleton.children[chain[-1]]):
            chain.append(max(below, key=lambda j: self.reach[j] + self.bones[j]))
        return chain


def _pairs(tree: _Tree, kind: _Kind) -> list[_Pair]:
    """Pairs of like limbs that branch off at one joint, with that joint; the longest limbs first."""
    out: list[_Pair] = []
    for top in range(len(tree.skeleton)):
        starts = [child for child in tree.skeleton.children[top] if tree.skeleton.children[child]]
        if len(starts) < 2:
            continue
        starts = sorted(starts, key=lambda child: -tree.reach[child])[:_MOST_CHAINS]
        limbs = {start: _limbs(tree, start, kind) for start in starts}
        for a, b in combinations(starts, 2):
            like = [(m, n) for m in limbs[a] for n in limbs[b] if _alike(m, n)]
            if like:
                best = min(like, key=lambda pair: pair[0].cost + pair[1].cost)
                out.append((top, *best))
    out.sort(key=lambda pair: -pair[1].length)
    return out[:_MOST_PAIRS]


def _alike(a: Limb, b: Limb) -> bool:
    pairs = ((a.length, b.length), (a.thick, b.thick))
    return len(a.before) == len(b.before) and all(abs(x - y) <= _ALIKE * max(x, y) for x, y in pairs)


def _limbs(tree: _Tree, start: int, kind: _Kind) -> list[Limb]:
    """The limbs that a chain may be, one for every choice of its three joints that is not unlikely."""
    chain = tree.chain(start)
    at = tree.places[chain]
    along = [0.0, *np.cumsum(np.linalg.norm(np.diff(at, axis=0), axis=1)).tolist()]
    ends = tree.skeleton.end_offsets[tree.skeleton.end_parents == chain[-1]]
    whole = along[-1] + (float(np.linalg.norm(ends[0])) if len(ends) else 0.0)
    limbs: list[Limb] = []
    for cost, i, j, k in sorted(_choices(along, whole, kind)):
        if len(limbs) == _MOST_LIMBS:
            break
        cost += (_beside(at[i : j + 1]) + _beside(at[j : k + 1])) ** 2
        if cost < _WORST:
            tip, sizes = _tip(tree, chain, k), (along[k] - along[i], along[j] - along[i])
            limbs.append(Limb(tuple(chain[:i]), chain[i], chain[j], chain[k], tip, *sizes, cost))
    return limbs


def _choices(along: list[float], whole: float, kind: _Kind) -> Iterator[tuple[float, int, int, int]]:
    """Choices of three joints of a chain, by how far along it they are, with what the lengths cost."""
    for i, j, k in combinations(range(len(along)), 3):
        upper, lower = along[j] - along[i], along[k] - along[j]
        if 0.0 < max(upper, lower) < _UNEVEN * min(upper, lower):
            size = upper + lower
            cost = _squared(math.log(upper / lower), _HALVES) + _squared(along[i] / size, kind.before)
            cost += min(_squared((whole - along[k]) / size, kind.after), _HELD) + _SKIPPED * (k - i - 2)
            if cost < _WORST:
                yield cost, i, j, k


def _tip(tree: _Tree, chain: list[int], k: int) -> FloatArray:
    """Where a chain goes on from a joint."""
    beyond = [joint for joint in chain[k + 1 :] if np.any(tree.places[joint] != tree.places[chain[k]])]
    if beyond:
        return np.asarray(tree.places[beyond[0]])
    skeleton, lower = tree.skeleton, chain[k]
    ends = skeleton.end_offsets[skeleton.end_parents == lower]
    if not len(ends):
        return np.asarray(tree.places[lower])
    return np.asarray(tree.places[lower] + rot.rotate(tree.facing[lower], ends[0]))


def _beside(points: FloatArray) -> float:
    """How far the inner points of a bone in pieces lie beside it, in standard deviations."""
    bone = points[-1] - points[0]
    length = float(np.linalg.norm(bone))
    if len(points) < 3 or length == 0.0:
        return 0.0
    inner = points[1:-1] - points[0]
    away = inner - np.outer(inner @ bone, bone / length**2)
    return math.sqrt(float(np.einsum("ij,ij->i", away, away).max())) / length / _BENT_PIECES


def _best_pairs(tree: _Tree, leg_pairs: list[_Pair], arm_pairs: list[_Pair]) -> tuple[_Pair, _Pair] | None:
    """Legs and arms, or None."""
    best, least = None, _WORST
    longest = max((pair[1].length for pair in leg_pairs), default=0.0)
    for legs in leg_pairs:
        inside = {legs[1].upper, legs[2].upper, *tree.below(legs[1].upper), *tree.below(legs[2].upper)}
        for arms in arm_pairs:
            if arms[0] in inside or not _carries(tree, legs[0], arms[0]):
                continue
            trunk = float(np.linalg.norm(tree.places[arms[0]] - tree.places[legs[0]]))
            cost = 0.5 * sum(limb.cost for limb in (*legs[1:], *arms[1:]))
            cost += _squared(np.log(arms[1].length / legs[1].length), _ARM_LENGTH)
            cost += _squared(np.log(max(trunk, 1e-9) / legs[1].length), _TRUNK)
            cost += _squared(np.log(legs[1].length / longest), _SHORTER) + _crowd(tree, legs)
            if cost < least:
                best, least = (legs, arms), cost
    return best


def _carries(tree: _Tree, hips: int, chest: int) -> bool:
    """Whether the trunk to a chest begins at the hips, or beside them at a joint that is much nearer to them."""
    line = [chest, *tree.above(chest)]
    meeting = next((joint for joint in (hips, *tree.above(hips)) if joint in line), -1)
    if meeting in (-1, chest):
        return False
    near, far = (float(np.linalg.norm(tree.places[joint] - tree.places[meeting])) for joint in (hips, chest))
    return near < 0.5 * far


def _crowd(tree: _Tree, pair: _Pair) -> float:
    """A cost for chains beside a pair that are as long: a skirt has many."""
    reach = tree.reach[pair[1].before[0] if pair[1].before else pair[1].upper]
    like = [j for j in tree.skeleton.children[pair[0]] if abs(tree.reach[j] - reach) <= _ALIKE * reach]
    return 2.0 * max(len(like) - 2, 0)


def _squared(value: float, norm: tuple[float, float]) -> float:
    return float(((value - norm[0]) / norm[1]) ** 2)
