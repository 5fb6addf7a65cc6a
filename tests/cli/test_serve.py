"""The command serve: nothing but answers on its output, whatever happens inside."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import invoke

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.service import PROTOCOL


def test_it_asks_where_requests_come_from() -> None:
    assert isinstance(error := invoke("serve").exception, RequestError)
    assert "kinetograph serve --stdio" in str(error)


def test_every_line_of_its_output_is_an_answer(tmp_path: Path) -> None:
    lines = [
        json.dumps({"id": 1, "method": "hello", "params": {"protocol": PROTOCOL}}),
        "rubbish",
        "",
        json.dumps({"id": 2, "method": "look", "params": {"library": str(tmp_path / "Bücher 腕")}}),
    ]
    command = [sys.executable, "-m", "kinetograph", "serve", "--stdio"]
    done = subprocess.run(command, input="\n".join(lines).encode(), capture_output=True, check=False)
    answers = [json.loads(line) for line in done.stdout.decode().splitlines()]
    assert done.returncode == 0, done.stderr
    assert done.stderr == b""
    assert [answer["id"] for answer in answers] == [1, None, 2]
    assert answers[0]["result"]["version"] == kg.__version__
    assert "Bücher 腕: not a library" in answers[2]["error"]["message"]


@pytest.mark.parametrize("where", ["stdin", "stdout"])
def test_it_ends_with_its_client(where: str) -> None:
    command = [sys.executable, "-m", "kinetograph", "serve", "--stdio"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        hello = json.dumps({"id": 1, "method": "hello", "params": {"protocol": PROTOCOL}}).encode() + b"\n"
        process.stdin.write(hello)
        process.stdin.flush()
        process.stdout.readline()
        if where == "stdout":
            process.stdout.close()
            process.stdin.write(hello)
        process.stdin.close()
        assert process.wait(20) == 0 if where == "stdin" else process.wait(20) is not None
