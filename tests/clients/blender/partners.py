"""A follower for a leader, a motion from one armature to another, sensors' readings, the library's panel, and roles."""

import json
import os

import bpy
import numpy as np
from common import FOLDER, SAMPLE, WALKS, bezier, emptied, error_of, finish, heads, installed, readings, role, row

installed()
DANCES = FOLDER / "dances"


def duet():
    if not DANCES.is_dir():
        print("skipped the duet: no recorded dances")
        return
    scene = emptied(30)
    bpy.ops.kinetograph.drop(library=str(DANCES), take="Easy_03", track="leader", start=5.0, stop=15.0)
    leader = bpy.context.object
    scene.kinetograph.without = "Easy_03"
    bpy.ops.kinetograph.follow(leader=leader.name, library=str(DANCES))
    follower = bpy.context.object
    frames = range(1, 300, 3)
    theirs = heads(leader, [role(leader, f"{side}_hand") for side in ("left", "right")], frames)
    ours = heads(follower, [role(follower, f"{side}_hand") for side in ("left", "right")], frames)
    apart = np.linalg.norm(theirs[:, :, None] - ours[:, None], axis=-1).min(axis=(1, 2))
    held = float((apart < 0.2).mean())  # wrists of hands that are held
    said = f"{follower.name}: a wrist is within 20 cm of the leader's in {100 * held:.0f} % of the frames"
    row("a follower", held > 0.6 and follower != leader, said)
    scene.kinetograph.without = ""


def retargeted():
    emptied(24)
    bpy.ops.kinetograph.walk(curve=bezier("path", [(0, 0), (0, 3)]).name, library=WALKS)
    source = bpy.context.object
    bpy.ops.kinetograph.drop(library=WALKS, take=_first(), stop=0.5)
    target = bpy.context.object
    bpy.ops.kinetograph.retarget(source=source.name, target=target.name)
    frames = range(1, 50)
    bones = [role(source, name) for name in ("hips", "left_foot", "right_hand")]
    apart = np.linalg.norm(heads(source, bones, frames) - heads(target, bones, frames), axis=-1).max()
    row("retargeted onto the same body", apart < 5e-3, f"joints {1000 * apart:.2f} mm apart")
    said = error_of(bpy.ops.kinetograph.retarget, source=source.name, target=source.name)
    row("source and target the same", "same armature" in said, said)


def _first():
    bpy.ops.kinetograph.look(library=WALKS)
    return bpy.context.window_manager.kinetograph_takes[0].name


def panel():
    emptied(24)
    first = _first()
    start, seconds = (0.1, 0.5) if SAMPLE else (2.0, 2.0)
    takes = bpy.context.window_manager.kinetograph_takes
    count = len(takes)
    bpy.ops.kinetograph.look(library=WALKS, words="no such words")
    row("takes are listed by words", count >= 1 and len(takes) == 0, f"{count} takes, the first {first}")
    bpy.ops.kinetograph.drop(library=WALKS, take=first, start=start, stop=start + seconds)
    thing = bpy.context.object
    frames = thing.animation_data.action.frame_range
    row(
        "a take is dropped",
        frames[1] - frames[0] == 24 * seconds,
        f"{seconds} s are {frames[1] - frames[0]:.0f} frames at 24",
    )
    bpy.ops.kinetograph.alike(library=WALKS, armature=thing.name)
    near = takes[0]
    good = SAMPLE or (near.name == first and abs(near.start - start) < 0.2)
    row("found by example", good, f"{near.name} from {near.start:.1f} s: {near.said}")
    thing.select_set(True)
    thing.animation_data.action.name = "mein Gang"
    new = str(FOLDER / f"own {os.getpid()}")
    bpy.ops.kinetograph.add(library=new)
    bpy.ops.kinetograph.look(library=new)
    row("an action is added", [t.name for t in takes] == ["mein Gang"], f"{takes[0].name}, {takes[0].seconds:.2f} s")
    said = error_of(bpy.ops.kinetograph.add, library=new)
    row("and not twice", "mein Gang" in said, said)


def roles():
    emptied(24)
    bpy.ops.kinetograph.drop(library=WALKS, take=_first(), stop=1.0)
    thing = bpy.context.object
    del thing.data["kinetograph_roles"]
    bpy.ops.kinetograph.roles(armature=thing.name)
    table = {r.name: r.bone for r in bpy.context.window_manager.kinetograph_roles}
    found = table["left_foot"]
    for each in bpy.context.window_manager.kinetograph_roles:
        if each.name == "left_toe":
            each.bone = ""
    kept = json.loads(thing.data["kinetograph_roles"])
    row(
        "roles are kept with the armature", kept["left_foot"] == found and kept["left_toe"] == "", f"{len(table)} roles"
    )


def sensed():
    emptied(60)
    measured = readings()
    bpy.ops.kinetograph.sense(readings=str(measured), library=WALKS)
    thing = bpy.context.object
    hips = heads(thing, [role(thing, "hips")], [1, 200])[:, 0]
    went = float(np.linalg.norm((hips[1] - hips[0])[:2]))
    row(
        "from sensors' readings", (0.4 if SAMPLE else 1.5) < went < 4.5, f"walks {went:.1f} m of 3.3 in as many seconds"
    )


def together():
    """What was made is said in the action, and goes with one step of undo."""
    emptied(24)
    bpy.ops.kinetograph.walk(curve=bezier("path", [(0, 0), (0, 3)]).name, library=WALKS)
    action = bpy.context.object.animation_data.action
    sources, seams = list(action["kinetograph_sources"]), len(action.pose_markers)
    row("provenance", len(sources) == seams + 1 and "_" in sources[0], sources[0])
    registered = bpy.ops.kinetograph.walk.get_rna_type()
    options = bpy.types.KINETOGRAPH_OT_walk.bl_options
    row("one step of undo", options == {"REGISTER", "UNDO"} and registered is not None, "registered as one")


for each in (duet, retargeted, panel, roles, sensed, together):
    each()
finish()
