"""Protocols of devices: bytes packed here from the published layouts, and bytes that are damaged."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.live.rows import ArrivalClock, Gathering, Row
from kinetograph.live.sources import mocopi, mvn, parse_source, phone, sensorserver, slimevr, speed_of
from kinetograph.sensing import GRAVITY

# ---- SlimeVR ----


def _slime(kind: int, contents: bytes) -> bytes:
    return struct.pack(">iq", kind, 1) + contents


def test_a_tracker_at_rest_reads_gravity_upwards_however_it_is_turned() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        q = rot.normalize(rng.normal(size=4))
        w, x, y, z = q
        trackers = slimevr.Trackers("hip")
        assert trackers.receive(_slime(17, struct.pack(">BB4fB", 2, 1, x, y, z, w, 0))) == ([], [])
        (row,), _ = trackers.receive(_slime(4, struct.pack(">3fB", 0.0, 0.0, 0.0, 2)))
        assert row.sensor == "hip.2"
        assert row.orientation is not None
        up = rot.rotate(np.array(row.orientation), np.array(row.force))
        assert np.allclose(up, [0.0, GRAVITY, 0.0], atol=1e-5)  # in the world, Y up


@pytest.mark.parametrize("compact", [False, True])
def test_bundles_hold_rotation_and_acceleration_of_several_sensors(compact: bool) -> None:
    contents = [struct.pack(">B7h", s, 0, 0, 0, 32767, 128 * s, 0, -64) for s in (1, 2)]
    if compact:
        inner = b"".join(bytes([len(c) + 1, 23]) + c for c in contents)
        data = _slime(101, inner)
    else:
        inner = b"".join(struct.pack(">hi", len(c) + 4, 23) + c for c in contents)
        data = _slime(100, inner)
    rows, _ = slimevr.Trackers("t").receive(data)
    assert [row.sensor for row in rows] == ["t.1", "t.2"]
    assert np.allclose([row.force for row in rows], [[1, 0, GRAVITY - 0.5], [2, 0, GRAVITY - 0.5]], atol=1e-3)


def test_handshakes_are_answered_and_name_their_hardware() -> None:
    data = _slime(3, struct.pack(">7i", 0, 0, 0, 0, 0, 0, 17) + b"\x050.4.0" + bytes(range(6)))
    _, answers = slimevr.Trackers("t").receive(data)
    assert answers[0][:13] == b"\x03Hey OVR =D 5"
    assert len(answers[0]) == 64
    assert slimevr.hardware_address(data) == "000102030405"


# ---- MVN ----


def _mvn(kind: int, items: list[bytes], milliseconds: int = 1500) -> bytes:
    body = b"".join(items)
    tail = struct.pack(">BBBHH", 23, 0, 0, 0, len(body))
    head = b"MXTP%02d" % kind + struct.pack(">IBBIB", 7, 0x80, len(items), milliseconds, 0) + tail
    assert len(head) == 24
    return head + body


@pytest.mark.parametrize("newer", [False, True])
def test_mvn_trackers_read_gravity_upwards_at_rest(newer: bool) -> None:
    q = rot.multiply(rot.about("x", 0.7), rot.about("z", 1.9))
    force = rot.rotate(rot.conjugate(q), np.array([0.0, 0.0, GRAVITY]))  # their world has Z up
    values = [*q, 0, 0, 0, *([*force, 0.1, 0.2, 0.3] if newer else []), 1, 0, 0]
    data = _mvn(23, [struct.pack(f">i{len(values)}f", 11, *values)])
    (row,) = mvn.trackers(data)
    assert (row.sensor, row.time) == ("RightHand", 1.5)
    assert np.allclose(row.force, force, atol=1e-5)
    assert np.allclose(rot.rotate(np.array(row.orientation), np.array(row.force)), [0, GRAVITY, 0], atol=1e-4)
    assert (row.angular is not None) == newer


def test_mvn_segments_walk_forward_along_z_with_y_up() -> None:
    ahead = struct.pack(">i7f", 1, 2.0, 0.5, 0.9, *rot.about("z", np.pi / 2))  # 2 m ahead, facing left
    (pelvis,) = mvn.segments(_mvn(2, [ahead]))
    assert pelvis.name == "Pelvis"
    assert np.allclose(pelvis.position, [0.5, 0.9, 2.0], atol=1e-6)
    assert np.allclose(rot.rotate(pelvis.rotation, np.array([0.0, 0.0, 1.0])), [1.0, 0.0, 0.0], atol=1e-6)


# ---- mocopi ----


def _chunk(name: str, contents: bytes) -> bytes:
    return struct.pack("<I4s", len(contents), name.encode()) + contents


def _mocopi_transform(q: np.ndarray, p: np.ndarray) -> bytes:
    return _chunk("tran", struct.pack("<7f", q[1], q[2], q[3], q[0], *p))


_MOCOPI_PARENTS = [-1, *range(10), 7, 11, 12, 13, 7, 15, 16, 17, 0, 19, 20, 21, 0, 23, 24, 25]


def _mocopi(kind: str, offsets: np.ndarray, rotations: np.ndarray | None = None, number: int = 5) -> bytes:
    head = _chunk("head", _chunk("ftyp", b"sony motion format") + _chunk("vrsn", b"\x01"))
    sender = _chunk("sndf", _chunk("ipad", bytes(8)) + _chunk("rcvp", struct.pack("<H", 12351)))
    if kind == "skdf":
        bones = b"".join(
            _chunk(
                "bndt",
                _chunk("bnid", struct.pack("<H", i))
                + _chunk("pbid", struct.pack("<h", _MOCOPI_PARENTS[i]))
                + _mocopi_transform(rot.identity(), offsets[i]),
            )
            for i in range(27)
        )
        return head + sender + _chunk("skdf", _chunk("bons", bones))
    assert rotations is not None
    bones = b"".join(
        _chunk("btdt", _chunk("bnid", struct.pack("<H", i)) + _mocopi_transform(rotations[i], offsets[i]))
        for i in range(27)
    )
    clock = _chunk("fnum", struct.pack("<I", number)) + _chunk("time", struct.pack("<I", 0))
    return head + sender + _chunk("fram", clock + _chunk("uttm", struct.pack("<d", 1.7e9)) + _chunk("btrs", bones))


def test_mocopi_frames_are_as_long_as_the_app_sends_them_and_come_back() -> None:
    rng = np.random.default_rng(1)
    offsets, rotations = rng.normal(size=(27, 3)), rot.normalize(rng.normal(size=(27, 4)))
    described, frame = _mocopi("skdf", offsets), _mocopi("fram", offsets, rotations)
    assert (len(described), len(frame)) == (1821, 1591)  # what was captured from the app
    receiver = mocopi.Receiver()
    assert receiver.receive(frame) is None  # no skeleton yet
    assert receiver.receive(described) is None
    time, motion = receiver.receive(frame) or (None, None)
    assert time == 1.7e9
    assert motion is not None
    assert np.abs((motion.rotations[0] * rotations).sum(axis=1)).min() > 1 - 1e-6
    assert np.allclose(motion.translation[0], offsets[0], atol=1e-6)
    assert motion.skeleton.parents.tolist() == _MOCOPI_PARENTS
    assert "left_knee" in motion.skeleton.roles


# ---- phones ----


def test_sensorserver_messages_become_rows_with_the_latest_rates() -> None:
    receiver = sensorserver.Phone("right_wrist")
    turn = {"type": sensorserver.GYROSCOPE, "values": [0.1, 0.2, 0.3], "timestamp": 1_000_000_000, "accuracy": 3}
    lift = {"type": sensorserver.ACCELEROMETER, "values": [0.0, 9.8, 0.1], "timestamp": 1_010_000_000, "accuracy": 3}
    assert receiver.receive(json.dumps(turn)) == []
    (row,) = receiver.receive(json.dumps(lift))
    assert row == Row("right_wrist", 1.01, (0.0, 9.8, 0.1), (0.1, 0.2, 0.3))


def test_a_phone_says_where_it_is_worn() -> None:
    (row,) = phone.rows(json.dumps({"sensor": "left_wrist", "t": 2.5, "force": [0, 0, 9.8], "rate": None}))
    assert row == Row("left_wrist", 2.5, (0.0, 0.0, 9.8), None)


# ---- damage ----


_WHOLE = [
    _slime(23, struct.pack(">B7h", 1, 0, 0, 0, 32767, 1, 2, 3)),
    _slime(100, struct.pack(">hi", 19, 23) + struct.pack(">B7h", 1, 0, 0, 0, 32767, 1, 2, 3)),
    _mvn(23, [struct.pack(">i16f", 11, 1, *[0.0] * 15)] * 3),
    _mvn(2, [struct.pack(">i7f", 1, 0, 0, 0, 1, 0, 0, 0)]),
    _mocopi("skdf", np.ones((27, 3))),
    _mocopi("fram", np.ones((27, 3)), rot.identity(27)),
    json.dumps({"sensor": "a", "t": 1.0, "force": [0, 0, 9.8], "rate": [0, 0, 0]}).encode(),
    json.dumps({"type": sensorserver.ACCELEROMETER, "values": [0, 0, 1], "timestamp": 5}).encode(),
]


def test_ten_thousand_damaged_packets_of_each_source_raise_nothing() -> None:
    rng = np.random.default_rng(2)
    trackers, receiver, server = slimevr.Trackers("t"), mocopi.Receiver(), sensorserver.Phone("p")
    for whole in _WHOLE:
        for _ in range(10_000 // len(_WHOLE) + 1):
            data = bytearray(whole)
            for _ in range(rng.integers(1, 9)):
                data[rng.integers(len(data))] = rng.integers(256)
            damaged = bytes(data[: rng.integers(len(data) + 1)]) if rng.random() < 0.5 else bytes(data)
            for row in [*trackers.receive(damaged)[0], *mvn.trackers(damaged), *phone.rows(damaged)]:
                Gathering().add("d", row, 1.0)
            mvn.segments(damaged)
            receiver.receive(damaged)
            server.receive(damaged)
    assert len(trackers._rotations) <= 256  # what is kept is bounded


@given(st.binary(max_size=300))
def test_any_bytes_raise_nothing(data: bytes) -> None:
    slimevr.Trackers("t").receive(data)
    mvn.trackers(data)
    mvn.segments(data)
    mocopi.Receiver().receive(data)
    phone.rows(data)
    sensorserver.Phone("p").receive(data)


def test_deeply_nested_messages_raise_nothing() -> None:
    assert phone.rows("[" * 100_000) == []
    assert sensorserver.Phone("p").receive("[" * 100_000) == []


# ---- clocks and gathering ----


def test_rows_are_put_where_they_were_taken_although_the_network_delays_them() -> None:
    rng = np.random.default_rng(3)
    clock = ArrivalClock()
    sent = np.arange(3000) / 100.0
    arrived = sent + 1234.5 + rng.exponential(0.02, len(sent))
    times = np.array([clock(s, a) for s, a in zip(sent, arrived, strict=True)])
    assert np.all(np.diff(times) > 0)
    assert np.abs(times[300:] - (sent[300:] + 1234.5)).max() < 0.004
    assert clock.resets == 0


def test_a_clock_that_is_set_by_a_second_is_followed() -> None:
    clock = ArrivalClock()
    for i in range(500):
        clock(i / 100.0, 50.0 + i / 100.0)
    times = [clock(i / 100.0 - 1.0, 50.0 + i / 100.0) for i in range(500, 1000)]
    assert clock.resets == 1
    assert np.allclose(times, 50.0 + np.arange(500, 1000) / 100.0, atol=1e-9)


def test_rows_that_come_in_a_burst_after_the_network_stalled_are_all_taken() -> None:
    gathering = Gathering()
    sent = np.arange(6000) / 100.0
    arrived = np.maximum(sent + 0.01, np.where((sent > 20) & (sent < 35), 35.0, 0.0))  # nothing comes for 15 seconds
    taken = [gathering.add("d", Row("a", s, (0.0, 9.8, 0.0)), a) for s, a in zip(sent.tolist(), arrived, strict=True)]
    times = np.array([time for _, time, _ in gathering.rows()])
    assert all(taken)
    assert np.abs(times[-2000:] - sent[-2000:] - 0.01).max() < 0.01  # four seconds after the burst at the latest
    assert np.all(np.diff(times) > 0)


def test_gathering_leaves_out_what_is_late_damaged_or_of_strangers() -> None:
    gathering = Gathering(("wrist",), {"mac.0": "wrist"})
    up = (0.0, 9.8, 0.0)
    assert gathering.add("d", Row("mac.0", 1.0, up), 10.0)
    assert not gathering.add("d", Row("mac.0", 0.5, up), 10.1)
    assert not gathering.add("d", Row("mac.0", 2.0, (np.nan, 0.0, 0.0)), 11.0)
    assert not gathering.add("d", Row("mac.1", 2.0, up), 11.0)
    readings = gathering.take()
    assert readings is not None
    assert (readings.names, len(readings)) == (("wrist",), 1)
    assert gathering.heard["wrist"].late == 1
    assert gathering.strangers == {"mac.1": 1}
    assert gathering.take() is None


# ---- what people write ----


def test_sources_listen_on_the_loopback_unless_another_address_is_named() -> None:
    assert parse_source("mvn://").name == "mvn://127.0.0.1:9763"
    assert parse_source("mocopi://0.0.0.0:5000").name == "mocopi://0.0.0.0:5000"
    assert parse_source("sensorserver://10.0.0.5/left_wrist").name == "sensorserver://10.0.0.5:8080/left_wrist"


@pytest.mark.parametrize("text", ["bluetooth://x", "slimevr://:99999", "replay:a.csv@-1", "replay:a.csv@0"])
def test_sources_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(RequestError, match="expected"):
        parse_source(text)


def test_sources_of_two_speeds_are_refused() -> None:
    with pytest.raises(RequestError, match="one speed"):
        speed_of([parse_source("replay:a.csv@2"), parse_source("mvn://")])
