"""Writes motions in every format and compares the joints that other programs read from them.

    make check-clients        or: python tests/clients/check.py [--keep FOLDER] [--blender PYTHON]

Needs node with the packages of package.json, Chromium, and a Python that has bpy 5.0.1 (its own environment: it pins an
older numpy). What is missing is skipped, with a reason. A row fails where joints are more than 1 mm from ours, or rate
or duration differ. Recordings in a folder that ``KINETOGRAPH_DATA`` names are used as well.
"""

from __future__ import annotations

import argparse
import dataclasses as dc
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import kinetograph as kg
from kinetograph.formats import WriteOptions, read, save
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion, cut
from kinetograph.post import retarget
from kinetograph.samples import data_folders, fetch, human
from kinetograph.take import Take

HERE = Path(__file__).resolve().parent
WITHIN = 1e-3  # metres
FORMATS = ("bvh", "glb", "fbx", "usdc")
Entry = dict[str, Any]


def main() -> int:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--keep", type=Path, help="folder for what is written, and browser.png")
    arguments.add_argument("--blender", default=os.environ.get("KINETOGRAPH_BPY", ""), help="a Python that has bpy")
    arguments.add_argument("--chromium", default=shutil.which("chromium") or "", help="a Chromium to draw with")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        reference = write_all(folder)
        failed = validator([name for name in reference if name.endswith(".glb")])
        failed |= three({n: e for n, e in reference.items() if n.rpartition(".")[2] in ("bvh", "glb", "fbx")}, folder)
        failed |= browser(reference, folder, given.chromium)
        failed |= blender(reference, folder, given.blender)
    return int(failed)


# ---- what is written ----


def subjects() -> dict[str, tuple[Take, WriteOptions]]:
    """A walk, a pair, a human and awkward names; from recordings where there are any, else from the sample."""
    data = next((folder for folder in data_folders() if (folder / "walks").is_dir()), None)
    clips = fetch("deepmimic-clips")
    walk = kg.load(clips / "humanoid3d_walk.txt").motion()
    leader = follower = kg.load(clips / "humanoid3d_dance_a.txt").motion()
    if data is not None:
        walk = cut(kg.load(sorted((data / "walks").glob("15_*.bvh"))[0]).motion(), 0, 900)
        pair = (kg.load(data / "salsa" / f"Easy_01_{who}.bvh").motion() for who in ("leader", "follower"))
        leader, follower = (cut(motion, 0, 1200) for motion in pair)
    out = {
        "walk": (Take("walk", {"motion": walk}), WriteOptions()),
        "pair": (Take("pair", {"leader": leader, "follower": follower}), WriteOptions()),
    }
    awkward = ["Hüfte links", "Arm:L", "a.b", "腕", "with  two spaces", "slash/name"]
    names = tuple(awkward[i] if i < len(awkward) else name for i, name in enumerate(walk.skeleton.names))
    out["names"] = (
        Take("names", {"motion": dc.replace(walk, skeleton=dc.replace(walk.skeleton, names=names))}),
        WriteOptions(),
    )
    body = human()
    worn = retarget(walk, body.skeleton).motion
    out["human"] = (Take("human", {"motion": worn}), WriteOptions(character=body))
    return out


def write_all(folder: Path) -> dict[str, Entry]:
    """Write every subject in every format; where each joint is, at ten frames."""
    reference: dict[str, Entry] = {}
    for subject, (take, options) in subjects().items():
        for suffix in FORMATS:
            path = folder / f"{subject}.{suffix}"
            try:
                save(take, path, options=options)
            except kg.RequestError as error:
                print(f"skipped {path.name}: {error}")
                continue
            reference[str(path)] = entry_of(take)
    for data in data_folders():
        fbx = data / "fbx" / "135_01.fbx"  # a file of another program
        if fbx.is_file():
            # its keys begin after 84 frames; Blender fills the time before them differently
            reference[str(fbx)] = entry_of(read(fbx).take, first=90)
    return reference


def entry_of(take: Take, first: int = 0) -> Entry:
    positions = {}
    for track, motion in take.tracks.items():
        assert isinstance(motion, Motion)
        frames = np.unique(np.linspace(first, len(motion) - 1, 10).round().astype(int))
        places = joint_positions(motion)[frames]
        for joint, name in enumerate(motion.skeleton.names):
            positions[f"{track}/{name}"] = places[:, joint].tolist()
    return {
        "fps": motion.fps,
        "duration": motion.duration,
        "times": (frames / motion.fps).tolist(),
        "positions": positions,
        "tracks": list(take.tracks),
    }


# ---- the clients ----


def validator(files: list[str]) -> bool:
    ran = node("validate_glb.mjs", *files)
    if ran is None:
        return False
    for line in ran.stdout.splitlines():
        report = json.loads(line)
        print(
            f"gltf-validator {Path(report['file']).name}:",
            f"{report['numErrors']} errors, {report['numWarnings']} warnings",
        )
    return ran.returncode != 0


