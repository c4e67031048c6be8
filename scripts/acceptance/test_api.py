"""The console's interface for programs: the client of docs/api.md, the schemas, and clients that break the
rules."""

import json
import pathlib
import re
import socket
import sys
import time
from collections.abc import Iterator
from typing import Any

import jsonschema
import pytest

from camera import SELECTION, Camera
from client import ASK_CONTROL, DISENGAGE, ENGAGE, STOP, TEXT, Program, Request, Socket, select
from machine import Delay, took
from process import ROOT, memory_mb, run

PING: dict[str, Any] = {"type": "ping", "sent_ms": 0}
READS_NOTHING_S = 60.0
GROWS_AT_MOST_MB = 20.0


@pytest.fixture(scope="module")
def program(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Program]:
    record = tmp_path_factory.mktemp("api") / "run.mcap"
    program = Program(
        barrelman, "run", "--video", "sim:arena1?size=640x360", "--link", "sim:", "--record", record
    )
    program.wait_for_track()
    yield program
    assert program.end() == 0


def page_of(program: Program) -> Socket:
    return Socket(program.host, program.token)


def test_client_of_the_documentation_selects_and_engages(program: Program, tmp_path: pathlib.Path) -> None:
    found = re.search(r"```python\n(.*?)```", (ROOT / "docs/api.md").read_text(), re.DOTALL)
    assert found
    (tmp_path / "client.py").write_text(found[1])
    box = [str(value) for value in program.status()["track"]["box"]]
    done = run([sys.executable, tmp_path / "client.py", program.host, program.token, *box])
    assert done.returncode == 0, done.stderr
    took, selected, engaged, state, released = done.stdout.splitlines()
    assert took.startswith("take-control accepted"), took
    assert selected.startswith("select accepted"), selected
    assert engaged.startswith("engage accepted"), engaged
    assert re.match(r"(servoing|holding) tracking \[\d", state), state
    assert released.startswith("release-control accepted"), released
    assert program.request(STOP)["answer"] == "accepted"


def test_picture_is_the_newest_one_and_kept_by_nobody(program: Program) -> None:
    def picture(path: str) -> tuple[bytes, int]:
        status, body, headers = program.ask("GET", f"/api/v1/picture.jpg{path}", token=program.watch_token)
        assert (status, headers["cache-control"]) == (200, "no-store")
        assert body.startswith(b"\xff\xd8")
        assert body.endswith(b"\xff\xd9")
        return body, int(headers["captured-ns"])

    _, first = picture("")
    program.wait(lambda status: status["track"]["captured_ns"] > first, "a later picture")
    plain, second = picture("")
    assert second > first
    drawn, _ = picture("?overlay=true")
    assert plain != drawn


def test_program_takes_the_control_from_a_page_and_gives_it_up(program: Program) -> None:
    page = page_of(program)
    page.send(Request("take-control").message(1))
    assert page.until("answer")["answer"] == "accepted"
    assert "a page is in control" in program.request(ENGAGE)["reason"]
    assert program.request(ASK_CONTROL)["answer"] == "accepted"

    def seat() -> Any:
        return json.loads(program.ask("GET", "/api/v1/control")[1])

    assert seat()["asking"] == [seat()["program"]]
    assert program.request(Request("take-control"))["answer"] == "accepted"
    assert seat()["holder"] == seat()["program"]
    assert program.request(ENGAGE)["answer"] == "accepted"
    assert program.request(DISENGAGE)["answer"] == "accepted"
    assert program.request(Request("release-control"))["answer"] == "accepted"
    assert seat()["holder"] is None
    page.close()


@pytest.fixture(scope="module")
def schemas(barrelman: pathlib.Path) -> Any:
    return json.loads(run([barrelman, "config", "api"]).stdout)


def fits(schemas: Any, name: str, value: Any) -> None:
    jsonschema.Draft202012Validator({"$ref": f"#/components/schemas/{name}", **schemas}).validate(value)


def test_status_and_answer_fit_their_schemas(program: Program, schemas: Any) -> None:
    fits(schemas, "StatusSnapshot", program.status())
    fits(schemas, "Answer", program.request(DISENGAGE))


