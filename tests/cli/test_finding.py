"""Labels from tables, and finding takes by words and by example, on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import answer, invoke

from kinetograph.formats import save
from kinetograph.library import Library, facts_of
from kinetograph.motion import cut
from kinetograph.take import Take
from walkers import walk

NAMES = ("18_19_Justin/18_01_poses", "18_19_rory/18_01_poses", "18_19_Justin/18_10_poses", "02/02_03_poses", "02/02_04")


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library.create(tmp_path / "library")
    for number, name in enumerate(NAMES):
        made.add(Take(name, {"motion": walk(4.0 + number / 10, period=0.7 + 0.15 * number)}))
    return made


def label(library: Library, folder: Path, text: str, *options: str, name: str = "labels.csv") -> dict[str, object]:
    (folder / name).write_text(text)
    told: dict[str, object] = json.loads(
        answer("library", "label", library.path, folder / name, "--json", *options).stdout
    )
    return told


def test_a_table_labels_takes_and_names_what_it_skips(library: Library, tmp_path: Path) -> None:
    table = (
        "Subject,Motion,Description,Tags\n2,3,run/jog,fast; outdoors\n18,1,two people,\n"
        '02,4,"jump, balance",\n5,1,walk,\n18,10,sits,"calm,low"\n'
    )
    told = label(library, tmp_path, table)
    assert told["labelled"] == 3
    assert told["skipped"] == [
        "labels.csv:3: '18_1' is several takes, 18_19_Justin/18_01_poses, 18_19_rory/18_01_poses",
        "labels.csv:5: '5_1' is no take",
    ]
    facts = facts_of(library)
    assert facts["02/02_03_poses"].tags == {"fast", "outdoors"}
    assert (facts["02/02_04"].text, facts["02/02_04"].subject) == ("jump, balance", "02")
    assert facts["18_19_Justin/18_10_poses"].tags == {"calm", "low"}
    assert facts["18_19_rory/18_01_poses"].text == ""


def test_the_index_of_a_corpus_as_it_comes(library: Library, tmp_path: Path) -> None:
    index = (
        "A listing\n\nSubject #2 (various)\n\n02_03\trun/jog\n02_04\tjump, balance\n\nSubject #5 (dance)\n05_01\twalk\n"
    )
    told = label(library, tmp_path, index, "--words", name="index.txt")
    assert told["labelled"] == 2
    assert facts_of(library)["02/02_03_poses"].tags == {"run", "jog"}
    assert facts_of(library)["02/02_03_poses"].subject == "2"
    assert told["tags"] == {"run": 1, "jog": 1, "jump": 1, "balance": 1}


def test_labels_go_out_and_come_back(library: Library, tmp_path: Path) -> None:
    label(library, tmp_path, "take;tags;text\n02_04;a, b;x, y\n18_19_rory/18_01_poses;c;\n")
    before = facts_of(library)
    answer("library", "label", library.path, "--export", tmp_path / "out.csv")
    label(library, tmp_path, "take,tags,text\n02_04,,\n18_19_rory/18_01_poses,z,\n")
    assert facts_of(library) != before
    answer("library", "label", library.path, tmp_path / "out.csv")
    assert facts_of(library) == before


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,x,z\n1,2,3\n", "expected a header with take .* found t, x, z"),
        ("take,colour\n02_04,red\n", "expected a header with take"),
        ("subject,motion,text\n2,,walk\n", "labels.csv:2: expected the name of a take, found an empty cell"),
        ("", "found nothing"),
    ],
)
def test_another_table_is_refused(text: str, message: str, library: Library, tmp_path: Path) -> None:
    (tmp_path / "labels.csv").write_text(text)
    refused = invoke("library", "label", library.path, tmp_path / "labels.csv")
    assert refused.exception is not None
    with pytest.raises(type(refused.exception), match=message):
        raise refused.exception


def test_takes_are_found_by_words_and_tags(library: Library, tmp_path: Path) -> None:
    label(library, tmp_path, "take,tags,text\n02_03,fast,run and jog\n02_04,slow,jump\n")
    found = json.loads(answer("library", "find", library.path, "jog", "--json").stdout)
    assert [row["take"] for row in found] == ["02/02_03_poses"]
    found = json.loads(answer("library", "find", library.path, "--tagged", "slow", "--json").stdout)
    assert [(row["take"], row["text"]) for row in found] == [("02/02_04", "jump")]
    assert "nothing has the words 'tango'" in str(invoke("library", "find", library.path, "tango").exception)


def test_windows_are_found_by_an_example(library: Library, tmp_path: Path) -> None:
    asked = ("library", "find", library.path, "--json", "--like")
    own = json.loads(answer(*asked, "take:02/02_04@1-2").stdout)
    assert all(row["take"] != "02/02_04" or row["stop"] < 1.0 or row["start"] > 2.0 for row in own)
    save(cut(walk(4.0, period=1.0), 30, 61), tmp_path / "example.bvh")
    found = json.loads(answer(*asked, f"{tmp_path / 'example.bvh'}@0-1", "--count", "4", "--each", "2").stdout)
    assert len(found) == 4
    assert found[0]["take"] == NAMES[2]
    assert [row["distance"] for row in found] == sorted(row["distance"] for row in found)
    some = json.loads(answer(*asked, "take:02/02_04@1-2", "--takes", "*rory*").stdout)
    assert {row["take"] for row in some} == {NAMES[1]}


@pytest.mark.parametrize(
    ("example", "message"),
    [
        ("take:02/02_04", "an example is FILE@2-4 or take:NAME@2-4"),
        ("take:02/02_04@2", "an example is FILE@2-4"),
        ("take:02/02_04@3-9", "expected a part of the 4.40 s"),
        ("take:nobody@1-2", "no take 'nobody'"),
    ],
)
def test_another_example_is_refused(example: str, message: str, library: Library) -> None:
    assert message in str(invoke("library", "find", library.path, "--like", example).exception)


def test_of_many_duplicates_the_longest_are_listed(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    library.add(Take("again", {"motion": cut(library.take(NAMES[0]).motion(), 15, 121)}))
    monkeypatch.setattr("kinetograph.cli.find._FEW", 0)
    answered = answer("library", "duplicates", library.path)
    assert "list them with --all" in answered.stderr
    assert "18_01_poses" not in answered.stdout
    assert "18_01_poses" in answer("library", "duplicates", library.path, "--all").stdout


def test_duplicates_are_listed(library: Library) -> None:
    assert json.loads(answer("library", "duplicates", library.path, "--json").stdout) == []
    library.add(Take("again", {"motion": cut(library.take(NAMES[0]).motion(), 15, 121)}))
    rows = json.loads(
        answer("library", "duplicates", library.path, "--json", "--takes", "*Justin*", "--takes", "again").stdout
    )
    assert [(row["take"], row["other"], row["mirrored"]) for row in rows] == [(NAMES[0], "again", False)]
    assert "18_19_Justin/18_01_poses" in answer("library", "duplicates", library.path, "--least", "3").stdout
