"""Compiled kernels of the causal foot lock, one pose at a time. Arrays in, arrays out, no validation.

`bend_limb` is `kinetograph.post.inverse_kinematics.reach` with a hinge, and `gentle_share` is
`kinetograph.post.footskate.within_reach`, both for a single limb.
"""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.post._joining_kernels import decay
from kinetograph.post._vector_kernels import (
    cross,
    eased,
    exponential,
    inverse,
    length,
    product,
    rotated,
    smallest_rotation,
)
from kinetograph.post.footskate import BOWED, REACHED, STRETCHED
from kinetograph.post.inverse_kinematics import PLAIN, STRAIGHT, TURNED


@numba.njit(cache=True, nogil=True)
def forward(parents: IntArray, offsets: FloatArray, pose: FloatArray, positions: FloatArray, world: FloatArray) -> None:
    """World positions and rotations of all joints of a pose ``(3 + 4 J,)``."""
    positions[0] = pose[:3]
    world[0] = pose[3:7]
    for j in range(1, parents.shape[0]):
        p = parents[j]
        positions[j] = positions[p] + rotated(world[p], offsets[j])
        world[j] = product(world[p], pose[3 + 4 * j : 7 + 4 * j])


@numba.njit(cache=True, nogil=True)
def corner(a: float, b: float, opposite: float) -> float:
    """Angle between sides a and b of a triangle (law of cosines)."""
    cosine = (a * a + b * b - opposite * opposite) / max(2 * a * b, 1e-12)
    return float(np.arccos(min(max(cosine, -1.0), 1.0)))


@numba.njit(cache=True, nogil=True)
def fold_axis(plane: FloatArray, across: FloatArray, bent: float, wanted: float, moved: float) -> FloatArray:
    """The fold of a limb, radians about its axis: in its plane where it is bent, about its hinge where it is not."""
    plain = eased(bent / PLAIN)
    mixed = plain * bent * plane + (1.0 - plain) * moved * across
    size = length(mixed)
    axis = mixed / size if size > 1e-9 else plane
    right = bent * np.sum(plane * across)
    share = max(eased(0.5 * (right / TURNED + 1.0)), eased((bent - TURNED) / TURNED))
    return (1.0 - share) * bent * plane + share * wanted * axis


