"""Long files into a library, a block at a time: as if they had been added whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import ReadOptions, load, save, stream
from kinetograph.formats.bvh import stream as streams
from kinetograph.library import Library, add_stream
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

CENTIMETRES = ReadOptions("centimetre", "z")


@pytest.fixture
def long_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(streams, "BLOCK", 2000)  # bytes: some ten frames
    rng = np.random.default_rng(8)
    skeleton = Skeleton(("a", "b", "c"), np.array([-1, 0, 1]), np.array([[0, 0, 0], [0, 0.5, 0], [0.1, 0.5, 0]]))
    rotations = rot.exp(np.cumsum(rng.normal(0, 0.05, (300, 3, 3)), axis=0))
    save(Motion(skeleton, rng.normal(0, 1, (300, 3)), rotations, 60.0), tmp_path / "long.bvh")
    return tmp_path / "long.bvh"


def test_a_stream_is_the_file(tmp_path: Path, long_file: Path) -> None:
    library = Library.create(tmp_path / "library")
    opened = stream(long_file, CENTIMETRES)
    seen: list[tuple[int, int]] = []
    add_stream(library, "long", opened, progress=lambda done, total: seen.append((done, total)))
    whole = load(long_file, units="centimetre", up="z").motion()
    back = library.take("long").motion()
    assert len(seen) > 10
    assert seen[-1] == (300, 300)
    assert back.fps == 60.0
    np.testing.assert_array_equal(back.translation, whole.translation)
    assert rot.angle_between(back.rotations, whole.rotations).max() < 1e-6
    assert library.check().orphaned == 0


def test_a_file_that_is_cut_short_leaves_the_library_as_it_was(tmp_path: Path, long_file: Path) -> None:
    library = Library.create(tmp_path / "library")
    before = (library.path / "frames-1.bin").stat().st_size
    lines = long_file.read_text().splitlines(keepends=True)
    long_file.write_text("".join(lines[:-30]))
    with pytest.raises(FormatError, match=r"Frames: 300, but there are 270 rows of numbers"):
        add_stream(library, "long", stream(long_file, CENTIMETRES))
    long_file.write_text("".join(lines[:-30]) + "1 2 three\n" * 30)
    with pytest.raises(FormatError, match=r"long\.bvh:294:5: expected a finite number, found 'three'"):
        add_stream(library, "long", stream(long_file, CENTIMETRES))
    assert library.names() == ()
    assert (library.path / "frames-1.bin").stat().st_size == before


def test_what_cannot_be_streamed_is_refused(tmp_path: Path, long_file: Path) -> None:
    text = long_file.read_text()
    long_file.write_text(text.replace("Frames: 300", "Frames: 1000000000"))
    with pytest.raises(FormatError, match="Frames: 1000000000, but there are 300 rows of numbers"):
        stream(long_file, CENTIMETRES)
    with pytest.raises(RequestError, match=r"only \.bvh files are read in blocks"):
        stream(tmp_path / "a.glb")
    with pytest.raises(FormatError, match="cannot open it"):
        stream(tmp_path / "nothing.bvh")


def test_a_name_that_is_taken(tmp_path: Path, long_file: Path) -> None:
    library = Library.create(tmp_path / "library")
    add_stream(library, "long", stream(long_file, CENTIMETRES))
    with pytest.raises(RequestError, match="has a take 'long' already"):
        add_stream(library, "long", stream(long_file, CENTIMETRES))
