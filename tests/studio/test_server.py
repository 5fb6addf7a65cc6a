"""The server: what it answers, whom it refuses, and that nothing which is sent to it ends it or is lost."""

from __future__ import annotations

import http.client
import json
import os
import random
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

pytest.importorskip("websockets", reason="the extra 'studio' is not installed")

from rooms import Caller, served, standing, walk
from websockets.exceptions import ConnectionClosed, InvalidStatus

from kinetograph.errors import RequestError
from kinetograph.studio.made import Made
from kinetograph.studio.page import page_folder
from kinetograph.studio.project import Project, Walk, read_project
from kinetograph.studio.serving.server import LARGEST, Server
from kinetograph.synthesis import Synthesis

PATH = [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    try:
        page_folder()
    except RequestError as error:
        pytest.skip(str(error))
    folder = tmp_path / "studio"
    folder.mkdir()
    with served(folder) as running:
        yield running


def _get(server: Server, path: str, headers: dict[str, str] | None = None) -> tuple[int, str, dict[str, str]]:
    parts = urlsplit(server.address)
    connection = http.client.HTTPConnection("127.0.0.1", parts.port, timeout=10)
    connection.request("GET", path, headers=headers or {})
    answer = connection.getresponse()
    text = answer.read().decode("utf-8", "replace")
    connection.close()
    return answer.status, text, dict(answer.headers)


def _query(server: Server) -> str:
    return urlsplit(server.address).query


# ---- what it serves ----


def test_it_serves_the_page_to_whoever_has_the_token(server: Server) -> None:
    status, text, headers = _get(server, f"/?{_query(server)}")
    assert (status, "studio.js" in text) == (200, True)
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    cookie = headers["Set-Cookie"].split(";")[0]
    for name, kind in (("studio.js", "javascript"), ("style.css", "text/css")):
        status, _, headers = _get(server, f"/{name}", {"Cookie": cookie})
        assert status == 200
        assert kind in headers["Content-Type"]
        assert _get(server, f"/{name}")[0] == 403


@pytest.mark.parametrize("query", ["", "?token=", "?token=wrong", "?token=a&token=b"])
def test_a_wrong_token_is_refused_in_words(server: Server, query: str) -> None:
    status, text, _ = _get(server, f"/{query}")
    assert status == 403
    assert "expected the token of this server" in text


def test_another_host_is_refused_in_words(server: Server) -> None:
    status, text, _ = _get(server, f"/?{_query(server)}", {"Host": "evil.example"})
    assert status == 421
    assert "expected Host 127.0.0.1" in text


@pytest.mark.parametrize(
    "path",
    [
        "/../project.json",
        "/..%2fproject.json",
        "/exports/../project.json",
        "/exports/..%2f..%2fproject.json",
        "/exports/%2e%2e/project.json",
        "/exports/.hidden",
        "/files/secret.txt",
        "//etc/passwd",
        "/exports//etc/passwd",
        "/%00",
        "/project.json",
        "/exports/link.txt",
        "/exports/",
        "/" + "a" * 3000,
    ],
)
def test_nothing_but_the_page_and_the_exports_is_read(server: Server, path: str) -> None:
    folder = server.desk.room.folder
    for name in ("exports", "files"):
        (folder / name).mkdir(exist_ok=True)
    (folder / "files" / "secret.txt").write_text("hush-hush")
    (folder / "exports" / ".hidden").write_text("hush-hush")
    os.symlink("/etc/passwd", folder / "exports" / "link.txt")
    status, text, _ = _get(server, f"{path}?{_query(server)}")
    assert status in (400, 404)
    assert "hush-hush" not in text
    assert "root:" not in text


def test_an_export_is_served(server: Server) -> None:
    (server.desk.room.folder / "exports").mkdir()
    (server.desk.room.folder / "exports" / "walk 1.bvh").write_text("HIERARCHY")
    assert _get(server, f"/exports/walk%201.bvh?{_query(server)}")[:2] == (200, "HIERARCHY")


# ---- who may speak ----


@pytest.mark.parametrize("origin", ["http://evil.example", "null"])
def test_a_socket_of_another_origin_is_refused(server: Server, origin: str) -> None:
    with pytest.raises(InvalidStatus) as caught:
        Caller(server, additional_headers={"Origin": origin})
    assert caught.value.response.status_code == 403
    assert b"expected a page of http://127.0.0.1" in (caught.value.response.body or b"")


def test_a_socket_without_the_token_is_refused(server: Server) -> None:
    from websockets.sync.client import connect

    with pytest.raises(InvalidStatus) as caught, connect(f"ws://{urlsplit(server.address).netloc}/socket"):
        pass
    assert caught.value.response.status_code == 403


# ---- what is sent to it ----


def _malformed(seed: int) -> str | bytes:
    rng = random.Random(seed)
    whole = json.dumps({"kind": "edit", "part": "walk", "value": {"path": PATH}, "label": "draw"})
    kinds = [
        lambda: whole[: rng.randrange(len(whole) - 1)],
        lambda: rng.randbytes(rng.randrange(0, 200)),
        lambda: json.dumps({"kind": rng.choice(["welcome", "state", "", "x" * 500, 3, None, "Edit"])}),
        lambda: json.dumps({"kind": "edit", "part": rng.choice(["", "version", "libraries", "__class__", "x" * 999])}),
        lambda: json.dumps({"kind": "edit", "part": "walk", "value": rng.choice([1, [], "x", {"path": [[1]]}, None])}),
        lambda: json.dumps({"kind": "edit", "part": "mode", "value": "fly"}),
        lambda: "[" * rng.randrange(1, 3000),
        lambda: json.dumps({"kind": "undo", "more": 1}),
        lambda: '{"kind": "edit", "part": "walk", "value": {"path": [[NaN, 1, 1]]}}',
        lambda: "\x00" * 30,
    ]
    return rng.choice(kinds)()


def test_ten_thousand_malformed_messages_are_each_refused_in_one_line(server: Server) -> None:
    caller, before = Caller(server), None
    refused = 0

    def read() -> None:
        nonlocal refused
        while refused < 10_000:
            message = caller.next(60)
            refused += message["kind"] == "failed"
            assert message["kind"] != "failed" or "\n" not in message["message"]

    before = (server.desk.path.exists(), sorted(server.desk.room.folder.rglob("*")))
    reader = threading.Thread(target=read)
    reader.start()
    for seed in range(10_000):
        caller.send(_malformed(seed))
    reader.join(120)
    assert refused == 10_000
    assert (server.desk.path.exists(), sorted(server.desk.room.folder.rglob("*"))) == before
    caller.edit("walk", {"path": PATH}, label="draw")
    assert caller.until("made")["seconds"] == pytest.approx(1.0)
    caller.close()


def test_a_frame_of_100_mb_is_refused_in_words_and_the_server_lives(server: Server) -> None:
    caller = Caller(server)
    with pytest.raises(ConnectionClosed) as caught:
        _send_and_hear(caller, bytes(100 * 2**20))
    assert caught.value.rcvd is not None
    assert caught.value.rcvd.code == 1009
    assert str(LARGEST) in caught.value.rcvd.reason
    again = Caller(server)
    assert again.next()["kind"] == "welcome"
    again.close()


def _send_and_hear(caller: Caller, frame: bytes) -> None:
    caller.send(frame)
    while True:
        caller.next()


@pytest.mark.parametrize("role", ["character", "leader", "recording", "readings", "layout"])
@pytest.mark.parametrize("name", ["walk.bvh", "body.glb", "song.mp3", "readings.csv", "mine.toml"])
def test_a_file_that_is_not_what_it_is_to_be_is_refused_in_words(server: Server, name: str, role: str) -> None:
    caller = Caller(server)
    caller.drop(name, b"\x00\x01 this is no file of any kind", role, 7)
    answer = caller.until(lambda message: message.get("id") == 7)
    assert answer["kind"] == "failed"
    assert name in answer["message"]
    assert "\n" not in answer["message"]
    assert list((server.desk.room.folder / "files").iterdir()) == []
    caller.close()


@pytest.mark.parametrize(
    "name", ["../project.json", "/etc/x.bvh", "", ".", "..", "a/b.bvh", "a\\b.bvh", "C:x.bvh", "x" * 400]
)
def test_a_file_lands_nowhere_else(server: Server, name: str) -> None:
    caller = Caller(server)
    caller.drop(name, b"HIERARCHY", "recording", 3)
    answer = caller.until(lambda message: message.get("id") == 3)
    assert (answer["kind"], "expected the name of a file" in answer["message"]) == ("failed", True)
    caller.close()


# ---- what is made ----


def test_an_edit_is_made_saved_and_shown_to_every_page(server: Server) -> None:
    first, second = Caller(server), Caller(server)
    first.edit("walk", {"path": PATH}, number=5, label="draw")
    mine, theirs = (each.until(lambda m: m["kind"] == "state" and m["revision"] == 1) for each in (first, second))
    assert (mine["number"], theirs["number"], theirs["undo"]) == (5, 0, "draw")
    made = [each.until("made") for each in (first, second)]
    assert made[0]["payload"] == made[1]["payload"]
    assert made[0]["payload"][:4] == b"glTF"
    assert read_project(server.desk.path).walk == Walk(path=((0, 0, 0), (1, 2, 0)))
    second.send({"kind": "undo"})
    assert first.until("nothing")["section"] == "walk"
    assert read_project(server.desk.path).walk == Walk()
    for each in (first, second):
        each.close()


def test_a_page_that_comes_later_is_shown_what_there_is(server: Server) -> None:
    caller = Caller(server)
    caller.edit("walk", {"path": PATH})
    made = caller.until("made")
    caller.close()
    again = Caller(server)
    assert [again.next()["kind"] for _ in range(2)] == ["welcome", "state"]
    assert again.until("made")["key"] == made["key"]
    again.close()


def test_what_cannot_be_made_is_said_and_can_be_mended(tmp_path: Path) -> None:
    def refuse(project: Project, room: Any, progress: Any) -> Made | None:
        if len(project.walk.path) == 1:
            raise RequestError("a path needs\ntwo points")
        if len(project.walk.path) == 3:
            raise ZeroDivisionError("a fault")
        return walk(project, room, progress)

    with served(tmp_path, sections={"walk": refuse}) as server:
        caller = Caller(server)
        caller.edit("walk", {"path": PATH[:1]})
        assert caller.until("failed")["message"] == "a path needs two points"
        caller.edit("walk", {"path": [*PATH, PATH[1]]})
        assert caller.until("failed")["message"] == "a fault of the program: ZeroDivisionError: a fault"
        caller.edit("walk", {"path": PATH})
        assert caller.until("made")["pieces"][0]["take"] == "take"
        caller.close()


def test_the_last_of_many_edits_is_made_and_the_others_are_stopped(tmp_path: Path) -> None:
    finished = []

    def slow(project: Project, room: Any, progress: Any) -> Made:
        for step in range(50):
            progress(step, 50)
            time.sleep(0.01)
        finished.append(project.walk.path[-1][1])
        return Made((Synthesis(standing(1.0, project.walk.path[-1][1]), (), 0.0),))

    with served(tmp_path, sections={"walk": slow}) as server:
        caller = Caller(server)
        for x in range(20):
            caller.edit("walk", {"path": [[0, 0, 0], [1, x, 0]]})
        assert caller.until("made")["section"] == "walk"
        assert finished[-1] == 19
        assert len(finished) == 1
        caller.edit("walk", {"path": [[0, 0, 0], [1, 30, 0]]})
        caller.until(lambda message: message["kind"] == "working" and message["done"] > 0)
        caller.send({"kind": "cancel"})
        caller.until("made")  # the one before
        time.sleep(0.7)
        assert finished == [19]
        caller.close()


def test_a_page_that_goes_while_something_is_made_finds_it_made(tmp_path: Path) -> None:
    go = threading.Event()

    def waiting(project: Project, room: Any, progress: Any) -> Made | None:
        go.wait(10)
        return walk(project, room, progress)

    with served(tmp_path, Project(walk=Walk(path=((0, 0, 0), (1, 2, 0)))), {"walk": waiting}) as server:
        caller = Caller(server)
        caller.until("working")
        caller.close()
        go.set()
        again = Caller(server)
        assert again.until("made")["seconds"] == pytest.approx(1.0)
        again.close()


def test_a_project_is_as_it_was_after_a_new_start(tmp_path: Path) -> None:
    with served(tmp_path) as server:
        caller = Caller(server)
        caller.edit("walk", {"path": PATH, "smooth_time": 0.5})
        made = caller.until("made")
        caller.close()
    with served(tmp_path, read_project(tmp_path / "project.json")) as server:
        caller = Caller(server)
        assert caller.until("made")["payload"] == made["payload"]
        caller.close()


def test_a_page_that_takes_nothing_keeps_nobody_waiting(server: Server) -> None:
    deaf, caller = Caller(server, max_queue=1), Caller(server)
    for x in range(2000):
        caller.edit("walk", {"path": [[0, 0, 0], [1, x, 0]]}, number=x, solve=False)
    assert caller.until(lambda message: message["kind"] == "state" and message["number"] == 1999)
    deaf.connection.socket.close()
    caller.close()


def test_undo_is_answered_with_its_number_whether_there_is_anything_to_take_back_or_not(server: Server) -> None:
    caller = Caller(server)
    caller.edit("walk", {"path": PATH}, number=1)
    caller.until("made")
    for kind, number, path in (("undo", 2, None), ("undo", 3, None), ("redo", 4, PATH), ("redo", 5, PATH)):
        caller.send({"kind": kind, "number": number})
        state = caller.until(lambda message, number=number: message["kind"] == "state" and message["number"] == number)
        assert state["project"].get("walk", {}).get("path") == path
        assert caller.until(lambda message: message["kind"] in ("made", "nothing"))["section"] == "walk"
    caller.close()
