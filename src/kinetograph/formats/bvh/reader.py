"""Reading BVH: from the hierarchy and the rows of channels to motions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import _kernels
from kinetograph.formats.bvh.hierarchy import Hierarchy, Node, parse_hierarchy
from kinetograph.formats.bvh.rows import parse_motion
from kinetograph.formats.bvh.stamp import meaning
from kinetograph.formats.conventions import to_metres_y_up
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

_RIGID = 1e-6  # of the longest bone: a joint whose position differs from its mean by less does not move
_CROWDED = 20  # joints per channel at most, in long files: a small file must not ask for all memory


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a BVH file as a take in metres, Y up, with one motion per ROOT.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional

    Returns
    -------
    Loaded
        One ROOT gives the track ``motion``; several give tracks with the roots' names. A file without frames gives one
        frame of the rest pose. A motion has ``bones`` where position channels below the root change.

    Raises
    ------
    FormatError
        The file is not BVH, is cut short, or has values that are not finite numbers; with the line.
    """
    path = Path(path)
    options = options or ReadOptions()
    data = _text(path.read_bytes())
    hierarchy = parse_hierarchy(path, data)
    rows = parse_motion(path, data, hierarchy, options)
    notes = [*hierarchy.notes, *rows.notes]
    values = rows.values
    if len(values) == 0:
        values = _rest_row(hierarchy)
        notes.append("the file has no frames: read its rest pose")
    if len(values) * len(hierarchy.nodes) > 1_000_000 + _CROWDED * values.size:
        few = f"{len(hierarchy.nodes)} joints but {hierarchy.width} channels"
        raise FormatError(path, f"expected channels on most joints, found {few}; is the file damaged?")
    characters = _characters(hierarchy.nodes)
    motions = [motion_of_rows(nodes, values, rows.fps, notes) for nodes in characters]
    units, up = meaning(data, hierarchy.position)
    converted = to_metres_y_up(motions, options.units or units, options.up or up, options.keep)
    take = Take(path.stem, converted.tracks([nodes[0].name for nodes in characters], notes))
    return Loaded(take, (*notes, *converted.notes))


def _text(data: bytes) -> bytes:
    """The file as UTF-8 without a byte-order mark, and with line feeds at the ends of lines."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        data = data.decode("utf-16", "replace").encode()
    data = data.removeprefix(b"\xef\xbb\xbf")
    return data.replace(b"\r", b"\n") if b"\n" not in data else data


def _characters(nodes: list[Node]) -> list[list[Node]]:
    """The nodes of each ROOT, with their parents counted from it."""
    starts = [i for i, node in enumerate(nodes) if node.parent < 0]
    return [
        [replace(node, parent=max(node.parent - start, -1)) for node in nodes[start:stop]]
        for start, stop in zip(starts, [*starts[1:], len(nodes)], strict=True)
    ]


def _rest_row(hierarchy: Hierarchy) -> FloatArray:
    """One row of channels for the rest pose: angles of zero, and the offsets as positions."""
    row = np.zeros((1, hierarchy.width))
    for node in hierarchy.nodes:
        for column, axis in _positions_of(node):
            row[0, column] = _offset(node)[axis]
    return row


def motion_of_rows(nodes: list[Node], values: FloatArray, fps: float, notes: list[str]) -> Motion:
    """The motion of one character, in the file's own units and axes.

    Parameters
    ----------
    nodes : list of Node
        The character's joints.
    values : ndarray, shape (F, C)
        Channels as written.
    fps : float
    notes : list of str
        Gets a line on what was repaired.

    Returns
    -------
    Motion
    """
    translation, offsets, bones = _placements(nodes, values, notes)
    ends = [(joint, end) for joint, node in enumerate(nodes) for end in node.ends]
    skeleton = Skeleton(
        tuple(unique([node.name for node in nodes], "joint", notes)),
        np.array([node.parent for node in nodes]),
        offsets,
        np.array([joint for joint, _ in ends], dtype=np.int64),
        np.array([end for _, end in ends], dtype=np.float64),
    )
    return Motion(skeleton, translation, _rotations(nodes, values), fps, bones)


def _placements(
    nodes: list[Node], values: FloatArray, notes: list[str]
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Root translation ``(F, 3)``, offsets ``(J, 3)`` and, where joints move in their parents, bones ``(F, J, 3)``."""
    offsets = np.array([_offset(node) for node in nodes])
    translation = np.tile(offsets[0], (len(values), 1))
    for column, axis in _positions_of(nodes[0]):
        translation[:, axis] = values[:, column]
    placed = [
        (joint, axis, values[:, column])
        for joint, node in enumerate(nodes)
        if joint
        for column, axis in _positions_of(node)
    ]
    longest = max([np.abs(offsets[1:]).max(initial=0.0), *(float(np.abs(track).max()) for _, _, track in placed)])
    if placed and all(not track.any() for _, _, track in placed) and longest > 0:
        notes.append("position channels below the root are all 0: the OFFSETs are kept")
        return translation, offsets, None
    moving = []
    for joint, axis, track in placed:
        middle = float(track.mean())
        if np.abs(track - middle).max() <= _RIGID * longest:
            offsets[joint, axis] = middle
        else:
            moving.append((joint, axis, track))
    if not moving:
        return translation, offsets, None
    bones = np.tile(offsets, (len(values), 1, 1))
    for joint, axis, track in moving:
        bones[:, joint, axis] = track
    return translation, offsets, bones


def _rotations(nodes: list[Node], values: FloatArray) -> FloatArray:
    """Local rotations, shape ``(F, J, 4)``."""
    columns = np.full((len(nodes), 3), -1, dtype=np.int64)
    axes = np.zeros((len(nodes), 3), dtype=np.int64)
    for joint, node in enumerate(nodes):
        angles = [(i, axis) for i, (axis, kind) in enumerate(node.channels) if kind == "rotation"]
        for k, (i, axis) in enumerate(angles):
            columns[joint, k], axes[joint, k] = node.column + i, "xyz".index(axis)
    return _kernels.rotations_of_channels(values, columns, axes)


def _positions_of(node: Node) -> list[tuple[int, int]]:
    """Column and axis of each position channel."""
    return [(node.column + i, "xyz".index(axis)) for i, (axis, kind) in enumerate(node.channels) if kind == "position"]


def _offset(node: Node) -> tuple[float, float, float]:
    return node.offset or (0.0, 0.0, 0.0)
