"""Poses, moves and layers along a curve, as the panel's rows ask for them."""

import bpy
import numpy as np
from common import FOLDER, SAMPLE, WALKS, bezier, emptied, error_of, finish, heads, installed, role, row
from mathutils import Quaternion

S = [(0, 0), (2, 1), (4, -1), (6, 0)]
TAKE = "humanoid3d_walk" if SAMPLE else "15_03"
ARM = ("left_shoulder", "left_elbow", "left_hand")


def posed():
    """A walker of the library's body who lifts an arm at frame 40; and the places of its joints there."""
    curve = bezier("straight", [(0, 8), (3, 8)])
    bpy.ops.kinetograph.walk(curve=curve.name, library=WALKS, speed=1.0)
    thing = bpy.context.object
    thing.name = "posed"
    bone = thing.pose.bones[role(thing, "left_shoulder")]
    bpy.context.scene.frame_set(40)
    bone.rotation_quaternion = bone.rotation_quaternion @ Quaternion((1, 0, 0), 0.9)
    bone.keyframe_insert("rotation_quaternion", frame=40)
    return thing


def shape(thing, frame):
    """How far joints are from one another, whatever the place and the heading."""
    found = heads(thing, list(thing.data.bones.keys()), [frame])[0]
    return np.linalg.norm(found[:, None] - found[None], axis=-1)


def asked(**values):
    """A row of the panel."""
    rows = getattr(bpy.context.scene.kinetograph, values.pop("rows")).add()
    for name, value in values.items():
        setattr(rows, name, value)


def cleared():
    for rows in ("keys", "moves", "layers"):
        getattr(bpy.context.scene.kinetograph, rows).clear()


def walk(**given):
    """Walk along the curve, with what is asked for."""
    bpy.ops.kinetograph.walk(curve="path", library=WALKS, speed=1.1, along=True, **given)
    return bpy.context.object if not given.get("armature") else bpy.data.objects[given["armature"]]


installed()
emptied(24)
curve, model = bezier("path", S), posed()

asked(rows="keys", name="lift", armature=model, frame=40, at=70)
thing = walk()
markers = {marker.name: marker.frame for marker in thing.animation_data.action.pose_markers}
wanted, found = shape(model, 40), shape(thing, 70)
apart = float(np.abs(wanted - found).max())
row("a key of an armature", apart < 1e-3 and markers.get("key 1") == 70, f"met to {1000 * apart:.3f} mm at frame 70")

cleared()
asked(rows="keys", armature=model, frame=40, when="ALONG", along=3.0)
asked(rows="keys", armature=model, frame=40, at=30, window=0.2)
thing = walk()
markers = sorted((marker.name, marker.frame) for marker in thing.animation_data.action.pose_markers)
met = dict(markers)
apart = [float(np.abs(wanted - shape(thing, met[name])).max()) for name in ("key 1", "key 2")]
good = abs(met["key 1"] - 30) <= 5 and max(apart) < 1e-3
said = f"at frames {met['key 1']} and {met['key 2']}, to {1000 * max(apart):.3f} mm"
row("a key with a window, one along", good, said)

cleared()
asked(rows="keys", armature=model, frame=40, when="ALONG", along=3.0)
for fill in ("NONE", "ALL", "PLACES"):
    bpy.context.scene.kinetograph.fill = fill
    thing = walk(keep_time=False)
    at = next(marker.frame for marker in thing.animation_data.action.pose_markers if marker.name == "key 1")
    apart = float(np.abs(wanted - shape(thing, at)).max())
    row(f"a key whose recording plays: {fill.lower()}", apart < 1e-3, f"met at frame {at}, to {1000 * apart:.3f} mm")

cleared()
asked(rows="moves", name=TAKE, first=1, last=80)
thing = walk()
sources = [text for text in thing.animation_data.action["kinetograph_sources"] if float(text.split("-")[0]) < 3.0]
row("a move in its span", all(TAKE in text for text in sources), f"{len(sources)} pieces, all of {TAKE}")
cleared()
asked(rows="moves", name=f"like:take:{TAKE}@0.5-1.2", first=20, last=44, cost=0.5)
thing = walk()
row("a move by an example", len(thing.animation_data.action["kinetograph_sources"]) > 3, "with a cost")
cleared()
asked(rows="moves", name=f"!{TAKE}", first=1, last=80)
sources = [t for t in walk().animation_data.action["kinetograph_sources"] if float(t.split("-")[0]) < 3.0]
row("a move that is ruled out", not any(TAKE in text for text in sources), f"{len(sources)} pieces, none of {TAKE}")

cleared()
asked(rows="layers", name="left arm", armature=model, at=20)
plain = walk()
bones = [role(plain, name) for name in ARM]
held = heads(plain, bones, [20 + 39])[0]
arm, own = (np.linalg.norm(np.diff(places, axis=0), axis=1) for places in (held, heads(model, bones, [40])[0]))
bend = [
    float(np.degrees(np.arccos(np.dot(*(np.diff(p, axis=0) / np.linalg.norm(np.diff(p, axis=0), axis=1)[:, None])))))
    for p in (held, heads(model, bones, [40])[0])
]
said = f"the elbow bends by {bend[0]:.1f} degrees, {bend[1]:.1f} there"
row("a layer for an arm", abs(bend[0] - bend[1]) < 1.0, said)

if (FOLDER / "person.glb").is_file():
    cleared()
    known = {each.name for each in bpy.data.objects}
    bpy.ops.import_scene.gltf(filepath=str(FOLDER / "person.glb"))
    person = next(each for each in bpy.data.objects if each.type == "ARMATURE" and each.name not in known)
    frame = int(person.animation_data.action.frame_range[0]) + 20
    own = shape(person, frame)
    asked(rows="keys", armature=person, frame=frame, at=60)
    walk(armature=person.name)
    apart = float(np.abs(own - shape(person, 60)).max())
    row("a key of my rig's own body", apart < 1e-3, f"met to {1000 * apart:.3f} mm")

before = len(bpy.data.objects), len(bpy.data.actions)
for what, words, values in (
    ("a move that is unknown", "moonwalk", {"rows": "moves", "name": "moonwalk", "last": 40}),
    ("a move without a name", "has no name", {"rows": "moves", "name": "!", "last": 40}),
    ("a key without a pose", "has no pose", {"rows": "keys", "at": 40}),
    ("a pose that is not there", "nobody", {"rows": "keys", "at": 40, "take": "nobody@2"}),
    ("a layer without a motion", "has no motion", {"rows": "layers", "at": 40}),
    ("a key after the end", "outside", {"rows": "keys", "armature": model, "frame": 40, "at": 4000}),
):
    cleared()
    asked(**values)
    said = error_of(bpy.ops.kinetograph.walk, curve="path", library=WALKS, along=True).removeprefix("Error: ")
    same = (len(bpy.data.objects), len(bpy.data.actions)) == before
    row(what, words in said and "\n" not in said and same, said)
finish()
