from __future__ import annotations

from pathlib import Path

import pytest

from kinetograph.errors import RequestError
from kinetograph.evaluation.reproduce.xie2009 import METHODS, reproduce
from kinetograph.library import Library
from kinetograph.methods.sensor import LocalSettings
from kinetograph.take import Take
from walkers import walk


def test_the_page_has_a_row_for_each_method_and_its_pictures(tmp_path: Path):
    library = Library.create(tmp_path / "lib")
    for name, speed in (("a", 0.8), ("b", 1.0), ("c", 1.2)):
        library.add(Take(name, {"motion": walk(2.0, speed=speed)}))
    small = LocalSettings(runs=1, clusters=4, frames=150, centres=40)
    rows = reproduce(tmp_path / "out", library, takes=("b",), local=small)
    assert [row.method for row in rows] == list(METHODS)
    page = (tmp_path / "out" / "index.html").read_text()
    for heading in ("Table 7.1", "Table 7.2", "Section 7.3", "Figure 7.5", "Figure 7.6", "Not comparable"):
        assert f"<h2>{heading}" in page
    assert "<td>thesis<td>tennis forehand<td>256<td>0.21<td>4.9" in page
    assert "<td>thesis<td>tennis backhand<td>206<td>0.057" in page
    assert all(f"{row.rms:.3f}" in page for row in rows)
    for picture in ("b_rms.png", "b_interpolation.png", "b_optimisation.png", "b_optimisation_ahead.png"):
        assert picture in page
        assert (tmp_path / "out" / picture).stat().st_size > 5000
    with pytest.raises(RequestError, match="is not empty; name a new folder"):
        reproduce(tmp_path / "out", library)
