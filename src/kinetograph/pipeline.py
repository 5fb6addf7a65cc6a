"""The main jobs from end to end: recordings -> library -> model -> control -> motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinetograph.errors import LibraryError, RequestError
from kinetograph.formats import READERS, ReadOptions, read
from kinetograph.keys import Key
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl
from kinetograph.methods.performance.ground_path import smooth_path
from kinetograph.methods.performance.grow import (
    GROWN,
    Growth,
    by_hand,
    cut_tracks,
    grow_rest,
    grow_takes,
    growing_control,
)
from kinetograph.methods.performance.model import PerformanceControl, PerformanceModel, only_track
from kinetograph.methods.performance.rules import Rule
from kinetograph.methods.performance.sources import LABELS
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.segmentation import (
    cuts_at_labels,
    cuts_by_length,
    detect_beats,
    detect_contacts,
    detect_handholds,
    footplant_cuts,
    subdivide,
)
from kinetograph.signal import Signal
from kinetograph.skeleton import with_roles
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation, Take

CUT_BY = ("footplants", "beats", "labels", "fixed")
"""What `segment_take` cuts by; `grow_library` cuts by examples."""


@dataclass(frozen=True)
class Smoothing:
    """How a drawn path is calmed before it is performed: Gaussian widths in seconds and in metres, 0 for none."""

    time: float = 0.0
    space: float = 0.0


def open_library(path: str | Path) -> Library:
    """Open a library. Raises LibraryError, which tells apart a folder of recordings, an empty one and none."""
    folder = Path(path)
    if folder.is_dir() and not (folder / "catalogue.sqlite").exists():
        recordings = [p for p in folder.iterdir() if p.suffix.lower() in READERS]
        if recordings:
            raise LibraryError(
                f"{folder}: a folder with {len(recordings)} recordings, not a library; "
                f"make one with: kinetograph library create LIB {folder}"
            )
    return Library.open(folder)


def has_partners(library: Library, target: str | None) -> bool:
    """Whether the takes of a library have tracks beside ``target``, one of which may have been its control.

    Raises RequestError where no take has the target, or where takes have several motions and none is named.
    """
    from kinetograph.library.store import contents

    tracks = [(track.take, track.name) for track in contents(library)]
    if target is None:
        motions = [(track.take, track.name) for track in contents(library) if track.kind == "motion"]
        if len(motions) > len({take for take, _ in motions}):
            found = ", ".join(sorted({name for _, name in motions}))
            raise RequestError(f"{library.path}: takes have several motions ({found}); name the one to make (--target)")
        return False
    with_target = {take for take, name in tracks if name == target}
    if tracks and not with_target:
        found = ", ".join(sorted({name for _, name in tracks}))
        raise RequestError(f"{library.path}: no take has a track {target!r}; their tracks are {found}")
    return any(name != target for take, name in tracks if take in with_target)


def recordings_in(paths: Iterable[str | Path]) -> list[Path]:
    """The motion files named, and those directly inside the folders named, by name. Raises RequestError for none."""
    found: list[Path] = []
    for path in map(Path, paths):
        if path.is_dir():
            found += sorted(p for p in path.iterdir() if p.suffix.lower() in READERS and p.suffix.lower() != ".csv")
        else:
            found.append(path)
    if not found:
        raise RequestError(f"no motion file found; expected one of {', '.join(sorted(READERS))}")
    return found


def read_take(path: Path, options: ReadOptions, roles: dict[str, str] | None = None) -> tuple[Take, tuple[str, ...]]:
    """A file as a take named after it, with roles given by joint name put in place; and what was guessed."""
    loaded = read(path, options)
    tracks = {
        name: replace(track, skeleton=with_roles(track.skeleton, roles or {})) if isinstance(track, Motion) else track
        for name, track in loaded.take.tracks.items()
    }
    return Take(path.stem, tracks, loaded.take.annotations), loaded.notes


def segment_take(
    take: Take, track: str, by: str, *, length: float = 0.5, label: str = "cut", parts: int = 1
) -> tuple[Annotation, ...]:
    """Cuts and contacts of one motion, and the handholds with the take's other motion, as annotations.

    by: one of `CUT_BY`; length: seconds, for ``"fixed"``; label: the kind of annotation, for ``"labels"``; parts: cuts
    a beat, for ``"beats"``, which are those of all the take's motions together.
    """
    motion = take.motion(track)
    contacts = detect_contacts(motion, track=track)
    if by == "footplants":
        cuts = footplant_cuts(motion, contacts)
    elif by == "beats":
        cuts = subdivide(detect_beats([t for t in take.tracks.values() if isinstance(t, Motion)]), parts)
    elif by == "fixed":
        cuts = cuts_by_length(take, track, length)
    elif by == "labels":
        cuts = cuts_at_labels(take, track, label)
    else:
        raise RequestError(f"cut by one of {', '.join(CUT_BY)}, examples; found {by!r}")
    return (*contacts, *_handholds(take, track), *(Annotation(track, "cut", by, time, time) for time in cuts))


def _handholds(take: Take, track: str) -> tuple[Annotation, ...]:
    """The handholds of one motion of a take that has two; none where there are more, or fewer."""
    others = [t for name, t in take.tracks.items() if isinstance(t, Motion) and name != track]
    own = take.motion(track)
    if len(others) != 1 or len(others[0]) != len(own) or others[0].fps != own.fps:
        return ()
    return detect_handholds(own, others[0], track=track)


def segment_library(
    library: Library,
    by: str,
    *,
    length: float = 0.5,
    label: str = "cut",
    parts: int = 1,
    progress: Progress | None = None,
) -> dict[str, int]:
    """Cut every motion of a library and store cuts, contacts and handholds as annotations; number of cuts by take.

    Takes that loop are left alone where they are cut by footplants: they are cut when they are used, over several
    cycles.
    """
    names = library.names()
    counts: dict[str, int] = {}
    for done, name in enumerate(names):
        take = library.take(name)
        counts[name] = 0
        for track, value in take.tracks.items():
            if not isinstance(value, Motion) or (by == "footplants" and take.annotated(track, "loop")):
                continue
            notes = segment_take(take, track, by, length=length, label=label, parts=parts)
            for kind in ("contact", "handhold", "cut"):
                library.annotate(name, tuple(n for n in notes if n.kind == kind), kind=kind, track=track)
            counts[name] += sum(n.kind == "cut" for n in notes)
        if progress:
            progress(done + 1, len(names))
    return counts


def refuse_cuts(take: Take, tracks: Iterable[str]) -> None:
    """Raise RequestError where one of a take's tracks has cuts already."""
    for track in tracks:
        if count := len(take.annotated(track, "cut")):
            raise RequestError(
                f"take {take.name!r} has {count} cuts on {track!r}; keep a copy (library annotate --export), "
                "then give --force to put others in their place"
            )


