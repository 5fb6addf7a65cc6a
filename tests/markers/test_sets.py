"""Marker sets as tables: every set's body is found, sets and people are told apart by names, one's own is accepted."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from wearer import wearer, worn

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import load, save
from kinetograph.kinematics import joint_positions
from kinetograph.markers import (
    MarkerFit,
    fit_markers,
    fitted_take,
    landmarks,
    marker_sets,
    read_set,
    reference_body,
    subjects,
)
from kinetograph.markers.people import find_people
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Take

_LIMBS = ("hip", "knee", "foot", "shoulder", "elbow", "hand")


def misplaced(truth: Motion, fit: MarkerFit) -> FloatArray:
    """How far the limbs' joints that were fitted are from the truth, millimetres."""
    names = [f"{side}_{part}" for side in ("left", "right") for part in _LIMBS]
    names = [name for name in names if name in fit.motion.skeleton.names]
    there = joint_positions(truth)[:, [truth.skeleton.index(name) for name in names]]
    fitted = joint_positions(fit.motion)[:, [fit.motion.skeleton.index(name) for name in names]]
    return 1000 * np.linalg.norm(there - fitted, axis=-1)


@pytest.fixture(scope="module")
def body() -> tuple[Motion, dict[str, float]]:
    return wearer()


@pytest.mark.parametrize("name", [name for name in marker_sets() if name != "plug_in_gait"])
def test_joints_are_found_whatever_the_set(name: str, body: tuple[Motion, dict[str, float]]) -> None:
    signal = worn(*body, marker_sets()[name])
    fit = fit_markers(signal)
    assert any(f"markers of {marker_sets()[name].title}: {len(signal.names)}" in note for note in fit.notes)
    off = misplaced(body[0], fit)
    assert off.mean() < 4.0
    assert off.max() < 15.0
    assert fit.residuals()[-1]["mean_mm"] < 1.0
    assert len(fit.motion.skeleton.roles) >= (17 if name != "davis_bts" else 9)


@pytest.mark.parametrize("name", ["qualisys", "davis_bts"])
def test_misplaced_markers_on_moving_skin(name: str, body: tuple[Motion, dict[str, float]]) -> None:
    fit = fit_markers(worn(*body, marker_sets()[name], 0.01, 0.005))
    assert misplaced(body[0], fit).mean() < 20.0
    assert 2.0 < float(fit.residuals()[-1]["mean_mm"]) < 9.0


@pytest.mark.parametrize(
    ("names", "found"),
    [
        ("LASI RASI LPSI RPSI LTHI LKNE LTIB LANK LHEE LTOE", "plug_in_gait"),
        ("LASI RASI LPSI RPSI LTHI LKNE LKNM LTIB LTIAP LANK LMED LHEE LTOE", "cgm2"),
        ("RSHO ROFF RELB RWRI LSHO RASI LASI VSAC RTHI RKNE RSHA RANK RHEE RTOE", "helen_hayes"),
        ("R.ASIS L.ASIS V.Sacral R.Thigh R.Knee R.Shank R.Ankle R.Heel R.Toe Top.Head", "helen_hayes"),
        ("Q_WaistLFront Q_WaistRFront Q_WaistL Q_WaistBack Q_LKneeOut Q_SpineThoracic12 Q_LForefoot5", "qualisys"),
        ("WaistLFront WaistRFront WaistLBack WaistRBack LUArmHigh LThigh LShin BackTop HeadSide", "optitrack_baseline"),
        ("r asis,l asis,sacrum,r thigh,r bar 1,r knee 1,r knee 2,r bar 2,r mall,r met", "davis_bts"),
        ("RASIS LASIS RPSIS LPSIS RGT RLE RME RHF RTT RLM RMM RCA RFM RSM RVM", "ior"),
        ("R_IAS L_IAS R_IPS L_IPS R_FLE R_FME R_FAL R_TAM R_FCC R_FM1 R_FM5 CV7", "anatomical"),
        ("LFWT RFWT LBWT RBWT LTHI LKNE LSHN LANK LHEE LTOE LMT5", "cmu"),
    ],
)
def test_the_set_of_which_most_markers_are_there(names: str, found: str) -> None:
    people = find_people(names.split("," if "," in names else " "))
    assert [person.markers.name for person in people] == [found]


def test_names_before_the_markers_are_those_of_people(body: tuple[Motion, dict[str, float]]) -> None:
    signal = worn(*body, marker_sets()["davis_bts"])
    for before in ("Anna_", "Subject 1:", "Bo Lee: "):
        people = find_people([before + name for name in signal.names])
        assert [person.name for person in people] == [before.rstrip("_: ")]
    both = replace(
        signal,
        values=np.concatenate([signal.values, signal.values + np.array([1.0, 0.0, 0.5])], axis=1),
        names=(*("A_" + name for name in signal.names), *("B_" + name for name in signal.names)),
        valid=np.concatenate([signal.valid, signal.valid], axis=1),
    )
    assert subjects(both) == ["A", "B"]
    take, fits = fitted_take(Take("pair", {"markers": both}))
    assert list(take.tracks) == list(fits) == ["A", "B"]
    apart = take.motion("B").translation - take.motion("A").translation
    np.testing.assert_allclose(apart, np.broadcast_to([1.0, 0.0, 0.5], apart.shape), atol=1e-3)
    with pytest.raises(RequestError, match=r"markers of 2 people \(A, B\); name one of them"):
        fit_markers(both)
    with pytest.raises(RequestError, match="no markers of 'C'; found those of A, B"):
        fit_markers(both, "C")


