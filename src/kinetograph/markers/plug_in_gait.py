"""The Plug-in-Gait marker set: its markers, and the joints of a body that follow from them in single frames.

Axes of a segment are those of a T pose in the world: x to the left, y up, z forward, palms down. Joint centres are
first estimated as in gait laboratories: hips by the regression of Davis et al. (1991), ankles by the chord function of
the shank's marker, knees and elbows next to their markers along the normal of the bent limb (knees that never bend by
the chord function of the thigh's marker), wrists between their two markers, shoulders below the acromion by 17 % of
the distance between the two (Rab et al. 2002). Widths of joints are fractions of the leg's length. The solver then
improves the centres with all frames of a take.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.markers.geometry import axes, chord, hinge, length, middle, unit

MARKERS: dict[str, tuple[str, ...]] = {
    "hips": ("LASI", "RASI", "LPSI", "RPSI", "SACR"),
    "chest": ("C7", "T10", "CLAV", "STRN", "RBAK"),
    "head": ("LFHD", "RFHD", "LBHD", "RBHD"),
    **{
        f"{side}_{part}": tuple(side[0].upper() + name for name in names)
        for side in ("left", "right")
        for part, names in {
            "hip": ("THI", "KNE"),
            "knee": ("TIB", "ANK"),
            "foot": ("HEE", "TOE"),
            "collar": ("SHO",),
            "shoulder": ("UPA", "ELB"),
            "elbow": ("FRM", "WRA", "WRB"),
            "hand": ("FIN",),
        }.items()
    },
}
"""The markers on each segment; a segment is named after the joint at its upper end."""

_LEGS = tuple(f"{side}{name}" for side in "LR" for name in ("ASI", "THI", "KNE", "TIB", "ANK", "HEE", "TOE"))
_ARM = ("SHO", "ELB", "WRA", "WRB")
_PARENTS = {
    "hips": "",
    **{f"{s}_hip": "hips" for s in ("left", "right")},
    **{f"{s}_knee": f"{s}_hip" for s in ("left", "right")},
    **{f"{s}_foot": f"{s}_knee" for s in ("left", "right")},
    **{f"{s}_toe": f"{s}_foot" for s in ("left", "right")},
    "spine": "hips",
    "chest": "spine",
    "neck": "chest",
    "head": "neck",
    **{f"{s}_collar": "chest" for s in ("left", "right")},
    **{f"{s}_shoulder": f"{s}_collar" for s in ("left", "right")},
    **{f"{s}_elbow": f"{s}_shoulder" for s in ("left", "right")},
    **{f"{s}_hand": f"{s}_elbow" for s in ("left", "right")},
}
_KNEE, _ANKLE, _ELBOW = 0.115, 0.08, 0.08  # widths, as fractions of the leg's length
_RADIUS = 0.007  # metres, of a marker
_ASIS = (0.1, 0.5)  # metres between the two, of any person
_BENT = np.radians(25.0)  # limbs that bend by more have a plane
_ENOUGH = 20  # frames
_UPRIGHT = np.cos(np.radians(25.0))

Points = dict[str, FloatArray]


@dataclass(frozen=True, eq=False)
class Segment:
    """A segment in every frame; NaN where its markers are not seen.

    Parameters
    ----------
    parent : str
        The segment above, ``""`` at the top.
    origin : ndarray, shape (F, 3)
        Its upper joint, metres.
    axes : ndarray, shape (F, 3, 3)
        Its axes as columns.
    """

    parent: str
    origin: FloatArray
    axes: FloatArray


def missing(names: set[str]) -> list[str]:
    """The markers of the pelvis and the legs, which are needed, that are not among some names."""
    lost = [name for name in _LEGS if name not in names]
    return lost if "SACR" in names else lost + [name for name in ("LPSI", "RPSI") if name not in names]


def segments(points: Points) -> dict[str, Segment]:
    """The segments of a body, estimated in every frame by itself.

    Parameters
    ----------
    points : dict of str to ndarray, shape (F, 3)
        Markers by name, metres, Y up, NaN where they are not seen.

    Returns
    -------
    dict of str to Segment
        Parents before children. Arms, head and trunk are left out where their markers are missing.

    Raises
    ------
    RequestError
        The two markers in front of the pelvis are never seen at once, or not as far apart as a body's.
    """
    place: Points = {}
    frames: Points = {}
    _pelvis(points, place, frames)
    for side in ("left", "right"):
        _leg(points, side, place, frames)
    if {"C7", "T10", "CLAV", "STRN"} <= points.keys():
        _trunk(points, place, frames)
        if set(MARKERS["head"]) <= points.keys():
            _head(points, place, frames)
        if all(f"{side}SHO" in points for side in "LR"):
            for side in ("left", "right"):
                if all(f"{side[0].upper()}{name}" in points for name in _ARM):
                    _arm(points, side, place, frames)
    # markers in front of the pelvis are lower than those behind, and headbands tilted: upright people hold both level
    upright = frames.get("chest", frames["hips"])[:, 1, 1] > _UPRIGHT
    for name in ("hips", "head"):
        if name in frames:
            frames[name] = _levelled(frames[name], upright)
    return {name: Segment(parent, place[name], frames[name]) for name, parent in _PARENTS.items() if name in place}


def _pelvis(points: Points, place: Points, frames: Points) -> None:
    left, right = points["LASI"], points["RASI"]
    wide = _typical(length(left - right), 50, "LASI and RASI")
    if not _ASIS[0] < wide < _ASIS[1]:
        raise RequestError(f"LASI and RASI are {wide:.3g} m apart, as on no body; give the file's units with --units")
    front = middle(left, right)
    back = points["SACR"] if "SACR" in points else middle(points["LPSI"], points["RPSI"])
    pelvis = axes(x=left - right, z=front - back)
    hips = [front + (pelvis @ _hip(points, side, wide)[:, None])[..., 0] for side in ("left", "right")]
    place["hips"] = middle(*hips)
    frames["hips"] = pelvis
    place["left_hip"], place["right_hip"] = hips


def leg_length(points: Points) -> float:
    """Metres from the front of the pelvis by way of the knee's marker to the ankle's, the mean of the sides."""
    sides = [
        length(points[f"{s}ASI"] - points[f"{s}KNE"]) + length(points[f"{s}KNE"] - points[f"{s}ANK"]) for s in "LR"
    ]
    return float(np.mean([np.nanpercentile(side, 75) for side in sides]))  # of an extended leg


def _typical(values: FloatArray, percentile: float, names: str) -> float:
    known = values[np.isfinite(values)]
    if len(known) == 0:
        raise RequestError(f"no frame shows {names} at once; too much is hidden")
    return float(np.percentile(known, percentile))


def _hip(points: Points, side: str, wide: float) -> FloatArray:
    """The hip's centre in the pelvis' axes relative to the middle of its front, ``(3,)``, after Davis et al."""
    leg = leg_length(points)
    size, depth = 0.115 * leg - 0.0153, 0.1288 * leg - 0.04856 + _RADIUS
    theta, beta = 0.5, 0.314
    out = wide / 2 - size * np.sin(theta)
    ahead = size * np.cos(theta) * np.sin(beta) - depth * np.cos(beta)
    up = -size * np.cos(theta) * np.cos(beta) - depth * np.sin(beta)
    return np.array([out if side == "left" else -out, up, ahead])


def _leg(points: Points, side: str, place: Points, frames: Points) -> None:
    letter = side[0].upper()
    leg, sign = leg_length(points), 1.0 if side == "left" else -1.0
    hip, knee_marker, ankle_marker = place[f"{side}_hip"], points[f"{letter}KNE"], points[f"{letter}ANK"]
    width = 0.5 * _KNEE * leg + _RADIUS
    knee = knee_marker - sign * width * hinge(hip, knee_marker, ankle_marker, -sign * width, _BENT)
    if np.isfinite(knee[:, 0]).sum() < _ENOUGH:
        knee = chord(hip, knee_marker, points[f"{letter}THI"], width)
    ankle = chord(knee, ankle_marker, points[f"{letter}TIB"], 0.5 * _ANKLE * leg + _RADIUS)
    place[f"{side}_knee"], place[f"{side}_foot"] = knee, ankle
    frames[f"{side}_hip"] = axes(y=hip - knee, x=sign * (knee_marker - knee))
    frames[f"{side}_knee"] = axes(y=knee - ankle, x=frames[f"{side}_hip"][..., 0])  # a hinge
    frames[f"{side}_foot"] = axes(z=points[f"{letter}TOE"] - points[f"{letter}HEE"], x=sign * (ankle_marker - ankle))
    place[f"{side}_toe"], frames[f"{side}_toe"] = points[f"{letter}TOE"], frames[f"{side}_foot"]


def _trunk(points: Points, place: Points, frames: Points) -> None:
    c7, t10, clav, strn = (points[name] for name in ("C7", "T10", "CLAV", "STRN"))
    chest = axes(y=middle(c7, clav) - middle(t10, strn), z=middle(clav, strn) - middle(c7, t10))
    place["chest"], frames["chest"] = t10 + 0.3 * (strn - t10), chest
    place["neck"] = c7 + 0.35 * (clav - c7)
    apart = length(place["left_hip"] - place["right_hip"])[:, None]
    place["spine"] = place["hips"] + 0.828 * apart * frames["hips"][..., 1]  # Plug-in Gait's fifth lumbar vertebra
    frames["spine"] = axes(y=place["chest"] - place["spine"], x=frames["hips"][..., 0] + chest[..., 0])
    frames["neck"] = chest


def _head(points: Points, place: Points, frames: Points) -> None:
    front, back = middle(points["LFHD"], points["RFHD"]), middle(points["LBHD"], points["RBHD"])
    left, right = middle(points["LFHD"], points["LBHD"]), middle(points["RFHD"], points["RBHD"])
    head = axes(z=front - back, x=left - right)
    band = middle(front, back)
    # the skull rotates about the height of the ears, half a headband's length below the band
    place["head"] = band - 0.5 * length(front - back)[:, None] * head[..., 1]
    frames["head"] = head
    frames["neck"] = axes(y=place["head"] - place["neck"], x=frames["chest"][..., 0] + head[..., 0])


def _levelled(frame: FloatArray, upright: BoolArray) -> FloatArray:
    """A segment's axes rotated about its x so that it is level in most frames in which the body is upright."""
    pitch = np.arcsin(np.clip(frame[upright, 1, 2], -1, 1))
    if not np.isfinite(pitch).any():
        return frame
    angle = float(np.nanmedian(pitch))
    level = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    return np.asarray(frame @ level)


