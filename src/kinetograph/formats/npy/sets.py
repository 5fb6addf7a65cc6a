"""Known sets of joints, and which of them positions are of."""

from __future__ import annotations

import functools
import tomllib
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.smpl import average_body
from kinetograph.skeleton import Skeleton

_UNLIKE = 1.5  # how many times less a set's bones must vary than the next one's
_SMPL = {"humanml3d": (22, 20.0), "smpl": (24, None), "smplh": (52, None), "smplx": (55, None)}


@dataclass(frozen=True, eq=False)
class JointSet:
    """A set of joints.

    Parameters
    ----------
    name, title : str
    count : int
        Rows of positions.
    fps : float or None
        Frames per second of the data set that it is known from.
    rows : tuple of tuple of int
        For each joint of the skeleton, the rows whose mean it is.
    skeleton : Skeleton
        A body of 1.7 m in a T pose.
    """

    name: str
    title: str
    count: int
    fps: float | None
    rows: tuple[tuple[int, ...], ...]
    skeleton: Skeleton

    def joints(self, positions: FloatArray) -> FloatArray:
        """Positions ``(F, J, 3)`` of the skeleton's joints, from those of a file."""
        return np.stack([positions[:, list(rows)].mean(axis=1) for rows in self.rows], axis=1)


@functools.cache
def joint_sets() -> dict[str, JointSet]:
    """The known sets, by name."""
    body = average_body()
    rows = tuple((i,) for i in range(len(body)))
    titles = {"humanml3d": "HumanML3D", "smpl": "SMPL", "smplh": "SMPL-H", "smplx": "SMPL-X"}
    sets = {name: JointSet(name, titles[name], count, fps, rows, body) for name, (count, fps) in _SMPL.items()}
    text = resources.files(__package__).joinpath("joint_sets.toml").read_text(encoding="utf-8")
    return sets | {name: _of_table(name, table) for name, table in tomllib.loads(text).items()}


def _of_table(name: str, table: dict[str, object]) -> JointSet:
    joints = table["joints"]
    assert isinstance(joints, dict)
    names = list(joints)
    parents = [names.index(joint["parent"]) if "parent" in joint else -1 for joint in joints.values()]
    offsets = [joint.get("at", [0.0, 0.0, 0.0]) for joint in joints.values()]
    rows = [joint["row"] if isinstance(joint["row"], list) else [joint["row"]] for joint in joints.values()]
    fps = table.get("fps")
    skeleton = Skeleton(tuple(names), np.array(parents), np.array(offsets))
    rate = float(fps) if isinstance(fps, int | float) else None
    return JointSet(name, str(table["title"]), int(str(table["count"])), rate, tuple(map(tuple, rows)), skeleton)


def choose_set(path: Path, positions: FloatArray, given: str | Path | None, notes: list[str]) -> JointSet:
    """The set of joints that positions are of, by their number and by how little its bones vary.

    Parameters
    ----------
    path : Path
        For errors.
    positions : ndarray, shape (F, J, 3)
    given : str, Path or None
        A set's name.
    notes : list of str

    Returns
    -------
    JointSet

    Raises
    ------
    FormatError
        No set has so many joints, or several could be meant.
    RequestError
        The name given is unknown, or its set has another number of joints.
    """
    sets, count = joint_sets(), positions.shape[1]
    if given is not None:
        if str(given) not in sets:
            raise RequestError(f"unknown set of joints {str(given)!r}; expected one of {', '.join(sets)}")
        if sets[str(given)].count != count:
            raise RequestError(f"{path}: {given} has {sets[str(given)].count} joints, the file {count}")
        return sets[str(given)]
    fits = [joints for joints in sets.values() if joints.count == count]
    if not fits:
        known = ", ".join(f"{joints.count} {joints.title}" for joints in sets.values())
        raise FormatError(path, f"positions of {count} joints are of no known set; expected {known}")
    varies = [bones_vary(joints, positions) for joints in fits]
    order = np.argsort(varies)
    if len(fits) > 1:
        if varies[order[1]] < _UNLIKE * max(varies[order[0]], 1e-6):
            names = " or ".join(fits[i].name for i in order[:2])
            raise FormatError(path, f"positions of {count} joints could be of {names}; say which with --markers")
        notes.append(f"{count} joints: taken as {fits[order[0]].title}, whose bones vary least; --markers for another")
    return fits[int(order[0])]


def bones_vary(joints: JointSet, positions: FloatArray) -> float:
    """How much the bones of a set vary over time, and between left and right, in shares of their lengths."""
    places, skeleton = joints.joints(positions), joints.skeleton
    lengths = np.linalg.norm(places[:, 1:] - places[:, skeleton.parents[1:]], axis=-1)
    usual = np.median(lengths, axis=0)
    change = np.mean(np.abs(lengths - usual), axis=0) / np.maximum(usual, 1e-9)
    names = skeleton.names[1:]
    pairs = [(i, names.index("right" + n[4:])) for i, n in enumerate(names) if n.startswith("left")]
    sides = [abs(usual[a] - usual[b]) / max(usual[a], usual[b], 1e-9) for a, b in pairs]
    return float(np.mean(change) + np.mean(sides))
