"""Reads a USD file with usd-core, in a child process: ``python -m kinetograph.formats.usd.child FILE OUT.npz``.

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

REASON = "cannot read: "
"""Begins the line on stderr that says why, as usd-core may write lines of its own."""

_MEMORY = 4 * 2**30  # bytes
_ROOM, _SWELL = 300 * 2**20, 10  # bytes that reading may take, and more for every byte of the file
_SECONDS = 60
_MOST_FRAMES, _MOST_VALUES = 1_000_000, 40_000_000


def main(path: str, out: str) -> None:
    """Write every skeleton's joints, bind pose and local transforms over time.

    Parameters
    ----------
    path : str
        The USD file.
    out : str
        The ``.npz`` file to write.
    """
    os.environ["PXR_WORK_THREAD_LIMIT"] = "1"  # every thread's stack would count
    from pxr import Sdf, Usd, UsdGeom, UsdSkel

    _limit_memory(Path(path).stat().st_size)
    resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, _SECONDS))
    layer = Sdf.Layer.OpenAsAnonymous(path)
    if layer is None:
        raise SystemExit(f"{REASON}expected a USD file")
    outside = [str(name) for name in layer.GetCompositionAssetDependencies()]
    if outside:
        raise SystemExit(f"{REASON}refers to {outside[0][:80]!r}; only files that stand alone are read")
    stage = Usd.Stage.Open(layer)
    arrays: dict[str, Any] = {
        "scale": UsdGeom.GetStageMetersPerUnit(stage),
        "up": str(UsdGeom.GetStageUpAxis(stage)).lower(),
        "fps": stage.GetTimeCodesPerSecond(),
    }
    cache = UsdSkel.Cache()
    skeletons = [UsdSkel.Skeleton(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton)]
    for root in (prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Root)):
        cache.Populate(UsdSkel.Root(root), Usd.TraverseInstanceProxies())
    count = 0
    for skeleton in skeletons:
        query = cache.GetSkelQuery(skeleton)
        if query and len(query.GetJointOrder()):
            arrays |= {f"{count}/{key}": value for key, value in _skeleton_arrays(stage, skeleton, query).items()}
            count += 1
    np.savez(out, count=count, **arrays)


def _limit_memory(size: int) -> None:
    """Limit this process to the memory that a file of ``size`` bytes may need, where the system can say what it has."""
    status = Path("/proc/self/statm")
    if status.is_file():
        used = int(status.read_text().split()[5]) * resource.getpagesize()
        most = used + _ROOM + _SWELL * size
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))


def _skeleton_arrays(stage: Any, skeleton: Any, query: Any) -> dict[str, Any]:
    from pxr import Usd, UsdGeom

    joints = [str(joint) for joint in query.GetJointOrder()]
    animation = query.GetAnimQuery()
    times = sorted(animation.GetJointTransformTimeSamples()) if animation else []
    start, stop = (times[0], times[-1]) if times else (0.0, 0.0)
    frames = round(stop - start) + 1
    if not 0 < frames <= _MOST_FRAMES or frames * len(joints) > _MOST_VALUES:
        raise SystemExit(f"{REASON}{frames} frames of {len(joints)} joints are too many")
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
    names = [str(name) for name in label] if label and len(label) == len(joints) else joints
    bound = np.array(bind) if bind and len(bind) == len(joints) else np.array(query.ComputeJointSkelTransforms(start))
    return {
        "names": np.array(names),
        "parents": np.array(list(query.GetTopology().GetParentIndices())),
        "local": local,
        "places": places,
        "bind": bound,
        "label": np.array(skeleton.GetPrim().GetName()),
    }


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
