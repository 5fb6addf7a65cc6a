"""Which takes of a library a method uses where takes have different skeletons, and how the others are brought over."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from kinetograph.errors import RequestError
from kinetograph.left_out import LeftOut, by_reason, left_out_lines, shortened, takes_counted, together
from kinetograph.library import Joints, Library, contents, joints_of
from kinetograph.motion import Motion
from kinetograph.post.retargeting import retarget
from kinetograph.post.retargeting_error import RetargetingError, pooled, retargeting_error
from kinetograph.skeleton import Skeleton, plain_names
from kinetograph.take import Annotation

WHERE = "where takes of"
"""Words in the reason for which takes of other skeletons are left out."""


@dataclass(frozen=True)
class Bodies:
    """Which skeleton is used of a library that has several.

    Parameters
    ----------
    like : str
        A take whose skeleton is used; empty for the skeleton of most seconds.
    retarget : bool
        Bring the takes of other skeletons over, by the roles of their joints; otherwise they are left out.
    """

    like: str = ""
    retarget: bool = False


@dataclass(frozen=True)
class Chosen:
    """The takes that a method uses.

    Parameters
    ----------
    names : tuple of str
        In the library's order.
    tracks : mapping of str to str
        The name of each take's motion.
    others : frozenset of str
        Takes of other skeletons, which are brought over.
    left : mapping of str to tuple of str
        Takes that are left out, by reason.
    first : str
        The first take with the skeleton that is used.
    """

    names: tuple[str, ...]
    tracks: Mapping[str, str]
    others: frozenset[str]
    left: LeftOut
    first: str


def choose_takes(
    library: Library, bodies: Bodies | None = None, *, exclude: Iterable[str] = (), track: str | None = None
) -> Chosen:
    """The takes of a library that a method uses, without reading their frames.

    Parameters
    ----------
    library : Library
    bodies : Bodies, optional
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.

    Returns
    -------
    Chosen

    Raises
    ------
    RequestError
        For a name to leave out that is not there, and for a library without takes to use.
    """
    bodies, names = bodies or Bodies(), library.names()
    left_out = frozenset(_whole_name(name, names) for name in exclude)
    if unknown := sorted(left_out - set(names)):
        raise RequestError(f"no take {unknown[0]!r} to leave out; there are {shortened(names) or 'none'}")
    tracks, seconds, without = _tracks(library, names, track)
    if names and not tracks:
        library.take(names[0]).named_motion(track)  # says what there is to name
    if not set(tracks) - left_out:
        raise RequestError("the library has no take to use; add recordings, or exclude fewer")
    groups = _groups(library, tracks)
    used = _used(groups, seconds, bodies)
    kept, others = groups[used][1], [name for i, (_, group) in enumerate(groups) if i != used for name in group]
    left = {} if bodies.retarget else _of_others(groups, used, left_out)
    chosen = {*kept, *(others if bodies.retarget else ())} - left_out
    if not chosen:
        raise RequestError(
            f"the library has no take to use with the skeleton of {kept[0]!r}; add recordings, or exclude fewer"
        )
    taken = tuple(name for name in names if name in chosen)
    without = by_reason((name, why) for why, some in without.items() for name in some if name not in left_out)
    return Chosen(taken, tracks, frozenset(others), together(without, left), kept[0])


def _whole_name(name: str, names: Sequence[str]) -> str:
    """The take of a name, or of what follows a slash in it; the name itself where there is none."""
    found = [name] if name in names else [whole for whole in names if whole.endswith(f"/{name}")]
    if len(found) > 1:
        raise RequestError(f"take {name!r} to leave out may be {', '.join(found[:6])}; give more of its name")
    return found[0] if found else name


def _of_others(groups: list[tuple[int, list[str]]], used: int, left_out: frozenset[str]) -> dict[str, tuple[str, ...]]:
    """The takes of other skeletons than the used one, by reason."""
    count = groups[used][0]
    return by_reason(
        (name, f"of {joints} joints{' of other names' * (joints == count)}, {WHERE} {count} are used")
        for place, (joints, names) in enumerate(groups)
        if place != used
        for name in names
        if name not in left_out
    )


def bring_over(
    motion: Motion, skeleton: Skeleton, notes: tuple[Annotation, ...] = (), *, alone: bool = True
) -> tuple[Motion, RetargetingError]:
    """A motion on another skeleton, by the roles of its joints, and what that cost.

    Parameters
    ----------
    motion : Motion
    skeleton : Skeleton
    notes : tuple of Annotation
        Of the motion; during handholds, wrists are brought to where they were.
    alone : bool
        Whether nobody is with the body: its path is scaled with the legs, which somebody with a partner cannot have.

    Returns
    -------
    motion : Motion
    cost : RetargetingError

    Raises
    ------
    RequestError
        For a skeleton without hips or legs.
    """
    held = tuple(note for note in notes if note.kind in ("contact", "handhold"))
    made = retarget(motion, skeleton, scale=None if alone else 1.0, handholds=held)
    return made.motion, retargeting_error(motion, made)


def cost_lines(costs: Mapping[str, tuple[Skeleton, RetargetingError]], skeleton: Skeleton) -> tuple[str, ...]:
    """What it cost to bring takes over, one line for each skeleton that they had.

    Parameters
    ----------
    costs : mapping of str to (Skeleton, RetargetingError)
        By take: the skeleton that it had, and what it cost.
    skeleton : Skeleton
        That which is used.
    """
    groups: dict[tuple[str, ...], list[str]] = {}
    for take, (had, _) in costs.items():
        groups.setdefault(plain_names(had.names), []).append(take)
    return tuple(
        f"{takes_counted(len(takes))} of {len(names)} joints brought over to {len(skeleton)} joints by roles: "
        f"{_cost_in_words(pooled(costs[take][1] for take in takes))} ({shortened(takes)})"
        for names, takes in groups.items()
    )


def _cost_in_words(error: RetargetingError) -> str:
    """What bringing motions over cost, with units.

    Examples
    --------
    >>> _cost_in_words(RetargetingError({"left_foot": 0.0, "left_hand": 0.02}, 0.05, 0.04, 10))
    'limbs are off by 1.0 cm in the mean, left_hand most with 2.0 cm; planted feet move at 5.0 cm/s, before at 4.0 cm/s'
    """
    worst = max(error.joints, key=error.joints.__getitem__)
    text = (
        f"limbs are off by {100 * error.mean:.1f} cm in the mean, {worst} most with {100 * error.joints[worst]:.1f} cm"
    )
    if error.feet != error.feet:
        return text
    return f"{text}; planted feet move at {100 * error.feet:.1f} cm/s, before at {100 * error.feet_before:.1f} cm/s"


def skeleton_like(library: Library, skeleton: Skeleton, track: str | None = None) -> str:
    """The first take of a library whose motion has the joints of a skeleton; empty where none has.

    Parameters
    ----------
    library : Library
    skeleton : Skeleton
    track : str, optional
        Name of the motions' track.
    """
    wanted = (plain_names(skeleton.names), tuple(skeleton.parents.tolist()))
    found = (take for (take, name), joints in joints_of(library).items() if joints == wanted and track in (None, name))
    return next(found, "")


def joints_differ(why: str) -> bool:
    """Whether takes are left out because of their skeletons."""
    return WHERE in why


def notes_on(left: LeftOut) -> tuple[str, ...]:
    """What a person should know of the takes that are left out: a line for each reason, and what to do about it."""
    advice = "--retarget brings them over, --skeleton-of TAKE uses others"
    lines = zip(left, left_out_lines(left), strict=True)
    return tuple(f"{line}; {advice}" if joints_differ(why) else line for why, line in lines)


def _tracks(
    library: Library, names: Sequence[str], track: str | None
) -> tuple[dict[str, str], dict[str, float], dict[str, tuple[str, ...]]]:
    """The motion of each take that has the one that is asked for, its seconds, and takes without one, by reason."""
    motions: dict[str, dict[str, float]] = {name: {} for name in names}
    for info in contents(library):
        if info.kind == "motion" and info.take in motions:
            motions[info.take][info.name] = info.duration
    found, without = {}, []
    for name, each in motions.items():
        only = track if track is not None else next(iter(each), "") if len(each) == 1 else ""
        if only in each:
            found[name] = only
        else:
            without.append((name, _why_without(tuple(each), track)))
    return found, {name: motions[name][used] for name, used in found.items()}, by_reason(without)


def _why_without(motions: tuple[str, ...], track: str | None) -> str:
    if track is not None:
        return f"without a motion {track!r}"
    return f"with several motions ({', '.join(motions)}; name one with --track)" if motions else "without a motion"


def _groups(library: Library, tracks: Mapping[str, str]) -> list[tuple[int, list[str]]]:
    """The takes by their joints, in order: how many joints, and the names."""
    joints = joints_of(library)
    groups: dict[Joints, list[str]] = {}
    for name, track in tracks.items():
        groups.setdefault(joints[name, track], []).append(name)
    return [(len(key[0]), names) for key, names in groups.items()]


def _used(groups: list[tuple[int, list[str]]], seconds: Mapping[str, float], bodies: Bodies) -> int:
    """Which group is used: that of the take that is named, or that of most seconds."""
    if bodies.like:
        for place, (_, names) in enumerate(groups):
            if bodies.like in names:
                return place
        raise RequestError(
            f"no take {bodies.like!r} whose skeleton could be used; there are {shortened(list(seconds))}"
        )
    totals = [sum(seconds[name] for name in names) for _, names in groups]
    return max(range(len(groups)), key=totals.__getitem__)
