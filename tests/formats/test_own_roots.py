"""Which trees of joints are bodies, where a body begins, and what is above it written back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.formats import ReadOptions, load, read, read_character, save, stream
from kinetograph.formats.ancestors import last_ancestor, with_ancestors
from kinetograph.formats.bodies import Keep, choose_bodies
from kinetograph.formats.bvh.growing import GrowingBvh
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion, cut
from kinetograph.skeleton import Ancestor, Skeleton
from kinetograph.take import Take
from trees import controller, on_the_ground, under, walker

FORMATS = (".bvh", ".glb", ".fbx", ".usda", ".npz")
HELPERS = ("ik_foot_root", "ik_hand_gun")


def _places(motion: Motion, names: tuple[str, ...]) -> FloatArray:
    return joint_positions(motion)[:, [motion.skeleton.index(name) for name in names]]


def _same_body(found: Motion, body: Motion, atol: float = 1e-6) -> None:
    """The same joints in the world, each by its name, and no others."""
    assert sorted(found.skeleton.names) == sorted(body.skeleton.names)
    names = body.skeleton.names
    np.testing.assert_allclose(_places(found, names), _places(body, names), atol=atol)


def _tilted() -> FloatArray:
    return rot.multiply(rot.about("x", -np.pi / 2), rot.about("y", 0.7))


TREES = {
    "a root that never moves": (under(walker(), "World", np.zeros(3), rot.about("y", 0.0)), ["World"]),
    "one that is tilted, elsewhere": (
        under(walker(), "Reference", np.array([3.0, 1.0, -2.0]), _tilted()),
        ["Reference"],
    ),
    "one as high as the hips": (under(walker(), "Anchor", np.array([0.0, 0.95, 0.0]), rot.about("y", 0.0)), ["Anchor"]),
    "a game's root": (under(walker(), "root", *on_the_ground(walker()), HELPERS), ["root"]),
    "a game's root in an armature": (
        under(under(walker(), "root", *on_the_ground(walker()), HELPERS), "Armature", np.ones(3), _tilted()),
        ["Armature", "root"],
    ),
}


@pytest.mark.parametrize("kind", TREES)
def test_a_body_begins_at_its_hips_and_is_where_it_was(kind: str) -> None:
    whole, above = TREES[kind]
    (body,) = choose_bodies([whole]).motions
    assert body.skeleton.names[0] == "Hips"
    assert [node.name for node in body.skeleton.ancestors] == above
    assert body.bones is None
    assert len(body.skeleton.roles) == 21
    _same_body(body, walker(), 1e-9)


def test_ancestors_that_stand_are_kept_where_they_stand_and_those_that_move_where_they_rest() -> None:
    (body,) = choose_bodies([TREES["a game's root in an armature"][0]]).motions
    armature, root = body.skeleton.ancestors
    np.testing.assert_allclose(armature.translation, 1.0)
    np.testing.assert_allclose(np.abs(armature.rotation @ _tilted()), 1.0)
    np.testing.assert_allclose(root.rotation, [1.0, 0.0, 0.0, 0.0])


def test_a_body_that_begins_at_the_hips_is_left_as_it_is() -> None:
    motion = walker()
    chosen = choose_bodies([motion])
    assert chosen.roots == (None,)
    assert chosen.notes == ()
    assert chosen.motions[0].translation is motion.translation
    assert chosen.motions[0].skeleton.names == motion.skeleton.names
    assert not chosen.motions[0].skeleton.ancestors


def test_a_centre_of_mass_that_moves_with_the_hips_is_the_bodys_own_root() -> None:
    motion = walker()
    tilted = rot.multiply(motion.rotations[:, 0], rot.about("x", 0.2))
    com = under(motion, "Bip01", motion.translation, tilted, rest=(0.0, 0.95, 0.0))
    (alone,) = choose_bodies([com]).motions
    assert alone.skeleton.names[0] == "Bip01"
    assert not alone.skeleton.ancestors
    (in_game,) = choose_bodies([under(com, "root", *on_the_ground(motion), HELPERS)]).motions
    assert in_game.skeleton.names[0] == "Bip01"
    assert [node.name for node in in_game.skeleton.ancestors] == ["root"]
    _same_body(in_game, com, 1e-9)


def test_one_frame_is_enough_where_the_root_is_on_the_ground() -> None:
    whole, _ = TREES["a game's root"]
    (body,) = choose_bodies([cut(whole, 7, 8)]).motions
    assert body.skeleton.names[0] == "Hips"


def test_what_hangs_beside_the_hips_is_named() -> None:
    (note,) = choose_bodies([TREES["a game's root"][0]]).notes
    assert note == "left out as beside 'Hips', not of the body: 'ik_foot_root', 'ik_hand_gun' (kept by --everything)"


def test_a_root_that_moves_is_kept_if_asked_for() -> None:
    whole, _ = TREES["a game's root in an armature"]
    (body,) = choose_bodies([whole], Keep(root_motion=True)).motions
    assert body.skeleton.names[:2] == ("root", "Hips")
    assert [node.name for node in body.skeleton.ancestors] == ["Armature"]
    assert not set(HELPERS) & set(body.skeleton.names)
    ways = on_the_ground(walker())[0]
    np.testing.assert_allclose(body.translation, ways, atol=1e-9)
    still = choose_bodies([TREES["a root that never moves"][0]], Keep(root_motion=True)).motions[0]
    assert still.skeleton.names[0] == "Hips"


def test_everything_is_kept_if_asked_for() -> None:
    motions = [controller("ctrl"), TREES["a game's root"][0]]
    chosen = choose_bodies(motions, Keep(everything=True))
    assert [m.skeleton.names for m in chosen.motions] == [m.skeleton.names for m in motions]
    assert chosen.notes == ()


def test_bodies_are_chosen_among_controllers_and_two_people_stay_two() -> None:
    small = replace(walker(), skeleton=replace(walker().skeleton, offsets=0.1 * walker().skeleton.offsets))
    rigs = [controller("ctrl_a"), walker(), controller("ctrl_b"), walker(), small]
    chosen = choose_bodies(rigs)
    assert chosen.indices == (1, 3)
    assert chosen.notes == ("left out as no bodies: 'ctrl_a', 'ctrl_b', 'Hips' (kept by --everything)",)
    many = choose_bodies([walker(), *(controller(f"c{i}") for i in range(9))])
    assert many.notes == ("left out as no bodies: 'c0', 'c1', 'c2', 'c3' and 5 more (kept by --everything)",)


def test_a_file_without_a_body_is_kept_as_it_is() -> None:
    chosen = choose_bodies([controller("sword"), controller("shield")])
    assert chosen.indices == (0, 1)
    assert chosen.notes == ()


# ---- files ----


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("kind", TREES)
def test_files_hold_what_is_above_a_body(tmp_path: Path, kind: str, suffix: str) -> None:
    if suffix == ".usda":
        pytest.importorskip("pxr")
    (body,) = choose_bodies([TREES[kind][0]]).motions
    path = tmp_path / f"body{suffix}"
    save(body, path)
    back = load(path).motion()
    _same_body(back, body)
    assert back.fps == body.fps
    assert back.bones is None
    for node, was in zip(back.skeleton.ancestors, body.skeleton.ancestors, strict=True):
        assert node.name == was.name
        np.testing.assert_allclose(node.translation, was.translation, atol=1e-6)
        np.testing.assert_allclose(abs(node.rotation @ was.rotation), 1.0, atol=1e-6)
    assert back.skeleton.height == pytest.approx(body.skeleton.height, abs=1e-5)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_take_of_bodies_and_controllers_is_read_without_these(tmp_path: Path, suffix: str) -> None:
    if suffix == ".usda":
        pytest.importorskip("pxr")
    take = Take("scene", {"ctrl": controller("ctrl"), "ann": walker(), "bob": TREES["a game's root"][0]})
    path = tmp_path / f"scene{suffix}"
    save(take, path)
    tracks = read(path).take.tracks
    if suffix == ".npz":  # whose tracks are this package's own
        assert list(tracks) == ["ctrl", "ann", "bob"]
        return
    assert len(tracks) == 2
    for motion in tracks.values():
        assert isinstance(motion, Motion)
        _same_places = joint_positions(motion)[:, 0]
        np.testing.assert_allclose(_same_places, walker().translation, atol=1e-6)
    everything = read(path, ReadOptions(everything=True)).take.tracks
    assert len(everything) == 3


def test_units_and_axes_are_converted_with_what_is_above(tmp_path: Path) -> None:
    from kinetograph.formats import WriteOptions

    (body,) = choose_bodies([TREES["one that is tilted, elsewhere"][0]]).motions
    save(body, tmp_path / "a.bvh", options=WriteOptions(units="inch", up="z"))
    back = load(tmp_path / "a.bvh").motion()
    _same_body(back, body)
    np.testing.assert_allclose(back.skeleton.ancestors[0].translation, [3.0, 1.0, -2.0], atol=1e-6)


@pytest.mark.parametrize("kind", TREES)
def test_a_stream_gives_what_the_file_gives(tmp_path: Path, kind: str) -> None:
    save(TREES[kind][0], tmp_path / "a.bvh")
    whole = load(tmp_path / "a.bvh").motion()
    opened = stream(tmp_path / "a.bvh")
    assert opened.skeleton.names == whole.skeleton.names
    assert [n.name for n in opened.skeleton.ancestors] == [n.name for n in whole.skeleton.ancestors]
    places = np.concatenate([joint_positions(block) for block in opened.blocks()])
    np.testing.assert_allclose(places, joint_positions(whole), atol=1e-6)


def test_a_growing_file_has_what_is_above(tmp_path: Path) -> None:
    (body,) = choose_bodies([TREES["one that is tilted, elsewhere"][0]]).motions
    file = GrowingBvh(tmp_path / "a.bvh", body.skeleton, body.fps)
    for frame in range(len(body)):
        file.add(cut(body, frame, frame + 1))
    file.close()
    loaded = read(tmp_path / "a.bvh")
    assert loaded.notes == ()
    _same_body(loaded.take.motion(), body)
    assert loaded.take.motion().skeleton.ancestors[0].name == "Reference"


def test_an_archive_keeps_stance_and_ancestors(tmp_path: Path) -> None:
    motion = walker()
    stance = rot.about("z", np.linspace(0.0, 1.0, len(motion.skeleton)))
    above = (Ancestor("a", np.array([1.0, 2.0, 3.0]), _tilted()), Ancestor("b"))
    save(replace(motion, skeleton=replace(motion.skeleton, stance=stance, ancestors=above)), tmp_path / "a.npz")
    back = load(tmp_path / "a.npz").motion().skeleton
    assert back.stance is not None
    np.testing.assert_allclose(back.stance, stance)
    assert [(n.name, n.translation.tolist(), n.rotation.tolist()) for n in back.ancestors] == [
        (n.name, n.translation.tolist(), n.rotation.tolist()) for n in above
    ]


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 3))
@settings(max_examples=30, deadline=None)
def test_any_ancestors_leave_the_body_in_the_world(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    body = choose_bodies([walker(8)]).motions[0]
    above = tuple(Ancestor(f"n{i}", rng.normal(size=3), rot.normalize(rng.normal(size=4))) for i in range(count))
    body = replace(body, skeleton=replace(body.skeleton, ancestors=above))
    whole = with_ancestors(body)
    np.testing.assert_allclose(joint_positions(whole)[:, count:], joint_positions(body), atol=1e-9)
    at, _ = last_ancestor(body.skeleton)
    np.testing.assert_allclose(joint_positions(whole)[0, count - 1], at, atol=1e-12)
    (back,) = choose_bodies([replace(whole, skeleton=replace(whole.skeleton, roles={}))]).motions
    _same_body(back, body, 1e-9)


def test_names_above_that_the_body_has_too_are_made_unique() -> None:
    body = choose_bodies([walker(4)]).motions[0]
    body = replace(body, skeleton=replace(body.skeleton, ancestors=(Ancestor("Hips"), Ancestor("Spine"))))
    assert with_ancestors(body).skeleton.names[:3] == ("Hips_2", "Spine_2", "Hips")


def test_a_lone_skeleton_with_nothing_above_is_written_as_before() -> None:
    body = walker(4)
    assert with_ancestors(body) is body
    assert isinstance(body.skeleton, Skeleton)


def test_a_character_under_a_root_is_a_body_from_its_hips_on(tmp_path: Path) -> None:
    whole, _ = TREES["a game's root"]
    save(whole, tmp_path / "game.glb")
    save(walker(), tmp_path / "alone.glb")
    under_root, alone = read_character(tmp_path / "game.glb"), read_character(tmp_path / "alone.glb")
    assert under_root.skeleton.names[0] == "Hips"
    assert [node.name for node in under_root.skeleton.ancestors] == ["root"]
    assert set(np.unique(under_root.skin.joints)) <= set(range(len(alone.skeleton)))
    for joint in (1, 7, 15):  # the same parts of the body at the same places around the hips
        name = alone.skeleton.names[joint]
        mine = under_root.skin.points[under_root.skin.joints[:, 0] == under_root.skeleton.index(name)]
        wanted = alone.skin.points[alone.skin.joints[:, 0] == joint]
        np.testing.assert_allclose(mine.mean(axis=0), wanted.mean(axis=0), atol=0.05)
