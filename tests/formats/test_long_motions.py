"""Long motions are written block by block, and the bytes are those of writing them at once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import DataError
from kinetograph.formats import WriteOptions, body
from kinetograph.formats.bvh import writer
from kinetograph.motion import Motion
from kinetograph.take import Take
from walkers import walk


def _spinning() -> Motion:
    """A walk whose hips turn many times, so that angles pass 180 degrees."""
    motion = walk(5.0)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(rot.about("y", np.linspace(0.0, 40.0, len(motion))), rotations[:, 0])
    return replace(motion, rotations=rotations)


@pytest.mark.parametrize("options", [WriteOptions(), WriteOptions(units="inch", up="z", order="xyz")])
@pytest.mark.parametrize("block", [1, 7, 64])
def test_a_bvh_is_the_same_in_blocks(
    tmp_path: Path, block: int, options: WriteOptions, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = Take("pair", {"one": _spinning(), "two": walk(5.0, turn_rate=1.0)})
    for what in (_spinning(), pair):
        writer.write(what, tmp_path / "whole.bvh", options)
        with monkeypatch.context() as patch:
            patch.setattr(writer, "_BLOCK", block)
            writer.write(what, tmp_path / "blocks.bvh", options)
        assert (tmp_path / "blocks.bvh").read_bytes() == (tmp_path / "whole.bvh").read_bytes()


def test_soles_are_looked_at_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = walk(5.0)
    whole = body.sole_depth(motion)
    monkeypatch.setattr(body, "_BLOCK", 7)
    assert body.sole_depth(motion) == whole is not None


def test_a_motion_is_checked_to_its_last_frame() -> None:
    motion = walk(200.0)
    rotations = motion.rotations.copy()
    rotations[-1, 3] *= 1.1
    with pytest.raises(DataError, match=f"at frame {len(motion) - 1}, joint"):
        replace(motion, rotations=rotations)
    rotations[-1, 3] = np.nan
    with pytest.raises(DataError, match="must be finite"):
        replace(motion, rotations=rotations)
