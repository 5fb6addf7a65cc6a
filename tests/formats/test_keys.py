"""Keys as JSON and as text: parts of the body, and what each key's own file means."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.formats import KeySources, WriteOptions, key_from_text, read_keys, read_keys_from
from kinetograph.keys import PartFromRoot, PartInWorld
from kinetograph.motion import resample
from kinetograph.take import Take
from walkers import walk


@pytest.fixture
def pairs(tmp_path: Path) -> kg.Library:
    library = kg.Library.create(tmp_path / "pairs")
    library.add(Take("pair", {"slow": walk(3.0, speed=0.6), "quick": walk(3.0, speed=1.2)}))
    return library


def test_parts_are_read_from_json(tmp_path: Path):
    kg.save(walk(2.0), tmp_path / "walk.bvh")
    file = tmp_path / "keys.json"
    file.write_text(
        '{"keys": [{"pose": "walk.bvh@1", "parts": [{"role": "left_hand", "in": "root", "position": [0.2, 1.4, 0.4]},'
        ' {"role": "right_foot", "in": "world", "position": [1, 0.2, 3], "orientation": [1, 0, 0, 0]}]}]}'
    )
    (key,) = read_keys(file)
    assert key.parts == (
        PartFromRoot("left_hand", (0.2, 1.4, 0.4)),
        PartInWorld("right_foot", (1.0, 0.2, 3.0), (1.0, 0.0, 0.0, 0.0)),
    )
    file.write_text('{"keys": [{"pose": "walk.bvh@1", "parts": [{"role": "left_hand", "in": "root"}]}]}')
    with pytest.raises(RequestError, match="key 1: left_hand: expected a position, an orientation or both"):
        read_keys(file)


def test_the_track_of_a_take_is_heeded(pairs: kg.Library, tmp_path: Path):
    speeds = []
    for track in ("slow", "quick"):
        key = key_from_text("take:pair@1", "--from", KeySources(pairs, track=track))
        speeds.append(np.linalg.norm(np.diff(key.clip.translation, axis=0), axis=1).mean() * key.clip.fps)
    assert speeds == pytest.approx([0.6, 1.2], rel=0.01)
    own = key_from_text("take:pair@1; track=slow", "--from", KeySources(pairs, track="quick"))
    assert np.linalg.norm(np.diff(own.clip.translation, axis=0), axis=1).mean() * 30 == pytest.approx(0.6, rel=0.01)
    with pytest.raises(RequestError, match=r"name one of its motions \(slow, quick\)|name one of its"):
        key_from_text("take:pair@1", "--from", KeySources(pairs))
    file = tmp_path / "keys.json"
    file.write_text('{"keys": [{"pose": "take:pair@1"}, {"pose": "take:pair@2", "track": "quick"}]}')
    first, second = read_keys_from(file, KeySources(pairs, track="slow"))
    ratio = np.ptp(second.clip.translation[:, 2]) / np.ptp(first.clip.translation[:, 2])
    assert ratio == pytest.approx(2.0, rel=0.01)


def test_every_key_has_the_units_and_rate_of_its_own_file(tmp_path: Path):
    motion = walk(2.0)
    kg.save(motion, tmp_path / "metres.bvh")
    kg.save(resample(motion, 60.0), tmp_path / "inches.bvh", options=WriteOptions(units="inch"))
    file = tmp_path / "keys.json"
    file.write_text('{"keys": [{"pose": "inches.bvh@1", "units": "inch"}, {"pose": "metres.bvh@1"}]}')
    lines: list[str] = []
    inches, metres = read_keys_from(file, KeySources(note=lines.append))
    assert (inches.clip.fps, metres.clip.fps) == (pytest.approx(60.0), pytest.approx(30.0))
    pose = inches.clip.translation[inches.frame], metres.clip.translation[metres.frame]
    assert pose[0] == pytest.approx(pose[1], abs=1e-4)
    assert all(line.startswith(("key 1: ", "key 2: ")) for line in lines)


def test_a_key_is_written_in_a_line(pairs: kg.Library):
    sources = KeySources(pairs, track="slow")
    text = "take:pair@1; time=2..3; position=1,2; heading=90; roles=left_hand,right_hand; left_hand=0.2,1.4,0.4"
    key = key_from_text(f"{text}; name=reach", "--to", sources)
    assert (key.label, key.time, key.position) == ("reach", (2.0, 3.0), (1.0, 2.0))
    assert key.heading == pytest.approx(np.pi / 2)
    assert key.parts == (PartFromRoot("left_hand", (0.2, 1.4, 0.4)),)
    world = key_from_text("take:pair@1; left_hand@world=0,1,2; time=3", "--to", sources)
    assert world.parts == (PartInWorld("left_hand", (0.0, 1.0, 2.0)),)
    assert world.time == (3.0, 3.0)
    for bad, wanted in (
        ("take:pair@1; time", "--to: after its pose a key has name=value between semicolons, found 'time'"),
        ("take:pair@1; time=soon", "--to: time is numbers between commas, found 'soon'"),
        ("take:pair@1; tail=1,2,3", "no joint plays the role 'tail'"),
        ("take:pair@1; left_hand=1,2", "--to: .*length 3"),
        ("take:pair@1; left_hand@moon=1,2,3", "--to: Invalid enum value 'moon'"),
        ("pair", "--to: a pose is FILE@SECOND or take:NAME@SECOND"),
    ):
        with pytest.raises(RequestError, match=wanted):
            key_from_text(bad, "--to", sources)
