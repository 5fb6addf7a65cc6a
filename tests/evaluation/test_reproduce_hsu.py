"""The page on Hsu 2004, made of stick figures: what is printed is what direct computation gives."""

from __future__ import annotations

import html
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import samples
from kinetograph.errors import RequestError
from kinetograph.evaluation.dance import COMMONEST, leave_one_dance_out
from kinetograph.evaluation.protocol import leave_one_take_out
from kinetograph.evaluation.reproduce.hsu2004 import dances as hsu_dances
from kinetograph.evaluation.reproduce.hsu2004 import gaits as hsu_gaits
from kinetograph.evaluation.reproduce.hsu2004 import models as hsu_models
from kinetograph.evaluation.reproduce.hsu2004 import phase as hsu_phase
from kinetograph.evaluation.reproduce.hsu2004 import report as hsu_report
from kinetograph.evaluation.reproduce.hsu2004 import sweeps as hsu_sweeps
from kinetograph.evaluation.reproduce.hsu2004 import timings as hsu_timings
from kinetograph.evaluation.reproduce.hsu2004 import walks as hsu_walks
from kinetograph.evaluation.reproduce.hsu2004.data import Recordings, collect, find_folder, lasting
from kinetograph.evaluation.reproduce.hsu2004.gaits import fit_all, in_step_by_length
from kinetograph.evaluation.reproduce.hsu2004.labels import as_played, held_out_errors, name_steps, steps_by_foot
from kinetograph.evaluation.reproduce.hsu2004.sway import CalmPath, sway_by_phase
from kinetograph.evaluation.reproduce.page import Section, page, paragraph, shown, table
from kinetograph.evaluation.reproduce.timing import processor_seconds
from kinetograph.methods.performance import GroundPath, PerformanceControl, PointsByRole, at_rate, points_of
from kinetograph.motion import Motion, place
from kinetograph.pipeline import segment_library
from kinetograph.take import Annotation, Take
from walkers import walk

_ENDS = {"left_toe": 1.0, "right_toe": 1.0, "left_hand": 1.0, "right_hand": 1.0}


