"""Floods of the console by a watcher, or by somebody without a token, while the operator turns the camera and
presses Stop.

The operator holds the control on a WebSocket, turns the camera by hand and presses Stop, by turns on the
socket and by a request over HTTP on a connection of its own. Measured are the times from the press to the
answer, and to the zero rate at the emulated ground station, and the largest memory of the program. Each flood
(flooding.py) is a process of its own, which connects again as soon as the program disconnects it.
"""

import contextlib
import dataclasses
import http.client
import itertools
import json
import math
import pathlib
import socket
import ssl
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest

import flooding
from authority import Authority
from client import (
    CONTROL_TOKEN,
    DISENGAGE,
    REQUESTS,
    STOP,
    TEXT,
    WATCH_TOKEN,
    Request,
    Socket,
    ask,
    json_of,
    nudge,
)
from conftest import Check
from emulator import Emulator
from flooding import FLOODS, STOPS
from machine import NEVER, Delay, poll, wait_until
from process import Child, Lines, end, free_port, memory_mb, secret, spawn
from recording import Recording

pytestmark = [pytest.mark.alone, pytest.mark.clocked]

LIMIT_S = 0.1
# Processes and threads between a press and its answer (server, pilot, this test), and the zero (link, guard,
# emulator).
ANSWER_HOPS, ZERO_HOPS = 3, 5
NUDGE_INTERVAL = 0.05
# Between two rounds of a short flood, seconds: a debug build answers a tenth of the connections.
SHORT_PAUSE = 0.02
MEMORY_MB = 32
# A stop of the operator, as recorded.
STOPPED = {"kind": "stop", "cause": "operator"}


class Operator:
    """The page in control: a WebSocket that turns the camera by hand, and whose answers have their times."""

    def __init__(self, host: str, tls: ssl.SSLContext | None) -> None:
        self.host, self.tls = host, tls
        self.socket = Socket(host, CONTROL_TOKEN, query="?client=ab", tls=tls)
        self.lock, self.number, self.pan, self.is_open = threading.Lock(), 1000, 0.0, True
        self.answers: dict[int, tuple[float, str]] = {}
        for act in (self._read, self._turn):
            threading.Thread(target=act, daemon=True).start()

    def _read(self) -> None:
        while (message := self.socket.read()) is not None:
            if message[0] == TEXT and (content := json.loads(message[1]))["type"] == "answer":
                self.answers[content["id"]] = (time.monotonic(), content["answer"])
        self.is_open = False

    def _turn(self) -> None:
        while self.is_open:
            if self.pan:
                self.request(nudge(self.pan))
            else:
                self._send({"type": "ping", "sent_ms": 0})
            time.sleep(NUDGE_INTERVAL)

    def _send(self, message: object) -> None:
        with self.lock:
            try:
                self.socket.send(message)
            except OSError:
                self.is_open = False

    def request(self, request: Request) -> int:
        self.number += 1
        self._send(request.message(self.number))
        return self.number

    def stop_on_socket(self) -> Delay:
        """Presses Stop; the time until it is answered, infinity without an answer."""
        begin, number = time.monotonic(), self.request(STOP)
        at, answer = poll(
            lambda: self.answers.get(number) or (not self.is_open and (begin, "")), 5.0, 0.001
        ) or (begin, "")
        return Delay.between(begin, at, ANSWER_HOPS) if answer == "accepted" else NEVER

    def stop_over_http(self) -> Delay:
        """The same, by a request on a new connection."""
        begin = time.monotonic()
        with contextlib.suppress(OSError, http.client.HTTPException):
            code, body, _ = ask(self.host, "POST", REQUESTS, STOP.body, token=CONTROL_TOKEN, tls=self.tls)
            if code == 200 and json.loads(body)["answer"] == "accepted":
                return Delay.since(begin, ANSWER_HOPS)
        return NEVER


