"""Compiled kernels of the fit to markers: arrays in, arrays out, no validation.

The joints' rotations and the root's position are unknown; a step of the search has ``3 + 3 J`` numbers: the root's
shift and, for each joint, a rotation vector in the world. ``attached`` is the joint ``(M,)`` of each marker and its
place ``(M, 3)`` in that joint's frame. ``prior`` is the rotations ``(J, 4)`` that joints are drawn to, and how strongly
``(J, 3)``.
"""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.quaternion_kernels import conjugate, multiply, rotate

_STEPS = 30
_SMALL = 1e-6  # metres and radians: a shorter step ends the search
_LEAST, _MOST = 1e-9, 1e3  # damping
_FAR = 0.02  # metres: a frame whose markers are missed by more is also tried from its guess


@numba.njit(cache=True, nogil=True)
def _bend(local: FloatArray, rest: FloatArray, out: FloatArray) -> None:
    """The rotation vector, ``(3,)``, from ``rest`` to ``local``."""
    inverse, q = np.empty(4), np.empty(4)
    conjugate(rest, inverse)
    multiply(local, inverse, q)
    sign = -1.0 if q[0] < 0.0 else 1.0
    sine = np.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    size = 2.0 if sine < 1e-9 else 2.0 * np.arctan2(sine, sign * q[0]) / sine
    for i in range(3):
        out[i] = sign * size * q[1 + i]


@numba.njit(cache=True, nogil=True)
def _pose(
    root: FloatArray, local: FloatArray, parents: IntArray, offsets: FloatArray, places: FloatArray, world: FloatArray
) -> None:
    """Positions ``(J, 3)`` and rotations ``(J, 4)`` of the joints in the world; both are written."""
    for j in range(len(parents)):
        p = parents[j]
        if p < 0:
            for i in range(3):
                places[j, i] = root[i]
            for i in range(4):
                world[j, i] = local[j, i]
        else:
            rotate(world[p], offsets[j], places[j])
            for i in range(3):
                places[j, i] += places[p, i]
            multiply(world[p], local[j], world[j])


@numba.njit(cache=True, nogil=True)
def _cost(
    points: FloatArray,
    seen: BoolArray,
    local: FloatArray,
    places: FloatArray,
    world: FloatArray,
    attached: tuple[IntArray, FloatArray],
    prior: tuple[FloatArray, FloatArray],
    furthest: float,
    misses: FloatArray,
    bends: FloatArray,
) -> float:
    """Huber's cost of the markers' misses and the cost of the bends away from the prior; both are written."""
    segment, offsets = attached
    target, weight = prior
    total = 0.0
    moved = np.empty(3)
    for m in range(len(points)):
        if seen[m]:
            rotate(world[segment[m]], offsets[m], moved)
            square = 0.0
            for i in range(3):
                misses[m, i] = points[m, i] - places[segment[m], i] - moved[i]
                square += misses[m, i] * misses[m, i]
            size = np.sqrt(square)
            total += square if size <= furthest else 2.0 * furthest * size - furthest * furthest
    for j in range(len(local)):
        _bend(local[j], target[j], bends[j])
        for i in range(3):
            total += weight[j, i] * bends[j, i] * bends[j, i]
    return total


@numba.njit(cache=True, nogil=True)
def _equations(
    seen: BoolArray,
    places: FloatArray,
    world: FloatArray,
    parents: IntArray,
    attached: tuple[IntArray, FloatArray],
    weight: FloatArray,
    furthest: float,
    misses: FloatArray,
    bends: FloatArray,
    matrix: FloatArray,
    right: FloatArray,
) -> None:
    """Normal equations of a step: write the lower half of the matrix, ``(3 + 3 J, 3 + 3 J)``, and the right side."""
    segment, offsets = attached
    for i in range(len(right)):
        right[i] = 0.0
        for k in range(i + 1):
            matrix[i, k] = 0.0
    line = np.empty(len(parents), dtype=np.int64)
    arms = np.empty((len(parents), 3))
    moved = np.empty(3)
    for m in range(len(segment)):
        if not seen[m]:
            continue
        rotate(world[segment[m]], offsets[m], moved)
        for i in range(3):
            moved[i] += places[segment[m], i]
        count = 0
        j = segment[m]
        while j >= 0:
            line[count] = j
            for i in range(3):
                arms[count, i] = moved[i] - places[j, i]
            count += 1
            j = parents[j]
        _add_marker(line[:count], arms, misses[m], furthest, matrix, right)
    _add_prior(world, parents, weight, bends, matrix, right)


