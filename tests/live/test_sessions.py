"""Whole sessions on the loopback: files as devices, an emulated tracker that is not ours, a process that is killed."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pythonosc.osc_bundle import OscBundle
from websockets.asyncio.server import serve

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.formats import ReadOptions, load
from kinetograph.formats.bvh import GrowingBvh
from kinetograph.formats.deepmimic import skeleton as deepmimic
from kinetograph.formats.readings import read_readings, write_readings
from kinetograph.library import Library
from kinetograph.live import Clock, ListenDriver, RecordDriver, SensorDriver, Session, parse_sink, parse_source
from kinetograph.live.items import Item
from kinetograph.live.rows import Row
from kinetograph.methods.sensor import SensorControl, SensorModel
from kinetograph.motion import Motion
from kinetograph.pipeline import read_take
from kinetograph.sensing import GRAVITY, Readings, preset, select_rows, simulate


@pytest.fixture(scope="module")
def model(clips_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> SensorModel:
    library = Library.create(tmp_path_factory.mktemp("live") / "library")
    for name in ("run", "jump", "walk"):
        library.add(read_take(clips_folder / f"humanoid3d_{name}.txt", ReadOptions())[0])
    return SensorControl(layout=preset("ideal")).fit(library)


@pytest.fixture(scope="module")
def readings(clips_folder: Path) -> Readings:
    run = load(clips_folder / "humanoid3d_jump.txt").motion()
    return simulate(run, preset("ideal"), np.random.default_rng(0))


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_replayed_readings_become_frames_for_a_program_and_a_file(model, readings, tmp_path) -> None:
    write_readings(readings, tmp_path / "r.csv")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2**22)
        receiver.setblocking(False)
        sinks = [parse_sink(f"vmc://127.0.0.1:{receiver.getsockname()[1]}"), parse_sink(str(tmp_path / "o.bvh"))]
        said: list[str] = []
        session = Session(
            [parse_source(f"replay:{tmp_path}/r.csv@4")], SensorDriver(model), sinks, Clock(4.0), said.append
        )
        asyncio.run(session.run())
        times = []
        while True:
            try:
                packet = receiver.recv(2000)
            except BlockingIOError:
                break
            times += [one.params[0] for one in OscBundle(packet) if one.address == "/VMC/Ext/T"]
    assert session.frames >= readings.duration * model.method.rate - 2
    assert len(times) == session.frames  # none is dropped
    assert np.allclose(np.diff(times), 1 / model.method.rate, atol=1e-4)
    written = load(tmp_path / "o.bvh").motion()
    assert len(written) == session.frames
    assert {f"{name}: heard" for name in readings.names} == {line.split(" at ")[0] for line in said if "heard" in line}


def test_the_same_poses_come_live_as_for_the_whole_recording(model, readings, tmp_path) -> None:
    whole = model.synthesize(readings).motion
    driver = SensorDriver(model)
    frames: list[Motion] = []
    for chunk in np.array_split(np.arange(len(readings)), 40):
        part = select_rows(readings, chunk)
        now = float(part.times[-1])
        rows = [
            Row(part.names[s], t, tuple(f))  # type: ignore[arg-type]
            for s, t, f in zip(part.sensors, part.times.tolist(), part.force.tolist(), strict=True)
        ]
        for row in rows:
            driver.gathering.add("one clock", row, row.time or 0.0)
        frames += driver.advance(now)
    frames += driver.rest()
    rotations = np.concatenate([frame.rotations for frame in frames])
    common = min(len(rotations), len(whole))
    assert common >= len(whole) - 1
    # planted feet are held in the whole afterwards: arms are the same
    arm = whole.skeleton.landmark("left_elbow").joint
    apart = rot.angle_between(rotations[:common, arm], whole.rotations[:common, arm])
    assert apart.max() < 1e-6


def test_units_that_cannot_be_are_refused_as_they_come(model, readings) -> None:
    in_g = replace(readings, force=readings.force / GRAVITY)
    with pytest.raises(RequestError, match=r"is it in g\? multiply by 9.81"):
        model.start(keep=False).step(in_g)
    driver = SensorDriver(model)
    for i, at in enumerate(in_g.times.tolist()):
        row = Row(in_g.names[in_g.sensors[i]], at, tuple(in_g.force[i].tolist()))
        driver.gathering.add("d", row, at)
        if i % 50 == 49:
            driver.advance(at)
    assert len([note for note in driver.notes() if "multiply by 9.81" in note]) == 1


def test_silence_holds_the_pose_with_growing_uncertainty_and_memory_stays_flat(model, readings) -> None:
    live = model.start(keep=False)
    live.step(readings)
    first = live.wait(readings.duration + 0.5)
    poses = [pose for k in range(20) for pose in live.wait(readings.duration + 1.0 + k)]
    assert poses[-1].uncertainty.mean() > first[-1].uncertainty.mean()
    assert np.abs(poses[-1].rotations - poses[-30].rotations).max() < 1e-6
    assert len(live._kept) == 0


def test_a_tracker_emulator_that_is_not_ours_is_heard() -> None:
    emulator = pytest.importorskip("slimevr_tracker_emulator.async_tracker_emulator")
    kinds = pytest.importorskip("slimevr_tracker_emulator.tracker_types")
    port = _free_port()
    items: list[Item] = []

    async def run() -> None:
        source = parse_source(f"slimevr://127.0.0.1:{port}")
        listening = asyncio.create_task(source.run(lambda _, more: items.extend(more)))
        await asyncio.sleep(0.2)
        tracker = emulator.SlimeVRTrackerEmulatorAsync()
        half = float(np.sqrt(0.5))
        await tracker.set_tracker(
            kinds.SensorData(
                3,
                kinds.SensorState.SENSOR_OK,
                kinds.ImuType.BNO080,
                kinds.SensorRotationQuat(half, 0.0, 0.0, half),
                kinds.SensorAcceleration(1.0, 0.0, 0.0),
                kinds.SensorPosition(0.0, 0.0, 0.0),
            )
        )
        sending = asyncio.create_task(tracker.run(("127.0.0.1", port)))
        for _ in range(100):
            await asyncio.sleep(0.05)
            if items:
                break
        for task in (sending, listening):
            task.cancel()
        await asyncio.gather(sending, listening, return_exceptions=True)
        tracker.sock.close()

    asyncio.run(run())
    row = items[0]
    assert isinstance(row, Row)
    assert row.sensor.endswith(".3")
    # turned by 90 degrees about x, its y points up in a world with Z up
    assert row.force == pytest.approx((1.0, GRAVITY, 0.0), abs=1e-4)


def test_sensorserver_is_heard_and_connected_to_again() -> None:
    items: list[Item] = []
    connections = []

    async def answer(connection) -> None:  # type: ignore[no-untyped-def]
        connections.append(connection.request.path)
        for i in range(5):
            kind = "android.sensor.accelerometer"
            message = {"type": kind, "values": [0.0, 0.0, 9.8], "timestamp": (len(items) + i) * 10_000_000}
            await connection.send(json.dumps(message))
        # and hangs up

    async def run() -> None:
        async with serve(answer, "127.0.0.1", 0) as server:
            port = next(iter(server.sockets)).getsockname()[1]
            source = parse_source(f"sensorserver://127.0.0.1:{port}/chest")
            listening = asyncio.create_task(source.run(lambda _, more: items.extend(more)))
            for _ in range(200):
                await asyncio.sleep(0.05)
                if len(connections) > 1 and len(items) > 5:
                    break
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)

    asyncio.run(run())
    assert len(connections) > 1
    assert {row.sensor for row in items if isinstance(row, Row)} == {"chest"}
    assert connections[0].startswith("/sensors/connect?types=")


def test_recorded_rows_are_the_rows_that_were_sent(readings, tmp_path) -> None:
    write_readings(readings, tmp_path / "sent.csv")
    driver = RecordDriver(tmp_path / "heard.csv")
    session = Session([parse_source(f"replay:{tmp_path}/sent.csv@8")], driver, [], Clock(8.0), lambda _: None)
    asyncio.run(session.run())
    heard, _ = read_readings(tmp_path / "heard.csv")
    assert len(heard) == len(readings)
    for name in readings.names:
        ours = heard.force[heard.sensors == heard.names.index(name)]
        theirs = readings.force[readings.sensors == readings.names.index(name)]
        assert np.allclose(ours, theirs, atol=1e-6)


def test_devices_says_rate_and_loss(readings) -> None:
    driver = ListenDriver()
    rng = np.random.default_rng(0)
    for i in range(1000):
        if rng.random() > 0.3:
            driver.take("d", [Row("a", i / 100.0, (0.0, 9.81, 0.0))], i / 100.0)
    driver.rest()
    (row,) = driver.table(10.0)
    assert (row["sensor"], row["Hz"], row["force"]) == ("a", 100.0, 9.81)
    assert str(row["lost"]) in {f"{share}%" for share in range(26, 35)}


def test_a_bvh_that_grows_is_whole_when_its_process_is_killed(tmp_path) -> None:
    program = f"""
