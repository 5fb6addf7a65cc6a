"""Writing BVH."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.formats.ancestors import placed_joints, with_ancestors
from kinetograph.formats.bvh.stamp import stamped
from kinetograph.formats.conventions import check_up, scale_motion, to_up, unit_factor
from kinetograph.formats.options import WriteOptions
from kinetograph.motion import Motion, cut
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

_BLOCK = 4096  # frames that are written together
ANGLE_DECIMALS = 7  # 1e-9 rad: far below a micrometre at the end of an arm


def write(what: Take | Motion | Signal, path: str | Path, options: WriteOptions | None = None) -> None:
    """Write a motion, or a take's motions as one ROOT each, as BVH.

    Parameters
    ----------
    what : Take, Motion or Signal
    path : str or Path
        Written to exactly this path.
    options : WriteOptions, optional
        The order of angles, the units and the upward axis.

    Raises
    ------
    RequestError
        There is no motion, motions differ in rate or length, or an order, unit or axis is unknown.

    Notes
    -----
    Every joint has three rotation channels; the root also has three position channels, and so have joints whose
    ``bones`` are not as at rest. What the skeleton has above its root is written as joints that never move. Joints come
    depth first. Leaf joints without an end site get one of zero length, as most
    readers expect an End Site there. The last digits of the frame time say the units and the axis to this package's
    reader. Positions are written to 1e-7 m, angles to 1e-7 degrees.
    """
    options = options or WriteOptions()
    if len(options.order) != 3 or set(options.order) != set("xyz"):
        raise RequestError(f"Euler order must name x, y and z once each, as in 'zxy', found {options.order!r}")
    factor = 1.0 / unit_factor(options.units)
    up = check_up(options.up)
    given = _motions(what)
    motions = [to_up(scale_motion(cut(motion, 0, 1), factor), up) for motion in given]
    moving = [placed_joints(with_ancestors(motion), len(motion.skeleton.ancestors)) for motion in given]
    decimals = max(3, 7 + int(np.ceil(np.log10(1.0 / factor))))
    with Path(path).open("w", encoding="utf-8", newline="\n") as file:
        file.write("HIERARCHY\n")
        for motion, places in zip(motions, moving, strict=True):
            file.writelines(f"{line}\n" for line in hierarchy(motion, options.order, decimals, places))
        step = stamped(motions[0].fps, options.units, up)
        file.write(f"MOTION\nFrames: {len(given[0])}\nFrame Time: {step}\n")
        before: list[FloatArray | None] = [None] * len(given)
        for first in range(0, len(given[0]), _BLOCK):
            block = [cut(motion, first, min(first + _BLOCK, len(motion))) for motion in given]
            columns = [
                _columns(to_up(scale_motion(motion, factor), up), options.order, places, last)
                for motion, places, last in zip(block, moving, before, strict=True)
            ]
            before = [angles for _, _, angles in columns]
            placed = [each for _, kinds, _ in columns for each in kinds]
            formats = [f"%.{decimals}f" if each else f"%.{ANGLE_DECIMALS}f" for each in placed]
            values = np.concatenate([values for values, _, _ in columns], axis=1)
            small = np.abs(values) < 0.5 * 10.0**-ANGLE_DECIMALS
            np.savetxt(file, np.where(small, 0.0, values), fmt=" ".join(formats))


def _motions(what: Take | Motion | Signal) -> list[Motion]:
    if isinstance(what, Signal):
        raise RequestError("a BVH file holds motions, found a signal; save it as .csv")
    if isinstance(what, Motion):
        return [what]
    motions = [track for track in what.tracks.values() if isinstance(track, Motion)]
    if not motions:
        raise RequestError(f"a BVH file holds motions, but take {what.name!r} has only {', '.join(what.tracks)}")
    if len({(motion.fps, len(motion)) for motion in motions}) > 1:
        raise RequestError(f"the motions of take {what.name!r} differ in rate or length; save them one by one")
    return motions


def hierarchy(motion: Motion, order: str, decimals: int, placed: BoolArray | None = None) -> Iterator[str]:
    """The lines of one ROOT; the joints that are open are kept on a list, as depth may exceed Python's stack."""
    root = len(motion.skeleton.ancestors)
    motion = with_ancestors(motion)
    skeleton, placed = motion.skeleton, placed_joints(motion, root) if placed is None else placed
    ends: dict[int, list[FloatArray]] = {joint: [] for joint in range(len(skeleton))}
    for joint, offset in zip(skeleton.end_parents.tolist(), skeleton.end_offsets, strict=True):
        ends[joint].append(offset)
    angles = " ".join(f"{axis.upper()}rotation" for axis in order)
    positions = "Xposition Yposition Zposition"
    todo: list[tuple[int, int]] = [(0, 0)]
    while todo:
        joint, depth = todo.pop()
        indent = "\t" * depth
        if joint < 0:
            yield f"{indent}}}"
            continue
        yield f"{indent}{'JOINT' if joint else 'ROOT'} {_name(skeleton.names[joint])}"
        yield f"{indent}{{"
        # zeros for roots: some programs add the OFFSET to the position channels, in others these replace it
        offset = np.zeros(3) if joint in (0, root) else skeleton.offsets[joint]
        yield f"{indent}\tOFFSET {_numbers(offset, decimals)}"
        yield f"{indent}\tCHANNELS {6 if placed[joint] else 3} {positions + ' ' if placed[joint] else ''}{angles}"
        children = skeleton.children[joint]
        for end in ends[joint] or ([] if children else [np.zeros(3)]):
            yield f"{indent}\tEnd Site"
            yield f"{indent}\t{{"
            yield f"{indent}\t\tOFFSET {_numbers(end, decimals)}"
            yield f"{indent}\t}}"
        todo.append((-1, depth))
        todo.extend((child, depth + 1) for child in reversed(children))


def _columns(
    motion: Motion, order: str, placed: BoolArray, before: FloatArray | None = None
) -> tuple[FloatArray, list[bool], FloatArray]:
    """Channels, shape ``(F, C)``, joints depth-first, whether each is a position, and the last angles.

    before: the angles ``(2, J, 3)`` in radians of the frame before the first, and their whole revolutions.
    """
    motion = with_ancestors(motion)
    # unwrapped, as importers that interpolate angles would spin between two frames
    raw = rot.to_euler(motion.rotations, order)
    first, whole = (raw[:1], 0.0) if before is None else (before[:1], before[1])
    turned = np.unwrap(np.concatenate([first, raw]), axis=0)[1:] + whole
    angles = np.degrees(turned)
    blocks, kinds = [], []
    for joint in depth_first(motion.skeleton):
        if placed[joint]:
            blocks.append(motion.translation if joint == 0 or motion.bones is None else motion.bones[:, joint])
            kinds += [True] * 3
        blocks.append(angles[:, joint])
        kinds += [False] * 3
    return np.concatenate(blocks, axis=1), kinds, np.stack([raw[-1], turned[-1] - raw[-1]])


def depth_first(skeleton: Skeleton) -> Iterator[int]:
    """Joints in the order in which a file has their channels."""
    todo = [0]
    while todo:
        joint = todo.pop()
        yield joint
        todo.extend(reversed(skeleton.children[joint]))


def _name(name: str) -> str:
    """A joint's name on one line, without braces."""
    return " ".join(re.sub(r"[{}]", "_", name).split()) or "joint"


def _numbers(values: FloatArray, decimals: int) -> str:
    return " ".join(f"{value:.{decimals}f}" for value in np.round(values, decimals) + 0.0)  # + 0.0: no -0.000
