"""Controls of other kinds: curves that may be scaled, and channels that are in no space."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.evaluation.metrics import joint_error
from kinetograph.methods.performance import Channels, Continued, Fixed, Ground, PerformanceControl, Similarity
from kinetograph.motion import cut, place
from kinetograph.post.assemble import PostSettings
from kinetograph.take import Annotation, Take
from walkers import walk

_PLAIN = PostSettings(blend="none", footskate=False, handholds=None)


@pytest.fixture(scope="module")
def curves() -> ModuleType:
    path = Path(__file__).resolve().parents[3] / "examples" / "plot_curve_analogies.py"
    spec = importlib.util.spec_from_file_location("curve_analogies", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_LINE = [(0, 0), (1, 0.5), (2, -0.2), (3, 0.4), (4.2, 0.2)]


def test_a_line_turned_and_made_larger_has_its_style_turned_and_made_larger(curves: ModuleType) -> None:
    plain = curves.line(_LINE)
    styled = curves.curly(plain)
    turn = 1.2 * np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    answer, pieces = curves.analogy(plain, styled, plain @ turn + [3.0, -1.0])
    known = int((pieces[-1].start - 0.1) * curves.RATE)  # the last piece leaves the example's last cut behind
    assert known > 0.8 * len(answer)
    np.testing.assert_allclose(answer[:known], (styled @ turn + [3.0, -1.0])[:known], atol=2e-3)
    assert [piece.scale for piece in pieces[:-1]] == pytest.approx([1.2] * (len(pieces) - 1), abs=1e-3)


def test_another_line_is_curled_alike(curves: ModuleType) -> None:
    plain = curves.line(_LINE)
    new = curves.line([(0, 0), (1, -0.4), (2, 0.1), (3, -0.3)])
    answer, _ = curves.analogy(plain, curves.curly(plain), new)
    assert len(answer) == len(new)
    away = np.linalg.norm(answer[:, None] - new[None], axis=-1).min(axis=1)
    assert 0.2 < away.max() < 2 * 0.16 * 1.4 + 0.05
    # a curl goes backwards once; there are as many as the line is long
    along = np.gradient(new, axis=0)
    back = np.einsum("fi,fi->f", np.gradient(answer, axis=0), along) < 0
    curls = np.count_nonzero(np.diff(back.astype(int)) > 0)
    assert abs(curls - len(new) / curves.RATE / curves.CURL) <= 1.5
    assert np.linalg.norm(np.diff(answer, axis=0), axis=1).max() < 0.15


def test_the_ground_group_does_not_scale(curves: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(curves, "METHOD", replace(curves.METHOD, alignment=Ground()))
    plain = curves.line(_LINE)
    _, pieces = curves.analogy(plain, curves.curly(plain), 1.2 * plain)
    assert [piece.scale for piece in pieces] == pytest.approx([1.0] * len(pieces))


def test_a_body_keeps_its_size_and_goes_further(tmp_path: Path) -> None:
    recording = walk(4.0, speed=1.0, turn_rate=0.4)
    library = kg.Library.create(tmp_path / "library")
    library.add(Take("walk", {"body": recording}, _cuts("body", 4.0)))
    path = np.stack([recording.translation * [1.3, 0.0, 1.3]], axis=1)
    method = PerformanceControl(alignment=Similarity(), stretch=0.0, post=_PLAIN)
    result = method.fit(library).synthesize(kg.Signal(path, ("path",), "m", 30.0))
    reach = np.linalg.norm(np.diff(result.motion.translation[:, [0, 2]], axis=0), axis=1).sum()
    assert reach == pytest.approx(1.3 * 4.0, rel=0.05)
    np.testing.assert_allclose(result.motion.skeleton.offsets, recording.skeleton.offsets)
    np.testing.assert_allclose(result.motion.translation[:, 1], recording.translation[0, 1])


# ---- channels ----


def _cuts(track: str, duration: float) -> tuple[Annotation, ...]:
    return tuple(Annotation(track, "cut", "", t, t) for t in np.arange(int(2 * duration) + 1) / 2)


def _speech(duration: float) -> kg.Signal:
    """Two channels that are never the same again."""
    times = np.arange(round(duration * 50) + 1) / 50
    return kg.Signal(np.stack([np.sin(1.1 * times), times**1.5], axis=1), ("loudness", "pitch"), "", 50.0)


def _spoken(folder: Path) -> kg.Library:
    library = kg.Library.create(folder / "library")
    gestures = walk(6.0, turn_rate=0.5)
    library.add(Take("talk", {"speech": _speech(6.0), "body": gestures}, _cuts("body", 6.0)))
    return library


def test_a_body_is_recovered_where_it_was_from_channels(tmp_path: Path) -> None:
    reading = Channels({"pitch": 1.0, "loudness": 0.5})
    method = PerformanceControl(alignment=Fixed(), stretch=0.0, control_points=reading, post=_PLAIN)
    speech = _speech(6.0)
    part = kg.Signal(speech.values[50:226], speech.names, "", 50.0)  # from 1 s to 4.5 s
    result = method.fit(_spoken(tmp_path), track="body").synthesize(part)
    assert joint_error(result.motion, cut(walk(6.0, turn_rate=0.5), 30, 136)) < 1e-3
    assert result.cost == pytest.approx(0.0, abs=1e-4)
    assert {piece.rotation for piece in result.pieces} == {(1.0, 0.0, 0.0, 0.0)}


def _said(folder: Path) -> kg.Library:
    """The same walk twice, in two places, with other words."""
    library = kg.Library.create(folder / "library")
    for name, pitch, at in (("here", 0.0, (0.0, 0.0, 0.0)), ("there", 100.0, (5.0, 0.0, 1.0))):
        body = place(walk(6.0, turn_rate=0.5), 0.4 * pitch, at)
        speech = kg.Signal(_speech(6.0).values[:, 1:] + pitch, ("pitch",), "", 50.0)
        library.add(Take(name, {"speech": speech, "body": body}, _cuts("body", 6.0)))
    return library


def _jump(pitch: float = 100.0) -> kg.Signal:
    """The words of the first for three seconds, then of the second."""
    values = _speech(6.0).values[:, 1:].copy()
    values[150:] += pitch
    return kg.Signal(values, ("pitch",), "", 50.0)


def test_a_body_goes_on_from_where_it_is(tmp_path: Path) -> None:
    method = PerformanceControl(
        alignment=Continued(), stretch=0.0, control_points=Channels({"pitch": 1.0}), post=_PLAIN
    )
    library = _said(tmp_path)
    result = method.fit(library, track="body").synthesize(_jump())
    assert [piece.take for piece in result.pieces] == ["here"] * 6 + ["there"] * 6
    assert joint_error(result.motion, walk(6.0, turn_rate=0.5)) < 5e-3  # a border may be a thirtieth of a second off
    assert result.costs["continuity"] == pytest.approx(0.0, abs=1e-6)
    recorded = replace(method, alignment=Fixed()).fit(library, track="body").synthesize(_jump())
    assert np.linalg.norm(np.diff(recorded.motion.translation, axis=0), axis=1).max() > 1.0
    assert recorded.costs["continuity"] > 1.0


def test_channels_cost_by_their_weights() -> None:
    reading = Channels({"pitch": 2.0})
    np.testing.assert_allclose(reading.points(_speech(1.0))[:, 0, 0], _speech(1.0).values[:, 1])
    np.testing.assert_allclose(reading.weights(), [2.0])


def test_channels_that_are_not_there_and_groups_that_make_no_sense(tmp_path: Path) -> None:
    with pytest.raises(
        RequestError,
        match=r"channels do not lie in space: .* found Ground\(\)",
    ):
        PerformanceControl(control_points=Channels({"pitch": 1.0}))
    with pytest.raises(RequestError, match="channels need positive weights by name, found"):
        Channels({})
    with pytest.raises(RequestError, match="no channel energy; its channels are loudness, pitch"):
        Channels({"energy": 1.0}).points(_speech(1.0))
    with pytest.raises(RequestError, match="no channel pitch; it has none"):
        Channels({"pitch": 1.0}).points(walk(1.0))
    with pytest.raises(RequestError, match="expected a track 'music' to control 'body', found speech"):
        Channels({"pitch": 1.0}, track="music").recorded(_spoken(tmp_path).take("talk"), "body")
    with pytest.raises(RequestError, match=r"scales run from one in \(0, 1\] to one of 1 or more, found 0 and 2"):
        Similarity(0, 2)
    with pytest.raises(RequestError, match=r"must be Ground\(\), .* or Continued\(\), found 'affine'"):
        PerformanceControl(alignment="affine")
