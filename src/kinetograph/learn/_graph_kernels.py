"""Compiled kernels of the transition graph: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import BoolArray, ComplexArray, FloatArray, IntArray, SingleArray


@numba.njit(cache=True, nogil=True)
def thin(
    frames: IntArray,
    neighbours: IntArray,
    distances: SingleArray,
    part: IntArray,
    apart: int,
    limit: float,
    most: int,
    each: int,
    out: BoolArray,
) -> None:
    """Mark in ``out`` ``(P, K)`` the neighbours worth a transition, nearest first; they come sorted by distance.

    Left out: those further than ``limit``, those less than ``apart`` frames from the query itself in its own part or
    from a neighbour that is kept already, and all after the first ``most``, or the first ``each`` of one part.
    """
    for row in range(neighbours.shape[0]):
        kept = 0
        for column in range(neighbours.shape[1]):
            frame = neighbours[row, column]
            if kept == most or not distances[row, column] <= limit:
                break
            fine = part[frame] != part[frames[row]] or abs(frame - frames[row]) >= apart
            same = 0
            for earlier in range(column):
                if out[row, earlier] and part[neighbours[row, earlier]] == part[frame]:
                    fine = fine and abs(neighbours[row, earlier] - frame) >= apart
                    same += 1
            fine = fine and same < each
            if fine:
                out[row, column] = True
                kept += 1


@numba.njit(cache=True, nogil=True)
def best_matches(
    products: SingleArray,
    squares: SingleArray,
    other_squares: SingleArray,
    starts: IntArray,
    others: IntArray,
    between: int,
    out: IntArray,
) -> None:
    """The best matches of a recording's rows with those of others, in rows ``between`` apart.

    products ``(A, B)``: twice the rows' products with all rows after them; squares ``(A,)``, ``(B,)``: their squared
    lengths. Others ``(K,)`` begin at ``starts`` less the first row after. Out ``(K, M, 2)``: row and column, or left.
    """
    rows = len(squares)
    first = starts[-1] - len(other_squares)
    nearest = np.empty(rows, dtype=np.int64)
    least = np.empty(rows, dtype=np.float32)
    for k in range(len(others)):
        for i in range(rows):
            nearest[i], least[i] = 0, np.inf
            for j in range(starts[others[k]] - first, starts[others[k] + 1] - first):
                gap = max(squares[i] + other_squares[j] - products[i, j], np.float32(0.0))
                if gap < least[i]:
                    nearest[i], least[i] = j, gap
        for number in range(out.shape[1]):
            row = least.argmin()
            if not np.isfinite(least[row]):
                break
            out[k, number, 0], out[k, number, 1] = row, nearest[row]
            least[max(row - between + 1, 0) : row + between] = np.inf


@numba.njit(cache=True, nogil=True)
def arrivals(starts: IntArray, target: IntArray, begins: IntArray, source: IntArray) -> None:
    """Sort transitions by target: ``source[begins[q]:begins[q + 1]]`` are the frames that lead to frame q.

    Begins ``(N + 2,)`` is zero before; its first ``N + 1`` numbers hold.
    """
    for q in target:
        begins[q + 2] += 1
    for q in range(2, len(begins)):
        begins[q] += begins[q - 1]
    for i in range(len(starts) - 1):
        for e in range(starts[i], starts[i + 1]):
            source[begins[target[e] + 1]] = i
            begins[target[e] + 1] += 1


@numba.njit(cache=True, nogil=True)
def count_steps(
    steps: FloatArray,
    goals: IntArray,
    last: IntArray,
    arriving: tuple[IntArray, IntArray],
    commit: int,
    most: int,
) -> None:
    """The fewest steps ``(N,)``, infinite before, from every frame to the goals, as far as they are at most ``most``.

    last ``(N,)``: the last frame of each frame's recording; arriving: see `arrivals`. A transition takes ``1 + commit``
    steps and ends ``commit`` frames after its target. Frames are gone through by their steps, each once.
    """
    begins, source = arriving
    queue = np.empty(len(steps), dtype=np.int64)
    levels = np.zeros(most + 2, dtype=np.int64)  # where the frames of each number of steps begin in the queue
    count = 0
    for frame in goals:
        if steps[frame] > 0:
            steps[frame] = 0
            queue[count] = frame
            count += 1
    levels[1] = count
    for level in range(1, most + 1):
        for k in range(levels[level - 1], levels[level]):
            before = queue[k] - 1
            if before >= 0 and last[before] > before and steps[before] > level:
                steps[before] = level
                queue[count] = before
                count += 1
        far = level - 1 - commit
        for k in range(levels[far], levels[far + 1]) if far >= 0 else range(0):
            target = queue[k] - commit
            for e in range(begins[target], begins[target + 1]) if target >= 0 else range(0):
                if steps[source[e]] > level:
                    steps[source[e]] = level
                    queue[count] = source[e]
                    count += 1
        levels[level + 1] = count
        if levels[max(level - commit, 0)] == count:
            break


@numba.njit(cache=True, nogil=True)
def relax(
    to_go: FloatArray,
    last: IntArray,
    starts: IntArray,
    target: IntArray,
    change: FloatArray,
    play: FloatArray,
    commit: int,
) -> bool:
    """One backward sweep of Bellman's equation over all frames, in place; returns whether any value fell.

    to_go ``(N,)``; last ``(N,)``: the last frame of each frame's recording; transitions of frame i are
    ``starts[i]`` to ``starts[i + 1]``. Playing on from i costs ``play[i]``, a transition ``change[e]``, the ``commit``
    steps that it is followed by included.
    """
    changed = False
    for i in range(len(to_go) - 1, -1, -1):
        best = to_go[i]
        if i < last[i]:
            best = min(best, to_go[i + 1] + play[i])
        for e in range(starts[i], starts[i + 1]):
            best = min(best, change[e] + to_go[target[e] + commit])
        if best < to_go[i]:
            to_go[i] = best
            changed = True
    return changed


@numba.njit(cache=True, nogil=True)
def add_squared_distances(rows: SingleArray, columns: IntArray, row: SingleArray, out: FloatArray) -> None:
    """Squared distances ``(N,)`` of some columns of rows ``(N, D)`` from as many numbers, added to ``out``."""
    for i in range(rows.shape[0]):
        total = np.float32(0.0)
        for k in range(columns.shape[0]):
            gap = rows[i, columns[k]] - row[k]
            total += gap * gap
        out[i] += total


@numba.njit(cache=True, nogil=True)
def add_ways(
    stage: int,
    stages: IntArray,
    frames: IntArray,
    rotation: ComplexArray,
    shift: ComplexArray,
    ground: ComplexArray,
    facing: ComplexArray,
    left: FloatArray,
    least: FloatArray,
    goal: tuple[complex, float, complex],
    way: tuple[float, float, float, float],
    near: float,
    out: FloatArray,
) -> None:
    """Add to ``out`` ``(R,)`` what the way to a goal's place costs the routes of its stage more than they must.

    goal: its place, the distance from it that is none, and its heading as a unit number, or 0 where that is free; way:
    pace, rotation and cost of a step, and the metres off a place that cost 1. Rotations count by half of pi times one
    less their cosine.
    """
    place, off, heading = goal
    pace, speed, cost, scale = way
    for i in range(len(frames)):
        if stages[i] != stage:
            continue
        frame = frames[i]
        gap = place - (rotation[i] * ground[frame] + shift[i])
        faces = rotation[i] * facing[frame]
        metres = np.sqrt(gap.real * gap.real + gap.imag * gap.imag)
        share = min(metres / near, 1.0)
        angle = share * (1.0 - (gap.real * faces.real + gap.imag * faces.imag) / max(metres, 1e-9))
        if heading != 0:
            angle += (1.0 - share) * (1.0 - (heading.real * faces.real + heading.imag * faces.imag))
        needed = max(metres - off, 0.0) / pace + 0.5 * np.pi * angle / speed
        late = max(needed - max(left[i], 0.0), 0.0) * pace / scale
        more = max(needed - (least[frame] if least[frame] < np.inf else 0.0), 0.0)
        out[i] += late * late + cost * more
