"""Small texts that people write by hand or export: damaged as they are in practice, and what their readers do.

By hand, for as many as one likes of every reader, or of those named:

    PYTHONPATH=tests python tests/formats/small_texts.py 5000 [keys layout ...]

A reader must read a text or raise an error of the package, of one line, within 5 seconds.
"""

from __future__ import annotations

import re
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path

import msgspec
import mutations
import numpy as np

from kinetograph.errors import KinetographError
from kinetograph.formats import (
    read,
    read_vicon_rotations,
    read_xsens,
    save,
)
from kinetograph.formats.keys_json import read_keys
from kinetograph.formats.readings import read_layout, read_readings
from kinetograph.library import Library, import_annotations, read_annotations, read_times
from kinetograph.post import read_table
from kinetograph.studio.project import Project, Walk, read_project
from kinetograph.take import Take

Reader = Callable[[Path], object]

KEYS = b"""{"keys": [
 {"pose": "good.bvh@0", "time": 0, "position": [0, 0], "heading": 90, "name": "first"},
 {"pose": "good.bvh@0.1", "time": [0.5, 1.5], "roles": ["left_foot"]}
]}
"""
LAYOUT = b"""name = "wrists"
preset = "phone"
[device]
span_g = 3
bits = 8
rate = 50
[[sensor]]
name = "left"
joint = "left_elbow"
towards = "left_hand"
along = 0.8
offset = [0, 0.02, 0]
rotation = [0, 0, 1, 0]
bias = [0.1, 0, 0]
width = 0.05
"""
READINGS = b"""# worn on 3 May
t,sensor,ax,ay,az,gx,gy,gz,qw,qx,qy,qz
0,left,0,9.8,0,0,0,0.1,1,0,0,0
0.01,right,0,9.8,0,0,0,0.1,1,0,0,0
0.02,left,0.1,9.8,0,0,0,0.1,0.7071,0.7071,0,0
"""
ANNOTATIONS = b"""take,track,kind,label,start,stop
walk,motion,contact,left_foot,0.0,0.1
walk,motion,cut,,0.1,
"""
JOINTS = "# target\tsource\nHips\tpelvis\nChest\tspine one\nHead\t-\nBrazo\u00f1\tarm\n".encode()
XSENS = (
    b"// Update Rate: 100.0Hz\nPacketCounter,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Quat_q0,Quat_q1,Quat_q2,Quat_q3\n"
    + (b"1,0,9.8,0,.1,.2,.3,1,0,0,0\n2,0,9.9,0,.1,.2,.3,1,0,0,0\n")
)
VICON = b"// idx=11,13\nqhip_1,qhip_2,qhip_3,qhip_4\n1,0,0,0\n1,0,0.1,0\n"
PROJECT = msgspec.json.encode(
    Project(libraries={"walks": "walks.library"}, walk=Walk(path=((0.0, 0.0, 0.0), (1.0, 1.0, 0.0))))
)
VENDORS = {
    "mt manager": b"// Update Rate: 100.0Hz\nPacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Quat_q0,"
    b"Quat_q1,Quat_q2,Quat_q3\n1,,9.81,0.5,-1,0.1,0.2,-0.3,1,0,0,0\n2,,9.81,0.5,-1,0.1,0.2,-0.3,1,0,0,0\n",
    "movella dot": b"sep=,\nDeviceTag:,DOT\n\nPacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n"
    b"1,4294960000,9.81,0.5,-1,5.7,11.4,-17.1\n2,9371,9.81,0.5,-1,5.7,11.4,-17.1\n",
    "x-io": b"Timestamp (us),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),"
    b"Accelerometer Y (g),Accelerometer Z (g)\n1000000,5.7,11.4,-17,1,0.05,-0.1\n1002500,5.7,11.4,-17,1,0.05,-0.1\n",
    "phyphox": b'"Time (s)";"Acceleration x (m/s^2)";"Acceleration y (m/s^2)";"Acceleration z (m/s^2)"\n'
    b"0.5;9.81;0.5;-1\n0.51;9.81;0.5;-1\n",
    "sensor logger": b"time,seconds_elapsed,z,y,x\n170000000000000,0.1,-1,0.5,9.81\n170000000001000,0.2,-1,0,9\n",
    "physics toolbox": b"time,gFx,gFy,gFz\n0.1,1,0.05,-0.1\n0.12,1,0.05,-0.1\n",
}
_WORD = re.compile(rb'"[^"\n]*"|[^\s,;:=\[\]{}]+|\[[^\]\n]*\]')
INSTEAD = (
    *(b"[]", b"{}", b"[[[1]]]", b'"text"', b"null", b"true", b"nan", b"-inf", b"1e999", b"-1", b"1e308", b"2" * 5000),
    *(
        b"\xff",
        b"\xe9t\xe9",
        b"\xef\xbb\xbf",
        b"\0",
        b"\r",
        b"\n",
        b'"',
        b"'",
        b",",
        b";",
        b"\t",
        b"=",
        b"[",
        b"{",
        b".",
    ),
    *(
        b"[" * 5000,
        b'{"a":' * 5000,
        b"a=" + b"[" * 5000,
        b"\xed\xa0\x80",
        b'"\\ud800"',
        b"1979-05-27",
        b"0x10",
        b"..",
        b"@",
    ),
)


