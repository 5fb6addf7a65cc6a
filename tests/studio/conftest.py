"""A browser for the studio's page: Debian's chromium, driven by playwright, without a screen and without a network."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest

from kinetograph.errors import RequestError
from kinetograph.studio.page import page_folder

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put tests in a browser last: once playwright has started, its loop runs, and no other can in this thread."""
    items.sort(key=lambda item: "browser" in getattr(item, "fixturenames", ()))


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium; the test is skipped where it or playwright is missing."""
    if reason := os.environ.get("KINETOGRAPH_NO_BROWSER"):
        pytest.skip(reason)
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is missing: pip install playwright")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is missing: apt-get install chromium")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """A page of 1280 by 800 pixels; afterwards it has raised nothing, and asked nobody but the loopback."""
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    page = context.new_page()
    raised: list[str] = []
    asked: list[str] = []
    page.on("pageerror", lambda error: raised.append(str(error)))
    page.on("websocket", lambda socket: asked.append(socket.url))
    context.on("request", lambda request: asked.append(request.url))
    yield page
    context.close()
    assert not raised
    hosts = {urlsplit(url).hostname for url in asked if urlsplit(url).scheme in ("http", "https", "ws", "wss")}
    assert hosts <= {"127.0.0.1", "localhost"}


@pytest.fixture(scope="session")
def built_page() -> Path:
    """The folder of the built page; the test is skipped where it is not built."""
    try:
        return page_folder()
    except RequestError as error:
        pytest.skip(str(error))
