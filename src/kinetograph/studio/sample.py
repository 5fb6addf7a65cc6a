"""Libraries of the sample's clips, for whoever has none yet."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from kinetograph.errors import LibraryError
from kinetograph.library import Library
from kinetograph.progress import Progress

WALKS = ("0walk_forward", "humanoid3d_walk", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
"""The clips that walk: two straight cycles and four that turn."""

NAMES = ("walks", "moves")
"""The libraries: who walks, and everything that one person does."""


def sample_libraries(progress: Progress | None = None) -> Mapping[str, Path]:
    """The libraries of the sample, made once in the user's cache.

    Parameters
    ----------
    progress : callable, optional
        Called while the sample is fetched.

    Returns
    -------
    mapping of str to Path
        Their folders by name.

    Raises
    ------
    FetchError
        Where it cannot be fetched.
    """
    from kinetograph.samples import fetch

    clips = fetch("deepmimic-clips", progress=progress)
    folder = clips.parent / "libraries"
    folder.mkdir(exist_ok=True)
    names = sorted(path.stem for path in clips.glob("*.txt"))
    return {
        "walks": _library(folder / "walks", clips, WALKS),
        "moves": _library(folder / "moves", clips, names),
    }


def _library(folder: Path, clips: Path, names: Sequence[str]) -> Path:
    """A library of clips; one that is whole stays as it is."""
    from kinetograph.formats import ReadOptions
    from kinetograph.pipeline import read_take

    if folder.exists():
        try:
            if Library.open(folder).names() == tuple(sorted(names)):
                return folder
        except LibraryError:
            pass
    draft = folder.with_name(f".{folder.name}.draft")
    shutil.rmtree(draft, ignore_errors=True)
    library = Library.create(draft)
    for name in names:
        library.add(read_take(clips / f"{name}.txt", ReadOptions())[0])
    shutil.rmtree(folder, ignore_errors=True)
    draft.rename(folder)
    return folder