def damaged(good: bytes, rng: np.random.Generator) -> bytes:
    """A text with some words or bytes changed, another's encoding, or a part of it."""
    data = good
    for _ in range(int(rng.integers(1, 3))):
        kind = int(rng.integers(0, 6))
        if kind == 0:
            data = mutations.mutate(data, rng)
        elif kind == 1:
            data = data[: int(rng.integers(0, len(data) + 1))]
        elif kind == 2:
            at = int(rng.integers(0, len(data) + 1))
            data = data[:at] + INSTEAD[int(rng.integers(0, len(INSTEAD)))] + data[at:]
        elif kind == 3 and rng.random() < 0.2:
            coding = str(rng.choice(["utf-16", "utf-32", "utf-8-sig"]))
            data = data.decode("latin-1").encode(coding)
        else:  # a word for a word
            words = list(_WORD.finditer(data))
            if words:
                word = words[int(rng.integers(0, len(words)))]
                data = data[: word.start()] + INSTEAD[int(rng.integers(0, len(INSTEAD)))] + data[word.end() :]
    return data


def texts(folder: Path) -> dict[str, tuple[bytes, Reader]]:
    """A good text and its reader, by name; what they refer to lies in the folder."""
    save(mutations.small_motion(), folder / "good.bvh")
    library = Library.create(folder / "some.library")
    library.add(Take("walk", {"motion": mutations.small_motion(30)}))
    found: dict[str, tuple[bytes, Reader]] = {
        "keys.json": (KEYS, partial(read_keys, library=library)),
        "layout.toml": (LAYOUT, read_layout),
        "readings.csv": (READINGS, read_readings),
        "annotations.csv": (ANNOTATIONS, partial(import_annotations, library)),
        "notes.csv": (ANNOTATIONS, partial(read_annotations, take="walk")),
        "beats.txt": (b"time\n0.5\n1.0,x\n# end\n1.5\n", read_times),
        "joints.tsv": (JOINTS, read_table),
        "project.json": (PROJECT, read_project),
        "xsens.txt": (XSENS, partial(read_xsens, name="left")),
        "vicon.csv": (VICON, read_vicon_rotations),
        "path.csv": (mutations.CSV, read),
    }
    found |= {f"{name}.csv": (text, read_readings) for name, text in VENDORS.items()}
    return found


def fuzz(name: str, good: bytes, reader: Reader, folder: Path, count: int, seed: int = 0) -> tuple[int, int]:
    """Read ``count`` damaged texts: how many were still read, and how many were refused."""
    rng, path = np.random.default_rng(seed), folder / name
    fine, one_line = 0, True
    for number in range(count):
        path.write_bytes(damaged(good, rng))
        start = time.perf_counter()
        try:
            reader(path)
            fine += 1
        except KinetographError as error:
            one_line = one_line and "\n" not in str(error) and len(str(error)) < 2000
        except BaseException:
            (folder / f"failed-{name}").write_bytes(path.read_bytes())
            sys.stderr.write(f"{name}: text {number} of seed {seed} is kept in {folder}\n")
            raise
        assert time.perf_counter() - start < mutations.SLOW, f"{name} {number} is slow"
    assert one_line, f"{name}: an error of more than one line"
    return fine, count - fine


def main(count: int, only: list[str]) -> None:
    warnings.simplefilter("error")
    folder = Path(tempfile.mkdtemp())
    for name, (good, reader) in texts(folder).items():
        if only and not any(word in name for word in only):
            continue
        (folder / name).write_bytes(good)
        reader(folder / name)
        for seed in range(count // 500 or 1):
            try:
                print(name, *fuzz(name, good, reader, folder, min(count, 500), seed), flush=True)
            except Exception as error:
                last = traceback.extract_tb(error.__traceback__)
                place = [f"{f.filename.split('/src/')[-1]}:{f.lineno}" for f in last if "kinetograph" in f.filename][
                    -1:
                ]
                print(name, seed, type(error).__name__, str(error)[:120], place)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000, sys.argv[2:])
