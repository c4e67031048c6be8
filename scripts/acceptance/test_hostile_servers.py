"""No server fills the program's memory, and no password goes where it should not.

Each hostile server speaks to a run of its own for some seconds; the most memory that the run ever had (VmHWM)
is judged.
"""

import base64
import contextlib
import os
import pathlib
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, Self

import pytest

from independent_sigma import TOKEN, Sigma
from process import Child, Lines, end, memory_mb, secret, spawn

MEMORY_LIMIT_MB = 150
LASTS_S = 8.0
NOISE = os.urandom(1 << 16).replace(b"\n", b"x").replace(b"\r", b"x")
SPS, PPS = base64.b64decode("Z0LAHtoCgL/lmoCAgKAAAAMAIAAAB4HixdQ="), base64.b64decode("aM48gA==")
SELECT = ("--select", "100,100,40,40")

Answer = Callable[["RtspServer", socket.socket, str, str, str], None]


class RtspServer:
    """Answers each request of a client by `answer(server, connection, method, cseq, head)`; keeps the heads
    that it got."""

    def __init__(self, answer: Answer) -> None:
        self.answer, self.ended = answer, False
        self.heads: list[str] = []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def url(self) -> str:
        return f"rtsp://127.0.0.1:{self.port}/live"

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                connection, _ = self.listener.accept()
                threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        with contextlib.suppress(OSError, ValueError, StopIteration):
            held = b""
            while data := connection.recv(65536):
                held += data
                while b"\r\n\r\n" in held:
                    head, held = held.split(b"\r\n\r\n", 1)
                    self.heads.append(head.decode())
                    method = head.split(b" ", 1)[0].decode()
                    cseq = next(
                        line.split(b":")[1].strip().decode()
                        for line in head.split(b"\r\n")
                        if line.lower().startswith(b"cseq")
                    )
                    self.answer(self, connection, method, cseq, head.decode())
        connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.ended = True
        self.listener.close()


def reply(
    connection: socket.socket,
    cseq: str,
    status: str = "200 OK",
    headers: tuple[str, ...] = (),
    body: bytes = b"",
) -> None:
    lines = [f"RTSP/1.0 {status}", f"CSeq: {cseq}", *headers] + (
        [f"Content-Length: {len(body)}"] if body else []
    )
    connection.sendall(("\r\n".join(lines) + "\r\n\r\n").encode() + body)


def flood(server: RtspServer, connection: socket.socket, piece: bytes) -> None:
    while not server.ended:
        connection.sendall(piece)


def endless_head(server: RtspServer, connection: socket.socket, _method: str, cseq: str, _head: str) -> None:
    connection.sendall(f"RTSP/1.0 200 OK\r\nCSeq: {cseq}\r\nX: ".encode())
    flood(server, connection, NOISE)


def many_header_lines(
    server: RtspServer, connection: socket.socket, _method: str, cseq: str, _head: str
) -> None:
    connection.sendall(f"RTSP/1.0 200 OK\r\nCSeq: {cseq}\r\n".encode())
    flood(server, connection, b"X: y\r\n" * 10_000)


def endless_body(server: RtspServer, connection: socket.socket, _method: str, cseq: str, _head: str) -> None:
    connection.sendall(f"RTSP/1.0 200 OK\r\nCSeq: {cseq}\r\nContent-Length: 4294967290\r\n\r\n".encode())
    flood(server, connection, NOISE)


def large_sdp(_server: RtspServer, connection: socket.socket, _method: str, cseq: str, _head: str) -> None:
    line = b"a=x:" + b"y" * 1000 + b"\r\n"
    reply(connection, cseq, headers=("Content-Type: application/sdp",), body=b"v=0\r\n" + line * 50_000)


def sdp() -> bytes:
    sets = f"{base64.b64encode(SPS).decode()},{base64.b64encode(PPS).decode()}"
    return (
        f"v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=x\r\nt=0 0\r\na=control:*\r\n"
        f"m=video 0 RTP/AVP 96\r\nc=IN IP4 0.0.0.0\r\na=rtpmap:96 H264/90000\r\n"
        f"a=fmtp:96 packetization-mode=1;profile-level-id={SPS[1:4].hex()};sprop-parameter-sets={sets}\r\n"
        f"a=control:trackID=1\r\n"
    ).encode()


def started(connection: socket.socket, method: str, cseq: str) -> bool:
    """Answers until PLAY. Returns whether the stream begins."""
    if method == "DESCRIBE":
        reply(connection, cseq, headers=("Content-Type: application/sdp",), body=sdp())
    elif method == "SETUP":
        reply(connection, cseq, headers=("Transport: RTP/AVP/TCP;unicast;interleaved=0-1", "Session: 7"))
    else:
        reply(connection, cseq, headers=("Session: 7",))
    return method == "PLAY"


