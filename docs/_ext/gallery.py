"""How the gallery shows the examples: in this order, with every picture that they write."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path
from typing import Any

ORDER = (
    "walk_a_path",
    "follow_a_walker",
    "pin_and_forbid",
    "alternatives",
    "live",
    "transcribe",
    "in_between",
    "hold_a_span",
    "cluster_chain",
    "sensor_drives_a_body",
    "simulate_and_calibrate",
    "cut_a_library",
    "provenance",
    "look_at_motion",
    "mirror",
    "retarget",
    "formats",
    "curve_analogies",
)
"""The examples from the first that a reader should see to the last; one that is not named here comes after them."""


BEGAN = time.time()
"""Pictures that are older than this are of an earlier build."""


class Order:
    """Sphinx-gallery's key to sort by.

    Parameters
    ----------
    folder : str
        The folder that is sorted.
    """

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def __call__(self, name: str) -> tuple[int, str]:
        """The place of an example's file."""
        stem = Path(name).stem.removeprefix("plot_")
        return (ORDER.index(stem) if stem in ORDER else len(ORDER), stem)


def written_pictures(block: Any, variables: dict[str, Any], conf: dict[str, Any], **_: Any) -> str:
    """The pictures and films that a block of an example has written into its folder, as reStructuredText."""
    from sphinx_gallery.scrapers import figure_rst

    folder = Path(os.environ["KINETOGRAPH_EXAMPLES"])
    seen: set[tuple[str, int]] = conf.setdefault("pictures_seen", set())
    paths = []
    for picture in sorted(folder.glob("*.[pg][ni][gf]"), key=lambda path: path.stat().st_mtime_ns):
        stamp = (str(picture), picture.stat().st_mtime_ns)
        if stamp in seen or picture.stat().st_mtime < BEGAN:
            continue
        seen.add(stamp)
        target = Path(next(variables["image_path_iterator"])).with_suffix(picture.suffix)
        shutil.copy(picture, target)
        paths.append(str(target))
    return figure_rst(paths, conf["src_dir"])


def no_arguments(conf: dict[str, Any], script_vars: dict[str, Any]) -> list[str]:
    """Examples are run without arguments."""
    return []
