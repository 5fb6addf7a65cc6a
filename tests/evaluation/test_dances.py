"""The real dances, where they are at hand: the figures that the documentation quotes must stay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import kinetograph as kg
from kinetograph.evaluation.dance import leave_one_dance_out
from kinetograph.formats import ReadOptions
from kinetograph.methods.performance import partner_control, points_of, short_pieces
from kinetograph.motion import cut, resample
from kinetograph.pipeline import read_take, segment_library
from kinetograph.take import Take

_NAMES = ("Easy_01", "Easy_02", "Easy_03")


@pytest.fixture(scope="module")
def dances(data_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    folder = data_folder / "salsa"
    if not folder.is_dir():
        pytest.skip("no dances: the folder of recordings has no salsa/")
    library = kg.Library.create(tmp_path_factory.mktemp("dances") / "library")
    options = ReadOptions("inch", "z")
    for name in _NAMES:
        pair = {t: read_take(folder / f"{name}_{t}.bvh", options)[0].motion() for t in ("leader", "follower")}
        library.add(Take(name, {track: resample(motion, 30.0) for track, motion in pair.items()}))
    segment_library(library, "beats")
    return library


def test_simple_dances_are_followed_closely(dances: kg.Library) -> None:
    rows = leave_one_dance_out(partner_control(), dances, "follower", baselines=False)
    assert max(row.joint_cm for row in rows) < 12.0
    assert max(row.relative_cm for row in rows) < 5.0
    assert max(row.hold_median_cm for row in rows) < 2.0
    assert max(row.hold_p95_cm for row in rows) < 8.0
    assert all(row.slide <= row.slide_recorded for row in rows)
    assert min(row.times_real_time for row in rows) > 1.0


def test_clustering_leaves_fewer_segments(dances: kg.Library) -> None:
    full = partner_control().fit(dances, track="follower")
    fewer = replace(partner_control(), cluster=0.1).fit(dances, track="follower")
    assert len(fewer.fitted.instances.segments) < 0.8 * len(full.fitted.instances.segments)


def test_half_a_second_late_is_as_good_as_all_at_once(dances: kg.Library) -> None:
    leader = cut(dances.take("Easy_02").motion("leader"), 0, 601)
    offline = partner_control().fit(dances, exclude=("Easy_02",), track="follower").synthesize(leader)
    model = short_pieces(partner_control()).fit(dances, exclude=("Easy_02",), track="follower")
    live = model.start(leader.fps, 0.5)
    for points in points_of(model.method, leader):
        live.step(points)
    assert live.path().score < 1.05 * offline.cost
