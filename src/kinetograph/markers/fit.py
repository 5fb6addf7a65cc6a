"""A skeleton's motion from markers, by inverse kinematics.

The body is first estimated: for Plug-in-Gait, from joint centres and axes in single frames, medians over the take of
the bones and of the markers' places on them; for other sets, from the places that a table gives on a reference body,
which is scaled. Then two fits alternate: of the poses of some frames to the markers, and of bones and places to those
poses, by linear least squares with the first estimate as a prior. Last, every frame is fitted, beginning with the pose
of the frame before it. A joint whose markers are hidden is drawn to rotations between those before and after, so weakly
that the markers that are seen decide where they can.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import landmark_positions
from kinetograph.markers.conventional import conventional_body
from kinetograph.markers.people import Person, find_people
from kinetograph.markers.plug_in_gait import MARKERS, missing
from kinetograph.markers.sets import MarkerSet, marker_sets, read_set
from kinetograph.markers.solver import ROUNDS, Solver, measured
from kinetograph.markers.template import first_body
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark
from kinetograph.take import Take, Track

_STRAY = 0.1  # metres: a marker that misses by more is noted
_LISTED = 8  # names in a note
_SPELLINGS = {"LFRA": "LFRM", "RFRA": "RFRM"}


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


def fit_markers(
    signal: Signal,
    subject: str | None = None,
    *,
    markers: str | Path | None = None,
    rounds: int = ROUNDS,
) -> MarkerFit:
    """The motion of a body that wears markers of a known set.

    Parameters
    ----------
    signal : Signal
        Points in metres, Y up, named as in the set, with or without a subject's name and a colon, underscore or space
        in front.
    subject : str, optional
        Whose markers to fit, where they are of several people.
    markers : str or Path, optional
        The set: one of the package's by name, or a ``.toml`` file with one's own (see `kinetograph.markers.read_set`).
        Unless given, the one of which most markers are there.
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
    Three markers of the pelvis are needed; legs, trunk, head and arms are fitted where they have markers. With those of
    the legs of Plug-in-Gait, joint centres are first those of gait laboratories; for other sets they are those of a
    reference body, scaled.

    References
    ----------
    Davis, Ounpuu, Tyburski, Gage: A gait analysis data collection and reduction technique. Human Movement Science 10,
    1991.
    """
    if not signal.spatial:
        raise RequestError("markers are points (F, P, 3), found channels")
    person = _person(signal, subject, None if markers is None else read_set(markers))
    names, notes = _worn(person, signal)
    points = np.where(signal.valid[..., None], signal.values, np.nan)[:, [person.columns[name] for name in names]]
    solver, places, names = _first(person, names, points, rounds)
    motion = solver.motion(places, signal.fps)
    on_body = {name: Landmark(int(j), places[i]) for i, (name, j) in enumerate(zip(names, solver.joints, strict=True))}
    fitted = landmark_positions(motion, list(on_body.values()))
    seen = solver.seen
    misses = np.where(seen, np.linalg.norm(fitted - solver.points, axis=-1), np.nan)
    return MarkerFit(motion, on_body, misses, (*notes, *_gaps(names, seen, signal.fps), *_strays(names, misses)))


def fitted_take(take: Take, markers: str | Path | None = None) -> tuple[Take, dict[str, MarkerFit]]:
    """Replace the markers in a take by motions.

    Parameters
    ----------
    take : Take
        Its motions, and signals that are not points, stay as they are.
    markers : str or Path, optional
        See `fit_markers`.

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
        people: list[str | None] = [*subjects(track, markers)]
        for person in people or [None]:
            key = "motion" if len(people) < 2 else person or name
            fits[key] = fit_markers(track, person, markers=markers)
            tracks[key] = fits[key].motion
    return replace(take, tracks=tracks, annotations=take.annotations if not fits else ()), fits


def subjects(signal: Signal, markers: str | Path | None = None) -> list[str]:
    """The names in front of the markers of people in a recording; ``""`` where there is none.

    Parameters
    ----------
    signal : Signal
    markers : str or Path, optional
        See `fit_markers`.

    Returns
    -------
    list of str
        Empty where there are no five markers of a known set.
    """
    chosen = None if markers is None else read_set(markers)
    return [person.name for person in find_people(_seen(signal), chosen)]


def _person(signal: Signal, subject: str | None, markers: MarkerSet | None) -> Person:
    people = find_people(_seen(signal), markers)
    if not people:
        wanted = f"the set {markers.title}" if markers else f"any known set ({', '.join(marker_sets())})"
        found = _listed([name for name in _seen(signal) if name])
        raise RequestError(f"no five markers of {wanted}; found {found or 'none'}; give your own set with --markers")
    if subject is None and len(people) > 1:
        names = ", ".join(person.name for person in people)
        raise RequestError(f"markers of {len(people)} people ({names}); name one of them")
    chosen = next((person for person in people if subject in (None, person.name)), None)
    if chosen is None:
        raise RequestError(f"no markers of {subject!r}; found those of {', '.join(one.name for one in people)}")
    return chosen


def _worn(person: Person, signal: Signal) -> tuple[list[str], list[str]]:
    """The markers of a person that are ever seen, and notes on the others."""
    names = list(person.columns)
    notes = [f"markers of {person.markers.title}: {len(names)} are there"]
    mine = [(i, name) for i, name in enumerate(_seen(signal)) if name and name.startswith(person.name)]
    if others := [name[len(person.name) :].lstrip(":_ ") for i, name in mine if i not in person.columns.values()]:
        notes.append(f"not of the set, left out: {_listed(others)}")
    return names, notes


def _seen(signal: Signal) -> list[str]:
    """The names of points, empty for those that are never seen."""
    return [name if signal.valid[:, i].any() else "" for i, name in enumerate(signal.names)]


def _first(person: Person, names: list[str], points: FloatArray, rounds: int) -> tuple[Solver, FloatArray, list[str]]:
    """A measured body, the places of its markers, and their names."""
    gait = [_SPELLINGS.get(name.upper(), name.upper()) for name in names]
    known = {name for group in MARKERS.values() for name in group}
    if person.markers.name == "plug_in_gait" and not missing(set(gait)) and set(gait) <= known:
        if "SACR" in gait:
            kept = [i for i, name in enumerate(gait) if name not in ("LPSI", "RPSI")]
            gait, points, names = [gait[i] for i in kept], points[:, kept], [names[i] for i in kept]
        solver, places, used = conventional_body(gait, points)
        places, solver = measured(solver, places, rounds)
        return solver, places, [gait[i] for i in used]
    solver, places, spread = first_body([person.place(name) for name in names], points)
    places, solver = measured(solver, places, rounds, spread)
    return solver, places, names


def _listed(names: list[str]) -> str:
    return ", ".join(names[:_LISTED]) + (f" and {len(names) - _LISTED} more" if len(names) > _LISTED else "")


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
