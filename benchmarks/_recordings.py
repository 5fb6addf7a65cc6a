"""The recordings that benchmarks run on: walks in a folder that ``KINETOGRAPH_DATA`` names, else the sample's walks."""

from __future__ import annotations

import tempfile
from pathlib import Path

from kinetograph.formats import ReadOptions
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.pipeline import read_take
from kinetograph.samples import data_folders, fetch


def data_folder() -> Path | None:
    """The first folder with recordings of walks that ``KINETOGRAPH_DATA`` names, if any."""
    return next((folder for folder in data_folders() if (folder / "walks").is_dir()), None)


class Walker:
    """A library of walks, in a temporary folder, and a model of it."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._library: Library | None = None

    @property
    def library(self) -> Library:
        if self._library is None:
            self._library = Library.create(Path(self._folder.name) / "walks")
            for path in self._files():
                self._library.add(read_take(path, ReadOptions())[0])
        return self._library

    @property
    def real(self) -> bool:
        """Whether these are long recordings rather than the sample's clips."""
        return data_folder() is not None

    def __call__(self) -> PerformanceModel:
        return PerformanceControl().fit(self.library)

    def _files(self) -> list[Path]:
        folder = data_folder()
        if folder:
            return sorted((folder / "walks").glob("15_*.bvh"))
        clips = fetch("deepmimic-clips")
        return [clips / f"{n}.txt" for n in ("0walk_forward", "turn_left0", "turn_left1", "turn_right0", "turn_right1")]


walker = Walker()