def cut_by_hand(library: Library, take: Take, tracks: Sequence[str], times: Iterable[float]) -> tuple[float, ...]:
    """Store a person's cuts on some motions of a take, in place of those there are; their seconds, in order.

    Contacts and handholds are stored where there are none. Raises RequestError for fewer than two times, or one
    outside the take.
    """
    cuts = tuple(sorted(set(times)))
    shortest = min(take.tracks[track].duration for track in tracks)
    outside = [time for time in cuts if not 0 <= time <= shortest + 1e-6]
    if outside:
        raise RequestError(f"take {take.name!r} lasts {shortest:.2f} s, found a cut at {outside[0]:g} s")
    if len(cuts) < 2:
        raise RequestError(f"segments need 2 cuts or more, found {len(cuts)}; nothing was written")
    for track in tracks:
        library.annotate(take.name, (Annotation(track, "cut", "tapped", t, t) for t in cuts), kind="cut", track=track)
        _store_meetings(library, take, track)
    return cuts


def grow_library(
    library: Library,
    method: PerformanceControl | None = None,
    *,
    examples: Sequence[str] = (),
    join: bool = False,
    rest: bool = False,
    again: bool = False,
    tolerance: float = 0.1,
    progress: Progress | None = None,
) -> list[Growth]:
    """Cut the takes of a library that have no cuts by those that have, and store cuts, labels, contacts and handholds.

    examples: the takes to learn from; without names, all that a person has cut. Those a person has cut are grown
    without their own cuts, and compared. join: see `grow_takes`. rest: what lies before the first and after the last
    cut of the examples is cut too. again: what was grown before is grown anew; it is left as it is otherwise, since a
    person may have edited it. No cut or label of a person's is changed. Raises RequestError where there is nothing to
    grow from.
    """
    takes = {name: library.take(name) for name in library.names()}
    hand = [by_hand(take) for take in takes.values() if any(_of_hand(note) for note in take.annotations)]
    known = [by_hand(takes.get(name) or library.take(name)) for name in examples] or hand
    method = method or growing_control(any(len(_motions(take)) > 1 for take in known))
    cut_tracks(known)
    used = {take.name for take in (*known, *hand)}
    left = [take for name, take in takes.items() if name not in used and _motions(take)]
    new = [take for take in left if again or not any(note.kind == "cut" for note in take.annotations)]
    others = [take for take in hand if examples and take.name not in examples]
    grown = grow_takes(method, known, [*new, *others], join=join, tolerance=tolerance, progress=progress)
    for take in known if len(known) > 1 and not examples else ():
        grown += grow_takes(method, [other for other in known if other is not take], [take], tolerance=tolerance)
    for growth, take in zip(grown, new, strict=False):
        _store_growth(library, take, growth)
    for take in known if rest else ():
        if again or not any(note.label == GROWN for note in takes[take.name].annotations):
            grown.append(grow_rest(method, known, take))
            _store_growth(library, take, grown[-1])
    return grown


