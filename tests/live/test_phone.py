"""A phone's page in a real browser: Chromium's own sensors are overridden, and its events arrive as rows."""

from __future__ import annotations

import asyncio
import json
import shutil
import ssl
import subprocess
import urllib.error
import urllib.request
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import connect

from kinetograph.live.items import Item
from kinetograph.live.rows import Row
from kinetograph.live.sources import parse_source

_SENSORS = ("left_wrist", "right_wrist")


@asynccontextmanager
async def _serving(address: str = "phone://127.0.0.1:0") -> AsyncIterator[tuple[str, list[Item]]]:
    """A page that is served: its link, and the items that come."""
    links: asyncio.Queue[str] = asyncio.Queue()
    items: list[Item] = []
    source = parse_source(address, _SENSORS, links.put_nowait)
    task = asyncio.create_task(source.run(lambda _, more: items.extend(more)))
    try:
        yield await asyncio.wait_for(links.get(), 10), items
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def _status(link: str) -> int:
    try:
        with urllib.request.urlopen(link, timeout=5) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


def test_nothing_is_given_without_the_token() -> None:
    async def run() -> None:
        async with _serving() as (link, _):
            base = link.split("?", 1)[0]
            for path in (base, base + "?token=guess", base + "rows", base + "../../etc/passwd"):
                assert await asyncio.to_thread(_status, path) == 403
            assert await asyncio.to_thread(_status, link) == 200
            assert await asyncio.to_thread(_status, link.replace("/?", "/etc/passwd?")) == 404

    asyncio.run(run())


def test_rows_of_sensors_that_are_not_worn_and_long_messages_are_left_out() -> None:
    async def run() -> None:
        async with _serving() as (link, items):
            address = link.replace("http", "ws").replace("/?", "/rows?")
            async with connect(address) as socket:
                assert json.loads(await socket.recv()) == {"sensors": list(_SENSORS)}
                row = {"t": 1.0, "force": [0, 0, 9.8], "rate": None}
                for sensor in ("nose", "left_wrist"):
                    await socket.send(json.dumps(row | {"sensor": sensor}))
                await socket.send("not JSON")
                await socket.send("x" * 10_000)
                with pytest.raises(Exception, match="1009"):  # the message is too big
                    await socket.recv()
            assert items == [Row("left_wrist", 1.0, (0.0, 0.0, 9.8))]

    asyncio.run(run())


def test_phones_elsewhere_are_served_by_https_with_a_certificate_that_stays(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))

    async def run() -> str:
        async with _serving("phone://0.0.0.0:0") as (link, _):
            assert link.startswith("https://")
            port = link.split("/?")[0].rsplit(":", 1)[1]
            context = ssl.create_default_context()
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
            _, writer = await asyncio.open_connection("127.0.0.1", int(port), ssl=context)
            secured = writer.get_extra_info("ssl_object")
            given = str(secured.getpeercert(True))
            writer.close()
            return given

    assert asyncio.run(run()) == asyncio.run(run())
    (made,) = tmp_path.rglob("*.pem")
    assert made.stat().st_mode & 0o077 == 0  # its key is nobody else's


@pytest.fixture
def chromium(tmp_path: Path) -> Iterator[int]:
    """A browser without a screen: the port of its debugging protocol."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no Chromium on PATH")
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]
    flags += ["--disable-background-networking", "--disable-component-update", "--disable-sync"]
    browser = subprocess.Popen(
        [program, *flags, f"--user-data-dir={tmp_path}/profile", "--remote-debugging-port=0", "about:blank"],
        stderr=subprocess.PIPE,
        text=True,
    )
    assert browser.stderr is not None
    try:
        said = next((line for line in browser.stderr if "DevTools listening" in line), "")
        if not said:
            pytest.skip("Chromium does not start here")
        yield int(said.rsplit(":", 1)[1].split("/")[0])
    finally:
        browser.terminate()
        browser.wait(10)
        browser.stderr.close()


class _Tab:
    """A tab, driven by the debugging protocol."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._number = socket, 0

    async def call(self, method: str, **parameters: Any) -> Any:
        self._number += 1
        await self._socket.send(json.dumps({"id": self._number, "method": method, "params": parameters}))
        while True:
            answer = json.loads(await asyncio.wait_for(self._socket.recv(), 20))
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]

    async def evaluate(self, text: str) -> Any:
        answer = await self.call("Runtime.evaluate", expression=text, awaitPromise=True, returnByValue=True)
        return answer["result"].get("value")


def test_motion_of_a_real_browser_arrives_as_specific_force_and_rates(chromium: int) -> None:
    async def run() -> list[Item]:
        async with _serving() as (link, items):
            with urllib.request.urlopen(f"http://127.0.0.1:{chromium}/json/list", timeout=10) as answer:
                tabs = json.load(answer)
            address = next(tab["webSocketDebuggerUrl"] for tab in tabs if tab["type"] == "page")
            async with connect(address, max_size=2**24) as socket:
                tab = _Tab(socket)
                for sensor in ("accelerometer", "linear-acceleration", "gyroscope"):
                    await tab.call("Emulation.setSensorOverrideEnabled", enabled=True, type=sensor)
                await tab.call("Page.navigate", url=link)
                for _ in range(100):
                    if await tab.evaluate("document.querySelectorAll('#sensor option').length") == len(_SENSORS):
                        break
                    await asyncio.sleep(0.1)
                await tab.evaluate("document.getElementById('sensor').value = 'right_wrist'")
                await tab.evaluate("document.getElementById('start').click()")
                for i in range(200):
                    for sensor, values in (
                        ("accelerometer", (1.0, 9.7, -0.5)),
                        ("linear-acceleration", (1.0, 0.0, -0.5)),
                        ("gyroscope", (0.1, -0.2, 0.3)),
                    ):
                        reading = {"xyz": dict(zip("xyz", values, strict=True))}
                        await tab.call("Emulation.setSensorOverrideReadings", type=sensor, reading=reading)
                    await asyncio.sleep(0.02)
                    if len(items) > 20 and i > 20:
                        break
            return items

    rows = [item for item in asyncio.run(run()) if isinstance(item, Row)]
    assert len(rows) > 10
    assert {row.sensor for row in rows} == {"right_wrist"}
    last = rows[-1]
    assert last.force == pytest.approx((1.0, 9.7, -0.5), abs=0.11)  # browsers round, so as not to identify a phone
    assert last.angular == pytest.approx((0.1, -0.2, 0.3), abs=0.02)
    times = [row.time for row in rows if row.time is not None]
    assert times == sorted(times)