@dataclasses.dataclass
class Bench:
    """A run with an emulated ground station, and the operator."""

    host: str
    program: Child
    output: str
    record: pathlib.Path
    emulator: Emulator
    operator: Operator
    memory_mb: float
    # The file of the authority; None: without TLS.
    authority: pathlib.Path | None = None

    def rests_after(self, pressed: float) -> Delay | None:
        """The time from a press until no rate is in force; None for a camera that rested already, as its hand
        was not heard in time."""
        wait_until(lambda: self.emulator.since(pressed), "a line at the ground station")
        if not any(self.emulator.rates_at(pressed)):
            return None
        poll(lambda: self.emulator.rest_at(pressed) < math.inf, 5.0, 0.002)
        return Delay.between(pressed, self.emulator.rest_at(pressed), ZERO_HOPS)

    def press_stops(self, count: int, turns: bool) -> tuple[dict[str, list[Delay]], list[Delay]]:
        """Turns the camera and stops it, `count` times. Returns the times to the answers and to the zeros at
        the vehicle.

        Without `turns` the camera rests, as others stop it all the time.
        """
        answers: dict[str, list[Delay]] = {"socket": [], "HTTP": []}
        zeros: list[Delay] = []
        for number in range(count):
            if turns:
                self.operator.request(DISENGAGE)
                self.operator.pan = 0.5 if number % 2 else -0.5
                self.emulator.wait_for(
                    lambda row: any(row.rates), "a rate: the operator is kept out", time.monotonic()
                )
            time.sleep(0.1)
            # The hand lets go with the press: what is sent before it is older.
            self.operator.pan = 0.0
            pressed = time.monotonic()
            for way, press in (
                ("socket", self.operator.stop_on_socket),
                ("HTTP", self.operator.stop_over_http),
            ):
                if not turns or number % 2 == (way == "HTTP"):
                    answers[way].append(press())
            rests = self.rests_after(pressed) if turns else None
            zeros += [] if rests is None else [rests]
        return answers, zeros