def _of_hand(note: Annotation) -> bool:
    return note.kind == "cut" and note.label != GROWN


def _motions(take: Take) -> dict[str, Motion]:
    return {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}


def _store_growth(library: Library, take: Take, growth: Growth) -> None:
    """Cuts beside a person's; labels where there are none, or none but those of an earlier growth."""
    for track, grown in growth.tracks.items():
        cuts = take.annotated(track, "cut")
        library.annotate(take.name, (*filter(_of_hand, cuts), *grown.cuts), kind="cut", track=track)
        before = any(note.label == GROWN for note in cuts)
        for kind in LABELS:
            notes = [note for note in grown.labels if note.kind == kind]
            if notes and (before or not take.annotated(track, kind)):
                library.annotate(take.name, notes, kind=kind, track=track)
        _store_meetings(library, take, track)


def _store_meetings(library: Library, take: Take, track: str) -> None:
    """Contacts and handholds of a motion that has none stored: of feet with the ground, and of hands with hands."""
    if not take.annotated(track, "contact"):
        library.annotate(take.name, detect_contacts(take.motion(track), track=track), kind="contact", track=track)
    if not take.annotated(track, "handhold"):
        library.annotate(take.name, _handholds(take, track), kind="handhold", track=track)


def perform(
    control: Take | Signal | Motion,
    library: Library,
    method: PerformanceControl | None = None,
    *,
    smoothing: Smoothing | None = None,
    exclude: tuple[str, ...] = (),
    track: str | None = None,
    rules: Sequence[Rule] = (),
    progress: Progress | None = None,
) -> Synthesis:
    """The main job: a walker, made of the library's recordings, performs a control."""
    model = (method or PerformanceControl()).fit(library, exclude=exclude, track=track)
    return perform_with(model, control, smoothing=smoothing, rules=rules, progress=progress)


def perform_with(
    model: PerformanceModel,
    control: Take | Signal | Motion,
    *,
    smoothing: Smoothing | None = None,
    rules: Sequence[Rule] = (),
    progress: Progress | None = None,
) -> Synthesis:
    """The same by a model that is there, with its notes among the warnings."""
    result = model.synthesize(_smoothed(control, smoothing), progress, rules)
    return replace(result, warnings=(*model.notes, *result.warnings))


def perform_alternatives(
    model: PerformanceModel,
    control: Take | Signal | Motion,
    count: int,
    *,
    alike: bool = False,
    smoothing: Smoothing | None = None,
    rules: Sequence[Rule] = (),
) -> tuple[Synthesis, ...]:
    """The best performance of a control and up to ``count`` - 1 others: see `PerformanceModel.alternatives`."""
    found = model.alternatives(_smoothed(control, smoothing), count, rules, alike=alike)
    return tuple(replace(each, warnings=(*model.notes, *each.warnings)) for each in found)


def _smoothed(control: Take | Signal | Motion, smoothing: Smoothing | None) -> Signal | Motion:
    wanted = only_track(control) if isinstance(control, Take) else control
    if isinstance(wanted, Signal) and smoothing:
        return smooth_path(wanted, smoothing.time, smoothing.space)
    return wanted


def winding_path(speed: float = 0.95, fps: float = 30.0) -> Signal:
    """A path that turns both ways, about 18 m long, walked at ``speed`` metres a second: what the demo follows."""
    from scipy.interpolate import CubicSpline

    corners = np.array([(0, 0), (2, 0.3), (3.5, 2), (2.5, 4), (0.5, 4.5), (-1, 6), (0, 8), (2.5, 8.5)], dtype=float)
    dense = CubicSpline(np.arange(len(corners)), corners)(np.linspace(0, len(corners) - 1, 4000))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    even = np.linspace(0, along[-1], int(along[-1] / speed * fps) + 1)
    x, z = (np.interp(even, along, dense[:, i]) for i in (0, 1))
    return Signal(np.stack([x, np.zeros_like(x), z], axis=-1)[:, None], ("path",), "m", fps)


def inbetween(
    keys: tuple[Key, ...],
    library: Library,
    method: KeyframeControl | None = None,
    *,
    count: int = 1,
    exclude: tuple[str, ...] = (),
    track: str | None = None,
    seed: int = 0,
) -> tuple[Synthesis, ...]:
    """Motions through keys, made of a library's recordings: the best, and up to ``count`` - 1 that differ from it.

    seed: of the paper's clusters. Raises RequestError.
    """
    method = method or KeyframeControl()
    model = method.fit(library, exclude=exclude, track=track, rng=np.random.default_rng(seed))
    return model.alternatives(keys, count) if count > 1 else (model.synthesize(keys),)
