"""Serving the phones' page: one port for the page and its socket, with a token in the link, over HTTPS to phones.

Everything that is received is bounded, and treated as data: nothing is opened as a path.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import secrets
import socket
from collections.abc import Callable
from http import HTTPStatus
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from kinetograph.errors import RequestError
from kinetograph.live.sources import phone

if TYPE_CHECKING:
    from kinetograph.live.items import Deliver

_LARGEST = 4096  # bytes of a message
_PHONES = 16  # at once
_HEADERS = {
    "Content-Type": "text/html; charset=utf-8",
    "Content-Security-Policy": (
        "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src 'self' ws: wss:"
    ),
    "Referrer-Policy": "no-referrer",
}


async def serve(
    host: str, port: int, sensors: tuple[str, ...], deliver: Deliver, announce: Callable[[str], None]
) -> None:
    """Serve the page until cancelled.

    Parameters
    ----------
    host : str
        The address to listen on.
    port : int
        0 for any that is free.
    sensors : tuple of str
        Where a phone may be worn; another name is refused, unless there are none.
    deliver : callable
    announce : callable
        Takes the link to open.

    Raises
    ------
    RequestError
        Without the extra, and where the address cannot be listened on.
    """
    try:
        from websockets.asyncio.server import serve as serve_sockets
    except ImportError:
        raise RequestError("phones need the extra 'live': pip install 'kinetograph[live]'") from None
    page = _Page(sensors, deliver)
    context = None if is_loopback(host) else _context(host)
    options: dict[str, Any] = {"process_request": page.respond, "max_size": _LARGEST, "compression": None}
    options |= {"open_timeout": 5, "close_timeout": 1}  # seconds
    try:
        server = await serve_sockets(page.answer, host, port, ssl=context, **options)
    except OSError as error:
        raise RequestError(f"phone://{host}:{port}: cannot listen there: {error.strerror or error}") from None
    async with server:
        bound = next(iter(server.sockets)).getsockname()[1]
        scheme = "http" if context is None else "https"
        announce(f"{scheme}://{_reachable(host)}:{bound}/?token={page.token}")
        await asyncio.get_running_loop().create_future()


class _Page:
    """What is answered: the page to whoever has the token, and phones' messages handed on."""

    def __init__(self, sensors: tuple[str, ...], deliver: Deliver) -> None:
        self.token = secrets.token_urlsafe(16)
        self._sensors, self._deliver = sensors, deliver
        self._connected: set[Any] = set()

    async def answer(self, connection: Any) -> None:
        """One phone, until it leaves."""
        from websockets.exceptions import ConnectionClosed

        if len(self._connected) >= _PHONES:
            await connection.close(1013, "too many phones")
            return
        self._connected.add(connection)
        name = f"phone-{secrets.token_hex(4)}"
        try:
            with contextlib.suppress(ConnectionClosed):
                await connection.send(phone.welcome(self._sensors))
                async for message in connection:
                    rows = [row for row in phone.rows(message) if not self._sensors or row.sensor in self._sensors]
                    if rows:
                        self._deliver(name, rows)
        finally:
            self._connected.discard(connection)

    def respond(self, connection: Any, request: Any) -> Any:
        """The page, or None to go on with a socket."""
        path = urlsplit(request.path)
        given = parse_qs(path.query).get("token", [""])[0]
        if not hmac.compare_digest(given.encode(), self.token.encode()):
            return connection.respond(HTTPStatus.FORBIDDEN, "open the link with its token\n")
        if path.path == "/rows":
            return None
        if path.path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "there is one page here, /\n")
        response = connection.respond(HTTPStatus.OK, phone.page().decode())
        del response.headers["Content-Type"]
        for header, value in _HEADERS.items():
            response.headers[header] = value
        return response


def is_loopback(host: str) -> bool:
    """Whether an address is this machine's own."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def qr_code(link: str) -> str:
    """A link as a QR code of text, for a terminal; empty without the extra."""
    try:
        import segno
    except ImportError:
        return ""
    import io

    out = io.StringIO()
    segno.make(link, micro=False).terminal(out, compact=True)
    return out.getvalue()


def qr_modules(link: str) -> tuple[str, ...]:
    """A link as the rows of a QR code, ``1`` for dark and ``0`` for light modules; none without the extra."""
    try:
        import segno
    except ImportError:
        return ()
    return tuple("".join("1" if module else "0" for module in row) for row in segno.make(link, micro=False).matrix)


def _reachable(host: str) -> str:
    """An address that a phone can open: of the interface that leads outside, where all are listened on."""
    if host not in ("0.0.0.0", "::"):
        return f"[{host}]" if ":" in host else host
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # nothing is sent: it only asks which interface would be taken
            return str(probe.getsockname()[0])
        except OSError:
            return socket.gethostname()


def _context(host: str) -> Any:
    import ssl

    from kinetograph.live.sources.certificate import certificate

    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate(_reachable(host)))
    return context
