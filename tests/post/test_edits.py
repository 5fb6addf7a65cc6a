"""How far a motion is from what it was made of: where it stands and how it faces do not count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.motion import cut, place
from kinetograph.post.assemble import Part, edits
from kinetograph.synthesis import Piece
from walkers import walk


@pytest.mark.parametrize("shift", [(3.0, 0.0, 0.0), (0.0, 0.0, -4.0), (1.0, 0.0, 2.0)])
@pytest.mark.parametrize("heading", [0.0, 1.2])
def test_a_piece_that_is_only_placed_is_not_edited(shift: tuple[float, float, float], heading: float) -> None:
    recording = walk(3.0, turn_rate=0.3)
    stop = recording.duration
    turned = rot.about("y", heading)
    piece = Piece("walk", "motion", 0.0, stop, 0.0, stop, tuple(turned.tolist()), shift)
    placed = place(recording, heading, np.array(shift))
    assert edits(placed, [Part(piece, recording, ())]).max() < 1e-9


def test_what_is_lifted_or_bent_is_edited_by_as_much() -> None:
    recording = cut(walk(3.0), 0, 60)
    piece = Piece("walk", "motion", 0.0, 59 / recording.fps, 0.0, 59 / recording.fps)
    lifted = replace(recording, translation=recording.translation + np.array([0.0, 0.1, 0.0]))
    np.testing.assert_allclose(edits(lifted, [Part(piece, recording, ())]), 0.1, atol=1e-9)