def test_requests_fit_their_schemas(schemas: Any) -> None:
    fits(schemas, "RequestBody", {"id": 1, **select([1, 2, 3, 4], captured_ns=5).body})
    fits(schemas, "MessageToProgram", ASK_CONTROL.message(7))


def test_every_message_to_a_page_fits_its_schema(program: Program, schemas: Any) -> None:
    page = page_of(program)
    seen: set[str] = set()
    page.send({"type": "ping", "sent_ms": 1.5})
    page.send(ASK_CONTROL.message(7))
    wanted, until = {"hello", "events", "control", "snapshot", "pong", "answer"}, time.monotonic() + 30
    while not seen >= wanted and time.monotonic() < until and (message := page.read()):
        if message[0] == TEXT:
            content = json.loads(message[1])
            fits(schemas, "MessageToPage", content)
            seen.add(content["type"])
    page.close()
    assert seen >= wanted


@pytest.mark.parametrize(
    ("request_", "answer"),
    [(ENGAGE, "refused"), (STOP, "accepted")],
    ids=["a command is refused", "a stop is taken"],
)
def test_watcher(program: Program, request_: Any, answer: str) -> None:
    watcher = Socket(program.host, program.watch_token)
    watcher.send(request_.message(1))
    said = watcher.until("answer")
    watcher.close()
    assert said["answer"] == answer


@pytest.mark.parametrize(
    "message",
    [b'{"type":"ping","sent_ms":' + b" " * 5000 + b"1}", b"not JSON"],
    ids=["an oversized message", "a message that is none"],
)
def test_connection_is_ended_by(program: Program, message: bytes) -> None:
    page = page_of(program)
    page.send(message)
    assert page.closes(10)


def test_connection_is_ended_by_a_flood_of_messages(program: Program) -> None:
    page = page_of(program)
    try:
        for _ in range(3000):
            page.send(PING)
    except OSError:
        pass
    assert page.closes(10)


def test_connection_is_ended_by_slow_headers(program: Program) -> None:
    host, port = program.host.split(":")
    with socket.create_connection((host, int(port))) as slow:
        slow.sendall(b"GET / HTTP/1.1\r\nHost:")
        slow.settimeout(30)
        begin = time.monotonic()
        slow.recv(100)
        Delay.since(begin).judge(9)


def test_80_connections_at_once_leave_the_server_answering(program: Program) -> None:
    host, port = program.host.split(":")
    idle = [socket.create_connection((host, int(port))) for _ in range(80)]
    time.sleep(0.3)
    for connection in idle:
        connection.close()
    time.sleep(0.3)
    assert program.ask("GET", "/healthz", token=None)[1] == b"ok\n"


def test_of_20_pages_at_once_the_idlest_go_and_the_server_answers(program: Program) -> None:
    pages = [page_of(program) for _ in range(20)]
    assert program.status()["step"] > 0
    assert pages[0].closes(5) or pages[1].closes(5)
    for page in pages:
        page.close()


def test_page_that_is_silent_is_dropped(program: Program) -> None:
    assert page_of(program).closes(25)


@pytest.mark.apart
def test_page_that_does_not_read_holds_up_neither_memory_nor_pilot(
    barrelman: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    with Camera() as camera:
        program = Program(
            barrelman, "run", "--video", camera.url, "--select", SELECTION, "--record", tmp_path / "long.mcap"
        )
        program.wait_for_track()

        def opened() -> Socket:
            page = Socket(program.host, program.token, receive_buffer=4096)
            page.send({"type": "video", "path": "h264"})
            return page

        page = opened()
        time.sleep(4)
        before, steps, begin = memory_mb(program.child), program.status()["step"], time.monotonic()
        while time.monotonic() < begin + READS_NOTHING_S:
            try:
                page.send(PING)
            except OSError:
                page = opened()
            time.sleep(1)
        assert memory_mb(program.child) - before < GROWS_AT_MOST_MB
        assert (program.status()["step"] - steps) / took(begin, time.monotonic()) > 10
        page.close()
        assert program.end() == 0
