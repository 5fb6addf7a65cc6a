"""The server: the page and its socket on one port of this machine."""

from __future__ import annotations

import asyncio
import contextlib
import mimetypes
import secrets
from collections.abc import AsyncIterator, Callable
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

import msgspec

from kinetograph.errors import RequestError
from kinetograph.studio.desk.desk import Desk
from kinetograph.studio.messages import Message
from kinetograph.studio.page import page_folder
from kinetograph.studio.room import EXPORTS, plain_name
from kinetograph.studio.serving.guard import Guard, Refusal, policy

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

LOOPBACK = "127.0.0.1"
LARGEST = 64 * 2**20
"""Bytes of a message: of a file that is dropped."""

_WAITING = 512  # frames that a page has not taken yet; one that takes none is cut off, and comes again
_ENCODER = msgspec.json.Encoder()


class SocketPage:
    """A page at the other end of a socket.

    Parameters
    ----------
    connection : ServerConnection
    """

    def __init__(self, connection: ServerConnection) -> None:
        self._connection = connection
        self._frames: asyncio.Queue[str | bytes] = asyncio.Queue(_WAITING)

    def post(self, frame: Message | bytes) -> None:
        """Send a message or a binary frame, in the order of the calls; a page that takes nothing is cut off."""
        text = frame if isinstance(frame, bytes) else _ENCODER.encode(frame).decode()
        try:
            self._frames.put_nowait(text)
        except asyncio.QueueFull:
            self._connection.transport.abort()

    async def send(self) -> None:
        """Send what is posted, until the page is gone."""
        while True:
            await self._connection.send(await self._frames.get())


class Server:
    """Serves a desk.

    Parameters
    ----------
    desk : Desk
    port : int
        0 for any that is free.
    """

    def __init__(self, desk: Desk, port: int = 0) -> None:
        self.desk = desk
        self._wanted = port
        self._guard = Guard(secrets.token_urlsafe(24), port)

    @property
    def address(self) -> str:
        """What to open."""
        return f"http://{LOOPBACK}:{self._guard.port}/?token={self._guard.token}"

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncIterator[Server]:
        """Serve while the block lasts.

        Raises
        ------
        RequestError
            Without the extra or the page, and where the port cannot be listened on.
        """
        try:
            from websockets.asyncio.server import serve
        except ImportError:
            raise RequestError("the studio needs the extra 'studio': pip install 'kinetograph[studio]'") from None
        page_folder()
        options: dict[str, Any] = {"process_request": self._respond, "max_size": LARGEST, "compression": None}
        options |= {"open_timeout": 5, "close_timeout": 1, "ping_interval": 20}  # seconds
        try:
            server = await serve(self._meet, LOOPBACK, self._wanted, **options)
        except OSError as error:
            reason = error.strerror or error
            raise RequestError(f"cannot listen on port {self._wanted}: {reason}; choose another with --port") from None
        async with server:
            port = next(iter(server.sockets)).getsockname()[1]
            self._guard = Guard(self._guard.token, port)
            yield self

    async def _meet(self, connection: ServerConnection) -> None:
        """Serve a page until it is gone."""
        from websockets.exceptions import ConnectionClosed

        page = SocketPage(connection)
        sending = asyncio.create_task(page.send())
        self.desk.join(page)
        try:
            async for frame in connection:
                await self.desk.hear(page, frame)
                await asyncio.sleep(0)  # whoever sends without a pause does not keep the others waiting
        except ConnectionClosed:
            pass
        finally:
            self.desk.leave(page)
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)

    def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request for a file; None for that of a socket, which goes on."""
        try:
            self._guard.check_host(request.headers.get("Host"))
            return self._answer(request)
        except Refusal as refusal:
            return _response(refusal.status, {"Content-Type": "text/plain; charset=utf-8"}, f"{refusal}\n".encode())
        except Exception:  # a request that no browser sends: of two Hosts, for example
            return _response(HTTPStatus.BAD_REQUEST, {}, b"expected a request of a browser\n")

    def _answer(self, request: Request) -> Response | None:
        path = unquote(urlsplit(request.path).path)
        cookies = request.headers.get("Cookie")
        if path == "/socket":
            self._guard.check_origin(request.headers.get("Origin"))
            self._guard.check_token(request.path, cookies)
            return None
        self._guard.check_token(request.path, cookies)
        file = self._file(path)
        headers = {
            "Content-Type": mimetypes.guess_type(file.name)[0] or "application/octet-stream",
            **policy(self._guard.port),
            **({"Set-Cookie": self._guard.cookie()} if path == "/" else {}),
        }
        return _response(HTTPStatus.OK, headers, file.read_bytes())

    def _file(self, path: str) -> Path:
        """The file of a path: one of the page's or of the exports, and no other."""
        found = None
        folder, _, name = path.removeprefix("/").rpartition("/")
        if folder in ("", EXPORTS):
            within = self.desk.room.folder / EXPORTS if folder else page_folder()
            with contextlib.suppress(RequestError):
                found = within / plain_name(name or "index.html")
        if found is None or not found.is_file() or found.is_symlink():
            raise Refusal(HTTPStatus.NOT_FOUND, f"there is no {path[:80]!r} here")
        return found


def _response(status: HTTPStatus, headers: dict[str, str], body: bytes) -> Response:
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    fields = {**headers, "Content-Length": str(len(body)), "Connection": "close"}
    return Response(status.value, status.phrase, Headers(fields), body)


async def serve_studio(
    desk: Desk, port: int, announce: Callable[[str], None], stop: asyncio.Event, begin: Callable[[], Any]
) -> None:
    """Serve a desk until it is stopped.

    Parameters
    ----------
    desk : Desk
    port : int
        0 for any that is free.
    announce : callable
        Takes the address, once it can be opened.
    stop : asyncio.Event
    begin : callable
        Called once the page can be opened; gives a coroutine: what is fetched and made ready meanwhile.
    """
    async with Server(desk, port).running() as server:
        announce(server.address)
        beginning = asyncio.create_task(begin())
        await stop.wait()
        beginning.cancel()
        desk.solver.cancel()
        await asyncio.gather(beginning, desk.solver.rest(), return_exceptions=True)
