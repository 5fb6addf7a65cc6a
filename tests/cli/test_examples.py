"""Every example in the commands' help runs in the folder in which the demo was run."""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from command_line import answer
from typer.main import get_command

from kinetograph.cli import app
from kinetograph.errors import RequestError
from kinetograph.samples import fetching as samples
from kinetograph.studio.page import page_folder

DANCES = "needs a library of partner dances, of which the sample has none"
PERSON = "needs the sample 'character'"
SPORTS = "needs a library of sports"
DEVICE = "needs a device that sends"
SERVER = "serves a page until it is stopped; tested in tests/studio"
CORPUS = "needs a large library"

NOT_AFTER_THE_DEMO = {
    "studio": SERVER,
    "serve --stdio": "answers a program on its output; tested in tests/cli/test_serve.py",
    "studio out/walks.library out/clips.library --project out/studio/project.json": SERVER,
    "studio --request out/request.json": SERVER,
    "render requests -l walks -o made --to .bvh,.glb --jobs 4": "needs a folder of requests; tested in test_request.py",
    "perform leader.bvh -l dances --target follower -o follower.bvh": DANCES,
    "evaluate performance -l dances --target follower": DANCES,
    "evaluate performance -l big --only 02/02_01 --no-baselines": CORPUS,
    "evaluate performance -l big --jobs 4": CORPUS,
    "evaluate request -l corpus --walks walks --requests 20": CORPUS,
    "evaluate performance -l big --cluster tcp://HOST:8786": CORPUS,
    "library label dances --by partner": DANCES,
    "library add dances --take salsa_1 leader=a.bvh follower=b.bvh --units inch --up z": DANCES,
    "sense swing.csv -l golf --layout mine.toml -o swing.bvh": SPORTS,
    "sense swing.csv -l golf -o swing.bvh --synthesis optimisation --ahead 0 --choice mean": SPORTS,
    "live sense -l golf --layout mine.toml --from slimevr:// --to vmc://": DEVICE,
    "live sense -l golf --from phone://0.0.0.0 --to studio": DEVICE,
    "live perform -l dances --target follower --from mocopi:// --to vmc://": DEVICE,
    'evaluate sensor -l sports --group "golf=64_*" --group "karate=1[34]*" --jobs 2': SPORTS,
    'evaluate sensor -l sports --leave person --person "ann=64_*" --person "bob=124_*" -o out/sports': SPORTS,
    "evaluate sensor --against estimated.bvh recorded.bvh": "needs an estimate of somebody else's",
    "reproduce xie2009 -l sports -o xie2009 --serves data/c3d": SPORTS,
    "calibrate worn.csv -l golf --still 0:3 -o mine.toml": "needs readings that begin with standing still",
    'evaluate keyframe -l lafan1 --held-out "*subject5" --jobs 2': "needs the LAFAN1 recordings",
    "library tap out/clips.library humanoid3d_punch --speed 0.5": "needs a person at a terminal",
    "reproduce hsu2004 -o out/hsu2004 --quick": "takes a minute; tested in tests/evaluation",
}
"""Examples that are not run, with the reason."""

WITH_A_PERSON = {
    "convert out/walk.bvh out/person.glb --character human",
    "view out/walk.bvh -o out/person.gif --character human --seconds 1",
}
"""Examples that are run where the sample 'character' is on this machine."""

WITH_THE_PAGE = {"view out/walk.bvh -o out/walk.html"}
"""Examples that are run where the studio's page is built."""


def _commands(command: Any, name: str = "") -> Iterator[tuple[str, str]]:
    """Every command's name and help."""
    below = getattr(command, "commands", {})
    for sub in below:
        yield from _commands(below[sub], f"{name} {sub}".strip())
    if not below:
        yield name, command.help


EXAMPLES = {name: re.findall(r"^Example: kinetograph (.*)$", text, re.M) for name, text in _commands(get_command(app))}
"""The examples of each command, in order."""


def _is_built() -> bool:
    try:
        return bool(page_folder())
    except RequestError:
        return False


@pytest.fixture(scope="module")
def after_the_demo(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Path:
    """A folder in which the demo was run."""
    folder = tmp_path_factory.mktemp("demo")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        answer(*shlex.split(EXAMPLES["demo"][0]))
    return folder


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_run_after_the_demo(
    name: str, after_the_demo: Path, clips_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    person = samples.where("character")
    monkeypatch.setenv(samples.DATA_VARIABLE, ":".join(str(folder) for folder in (clips_folder, person) if folder))
    left_out = set(NOT_AFTER_THE_DEMO) | (set() if person else WITH_A_PERSON)
    left_out |= set() if _is_built() else WITH_THE_PAGE
    shutil.copytree(after_the_demo / "out", tmp_path / "out")
    monkeypatch.chdir(tmp_path)
    for example in EXAMPLES[name]:
        if example not in left_out:
            answer(*shlex.split(example))


def test_every_command_has_an_example_that_runs_after_the_demo() -> None:
    left_out = NOT_AFTER_THE_DEMO.keys() | WITH_A_PERSON | WITH_THE_PAGE
    without = [name for name, examples in EXAMPLES.items() if not set(examples) - left_out]
    assert sorted(without) == ["evaluate request", "reproduce hsu2004", "serve", "studio"]


def test_what_is_left_out_are_examples() -> None:
    examples = {example for group in EXAMPLES.values() for example in group}
    assert (NOT_AFTER_THE_DEMO.keys() | WITH_A_PERSON | WITH_THE_PAGE) - examples == set()
