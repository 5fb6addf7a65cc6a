"""Libraries of several skeletons: which is used, what is left out, and what it costs to bring the others over."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.library import Library
from kinetograph.methods.bodies import Bodies, choose_takes, skeleton_like
from kinetograph.methods.recordings import gather
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take
from walkers import walk

ROLES = ("hips", "left_foot", "right_foot", "left_hand")


def _renamed(motion: Motion, before: str) -> Motion:
    """The same motion on joints that have other names."""
    body = motion.skeleton
    names = tuple(before + name for name in body.names)
    return replace(motion, skeleton=replace(body, names=names))


def _helped(motion: Motion) -> Motion:
    """The same motion on a skeleton with one more joint, at the end of an arm."""
    body = motion.skeleton
    hand = body.index("left_hand")
    tall = Skeleton(
        (*body.names, "tip"),
        np.append(body.parents, hand),
        np.vstack([body.offsets, [0.0, -0.1, 0.0]]),
        roles=body.roles,
    )
    still = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (len(motion), 1, 4))
    return Motion(tall, motion.translation, np.concatenate([motion.rotations, still], axis=1), motion.fps)


def _library(folder: Path, *takes: Take) -> Library:
    library = Library.create(folder / "library")
    for take in takes:
        library.add(take)
    return library


@pytest.fixture
def mixed(tmp_path: Path) -> Library:
    """Two takes of 15 joints, 5 s together, and one of 16 joints and 4 s, which comes first."""
    return _library(
        tmp_path,
        Take("tip", {"motion": _helped(walk(4.0, turn_rate=0.3))}),
        Take("a", {"motion": walk(2.0)}),
        Take("b", {"motion": walk(3.0)}),
    )


def test_the_skeleton_of_most_seconds_is_used_and_the_others_are_named(mixed: Library) -> None:
    gathered = gather(mixed)
    assert [recording.name for recording in gathered.recordings] == ["a", "b"]
    assert gathered.left == {"of 16 joints, where takes of 15 are used": ("tip",)}
    (note,) = gathered.notes
    assert note.startswith("1 take left out: of 16 joints, where takes of 15 are used (tip); --retarget")


def test_a_take_says_which_skeleton_is_used(mixed: Library) -> None:
    assert choose_takes(mixed, Bodies(like="tip")).names == ("tip",)
    assert choose_takes(mixed, Bodies(like="b"), exclude=("b",)).names == ("a",)
    with pytest.raises(RequestError, match="no take 'c' whose skeleton could be used; there are tip, a, b"):
        choose_takes(mixed, Bodies(like="c"))
    with pytest.raises(RequestError, match="no take to use with the skeleton of 'tip'"):
        choose_takes(mixed, Bodies(like="tip"), exclude=("tip",))


def test_takes_that_are_left_out_do_not_change_the_skeleton(mixed: Library) -> None:
    assert choose_takes(mixed, exclude=("b",)).names == ("a",)


def test_others_are_brought_over_at_a_cost_that_is_told(mixed: Library) -> None:
    gathered = gather(mixed, Bodies(retarget=True))
    tip, a, _ = gathered.recordings
    assert (tip.name, gathered.left) == ("tip", {})
    assert tip.take.motion() is tip.motion
    assert tip.motion.skeleton.names == a.motion.skeleton.names
    np.testing.assert_allclose(
        role_positions(tip.motion, ROLES), role_positions(mixed.take("tip").motion(), ROLES), atol=0.002
    )
    (note,) = gathered.notes
    assert note.startswith("1 take of 16 joints brought over to 15 joints by roles: limbs are off by 0.0 cm")


def test_a_namespace_is_no_difference(tmp_path: Path) -> None:
    library = _library(tmp_path, Take("a", {"m": walk(2.0)}), Take("b", {"m": _renamed(walk(1.0), "actor:")}))
    gathered = gather(library)
    assert (len(gathered.recordings), gathered.notes) == (2, ())
    assert skeleton_like(library, _renamed(walk(1.0), "x:").skeleton) == "a"
    assert skeleton_like(library, _renamed(walk(1.0), "x").skeleton) == ""


def test_a_skeleton_without_hips_cannot_be_brought_over_and_stops_nobody(tmp_path: Path) -> None:
    bare = walk(1.0)
    bare = replace(
        bare, skeleton=Skeleton(tuple(f"x{i}" for i in range(15)), bare.skeleton.parents, bare.skeleton.offsets)
    )
    gathered = gather(_library(tmp_path, Take("a", {"m": walk(2.0)}), Take("bare", {"m": bare})), Bodies(retarget=True))
    assert [recording.name for recording in gathered.recordings] == ["a"]
    ((why, names),) = gathered.left.items()
    assert (names, "the source has no hips" in why) == (("bare",), True)


def test_takes_without_the_motion_that_is_asked_for_are_named(tmp_path: Path) -> None:
    signal = Signal([[1.0], [1.2]], ("speed",), "m/s", 30.0)
    two = {"leader": walk(1.0), "follower": walk(1.0)}
    library = _library(tmp_path, Take("a", {"m": walk(2.0)}), Take("two", two), Take("speech", {"s": signal}))
    assert choose_takes(library).left == {
        "with several motions (leader, follower; name one with --track)": ("two",),
        "without a motion": ("speech",),
    }
    assert choose_takes(library, track="leader").names == ("two",)
    with pytest.raises(RequestError, match=r"take 'a': name one of its motions \(m\), found 'x'"):
        choose_takes(library, track="x")