@numba.njit(cache=True, nogil=True)
def _add_marker(
    line: IntArray, arms: FloatArray, miss: FloatArray, furthest: float, matrix: FloatArray, right: FloatArray
) -> None:
    """Add a marker's share; line: its joint and all above it. arms: from each of these to the marker."""
    x, y, z = miss[0], miss[1], miss[2]
    size = np.sqrt(x * x + y * y + z * z)
    share = 1.0 if size <= furthest else furthest / size
    for i in range(3):
        matrix[i, i] += share
        right[i] += share * miss[i]
    for a in range(len(line)):
        i, u = 3 + 3 * line[a], arms[a]
        right[i] += share * (u[1] * z - u[2] * y)
        right[i + 1] += share * (u[2] * x - u[0] * z)
        right[i + 2] += share * (u[0] * y - u[1] * x)
        # a rotation w moves the marker by w x u, so its row against the shift is the cross product's matrix of u
        matrix[i, 1] -= share * u[2]
        matrix[i, 2] += share * u[1]
        matrix[i + 1, 0] += share * u[2]
        matrix[i + 1, 2] -= share * u[0]
        matrix[i + 2, 0] -= share * u[1]
        matrix[i + 2, 1] += share * u[0]
        for b in range(len(line)):
            k, v = 3 + 3 * line[b], arms[b]
            if k > i:
                continue
            dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
            for r in range(3):
                for c in range(3):
                    matrix[i + r, k + c] -= share * v[r] * u[c]
                matrix[i + r, k + r] += share * dot


@numba.njit(cache=True, nogil=True)
def _add_prior(
    world: FloatArray, parents: IntArray, weight: FloatArray, bends: FloatArray, matrix: FloatArray, right: FloatArray
) -> None:
    """Add the pull towards the prior, whose axes are those of each joint's parent."""
    moved, axis = np.empty(3), np.empty(3)
    for j in range(len(parents)):
        for i in range(3):
            for r in range(3):
                axis[r] = 1.0 if r == i else 0.0
                moved[r] = axis[r]
            if j > 0:
                rotate(world[parents[j]], axis, moved)
            for r in range(3):
                right[3 + 3 * j + r] -= weight[j, i] * bends[j, i] * moved[r]
                for c in range(3):
                    matrix[3 + 3 * j + r, 3 + 3 * j + c] += weight[j, i] * moved[r] * moved[c]


@numba.njit(cache=True, nogil=True)
def _step(matrix: FloatArray, right: FloatArray, damping: float, factor: FloatArray, out: FloatArray) -> float:
    """Solve the damped equations by Cholesky's method from their lower half; the largest number of the step."""
    size = len(right)
    for i in range(size):
        for k in range(i + 1):
            total = matrix[i, k]
            if i == k:
                total += damping * (1.0 + total)
            for r in range(k):
                total -= factor[i, r] * factor[k, r]
            factor[i, k] = np.sqrt(max(total, 1e-15)) if i == k else total / factor[k, k]
    for i in range(size):
        total = right[i]
        for r in range(i):
            total -= factor[i, r] * out[r]
        out[i] = total / factor[i, i]
    longest = 0.0
    for i in range(size - 1, -1, -1):
        total = out[i]
        for r in range(i + 1, size):
            total -= factor[r, i] * out[r]
        out[i] = total / factor[i, i]
        longest = max(longest, abs(out[i]))
    return longest


@numba.njit(cache=True, nogil=True)
def _moved(
    root: FloatArray,
    local: FloatArray,
    world: FloatArray,
    parents: IntArray,
    step: FloatArray,
    new_root: FloatArray,
    new_local: FloatArray,
) -> None:
    """The pose after a step: the root moved, and each local rotation preceded by its rotation in the world."""
    for i in range(3):
        new_root[i] = root[i] + step[i]
    spin, inverse, before, after = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    for j in range(len(parents)):
        x, y, z = step[3 + 3 * j], step[4 + 3 * j], step[5 + 3 * j]
        angle = np.sqrt(x * x + y * y + z * z)
        size = 0.5 if angle < 1e-9 else np.sin(0.5 * angle) / angle
        spin[0], spin[1], spin[2], spin[3] = np.cos(0.5 * angle), size * x, size * y, size * z
        if parents[j] >= 0:  # from the world to the parent's frame, in which the joint rotates
            q = world[parents[j]]
            conjugate(q, inverse)
            multiply(inverse, spin, before)
            multiply(before, q, after)
            multiply(after, local[j], new_local[j])
        else:
            multiply(spin, local[j], new_local[j])
        square = 0.0
        for i in range(4):
            square += new_local[j, i] * new_local[j, i]
        for i in range(4):
            new_local[j, i] /= np.sqrt(square)


