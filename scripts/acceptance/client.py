"""The console's interface for programs: requests, a run with its console, and WebSockets.

The form of a request stands in this file alone.
"""

import contextlib
import http.client
import json
import pathlib
import signal
import socket
import ssl
import subprocess
import time
from collections.abc import Callable, Iterable
from typing import Any, Self

from encrypted import Encrypted
from machine import PATIENCE_S, wait_until
from process import Child, HasEndedError, Lines, end, spawn

REQUESTS = "/api/v1/requests"
CONTROL_TOKEN, WATCH_TOKEN = "control-token-of-the-test", "watch-token-of-the-test"
# The optimal law's mode that moves the camera nearly all the time, so that each case finds the camera in
# motion.
HARDLY_RESTS = "minimum-energy"
WORLD = "sim:arena1?seed=3&size=640x360"


class Request(dict[str, Any]):
    """A request to the pilot."""

    def __init__(self, kind: str, **more: Any) -> None:
        super().__init__(kind=kind, **more)

    @property
    def body(self) -> dict[str, Any]:
        """What is posted to REQUESTS."""
        return {"request": self}

    def message(self, number: int) -> dict[str, Any]:
        """What is sent on a WebSocket."""
        return {"type": "request", "id": number, "request": self}


STOP, ENGAGE, DISENGAGE, DESELECT = (
    Request("stop"),
    Request("engage"),
    Request("disengage"),
    Request("deselect"),
)
GUIDE, ASK_CONTROL = Request("guide"), Request("ask-control")
PAUSE, RESUME = Request("pause"), Request("resume")
UNKNOWN = Request("fly")


def nudge(pan: float, tilt: float = 0.0, zoom: float = 0.0) -> Request:
    return Request("nudge", pan=pan, tilt=tilt, zoom=zoom)


def select(bounds: Iterable[float], captured_ns: int) -> Request:
    return Request("select", bounds=dict(zip("uvwh", bounds, strict=True)), captured_ns=captured_ns)


def ask(
    host: str,
    method: str,
    path: str,
    body: Any = None,
    headers: dict[str, str] | None = None,
    token: str | None = None,
    tls: ssl.SSLContext | None = None,
) -> tuple[int, bytes, Any]:
    """The status, the body and the headers of an answer."""
    headers = dict(headers or {})
    if token:
        headers.setdefault("Authorization", f"Bearer {token}")
    if body is not None:
        headers.setdefault("Content-Type", "application/json")
    connection = (
        http.client.HTTPSConnection(host, timeout=15, context=tls)
        if tls
        else http.client.HTTPConnection(host, timeout=15)
    )
    with contextlib.closing(connection):
        connection.request(
            method, path, body if body is None or isinstance(body, str | bytes) else json.dumps(body), headers
        )
        answer = connection.getresponse()
        return answer.status, answer.read(), answer.headers


def is_inside(status: Any) -> bool:
    """Whether the boat is known to be in the ellipse."""
    return bool((status["percept"] or {}).get("p", 9) < 1)


class Program:
    """A running `demo` or `run` with its console."""

    def __init__(
        self, barrelman: pathlib.Path, command: str, *options: Any, listen: str = "127.0.0.1:0"
    ) -> None:
        self.child: Child = spawn([barrelman, command, "--listen", listen, *options], stdout=subprocess.PIPE)
        self.lines, self.errors = Lines(self.child.stdout), Lines(self.child.stderr)
        self.url = wait_until(
            self._url, lambda: f"the console of {' '.join(map(str, options))}; {self.errors.text()[-400:]}"
        )
        self.watch_url = (
            self.lines.wait_for("watch only: https?://")[1].split(": ", 1)[1].strip()
            if "#token=" in self.url
            else ""
        )
        self.host = self.url.split("://")[1].split("/")[0]
        self.token, self.watch_token = (url.partition("#token=")[2] for url in (self.url, self.watch_url))

    def _url(self) -> str | None:
        if self.child.poll() is not None:
            raise HasEndedError(self.errors.text()[-400:])
        found = self.lines.find(r"console.*https?://")
        return found[1].split(": ", 1)[1].strip() if found else None

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        headers: dict[str, str] | None = None,
        token: str | None = "",
    ) -> tuple[int, bytes, Any]:
        """As `ask`, with the token for the control unless another one, or none, is given."""
        return ask(self.host, method, path, body, headers, self.token if token == "" else token)

    def status(self) -> Any:
        return json.loads(self.ask("GET", "/api/v1/status")[1])

    def request(self, request: Request, token: str = "") -> Any:
        """Makes a request as a program, and returns its answer."""
        code, body, _ = self.ask("POST", REQUESTS, request.body, token=token)
        return json.loads(body) if code == 200 else {"answer": f"HTTP {code}", "reason": body.decode()}

    def resume(self) -> None:
        """Lets the world go on that waits for the first box. Before the world has begun, nothing is taken."""
        wait_until(lambda: self.request(RESUME)["answer"] == "accepted", "a world that goes on")

    def wait(self, condition: Callable[[Any], Any], what: str, seconds: float = PATIENCE_S) -> Any:
        """Waits for a state."""
        seen: list[Any] = []

        def holds() -> Any:
            try:
                seen[:] = [self.status()]
            except ConnectionError as error:
                raise HasEndedError(f"{what}: {self.errors.text()[-400:]}") from error
            return seen[0] if condition(seen[0]) else None

        return wait_until(
            holds,
            lambda: f"{what} ({json.dumps(seen[0])[:4000]}; {self.errors.text()[-600:]})",
            seconds,
            0.05,
        )

    def wait_for_track(self) -> None:
        self.wait(lambda status: (status["track"] or {}).get("state") == "tracking", "the track")

    def end(self) -> int:
        """Ends the program as Ctrl-C does."""
        code = end(self.child, signal.SIGINT)
        self.errors.join()
        return code

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.child.poll() is None:
            self.end()


