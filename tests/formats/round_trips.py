"""Motions of every kind that a file may hold, made here, and what of them must come back from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.formats import Loaded, ReadOptions, WriteOptions, read, save
from kinetograph.kinematics import end_positions, joint_positions
from kinetograph.motion import Motion
from kinetograph.skeleton import Ancestor, Skeleton
from kinetograph.take import Take
from walkers import slide, walk

TOLERANCE = 1e-4
"""Metres by which a joint may be elsewhere."""


@dataclass(frozen=True)
class Case:
    """A take, and how it is written."""

    take: Take
    options: WriteOptions | None = None
    only: tuple[str, ...] = (".bvh", ".glb", ".fbx", ".usdc")


def one(motion: Motion, name: str = "dance", **more: object) -> Case:
    return Case(Take(name, {"motion": motion}), **more)  # type: ignore[arg-type]


def base(seconds: float = 0.4, fps: float = 30.0, **more: float) -> Motion:
    """A short walk of a body whose joints have the names of most programs."""
    motion = walk(seconds, fps=fps, turn_rate=0.5, **more)
    return named(motion, lambda name: "".join(part.capitalize() for part in name.split("_")))


def named(motion: Motion, change: Callable[[str], str]) -> Motion:
    names = tuple(change(name) for name in motion.skeleton.names)
    return replace(motion, skeleton=replace(motion.skeleton, names=names, roles={}))


def numbered(motion: Motion) -> Motion:
    """The motion with names that say nothing, as of nodes without any."""
    names = tuple(f"joint_{joint}" for joint in range(len(motion.skeleton)))
    return replace(motion, skeleton=replace(motion.skeleton, names=names))


def below(motion: Motion, name: str, carried: bool) -> Motion:
    """The motion with a joint above its root, which never moves or carries the travel."""
    skeleton = motion.skeleton
    parents = np.concatenate([[-1], skeleton.parents + 1])
    offsets = np.concatenate([[[0.0, 0.0, 0.0]], skeleton.offsets])
    more = Skeleton((name, *skeleton.names), parents, offsets)
    frames = len(motion)
    rotations = np.concatenate([rot.identity(frames, 1), motion.rotations], axis=1)
    ground = motion.translation * [1.0, 0.0, 1.0] if carried else np.zeros((frames, 3))
    bones = np.broadcast_to(offsets, (frames, *offsets.shape)).copy()
    bones[:, 0], bones[:, 1] = 0.0, motion.translation - ground
    return Motion(more, ground, rotations, motion.fps, bones)


def rest_rotated(motion: Motion, rest: np.ndarray) -> Motion:
    """The same motion in the world, of a skeleton whose joints' frames are rotated at rest by ``rest``, (J, 4)."""
    skeleton = motion.skeleton
    offsets = skeleton.offsets.copy()
    rotations = motion.rotations.copy()
    for joint, parent in enumerate(skeleton.parents.tolist()):
        above = rest[parent] if parent >= 0 else rot.IDENTITY
        if parent >= 0:
            offsets[joint] = rot.rotate(rot.conjugate(above), offsets[joint])
        rotations[:, joint] = rot.multiply(rot.multiply(rot.conjugate(above), rotations[:, joint]), rest[joint])
    return replace(motion, skeleton=replace(skeleton, offsets=offsets), rotations=rot.normalize(rotations))


def along_x(motion: Motion) -> Motion:
    """The same motion in the world, every bone's rest along the X axis of its joint."""
    skeleton = motion.skeleton
    rest = rot.identity(len(skeleton))
    for joint in range(len(skeleton)):
        children = skeleton.children[joint]
        if children:
            rest[joint] = rot.between(np.array([1.0, 0.0, 0.0]), skeleton.offsets[children[0]])
    return rest_rotated(motion, rest)


def scaled(motion: Motion, factor: float) -> Motion:
    skeleton = replace(motion.skeleton, offsets=motion.skeleton.offsets * factor, roles={})
    return replace(motion, skeleton=skeleton, translation=motion.translation * factor)


def with_ends(motion: Motion, each: int = 1) -> Motion:
    leaves = [joint for joint, children in enumerate(motion.skeleton.children) if not children]
    ends = np.random.default_rng(3).normal(0, 0.05, (len(leaves) * each, 3))
    skeleton = replace(motion.skeleton, end_parents=np.repeat(leaves, each), end_offsets=ends)
    return replace(motion, skeleton=skeleton)


def above(motion: Motion, *nodes: Ancestor) -> Motion:
    return replace(motion, skeleton=replace(motion.skeleton, ancestors=nodes))


def chain(joints: int, frames: int = 4, names: Callable[[int], str] = "bone{}".format) -> Motion:
    skeleton = Skeleton(
        tuple(names(i) for i in range(joints)),
        np.arange(joints) - 1,
        np.array([[0.0, 0.0, 0.0], *[[0.0, 0.05, 0.02]] * (joints - 1)]),
    )
    rng = np.random.default_rng(joints)
    rotations = rot.exp(rng.normal(0, 0.3, (frames, joints, 3)))
    return Motion(skeleton, rng.normal(0, 0.3, (frames, 3)), rotations, 30.0)


