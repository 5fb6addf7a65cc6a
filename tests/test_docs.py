"""The docs say what is so: the reference lists every command, and the README's lines run."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def _builder():
    spec = importlib.util.spec_from_file_location("docs_build", ROOT / "docs" / "build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_command_reference_is_up_to_date():
    assert (ROOT / "docs" / "cli.md").read_text() == _builder().cli_reference(), "run: make docs"


def test_every_command_has_help_an_example_and_described_options():
    text = _builder().cli_reference()
    for section in text.split("\n## ")[1:]:
        name = section.splitlines()[0]
        assert re.search(r"^    kinetograph ", section, re.M), f"{name} has no example"
        assert "|  |" not in section, f"{name} has an option without help"


def test_links_in_the_docs_lead_somewhere():
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]:
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name} links to {target}"


@pytest.fixture(scope="module")
def after_the_demo(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Path:
    """A folder in which the demo has been run."""
    folder = tmp_path_factory.mktemp("demo")
    subprocess.run([sys.executable, "-m", "kinetograph", "demo"], cwd=folder, check=True, capture_output=True)
    return folder


def test_the_readme_runs(after_the_demo: Path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    assert blocks
    for number, block in enumerate(blocks):
        program = after_the_demo / f"readme_{number}.py"
        program.write_text(block)
        command = [sys.executable, str(program)]
        done = subprocess.run(command, cwd=after_the_demo, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert (after_the_demo / "out" / "mine.bvh").stat().st_size > 10_000


@pytest.mark.parametrize("example", sorted((ROOT / "examples").glob("*.py")), ids=lambda p: p.stem)
def test_examples_run(example: Path, after_the_demo: Path):
    command = [sys.executable, str(example)]
    done = subprocess.run(command, cwd=after_the_demo, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
