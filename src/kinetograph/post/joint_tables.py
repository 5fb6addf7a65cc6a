"""Tables of pairs of joints of two skeletons: to print, edit and read again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from kinetograph.errors import FormatError
from kinetograph.formats.texts import read_text
from kinetograph.roles import read_names
from kinetograph.skeleton import ROLES, Skeleton

_NONE = "-"


@dataclass(frozen=True)
class JointTable:
    """Which joint of a source skeleton each joint of a target skeleton follows.

    Parameters
    ----------
    pairs : mapping of str to str
        Target joint to source joint.
    rest : tuple of str
        Target joints that keep their rest pose.
    why : mapping of str to str
        Target joint to the reason for its pair: a role, or ``"name"``.
    """

    pairs: Mapping[str, str]
    rest: tuple[str, ...]
    why: Mapping[str, str]

    def check(self, source: Skeleton, target: Skeleton) -> None:
        """Check that all names are joints of their skeletons.

        Parameters
        ----------
        source, target : Skeleton

        Raises
        ------
        RequestError
            If one is not.
        """
        for here, there in self.pairs.items():
            target.index(here)
            source.index(there)

    def __str__(self) -> str:
        """One line per target joint, with tabs between columns; `parse_table` reads it."""
        rows = [(target, source, self.why.get(target, "")) for target, source in self.pairs.items()]
        rows += [(target, _NONE, "rest pose") for target in self.rest]
        lines = ["# target\tsource\twhy", *("\t".join(row) for row in rows)]
        return "\n".join(lines) + "\n"


def joint_table(source: Skeleton, target: Skeleton) -> JointTable:
    """Pair joints by role and, where they have none, by name.

    Parameters
    ----------
    source, target : Skeleton

    Returns
    -------
    JointTable

    Examples
    --------
    >>> from kinetograph.formats.deepmimic import skeleton
    >>> table = joint_table(skeleton(), skeleton())
    >>> table.pairs["left_knee"], table.rest
    ('left_knee', ())
    """
    pairs: dict[str, str] = {}
    why: dict[str, str] = {}
    for role in ROLES:
        here, there = target.roles.get(role), source.roles.get(role)
        # a point on a joint, as the tip of a foot, has no rotation of its own; in the source it still has its joint's
        if here is None or there is None or here.offset.any() or target.names[here.joint] in pairs:
            continue
        pairs[target.names[here.joint]] = source.names[there.joint]
        why[target.names[here.joint]] = role
    named = dict(zip(read_names(source.names), source.names, strict=True))
    used = set(pairs.values())
    for name, words in zip(target.names, read_names(target.names), strict=True):
        partner = name if name in source.names else named.get(words)
        if name not in pairs and partner is not None and partner not in used:
            pairs[name], why[name] = partner, "name"
    order = {name: i for i, name in enumerate(target.names)}
    pairs = dict(sorted(pairs.items(), key=lambda pair: order[pair[0]]))
    return JointTable(pairs, tuple(name for name in target.names if name not in pairs), why)


def read_table(path: str | Path) -> JointTable:
    """Read a file with a table, see `parse_table`. Raises FormatError where it is none."""
    return parse_table(read_text(Path(path), "a table of joints"), path)


def parse_table(text: str, path: str | Path = "joint table") -> JointTable:
    """Read a table as `JointTable` prints it and a person may have edited it.

    Parameters
    ----------
    text : str
        One target joint, a tab and one source joint per line; ``-`` as the source leaves the joint in its rest pose.
        Lines that begin with ``#`` are comments.
    path : str or Path
        What errors call the file.

    Returns
    -------
    JointTable

    Raises
    ------
    FormatError
        With the line, if it has no two names or a target joint occurs twice.
    """
    pairs: dict[str, str] = {}
    rest: list[str] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = [cell.strip() for cell in line.split("\t")] if "\t" in line else line.split()
        if len(cells) < 2 or not cells[0] or not cells[1]:
            raise FormatError(path, "expected a target joint, a tab and a source joint or -", line=number)
        if cells[0] in pairs or cells[0] in rest:
            raise FormatError(path, f"target joint {cells[0]!r} occurs twice", line=number)
        if cells[1] == _NONE:
            rest.append(cells[0])
        else:
            pairs[cells[0]] = cells[1]
    return JointTable(pairs, tuple(rest), {})