@numba.njit(cache=True, nogil=True)
def limb_axes(
    upper: FloatArray, middle: FloatArray, end: FloatArray, hinge: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Unit normals: of the plane that a limb is in, and of the one in which a straight limb folds."""
    along = (end - upper) / max(length(end - upper), 1e-12)
    across = hinge - np.sum(hinge * along) * along
    size = length(across)
    across = across / size if size > 1e-6 else np.array([-1.0, 0.0, 0.0])
    normal = cross(end - upper, middle - upper)
    size = length(normal)
    return (normal / size if size > 1e-6 else across), across


@numba.njit(cache=True, nogil=True)
def bend_limb(
    upper: FloatArray, middle: FloatArray, end: FloatArray, target: FloatArray, hinge: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """World rotations of the two bones of a limb, from where they are now, that bring its end to a target."""
    first, second, now = length(middle - upper), length(end - middle), length(end - upper)
    furthest = max(STRAIGHT * (first + second), now)
    wanted = min(max(length(target - upper), abs(first - second) + 1e-4), furthest)
    open_now, open_wanted = corner(first, second, now), corner(first, second, wanted)
    plane, across = limb_axes(upper, middle, end, hinge)
    moved = length(target - end) / (first + second) + max(open_now - open_wanted, 0.0)
    fold = fold_axis(plane, across, np.pi - open_now, np.pi - open_wanted, moved)
    bend = length(fold)
    axis = fold / bend if bend > 1e-9 else plane
    span = np.sqrt(max(first**2 + second**2 + 2.0 * first * second * np.cos(bend), 0.0))
    lean, lean_now = corner(first, span, second), corner(first, now, second)
    upper_bend = product(exponential(axis * lean), exponential(-plane * lean_now))
    unfold = exponential(plane * (np.pi - open_now - lean_now))
    lower_bend = product(exponential(axis * (lean - bend)), unfold)
    swing = smallest_rotation(end - upper, target - upper)
    return product(swing, upper_bend), product(swing, lower_bend)


@numba.njit(cache=True, nogil=True)
def gentle_share(hip: FloatArray, furthest: float, ankle: FloatArray, offset: FloatArray) -> float:
    """The share of an offset by which an ankle is moved so that its leg is straightened gently."""
    leg = ankle - hip
    now, wanted = length(leg), length(leg + offset)
    if wanted <= now:
        return 1.0
    room = max(furthest - now, 1e-9)
    share = (wanted - now) / room
    if share > BOWED:
        share = BOWED + (1.0 - BOWED) * np.tanh((share - BOWED) / (1.0 - BOWED))
    reached = now + room * share
    along, square = np.sum(leg * offset), np.sum(offset * offset)
    root = np.sqrt(max(along**2 + square * (reached**2 - now**2), 0.0))
    return float(min(max((root - along) / max(square, 1e-18), 0.0), 1.0))


@numba.njit(cache=True, nogil=True)
def move_leg(
    parents: IntArray, leg: IntArray, pose: FloatArray, positions: FloatArray, world: FloatArray, target: FloatArray,
    hinge: FloatArray,
) -> None:  # fmt: skip
    """Bring an ankle to a target by rotating hip and knee, in place; the foot keeps its rotation in the world."""
    upper, middle, end = leg
    by_upper, by_lower = bend_limb(positions[upper], positions[middle], positions[end], target, hinge)
    above = np.array([1.0, 0.0, 0.0, 0.0]) if parents[upper] < 0 else world[parents[upper]]
    new_upper, new_lower = product(by_upper, world[upper]), product(by_lower, world[middle])
    # bones between the joints, such as twist bones, go with the joint above them
    before_middle = product(product(new_upper, inverse(world[upper])), world[parents[middle]])
    before_end = product(product(new_lower, inverse(world[middle])), world[parents[end]])
    pose[3 + 4 * upper : 7 + 4 * upper] = product(inverse(above), new_upper)
    pose[3 + 4 * middle : 7 + 4 * middle] = product(inverse(before_middle), new_lower)
    pose[3 + 4 * end : 7 + 4 * end] = product(inverse(before_end), world[end])
    for j in (upper, middle, end):
        pose[3 + 4 * j : 7 + 4 * j] /= length(pose[3 + 4 * j : 7 + 4 * j])


@numba.njit(cache=True, nogil=True)
def hold_foot(
    slide: FloatArray, planted: bool, foot: FloatArray, dt: float, half_life: float, grip: float, fastest: float,
    furthest: float,
) -> None:  # fmt: skip
    """A foot's offset after ``dt`` seconds, in place: against the slide while it is planted, else less and less.

    The foot's row is its offset, the offset's rate, and how firmly it holds, from 0 to 1.
    """
    offset, rate = foot[:3].copy(), foot[3:6].copy()
    decay(offset, rate, half_life, dt)
    foot[6] = min(foot[6] + dt / grip, 1.0) if planted else 0.0
    hold = eased(foot[6])
    against = -slide / dt
    against *= min(1.0, fastest / max(length(against), 1e-12))
    moved = (1.0 - hold) * offset + hold * (foot[:3] + dt * against)
    size = length(moved)
    foot[3:6] = (1.0 - hold) * rate + hold * against
    if size > furthest:
        moved *= furthest / size
        outward = np.sum(foot[3:6] * moved) / furthest**2
        foot[3:6] -= max(outward, 0.0) * moved
    foot[:3] = moved


@numba.njit(cache=True, nogil=True)
def needed_drop(hip: FloatArray, straight: float, ankle: FloatArray, offset: FloatArray, deepest: float) -> float:
    """How far a hip has to go down for its leg to reach the ankle with its offset."""
    if length(offset) < 1e-7:
        return 0.0
    furthest = max(REACHED * straight, length(ankle - hip))
    leg = ankle + offset - hip
    lowest = np.sqrt(max(furthest**2 - leg[0] ** 2 - leg[2] ** 2, 0.0))
    return float(min(max(-leg[1] - lowest, 0.0), deepest))


@numba.njit(cache=True, nogil=True)
def sink(drop: FloatArray, needed: float, half_life: float, dt: float) -> None:
    """Let the hips' drop, with its rate, approach what is needed, critically damped, in place."""
    gap = np.array([drop[0] - needed])
    rate = drop[1:2].copy()
    decay(gap, rate, half_life, dt)
    drop[0] = max(needed + gap[0], 0.0)
    drop[1] = rate[0]


@numba.njit(cache=True, nogil=True)
def planted_slide(
    points: FloatArray, before: FloatArray, flags: BoolArray, were: BoolArray, feet: IntArray, foot: int
) -> tuple[bool, FloatArray]:
    """Whether a foot is planted, and the mean way that its points slid that are in contact now and before."""
    slide = np.zeros(3)
    count, planted = 0, False
    for i in range(feet.shape[0]):
        if feet[i] == foot and flags[i]:
            planted = True
            if were[i]:
                slide += points[i] - before[i]
                count += 1
    slide[1] = 0.0
    return planted, slide / max(count, 1)


@numba.njit(cache=True, nogil=True)
def lock_feet(
    parents: IntArray, offsets: FloatArray, legs: IntArray, joints: IntArray, local: FloatArray, feet: IntArray,
    limits: FloatArray, flags: BoolArray, dt: float, pose: FloatArray, points: FloatArray, were: BoolArray,
    held: FloatArray, drop: FloatArray, begun: bool,
) -> None:  # fmt: skip
    """One step of the lock: pose, points, ``were``, ``held`` and ``drop`` are changed in place."""
    positions, world = np.empty((parents.shape[0], 3)), np.empty((parents.shape[0], 4))
    forward(parents, offsets, pose, positions, world)
    now = np.empty_like(points)
    for i in range(joints.shape[0]):
        now[i] = positions[joints[i]] + rotated(world[joints[i]], local[i])
    needed = 0.0
    straights = np.empty(legs.shape[0])
    for s in range(legs.shape[0]):
        hip, knee, ankle = positions[legs[s, 0]], positions[legs[s, 1]], positions[legs[s, 2]]
        straights[s] = length(knee - hip) + length(ankle - knee)
        if begun:
            planted, slide = planted_slide(now, points, flags, were, feet, s)
            hold_foot(slide, planted, held[s], dt, limits[0], limits[1], limits[2], limits[3])
        needed = max(needed, needed_drop(hip, straights[s], ankle, held[s, :3], limits[5]))
    points[:] = now
    were[:] = flags
    sink(drop, needed, limits[4], dt if begun else 0.0)
    down = np.array([0.0, drop[0], 0.0])
    pose[:3] -= down
    hinge = positions[legs[-1, 0]] - positions[legs[0, 0]]
    positions -= down
    for s in range(legs.shape[0]):
        hip, ankle = positions[legs[s, 0]], positions[legs[s, 2]] + down
        if length(held[s, :3]) + drop[0] > 1e-7:
            furthest = max(STRETCHED * straights[s], length(ankle - hip))
            share = gentle_share(hip, furthest, ankle, held[s, :3])
            move_leg(parents, legs[s], pose, positions, world, ankle + share * held[s, :3], hinge)
