"""Reads a USD file with usd-core, in a child process: ``python -m kinetograph.formats.usd.child FILE OUT.npz [NAME]``.

Native code that reads damaged bytes may crash or ask for all memory; then this process ends, and not its parent. Why a
file is not read is written to stderr, in one line.
"""

from __future__ import annotations

import os
import resource
import sys
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.formats.animations import choose, labels, title
from kinetograph.formats.scene import most_values

REASON = "cannot read: "
"""Begins the line on stderr that says why, as usd-core may write lines of its own."""

REQUEST = "cannot choose: "
"""The same where it is not the file's fault."""

_MEMORY = 4 * 2**30  # bytes
_ROOM, _SWELL = 300 * 2**20, 10  # bytes that reading may take, and more for every byte of the file
_SECONDS = 60
_ARCS = {
    "references": "references",
    "payload": "payloads",
    "inheritPaths": "inherits",
    "specializes": "specializes",
    "variantSetNames": "variants",
    "variantSelection": "variants",
    "subLayers": "sublayers",
    "relocates": "relocates",
    "layerRelocates": "relocates",
}


def main(path: str, out: str, wanted: str | None = None) -> None:
    """Write every skeleton's joints, bind pose and local transforms over time.

    Parameters
    ----------
    path : str
        The USD file.
    out : str
        The ``.npz`` file to write.
    wanted : str, optional
        Which of several animations, a name or a number.
    """
    os.environ["PXR_WORK_THREAD_LIMIT"] = "1"  # every thread's stack would count
    from pxr import Sdf, Usd, UsdGeom, UsdSkel

    size = Path(path).stat().st_size
    _limit_memory(size)
    resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, _SECONDS))
    layer = Sdf.Layer.OpenAsAnonymous(path)
    if layer is None:
        raise SystemExit(f"{REASON}expected a USD file")
    _refuse_composition(layer)
    stage = Usd.Stage.Open(layer)
    skeletons = [UsdSkel.Skeleton(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton)]
    animations = _animations(stage, skeletons)
    known, names = labels([name for name, _ in animations]), [name for name, _ in animations]
    notes: list[str] = []
    try:
        chosen = choose(Path(path), known, wanted, notes) if animations or wanted is not None else -1
    except RequestError as error:
        raise SystemExit(f"{REQUEST}{error}") from None
    cache = UsdSkel.Cache()
    if animations:
        skeletons = _bound(skeletons, animations[chosen][1])
    for root in (prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Root)):
        cache.Populate(UsdSkel.Root(root), Usd.TraverseInstanceProxies())
    arrays: dict[str, Any] = {
        "scale": UsdGeom.GetStageMetersPerUnit(stage),
        "up": str(UsdGeom.GetStageUpAxis(stage)).lower(),
        "fps": stage.GetTimeCodesPerSecond(),
        "animations": np.array(known, dtype=np.str_),
        "animation": title(known, chosen, names[chosen]) if animations else "",
        "notes": np.array(notes, dtype=np.str_),
    }
    queries = [(skeleton, cache.GetSkelQuery(skeleton)) for skeleton in skeletons]
    queries = [(skeleton, query) for skeleton, query in queries if query and len(query.GetJointOrder())]
    for count, arrays_of_one in enumerate(_all_arrays(stage, queries, size)):
        arrays |= {f"{count}/{key}": value for key, value in arrays_of_one.items()}
    np.savez(out, count=len(queries), **arrays)


def _refuse_composition(layer: Any) -> None:
    """End where anything in a layer brings in other files, or copies parts of this one; before any of it is done."""
    found: list[str] = []

    def look(path: Any) -> None:
        spec = layer.GetObjectAtPath(path)
        for key in [] if spec is None or found else spec.ListInfoKeys():
            if (key in _ARCS or key.startswith("clip")) and spec.GetInfo(key):
                found.append(f"has {_ARCS.get(key, 'value clips')}, at {str(path)[:80]}")

    layer.Traverse("/", look)
    outside = [f"refers to {str(name)[:80]!r}" for name in layer.GetCompositionAssetDependencies() if name]
    if outside or found:
        what = [*outside, *found][0]
        raise SystemExit(f"{REASON}{what}; only files that stand alone are read: flatten it (usdcat --flatten)")


