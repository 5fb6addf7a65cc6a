from __future__ import annotations

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.synthesis import Piece, Synthesis
from walkers import walk


def _result() -> Synthesis:
    """Two pieces of a second: the first from 3.0 on, begun before the result; the second from 10.0, twice as slow."""
    pieces = (
        Piece("early", "motion", source_start=3.0, source_stop=4.5, start=-0.5, stop=1.0),
        Piece("late", "motion", source_start=10.0, source_stop=10.5, start=1.0, stop=2.0),
    )
    return Synthesis(walk(2.0, fps=10.0), pieces, cost=0.0)


def test_stretch_is_above_one_where_the_result_is_slower() -> None:
    first, second = _result().pieces
    assert first.stretch == pytest.approx(1.0)
    assert second.stretch == pytest.approx(2.0)


def test_source_time_is_the_recordings_own() -> None:
    first, second = _result().pieces
    assert float(first.source_time(0.0)) == pytest.approx(3.5)
    np.testing.assert_allclose(second.source_time([1.0, 1.5, 2.0]), [10.0, 10.25, 10.5])


def test_turn_is_about_the_vertical() -> None:
    w, x, y, z = rot.about("y", 0.6).tolist()
    assert Piece("t", "m", 0, 1, 0, 1, rotation=(w, x, y, z)).turn == pytest.approx(0.6)
    assert Piece("t", "m", 0, 1, 0, 1).turn == 0.0


def test_a_frame_on_a_seam_belongs_to_the_later_piece() -> None:
    result = _result()
    assert [result.piece_at(frame).take for frame in (0, 9, 10, 20)] == ["early", "early", "late", "late"]


def test_a_seam_is_met_whatever_the_rounding() -> None:
    starts = np.concatenate([[0.0], np.cumsum(np.full(90, 1 / 30))])
    assert (starts[:90] > np.arange(90) / 30).any()  # a sum is not the product
    pieces = tuple(Piece(str(i), "motion", 0, 1, *starts[i : i + 2].tolist()) for i in range(90))
    result = Synthesis(walk(3.0, fps=30.0), pieces, cost=0.0)
    assert [result.piece_at(frame).take for frame in range(90)] == [str(i) for i in range(90)]


def test_a_frame_before_the_first_piece_belongs_to_it() -> None:
    result = Synthesis(walk(1.0), (Piece("t", "m", 0, 1, 0.25, 1),), cost=0.0)
    assert result.piece_at(0).take == "t"


def test_every_frame_says_where_it_came_from() -> None:
    sources = _result().provenance()
    assert len(sources) == 21
    assert [take for take, _ in sources] == ["early"] * 10 + ["late"] * 11
    np.testing.assert_allclose([second for _, second in sources[:10]], 3.5 + np.arange(10) / 10)
    np.testing.assert_allclose([second for _, second in sources[10:]], 10.0 + np.arange(11) / 20)