def star() -> Motion:
    angles = np.arange(24) * 2 * np.pi / 24
    offsets = np.array([[0, 0, 0], *[[np.cos(a), np.sin(a), 0.1] for a in angles]])
    skeleton = Skeleton(("hub", *(f"ray{i}" for i in range(24))), np.array([-1, *[0] * 24]), offsets)
    rotations = rot.exp(np.random.default_rng(1).normal(0, 1.0, (5, 25, 3)))
    return Motion(skeleton, np.zeros((5, 3)), rotations, 30.0)


def spinning() -> Motion:
    motion = base()
    spin = rot.about("y", np.radians(170.0) * np.arange(len(motion)))
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(spin, rotations[:, 0])
    rotations[:, 6] = rot.multiply(rot.about("x", -2.9 * np.arange(len(motion))), rotations[:, 6])
    return replace(motion, rotations=rotations)


def gimbal() -> Motion:
    motion = base()
    rotations = motion.rotations.copy()
    for joint, axis in enumerate("xyzxyz"):
        sign = 1.0 if joint % 2 else -1.0
        rotations[:, joint] = rot.multiply(rot.about(axis, np.full(len(motion), sign * np.pi / 2)), rotations[:, joint])
    return replace(motion, rotations=rot.normalize(rotations))


def zero_bones() -> Motion:
    motion = base()
    offsets = motion.skeleton.offsets.copy()
    offsets[[2, 5]] = 0.0
    return replace(motion, skeleton=replace(motion.skeleton, offsets=offsets))


def stretching() -> Motion:
    motion = base()
    bones = np.broadcast_to(motion.skeleton.offsets, (len(motion), len(motion.skeleton), 3)).copy()
    bones[:, 1:] *= (1.0 + 0.1 * np.sin(np.arange(len(motion))))[:, None, None]
    return replace(motion, bones=bones)


def pair(*motions: Motion) -> Case:
    return Case(Take("duet", {f"dancer {i}": motion for i, motion in enumerate(motions, start=1)}))


def sideways(motion: Motion, metres: float = 1.0) -> Motion:
    return replace(motion, translation=motion.translation + np.array([metres, 0.0, 0.0]))


_TURN = rot.about("x", -np.pi / 2)
_RANDOM = rot.exp(np.random.default_rng(8).normal(0, 1.0, (15, 3)))
CASES: dict[str, Callable[[], Case]] = {
    "plain": lambda: one(base()),
    "static root": lambda: one(below(base(), "root", carried=False)),
    "root with the travel": lambda: one(below(base(), "root", carried=True)),
    "an ancestor": lambda: one(above(base(), Ancestor("Armature"))),
    "an ancestor that is rotated": lambda: one(above(base(), Ancestor("Armature", np.array([0.1, 0.2, 0.3]), _TURN))),
    "two ancestors": lambda: one(above(base(), Ancestor("scene"), Ancestor("rig", np.array([0.0, 0.1, 0.0]), _TURN))),
    "bones along X": lambda: one(along_x(base())),
    "all rotations at rest": lambda: one(rest_rotated(base(), _RANDOM)),
    "lying rest": lambda: one(rest_rotated(base(), np.tile(_TURN, (15, 1)))),
    "names of numbers": lambda: one(numbered(base())),
    "two tracks": lambda: pair(base(), sideways(base())),
    "three tracks": lambda: pair(base(), sideways(base()), sideways(base(), -2.0)),
    "two skeletons": lambda: pair(base(), sideways(along_x(base()))),
    "a couple of sizes": lambda: pair(base(), sideways(scaled(base(), 0.6))),
    "tiny": lambda: one(scaled(base(), 0.01)),
    "giant": lambda: one(scaled(base(), 3.0)),
    "child": lambda: one(scaled(base(), 0.55)),
    "ends": lambda: one(with_ends(base())),
    "several ends": lambda: one(with_ends(base(), 3)),
    "a bone that stretches": lambda: one(slide(base(), "LeftFoot", np.linspace(0, 0.1, 39).reshape(13, 3))),
    "all bones stretch": lambda: one(stretching()),
    "23.976 frames": lambda: one(base(fps=24_000 / 1001)),
    "29.97 frames": lambda: one(base(fps=30_000 / 1001)),
    "59.94 frames": lambda: one(base(fps=60_000 / 1001)),
    "240 frames": lambda: one(base(fps=240.0)),
    "12.5 frames": lambda: one(base(1.0, fps=12.5)),
    "names with blanks": lambda: one(named(base(), lambda name: f"my {name} joint")),
    "names with colons": lambda: one(named(base(), lambda name: f"mixamorig:{name}")),
    "names with umlauts": lambda: one(named(base(), lambda name: f"Hüft-{name}ß")),
    "names with dots": lambda: one(named(base(), lambda name: f"{name}.001.L")),
    "names with slashes": lambda: one(named(base(), lambda name: f"rig|a/{name}")),
    "names in Japanese": lambda: one(named(base(), lambda name: f"左{name}センター")),
    "long names": lambda: one(named(base(), lambda name: name * 8)),
    "one frame": lambda: one(base(0.0)),
    "two frames": lambda: one(base(1 / 30)),
    "one joint": lambda: one(chain(1)),
    "two joints": lambda: one(chain(2)),
    "a deep chain": lambda: one(chain(60)),
    "a star": lambda: one(star()),
    "spinning": lambda: one(spinning()),
    "gimbal lock": lambda: one(gimbal()),
    "bones of no length": lambda: one(zero_bones()),
    "a kilometre away": lambda: one(sideways(base(), 1000.0)),
    "z up, centimetres": lambda: one(base(), options=WriteOptions("zxy", "centimetre", "z"), only=(".bvh",)),
    "x up, inches": lambda: one(base(), options=WriteOptions("xyz", "inch", "x"), only=(".bvh",)),
}