def test_ones_own_set_is_a_table(tmp_path: Path, body: tuple[Motion, dict[str, float]]) -> None:
    signal = worn(*body, marker_sets()["davis_bts"])
    renamed = {name: f"m{i}" for i, name in enumerate(signal.names)}
    lines = ["title = 'mine'", "[markers]", "'*wand' = { segment = 'hip', place = [0.1, -0.2, 0.0], spread = 0.05 }"]
    by_place = {(place.segment, tuple(place.at)): name for name, place in landmarks().items()}
    places = marker_sets()["davis_bts"].places
    lines += [f"{new} = '{by_place[places[old].segment, tuple(places[old].at)]}'" for old, new in renamed.items()]
    (tmp_path / "mine.toml").write_text("\n".join(lines))
    mine = read_set(tmp_path / "mine.toml")
    assert mine.title == "mine"
    np.testing.assert_allclose(mine.places["rwand"].at, [-0.1, -0.2, 0.0])
    assert (mine.places["rwand"].segment, mine.places["lwand"].segment) == ("right_hip", "left_hip")
    other = replace(signal, names=tuple(renamed.values()))
    with pytest.raises(RequestError, match=r"no five markers of any known set \(plug_in_gait, .*; found m0, m1, "):
        fit_markers(other)
    fit = fit_markers(other, markers=tmp_path / "mine.toml")
    np.testing.assert_allclose(joint_positions(fit.motion), joint_positions(fit_markers(signal).motion), atol=1e-6)
    save(Take("a", {"markers": other}), tmp_path / "a.csv")
    take, _ = fitted_take(load(tmp_path / "a.csv", up="y", units="metre"), tmp_path / "mine.toml")
    assert list(take.tracks) == ["motion"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[markers]\na = 'left asos'", "marker 'a': no landmark 'left asos'; did you mean left asis"),
        ("[markers]\na = 'asis'", "marker 'a': no landmark 'asis'"),
        ("[markers]\na = { segment = 'tail', place = [0, 0, 0] }", "no segment 'tail'; expected one of hips, left_hip"),
        ("[markers]\na = { segment = 'hips', place = [0, 9, 0] }", "expected a place and a spread in metres"),
        ("[markers]\na = { segment = 'hips', place = [0, 9] }", "expected a table of markers"),
        ("[markers]\n'a**' = 'asis'", "one \\* at most for the side"),
        ("markers = 3", "expected a table of markers"),
        ("[marker]\na = 'x'", "expected a table of markers"),
        ("extends = 'nothing'\n[markers]\na = 'c7'", "extends 'nothing'; expected one of plug_in_gait"),
        ("[markers", "expected TOML"),
    ],
)
def test_tables_that_are_wrong_are_refused_in_a_line(text: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(FormatError, match=expected) as caught:
        read_set(tmp_path / "a.toml")
    assert "\n" not in str(caught.value)


def test_a_set_that_is_not_there() -> None:
    with pytest.raises(RequestError, match="unknown marker set 'vicon'; expected one of plug_in_gait, "):
        read_set("vicon")
    with pytest.raises(FormatError, match="cannot open it"):
        read_set("nowhere.toml")


def test_units_that_are_wrong_and_a_pelvis_that_is_missing(body: tuple[Motion, dict[str, float]]) -> None:
    signal = worn(*body, marker_sets()["davis_bts"])
    with pytest.raises(RequestError, match=r"as on a body of 1\.\d+e\+03 m; give the file's units with --units"):
        fit_markers(replace(signal, values=1000 * signal.values))
    kept = [i for i, name in enumerate(signal.names) if name not in ("lasis", "sacrum", "rthigh", "lthigh")]
    few = Signal(signal.values[:, kept], tuple(signal.names[i] for i in kept), "m", signal.fps)
    with pytest.raises(RequestError, match="no frame shows three points of the pelvis at once"):
        fit_markers(few)


def test_every_landmark_is_on_the_skin_of_its_segment() -> None:
    body = reference_body()
    for name, place in landmarks().items():
        assert place.segment in body.names, name
        bones = [np.linalg.norm(body.offsets[child]) for child in body.children[body.index(place.segment)]]
        assert np.linalg.norm(place.at) < max([0.2, *bones]) * 1.35, name
        if name.startswith("left "):
            mirrored = landmarks()["right" + name[4:]]
            np.testing.assert_allclose(mirrored.at, place.at * [-1, 1, 1])
    # standing straight, the body is as tall as its table says, and its sides are alike
    top = joint_positions(Motion(body, np.zeros((1, 3)), np.tile([1.0, 0, 0, 0], (1, len(body), 1)), 1.0))[0]
    height = top[body.index("head"), 1] + landmarks()["head_top"].at[1] - top[body.index("left_foot"), 1] + 0.085
    assert math.isclose(height, 1.75, abs_tol=0.03)


def test_real_serves_fit_alike_by_the_table(data_folder: Path) -> None:
    signal = load(data_folder / "c3d" / "kinematics_tennis_serve.c3d").signal()
    part = replace(signal, values=signal.values[:400:5], valid=signal.valid[:400:5])
    conventional, by_table = fit_markers(part), fit_markers(part, markers="cgm2")
    assert by_table.residuals()[-1]["mean_mm"] < 1.3 * float(conventional.residuals()[-1]["mean_mm"])
    assert misplaced(conventional.motion, by_table).mean() < 30.0
