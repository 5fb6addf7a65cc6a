"""Annotations as a table that people edit."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph.errors import FormatError, RequestError
from kinetograph.library import Library, annotations_of, export_annotations, import_annotations
from kinetograph.library.annotations_csv import read_annotations
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take

HEADER = "take,track,kind,label,start,stop\n"


def path_take(name: str, *notes: Annotation) -> Take:
    path = Signal(np.zeros((101, 1, 3)), ("path",), "m", 10.0)
    return Take(name, {"path": path, "hands": path}, notes)


def cut(time: float, track: str = "path") -> Annotation:
    return Annotation(track, "cut", "", time, time)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    library = Library.create(tmp_path / "library")
    library.add(path_take("walk", cut(1.0), cut(2.5), Annotation("hands", "move", "wave, left", 0.1, 3.0)))
    library.add(path_take("run"))
    return library


def test_the_table_is_what_it_says(library: Library, tmp_path: Path) -> None:
    path = tmp_path / "cuts.csv"
    assert export_annotations(library, path) == 3
    assert path.read_text().splitlines() == [
        "take,track,kind,label,start,stop",
        "walk,path,cut,,1.0,1.0",
        "walk,path,cut,,2.5,2.5",
        'walk,hands,move,"wave, left",0.1,3.0',
    ]
    assert export_annotations(library, path, kind="move") == 1
    assert len(path.read_text().splitlines()) == 2
    assert [p.name for p in tmp_path.iterdir() if p.name != "library"] == ["cuts.csv"]


def test_an_edited_table_replaces_only_what_it_names(library: Library, tmp_path: Path) -> None:
    path = tmp_path / "cuts.csv"
    path.write_text("\ufeff" + HEADER + "walk,path,cut,,4.0,\n\nrun,hands,move,jump,1,2.5\n", encoding="utf-8")
    assert import_annotations(library, path) == 2
    assert annotations_of(library, "walk") == (Annotation("hands", "move", "wave, left", 0.1, 3.0), cut(4.0))
    assert annotations_of(library, "run") == (Annotation("hands", "move", "jump", 1.0, 2.5),)


TEXT = st.text(max_size=6)
TIMES = st.tuples(st.floats(0, 10), st.floats(0, 10)).map(sorted)
NOTES = st.builds(lambda t, k, la, s: Annotation(t, k, la, *s), st.sampled_from(["path", "hands"]), TEXT, TEXT, TIMES)


@given(TEXT, st.lists(NOTES, max_size=4))
@settings(max_examples=40)
def test_a_table_read_back_changes_nothing(name: str, notes: list[Annotation]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        library = Library.create(Path(folder) / "library")
        library.add(path_take(name, *notes))
        path = Path(folder) / "notes.csv"
        assert export_annotations(library, path) == len(notes)
        library.annotate(name, [Annotation(n.track, n.kind, "overwritten", 0, 0) for n in notes])
        assert import_annotations(library, path) == len(notes)
        assert annotations_of(library, name) == tuple(notes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\n", r"notes\.csv:1: expected the header take,track,kind,label,start,stop, found nothing"),
        ("a;b\n", r"notes\.csv:1: expected the header .*, found a;b"),
        (HEADER + "walk,path,cut,,1\n", r"notes\.csv:2: expected 6 cells \(.*\), found 5"),
        (HEADER + "\nwalk,path,cut,,1,x\n", r"notes\.csv:3: expected seconds for start and stop, found '1', 'x'"),
        (HEADER + "walk,path,cut,,3,2\n", r"notes\.csv:2: an annotation runs from 0 <= start to stop >= start"),
        (HEADER + "walk,path,cut,,nan,nan\n", r"notes\.csv:2: an annotation runs from"),
        (HEADER + 'walk,path,cut,"a\nb",1,1\nwalk,path,cut,,,\n', r"notes\.csv:4: expected seconds .* '', ''"),
        (HEADER + "walk,feet,cut,,1,1\n", r"notes\.csv:2: no track 'feet' of take 'walk': .* has path, hands"),
        (HEADER + "wlak,path,cut,,1,1\n", r"notes\.csv:2: no track 'path' of take 'wlak': the library has no take"),
        (HEADER + "walk,path,cut,,1,10.2\n", r"notes\.csv:2: 10\.2 s lies after the end of track 'path' at 10\.000 s"),
        (HEADER + "walk,path,cut," + "x" * 200_000 + ",1,1\n", r"notes\.csv:2: not a table .* field larger"),
        (
            HEADER.encode() + b"walk,path,cut,caf\xe9,1,1\n",
            r"notes\.csv:2: expected a table .* not UTF-8 text",
        ),
    ],
)
def test_a_bad_table_names_its_line_and_changes_nothing(
    library: Library, tmp_path: Path, text: str | bytes, message: str
) -> None:
    before = annotations_of(library, "walk")
    path = tmp_path / "notes.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    with path.open("ab") as file:
        file.write(b"walk,path,cut,,7,7\n")
    with pytest.raises(FormatError, match=message):
        import_annotations(library, path)
    assert annotations_of(library, "walk") == before


def test_files_out_of_reach_are_named(library: Library, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"missing\.csv: cannot open it: No such file"):
        import_annotations(library, tmp_path / "missing.csv")
    with pytest.raises(RequestError, match=r"cuts\.csv: cannot write here: No such file"):
        export_annotations(library, tmp_path / "nowhere" / "cuts.csv")


def test_a_file_of_one_take_is_read_under_any_name_and_one_of_several_by_theirs(tmp_path: Path) -> None:
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    one.write_text(HEADER + "walk,path,cut,,1.0,1.0\n")
    two.write_text(HEADER + "walk,path,cut,,1.0,1.0\nrun,path,cut,,2.0,2.0\n")
    assert read_annotations(one, "walk") == read_annotations(one, "another") == (cut(1.0),)
    assert read_annotations(two, "run") == (cut(2.0),)
    with pytest.raises(FormatError, match="annotations of take 'another', found those of run, walk"):
        read_annotations(two, "another")
