"""Who may speak to the server: pages that it served itself, to the person who started it, on this machine."""

from __future__ import annotations

import hmac
from dataclasses import dataclass
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

from kinetograph.errors import RequestError

COOKIE = "kinetograph"
"""How the name of the cookie begins that holds the token; the port follows, as cookies do not tell ports apart."""


class Refusal(RequestError):
    """A request that is refused, with the status of its answer."""

    def __init__(self, status: HTTPStatus, text: str) -> None:
        super().__init__(text)
        self.status = status


@dataclass(frozen=True)
class Guard:
    """The token of a server, and the names that it is called by.

    Parameters
    ----------
    token : str
    port : int
    """

    token: str
    port: int

    @property
    def hosts(self) -> frozenset[str]:
        """What a request's Host may be: other names that lead here are somebody else's."""
        return frozenset(f"{name}:{self.port}" for name in ("127.0.0.1", "localhost"))

    def check_host(self, host: str | None) -> None:
        """Raise Refusal unless the request was sent to this machine by its own name."""
        if host not in self.hosts:
            raise Refusal(HTTPStatus.MISDIRECTED_REQUEST, f"expected Host 127.0.0.1:{self.port}, found {_short(host)}")

    def check_origin(self, origin: str | None) -> None:
        """Raise Refusal for a page of another origin; programs that are no browsers send none."""
        if origin is not None and origin not in {f"http://{host}" for host in self.hosts}:
            raise Refusal(
                HTTPStatus.FORBIDDEN, f"expected a page of http://127.0.0.1:{self.port}, found one of {_short(origin)}"
            )

    def check_token(self, target: str, cookies: str | None) -> None:
        """Raise Refusal unless the token is in the query or in the cookie."""
        given = parse_qs(urlsplit(target).query).get("token", [])
        kept, mine = self._kept(cookies), self.token.encode()
        if not any(hmac.compare_digest(each.encode("utf-8", "surrogatepass"), mine) for each in (*given, *kept)):
            raise Refusal(
                HTTPStatus.FORBIDDEN,
                f"expected the token of this server, found {'another' if given else 'none'}; "
                "open the address that kinetograph studio printed",
            )

    def cookie(self) -> str:
        """The header that makes a browser keep the token for this server's pages only."""
        return f"{COOKIE}_{self.port}={self.token}; HttpOnly; SameSite=Strict; Path=/"

    def _kept(self, cookies: str | None) -> list[str]:
        try:
            jar = SimpleCookie(cookies or "")
        except CookieError:
            return []
        name = f"{COOKIE}_{self.port}"
        return [jar[name].value] if name in jar else []


def policy(port: int) -> dict[str, str]:
    """The headers that keep a page to this server; programs that drive a browser may evaluate, the page does not."""
    return {
        "Content-Security-Policy": (
            "default-src 'none'; script-src 'self' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
            "img-src 'self' data: blob:; "
            f"connect-src 'self' blob: ws://127.0.0.1:{port} ws://localhost:{port}; base-uri 'none'; "
            "form-action 'none'; frame-ancestors 'none'"
        ),
        "Cache-Control": "no-store",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
    }


def _short(text: str | None) -> str:
    return "none" if text is None else repr(text[:80])
