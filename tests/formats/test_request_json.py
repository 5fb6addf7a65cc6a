"""The document of a request: what is read, what is refused in one line, and what is written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kinetograph.errors import FormatError
from kinetograph.formats import Request, read_request, write_request
from kinetograph.formats.request_json import MoveRow, OnPathRow, is_project


def test_a_request_is_what_was_written(tmp_path: Path) -> None:
    request = Request(
        path=((0.0, 0.0, 0.0), (1.0, 0.0, 1.0)),
        keys=(OnPathRow("take:wave@1", along=0.5, name="wave"), OnPathRow("pose.bvh@0", time=(0.2, 0.9))),
        moves=(MoveRow(0.0, 1.0, "run", weight=0.5),),
        mirror=True,
    )
    write_request(request, tmp_path / "request.json")
    assert read_request(tmp_path / "request.json") == request
    assert not is_project(tmp_path / "request.json")


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"paths": "path.csv"}, "unknown field `paths`"),
        ({"keys": [{"time": 4}]}, r"missing required field `pose` - at `\$.keys"),
        ({"moves": [{"start": "four", "stop": 7, "name": "run"}]}, r"Expected `float`, got `str` - at `\$.moves"),
        ({"moves": [{"start": 4, "stop": 7, "first": "both"}]}, "Invalid enum value 'both'"),
        ({"contacts": [{"part": "nose", "start": 4, "stop": 7}]}, "Invalid enum value 'nose'"),
    ],
)
def test_what_is_no_request_is_refused_with_the_place(tmp_path: Path, document: object, says: str) -> None:
    (tmp_path / "request.json").write_text(json.dumps(document))
    with pytest.raises(FormatError, match=says):
        read_request(tmp_path / "request.json")


def test_a_project_of_the_studio_is_told_from_a_request(tmp_path: Path) -> None:
    for text, project in (
        ('{"version": 1, "walk": {"path": []}}', True),
        ('{"keys": {"rows": []}}', True),
        ('{"keys": []}', False),
        ("{}", True),
    ):
        (tmp_path / "some.json").write_text(text)
        assert is_project(tmp_path / "some.json") is project, text