import sys, time
import numpy as np
from kinetograph import rotations as rot
from kinetograph.formats.bvh import GrowingBvh
from kinetograph.formats.deepmimic import skeleton
from kinetograph.motion import Motion
body = skeleton()
file = GrowingBvh({str(tmp_path / "o.bvh")!r}, body, 30.0)
for i in range(100_000):
    q = rot.identity(1, len(body)); q[0, 0] = rot.about("y", i / 100)
    file.add(Motion(body, np.full((1, 3), i / 1000), q, 30.0))
    if i == 300:
        print("ready", flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.2)
        os.kill(process.pid, signal.SIGKILL)
    motion = load(tmp_path / "o.bvh").motion()
    assert len(motion) >= 300
    assert len(motion) % 30 == 0
    assert np.allclose(motion.translation[:, 0] * (len(motion) > 0), np.arange(len(motion)) / 1000, atol=1e-6)
    angle = rot.angle_between(motion.rotations[-1, 0], rot.about("y", (len(motion) - 1) / 100))
    assert float(angle) < 1e-6


def test_a_file_that_grows_has_no_leaps_of_angles(tmp_path) -> None:
    body = deepmimic()
    file = GrowingBvh(tmp_path / "o.bvh", body, 30.0)
    for i in range(200):
        q = rot.identity(1, len(body))
        q[0, 0] = rot.about("z", i * 0.1)
        file.add(Motion(body, np.zeros((1, 3)), q, 30.0))
    file.close()
    rows = [line.split() for line in (tmp_path / "o.bvh").read_text().split("Frame Time")[1].splitlines()[1:]]
    first = np.array([float(row[3]) for row in rows])
    assert np.abs(np.diff(first)).max() < 6.0


def test_time_stands_still_while_the_machine_sleeps() -> None:
    now = [0]
    clock = Clock(1.0, lambda: now[0])
    clock.start()
    now[0] += 3_600_000_000_000
    assert clock.now() == 5.0
    now[0] += 1_000_000_000
    assert clock.now() == 6.0
