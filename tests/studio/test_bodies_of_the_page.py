"""The page's bodies without a page: live poses, colours of joints and the shadow, run by Node."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinetograph
from bodies import blocks, person
from kinetograph import rotations as rot
from kinetograph.formats.gltf import encode
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion
from walkers import walk

CLIENT = Path(kinetograph.__file__).parent / "studio" / "client"

SCRIPT = """
import { readFileSync } from "node:fs";
const [client, folder, body] = process.argv.slice(2);
const { loadClip, loadLiveBody } = await import(`${client}/stage/body.js`);
const file = readFileSync(`${folder}/clip.glb`);
const buffer = file.buffer.slice(file.byteOffset, file.byteOffset + file.byteLength);
const given = JSON.parse(readFileSync(`${folder}/given.json`));
const run = new Function("loadClip", "loadLiveBody", "buffer", "given", `return (async () => {${body}})()`);
console.log(JSON.stringify(await run(loadClip, loadLiveBody, buffer, given)));
"""


def answer(folder: Path, glb: bytes, body: str, given: Any = None) -> Any:
    """What some lines of JavaScript return about a clip."""
    node = shutil.which("node")
    if node is None or not (CLIENT / "node_modules" / "three").is_dir():
        pytest.skip("Node or the page's packages are missing: npm ci in src/kinetograph/studio/client")
    (folder / "clip.glb").write_bytes(glb)
    (folder / "given.json").write_text(json.dumps(given))
    (folder / "script.mjs").write_text(SCRIPT)
    command = [node, str(folder / "script.mjs"), CLIENT.as_uri(), str(folder), body]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def random_pose(joints: int) -> Motion:
    rng = np.random.default_rng(3)
    return Motion(person(), rng.normal(size=(1, 3)), rot.exp(rng.normal(size=(1, joints, 3))), 30.0)


def test_a_live_pose_is_shown_as_it_is(tmp_path: Path) -> None:
    pose = random_pose(len(person()))
    numbers = [*pose.translation[0].tolist(), *pose.rotations[0].ravel().tolist()]
    still = Motion(person(), np.zeros((2, 3)), rot.identity(2, len(person())), 30.0)
    shown = answer(
        tmp_path,
        encode(still),
        """
        const body = await loadLiveBody(buffer);
        body.apply(Float32Array.from(given));
        body.object.updateMatrixWorld(true);
        const bones = Object.fromEntries(body.joints.map((name, i) => {
          const { elements } = body.figure.bones[i].matrixWorld;
          return [name, [elements[12], elements[13], elements[14]]];
        }));
        return { told: body.pose(), bones, root: body.root() };
        """,
        numbers,
    )
    expected = joint_positions(pose)[0]
    assert list(shown["told"]) == list(person().names)
    np.testing.assert_allclose(list(shown["told"].values()), expected, atol=1e-5)
    np.testing.assert_allclose(list(shown["bones"].values()), expected, atol=1e-5)
    np.testing.assert_allclose(shown["root"], pose.translation[0], atol=1e-6)


def test_asking_for_a_pose_leaves_what_is_shown(tmp_path: Path) -> None:
    shown = answer(
        tmp_path,
        encode(walk(2.0)),
        """
        const clip = await loadClip(buffer);
        clip.seek(0.5);
        const before = clip.figures[0].bones[0].position.toArray();
        clip.pose(1.7);
        return [before, clip.figures[0].bones[0].position.toArray(), clip.root(0.5)];
        """,
    )
    assert shown[0] == shown[1] == shown[2]


def test_joints_are_coloured_by_their_values(tmp_path: Path) -> None:
    cubes = blocks(person(), 0.1)
    character = replace(cubes, skin=replace(cubes.skin, palette=(("cubes", (0.5, 0.4, 0.3)),)))
    joint = 4
    values = np.zeros(len(person()))
    values[joint] = 1.0
    motion = Motion(person(), np.zeros((2, 3)), rot.identity(2, len(person())), 30.0)
    before, after, cleared, joints = answer(
        tmp_path,
        encode(motion, character),
        """
        const clip = await loadClip(buffer);
        const colours = () => Array.from(clip.figures[0].body.geometry.getAttribute("color").array);
        const before = colours();
        clip.setJointColours(Float32Array.from(given));
        const after = colours();
        clip.setJointColours(null);
        return [before, after, colours(), Array.from(clip.figures[0].character.skin.joints)];
        """,
        values.tolist(),
    )
    of = np.array(joints).reshape(-1, 4)[:, 0]
    shown = np.array(after).reshape(-1, 3)
    for part in (of == joint, of != joint):
        assert np.ptp(shown[part], axis=0).max() == 0
    assert np.abs(shown[of == joint][0] - shown[of != joint][0]).max() > 0.2
    assert cleared == before


def test_a_file_that_is_no_clip_is_refused(tmp_path: Path) -> None:
    said = answer(tmp_path, b"not a clip" * 10, "return loadClip(buffer).catch((error) => error.message);")
    assert said == "expected a GLB file"
