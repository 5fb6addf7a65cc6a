"""Live sessions on the loopback: what a session adds to the time that a method waits, and whether frames are dropped.

``python -m benchmarks sessions`` replays a minute, and ten minutes at four times the speed; with an hour as argument of
`endurance` it takes as long as that.
"""

from __future__ import annotations

import asyncio
import socket
import struct
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph.formats import ReadOptions
from kinetograph.library import Library
from kinetograph.live import Clock, SensorDriver, Session, parse_sink
from kinetograph.live.items import Deliver, Item
from kinetograph.live.rows import Row
from kinetograph.methods.sensor import SensorControl, SensorModel
from kinetograph.motion import Motion, resample
from kinetograph.pipeline import read_take
from kinetograph.samples import fetch
from kinetograph.sensing import preset, simulate


def main() -> None:
    model, motion = _model()
    latency(model, motion)
    endurance(model, motion)


def latency(model: SensorModel, motion: Motion, seconds: float = 60.0) -> None:
    """Milliseconds from the row that settles a frame to the frame's arrival at another socket."""
    rows = _rows(motion, seconds)
    settles = _settling(model, rows)
    source, receiver = _Rows(rows), _Receiver()
    session = Session([source], SensorDriver(model), [parse_sink(f"vmc://127.0.0.1:{receiver.port}")], Clock(), print)
    session.say = lambda _: None
    asyncio.run(session.run())
    receiver.close()
    late = [
        1000 * (arrived - source.delivered[settles[frame]])
        for frame, arrived in receiver.arrived.items()
        if frame < len(settles)
    ]
    p50, p99 = np.quantile(late, [0.5, 0.99])
    missing = session.frames - len(receiver.arrived)
    print(
        f"8 sensors at 100 Hz to VMC, {seconds:.0f} s: added p50 {p50:.1f} ms, p99 {p99:.1f} ms; {missing} frames lost"
    )


def endurance(model: SensorModel, motion: Motion, seconds: float = 600.0, speed: float = 4.0) -> None:
    """Frames that are dropped, and the memory that is used, over a long session with losses and silences."""
    source, receiver = _Rows(_rows(motion, seconds), speed, loss=0.3), _Receiver()
    sinks = [parse_sink(f"vmc://127.0.0.1:{receiver.port}")]
    session = Session([source], SensorDriver(model), sinks, Clock(speed), lambda _: None)
    before = _memory()
    asyncio.run(session.run())
    receiver.close()
    due = seconds * model.method.rate
    print(
        f"{seconds:.0f} s at {speed:g} times the speed, 30 % of the rows lost: {session.frames} frames made of "
        f"{due:.0f} due, {len(receiver.arrived)} arrived; memory +{_memory() - before:.0f} MB"
    )


def _model() -> tuple[SensorModel, Motion]:
    """A model, and a motion that it has not seen."""
    folder = data_folder()
    if folder is not None:
        files = sorted((folder / "sports").glob("64_0*_amass30.bvh"))
    else:
        files = [fetch("deepmimic-clips") / f"humanoid3d_{name}.txt" for name in ("run", "jump", "walk")]
    takes = [read_take(path, ReadOptions())[0] for path in files]
    with tempfile.TemporaryDirectory() as scratch:
        library = Library.create(Path(scratch) / "library")
        for take in takes[:-1]:
            library.add(take)
        model = SensorControl(layout=preset("ideal")).fit(library)
    return model, resample(takes[-1].motion(), 60.0)


def _rows(motion: Motion, seconds: float) -> list[Row]:
    """What eight sensors measure, the motion again and again."""
    readings = simulate(motion, preset("ideal"), np.random.default_rng(0))
    period, rows = motion.duration + 0.01, []
    for k in range(int(np.ceil(seconds / period))):
        rows += [
            Row(readings.names[s], t + k * period, (f[0], f[1], f[2]))
            for s, t, f in zip(readings.sensors.tolist(), readings.times.tolist(), readings.force.tolist(), strict=True)
        ]
    return [row for row in rows if (row.time or 0.0) <= seconds]


def _settling(model: SensorModel, rows: Sequence[Row]) -> list[int]:
    """The row that settles each frame, where every row arrives at its time."""
    from kinetograph.live.rows import Gathering

    names = model.fitted.examples.names
    live, settled = model.start(keep=False), list[int]()
    gathering = Gathering(names)
    for i, row in enumerate(rows):
        gathering.add("d", row, row.time or 0.0)
        readings = gathering.take()
        assert readings is not None
        settled += [i] * len(live.step(readings))
    return settled


@dataclass
class _Rows:
    """Rows at their times."""

    rows: Sequence[Row]
    speed: float = 1.0
    loss: float = 0.0
    name: str = "rows"
    delivered: list[float] = field(default_factory=list)

    def prepare(self) -> None:
        """Nothing takes long."""

    async def run(self, deliver: Deliver) -> None:
        """Hand on each row at its time."""
        began, rng, at = time.monotonic(), np.random.default_rng(0), 0
        while at < len(self.rows):
            due, batch = (time.monotonic() - began) * self.speed, list[Item]()
            while at < len(self.rows) and (self.rows[at].time or 0.0) <= due:
                if self.loss == 0.0 or rng.random() > self.loss:
                    batch.append(self.rows[at])
                at += 1
            self.delivered += [time.monotonic()] * (at - len(self.delivered))
            if batch:
                deliver("rows", batch)
            await asyncio.sleep(0.001)


class _Receiver:
    """Takes VMC on a thread of its own, and notes when each frame came."""

    def __init__(self) -> None:
        self.arrived: dict[int, float] = {}
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2**22)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.5)
        self._open = True
        self.port = self._socket.getsockname()[1]
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()

    def _listen(self) -> None:
        while self._open:
            try:
                data = self._socket.recv(2000)
            except TimeoutError:
                continue
            for seconds in _times(data):
                self.arrived.setdefault(round(seconds * 60), time.monotonic())

    def close(self) -> None:
        time.sleep(0.6)
        self._open = False
        self._thread.join()
        self._socket.close()


def _times(data: bytes) -> Iterator[float]:
    """The times of a bundle's messages ``/VMC/Ext/T``."""
    at = data.find(b"/VMC/Ext/T\0")
    if at >= 0:
        yield struct.unpack_from(">f", data, at + 16)[0]


def _memory() -> float:
    """Megabytes that are in use."""
    with Path("/proc/self/status").open() as file:
        return next(int(line.split()[1]) / 1024 for line in file if line.startswith("VmRSS"))