def endless_unit(server: RtspServer, connection: socket.socket, method: str, cseq: str, _head: str) -> None:
    """Fragments of one access unit that never ends."""
    if started(connection, method, cseq):
        sequence = 0
        while not server.ended:
            indicator = bytes([0x7C, 0x85 if sequence == 0 else 0x05])
            packet = (
                bytes([0x80, 96])
                + sequence.to_bytes(2, "big")
                + bytes(4)
                + bytes([1, 2, 3, 4])
                + indicator
                + NOISE[:60_000]
            )
            connection.sendall(b"$\0" + len(packet).to_bytes(2, "big") + packet)
            sequence = (sequence + 1) & 0xFFFF


def server_requests(
    server: RtspServer, connection: socket.socket, method: str, cseq: str, _head: str
) -> None:
    """Requests of the server, as fast as they are taken."""
    if started(connection, method, cseq):
        threading.Thread(target=lambda: drain(connection), daemon=True).start()
        with contextlib.suppress(OSError):
            for number in range(1 << 30):
                if server.ended:
                    return
                connection.sendall(f"OPTIONS rtsp://127.0.0.1/ RTSP/1.0\r\nCSeq: {number}\r\n\r\n".encode())
                time.sleep(0.01)


def drain(connection: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while connection.recv(65536):
            pass


class PingingSigma(Sigma):
    """Pings as fast as the socket takes them, and reads no answer."""

    def speak(self, handler: Any) -> None:
        handler.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        super_write = handler.wfile.write
        calls: list[int] = []

        def write(data: bytes) -> None:
            super_write(data)
            calls.append(1)
            if len(calls) > 1:
                handler.wfile.flush()
                while True:
                    handler.connection.sendall((b"\x89\x7d" + b"p" * 125) * 500)

        handler.wfile.write = write
        super().speak(handler)


class EndlessSigma(Sigma):
    """Answers some paths with a head or a body that does not end."""

    paths: tuple[str, ...] = ()
    begins = b""

    def serve(self, handler: Any, method: str) -> None:
        if handler.path.endswith(self.paths):
            handler.wfile.write(self.begins)
            with contextlib.suppress(OSError):
                while True:
                    handler.wfile.write(NOISE)
        super().serve(handler, method)


class LongBodies(EndlessSigma):
    paths = ("/camera/state", "/flight/state", "/system/state")
    begins = b"HTTP/1.1 200 OK\r\nContent-Length: 4294967290\r\n\r\n"


class LongHeads(EndlessSigma):
    paths = ("/flight/state",)
    begins = b"HTTP/1.1 200 OK\r\nX: "


def basic_only(
    _server: RtspServer,
    connection: socket.socket,
    _method: str,
    cseq: str,
    head: str,
    kinds: tuple[str, ...] = ('Basic realm="x"',),
) -> None:
    if "Authorization" in head:
        reply(connection, cseq, "404 Not Found")
    else:
        reply(connection, cseq, "401 Unauthorized", tuple(f"WWW-Authenticate: {kind}" for kind in kinds))


def digest_or_basic(server: RtspServer, connection: socket.socket, method: str, cseq: str, head: str) -> None:
    basic_only(server, connection, method, cseq, head, ('Digest realm="x", nonce="0123"', 'Basic realm="x"'))


def start(barrelman: pathlib.Path, *options: Any) -> tuple[Child, Lines]:
    child = spawn([barrelman, "run", "--headless", "--no-record", *options])
    return child, Lines(child.stderr)


def text_of(barrelman: pathlib.Path, seconds: float, *options: Any) -> tuple[int | None, str]:
    """The exit code, None for a run that lasts longer, and the errors of a run."""
    child, errors = start(barrelman, *options)
    with contextlib.suppress(subprocess.TimeoutExpired):
        child.wait(timeout=seconds)
    code = child.poll()
    child.kill()
    errors.join()
    return code, errors.text()


def memory_stays_small(barrelman: pathlib.Path, *options: Any) -> str:
    """Requires that a run for some seconds stays small. Returns its errors."""
    child, errors = start(barrelman, *options)
    most, until = 0.0, time.monotonic() + LASTS_S
    while time.monotonic() < until and child.poll() is None:
        most = max(most, memory_mb(child, "VmHWM"))
        time.sleep(0.1)
    if child.poll() is None:
        end(child)
    assert 0 < most < MEMORY_LIMIT_MB, errors.text()[-200:]
    return errors.text()


@pytest.mark.apart
@pytest.mark.parametrize(
    "answer", [endless_head, many_header_lines, endless_body, large_sdp, endless_unit, server_requests]
)
def test_rtsp_server_does_not_fill_the_memory(barrelman: pathlib.Path, answer: Answer) -> None:
    with RtspServer(answer) as server:
        said = memory_stays_small(barrelman, "--video", server.url, *SELECT)
    # Nor the log.
    assert answer is not server_requests or len(said.splitlines()) < 30


@pytest.mark.apart
@pytest.mark.parametrize("vehicle", [PingingSigma, LongBodies, LongHeads])
def test_vehicle_does_not_fill_the_memory(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, vehicle: type[Sigma]
) -> None:
    sigma = vehicle()
    link = [
        "--profile",
        "fotokite-sigma",
        "--link",
        sigma.url,
        "--link-token-file",
        secret(tmp_path / "token", TOKEN),
    ]
    memory_stays_small(barrelman, "--video", "sim:arena1?size=320x180", *link)
    sigma.close()


@pytest.mark.apart
@pytest.mark.parametrize(
    ("answer", "is_allowed", "sends"),
    [
        pytest.param(basic_only, False, "nothing", id="a server that takes Basic alone gets no password"),
        pytest.param(basic_only, True, "Basic", id="video.allow_basic_login sends it"),
        pytest.param(digest_or_basic, False, "Digest", id="a server that takes Digest, too, gets Digest"),
    ],
)
def test_login_goes_only_where_it_may(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, answer: Answer, is_allowed: bool, sends: str
) -> None:
    config = tmp_path / "basic.toml"
    config.write_text("[video]\nallow_basic_login = true\n")
    login = secret(tmp_path / "login", "admin:s3cret")
    with RtspServer(answer) as server:
        words = ["--video", server.url, "--video-login-file", login, *SELECT]
        _, said = text_of(barrelman, 4, *([config] if is_allowed else []), *words)
    lines = [line for head in server.heads for line in head.splitlines()]
    kinds = {line.split()[1] for line in lines if line.startswith("Authorization")} or {"nothing"}
    assert kinds == {sends}, said
    assert sends != "nothing" or ("rtsps://" in said and "allow_basic_login" in said)


class NamingSigma(Sigma):
    """Names this address of its video."""

    video = ""

    def answer(self, method: str, path: str, authorization: str | None, body: bytes) -> tuple[int, Any]:
        status, answer = super().answer(method, path, authorization, body)
        if path == "/v1/videostreams" and status == 200:
            answer[0]["rtsp_url"] = self.video
        return status, answer


@pytest.fixture
def naming() -> Iterator[NamingSigma]:
    sigma = NamingSigma()
    yield sigma
    sigma.close()


@pytest.mark.apart
@pytest.mark.parametrize(
    "video",
    [
        pytest.param("sim:arena1", id="a simulated world"),
        pytest.param("file:/etc/hostname", id="a file"),
        pytest.param("SIM:arena1", id="a scheme in capitals"),
        pytest.param("rtsp://127.0.0.2:8554/x", id="another host"),
        pytest.param("rtsp://u:p@127.0.0.1:8554/x", id="a login"),
        pytest.param("rtsp://127.0.0.1:8554/x?fault=stall%401", id="an option"),
    ],
)
def test_video_that_a_vehicle_names_is_refused(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, naming: NamingSigma, video: str
) -> None:
    naming.video = video
    link = [
        "--profile",
        "fotokite-sigma",
        "--link",
        naming.url,
        "--link-token-file",
        secret(tmp_path / "token", TOKEN),
    ]
    code, said = text_of(barrelman, 30, "--engage", *link)
    assert code == 1, said
    assert "the vehicle names" in said
    assert not [motion for motion in naming.motions if any(motion[1])]


@pytest.mark.apart
@pytest.mark.parametrize(
    "is_named",
    [False, True],
    ids=["without its address in the file, gets no login", "whose address is in the file, gets it"],
)
def test_video_that_a_vehicle_names(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, naming: NamingSigma, is_named: bool
) -> None:
    with RtspServer(digest_or_basic) as server:
        login = secret(
            tmp_path / "login", "admin:s3cret", *([f"host 127.0.0.1:{server.port}"] if is_named else [])
        )
        naming.video = server.url
        link = [
            "--profile",
            "fotokite-sigma",
            "--link",
            naming.url,
            "--link-token-file",
            secret(tmp_path / "token", TOKEN),
        ]
        _, said = text_of(barrelman, 4, *link, "--video-login-file", login)
    assert any("Authorization" in head for head in server.heads) == is_named, said
