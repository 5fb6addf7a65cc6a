"""Every error is one line that says where, what was found and what to try."""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import kinetograph
from kinetograph import rotations as rot
from kinetograph.errors import (
    DataError,
    FetchError,
    FormatError,
    KinetographError,
    LibraryError,
    RequestError,
)
from kinetograph.motion import Motion, cut
from kinetograph.post import join
from kinetograph.skeleton import Landmark, Skeleton, with_roles
from kinetograph.take import Annotation, Take

_PACKAGE = Path(kinetograph.__file__).parent
_LINES = "two\nlines"


def _stick() -> Skeleton:
    return Skeleton(("root", _LINES), np.array([-1, 0]), np.zeros((2, 3)))


def _motion(frames: int = 2) -> Motion:
    return Motion(_stick(), np.zeros((frames, 3)), rot.identity(frames, 2), 30.0)


@pytest.mark.parametrize("kind", [DataError, RequestError, LibraryError, FetchError, FormatError])
def test_every_error_is_kinetographs_own(kind: type[Exception]) -> None:
    assert issubclass(kind, KinetographError)


@pytest.mark.parametrize("kind", [DataError, RequestError, FormatError])
def test_bad_values_are_value_errors_too(kind: type[Exception]) -> None:
    assert issubclass(kind, ValueError)


def test_a_format_error_says_where() -> None:
    error = FormatError("a/walk.bvh", "expected 96 values, found 95", line=7)
    assert (str(error), error.path, error.line) == (
        "a/walk.bvh:7: expected 96 values, found 95",
        Path("a/walk.bvh"),
        7,
    )
    assert str(FormatError(Path("walk.bvh"), "is empty")) == "walk.bvh: is empty"


@pytest.mark.parametrize(
    "provoke",
    [
        lambda: Skeleton((_LINES, _LINES), np.array([-1, 0]), np.zeros((2, 3))),
        lambda: Skeleton(("a",), np.array([-1]), np.zeros((1, 3)), roles={_LINES: Landmark(0)}),
        lambda: Skeleton(("a",), np.array([-1]), np.zeros((1, 3)), roles={"hips": Landmark(0, np.zeros((2, 3)))}),
        lambda: Skeleton(("a",), np.array([-1]), np.zeros((1, 3)), np.arange(-1, 2000), np.zeros((2001, 3))),
        lambda: _stick().landmark(_LINES),
        lambda: _stick().index("two_lines"),
        lambda: with_roles(_stick(), {_LINES: "root"}),
        lambda: Motion(_stick(), np.zeros((1, 3)), np.full((1, 2, 4), 2.0), 30.0),
        lambda: cut(_motion(), 3, 2),
        lambda: Take(_LINES, {}),
        lambda: Take("t", {"motion": _motion()}, (Annotation(_LINES, "cut", "", 0, 0),)),
        lambda: Take(_LINES, {"motion": _motion()}).motion(_LINES),
        lambda: rot.from_euler(np.zeros(3), _LINES),
        lambda: join([], 30.0, 1, _LINES),
    ],
)
def test_awkward_values_stay_on_one_line(provoke: Callable[[], object]) -> None:
    with pytest.raises(KinetographError) as caught:
        provoke()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) > 15


@pytest.mark.parametrize("path", sorted(_PACKAGE.rglob("*.py")), ids=lambda p: str(p.relative_to(_PACKAGE)))
def test_no_message_has_a_second_line(path: Path) -> None:
    errors = {"KinetographError", *(kind.__name__ for kind in KinetographError.__subclasses__())}
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in errors:
            texts = [c.value for c in ast.walk(node) if isinstance(c, ast.Constant) and isinstance(c.value, str)]
            assert not any("\n" in text for text in texts), f"{path}:{node.lineno}"
