"""The announcement that the search is compiled: once for an installation, and only after it was."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinetograph.cli.compilation import compilation_announced, compiled_mark

SAYS = "compiling the search for this processor, once (a few seconds)\n"


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda name: str(tmp_path / name))
    return tmp_path


def _search() -> None:
    with compilation_announced():
        pass


def test_it_is_announced_once(cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _search()
    assert capsys.readouterr().err == SAYS
    assert compiled_mark().is_relative_to(cache)
    _search()
    assert capsys.readouterr().err == ""


def test_a_search_that_failed_is_announced_again(cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="no path"), compilation_announced():
        raise ValueError("no path")
    _search()
    assert capsys.readouterr().err == 2 * SAYS


def test_another_version_is_compiled_anew(
    cache: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    _search()
    monkeypatch.setattr("kinetograph.__version__", "99")
    _search()
    assert capsys.readouterr().err == 2 * SAYS


def test_a_cache_that_cannot_be_written_is_no_error(cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (cache / "kinetograph").write_text("in the way")
    _search()
    assert capsys.readouterr().err == SAYS
