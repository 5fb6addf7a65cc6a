"""A skeleton's motion from the markers of the Plug-in-Gait set, by inverse kinematics.

The body is first estimated from joint centres and axes in single frames: medians over the take of the bones and of the
markers' places on them. Then two fits alternate: of the poses of some frames to the markers, and of bones and places
to those poses, by linear least squares with the first estimate as a prior. Last, every frame is fitted, beginning with
the pose of the frame before it. A joint whose markers are hidden is drawn to rotations between those before and after,
so weakly that the markers that are seen decide where they can.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import landmark_positions
from kinetograph.markers.plug_in_gait import MARKERS, Segment, leg_length, missing, segments
from kinetograph.markers.solver import ROUNDS, Solver, measured
from kinetograph.motion import Motion
from kinetograph.roles import with_found_roles
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark, Skeleton
from kinetograph.take import Take, Track

_STRAY = 0.1  # metres: a marker that misses by more is noted
_TIPS = {"toe": (0.0, 0.0, 0.06), "head": (0.0, 0.21, 0.0), "hand": (0.2, 0.0, 0.0)}  # of the leg's length; the left's


@dataclass(frozen=True, eq=False)
class MarkerFit:
    """A motion fitted to markers.

    Parameters
    ----------
    motion : Motion
    places : dict of str to Landmark
        Where each marker is on the skeleton.
    misses : ndarray, shape (F, M)
        Metres from each marker to its place on the body, NaN where it was not seen.
    notes : tuple of str
        What was left out or bridged.
    """

    motion: Motion
    places: dict[str, Landmark]
    misses: FloatArray
    notes: tuple[str, ...]

    def residuals(self) -> list[dict[str, str | float]]:
        """Mean, 95 % and maximum of the misses in mm, and the share of frames seen, per marker and for all together."""
        rows = [_row(name, self.misses[:, i]) for i, name in enumerate(self.places)]
        return [*rows, _row("all", self.misses.reshape(-1))]


def fit_markers(signal: Signal, subject: str | None = None, *, rounds: int = ROUNDS) -> MarkerFit:
    """The motion of a body that wears the Plug-in-Gait markers.

    Parameters
    ----------
    signal : Signal
        Points in metres, Y up, named as in the set, with or without a subject's name and a colon in front.
    subject : str, optional
        Whose markers to fit, where they are of several people.
    rounds : int
        How often the body is measured; with 0, bones and joint centres are those of the first estimate.

    Returns
    -------
    MarkerFit
        The skeleton's rest pose is a T pose, and its bones are those of the body.

    Raises
    ------
    RequestError
        Markers are missing, or no frame shows enough of them at once.

    Notes
    -----
    The markers of pelvis and legs are needed. Trunk, head and arms are fitted where their markers are there; additional
    markers on thighs, arms and back improve the fit.

    References
    ----------
    Davis, Ounpuu, Tyburski, Gage: A gait analysis data collection and reduction technique. Human Movement Science 10,
    1991.
    """
    names, columns, notes = _own(signal, subject)
    points = np.where(signal.valid[..., None], signal.values, np.nan)[:, columns]
    body = segments({name: points[:, i] for i, name in enumerate(names)})
    wanted = [i for i, name in enumerate(names) if _segment_of(name) in body]
    names, points = [names[i] for i in wanted], points[:, wanted]
    seen: BoolArray = np.isfinite(points[..., 0])
    solver = Solver(_skeleton(body, names, points), np.nan_to_num(points), seen, _joints(body, names), _guess(body))
    places, solver = measured(solver, _places(body, names, points), rounds)
    motion = solver.motion(places, signal.fps)
    on_body = {name: Landmark(int(j), places[i]) for i, (name, j) in enumerate(zip(names, solver.joints, strict=True))}
    fitted = landmark_positions(motion, list(on_body.values()))
    misses = np.where(seen, np.linalg.norm(fitted - solver.points, axis=-1), np.nan)
    return MarkerFit(motion, on_body, misses, (*notes, *_gaps(names, seen, signal.fps), *_strays(names, misses)))


def fitted_take(take: Take) -> tuple[Take, dict[str, MarkerFit]]:
    """Replace the markers in a take by motions.

    Parameters
    ----------
    take : Take
        Its motions, and signals that are not points, stay as they are.

    Returns
    -------
    take : Take
        A motion is named after the person where several wear markers.
    fits : dict of str to MarkerFit
        By track.

    Raises
    ------
    RequestError
        Points are not the markers of a body.
    """
    tracks: dict[str, Track] = {}
    fits: dict[str, MarkerFit] = {}
    for name, track in take.tracks.items():
        if not isinstance(track, Signal) or not track.spatial:
            tracks[name] = track
            continue
        people = subjects(track) or [""]
        for person in people:
            key = "motion" if len(people) < 2 else person or name
            fits[key] = fit_markers(track, person)
            tracks[key] = fits[key].motion
    return replace(take, tracks=tracks, annotations=take.annotations if not fits else ()), fits


def subjects(signal: Signal) -> list[str]:
    """The names in front of the colon of markers of the set; ``""`` where a marker's name has no colon."""
    known = {name for group in MARKERS.values() for name in group}
    split = [_split(name) for name in signal.names]
    return list(dict.fromkeys(person for person, name in split if name in known))


def _split(name: str) -> tuple[str, str]:
    person, _, marker = name.rpartition(":")
    return person, marker.strip().upper()


