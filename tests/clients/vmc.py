"""Frames sent as VMC to a receiver in Blender that is not ours, and where its bones end up.

    python tests/clients/vmc.py --blender PYTHON_WITH_BPY --receiver FOLDER_OF_VMC4B

The receiver is VMC4B, an add-on under the GPL, which whoever runs this fetches. It is given an armature in a T pose and
our datagrams; a row fails where a bone is more than 1 mm from ours.
"""

from __future__ import annotations

import argparse
import base64
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.kinematics import forward
from kinetograph.live.sinks.humanoid import BONES, Humanoid
from kinetograph.live.sinks.vmc import datagrams
from kinetograph.motion import Motion, cut
from kinetograph.samples import fetch

HERE = Path(__file__).resolve().parent
WITHIN = 1e-3  # metres


def main() -> int:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--blender", required=True, help="a Python that has bpy")
    arguments.add_argument("--receiver", required=True, type=Path, help="a checkout of VMC4B")
    given = arguments.parse_args()
    failed = False
    for name in ("walk", "spinkick", "cartwheel"):
        motion = kg.load(fetch("deepmimic-clips") / f"humanoid3d_{name}.txt").motion()
        frames = [cut(motion, i, i + 1) for i in range(0, len(motion), max(len(motion) // 8, 1))]
        failed |= not _same(name, frames, given.blender, given.receiver)
    return int(failed)


def _same(name: str, frames: list[Motion], blender: str, receiver: Path) -> bool:
    body = Humanoid(frames[0].skeleton)
    expected = [forward(frame)[0][0, body.joints] for frame in frames]
    work = {
        "bones": list(body.bones),
        "parents": list(body.parents),
        "rest": _t_pose(body).tolist(),
        "frames": [[base64.b64encode(d).decode() for d in datagrams(body, f, i / 60)] for i, f in enumerate(frames)],
    }
    with tempfile.TemporaryDirectory() as scratch:
        todo, done = Path(scratch) / "todo.json", Path(scratch) / "done.json"
        todo.write_text(json.dumps(work))
        run = subprocess.run(
            [blender, str(HERE / "receive_with_blender.py"), str(receiver), str(todo), str(done)],
            check=False,
            capture_output=True,
            text=True,
        )
        if run.returncode:
            print(f"  {name:12s} failed: {run.stderr.strip().splitlines()[-1:]}")
            return False
        found = np.array(json.loads(done.read_text()))
    off = np.linalg.norm(found - np.array(expected), axis=-1)
    print(f"  {name:12s} {len(frames)} frames, {len(body.bones)} bones: at most {1000 * off.max():.3f} mm apart")
    return bool(off.max() < WITHIN)


def _t_pose(body: Humanoid) -> np.ndarray[Any, Any]:
    """Where the bones are, (B, 3), when the skeleton stands in its T pose, which has no rotations."""
    skeleton = body.skeleton
    still = Motion(skeleton, np.array([[0.0, 1.0, 0.0]]), rot.identity(1, len(skeleton)), 60.0)
    _, turned = body.pose(still)  # relative to the T pose
    world = {}
    rotations = still.rotations.copy()
    for bone, parent in enumerate(body.parents):
        world[bone] = turned[0, bone] if parent < 0 else rot.multiply(world[parent], turned[0, bone])
    whole = {body.joints[bone]: rot.conjugate(q) for bone, q in world.items()}  # rest to T pose, in the world
    placed: list[Any] = []
    for joint, parent in enumerate(skeleton.parents.tolist()):
        above = rot.identity() if parent < 0 else placed[parent]
        placed.append(whole.get(joint, above))
        rotations[0, joint] = rot.multiply(rot.conjugate(above), placed[joint])
    standing = Motion(skeleton, still.translation, rotations, 60.0)
    assert np.abs(body.pose(standing)[1][0, :, 0]).min() > 1 - 1e-9, [BONES[b] for b in body.bones]
    return forward(standing)[0][0, body.joints]


if __name__ == "__main__":
    sys.exit(main())