def _animations(stage: Any, skeletons: list[Any]) -> list[tuple[str, dict[Any, Any]]]:
    """The animations of a stage: what each is called, and its prim by the path of the skeleton that it moves.

    First those that skeletons are bound to, then others that have joints of a skeleton, below one root with it where
    there is such a skeleton. Prims with one name are parts of one animation.
    """
    from pxr import UsdSkel

    prims = [prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Animation)]
    bound = {
        skeleton.GetPath(): UsdSkel.BindingAPI(skeleton.GetPrim()).GetInheritedAnimationSource()
        for skeleton in skeletons
    }
    bound = {path: prim for path, prim in bound.items() if prim and prim.IsA(UsdSkel.Animation)}
    used = {prim.GetPath() for prim in bound.values()}
    found = [(_name(next(iter(bound.values()))), bound)] if bound else []
    others: dict[str, dict[Any, Any]] = {}
    for prim in prims:
        moved = [] if prim.GetPath() in used else [s for s in skeletons if _moves(prim, s)]
        near = [s for s in moved if UsdSkel.Root.Find(s.GetPrim()) == UsdSkel.Root.Find(prim)]
        for skeleton in near or moved:
            others.setdefault(_name(prim), {})[skeleton.GetPath()] = prim
    return [*found, *others.items()]


def _name(prim: Any) -> str:
    return str(prim.GetDisplayName() or prim.GetName())


def _moves(prim: Any, skeleton: Any) -> bool:
    """Whether an animation has joints of a skeleton."""
    from pxr import UsdSkel

    joints = UsdSkel.Animation(prim).GetJointsAttr().Get() or []
    return bool(set(joints) & set(skeleton.GetJointsAttr().Get() or []))


def _bound(skeletons: list[Any], animation: dict[Any, Any]) -> list[Any]:
    """The skeletons that an animation moves, bound to its prims."""
    from pxr import UsdSkel

    moved = [skeleton for skeleton in skeletons if skeleton.GetPath() in animation]
    for skeleton in moved:
        binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
        binding.CreateAnimationSourceRel().SetTargets([animation[skeleton.GetPath()].GetPath()])
    return moved or skeletons


def _limit_memory(size: int) -> None:
    """Limit this process to the memory that a file of ``size`` bytes may need, where the system can say what it has."""
    status = Path("/proc/self/statm")
    if status.is_file():
        used = int(status.read_text().split()[5]) * resource.getpagesize()
        most = used + _ROOM + _SWELL * size
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))


def _all_arrays(stage: Any, queries: list[tuple[Any, Any]], size: int) -> list[dict[str, Any]]:
    """The arrays of every skeleton, from one start. Ends where they would be too large for the file."""
    spans = [_span(skeleton, query) for skeleton, query in queries]
    start = min((first for first, _ in spans), default=0.0)
    joints = [len(query.GetJointOrder()) + 1 for _, query in queries]
    values = sum((last - start + 1) * count for (_, last), count in zip(spans, joints, strict=True))
    if not values <= most_values(size):
        raise SystemExit(f"{REASON}{values:g} frames of joints are too many for a file of its size")
    frames = [round(last - start) + 1 for _, last in spans]
    return [_skeleton_arrays(stage, *pair, start, count) for pair, count in zip(queries, frames, strict=True)]


def _span(skeleton: Any, query: Any) -> tuple[float, float]:
    """The first and the last time code at which a skeleton is moved."""
    from pxr import UsdGeom

    animation = query.GetAnimQuery()
    times = list(animation.GetJointTransformTimeSamples()) if animation else []
    prim = skeleton.GetPrim()
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(UsdGeom.Xformable):
            times += UsdGeom.Xformable(prim).GetTimeSamples()
        prim = prim.GetParent()
    return (min(times), max(times)) if times else (0.0, 0.0)


def _skeleton_arrays(stage: Any, skeleton: Any, query: Any, start: float, frames: int) -> dict[str, Any]:
    from pxr import Usd, UsdGeom

    joints = [str(joint) for joint in query.GetJointOrder()]
    here = UsdGeom.XformCache()
    local = np.empty((frames, len(joints), 4, 4), dtype=np.float32)
    places = np.empty((frames, 4, 4))
    for frame in range(frames):
        code = Usd.TimeCode(start + frame)
        local[frame] = np.array(query.ComputeJointLocalTransforms(code))
        here.SetTime(code)
        places[frame] = np.array(here.GetLocalToWorldTransform(skeleton.GetPrim()))
    bind = skeleton.GetBindTransformsAttr().Get()
    label = skeleton.GetJointNamesAttr().Get()
    own = label and len(label) == len(joints)
    names = list(map(str, label)) if own else [joint.rpartition("/")[2] for joint in joints]
    bound = np.array(bind) if bind and len(bind) == len(joints) else np.array(query.ComputeJointSkelTransforms(start))
    return {
        "names": np.array(names),
        "parents": np.array(list(query.GetTopology().GetParentIndices())),
        "local": local,
        "places": places,
        "bind": bound,
        "label": np.array(_name(skeleton.GetPrim())),
    }


if __name__ == "__main__":
    main(*sys.argv[1:4])
