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


def test_the_readme_runs(tmp_path: Path, clips_folder: Path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    assert blocks
    subprocess.run([sys.executable, "-m", "kinetograph", "demo"], cwd=tmp_path, check=True, capture_output=True)
    for number, block in enumerate(blocks):
        program = tmp_path / f"readme_{number}.py"
        program.write_text(block)
        done = subprocess.run([sys.executable, str(program)], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "mine.bvh").stat().st_size > 10_000


@pytest.mark.parametrize("example", sorted((ROOT / "examples").glob("*.py")), ids=lambda p: p.stem)
def test_examples_run(example: Path, tmp_path: Path, clips_folder: Path):
    subprocess.run([sys.executable, "-m", "kinetograph", "demo"], cwd=tmp_path, check=True, capture_output=True)
    done = subprocess.run([sys.executable, str(example)], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
