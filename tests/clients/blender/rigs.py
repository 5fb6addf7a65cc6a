"""A walk onto other bodies: rigs of Rigify, with an FBX's scale and Mixamo's names, with VRM's, with IK, and a person.

What each bone does in Blender is compared with kinetograph's own retargeting, which the extension is given; and feet,
while the recording's are planted, with where they are planted first.
"""

import importlib
import json
import time

import bpy
import numpy as np
from common import FOLDER, WALKS, bezier, emptied, finish, installed, row
from mathutils import Matrix, Vector

installed()
KG = "bl_ext.user_default.kinetograph"
motions, apply, controls, axes, tasks, operators, bodies = (
    importlib.import_module(f"{KG}.{name}")
    for name in ("motions", "apply", "controls", "axes", "tasks", "operators", "bodies")
)
_given = {}


def remember(rig, names, translation, rotations):
    """What the extension was given for a rig, kept for the comparison."""
    turned, heads = _targets(rig, names, translation, rotations)
    _given.update(rig=rig, turned=turned, heads=heads)
    return turned, heads


_targets = motions.targets
apply.targets = remember


def look(what, degrees, used, only_direction=False, near=2):
    """Compare the bones with what the extension was given, and planted feet with the ground."""
    rig, scene = _given["rig"], bpy.context.scene
    first = int(rig.thing.animation_data.action.frame_range[0])
    frames = first + np.arange(len(_given["turned"]))
    joints = [rig.bones.index(name) for name in used if name in rig.bones]
    seen = motions.poses(rig.thing, [rig.bones[j] for j in joints], scene, frames)
    goal = controls._matrices(_given["turned"], _given["heads"])[:, joints]
    turn, place = controls.apart(seen, goal)
    worst = np.degrees(turn.max(axis=0))
    bent = np.degrees(
        np.arccos(
            np.clip((seen[..., :3, 1] * goal[..., :3, 1]).sum(-1) / np.linalg.norm(seen[..., :3, 1], axis=-1), -1, 1)
        )
    )
    off = 1000 * place.max() * rig.scale * rig.unit
    angles = bent.max(axis=0) if only_direction else worst
    name = rig.bones[joints[int(angles.argmax())]]
    word = "directions" if only_direction else "rotations"
    good = angles.max() < degrees and off < near
    said = f"{word} {angles.max():.2f} degrees off at most ({name}), places {off:.1f} mm"
    slide, height = feet(rig, frames)
    row(
        what,
        good and slide < 0.01 and height < 0.01,
        f"{said}; planted feet move {100 * slide:.1f} cm, rise {100 * height:.1f}",
    )


def feet(rig, frames):
    """How far planted ankles move and rise, metres: the median over steps of the furthest; a step is low and slow."""
    roles = json.loads(rig.thing.data.get("kinetograph_roles", "{}")) or _given.get("roles", {})
    moved, risen = [], []
    for side in ("left", "right"):
        foot = roles[f"{side}_foot"]
        seen = motions.poses(rig.thing, [foot], bpy.context.scene, frames)[:, 0, :3, 3]
        places = rig.to_world(seen)
        speed = np.linalg.norm(np.diff(places, axis=0), axis=1) * 24
        low = (places[:-1, 2] < np.quantile(places[:, 2], 0.35) + 0.01) & (speed < 0.25)
        for step in np.split(np.flatnonzero(low), np.flatnonzero(np.diff(np.flatnonzero(low)) > 1) + 1):
            if len(step) >= 4:
                inner = places[step[1:-1]]
                moved.append(np.linalg.norm(inner[:, :2] - inner[:, :2].mean(axis=0), axis=1).max())
                risen.append(abs(inner[:, 2] - np.median(inner[:, 2])).max())
    return float(np.median(moved)), float(np.median(risen))


def walk(thing):
    path = bezier("path", [(0, 0), (0.3, 1.5), (1.5, 3)])
    started = time.perf_counter()
    bpy.ops.kinetograph.walk(curve=path.name, library=WALKS, armature=thing.name, speed=1.1)
    return time.perf_counter() - started


