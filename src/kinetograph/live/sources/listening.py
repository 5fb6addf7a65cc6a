"""Where a stream comes from: a text such as ``slimevr://:6969`` becomes a source, which is listened to.

A source turns bytes into items by the pure functions of its protocol, and hands them on; what is damaged is left out.
It listens on the loopback unless its text names another address.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol, cast
from urllib.parse import urlsplit

from kinetograph.errors import RequestError
from kinetograph.live.items import LOOPBACK, Deliver, Frame, Item, Point
from kinetograph.live.sources import mocopi, mvn, phone, sensorserver, slimevr

_LARGEST = 8192  # bytes of a message
_TRACKERS = 64  # addresses that are answered
_BEAT = 1.0  # seconds between heartbeats


class StreamSource(Protocol):
    """Something to listen to."""

    @property
    def name(self) -> str:
        """What it is called in messages."""
        ...

    def prepare(self) -> None:
        """Do what takes long, before the session's time begins."""
        ...

    async def run(self, deliver: Deliver) -> None:
        """Hand on what arrives, until it is cancelled or nothing more will come.

        Raises
        ------
        RequestError
            Where it cannot be listened to.
        """
        ...


@dataclass(frozen=True)
class Udp:
    """Datagrams of one of the protocols.

    Parameters
    ----------
    scheme : {"slimevr", "mvn", "mocopi"}
    host : str
        The address to listen on.
    port : int
    """

    scheme: str
    host: str
    port: int

    @property
    def name(self) -> str:
        """The scheme, address and port."""
        return f"{self.scheme}://{self.host}:{self.port}"

    def prepare(self) -> None:
        """Nothing takes long."""

    async def run(self, deliver: Deliver) -> None:
        """Hand on rows, or frames of mocopi's."""
        receiver = _RECEIVERS[self.scheme](deliver)
        loop = asyncio.get_running_loop()
        try:
            transport, _ = await loop.create_datagram_endpoint(lambda: receiver, local_addr=(self.host, self.port))
        except OSError as error:
            raise RequestError(f"{self.name}: cannot listen there: {error.strerror or error}") from None
        try:
            while True:
                await asyncio.sleep(_BEAT)
                receiver.beat()
        finally:
            transport.close()


class _Receiver(asyncio.DatagramProtocol):
    """Hands on what datagrams say."""

    def __init__(self, deliver: Deliver) -> None:
        self.deliver = deliver
        self.transport: asyncio.DatagramTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast("asyncio.DatagramTransport", transport)  # no subclass of it, in the standard loop

    def beat(self) -> None:
        """Called about once a second."""


class _SlimeVr(_Receiver):
    def __init__(self, deliver: Deliver) -> None:
        super().__init__(deliver)
        self.trackers: dict[tuple[str, int], slimevr.Trackers] = {}

    def datagram_received(self, data: bytes, address: tuple[str, int]) -> None:
        assert self.transport is not None
        if address not in self.trackers:
            if len(self.trackers) >= _TRACKERS:
                return
            hardware = slimevr.hardware_address(data) or f"{address[0]}-{address[1]}".replace(".", "-")
            self.trackers[address] = slimevr.Trackers(f"slimevr.{hardware}")
        trackers = self.trackers[address]
        rows, answers = trackers.receive(data)
        for answer in answers:
            self.transport.sendto(answer, address)
        if rows:
            self.deliver(trackers.name, rows)

    def beat(self) -> None:
        assert self.transport is not None
        for address in self.trackers:
            self.transport.sendto(slimevr.heartbeat(), address)


class _Mvn(_Receiver):
    def datagram_received(self, data: bytes, address: tuple[str, int]) -> None:
        if rows := mvn.trackers(data):
            self.deliver("mvn", rows)
        elif parts := mvn.segments(data):
            head = mvn.head(data)
            pelvis = next((part for part in parts if part.name == "Pelvis"), None)
            if pelvis is not None and head is not None:
                self.deliver("mvn", [Point(head.time, pelvis.position)])


class _Mocopi(_Receiver):
    def __init__(self, deliver: Deliver) -> None:
        super().__init__(deliver)
        self.receiver = mocopi.Receiver()

    def datagram_received(self, data: bytes, address: tuple[str, int]) -> None:
        found = self.receiver.receive(data)
        if found is not None:
            self.deliver("mocopi", [Frame(*found)])


_RECEIVERS: dict[str, Callable[[Deliver], _Receiver]] = {"slimevr": _SlimeVr, "mvn": _Mvn, "mocopi": _Mocopi}
_PORTS = {"slimevr": slimevr.PORT, "mvn": mvn.PORT, "mocopi": mocopi.PORT, "sensorserver": sensorserver.PORT}


@dataclass(frozen=True)
class SensorServer:
    """An Android phone that runs SensorServer.

    Parameters
    ----------
    host : str
    port : int
    sensor : str
        What its sensor is called.
    """

    host: str
    port: int
    sensor: str

    @property
    def name(self) -> str:
        """The address and the sensor."""
        return f"sensorserver://{self.host}:{self.port}/{self.sensor}"

    def prepare(self) -> None:
        """Nothing takes long."""

    async def run(self, deliver: Deliver) -> None:
        """Hand on rows, and connect again where the connection is lost."""
        client = _websockets_client()
        receiver = sensorserver.Phone(self.sensor)
        address = sensorserver.address(self.host, self.port)
        async for socket in client.connect(address, max_size=_LARGEST, open_timeout=5, compression=None):
            try:
                async for message in socket:
                    if rows := receiver.receive(message):
                        deliver(self.name, rows)
            except client.ConnectionClosed:
                continue