def _wander(shift: float, duration: float = 9.0) -> Motion:
    times = np.arange(round(duration * 30) + 1) / 30
    return walk(
        duration, speed=1.0 + 0.25 * np.sin(0.9 * times + shift), turn_rate=0.6 * np.cos(0.7 * times + 2 * shift)
    )


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    library = kg.Library.create(tmp_path_factory.mktemp("walks") / "library")
    for name, shift in (("a", 0.0), ("b", 0.7)):
        library.add(Take(name, {"body": _wander(shift)}))
    segment_library(library, "footplants")
    return library


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer settings than even --quick has."""
    for module, name, values in (
        (hsu_timings, "SECONDS", 6.0),
        (hsu_timings, "SEGMENTS", 10),
        (hsu_timings, "BEAMS", (0.01,)),
        (hsu_timings, "LENGTHS", (3.0, 6.0, 9.0)),
        (hsu_sweeps, "CONTINUITY", (0.0, 0.1, 0.2)),
        (hsu_sweeps, "CLUSTERS", (None, 0.05)),
        (hsu_sweeps, "RATES", (10.0, 30.0)),
        (hsu_phase, "LENGTHS", (4.0,)),
        (hsu_gaits, "SIGMAS", (0.0, 0.6)),
    ):
        monkeypatch.setattr(module, name, values)
    monkeypatch.setattr(hsu_walks, "drawn", lambda draw, caption: paragraph(caption))


def _tables(text: str) -> dict[str, list[list[str]]]:
    """The cells of every table by its caption, read back from the page."""
    tables = {}
    for part in re.findall(r"<table>(.*?)</table>", text, re.S):
        caption = html.unescape(re.search(r"<caption>(.*?)</caption>", part)[1])
        rows = [line for line in part.split("\n") if line.startswith("<tr>")]
        tables[caption] = [[html.unescape(c) for c in re.split(r"<t[dh][^>]*>", row)[1:]] for row in rows]
    return tables


# ---- the whole page ----


def test_the_page_holds_every_table_and_its_numbers(
    tmp_path: Path, walks: kg.Library, small: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    recordings = Recordings(walks=walks, walks_from="two stick figures", missing=("two dances or more",))
    monkeypatch.setattr(hsu_report, "collect", lambda folder, scratch, quick: recordings)
    said: list[str] = []
    results = hsu_report.reproduce(tmp_path / "out", quick=True, report=said.append)
    assert said == ["missing: two dances or more"]
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "Missing: two dances or more." in text
    assert "Made with --quick" in text
    assert "Not made" not in text
    assert not re.search(r'(src|href)="(?!data:|#)', text), "the page needs another file"
    tables = _tables(text)
    assert [title.split(",")[0] for title in tables] == [
        *("Leave one take out", "Phase of the generated gait less that of the real one"),
        *("Excerpts that come out on the right foot", "Gait phase where turns are sharpest"),
        *("Share in phase by smoothing", "Processor time", "Processor time of the search", "Clustering"),
        *("The rate of the search; every result is scored by equation 4.5 at 30 Hz", "The continuity constant"),
        "Segments and patterns that come out as another move",
    ]
    assert text.count('src="data:image/png;base64,') == 5
    numbers = json.loads((tmp_path / "out" / "numbers.json").read_text())
    assert numbers["not yet"] == []
    assert numbers["Phase"] == json.loads(json.dumps(results["Phase"]))
    fits = numbers["Time against length"]["fits"]["exact"]
    assert set(fits) == {"slope", "intercept", "r2"}
    _rows_are_those_of_the_protocol(walks, tables["Leave one take out"])
    _continuity_agrees_with_the_protocol(walks, numbers["Continuity constant"]["rows"])
    with pytest.raises(RequestError, match="is not empty; name a new folder"):
        hsu_report.reproduce(tmp_path / "out")


def _rows_are_those_of_the_protocol(walks: kg.Library, cells: list[list[str]]) -> None:
    rows = {
        (r.take, r.method): r
        for r in leave_one_take_out(PerformanceControl(reuse=0.0, stand=False), walks, baselines=True)
    }
    printed = {(c[0], c[1]): c[2:7] for c in cells[1:] if c[0] != "mean"}
    assert printed.keys() == rows.keys()
    for key, row in rows.items():
        slide = "-" if np.isnan(row.slide) else f"{shown(row.slide)} ({shown(row.slide_recorded)})"
        assert printed[key] == [
            shown(row.control_cm),
            shown(row.joint_cm),
            shown(row.relative_cm),
            slide,
            shown(row.jerk),
        ]
    means = {c[1]: c for c in cells if c[0] == "mean"}
    ours = [rows[name, "segments"].joint_cm for name in "ab"]
    assert means["segments"][3] == shown(float(np.mean(ours)))


def _continuity_agrees_with_the_protocol(walks: kg.Library, rows: list[dict[str, float]]) -> None:
    """Quick: the longest take only, which is the first of the equally long ones."""
    for row in rows:
        method = PerformanceControl(reuse=0.0, stand=False, continuity=row["k, seconds"])
        direct = next(r for r in leave_one_take_out(method, walks) if r.take == "a")
        assert row["joints cm"] == pytest.approx(direct.joint_cm)
        assert row["control cm"] == pytest.approx(direct.control_cm)


def test_an_interrupted_page_holds_what_is_done_and_names_the_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt() -> Section:
        raise KeyboardInterrupt

    def refuse() -> Section:
        raise RequestError("no foot is ever planted")

    done = Section("first", (paragraph("it <is> done"),), {"x": float("nan")})
    steps = [
        hsu_report.Step("first", lambda: done),
        hsu_report.Step("second", refuse),
        hsu_report.Step("third", interrupt),
    ]
    monkeypatch.setattr(hsu_report, "collect", lambda folder, scratch, quick: Recordings())
    monkeypatch.setattr(hsu_report, "plan", lambda recordings, quick, tick: steps)
    said: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        hsu_report.reproduce(tmp_path / "out", report=said.append)
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "it &lt;is&gt; done" in text
    assert "Not made: no foot is ever planted" in text
    assert "interrupted before: third." in text
    assert said == ["second: not made: no foot is ever planted"]
    assert json.loads((tmp_path / "out" / "numbers.json").read_text())["first"] == {"x": None}
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["index.html", "numbers.json"]


def test_what_is_missing_is_named_and_nothing_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def offline(name: str) -> Path:
        raise kg.errors.FetchError(f"{name}: no connection")

    monkeypatch.setattr(samples, "where", lambda name: None)
    monkeypatch.setattr(samples, "fetch", offline)
    recordings = collect(None, tmp_path)
    assert (recordings.walks, recordings.clips, recordings.dances) == (None, None, None)
    assert [text.split(":")[0].split(" (")[0] for text in recordings.missing] == [
        *("the registry sample", "takes of CMU subject 15", "long walks of DeepMimic", "dances"),
    ]
    assert recordings.missing[0] == "the registry sample: deepmimic-clips: no connection"
    assert recordings.missing[1].endswith("expected 2 or more, one to hold out, found 0")
    assert hsu_report.plan(recordings, False, lambda text: None) == []


def test_the_folder_of_recordings_is_the_one_named_or_the_variables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(samples.DATA_VARIABLE, f"{tmp_path / 'none'}:{tmp_path}")
    assert find_folder(None) is None
    (tmp_path / "walks").mkdir()
    assert find_folder(None) == tmp_path
    with pytest.raises(RequestError, match=r"other: expected a folder with walks/ or salsa/ in it, found neither"):
        find_folder(tmp_path / "other")


def test_recordings_that_cannot_be_read_are_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(samples, "where", lambda name: None)
    monkeypatch.setattr(samples, "fetch", lambda name: tmp_path / "nowhere")
    (tmp_path / "walks").mkdir()
    for name in ("15_01", "15_03"):
        kg.save(walk(4.0), tmp_path / "walks" / f"{name}.bvh")
    (tmp_path / "salsa").mkdir()
    for name in ("a", "b"):
        for who in ("leader", "follower"):
            (tmp_path / "salsa" / f"{name}_{who}.bvh").write_text("not a motion")
    recordings = collect(tmp_path, tmp_path / "scratch")
    assert recordings.walks is not None
    assert recordings.walks.names() == ("15_01", "15_03")
    assert recordings.dances is None
    assert "a_leader.bvh" in next(text for text in recordings.missing if text.startswith("dances"))


# ---- phase ----


def test_a_path_alone_has_no_sway(walks: kg.Library) -> None:
    motion = walk(20.0)
    swaying = replace(motion, translation=motion.translation + _sway(motion))
    centres, mean, spread = sway_by_phase(swaying)
    assert np.nanmax(mean[:, 0]) - np.nanmin(mean[:, 0]) == pytest.approx(2 * 3.0, rel=0.1)
    assert np.nanmax(np.abs(mean[:, 1])) < 0.1
    assert np.nanmean(spread) < 0.5
    assert len(centres) == len(mean)
    calm = CalmPath().points(swaying)[60:-60].mean(axis=1)
    assert np.ptp(calm[:, 0]) < 0.001
    raw = GroundPath().points(swaying)
    np.testing.assert_allclose(np.linalg.norm(raw[:, 0] - raw[:, 1], axis=1), 0.3)
    np.testing.assert_allclose(np.linalg.norm(np.diff(CalmPath().points(swaying), axis=1), axis=-1), 0.3)


def _sway(motion: Motion) -> np.ndarray:
    """Three centimetres to either side, once a stride."""
    times = np.arange(len(motion)) / motion.fps
    return 0.03 * np.outer(np.cos(2 * np.pi * times), [1.0, 0.0, 0.0])


def test_hips_that_sway_with_the_stride_give_the_foot_at_any_length(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    takes = []
    for name, shift in (("a", 0.0), ("b", 0.9)):
        motion = _wander(shift, 12.0)
        takes.append((name, replace(motion, translation=motion.translation + _sway(motion))))
        library.add(Take(name, {"body": takes[-1][1]}))
    rows = in_step_by_length(takes, fit_all(library), 3, (3.0, 30.0))
    assert [(row[0], row[1], row[2]) for row in rows] == [(3.0, 6, 100.0)]


# ---- the search's own figures ----


def test_pieces_placed_again_cost_what_the_result_says(walks: kg.Library) -> None:
    motion = walks.take("a").motion()
    model = PerformanceControl(reuse=0.0, stand=False).fit(walks, exclude=("a",))
    result = model.synthesize(motion)
    dense = at_rate(points_of(model.method, motion), motion.fps, 30.0)
    again = hsu_models.placed_again(model, result, dense, 30.0)
    assert [p.cost for p in again] == pytest.approx([p.cost for p in result.pieces])
    assert [p.seam for p in again] == pytest.approx([p.seam for p in result.pieces])
    seams = np.array([p.seam for p in result.pieces[1:]]) / model.method.continuity
    gap = 100 * np.sqrt(seams.mean() / 4)  # four end effectors of weight 1
    assert hsu_models.seam_gap(model, result, motion) == pytest.approx(gap)


def test_clustering_to_a_number_comes_near_it(walks: kg.Library) -> None:
    full = PerformanceControl(reuse=0.0, stand=False).fit(walks)
    some = hsu_models.clustered(PerformanceControl(reuse=0.0, stand=False), walks, 12)
    assert len(full.fitted.instances.segments) > 25
    assert abs(len(some.fitted.instances.segments) - 12) <= 3
    assert len(
        hsu_models.clustered(PerformanceControl(reuse=0.0, stand=False), walks, 10**6).fitted.instances.segments
    ) == len(full.fitted.instances.segments)


def test_jobs_are_run_in_turn() -> None:
    order: list[str] = []
    taken = processor_seconds({"a": lambda: order.append("a"), "b": lambda: order.append("b")}, repeats=3)
    assert "".join(order) == "abababab"
    assert set(taken) == {"a", "b"}


def test_a_motion_lasts_as_long_as_is_asked() -> None:
    motion = walk(2.0)
    assert lasting(motion, 7.0).duration == pytest.approx(7.0)
    assert lasting(motion, 1.0).duration == pytest.approx(1.0)


# ---- moves of walks ----


def test_steps_are_named_by_the_foot_that_begins_them(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    for name in "ab":
        library.add(Take(name, {"body": walk(6.0, speed=1.0)}))
    segment_library(library, "footplants")
    take = library.take("a")
    cuts = [note.start for note in take.annotated("body", "cut")]
    names = steps_by_foot(take.motion(), cuts)
    # the left foot is planted at whole seconds, the right one half a second later
    assert names == ["left" if abs(t - round(t)) < 0.25 else "right" for t in cuts[:-1]]
    name_steps(library, steps_by_foot)
    errors, judged = held_out_errors(library, PerformanceControl())
    assert errors.segments == len(judged) == 2 * len(names)


def test_a_looping_clip_is_judged_step_by_step() -> None:
    clip = walk(1.0)
    notes = (Annotation("body", "loop", "wrap", 0.0, 1.0), Annotation("body", "move", "walk", 0.0, 100.0))
    played = as_played(Take("t", {"body": clip}, notes), walk(6.0))
    moves = played.annotated("motion", "move")
    assert len(moves) == len(played.annotated("motion", "cut")) - 1 > 8
    assert {note.label for note in moves} == {"walk"}


def test_the_samples_clips_are_distinguished_by_their_paths(tmp_path: Path, clips_folder: Path) -> None:
    recordings = collect(None, tmp_path)
    assert recordings.clips is not None
    assert recordings.walks is recordings.clips
    errors, names = held_out_errors(recordings.clips, PerformanceControl(reuse=0.0))
    assert set(names) == {"walk", "turn left", "turn right"}
    assert errors.segments == len(names) > 60
    assert errors.segment_rate < 0.25  # a third of the names would be right by chance


# ---- dances ----


def test_dances_are_printed_as_the_protocol_gives_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = kg.Library.create(tmp_path / "library")
    for name, shift in (("a", 0.0), ("b", 0.3)):
        leader = _wander(shift, 6.0)
        cuts = tuple(Annotation("follower", "cut", "", t, t) for t in np.arange(13) / 2)
        library.add(Take(name, {"leader": leader, "follower": place(leader, 0.0, (1.0, 0.0, 0.3))}, cuts))
    method = PerformanceControl(control_points=PointsByRole(_ENDS), span=2)
    monkeypatch.setattr(hsu_dances, "partner_control", lambda: method)
    monkeypatch.setattr(hsu_dances, "drawn", lambda draw, caption: paragraph(caption))
    section = hsu_dances.dance_section(library, lambda text: None)
    tables = _tables(page("t", [section]))
    for row in leave_one_dance_out(method, library, "follower", baselines=False):
        cells = next(c for c in tables["By dance"] if c[0] == row.take)
        assert cells[2:4] == [shown(row.joint_cm), shown(row.relative_cm)]
    assert len(tables["Means over the dances"]) == 1 + 6
    named = tables["Table 6.1: stances and transitions"]
    assert [row[:3] for row in named[1:4]] == [
        ["a", label, "6"] for label in ("segments", "nearest segment", COMMONEST)
    ]
    assert named[3][3:] == ["0", "0", "0"]  # two who walk next to each other never leave open stance
    units = hsu_dances.unit_section(library, True, lambda text: None).numbers["units"]
    assert [row["unit"] for row in units] == ["1 beat", "2 beats", "4 beats"]
    assert [row["segments"] for row in units] == [12, 11, 9]


# ---- the page's parts ----


def test_a_table_is_read_back_as_it_was_given() -> None:
    rows = [("a & b", 1.23456, None), ("c", 1234.5, 7)]
    text = table("x < y", ("name", "value", "count"), rows)
    assert _tables(text) == {"x < y": [["name", "value", "count"], ["a & b", "1.23", "-"], ["c", "1234", "7"]]}
    assert shown(float("nan")) == "-"
    assert shown(0.04884) == "0.0488"
