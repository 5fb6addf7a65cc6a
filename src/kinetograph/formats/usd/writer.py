"""Writing USD with usd-core."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.character import Skin
from kinetograph.errors import RequestError
from kinetograph.formats.ancestors import with_ancestors_skinned
from kinetograph.formats.body import dressed, named_motions
from kinetograph.formats.capsules import rest_positions
from kinetograph.formats.names import unique
from kinetograph.formats.options import WriteOptions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Take


def write(what: Take | Motion | Signal, path: str | Path, options: WriteOptions | None = None) -> None:
    """Write a motion, or every motion of a take, as USD.

    Parameters
    ----------
    what : Take, Motion or Signal
    path : str or Path
        Written to exactly this path.
    options : WriteOptions, optional
        ``character`` is whose skin the motions wear; without one, capsules.

    Raises
    ------
    RequestError
        usd-core is missing, there is no motion, motions differ in rate, or units or axis are given.

    Notes
    -----
    USD's names have only letters, digits and underscores; joints are renamed accordingly, and keep their own names as
    data.
    """
    options = options or WriteOptions()
    if options.units != "metre" or options.up != "y":
        raise RequestError(
            f"USD is written in metres, Y up; found units {options.units!r}, up {options.up!r}: leave them out"
        )
    usd = _library()
    name, motions = named_motions(what, "USD")
    if len({motion.fps for motion in motions.values()}) > 1:
        raise RequestError("USD has one rate; found motions of several: resample them first")
    stage = usd.Usd.Stage.CreateInMemory()
    usd.UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    usd.UsdGeom.SetStageUpAxis(stage, usd.UsdGeom.Tokens.y)
    fps = next(iter(motions.values())).fps
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(max(len(motion) for motion in motions.values()) - 1)
    scene = usd.UsdGeom.Xform.Define(stage, "/" + _identifiers(usd, [name])[0])
    stage.SetDefaultPrim(scene.GetPrim())
    for label, (track, motion) in zip(_identifiers(usd, list(motions)), motions.items(), strict=True):
        whole = with_ancestors_skinned(*dressed(motion, options.character))
        _add(usd, stage, f"{scene.GetPath()}/{label}", (track, name), *whole)
    _export(stage, Path(path))


def _library() -> Any:
    try:
        from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdSkel, Vt
    except ImportError:
        raise RequestError("USD needs the package usd-core: pip install 'kinetograph[usd]'") from None
    module = ModuleType("usd")
    module.__dict__.update(Gf=Gf, Sdf=Sdf, Tf=Tf, Usd=Usd, UsdGeom=UsdGeom, UsdSkel=UsdSkel, Vt=Vt)
    return module


def _identifiers(usd: Any, names: list[str]) -> list[str]:
    return unique([usd.Tf.MakeValidIdentifier(name) or "joint" for name in names], "joint", [])


def _add(usd: Any, stage: Any, path: str, names: tuple[str, str], motion: Motion, skin: Skin) -> None:
    track, called = names
    root = usd.UsdSkel.Root.Define(stage, path)
    label = path.rpartition("/")[2]  # programs name the character after this node
    skeleton = usd.UsdSkel.Skeleton.Define(stage, f"{path}/{label}")
    skeleton.GetPrim().SetDisplayName(track)
    animated = _identifiers(usd, [label, f"{label}_body", called])[2]
    animation = usd.UsdSkel.Animation.Define(stage, f"{path}/{animated}")
    animation.GetPrim().SetDisplayName(called)
    joints = _identifiers(usd, list(motion.skeleton.names))
    for joint, parent in enumerate(motion.skeleton.parents[1:].tolist(), start=1):
        joints[joint] = f"{joints[parent]}/{joints[joint]}"
    skeleton.CreateJointsAttr(joints)
    skeleton.CreateJointNamesAttr(list(motion.skeleton.names))
    animation.CreateJointsAttr(joints)
    rest = motion.skeleton.offsets.copy()
    rest[0] = motion.translation[0]
    placed = rest_positions(motion.skeleton) + motion.translation[0]
    skeleton.CreateRestTransformsAttr(_matrices(usd, rest))
    skeleton.CreateBindTransformsAttr(_matrices(usd, placed))
    _animate(usd, animation, motion, rest)
    usd.UsdSkel.BindingAPI.Apply(root.GetPrim())
    binding = usd.UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    _add_mesh(usd, stage, f"{path}/{label}_body", skeleton, skin, motion.translation[0])


def _animate(usd: Any, animation: Any, motion: Motion, rest: FloatArray) -> None:
    count = len(motion.skeleton)
    rotations = rot.unroll(motion.rotations).astype(np.float32)[..., [1, 2, 3, 0]]  # in arrays the real part is last
    places = np.tile(rest, (len(motion), 1, 1)) if motion.bones is None else motion.bones.copy()
    places[:, 0] = motion.translation
    translations, quaternions = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
    animation.CreateScalesAttr(usd.Vt.Vec3hArray(count, usd.Gf.Vec3h(1, 1, 1)))
    with usd.Sdf.ChangeBlock():
        for frame in range(len(motion)):
            translations.Set(usd.Vt.Vec3fArray.FromNumpy(places[frame].astype(np.float32)), frame)
            quaternions.Set(usd.Vt.QuatfArray.FromNumpy(np.ascontiguousarray(rotations[frame])), frame)


def _add_mesh(usd: Any, stage: Any, path: str, skeleton: Any, skin: Skin, origin: FloatArray) -> None:
    mesh = usd.UsdGeom.Mesh.Define(stage, path)
    points = (skin.points + origin).astype(np.float32)
    mesh.CreatePointsAttr(usd.Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateExtentAttr(usd.Vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0), points.max(axis=0)])))
    mesh.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(len(skin.triangles), 3, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(usd.Vt.IntArray.FromNumpy(skin.triangles.reshape(-1).astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateNormalsAttr(usd.Vt.Vec3fArray.FromNumpy(skin.normals.astype(np.float32)))
    mesh.SetNormalsInterpolation("vertex")
    colours = np.array([colour for _, colour in skin.palette], dtype=np.float32)[skin.tints]
    shade = mesh.CreateDisplayColorPrimvar("uniform")
    shade.Set(usd.Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(colours)))
    binding = usd.UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    joints = np.where(skin.weights > 0, skin.joints, 0).astype(np.int32)
    binding.CreateJointIndicesPrimvar(False, 4).Set(usd.Vt.IntArray.FromNumpy(joints.reshape(-1)))
    weights = skin.weights.astype(np.float32).reshape(-1)
    binding.CreateJointWeightsPrimvar(False, 4).Set(usd.Vt.FloatArray.FromNumpy(weights))
    binding.CreateGeomBindTransformAttr(usd.Gf.Matrix4d(1.0))


def _matrices(usd: Any, shifts: FloatArray) -> Any:
    return [usd.Gf.Matrix4d(1.0).SetTranslate(usd.Gf.Vec3d(*map(float, shift))) for shift in shifts]


def _export(stage: Any, path: Path) -> None:
    if not stage.GetRootLayer().Export(str(path)):
        raise RequestError(f"{path}: USD could not write it; is the disk full?")