class EngagedRun(Program):
    """A run that is engaged from the start, whose video is a simulated world's that nothing moves unless
    another is given."""

    def __init__(self, barrelman: pathlib.Path, *options: Any, video: str | None = WORLD) -> None:
        words = ["--video", video] if video else []
        super().__init__(
            barrelman, "run", "--engage", "--no-record", "--mode", HARDLY_RESTS, *options, *words
        )


def json_of(content: Any) -> bytes:
    return json.dumps(content).encode()


def masked(kind: int, content: bytes = b"") -> bytes:
    """A frame of a WebSocket client. Its mask is zero, so that the content stays as it is."""
    size = len(content)
    head = (
        bytes([0x80 | size])
        if size < 126
        else b"\xfe" + size.to_bytes(2, "big")
        if size < 65536
        else b"\xff" + size.to_bytes(8, "big")
    )
    return bytes([kind]) + head + b"\0\0\0\0" + content


def head(line: str, host: str, token: str | None, *more: str) -> bytes:
    """The head of a request."""
    words = [
        f"{line} HTTP/1.1",
        f"Host: {host}",
        *more,
        *([f"Authorization: Bearer {token}"] if token else []),
    ]
    return ("\r\n".join(words) + "\r\n\r\n").encode()


UPGRADE = (
    "Connection: Upgrade",
    "Upgrade: websocket",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
)
TEXT, CLOSE = 1, 8


class Socket:
    """A minimal WebSocket client: reads unmasked frames, sends masked frames."""

    def __init__(
        self,
        host: str,
        token: str | None,
        receive_buffer: int | None = None,
        query: str = "",
        tls: ssl.SSLContext | None = None,
    ) -> None:
        name, port = host.split(":")
        plain = socket.create_connection((name, int(port)), timeout=10)
        plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if receive_buffer:
            plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket = Encrypted(plain, tls, name) if tls else plain
        self.socket.sendall(head(f"GET /api/v1/socket{query}", host, token, *UPGRADE))
        first = answer = self._line()
        while answer.strip():
            answer = self._line()
        self.accepted = b" 101 " in first

    def _line(self) -> bytes:
        line = b""
        while not line.endswith(b"\n") and (piece := self.socket.recv(1)):
            line += piece
        return line

    def send(self, message: Any) -> None:
        self.socket.sendall(masked(0x81, message if isinstance(message, bytes) else json_of(message)))

    def read(self) -> tuple[int, bytes] | None:
        """The next message as (opcode, content); None if the connection has ended."""
        try:
            start = self._exactly(2)
            size = start[1] & 127
            size = int.from_bytes(self._exactly({126: 2, 127: 8}[size]), "big") if size > 125 else size
            kind, content = start[0] & 15, self._exactly(size)
            return None if kind == CLOSE else (kind, content)
        except (OSError, EOFError):
            return None

    def until(self, kind: str, seconds: float = 20.0) -> Any:
        """The next text message of this type; None if the connection ends or no such message arrives in
        time."""
        until = time.monotonic() + seconds
        while time.monotonic() < until and (message := self.read()) is not None:
            if message[0] == TEXT and (content := json.loads(message[1]))["type"] == kind:
                return content
        return None

    def closes(self, seconds: float) -> bool:
        """Whether the connection ends within this time."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            if self.read() is None:
                return True
        return False

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            piece = self.socket.recv(count - len(data))
            if not piece:
                raise EOFError
            data += piece
        return data

    def close(self) -> None:
        self.socket.close()