@dataclass(frozen=True)
class PhonePage:
    """Phones that open a page of ours.

    Parameters
    ----------
    host : str
        The address to listen on; all but the loopback are served by HTTPS.
    port : int
    sensors : tuple of str
        Where a phone may be worn.
    announce : callable
        Takes the link to open.
    """

    host: str
    port: int
    sensors: tuple[str, ...] = ()
    announce: Callable[[str], None] = field(default=print)

    @property
    def name(self) -> str:
        """The address."""
        return f"phone://{self.host}:{self.port}"

    def prepare(self) -> None:
        """Nothing takes long."""

    async def run(self, deliver: Deliver) -> None:
        """Serve the page, and hand on what phones send back."""
        from kinetograph.live.sources.phone_server import serve

        await serve(self.host, self.port, self.sensors, deliver, self.announce)


@dataclass(frozen=True)
class Replay:
    """A file, as if it arrived now.

    Parameters
    ----------
    path : Path
        Readings, a path, or a motion.
    speed : float
        Times as fast.
    """

    path: Path
    speed: float = 1.0

    @property
    def name(self) -> str:
        """The file's name."""
        return f"replay:{self.path.name}"

    def prepare(self) -> None:
        """Read the file."""
        _ = self._items

    @cached_property
    def _items(self) -> list[Item]:
        from kinetograph.live.sources.replay import items_of

        return items_of(self.path)

    async def run(self, deliver: Deliver) -> None:
        """Hand on each row, point or frame at its time."""
        loop = asyncio.get_running_loop()
        items = self._items
        began = loop.time()
        at = 0
        while at < len(items):
            due = (loop.time() - began) * self.speed
            stop = at
            while stop < len(items) and (items[stop].time or 0.0) <= due:
                stop += 1
            if stop > at:
                deliver(self.name, items[at:stop])
                at = stop
                await asyncio.sleep(0)
            else:
                await asyncio.sleep(max(((items[at].time or 0.0) - due) / self.speed, 0.0))


def parse_source(text: str, sensors: tuple[str, ...] = (), announce: Callable[[str], None] = print) -> StreamSource:
    """The source that a text names.

    Parameters
    ----------
    text : str
        ``phone``, ``phone://HOST:PORT``, ``sensorserver://HOST:PORT/SENSOR``, ``slimevr://HOST:PORT``,
        ``mvn://HOST:PORT``, ``mocopi://HOST:PORT`` or ``replay:FILE@SPEED``.
    sensors : tuple of str
        Where a phone may be worn.
    announce : callable
        Takes the link that a phone has to open.

    Returns
    -------
    StreamSource

    Raises
    ------
    RequestError
        For a text that names none.

    Examples
    --------
    >>> parse_source("slimevr://:6969").name
    'slimevr://127.0.0.1:6969'
    """
    if text.startswith("replay:"):
        return _replay(text.removeprefix("replay:"))
    scheme, _, rest = text.partition("://")
    if scheme == "phone":
        host, port, _ = _address(text, rest, phone.PORT)
        return PhonePage(host, port, sensors, announce)
    if scheme not in _PORTS:
        known = "phone, sensorserver://HOST, slimevr://, mvn://, mocopi://, replay:FILE"
        raise RequestError(f"expected a source, one of {known}; found {text!r}")
    host, port, name = _address(text, rest, _PORTS[scheme])
    if scheme == "sensorserver":
        return SensorServer(host, port, name or "phone")
    return Udp(scheme, host, port)


def speed_of(sources: Sequence[StreamSource]) -> float:
    """How fast time goes in a session: that of its replays, else 1.

    Parameters
    ----------
    sources : sequence of StreamSource

    Returns
    -------
    float

    Raises
    ------
    RequestError
        For replays of several speeds, or a fast one together with a device.
    """
    speeds = {source.speed if isinstance(source, Replay) else 1.0 for source in sources}
    if len(speeds) > 1:
        raise RequestError(f"expected one speed for all sources, found {', '.join(f'{s:g}' for s in sorted(speeds))}")
    return speeds.pop() if speeds else 1.0


def _replay(rest: str) -> Replay:
    path, at, speed = rest.rpartition("@")
    if not at:
        return Replay(Path(rest))
    try:
        factor = float(speed)
    except ValueError:
        return Replay(Path(rest))  # a name with an @ in it
    if not 0 < factor < 1e6:
        raise RequestError(f"replay: expected a speed above 0, as in replay:walk.csv@2; found {speed}")
    return Replay(Path(path), factor)


def _address(text: str, rest: str, port: int) -> tuple[str, int, str]:
    """Host, port and path of what follows a scheme."""
    try:
        parts = urlsplit(f"//{rest}")
        return parts.hostname or LOOPBACK, port if parts.port is None else parts.port, parts.path.strip("/")
    except ValueError:
        raise RequestError(f"expected HOST:PORT with a port up to 65535, found {text!r}") from None


def _websockets_client() -> Any:
    try:
        from websockets.asyncio import client
    except ImportError:
        raise RequestError("this source needs the extra 'live': pip install 'kinetograph[live]'") from None
    return client
