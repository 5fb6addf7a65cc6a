"""Tapping: keys at known times through a pseudo-terminal, times from a file, and what is refused."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import termios
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from command_line import answer, run

import kinetograph as kg
from kinetograph.cli import keystrokes
from kinetograph.drawing.text import bones_over_time, draw_bones
from kinetograph.errors import FormatError, RequestError
from kinetograph.library.annotations_csv import read_times
from kinetograph.pipeline import cut_by_hand
from kinetograph.take import Take
from walkers import walk


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    """The two ends of a pseudo-terminal: a person's, and a program's."""
    ends = pty.openpty()
    yield ends
    for end in ends:
        os.close(end)


class Person:
    """Presses keys at times that are known: its clock goes on only while one waits for a key."""

    def __init__(self, terminal: int, keys: dict[float, bytes]) -> None:
        self.now = 100.0
        self._terminal = terminal
        self._keys = {self.now + time: key for time, key in keys.items()}

    def clock(self) -> float:
        return self.now

    def wait(self, file: int, seconds: float) -> bool:
        due = min((time for time in self._keys if time <= self.now + seconds), default=None)
        self.now = self.now + seconds if due is None else max(due, self.now)
        if due is None:
            return False
        os.write(self._terminal, self._keys.pop(due))
        return keystrokes.pressed(file, 10.0)


def _tapped(terminal: tuple[int, int], keys: dict[float, bytes], duration: float = 3.0) -> tuple[list[float], int]:
    person, drawn = Person(terminal[0], keys), []
    with keystrokes.single_keys(terminal[1]):
        times = keystrokes.taps(
            terminal[1], duration, lambda now, count: drawn.append(count), clock=person.clock, wait=person.wait
        )
    return times, len(drawn)


def test_keys_are_heard_when_they_are_pressed(terminal: tuple[int, int]) -> None:
    times, drawn = _tapped(terminal, {0.51: b" ", 1.02: b"j", 1.7: b" "})
    np.testing.assert_allclose(times, [0.51, 1.02, 1.7])
    assert drawn >= 3 * 15


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({0.5: b" ", 0.9: b" ", 1.2: b"\x7f", 1.5: b" "}, [0.5, 1.5]),  # the second is taken back
        ({0.5: b" ", 1.0: b" ", 1.3: b"q", 2.0: b" "}, [0.5, 1.0]),  # it ends early
        ({0.5: b" ", 0.52: b" ", 1.0: b"  "}, [0.5, 1.0]),  # a key that bounces
        ({0.5: b" ", 1.0: b"\x1b[A"}, [0.5]),  # an arrow is no tap
        ({0.2: b"\x7f", 0.5: b" ", 3.5: b" "}, [0.5]),  # nothing to take back; too late
    ],
)
def test_keys_that_mean_something(terminal: tuple[int, int], keys: dict[float, bytes], expected: list[float]) -> None:
    np.testing.assert_allclose(_tapped(terminal, keys)[0], expected)


def test_a_terminal_is_left_as_it_was_and_one_that_goes_away_is_an_error() -> None:
    person, program = pty.openpty()
    before = termios.tcgetattr(program)
    with keystrokes.single_keys(program):
        assert termios.tcgetattr(program) != before
    assert termios.tcgetattr(program) == before
    os.close(person)
    with pytest.raises(RequestError, match="the terminal went away while a take was tapped; nothing was written"):
        keystrokes.taps(program, 1.0, lambda now, count: None)
    os.close(program)


# ---- the command ----


@pytest.fixture
def library(tmp_path: Path) -> kg.Library:
    made = kg.Library.create(tmp_path / "library")
    made.add(Take("walk", {"body": walk(3.0)}))
    return made


def _cuts(library: kg.Library) -> list[float]:
    return [note.start for note in library.take("walk").annotated("body", "cut")]


def _tapping(library: kg.Library, keys: int) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "kinetograph", "library", "tap", str(library.path), "walk", "--countdown", "0"]
    options = ["--speed", "0.1", "--latency", "0.01", "--json"]
    ignored = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs pass that on
    try:
        return subprocess.Popen([*command, *options], stdin=keys, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    finally:
        signal.signal(signal.SIGINT, ignored)


def _read_until(tapping: subprocess.Popen[bytes], text: bytes) -> bytes:
    assert tapping.stderr is not None
    shown = b""
    while text not in shown and (more := os.read(tapping.stderr.fileno(), 65536)):
        shown += more
    return shown


def test_taps_become_cuts(library: kg.Library, terminal: tuple[int, int]) -> None:
    os.write(terminal[0], b" ")  # before it begins: thrown away
    with _tapping(library, terminal[1]) as tapping:
        shown = b""
        for count in range(3):
            shown += _read_until(tapping, b" %d taps" % count)
            shown += _read_until(tapping, b" %d taps" % count)
            os.write(terminal[0], b" ")
        shown += _read_until(tapping, b"3 taps")
        os.write(terminal[0], b"q")
        answer, rest = tapping.communicate()
    assert tapping.returncode == 0, rest
    assert b'"cuts": 3' in answer
    assert any("\u2801" <= letter <= "\u28ff" for letter in shown.decode(errors="ignore"))  # a figure was drawn
    found = _cuts(library)
    assert 0.0 < found[0] < found[1] < found[2] <= 3.0


def test_stopping_writes_nothing(library: kg.Library, terminal: tuple[int, int]) -> None:
    with _tapping(library, terminal[1]) as tapping:
        _read_until(tapping, b" 0 taps")
        _read_until(tapping, b" 0 taps")  # by now keys are heard
        os.write(terminal[0], b" ")
        _read_until(tapping, b"1 taps")
        tapping.send_signal(signal.SIGINT)
        answer, shown = tapping.communicate()
    assert (tapping.returncode, answer) == (1, b"")
    assert shown.decode().splitlines()[-1] == "kinetograph: stopped by Ctrl-C; nothing was written"
    assert _cuts(library) == []


def test_without_a_terminal_times_come_from_a_file(library: kg.Library, tmp_path: Path) -> None:
    done = run("library", "tap", library.path, "walk")
    assert done.returncode == 1
    assert "tapping needs a terminal to press keys in; give the times in a file instead (--from CSV)" in done.stderr
    times = tmp_path / "beats.csv"
    times.write_text("seconds\n0.5\n1.0\n1.5\n")
    line = ("library", "tap", library.path, "walk", "--from", times)
    answer(*line)
    assert _cuts(library) == [0.5, 1.0, 1.5]
    times.write_text("0.7\n1.2\n")
    with pytest.raises(RequestError, match="take 'walk' has 3 cuts on 'body'; keep a copy"):
        answer(*line)
    answer(*line, "--force")
    assert _cuts(library) == [0.7, 1.2]


def test_cuts_that_make_no_segments(library: kg.Library) -> None:
    take = library.take("walk")
    with pytest.raises(RequestError, match="segments need 2 cuts or more, found 1; nothing was written"):
        cut_by_hand(library, take, ["body"], [1.0])
    with pytest.raises(RequestError, match=r"take 'walk' lasts 3\.00 s, found a cut at 7 s"):
        cut_by_hand(library, take, ["body"], [1.0, 7.0])
    assert _cuts(library) == []


# ---- files of times ----


def test_times_are_read_from_what_editors_export(tmp_path: Path) -> None:
    path = tmp_path / "beats.csv"
    for text in ("0.5\n1.25\n", "t\n0.5\n1.25\n", "# tapped\nstart\tlabel\n0.5\t1\n\n1.25\t2\n", "0.5,1\r\n1.25,2"):
        path.write_text(text)
        assert read_times(path) == (0.5, 1.25)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("0.5\nhalf\n", r"beats\.csv:2: expected seconds, 0 or more, in the first column, found 'half'"),
        ("0.5\nnan\n", r"beats\.csv:2: .* found 'nan'"),
        ("-1\n", r"beats\.csv:1: .* found '-1'"),
        ("seconds\n", "expected seconds, one per line, found none"),
    ],
)
def test_times_that_are_none(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "beats.csv"
    path.write_text(text)
    with pytest.raises(FormatError, match=says):
        read_times(path)


# ---- figures ----


def test_a_figure_stands_on_the_last_line_and_stays_in_the_middle() -> None:
    motion = walk(2.0)
    bones = bones_over_time([motion], 15.0)
    assert bones.shape == (31, len(motion.skeleton) - 1, 2, 3)
    for frame in (0, 30):
        lines = draw_bones(bones[frame])
        assert {len(line) for line in lines} == {48}
        assert set(lines[0]) == {"\u2800"}  # it is not as tall as that
        assert set(lines[-1]) != {"\u2800"}
        columns = [i for line in lines for i, letter in enumerate(line) if letter != "\u2800"]
        assert min(columns) > 12
        assert max(columns) < 36