def _arm(points: Points, side: str, place: Points, frames: Points) -> None:
    letter, sign = side[0].upper(), 1.0 if side == "left" else -1.0
    tip, elbow_marker = points[f"{letter}SHO"], points[f"{letter}ELB"]
    chest = frames["chest"]
    apart = _typical(length(points["LSHO"] - points["RSHO"]), 50, "LSHO and RSHO")
    shoulder = tip - 0.17 * apart * chest[..., 1]
    radial, ulnar = points[f"{letter}WRA"], points[f"{letter}WRB"]
    wrist = middle(radial, ulnar)
    width = sign * (0.5 * _ELBOW * leg_length(points) + _RADIUS)
    normal = hinge(shoulder, elbow_marker, wrist, width, _BENT)
    if np.isfinite(normal[:, 0]).sum() < _ENOUGH:
        normal = hinge(shoulder, elbow_marker, wrist, width, 0.0)
    elbow = elbow_marker + width * normal
    root = points["CLAV"] + 0.25 * (points["C7"] - points["CLAV"]) + sign * 0.1 * apart * chest[..., 0]
    place[f"{side}_collar"], frames[f"{side}_collar"] = root, chest
    place[f"{side}_shoulder"], place[f"{side}_elbow"], place[f"{side}_hand"] = shoulder, elbow, wrist
    frames[f"{side}_shoulder"] = axes(x=sign * (elbow - shoulder), y=elbow_marker - elbow)
    frames[f"{side}_elbow"] = axes(x=sign * (wrist - elbow), z=radial - ulnar)
    finger = points.get(f"{letter}FIN", wrist + unit(wrist - elbow))
    frames[f"{side}_hand"] = axes(x=sign * (finger - wrist), z=radial - ulnar)
