"""Checks the Blender extension in Blender itself, a process for each subject: python tests/clients/extension.py.

    make check-clients        or: python tests/clients/extension.py --blender PYTHON [--keep FOLDER] [SUBJECT ...]

Needs a Python that has bpy, 4.2 to 5.0.1. Walks are those of the folder that ``KINETOGRAPH_DATA`` names where there
is one, and else of the sample.
"""

from __future__ import annotations

import argparse
import os
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

from kinetograph.errors import KinetographError
from kinetograph.formats import WriteOptions, load, save
from kinetograph.library import Library
from kinetograph.motion import cut
from kinetograph.pipeline import find_recordings, ingest, segment_library
from kinetograph.post import retarget
from kinetograph.samples import data_folders, fetch, human
from kinetograph.take import Take

HERE = Path(__file__).resolve().parent
EXTENSION = HERE.parents[1] / "blender"
SUBJECTS = ("faults", "curves", "along", "panel", "rigs", "keys", "partners", "live", "picture")


def main() -> int:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--blender", default=os.environ.get("KINETOGRAPH_BPY", ""), help="a Python that has bpy")
    arguments.add_argument("--keep", type=Path, help="folder for libraries and pictures")
    arguments.add_argument("subject", nargs="*", help=", ".join(SUBJECTS))
    given = arguments.parse_args()
    if (
        not given.blender
        or subprocess.run([given.blender, "-c", "import bpy"], check=False, capture_output=True).returncode
    ):
        print("skipped the Blender extension: no Python with bpy; name one with --blender")
        return 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = (given.keep or Path(scratch)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        prepare(folder)
        built = subprocess.run(
            [sys.executable, str(EXTENSION / "build.py"), str(folder)], check=True, capture_output=True, text=True
        )
        return max(run(given.blender, subject, built.stdout.strip(), folder) for subject in given.subject or SUBJECTS)


def run(python: str, subject: str, archive: str, folder: Path) -> int:
    """One subject in a process of its own, whose rows are printed; its status."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    environment |= {"BLENDER_USER_RESOURCES": str(folder / "user"), "PATH": f"{folder / 'bin'}:{environment['PATH']}"}
    script = HERE / "blender" / f"{subject}.py"
    ran = subprocess.run(
        [python, str(script), archive, str(folder)], check=False, capture_output=True, text=True, env=environment
    )
    rows = [line for line in ran.stdout.splitlines() if line.startswith(("Blender extension", "skipped"))]
    print("\n".join(rows), flush=True)
    if ran.returncode and not any("FAIL" in line for line in rows):
        sys.stderr.write(ran.stdout[-1500:] + ran.stderr[-3000:])
    return int(ran.returncode != 0)


def prepare(folder: Path) -> None:
    """The libraries and the person that the subjects use, and a ``kinetograph`` on the PATH that is this one."""
    program = folder / "bin" / "kinetograph"
    program.parent.mkdir(exist_ok=True)
    search = os.environ.get("PYTHONPATH", "")
    program.write_text(f'#!/bin/sh\nPYTHONPATH="{search}" exec "{sys.executable}" -m kinetograph "$@"\n')
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    data = next((path for path in data_folders() if (path / "walks").is_dir()), None)
    if data is None:
        (folder / "sample").touch()
    if not (folder / "walks").exists():
        library = Library.create(folder / "walks")
        ingest(library, find_recordings(walks(data)).recordings)
        segment_library(library, "footplants")
    if data is not None and not (folder / "dances").exists():
        dances(folder / "dances", data / "salsa")
    if not (folder / "person.glb").exists():
        person(folder / "person.glb")


def walks(data: Path | None) -> list[Path]:
    if data is not None:
        return sorted((data / "walks").glob("15_*.bvh"))
    clips = fetch("deepmimic-clips")
    names = ("humanoid3d_walk", "0walk_forward", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
    return [clips / f"{name}.txt" for name in names]


def dances(where: Path, salsa: Path) -> None:
    from kinetograph.formats import ReadOptions, read

    library = Library.create(where)
    for name in ("Easy_01", "Easy_02", "Easy_03", "Medium_01"):
        if not (salsa / f"{name}_leader.bvh").is_file():
            continue
        options = ReadOptions(units="inch", up="z")
        tracks = {who: read(salsa / f"{name}_{who}.bvh", options).take.motion() for who in ("leader", "follower")}
        library.add(Take(name, tracks))
    segment_library(library, "beats")


def person(where: Path) -> None:
    try:
        body = human()
    except KinetographError:
        return
    walk = load(fetch("deepmimic-clips") / "humanoid3d_walk.txt").motion()
    save(
        Take("person", {"motion": retarget(cut(walk, 0, 3), body).motion}), where, options=WriteOptions(character=body)
    )


if __name__ == "__main__":
    sys.exit(main())
