"""Who may speak to the server."""

from __future__ import annotations

import pytest

from kinetograph.studio.serving.guard import Guard, Refusal

GUARD = Guard("a-token", 8123)


@pytest.mark.parametrize("host", ["127.0.0.1:8123", "localhost:8123"])
def test_its_own_names_are_let_in(host: str) -> None:
    GUARD.check_host(host)
    GUARD.check_origin(f"http://{host}")


@pytest.mark.parametrize(
    "host", [None, "", "127.0.0.1", "127.0.0.1:8124", "example.com:8123", "127.0.0.1:8123.example.com", "[::1]:8123"]
)
def test_other_names_are_refused(host: str | None) -> None:
    with pytest.raises(Refusal, match=r"expected Host 127\.0\.0\.1:8123, found"):
        GUARD.check_host(host)


@pytest.mark.parametrize("origin", ["http://example.com", "null", "https://127.0.0.1:8123", "http://127.0.0.1:81"])
def test_pages_of_other_origins_are_refused(origin: str) -> None:
    with pytest.raises(Refusal, match="expected a page of"):
        GUARD.check_origin(origin)


def test_programs_that_are_no_browsers_send_no_origin() -> None:
    GUARD.check_origin(None)


@pytest.mark.parametrize(
    ("target", "cookies"),
    [("/?token=a-token", None), ("/studio.js", "kinetograph_8123=a-token"), ("/", "x=1; kinetograph_8123=a-token")],
)
def test_the_token_is_in_the_query_or_in_the_cookie(target: str, cookies: str | None) -> None:
    GUARD.check_token(target, cookies)


@pytest.mark.parametrize(
    ("target", "cookies"),
    [
        ("/", None),
        ("/?token=", None),
        ("/?token=A-TOKEN", None),
        ("/?token=a-tokenx", None),
        ("/?tokens=a-token", None),
        ("/", "kinetograph_8124=a-token"),
        ("/", "kinetograph_8123=other"),
        ("/?token=\udcff", "=;;="),
    ],
)
def test_any_other_token_is_refused(target: str, cookies: str | None) -> None:
    with pytest.raises(Refusal, match="expected the token of this server"):
        GUARD.check_token(target, cookies)
