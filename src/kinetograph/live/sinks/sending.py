"""Where motion goes, frame by frame: programs over the network, and files that stay whole."""

from __future__ import annotations

import socket
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

from kinetograph.errors import ExistsError, RequestError
from kinetograph.formats.bvh import GrowingBvh
from kinetograph.live.items import LOOPBACK
from kinetograph.live.sinks import vmc
from kinetograph.live.sinks.humanoid import Humanoid
from kinetograph.motion import Motion


class Sink(Protocol):
    """Something that takes frames."""

    @property
    def name(self) -> str:
        """What it is called in messages."""
        ...

    def send(self, frame: Motion, time: float) -> None:
        """Take a motion of one frame, ``time`` seconds since the first."""
        ...

    def close(self) -> None:
        """No more frames will come."""
        ...


@dataclass
class VmcSink:
    """Sends frames to a program that takes Virtual Motion Capture.

    Parameters
    ----------
    host : str
    port : int
    """

    host: str
    port: int
    lost: int = field(default=0, init=False)
    _socket: socket.socket | None = field(default=None, init=False)
    _body: Humanoid | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        try:
            found = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_DGRAM)[0]
        except OSError as error:
            raise RequestError(f"{self.name}: cannot find that address: {error.strerror or error}") from None
        self._family, self._address = found[0], found[4]

    @property
    def name(self) -> str:
        """The address."""
        return f"vmc://{self.host}:{self.port}"

    def send(self, frame: Motion, time: float) -> None:
        """Send a frame; what the network does not take at once is lost, and counted."""
        if self._socket is None:
            self._socket = socket.socket(self._family, socket.SOCK_DGRAM)
            self._socket.setblocking(False)
        if self._body is None or self._body.skeleton is not frame.skeleton:
            self._body = Humanoid(frame.skeleton)
        for datagram in vmc.datagrams(self._body, frame, time):
            try:
                self._socket.sendto(datagram, self._address)
            except OSError:
                self.lost += 1

    def close(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


@dataclass
class BvhSink:
    """Writes frames to a BVH file that is whole whenever the program ends, up to the last second.

    Parameters
    ----------
    path : Path
    force : bool
        Overwrite a file that exists.
    """

    path: Path
    force: bool = False
    _file: GrowingBvh | None = None

    def __post_init__(self) -> None:
        if self.path.exists() and not self.force:
            raise ExistsError(f"{self.path}: exists already; overwrite it with --force or choose another name")
        if not self.path.parent.is_dir():
            raise RequestError(f"{self.path}: expected a folder that exists, found none")

    @property
    def name(self) -> str:
        """The file's name."""
        return str(self.path)

    def send(self, frame: Motion, time: float) -> None:
        """Write a frame."""
        if self._file is None:
            self._file = GrowingBvh(self.path, frame.skeleton, frame.fps)
        self._file.add(frame)

    def close(self) -> None:
        """Write what is left."""
        if self._file is not None:
            self._file.close()


def parse_sink(text: str, force: bool = False) -> Sink:
    """The sink that a text names.

    Parameters
    ----------
    text : str
        ``vmc://HOST:PORT``, or a file ending in .bvh.
    force : bool
        Overwrite a file that exists.

    Returns
    -------
    Sink

    Raises
    ------
    RequestError
        For a text that names none, an address that is none, and a file that cannot be written.
    """
    if text.startswith("vmc://"):
        try:
            parts = urlsplit(text)
            return VmcSink(parts.hostname or LOOPBACK, parts.port or vmc.PORT)
        except ValueError:
            raise RequestError(f"expected vmc://HOST:PORT with a port up to 65535, found {text!r}") from None
    if text.lower().endswith(".bvh"):
        return BvhSink(Path(text), force)
    raise RequestError(f"expected where to send frames, vmc://HOST:PORT or a file.bvh; found {text!r}")