# ---- the bodies ----


def rigify():
    emptied(24)
    bpy.ops.preferences.addon_enable(module="rigify")
    bpy.ops.object.armature_basic_human_metarig_add()
    meta = bpy.context.object
    bpy.ops.pose.rigify_generate()
    rig = next(o for o in bpy.data.objects if o.type == "ARMATURE" and o != meta)
    parts = ("spine", "spine.001", "spine.002", "spine.003", "spine.006")
    limbs = ("shoulder", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toe")
    used = [f"ORG-{p}" for p in parts] + [f"ORG-{p}.{side}" for p in limbs for side in "LR"]
    seconds = walk(rig)
    # a knee is a hinge there, so that thighs and shins may be rotated otherwise about their own length
    look(f"Rigify, as it comes, on IK ({seconds:.0f} s)", 0.1, used, only_direction=True, near=1)
    bpy.context.scene.kinetograph.on_fk = True
    seconds = walk(rig)
    look(f"Rigify, switched to FK ({seconds:.0f} s)", 1.0, used)
    bpy.context.scene.kinetograph.on_fk = False
    in_slices(rig)


class Asked(operators.KINETOGRAPH_OT_walk.__mro__[1]):
    """The operator's settings, as a task that a timer would drive."""

    curve, library, speed, by_radius, keep_time, mirror, hips = "path", WALKS, 1.1, False, True, False, "NEAR"
    along = False
    task, _made = operators.KINETOGRAPH_OT_walk.task, operators.KINETOGRAPH_OT_walk._made

    def __init__(self, armature):
        self.armature = armature


def in_slices(rig):
    """Keys are written while the interface goes on; given up meanwhile, nothing is left of them."""
    scene, action = bpy.context.scene, rig.animation_data.action
    scene.frame_set(7)
    path = bpy.data.objects["path"]
    path.data.splines[0].bezier_points[-1].co = (4, 8, 0)
    bpy.context.view_layer.update()
    before = len(bpy.data.actions), len(bpy.data.scenes)
    runner, took, frames = tasks.Runner(Asked(rig.name).task(bpy.context)), [], set()
    while not (runner.writing and len(took) > 10):
        writing, began = runner.writing, time.perf_counter()
        runner.step()
        if writing:
            took.append(time.perf_counter() - began)
            frames.add(scene.frame_current)
    runner.cancel()
    same = (len(bpy.data.actions), len(bpy.data.scenes)) == before and rig.animation_data.action == action
    row("given up while keys are written", same and scene.frame_current == 7, "the scene as it was")
    runner, began = tasks.Runner(Asked(rig.name).task(bpy.context)), time.perf_counter()
    took = []
    while not runner.done:
        writing, step = runner.writing, time.perf_counter()
        runner.step()
        if writing:
            took.append(time.perf_counter() - step)
    count = int(rig.animation_data.action.frame_range[1])
    said = f"{count} frames in {sum(took):.1f} s, {len(took)} slices, the longest {1000 * max(took):.0f} ms"
    row("Rigify's keys in slices", frames == {7} and np.median(took) < 0.06, said)


MIXAMO = {
    "Hips": ("", (0, 0, 1.0)), "Spine": ("Hips", (0, 0.01, 0.1)), "Spine1": ("Spine", (0, 0, 0.12)),
    "Spine2": ("Spine1", (0, 0, 0.13)), "Neck": ("Spine2", (0, 0, 0.15)), "Head": ("Neck", (0, -0.02, 0.1)),
    "HeadTop_End": ("Head", (0, 0, 0.18)),
}  # fmt: skip
for side, sign in (("Left", 1), ("Right", -1)):
    MIXAMO |= {
        f"{side}Shoulder": ("Spine2", (sign * 0.06, 0, 0.1)), f"{side}Arm": (f"{side}Shoulder", (sign * 0.13, 0, 0)),
        f"{side}ForeArm": (f"{side}Arm", (sign * 0.27, 0, 0)), f"{side}Hand": (f"{side}ForeArm", (sign * 0.26, 0, 0)),
        f"{side}UpLeg": ("Hips", (sign * 0.09, 0, -0.05)), f"{side}Leg": (f"{side}UpLeg", (0, -0.01, -0.42)),
        f"{side}Foot": (f"{side}Leg", (0, 0.03, -0.44)), f"{side}ToeBase": (f"{side}Foot", (0, -0.13, -0.07)),
        f"{side}Toe_End": (f"{side}ToeBase", (0, -0.07, 0)),
    }  # fmt: skip
VRM = {
    "Hips": "J_Bip_C_Hips", "Spine": "J_Bip_C_Spine", "Spine1": "J_Bip_C_Chest", "Spine2": "J_Bip_C_UpperChest",
    "Neck": "J_Bip_C_Neck", "Head": "J_Bip_C_Head", "Shoulder": "Shoulder", "Arm": "UpperArm", "ForeArm": "LowerArm",
    "Hand": "Hand", "UpLeg": "UpperLeg", "Leg": "LowerLeg", "Foot": "Foot", "ToeBase": "ToeBase",
}  # fmt: skip
UNREAL = {
    "Hips": "pelvis", "Spine": "spine_01", "Spine1": "spine_02", "Spine2": "spine_03", "Neck": "neck_01",
    "Head": "head", "Shoulder": "clavicle", "Arm": "upperarm", "ForeArm": "lowerarm", "Hand": "hand", "UpLeg": "thigh",
    "Leg": "calf", "Foot": "foot", "ToeBase": "ball",
}  # fmt: skip
ACCLAIM = {
    "Hips": "root", "Spine": "lowerback", "Spine1": "upperback", "Spine2": "thorax", "Neck": "lowerneck",
    "Head": "head", "Shoulder": "clavicle", "Arm": "humerus", "ForeArm": "radius", "Hand": "hand", "UpLeg": "femur",
    "Leg": "tibia", "Foot": "foot", "ToeBase": "toes",
}  # fmt: skip


def armature(name, rename, *, rolls=0.0, mode="QUATERNION", scale=1.0):
    """A T pose of Mixamo's proportions, by other names, with any roll of the bones."""
    data = bpy.data.armatures.new(name)
    thing = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.mode_set(mode="EDIT")
    places = {}
    for bone, (parent, offset) in MIXAMO.items():
        places[bone] = Vector(offset) + places.get(parent, Vector())
    for number, (bone, (parent, _)) in enumerate(MIXAMO.items()):
        made = data.edit_bones.new(rename(bone))
        below = [child for child, (above, _) in MIXAMO.items() if above == bone]
        made.head = places[bone] / scale
        made.tail = (places[below[0]] if below else places[bone] + Vector((0, 0, 0.08))) / scale
        made.roll = rolls * number
        if parent:
            made.parent = data.edit_bones[rename(parent)]
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in thing.pose.bones:
        bone.rotation_mode = mode
    return thing


def vrm_name(bone):
    side = "L" if bone.startswith("Left") else "R" if bone.startswith("Right") else ""
    plain = bone.removeprefix("Left").removeprefix("Right")
    return f"J_Bip_{side}_{VRM[plain]}" if side and plain in VRM else VRM.get(plain, f"end_{bone}")


def unreal_name(bone):
    side = "_l" if bone.startswith("Left") else "_r" if bone.startswith("Right") else ""
    plain = bone.removeprefix("Left").removeprefix("Right")
    return f"{UNREAL[plain]}{side}" if plain in UNREAL else f"end_{bone}"


def acclaim_name(bone):
    side = "l" if bone.startswith("Left") else "r" if bone.startswith("Right") else ""
    plain = bone.removeprefix("Left").removeprefix("Right")
    return f"{side}{ACCLAIM[plain]}" if plain in ACCLAIM else f"end_{bone}"


_PARTS = {"shoulder": "Arm", "elbow": "ForeArm", "hand": "Hand", "hip": "UpLeg", "knee": "Leg", "foot": "Foot"}
_PARTS["toe"] = "ToeBase"


def cast(what, thing, named):
    """Whether the roles that are kept with an armature are played by the bones of these names; the roles."""
    kept = json.loads(thing.data["kinetograph_roles"])
    wanted = {"hips": named("", "Hips"), "head": named("", "Head")}
    wanted |= {f"{side.lower()}_{r}": named(side, part) for side in ("Left", "Right") for r, part in _PARTS.items()}
    other = {name: kept.get(name) for name, bone in wanted.items() if kept.get(name) != bone}
    row(what, not other, f"others than expected: {other}" if other else f"all {len(wanted)} as expected")
    return kept


def unreal():
    """The mannequin's names, with its root on the floor, bones that twist, and goals of IK outside the body."""
    emptied(24)
    thing = armature("mannequin", unreal_name, rolls=0.4, scale=0.01)
    thing.scale *= 0.01
    bpy.ops.object.mode_set(mode="EDIT")
    bones = thing.data.edit_bones
    more = {"root": ("", "", 0.0), "ik_foot_root": ("root", "", 0.0)}
    for side in "lr":
        more |= {
            f"ik_foot_{side}": ("ik_foot_root", f"foot_{side}", 0.0),
            f"ik_hand_{side}": ("root", f"hand_{side}", 0.0),
        }
        for part in ("upperarm", "lowerarm", "thigh", "calf"):
            more[f"{part}_twist_01_{side}"] = (f"{part}_{side}", f"{part}_{side}", 0.5)
    for name, (parent, at, share) in more.items():
        made = bones.new(name)
        made.head = bones[at].head.lerp(bones[at].tail, share) if at else (0, 0, 0)
        made.tail = made.head + Vector((0, 0, 8))
        made.parent = bones.get(parent)
    bones["pelvis"].parent = bones["root"]
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    walk(thing)
    cast("roles of Unreal's mannequin", thing, lambda side, part: unreal_name(side + part))
    look("Unreal's names, in centimetres", 1.0, [unreal_name(bone) for bone in MIXAMO if "_End" not in bone])


def acclaim():
    emptied(24)
    thing = armature("cmu", acclaim_name, rolls=0.2, mode="ZXY")
    walk(thing)
    cast("roles of Acclaim's body", thing, lambda side, part: acclaim_name(side + part))
    look("Acclaim's names, as CMU's", 1.0, list(thing.data.bones.keys()))


def metarig():
    """Blender's own human, before Rigify makes a rig of it: fingers, a face, bones that are not connected."""
    emptied(24)
    bpy.ops.preferences.addon_enable(module="rigify")
    bpy.ops.object.armature_human_metarig_add()
    thing = bpy.context.object
    walk(thing)
    named = {"Hips": "spine", "Head": "spine.006", "Arm": "upper_arm", "ForeArm": "forearm", "Hand": "hand"}
    named |= {"UpLeg": "thigh", "Leg": "shin", "Foot": "foot", "ToeBase": "toe"}
    kept = cast("roles of Blender's human metarig", thing, lambda side, part: named[part] + (side and f".{side[0]}"))
    look("Blender's human metarig itself", 1.0, [bone for bone in kept.values() if bone])


def mixamo_fbx():
    """Through Blender's own FBX exporter and importer, in centimetres, as Mixamo's files come."""
    emptied(24)
    thing = armature("mixamo", lambda bone: f"mixamorig:{bone}", rolls=0.3)
    path = str(FOLDER / "mixamo.fbx")
    bpy.ops.export_scene.fbx(filepath=path, object_types={"ARMATURE"}, add_leaf_bones=False, global_scale=100.0)
    emptied(24)
    bpy.ops.import_scene.fbx(filepath=path, global_scale=0.01)
    thing = next(o for o in bpy.data.objects if o.type == "ARMATURE")
    walk(thing)
    thing.data.transform(Matrix.Scale(100.0, 4))  # as Mixamo's files come
    thing.scale *= 0.01
    bpy.context.view_layer.update()
    scale = thing.matrix_world.to_scale()[0]
    walk(thing)
    look(f"a Mixamo FBX, scaled by {scale:.3g}", 1.0, list(thing.data.bones.keys()))


def vrm():
    emptied(24)
    thing = armature("vrm", vrm_name, rolls=-0.7, mode="XYZ")
    thing.location, thing.rotation_euler = (1.0, 2.0, 0.0), (0.0, 0.0, 0.7)
    bpy.context.view_layer.update()
    walk(thing)
    look("VRM's names, Euler angles, placed", 1.0, list(thing.data.bones.keys()))


def by_ik():
    """A rig with an IK constraint on each shin, a goal at each ankle and a pole in front of each knee."""
    emptied(24)
    thing = armature("ik", lambda bone: bone)
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.mode_set(mode="EDIT")
    for side in ("Left", "Right"):
        foot = thing.data.edit_bones[f"{side}Foot"]
        goal = thing.data.edit_bones.new(f"{side} goal")
        goal.head, goal.tail = foot.head, foot.head + Vector((0, 0.2, 0))
        pole = thing.data.edit_bones.new(f"{side} pole")
        pole.head = thing.data.edit_bones[f"{side}Leg"].head + Vector((0, -0.6, 0))
        pole.tail = pole.head + Vector((0, 0, 0.1))
    bpy.ops.object.mode_set(mode="OBJECT")
    for side in ("Left", "Right"):
        ik = thing.pose.bones[f"{side}Leg"].constraints.new("IK")
        ik.target, ik.subtarget, ik.chain_count = thing, f"{side} goal", 2
        copy = thing.pose.bones[f"{side}Foot"].constraints.new("COPY_ROTATION")
        copy.target, copy.subtarget, copy.mute = thing, f"{side} goal", True
    walk(thing)
    look(
        "an IK goal at each ankle",
        2.0,
        [b for b in thing.data.bones.keys() if "Shoulder" not in b and " " not in b],
        only_direction=True,
    )


def held():
    """A rig whose head follows an empty: keys of it say nothing, and the report says so."""
    emptied(24)
    thing = armature("held", lambda bone: bone)
    other = bpy.data.objects.new("other", None)
    bpy.context.collection.objects.link(other)
    copy = thing.pose.bones["Head"].constraints.new("COPY_ROTATION")
    copy.target = other
    rig = bodies.Rig(thing, *bodies.tree(thing), 1.0)
    said = controls.held_elsewhere(rig)
    copy.mute = True
    good = said.startswith("other objects hold Head by") and controls.held_elsewhere(rig) == ""
    row("a bone that another object holds", good, said)


def person():
    """The CC0 character, as kinetograph writes it."""
    path = FOLDER / "person.glb"
    if not path.is_file():
        print("skipped the person: the sample 'character' is not here")
        return
    emptied(24)
    bpy.ops.import_scene.gltf(filepath=str(path))
    thing = next(o for o in bpy.data.objects if o.type == "ARMATURE")
    walk(thing)
    look("the CC0 character, from GLB", 1.0, list(thing.data.bones.keys()))
    sole(thing)


def sole(thing):
    """How far the skin goes below the floor and how near it stays to it."""
    meshes = [o for o in bpy.data.objects if o.type == "MESH" and o.find_armature() == thing]
    lows = []
    for frame in range(10, 60, 5):
        bpy.context.scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        low = []
        for mesh in meshes:
            shown = mesh.evaluated_get(graph)
            points = np.empty(3 * len(shown.data.vertices))
            shown.data.vertices.foreach_get("co", points)
            world = np.array(shown.matrix_world)
            low.append((points.reshape(-1, 3) @ world[2, :3] + world[2, 3]).min())
        lows.append(min(low))
    lows = 100 * np.array(lows)
    row("its skin on the floor", abs(lows).max() < 2.0, f"lowest point {lows.min():.1f} to {lows.max():.1f} cm")


for each in (mixamo_fbx, vrm, unreal, acclaim, metarig, by_ik, held, person, rigify):
    each()
finish()