@pytest.fixture(scope="module")
def bench(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with started(barrelman, tmp_path_factory.mktemp("floods")) as bench:
        yield bench


@pytest.fixture(scope="module")
def encrypted_bench(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    folder = tmp_path_factory.mktemp("encrypted-floods")
    authority = Authority(folder / "authority")
    with started(barrelman, folder, authority) as bench:
        yield bench


@contextlib.contextmanager
def started(
    barrelman: pathlib.Path, folder: pathlib.Path, authority: Authority | None = None
) -> Iterator[Bench]:
    path = authority.path if authority else None
    tls = ssl.create_default_context(cafile=path) if path else None
    files = authority.issue("127.0.0.1") if authority else ()
    encryption = zip(("--tls-certificate", "--tls-key"), files, strict=False)
    record, host = folder / "run.mcap", f"127.0.0.1:{free_port()}"
    tokens = secret(folder / "tokens", CONTROL_TOKEN, WATCH_TOKEN)
    with Emulator(barrelman, folder) as emulator:
        what = [
            "--video",
            "sim:open?seed=3&size=640x360",
            "--link",
            emulator.url,
            "--record",
            record,
        ]
        program = spawn(
            [
                *(barrelman, "run", *what, "--listen", host, "--console-token-file", tokens),
                *itertools.chain(*encryption),
            ],
            stdout=subprocess.PIPE,
        )
        out, errors = Lines(program.stdout), Lines(program.stderr)
        out.wait_for("console.*https?://")
        errors.wait_for("link up")
        yield Bench(
            host,
            program,
            out.text() + errors.text(),
            record,
            emulator,
            Operator(host, tls),
            memory_mb(program, "VmHWM"),
            path,
        )
        end(program)


def test_tokens_of_a_file_are_not_printed(bench: Bench) -> None:
    assert CONTROL_TOKEN not in bench.output


def test_recording_is_for_its_owner_alone(bench: Bench) -> None:
    assert bench.record.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize(
    "stops", [4, pytest.param(40, marks=pytest.mark.strict)], ids=lambda stops: f"{stops} stops"
)
@pytest.mark.parametrize("name", [None, *FLOODS], ids=lambda name: name or "no flood")
def test_stop_is_answered_and_carried_out_under_a_flood_of(
    bench: Bench, check: Check, name: str | None, stops: int
) -> None:
    stop_under_flood(bench, check, name, stops)


@pytest.mark.parametrize("name", ["new connections", "tiny messages"])
def test_stop_is_answered_and_carried_out_over_tls_under_a_flood_of(
    encrypted_bench: Bench, check: Check, name: str
) -> None:
    stop_under_flood(encrypted_bench, check, name, 4)


def stop_under_flood(bench: Bench, check: Check, name: str | None, stops: int) -> None:
    pause = SHORT_PAUSE if stops < 10 else 0
    authority = [bench.authority] if bench.authority else []
    words = [sys.executable, flooding.__file__, name, bench.host, pause, *authority]
    flood = spawn(words, stderr=subprocess.DEVNULL) if name else None
    time.sleep(0.5)
    answers, zeros = bench.press_stops(stops, turns=name != STOPS)
    for what, delays in [
        *((f"the answer by {way}", found) for way, found in answers.items()),
        ("the zero at the ground station", zeros),
    ]:
        if delays or "zero" not in what:
            worst = max(delays, default=NEVER, key=lambda delay: delay.seconds)
            check.in_time(f"{what} comes within {LIMIT_S * 1e3:.0f} ms", worst, LIMIT_S)
    if flood:
        check("the flood went on", flood.poll() is None)
        flood.kill()
        flood.wait()
    check("the operator's page stays", bench.operator.is_open)
    after = memory_mb(bench.program, "VmHWM")
    is_small = after - bench.memory_mb <= MEMORY_MB
    check(
        f"the largest memory since the first flood grows by at most {MEMORY_MB} MB",
        is_small,
        f"{bench.memory_mb:.0f}, then {after:.0f} MB",
    )


def test_operator_is_let_in_beside_512_connections_without_a_token(bench: Bench) -> None:
    name, port = bench.host.split(":")
    with contextlib.ExitStack() as waiting:
        for _ in range(512):
            waiting.enter_context(socket.create_connection((name, int(port))))
        begin = time.monotonic()
        code, *_ = ask(bench.host, "GET", "/api/v1/status", token=CONTROL_TOKEN)
        delay = Delay.since(begin, 2)
    assert code == 200
    delay.judge(LIMIT_S)


@pytest.mark.parametrize(
    "seconds", [1.0, pytest.param(6.0, marks=pytest.mark.long)], ids=lambda seconds: f"{seconds:.0f} s"
)
def test_stops_of_a_watcher_are_acknowledged_and_not_recorded(
    bench: Bench, check: Check, seconds: float
) -> None:
    bench.operator.pan = 0.0
    bench.operator.stop_on_socket()
    codes, began = [], time.monotonic()
    headers = {"Authorization": f"Bearer {WATCH_TOKEN}", "Content-Type": "application/json"}
    with contextlib.closing(http.client.HTTPConnection(bench.host, timeout=5)) as connection:
        while time.monotonic() < began + seconds:
            connection.request("POST", REQUESTS, json_of(STOP.body), headers)
            answer = connection.getresponse()
            codes.append(answer.status if json.loads(answer.read())["answer"] == "accepted" else 0)
    check("every stop is acknowledged", set(codes) == {200}, f"{len(codes)} stops")
    # What is recorded is flushed twice a second.
    time.sleep(1.0)
    recording = Recording(bench.record)
    recorded = sum(
        request == STOPPED and recording.at(now_ns) >= began for now_ns, request in recording.requests()
    )
    check("none is recorded while one is in force", recorded == 0, f"{recorded} of {len(codes)}")


def test_further_requests_of_a_watcher_are_refused_and_those_of_the_operator_are_not(bench: Bench) -> None:
    seen = [ask(bench.host, "GET", "/api/v1/status", token=WATCH_TOKEN)[0] for _ in range(500)]
    assert 429 in seen
    assert ask(bench.host, "GET", "/api/v1/status", token=CONTROL_TOKEN)[0] == 200