def _own(signal: Signal, subject: str | None) -> tuple[list[str], list[int], list[str]]:
    """The names of a body's markers, without the subject's name, their columns, and notes."""
    if not signal.spatial:
        raise RequestError("markers are points (F, P, 3), found channels")
    people = subjects(signal)
    if subject is None and len(people) > 1:
        raise RequestError(f"markers of {len(people)} people ({', '.join(people)}); name one of them")
    subject = (people or [""])[0] if subject is None else subject
    known = {name for group in MARKERS.values() for name in group}
    own = {marker: i for i, (person, marker) in enumerate(map(_split, signal.names)) if person == subject}
    never = {name for name, i in own.items() if not signal.valid[:, i].any()}
    lost = missing(own.keys() - never)
    if lost:
        some = ", ".join(list(own)[:8]) + (", ..." if len(own) > 8 else "")
        raise RequestError(f"no Plug-in-Gait body: missing the markers {', '.join(lost)}; found {some or 'none'}")
    others = [name for name in own if name not in known]
    names = [name for name in own if name in known and name not in never]
    if "SACR" in names:
        names = [name for name in names if name not in ("LPSI", "RPSI")]
    notes = [f"not of the Plug-in-Gait set, left out: {', '.join(others)}"] if others else []
    return names, [own[name] for name in names], notes


def _segment_of(name: str) -> str:
    return next(segment for segment, group in MARKERS.items() if name in group)


def _joints(body: dict[str, Segment], names: list[str]) -> IntArray:
    order = list(body)
    return np.array([order.index(_segment_of(name)) for name in names], dtype=np.int64)


def _in_axes(segment: Segment, points: FloatArray, name: str) -> FloatArray:
    """The median place, ``(3,)``, of points ``(F, 3)`` on a segment."""
    local = np.einsum("fba,fb->fa", segment.axes, points - segment.origin)
    known = local[np.isfinite(local).all(axis=1)]
    if len(known) == 0:
        raise RequestError(f"no frame shows {name} together with the markers next to it; too much is hidden")
    return np.asarray(np.median(known, axis=0))


def _places(body: dict[str, Segment], names: list[str], points: FloatArray) -> FloatArray:
    """Where the markers are on their segments, ``(M, 3)``."""
    return np.array([_in_axes(body[_segment_of(name)], points[:, i], name) for i, name in enumerate(names)])


def _skeleton(body: dict[str, Segment], names: list[str], points: FloatArray) -> Skeleton:
    order = list(body)
    parents = np.array([order.index(segment.parent) if segment.parent else -1 for segment in body.values()])
    offsets = np.zeros((len(order), 3))
    for i, (name, segment) in enumerate(body.items()):
        if segment.parent:
            offsets[i] = _in_axes(body[segment.parent], segment.origin, f"the joint {name}")
    leg = leg_length({name: points[:, i] for i, name in enumerate(names)})
    tips = [(i, name) for i, name in enumerate(order) if name.rpartition("_")[2] in _TIPS]
    ends = np.array([_TIPS[name.rpartition("_")[2]] for _, name in tips]) * leg
    ends[:, 0] *= [-1.0 if name.startswith("right") else 1.0 for _, name in tips]
    tip_parents = np.array([i for i, _ in tips], dtype=np.int64)
    return with_found_roles(Skeleton(tuple(order), parents, offsets, tip_parents, ends))


def _guess(body: dict[str, Segment]) -> tuple[FloatArray, FloatArray]:
    """Every frame's pose from its own markers: roots ``(F, 3)`` and local rotations ``(F, J, 4)``.

    Where markers are missing, a joint is in its rest pose and the root as in the frame before.
    """
    frames = np.arange(len(body["hips"].origin))
    known = np.flatnonzero(np.isfinite(body["hips"].axes).all(axis=(1, 2)))
    held = known[np.maximum(np.searchsorted(known, frames, side="right") - 1, 0)]
    world: dict[str, FloatArray] = {"": np.broadcast_to(np.eye(3), (len(frames), 3, 3))}
    local = []
    for name, segment in body.items():
        above = world[segment.parent]
        own = segment.axes if segment.parent else segment.axes[held]
        world[name] = np.where(np.isfinite(own.sum(axis=(1, 2), keepdims=True)), own, above)
        local.append(rot.from_matrix(np.einsum("fba,fbc->fac", above, world[name])))
    return body["hips"].origin[held], np.stack(local, axis=1)


def _gaps(names: list[str], seen: BoolArray, fps: float) -> list[str]:
    """A note on the markers that were hidden, with the longest time that one was hidden."""
    hidden = {name: int((~seen[:, i]).sum()) for i, name in enumerate(names) if not seen[:, i].all()}
    if not hidden:
        return []
    worst = max(hidden, key=lambda name: hidden[name])
    longest = max(_longest(~seen[:, i]) for i in range(len(names)))
    text = f"{len(hidden)} markers are hidden at times, {worst} in {hidden[worst]} of {len(seen)} frames"
    return [f"{text}, one for {longest / fps:.2f} s: bridged"]


def _strays(names: list[str], misses: FloatArray) -> list[str]:
    """A note on markers so far off at times that they are probably mistaken for others."""
    far = np.nan_to_num(misses) > _STRAY
    if not far.any():
        return []
    frames = np.flatnonzero(far.any(axis=1))
    which = ", ".join(name for i, name in enumerate(names) if far[:, i].any())
    text = f"{which} are more than {1000 * _STRAY:.0f} mm off in {len(frames)} frames, the first being {frames[0]}"
    return [f"{text}: mistaken for one another?"]


def _longest(hidden: BoolArray) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], hidden, [False]]).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max()) if len(edges) else 0


def _row(name: str, misses: FloatArray) -> dict[str, str | float]:
    seen = 1000.0 * misses[np.isfinite(misses)]
    figures = (float(seen.mean()), float(np.percentile(seen, 95)), float(seen.max())) if len(seen) else (0.0,) * 3
    mean, high, most = figures
    return {"marker": name, "mean_mm": mean, "p95_mm": high, "max_mm": most, "seen": len(seen) / len(misses)}
