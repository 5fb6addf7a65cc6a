"""Soles on the floor, and feet under sensor control: ``python -m benchmarks quality``.

Characters: walks, getting up and golf of the recordings, or walks and getting up of the sample, on the human body and
on capsules. Sensing: golf and basketball held out one at a time; without recordings, the sample's walks.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph.character import Character, skin_heights
from kinetograph.errors import FetchError
from kinetograph.evaluation import contact_speed, fastest_low_toe
from kinetograph.formats import ReadOptions, capsule_character, load
from kinetograph.kinematics import role_positions
from kinetograph.library import Library
from kinetograph.methods.sensor import SYNTHESES, SensorControl
from kinetograph.motion import Motion, resample
from kinetograph.pipeline import read_take
from kinetograph.post import contact_mask, planted_feet, retarget, undersides
from kinetograph.samples import fetch, human
from kinetograph.segmentation import detect_contacts
from kinetograph.sensing import simulate
from kinetograph.synthesis import Synthesis

BODIES = (
    *("walks/15_01.bvh", "walks/15_03.bvh", "walks/humanoid3d_long_walk1.txt", "actions/35_17.bvh"),
    *("actions/140_01.bvh", "actions/111_06.bvh", "actions/humanoid3d_getup_facedown.txt"),
    *("sports/64_01_amass30.bvh", "salsa/Easy_01_leader.bvh"),
)
SAMPLES = ("0walk_forward", "turn_left0", "humanoid3d_getup_facedown", "humanoid3d_getup_faceup", "humanoid3d_run")
HELD_OUT = (
    ("*_amass30.bvh", ("64_01", "64_05", "06_14", "06_15", "86_14", "124_03", "124_07")),
    ("*_cmu60.bvh", ("006_14", "006_15")),
)
_WALKS = ("0walk_forward", "turn_left0", "turn_left1", "turn_right0", "turn_right1", "humanoid3d_walk")
_FRAMES = 1200


def main() -> None:
    characters()
    sensed()


def characters() -> None:
    """Heights of the undersides of characters over the floor: lowest and highest while planted, lowest of the body."""
    try:
        person = human()
    except FetchError as error:
        print(f"no sample character, capsules only: {error}")
        person = None
    print(
        "soles on the floor, cm       body        planted low    high   lowest point   by ankles: planted low    high"
    )
    for path in _recordings():
        motion = load(path).motion()
        for body in [person, capsule_character(motion.skeleton)]:
            if body is None:
                continue
            made, plain = retarget(motion, body).motion, retarget(motion, body.skeleton).motion
            low, high = _planted(motion, made, body)
            before = _planted(motion, plain, body)
            figures = f"{low:12.1f} {high:7.1f} {_lowest(made, body):14.1f} {before[0]:25.1f} {before[1]:7.1f}"
            print(f"   {path.stem[:24]:24s}  {body.name:10s} {figures}")


def _recordings() -> list[Path]:
    folder = data_folder()
    paths = [folder / name for name in BODIES] if folder else [fetch("deepmimic-clips") / f"{n}.txt" for n in SAMPLES]
    return [path for path in paths if path.exists()]


def _planted(recorded: Motion, made: Motion, body: Character) -> tuple[float, float]:
    """Centimetres: the least and the greatest height of a sole while the recorded foot is planted, 1 % left out."""
    soles = undersides(body).soles(made)
    masks = planted_feet(recorded, detect_contacts(recorded))
    heights = 100 * np.concatenate([np.zeros(0), *(soles[side][masks[side]] for side in soles)])
    return (float(np.quantile(heights, 0.005)), float(np.quantile(heights, 0.995))) if len(heights) else (0.0, 0.0)


def _lowest(motion: Motion, body: Character) -> float:
    """Centimetres: the height of the lowest point of the whole skin, of at most ``_FRAMES`` frames."""
    frames = np.unique(np.linspace(0, len(motion) - 1, _FRAMES).astype(int))
    few = Motion(motion.skeleton, motion.translation[frames], motion.rotations[frames], motion.fps)
    return 100 * float(skin_heights(few, body.skin, np.arange(len(body.skin.points))).min())


def sensed() -> None:
    """Feet of takes held out from sensor control: speed while planted, and of toes in the lowest 30 % of heights."""
    print("feet under sensor control, cm/s         planted   recorded   most   most of low toes   toe cm   recorded")
    with tempfile.TemporaryDirectory() as scratch:
        for i, (pattern, names) in enumerate(HELD_OUT if _sports() else (("", _WALKS[:2]),)):
            library = Library.create(Path(scratch) / str(i))
            for path in _files(pattern):
                library.add(read_take(path, ReadOptions())[0])
            for name in library.names():
                if name.startswith(names):
                    _sense(library, name)


def _sports() -> bool:
    folder = data_folder()
    return folder is not None and (folder / "sports").is_dir()


def _files(pattern: str) -> list[Path]:
    folder = data_folder()
    if pattern and folder:
        return sorted((folder / "sports").glob(pattern))
    return [fetch("deepmimic-clips") / f"{name}.txt" for name in _WALKS]


def _sense(library: Library, name: str) -> None:
    truth = resample(library.take(name).motion(), 60.0)
    recorded = detect_contacts(truth)
    for label, synthesis in SYNTHESES.items():
        model = SensorControl(synthesis=synthesis).fit(library, exclude=(name,))
        made = model.synthesize(simulate(truth, model.method.layout))
        slides = 100 * contact_speed(made.motion, made.annotations), 100 * contact_speed(truth, recorded)
        most, low = _fastest_planted(made), 100 * fastest_low_toe(made.motion)
        print(
            f"   {name[:18]:18s} {label:14s} {slides[0]:11.1f} {slides[1]:10.1f} {most:6.1f} {low:18.1f} "
            f"{_toe(made.motion):8.1f} {_toe(truth):10.1f}"
        )


def _fastest_planted(made: Synthesis) -> float:
    """Centimetres per second: the fastest that any point moves along the ground while the result says it is planted."""
    most = 0.0
    for role in {note.label for note in made.annotations if note.kind == "contact"}:
        mask = contact_mask(made.annotations, role, len(made.motion), made.motion.fps)
        places = role_positions(made.motion, (role,))[:, 0][:, [0, 2]]
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)[mask[1:] & mask[:-1]] * made.motion.fps
        most = max(most, 100 * float(steps.max(initial=0.0)))
    return most


def _toe(motion: Motion) -> float:
    """Centimetres: the height of the lower toe, in the lower quarter of frames."""
    return 100 * float(np.quantile(role_positions(motion, ("left_toe", "right_toe"))[..., 1].min(axis=1), 0.25))
