"""FBX: every way in which a scene is written, against matrices computed one at a time."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import fbx_files
import mutations
import naive_fbx
import numpy as np
import pytest
from fbx_files import AUTO, CONSTANT, CUBIC, LINEAR, NEXT, TCB, USER, Bone, Keys, Layer, Stack

from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import ReadOptions, load, read, save
from kinetograph.formats.fbx.nodes import make, parse
from kinetograph.kinematics import joint_positions
from kinetograph.take import Take

METRES = {"UnitScaleFactor": 100.0, "TimeMode": 6}
MOVED = ("Lcl Translation", "Lcl Rotation", "Lcl Scaling")


def chain(rng: np.random.Generator, count: int = 6, scaled: bool = True) -> list[Bone]:
    """Bones with everything that a node may have."""
    bones = []
    for i in range(count):
        vectors = ("RotationOffset", "RotationPivot", "ScalingOffset", "ScalingPivot")
        properties: dict[str, Any] = {name: rng.normal(0, 0.1, 3) for name in vectors}
        properties |= {name: rng.uniform(-180, 180, 3) for name in ("PreRotation", "PostRotation", "Lcl Rotation")}
        properties |= {"Lcl Translation": rng.normal(0, 0.3, 3), "InheritType": int(rng.integers(0, 3))}
        properties |= {"RotationOrder": int(rng.integers(0, 7)), "RotationActive": int(rng.integers(0, 4) > 0)}
        if scaled:
            properties["Lcl Scaling"] = rng.uniform(0.5, 2.0, 3) * rng.choice([1, 1, 1, -1], 3)
        properties["GeometricTranslation"] = rng.normal(0, 10, 3)  # moves what hangs on a node, not the node
        bones.append(Bone(f"bone{i}", i - 1 if i < 4 else int(rng.integers(0, i)), properties))
    return bones


def walks(rng: np.random.Generator, bones: Sequence[Bone], spread: float = 0.2) -> dict[tuple[int, str, str], Keys]:
    """Linear keys, a second at 30 per second, of every axis of every bone."""
    times = [k / 30 for k in range(31)]
    out = {}
    for bone, name, axis in itertools.product(range(len(bones)), MOVED, "XYZ"):
        size = 60.0 if name == "Lcl Rotation" else spread
        values = rng.normal(1.0 if name == "Lcl Scaling" else 0.0, size, 3)
        out[bone, name, axis] = Keys(times, np.interp(times, [0, 0.5, 1], values).tolist())
    return out


def positions(path: Path, **options: Any) -> np.ndarray:
    """World positions, joints in the order of their numbers; the rate must be 30."""
    motion = read(path, ReadOptions(up="y", **options)).take.motion()
    assert motion.fps == 30
    return joint_positions(motion)[:, np.argsort(motion.skeleton.names)]


def expected(bones: Sequence[Bone], layers: Sequence[Layer], frames: int) -> np.ndarray:
    return np.array([naive_fbx.world(bones, layers, frame / 30)[:, :3, 3] for frame in range(frames)])


def written(folder: Path, data: bytes, name: str = "a.fbx") -> Path:
    (folder / name).write_bytes(data)
    return folder / name


@pytest.mark.parametrize("seed", range(12))
def test_scales_pivots_orders_and_rotations_before_and_after(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    bones = chain(rng)
    layer = Layer(walks(rng, bones))
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, [Stack("walk", [layer])], METRES)))
    np.testing.assert_allclose(positions(path), expected(bones, [layer], 31), atol=1e-6)


def test_a_bind_pose_without_a_skin_is_the_rest_pose(tmp_path: Path) -> None:
    bones = [
        Bone("root", properties={"Lcl Rotation": np.array([0.0, 0.0, 30.0])}),
        Bone("tip", 0, {"Lcl Translation": np.array([0.0, 50.0, 0.0])}),
    ]
    nodes = fbx_files.scene(bones)
    poses = []
    tilt = rot.to_matrix(rot.about("z", np.pi / 6))
    for key, place in ((100, np.zeros(3)), (101, tilt @ [0.0, 50.0, 0.0])):
        matrix = np.eye(4)
        matrix[:3, :3], matrix[3, :3] = tilt.T, place  # columns first
        poses.append(make("PoseNode", children=[make("Node", np.int64(key)), make("Matrix", matrix.ravel())]))
    objects = next(node for node in nodes if node.name == "Objects")
    objects.children.append(make("Pose", np.int64(99), "bind\x00\x01Pose", "BindPose", children=poses))
    motion = read(written(tmp_path, fbx_files.binary(nodes)), ReadOptions(up="y", units="centimetre")).take.motion()
    np.testing.assert_allclose(motion.skeleton.offsets[1], tilt @ [0.0, 0.5, 0.0], atol=1e-6)
    np.testing.assert_allclose(motion.rotations[0], [[1.0, 0.0, 0.0, 0.0]] * 2, atol=1e-6)


def test_a_bone_does_not_take_its_parents_scale_where_it_says_so(tmp_path: Path) -> None:
    lengths = {}
    for mode in (0, 1, 2):
        arm = {"Lcl Translation": (0.3, 0, 0), "InheritType": mode}
        bones = [Bone("a", -1, {"Lcl Scaling": (2.0, 2.0, 2.0)}), Bone("b", 0, arm), Bone("c", 1, arm)]
        keys = {(2, "Lcl Rotation", "X"): Keys([0, 1 / 30], [0, 1])}
        path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, [Stack("s", [Layer(keys)])], METRES)))
        lengths[mode] = np.linalg.norm(np.diff(positions(path)[0], axis=0), axis=1)
    np.testing.assert_allclose(lengths[2], [0.6, 0.3])  # the place of the first is scaled, but not what is inside it
    np.testing.assert_allclose(lengths[1], [0.6, 0.6])
    np.testing.assert_allclose(lengths[0], [0.6, 0.6])


def test_the_given_case_of_a_scaled_parent(data_folder: Path) -> None:
    cases = data_folder.parent / "cases"
    if not cases.is_dir():
        pytest.skip("no cases next to the data")
    for name in ("fbx_inherit2.fbx", "plain.fbx"):
        motion = load(cases / name).motion()
        at = dict(zip(motion.skeleton.names, joint_positions(motion)[0], strict=True))
        assert np.linalg.norm(at["LeftForeArm"] - at["LeftArm"]) == pytest.approx(0.28, abs=1e-6)
        assert np.linalg.norm(at["LeftHand"] - at["LeftForeArm"]) == pytest.approx(0.25, abs=1e-6)


# ---- one scene in every form ----

FORMS = {
    "text 7400": fbx_files.text,
    "text 7700": lambda nodes: fbx_files.text(nodes, 7700),
    "text 6100": lambda nodes: fbx_files.text(fbx_files.as_version_6(nodes), 6100),
    "binary 7100": lambda nodes: fbx_files.binary(nodes, 7100),
    "binary 7700": lambda nodes: fbx_files.binary(nodes, 7700),
    "binary 7400, high byte first": lambda nodes: fbx_files.binary(nodes, 7400, ">"),
    "binary 6100": lambda nodes: fbx_files.binary(fbx_files.as_version_6(nodes), 6100),
    "binary 6000, high byte first": lambda nodes: fbx_files.binary(fbx_files.as_version_6(nodes), 6000, ">"),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_scene_is_the_same_in_every_form(tmp_path: Path, form: str) -> None:
    rng = np.random.default_rng(7)
    bones = [*chain(rng, 5), Bone('arm "left" é', 2, {"Lcl Translation": (0.1, 0.2, 0.3)})]
    keys = walks(rng, bones)
    slow = [0.0, 0.25, 0.5, 1.0]
    held = [CONSTANT, CONSTANT | NEXT, LINEAR, LINEAR]
    keys[0, "Lcl Translation", "X"] = Keys(slow, [0, 1, 2, 3], held)
    soft = [CUBIC | USER | naive_fbx.WEIGHTED] * 4
    weight = fbx_files.weights(0.6, 0.2)
    keys[1, "Lcl Rotation", "Y"] = Keys(slow, [0, 40, -20, 10], soft, [[30.0, -50.0, weight, 0.0]] * 4)
    scene = fbx_files.scene(bones, [Stack("walk", [Layer(keys)])], METRES)
    path = written(tmp_path, FORMS[form](scene))
    loaded = read(path)
    assert loaded.animations == ("walk",)
    assert 'arm "left" é' in loaded.take.motion().skeleton.names
    names = sorted(bone.name for bone in bones)
    order = [names.index(bone.name) for bone in bones]
    np.testing.assert_allclose(positions(path)[:, order], expected(bones, [Layer(keys)], 31), atol=1e-6)


@pytest.mark.parametrize("frames", [5, 400])
def test_our_own_files_are_the_same_as_text_and_as_version_6(tmp_path: Path, frames: int) -> None:
    motion = mutations.small_motion(frames)
    path = tmp_path / "a.fbx"
    save(motion, path)
    nodes = parse(path, path.read_bytes()).children
    for data in (fbx_files.text(nodes), fbx_files.text(fbx_files.as_version_6(nodes), 6100)):
        again = load(written(tmp_path, data, "b.fbx")).motion()
        assert (again.skeleton.names, again.fps) == (motion.skeleton.names, motion.fps)
        assert np.abs(joint_positions(again) - joint_positions(motion)).max() < 1e-4


def test_written_and_read_again_nothing_changes(tmp_path: Path) -> None:
    motion = mutations.small_motion(40)
    save(Take("a walk", {"one": motion}), tmp_path / "a.fbx")
    loaded = read(tmp_path / "a.fbx")
    again = loaded.take.motion()
    assert (again.skeleton.names, again.fps, loaded.animations) == (motion.skeleton.names, motion.fps, ("a walk",))
    assert np.abs(joint_positions(again) - joint_positions(motion)).max() < 1e-6


# ---- what is wrong with text ----

TEXT = '; FBX 7.4.0 project file\nObjects:  {\n\tModel: 1, "Model::a", "LimbNode" {\n\t}\n}\n'


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("\t}\n}", "\t}"), r"the file ends inside 'Objects': it is cut short"),
        (("}\n}", "}\n}\n}"), r":6: a closing brace too many"),
        (('"LimbNode"', '"LimbNode'), r":3: a quotation mark without its other"),
        (("\t}\n}", "\t\tA: *3 {\n\t\t\ta: 1,2\n\t\t}\n\t}\n}"), r":4: expected an array of 3 numbers, found 2"),
        (("\t}\n}", "\t\tA: *2 {\n\t\t\ta: 1,x\n\t\t}\n\t}\n}"), r":4: expected an array of 2 numbers, found other"),
        (("7.4.0", "5.8.0"), r"expected FBX version 6000 to 8999, found 5800: convert it"),
        (("Objects:", "A: {" * 80), r":2: more nodes, or deeper ones"),
        (("Objects:", "A:" * 80_000), r":2: more nodes, or deeper ones"),
    ],
)
def test_what_is_wrong_with_text_is_named_by_its_line(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    with pytest.raises(FormatError, match=message):
        load(written(tmp_path, TEXT.replace(*change).encode()))


def test_numbers_as_old_c_libraries_write_them(tmp_path: Path) -> None:
    numbers = "1.#INF,-1.#IND,1.#QNAN, ; a comment\n\t\t\tnan(ind),-0.5\n\t\t\t,1e3"
    extra = f"\t\tVertices: *6 {{\n\t\t\ta: {numbers}\n\t\t}}\n\t}}\n}}"
    path = written(tmp_path, TEXT.replace("\t}\n}", extra).encode())
    assert load(path).motion().skeleton.names == ("a",)


def test_damaged_keys_of_version_6_are_refused(tmp_path: Path) -> None:
    bones = [Bone("a")]
    stack = Stack("s", [Layer({(0, "Lcl Rotation", "X"): Keys([0, 1], [0, 90])})])
    good = fbx_files.text(fbx_files.as_version_6(fbx_files.scene(bones, [stack])), 6100).decode()
    assert read(written(tmp_path, good.encode())).animations == ("s",)
    for old, new, message in (
        ("KeyCount: 2", "KeyCount: 3", "expected 3 keys of a curve, found 2"),
        (", L", ", U, z", "keys are damaged"),
        (", L", ", U, s, 1.0", "keys are damaged"),
        (", L", ", 5", "keys are damaged"),
    ):
        assert old in good
        with pytest.raises(FormatError, match=message):
            load(written(tmp_path, good.replace(old, new, 1).encode()))


# ---- curves ----

TIMES = [0.0, 0.2, 0.5, 0.6, 1.0]
VALUES = [0.0, 1.0, -0.5, 0.7, 0.2]
DATA = [[1.0, -2.0, fbx_files.weights(0.8, 0.5), 0.0], [3.0, 0.5, fbx_files.weights(0.1, 0.9), 0.0]] * 3
SMOOTH = [[0.0, 0.0, 0.0, 0.0]] * 5
KINDS: dict[str, Keys] = {
    "linear": Keys(TIMES, VALUES),
    "constant": Keys(TIMES, VALUES, [CONSTANT] * 5),
    "constant at the next": Keys(TIMES, VALUES, [CONSTANT | NEXT] * 5),
    "user": Keys(TIMES, VALUES, [CUBIC | USER] * 5, DATA[:5]),
    "weighted": Keys(TIMES, VALUES, [CUBIC | USER | naive_fbx.WEIGHTED] * 5, DATA[:5]),
    "automatic": Keys(TIMES, VALUES, [CUBIC | AUTO] * 5, SMOOTH),
    "tension, continuity, bias": Keys(TIMES, VALUES, [CUBIC | TCB] * 5, [[0.3, -0.4, 0.6, 0.0]] * 5),
    "mixed": Keys(TIMES, VALUES, [CUBIC | AUTO, LINEAR, CUBIC | TCB, CONSTANT, CUBIC | USER], SMOOTH),
}


@pytest.mark.parametrize("kind", KINDS)
def test_curves_between_keys(tmp_path: Path, kind: str) -> None:
    layer = Layer({(0, "Lcl Translation", "Y"): KINDS[kind]})
    bones = [Bone("a", -1, {"Lcl Translation": (5.0, 6.0, 7.0)})]
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, [Stack("s", [layer])], METRES)))
    loaded = read(path, ReadOptions(up="y", fps=100.0))
    wanted = [naive_fbx.value(KINDS[kind], frame / 100) for frame in range(101)]
    np.testing.assert_allclose(loaded.take.motion().translation[:, 1], wanted, atol=1e-6)
    np.testing.assert_array_equal(loaded.take.motion().translation[0, [0, 2]], [5.0, 7.0])
    assert any("keys are not evenly spaced: sampled at 30" in note for note in read(path).notes)


@pytest.mark.parametrize(
    ("clamp", "values", "wanted"),
    [
        (0x1000, [0.0, 1.0, 1.0], 0.5),  # flat at a key whose neighbour is equal: u^2 (3 - 2u), in the middle
        (0x6000, [0.0, 1.0, 0.5], 0.5),  # no overshoot at a peak, nor a slope at the ends
    ],
)
def test_automatic_tangents_that_do_not_overshoot(
    tmp_path: Path, clamp: int, values: list[float], wanted: float
) -> None:
    keys = Keys([0.0, 1.0, 2.0], values, [CUBIC | AUTO | clamp] * 3, SMOOTH[:3])
    scene = fbx_files.scene([Bone("a")], [Stack("s", [Layer({(0, "Lcl Translation", "X"): keys})])], METRES)
    motion = read(written(tmp_path, fbx_files.binary(scene)), ReadOptions(fps=10.0)).take.motion()
    assert motion.translation[:, 0].max() <= 1 + 1e-9
    first = motion.translation[5, 0]
    assert first == pytest.approx(wanted if clamp == 0x6000 else 0.625)  # the first key leaves with its chord
    if clamp == 0x1000:
        np.testing.assert_allclose(motion.translation[10:, 0], 1.0)


@pytest.mark.parametrize(("kind", "wanted"), [("C", 1.0), ("R", 0.5), ("A", 1.5), ("M", 0.5), ("K", 1.5)])
def test_curves_beyond_their_ends(tmp_path: Path, kind: str, wanted: float) -> None:
    short = Keys([0.0, 1.0], [0.0, 1.0], after=kind)
    layer = Layer({(0, "Lcl Translation", "X"): short, (0, "Lcl Translation", "Y"): Keys([0.0, 3.0], [0.0, 0.0])})
    path = written(tmp_path, fbx_files.binary(fbx_files.scene([Bone("a")], [Stack("s", [layer])], METRES)))
    x = read(path, ReadOptions(fps=10.0)).take.motion().translation[:, 0]
    assert x[15] == pytest.approx(wanted)
    assert x[23] == pytest.approx({"C": 1.0, "R": 0.3, "A": 2.3, "M": 0.3, "K": 2.3}[kind])


def test_sparse_keys_are_sampled_at_the_files_rate(tmp_path: Path) -> None:
    layer = Layer({(0, "Lcl Rotation", "X"): Keys([0.0, 1.0, 2.0], [0, 90, 0])})
    path = written(tmp_path, fbx_files.binary(fbx_files.scene([Bone("a")], [Stack("s", [layer])], METRES)))
    loaded = read(path)
    assert (loaded.take.motion().fps, len(loaded.take.motion())) == (30, 61)
    assert any("1 s apart: sampled at 30" in note for note in loaded.notes)


# ---- layers and stacks ----


@pytest.mark.parametrize("mode", [0, 1, 2])
@pytest.mark.parametrize("weight", [100.0, 40.0, 0.0])
def test_layers_that_add_axis_by_axis(tmp_path: Path, mode: int, weight: float) -> None:
    rng = np.random.default_rng(3)
    bones = chain(rng, 4, scaled=False)
    upper = {key: keys for key, keys in walks(rng, bones).items() if key[0] < 3 and key[2] != "Z"}
    layers = [
        Layer(walks(rng, bones), still={}),
        Layer(
            upper,
            {"BlendMode": mode, "Weight": weight, "RotationAccumulationMode": 1, "ScaleAccumulationMode": 1},
            {(bone, name, "Z"): 0.5 for bone in range(3) for name in MOVED},
        ),
    ]
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, [Stack("s", layers)], METRES)))
    np.testing.assert_allclose(positions(path), expected(bones, layers, 31), atol=1e-6)
    partly = any("overrides those below in part" in note for note in read(path).notes)
    assert partly == (mode == 1 and weight < 100)


def test_the_weight_of_a_layer_may_change(tmp_path: Path) -> None:
    lower = Layer({(0, "Lcl Translation", "X"): Keys([0, 1], [1, 1])})
    upper = Layer(
        {(0, "Lcl Translation", "X"): Keys([0, 1], [3, 3])}, {"BlendMode": 2}, weight=Keys([0.0, 1.0], [0.0, 100.0])
    )
    path = written(tmp_path, fbx_files.binary(fbx_files.scene([Bone("a")], [Stack("s", [lower, upper])], METRES)))
    np.testing.assert_allclose(positions(path)[:, 0, 0], np.linspace(1, 3, 31), atol=1e-6)


@pytest.mark.parametrize(("mode", "weight"), [(0, 100.0), (0, 50.0), (2, 50.0)])
def test_layers_whose_rotations_are_composed(tmp_path: Path, mode: int, weight: float) -> None:
    below, above = (30.0, -50.0, 70.0), (-60.0, 20.0, 40.0)
    layers = [
        Layer({(0, "Lcl Rotation", a): Keys([0, 1 / 30], [v, v]) for a, v in zip("XYZ", angles, strict=True)}, more)
        for angles, more in ((below, {}), (above, {"BlendMode": mode, "Weight": weight}))
    ]
    bones = [
        Bone("a", -1, {"RotationOrder": 4, "RotationActive": 1}),
        Bone("b", 0, {"Lcl Translation": (1.0, 2.0, 3.0)}),
    ]
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, [Stack("s", layers)], METRES)))
    first, second = (rot.from_matrix(naive_fbx.euler(angles, "zxy")[:3, :3]) for angles in (below, above))
    if mode == 0:
        wanted = rot.multiply(first, rot.exp(weight / 100 * rot.log(second)))
    else:
        between = rot.multiply(rot.conjugate(first), second)
        wanted = rot.multiply(first, rot.exp(weight / 100 * rot.log(between if between[0] > 0 else -between)))
    np.testing.assert_allclose(positions(path)[0, 1], rot.rotate(wanted, np.array([1.0, 2.0, 3.0])), atol=1e-6)


def test_scales_of_layers_are_multiplied(tmp_path: Path) -> None:
    layers = [
        Layer({(0, "Lcl Scaling", axis): Keys([0, 1 / 30], [v, v]) for axis in "XYZ"}, more)
        for v, more in ((2.0, {}), (9.0, {"Weight": 50.0}))
    ]
    bones = [Bone("a"), Bone("b", 0, {"Lcl Translation": (1.0, 0.0, 0.0)})]
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, [Stack("s", layers)], METRES)))
    np.testing.assert_allclose(positions(path)[0, 1], [6.0, 0.0, 0.0], atol=1e-6)


def test_a_muted_layer_is_left_out(tmp_path: Path) -> None:
    layers = [
        Layer({(0, "Lcl Translation", "X"): Keys([0, 1 / 30], [v, v])}, more)
        for v, more in ((1.0, {}), (5.0, {"Mute": 1}))
    ]
    path = written(tmp_path, fbx_files.binary(fbx_files.scene([Bone("a")], [Stack("s", layers)], METRES)))
    assert positions(path)[0, 0, 0] == 1.0
    assert "animation layer 'L1' is muted: left out" in read(path).notes


def three(folder: Path, form: str = "binary 7700") -> Path:
    stacks = [
        Stack(name, [Layer({(0, "Lcl Translation", "X"): Keys([0, 1 / 30], [v, v])} if v else {})])
        for name, v in (("Take 001", 0.0), ("Idle", 1.0), ("Run|fast", 2.0), ("Idle", 3.0))
    ]
    return written(folder, FORMS[form](fbx_files.scene([Bone("a")], stacks, METRES)))


@pytest.mark.parametrize("form", ["binary 7700", "text 6100"])
def test_one_of_several_animations_is_chosen_by_its_name(tmp_path: Path, form: str) -> None:
    path = three(tmp_path, form)
    loaded = read(path)
    assert loaded.animations == ("Idle", "Run|fast", "Idle_2")  # the first moves nothing
    assert any("3 animations: read 'Idle', not 'Run|fast', 'Idle_2'" in note for note in loaded.notes)
    for name, value in (("Idle", 1.0), ("Run|fast", 2.0), ("Idle_2", 3.0), ("3", 3.0)):
        loaded = read(path, ReadOptions(animation=name))
        assert loaded.take.motion().translation[0, 0] == value
        assert not any("animations" in note for note in loaded.notes)
    with pytest.raises(RequestError, match=r"no animation 'Jump'; expected 'Idle', 'Run\|fast', 'Idle_2'"):
        read(path, ReadOptions(animation="Jump"))
    assert any("no animation of a node" in note for note in read(path, ReadOptions(animation="Take 001")).notes)


def test_animations_of_a_file_share_its_skeleton(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    kept = ("Lcl Translation", "Lcl Rotation", "PreRotation", "RotationActive")  # pivots make bones longer and shorter
    bones = [
        Bone(bone.name, bone.parent, {name: bone.properties[name] for name in kept})
        for bone in chain(rng, 5, scaled=False)
    ]
    stacks = []
    for name in ("walk", "run"):
        keys = {key: keys for key, keys in walks(rng, bones).items() if key[1] == "Lcl Rotation"}
        stacks.append(Stack(name, [Layer(keys)]))
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, stacks, METRES)))
    walk, run = (read(path, ReadOptions(animation=name)).take for name in ("walk", "run"))
    assert (walk.animation, run.animation) == ("walk", "run")
    np.testing.assert_array_equal(walk.motion().skeleton.offsets, run.motion().skeleton.offsets)
    for take, stack in ((walk, stacks[0]), (run, stacks[1])):
        assert take.motion().bones is None
        order = np.argsort(take.motion().skeleton.names)
        at = joint_positions(take.motion())[:, order]
        np.testing.assert_allclose(at, expected(bones, stack.layers, 31), atol=1e-6)


@pytest.mark.parametrize("suffix", [".fbx", ".glb", ".npz"])
@pytest.mark.parametrize("seed", range(4))
def test_scenes_there_and_back(tmp_path: Path, seed: int, suffix: str) -> None:
    rng = np.random.default_rng(seed)
    bones = chain(rng, 6, scaled=seed % 2 == 0)
    form = list(FORMS.values())[seed * 2]
    path = written(tmp_path, form(fbx_files.scene(bones, [Stack("a walk", [Layer(walks(rng, bones))])], METRES)))
    take = read(path).take
    save(take, tmp_path / f"b{suffix}")
    again = read(tmp_path / f"b{suffix}").take
    first, second = take.motion(), again.motion()
    assert (first.skeleton.names, first.fps, len(first)) == (second.skeleton.names, second.fps, len(second))
    assert np.abs(joint_positions(first) - joint_positions(second)).max() < 1e-4
    assert again.animation == "a walk" or suffix == ".npz"


# ---- settings and what is above the skeleton ----


@pytest.mark.parametrize(
    ("axes", "wanted"),
    [
        ({}, (1, 2, 3)),
        ({"UpAxis": 2, "FrontAxis": 1, "FrontAxisSign": -1}, (1, 3, -2)),
        ({"UpAxis": 2}, (1, 3, -2)),
        ({"UpAxis": 0}, (-2, 1, 3)),
        ({"UpAxis": 1, "UpAxisSign": -1}, (1, -2, -3)),
        ({"UpAxis": 2, "UpAxisSign": -1, "FrontAxis": 1}, (1, -3, 2)),
        ({"UpAxis": 1, "FrontAxis": 0, "CoordAxis": 2, "CoordAxisSign": -1}, (-3, 2, 1)),
        ({"UpAxis": 2, "FrontAxis": 0, "CoordAxis": 1}, (2, 3, 1)),
        ({"UpAxis": 7}, (1, 2, 3)),
    ],
)
def test_axes_and_their_signs(tmp_path: Path, axes: Mapping[str, int], wanted: tuple[float, float, float]) -> None:
    bones = [Bone("a", -1, {"Lcl Translation": (1.0, 2.0, 3.0)})]
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(bones, settings=METRES | axes)))
    np.testing.assert_allclose(load(path).motion().translation[0], wanted, atol=1e-12)


def test_left_handed_axes_are_noted(tmp_path: Path) -> None:
    scene = fbx_files.scene([Bone("a")], settings=METRES | {"CoordAxisSign": -1})
    assert any("left-handed" in note for note in read(written(tmp_path, fbx_files.binary(scene))).notes)


def test_a_rate_of_ones_own(tmp_path: Path) -> None:
    layer = Layer({(0, "Lcl Rotation", "X"): Keys([0.0, 0.3, 1.0], [0, 90, 0])})
    for settings, fps in (({"TimeMode": 14, "CustomFrameRate": 12.5}, 12.5), ({"TimeMode": 11}, 24), ({}, 30)):
        path = written(tmp_path, fbx_files.binary(fbx_files.scene([Bone("a")], [Stack("s", [layer])], settings)))
        assert load(path).motion().fps == fps


def test_a_skeleton_under_scaled_and_rotated_nulls(tmp_path: Path) -> None:
    nodes = [
        Bone("Scene", -1, {"Lcl Rotation": (-90.0, 0.0, 0.0), "Lcl Translation": (0.0, 7.0, 0.0)}, "Null"),
        Bone("Armature", 0, {"Lcl Scaling": (100.0, 100.0, 100.0)}, "Null"),
        Bone("hips", 1, {"Lcl Translation": (0.0, 0.0, 0.9)}),
        Bone("spine", 2, {"Lcl Translation": (0.0, 0.1, 0.2)}),
    ]
    layer = Layer({(2, "Lcl Rotation", "Z"): Keys([0, 1 / 30], [0, 90])})
    scene = fbx_files.scene(nodes, [Stack("s", [layer])], {"TimeMode": 6})
    motion = read(written(tmp_path, fbx_files.binary(scene))).take.motion()
    assert motion.skeleton.names == ("hips", "spine")
    wanted = [[[0, 0.97, 0], [0, 1.17, -0.1]], [[0, 0.97, 0], [-0.1, 1.17, 0]]]
    np.testing.assert_allclose(joint_positions(motion), wanted, atol=1e-9)


def test_nodes_that_move_are_joints_where_there_is_no_skeleton(tmp_path: Path) -> None:
    nodes = [Bone("top", -1, {}, "Null"), Bone("box", 0, {}, "Mesh"), Bone("still", 0, {}, "Mesh")]
    layer = Layer({(1, "Lcl Rotation", "Z"): Keys([0, 1 / 30], [0, 90])}, still={(2, "Lcl Rotation", "X"): 0.0})
    path = written(tmp_path, fbx_files.binary(fbx_files.scene(nodes, [Stack("s", [layer])], METRES)))
    assert load(path).motion().skeleton.names == ("box",)


def test_what_a_skin_is_bound_to_is_a_joint(tmp_path: Path) -> None:
    nodes = fbx_files.scene([Bone("a", -1, {}, "Null"), Bone("b", 0, {}, "Mesh"), Bone("c", 1, {}, "LimbNode")])
    objects, links = nodes[2].children, nodes[3].children
    objects.append(make("Deformer", np.int64(7), "s\x00\x01SubDeformer", "Cluster"))
    links.append(make("C", "OO", objects[1].values[0], np.int64(7)))
    assert load(written(tmp_path, fbx_files.binary(nodes))).motion().skeleton.names == ("b", "c")


def test_properties_come_from_the_template_where_a_model_has_none(tmp_path: Path) -> None:
    template = fbx_files.table({"Lcl Translation": (1.0, 2.0, 3.0), "InheritType": 2})
    kind = make("ObjectType", "Model", children=[make("PropertyTemplate", "FbxNode", children=[template])])
    nodes = [Bone("a", -1, {"Lcl Scaling": (2.0, 2.0, 2.0)}), Bone("b", 0), Bone("c", 1)]
    scene = [*fbx_files.scene(nodes, settings=METRES), make("Definitions", children=[kind])]
    at = joint_positions(load(written(tmp_path, fbx_files.text(scene))).motion())[0]
    np.testing.assert_allclose(at, [[1, 2, 3], [3, 6, 9], [4, 8, 12]], atol=1e-9)