@numba.njit(cache=True, nogil=True)
def _descend(
    points: FloatArray,
    seen: BoolArray,
    parents: IntArray,
    offsets: FloatArray,
    attached: tuple[IntArray, FloatArray],
    prior: tuple[FloatArray, FloatArray],
    furthest: float,
    root: FloatArray,
    local: FloatArray,
) -> float:
    """Fit one frame's pose by the method of Levenberg and Marquardt, in place; its cost."""
    joints, size = len(parents), 3 + 3 * len(parents)
    places, world = np.empty((joints, 3)), np.empty((joints, 4))
    misses, bends = np.zeros((len(points), 3)), np.zeros((joints, 3))
    new_root, new_local = np.empty(3), np.empty((joints, 4))
    matrix, factor, right, step = np.empty((size, size)), np.empty((size, size)), np.empty(size), np.empty(size)
    _pose(root, local, parents, offsets, places, world)
    cost, damping = _cost(points, seen, local, places, world, attached, prior, furthest, misses, bends), _LEAST
    for _ in range(_STEPS):
        _equations(seen, places, world, parents, attached, prior[1], furthest, misses, bends, matrix, right)
        while True:
            longest = _step(matrix, right, damping, factor, step)
            _moved(root, local, world, parents, step, new_root, new_local)
            _pose(new_root, new_local, parents, offsets, places, world)
            new_cost = _cost(points, seen, new_local, places, world, attached, prior, furthest, misses, bends)
            if new_cost <= cost or damping > _MOST:
                break
            damping = max(10.0 * damping, 1e-6)
            _pose(root, local, parents, offsets, places, world)  # back, from where the next step is taken
        if new_cost > cost:
            break
        gained = cost - new_cost
        cost = new_cost
        root[:] = new_root
        local[:] = new_local
        damping = max(0.1 * damping, _LEAST)
        if longest < _SMALL or gained < 1e-8 * cost:
            break
    return cost


@numba.njit(cache=True, nogil=True)
def solve(
    points: FloatArray,
    seen: BoolArray,
    tree: tuple[IntArray, FloatArray],
    attached: tuple[IntArray, FloatArray],
    prior: tuple[FloatArray, FloatArray],
    guess: tuple[FloatArray, FloatArray],
    order: IntArray,
    furthest: float,
    roots: FloatArray,
    rotations: FloatArray,
) -> None:
    """Fit the pose of each frame to its markers.

    Parameters
    ----------
    points : ndarray, shape (F, M, 3)
        Markers, metres.
    seen : ndarray of bool, shape (F, M)
    tree : tuple of ndarray, shapes (J,) and (J, 3)
        Parents and bones.
    attached : tuple of ndarray, shapes (M,) and (M, 3)
        Each marker's joint, and its place in that joint's frame.
    prior : tuple of ndarray, shapes (F, J, 4) and (F, J, 3)
        Rotations that joints are drawn to, and how strongly: square metres per square radian about the axes of the
        joint's parent.
    guess : tuple of ndarray, shapes (F, 3) and (F, J, 4)
        Roots and rotations from which the first frame of ``order`` begins; a later one begins from the one before it
        and, where that ends too far from the markers, from the guess as well.
    order : ndarray of int
        Frames.
    furthest : float
        Metres from which a marker's miss counts linearly rather than by its square.
    roots : ndarray, shape (F, 3)
        Written.
    rotations : ndarray, shape (F, J, 4)
        Local; written.
    """
    parents, offsets = tree
    root, local = guess[0][order[0]].copy(), guess[1][order[0]].copy()
    for f in order:
        pull = (prior[0][f], prior[1][f])
        cost = _descend(points[f], seen[f], parents, offsets, attached, pull, furthest, root, local)
        roots[f], rotations[f] = root, local
        count = 0
        for m in range(seen.shape[1]):
            count += seen[f, m]
        if cost > count * _FAR * _FAR:
            root, local = guess[0][f].copy(), guess[1][f].copy()
            if _descend(points[f], seen[f], parents, offsets, attached, pull, furthest, root, local) < cost:
                roots[f], rotations[f] = root, local
            else:
                root, local = roots[f].copy(), rotations[f].copy()