@dataclass(frozen=True)
class Outcome:
    """What came back: lists of differences, empty where all is kept."""

    positions: list[str]
    names: list[str]
    rate: list[str]
    tracks: list[str]
    animation: list[str]

    @property
    def lost(self) -> dict[str, list[str]]:
        return {what: found for what, found in vars(self).items() if found}


def outcome(case: Case, path: Path) -> Outcome:
    """Write a case and read it again."""
    save(case.take, path, options=case.options)
    return compared(case, read(path, ReadOptions()), path.suffix)


def loaded_of(case: Case) -> Loaded:
    """A case as if it had been read."""
    return Loaded(case.take)


def compared(case: Case, loaded: Loaded, suffix: str) -> Outcome:
    there = [track for track in case.take.tracks.values() if isinstance(track, Motion)]
    back = [track for track in loaded.take.tracks.values() if isinstance(track, Motion)]
    positions, names, rate = [], [], []
    for number, (old, new) in enumerate(zip(there, back, strict=False)):
        if abs(new.fps / old.fps - 1.0) > 1e-12:
            rate.append(f"{old.fps!r} became {new.fps!r}")
        if len(new) != len(old):
            rate.append(f"{len(old)} frames became {len(new)}")
        kept = {*new.skeleton.names, *(node.name for node in new.skeleton.ancestors)}
        wanted = [*old.skeleton.names, *(node.name for node in old.skeleton.ancestors)]
        if number == 0:  # several characters of one file have names of their own in some formats
            names += [f"{name!r} became another" for name in wanted if name not in kept]
        positions += _differences(old, new)
    tracks = [] if len(there) == len(back) else [f"{len(there)} tracks became {len(back)}"]
    if len(there) > 1 and suffix != ".bvh" and list(case.take.tracks) != list(loaded.take.tracks):
        tracks.append(f"{list(case.take.tracks)} became {list(loaded.take.tracks)}")
    animation = []
    if suffix != ".bvh" and loaded.animations != (case.take.name,):
        animation.append(f"{case.take.name!r} became {loaded.animations}")
    return Outcome(positions, names, rate, tracks, animation)


def _differences(old: Motion, new: Motion) -> list[str]:
    """Joints, and ends, that are elsewhere; joints are matched by their order where names were changed."""
    if len(old) != len(new):
        return []
    joints = {name: joint for joint, name in enumerate(new.skeleton.names)}
    shared = [(i, joints[name]) for i, name in enumerate(old.skeleton.names) if name in joints]
    if not shared and len(old.skeleton) == len(new.skeleton):
        shared = [(i, i) for i in range(len(old.skeleton))]
    mine, theirs = zip(*shared, strict=True) if shared else ((), ())
    apart = np.linalg.norm(joint_positions(old)[:, mine] - joint_positions(new)[:, theirs], axis=-1)
    most = apart.max(axis=0, initial=0.0)
    far = [f"{old.skeleton.names[i]} by {most[k]:.2g} m" for k, i in enumerate(mine) if most[k] > TOLERANCE]
    if len(old.skeleton.end_parents) and not far:
        far += _ends_apart(old, new)
    return far or ([] if shared else ["no joint is there again"])


def _ends_apart(old: Motion, new: Motion) -> list[str]:
    """Ends that no end or joint is at."""
    points = np.concatenate([end_positions(new), joint_positions(new)], axis=1)
    ends = end_positions(old)
    apart = np.linalg.norm(ends[:, :, None] - points[:, None], axis=-1).max(axis=0).min(axis=1)
    return [f"an end by {distance:.2g} m" for distance in apart if distance > TOLERANCE]
