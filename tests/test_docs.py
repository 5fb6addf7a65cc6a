"""The docs say what is so: every command is documented, and the README, the tutorial and the examples run.

``make docs`` builds the site and checks every link between its pages; here is what can be seen without it.
"""

from __future__ import annotations

import importlib.util
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from PIL import Image

from kinetograph.cli import main

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
GENERATED = ("api/", "gallery/", "cli")
"""Pages that the site's build makes."""


def _extension(name: str) -> ModuleType:
    """A module that the site is built with."""
    spec = importlib.util.spec_from_file_location(f"docs_{name}", DOCS / "_ext" / f"{name}.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


COMMANDS = _extension("commands")
EVERY_COMMAND = dict(COMMANDS.every_command())


@pytest.mark.parametrize("name", EVERY_COMMAND)
def test_a_command_has_help_an_example_and_described_options(name: str):
    command = EVERY_COMMAND[name]
    assert COMMANDS.text_of(command), f"{name} has no help"
    assert COMMANDS.examples_of(command), f"{name} has no example"
    undescribed = [COMMANDS.label(p) for p in COMMANDS.options_of(command) if not COMMANDS.description(p).strip()]
    assert not undescribed, f"{name} has options without help"


@pytest.mark.parametrize("name", EVERY_COMMAND)
def test_an_example_uses_options_that_there_are(name: str):
    options = {o for p in COMMANDS.options_of(EVERY_COMMAND[name]) for o in (*p.opts, *p.secondary_opts)}
    for example in COMMANDS.examples_of(EVERY_COMMAND[name]):
        assert example.startswith(f"{name} ") or example == name
        used = {word.partition("=")[0] for word in shlex.split(example) if re.match(r"--?[a-z]", word)}
        assert used <= options, f"{example}: no option {', '.join(used - options)}"


def test_the_command_reference_has_every_command():
    page = COMMANDS.reference()
    assert [line[3:] for line in page.splitlines() if line.startswith("## ")] == list(EVERY_COMMAND)


@pytest.mark.parametrize("page", [*ROOT.glob("*.md"), *DOCS.rglob("*.md")], ids=lambda p: str(p.relative_to(ROOT)))
def test_links_between_pages_lead_somewhere(page: Path):
    text = page.read_text()
    links = re.findall(r"\]\(([^)#\s]+)\)", text)
    pages = re.findall(r"\{doc\}`(?:[^`<]*<)?([^`>]+)>?`", text)
    for target in [*links, *(f"{name}.md" for name in pages if not name.lstrip("/").startswith(GENERATED))]:
        if "://" not in target:
            found = DOCS / target[1:] if target.startswith("/") else page.parent / target
            assert found.exists(), f"{page.name} links to {target}"


def test_the_readmes_picture_moves_and_is_small():
    path = DOCS / "images" / "walk.gif"
    assert path.stat().st_size < 1.5e6
    with Image.open(path) as picture:
        assert picture.n_frames > 100


@pytest.fixture(scope="module")
def after_the_demo(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Path:
    """A folder in which the demo has been run."""
    folder = tmp_path_factory.mktemp("demo")
    subprocess.run([sys.executable, "-m", "kinetograph", "demo"], cwd=folder, check=True, capture_output=True)
    return folder


@pytest.fixture
def there(after_the_demo: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same, entered; pictures are drawn without a screen."""
    monkeypatch.chdir(after_the_demo)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.delenv("KINETOGRAPH_EXAMPLES", raising=False)
    return after_the_demo


def test_the_readme_runs(there: Path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    assert blocks
    for number, block in enumerate(blocks):
        program = there / f"readme_{number}.py"
        program.write_text(block)
        runpy.run_path(str(program), run_name="__main__")
    assert (there / "out" / "mine.bvh").stat().st_size > 10_000


def test_the_tutorial_runs(there: Path, clips_folder: Path, monkeypatch: pytest.MonkeyPatch):
    text = (DOCS / "tutorial.md").read_text()
    (keys,) = re.findall(r"```json\n(.*?)```", text, re.S)
    (there / "keys.json").write_text(keys)
    for language, block in re.findall(r"```(python|console)\n(.*?)```", text, re.S):
        if language == "python":
            exec(compile(block, "tutorial.md", "exec"), {})
            continue
        for line in block.replace("$CLIPS", str(clips_folder)).replace("\\\n", "").splitlines():
            command = shlex.split(line.removeprefix("$ "))
            if command[0] == "kinetograph":
                monkeypatch.setattr(sys, "argv", command)
                with pytest.raises(SystemExit) as ended:
                    main()
                assert ended.value.code in (0, None), line
    for name in ("quarter.bvh", "quarter.png", "quarter.fbx", "rise5.png", "keys.bvh", "sensed.png"):
        assert (there / "out" / name).stat().st_size > 5_000


@pytest.mark.parametrize("example", sorted((ROOT / "examples").glob("plot_*.py")), ids=lambda p: p.stem)
def test_examples_run(example: Path, there: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(example.parent))
    before = set((there / "out").glob("*.png"))
    runpy.run_path(str(example), run_name="__main__")
    assert set((there / "out").glob("*.png")) > before, "an example draws a picture"
