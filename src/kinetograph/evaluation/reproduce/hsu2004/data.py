"""The recordings that the experiments of Hsu 2004 use: those at hand, and what is missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from kinetograph import samples
from kinetograph.errors import KinetographError, RequestError
from kinetograph.evaluation.protocol import held_out_motion
from kinetograph.formats import ReadOptions
from kinetograph.library import Library
from kinetograph.motion import Motion, concatenate, cut, resample
from kinetograph.pipeline import read_take, segment_library
from kinetograph.take import Annotation, Take

CLIPS = {
    "humanoid3d_walk": "walk",
    "0walk_forward": "walk",
    "turn_left0": "turn left",
    "turn_left1": "turn left",
    "turn_right0": "turn right",
    "turn_right1": "turn right",
}
"""Walks of the registry sample, and the move that the name of each says it is."""
DANCE_RATE = 30.0
"""Frames per second that dances are resampled to."""


@dataclass(frozen=True, eq=False)
class Recordings:
    """Libraries, None where there are no recordings for them.

    Parameters
    ----------
    walks : Library, optional
    walks_from : str
        What the walks are.
    more_walks : Library, optional
        A second set of walks.
    clips : Library, optional
        The registry sample's clips with their moves.
    dances : Library, optional
    missing : tuple of str
        One line for each thing that is missing.
    """

    walks: Library | None = None
    walks_from: str = ""
    more_walks: Library | None = None
    clips: Library | None = None
    dances: Library | None = None
    missing: tuple[str, ...] = field(default=())


def find_folder(given: Path | None) -> Path | None:
    """The folder of recordings.

    Parameters
    ----------
    given : Path or None
        None takes the first of the folders that ``KINETOGRAPH_DATA`` names with walks or dances in it.

    Returns
    -------
    Path or None

    Raises
    ------
    RequestError
        For a given folder that has neither walks nor dances.
    """
    if given is not None:
        if not _has_recordings(given):
            raise RequestError(f"{given}: expected a folder with walks/ or salsa/ in it, found neither")
        return given
    return next((folder for folder in samples.data_folders() if _has_recordings(folder)), None)


def _has_recordings(folder: Path) -> bool:
    return (folder / "walks").is_dir() or (folder / "salsa").is_dir()


def collect(folder: Path | None, scratch: Path, quick: bool = False) -> Recordings:
    """Make libraries of a folder's recordings and of the registry sample.

    Parameters
    ----------
    folder : Path or None
        With recordings in ``walks/`` and ``salsa/``.
    scratch : Path
        Where the libraries are made.
    quick : bool
        Fewer dances.

    Returns
    -------
    Recordings
        Those that cannot be read are missing, and the line says why.
    """
    missing: list[str] = []
    clips = _or_missing(lambda: _clips(scratch / "clips"), "the registry sample", missing)
    sets = _sets_of_walks(folder, scratch, missing)
    if clips is not None and not sets:
        sets.append((clips, "looping clips of the registry sample, in the place of long walks"))
    walks, source = sets[0] if sets else (None, "")
    more = sets[1][0] if len(sets) > 1 else None
    what = "dances (salsa/*_leader.bvh and *_follower.bvh), of which the registry sample has none"
    dances = _or_missing(lambda: _dances(scratch / "dances", folder, quick), what, missing)
    return Recordings(walks, source, more, clips, dances, tuple(missing))


def _sets_of_walks(folder: Path | None, scratch: Path, missing: list[str]) -> list[tuple[Library, str]]:
    """The libraries of walks that a folder allows, and what they are."""
    sets = []
    for name, pattern, what in (
        ("walks", "15_*.bvh", "takes of CMU subject 15 (walks/15_*.bvh)"),
        ("long", "humanoid3d_long_walk*.txt", "long walks of DeepMimic (walks/humanoid3d_long_walk*.txt)"),
    ):
        files = sorted((folder / "walks").glob(pattern)) if folder else []
        made = _or_missing(partial(_walks, scratch / name, files), what, missing)
        if made is not None:
            sets.append((made, f"{len(files)} {what}"))
    return sets


def _or_missing(make: Callable[[], Library], what: str, missing: list[str]) -> Library | None:
    """What ``make`` gives; where it fails, None, and one more line says what is missing and why."""
    try:
        return make()
    except KinetographError as error:
        missing.append(f"{what}: {error}")
        return None


def held_out(library: Library) -> list[tuple[str, Motion]]:
    """Every take that walks, longest first, as it is held out."""
    takes = [(name, held_out_motion(library.take(name))) for name in library.names()]
    return sorted(takes, key=lambda pair: -pair[1].duration)


def lasting(motion: Motion, seconds: float) -> Motion:
    """A motion of so many seconds: the given one repeated, the last time in part. For timings only."""
    times = int(seconds // motion.duration) + 1
    return cut(concatenate([motion] * times), 0, int(seconds * motion.fps) + 1)


def _walks(where: Path, files: Sequence[Path]) -> Library:
    _expect_two(files)
    library = Library.create(where)
    for path in files:
        library.add(read_take(path, ReadOptions())[0])
    segment_library(library, "footplants")
    return library


def _expect_two(files: Sequence[object]) -> None:
    if len(files) < 2:
        raise RequestError(f"expected 2 or more, one to hold out, found {len(files)}")


def _clips(where: Path) -> Library:
    folder = samples.where("deepmimic-clips") or samples.fetch("deepmimic-clips")
    library = Library.create(where)
    for name, move in CLIPS.items():
        take = read_take(folder / f"{name}.txt", ReadOptions())[0]
        # a looping clip is played on and on: its move lasts as long
        named = Annotation(next(iter(take.tracks)), "move", move, 0.0, 100 * take.duration)
        library.add(Take(take.name, take.tracks, (*take.annotations, named)))
    return library


def _dances(where: Path, folder: Path | None, quick: bool) -> Library:
    leaders = sorted((folder / "salsa").glob("*_leader.bvh")) if folder else []
    pairs = [(path, path.with_name(path.name.replace("_leader", "_follower"))) for path in leaders]
    pairs = [pair for pair in pairs if pair[1].is_file()][: 3 if quick else None]
    _expect_two(pairs)
    library = Library.create(where)
    for leader, follower in pairs:
        tracks = {
            track: resample(read_take(path, ReadOptions("inch", "z"))[0].motion(), DANCE_RATE)
            for track, path in (("leader", leader), ("follower", follower))
        }
        library.add(Take(leader.stem.removesuffix("_leader"), tracks))
    segment_library(library, "beats")
    return library