def three(reference: dict[str, Entry], folder: Path) -> bool:
    # its BVH loader reads one root only, its FBX loader one layer of an animation only
    reference = {n: e for n, e in reference.items() if not (n.endswith(".bvh") and len(e["tracks"]) > 1)}
    # and it binds no curve to a BVH joint with a colon or a slash in its name
    reference = {n: e for n, e in reference.items() if Path(n).parent == folder and not n.endswith("names.bvh")}
    (folder / "reference.json").write_text(json.dumps(reference))
    ran = node("read_with_three.mjs", str(folder / "reference.json"), str(folder / "three.json"))
    if ran is None:
        return False
    return ran.returncode != 0 or compare("three.js", reference, json.loads((folder / "three.json").read_text()))


def browser(reference: dict[str, Entry], folder: Path, chromium: str) -> bool:
    """three.js in a browser: the same positions, and a picture of a person who walks."""
    if not chromium:
        print(
            "skipped the browser: no Chromium; install it (on Debian: apt-get install chromium) or name it: --chromium"
        )
        return False
    if not (HERE / "node_modules" / "playwright-core").is_dir():
        print(f"skipped the browser: no playwright-core: npm --prefix {HERE.name} ci")
        return False
    wanted = [name for name in reference if Path(name).name in ("human.glb", "human.fbx", "walk.glb", "walk.bvh")]
    shown = {name: reference[name] | {"shown": [1.0, 1.25, 1.5, 1.75]} for name in sorted(wanted)}
    (folder / "reference.json").write_text(json.dumps(shown))
    paths = [folder / "reference.json", folder / "browser.json", folder / "browser.png"]
    ran = node("see_with_three.mjs", *map(str, paths), chromium)
    if ran is None or ran.returncode:
        return ran is not None
    drawn = json.loads((folder / "browser.json").read_text())
    failed = compare("browser", shown, drawn)
    for name, seen in drawn.items():
        # a figure covers a twentieth of its picture or so, and never all of it
        good = all(0.02 < share < 0.5 for share in seen["drawn"])
        failed |= not good
        shares = ", ".join(f"{100 * share:.1f} %" for share in seen["drawn"])
        print(f"browser   {Path(name).name:12} {'ok  ' if good else 'FAIL'} a figure covers {shares} of its pictures")
    return failed


def node(script: str, *arguments: str) -> subprocess.CompletedProcess[str] | None:
    if shutil.which("node") is None or not (HERE / "node_modules").is_dir():
        print(f"skipped {script}: no node, or no packages: npm --prefix {HERE.name} ci")
        return None
    ran = subprocess.run(["node", str(HERE / script), *arguments], capture_output=True, text=True, check=False)
    sys.stderr.write(ran.stderr)
    return ran


def blender(reference: dict[str, Entry], folder: Path, python: str) -> bool:
    if not python:
        print("skipped Blender: name a Python that has bpy 5.0.1 with --blender or KINETOGRAPH_BPY")
        return False
    (folder / "reference.json").write_text(json.dumps(reference))
    script = [str(HERE / "read_with_blender.py"), str(folder / "reference.json"), str(folder / "blender.json")]
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    ran = subprocess.run([python, *script], capture_output=True, text=True, check=False, env=environment)
    if ran.returncode:
        sys.stderr.write(ran.stdout[-2000:] + ran.stderr[-2000:])
        return True
    return compare("Blender", reference, json.loads((folder / "blender.json").read_text()))


def compare(client: str, reference: dict[str, Entry], theirs: dict[str, Entry]) -> bool:
    """Print one row per file; whether any is off."""
    failed = False
    for name, entry in reference.items():
        seen = theirs[name]["positions"]
        worst, missing = 0.0, 0
        for key, places in entry["positions"].items():
            match = [seen[label] for label in candidates(key, entry["tracks"]) if label in seen]
            missing += not match
            worst = max(worst, float(np.abs(np.array(places) - np.array(match[0])).max())) if match else worst
        late = abs(theirs[name]["duration"] - entry["duration"])
        rate = abs(theirs[name].get("fps", entry["fps"]) / entry["fps"] - 1)
        # one program has whole frames per second only: its rate is off by 1 in 1000 where ours is 119.88
        good = worst < WITHIN and not missing and late < 1.01 / entry["fps"] and rate < 1.1e-3
        failed |= not good
        count = len(entry["positions"])
        print(
            f"{client:9} {Path(name).name:12} {'ok  ' if good else 'FAIL'} {count - missing}/{count} joints, "
            f"worst {1000 * worst:.4f} mm, {theirs[name].get('fps', entry['fps']):.2f} fps, "
            f"duration off by {1000 * late:.2f} ms"
        )
    return failed


def candidates(key: str, tracks: list[str]) -> list[str]:
    """What a client may call a joint: with and without its character, and with numbers for names used twice."""
    track, _, joint = key.partition("/")
    number = tracks.index(track)
    again = [f"{joint}_{number + 1}", f"{joint}.{number:03d}"] if number else [joint]
    plain = [
        "_".join(joint.split()),  # Blender's BVH
        re.sub(r"\s", "_", re.sub(r"[\[\].:/]", "", joint)),  # three.js's FBX
        re.sub(rb"[^A-Za-z0-9_]", b"_", joint.encode()).decode(),  # USD
        joint,
    ]
    both = [*again, *plain]
    return [
        key,
        *(f"{track}/{name}" for name in both),
        *again,
        *(name for name in plain + [f"/{n}" for n in plain] if not number),
    ]


if __name__ == "__main__":
    sys.exit(main())
