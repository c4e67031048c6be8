"""Live video over RTSP in TLS: an independent TLS server (Python's ssl) before an RTSP server on
loopback."""

import contextlib
import pathlib
import socket
import ssl
import threading
from collections.abc import Iterator

import pytest

from camera import HEIGHT, SELECTION, WIDTH, Camera
from conftest import Check
from machine import wait_until
from process import Lines, end, run, spawn

Certificate = tuple[pathlib.Path, pathlib.Path, str]
UP = "video: up"


class TlsFront:
    """Takes TLS connections, and passes their bytes to a port without TLS."""

    def __init__(self, certificate: pathlib.Path, key: pathlib.Path, port: int) -> None:
        self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self.context.load_cert_chain(certificate, key)
        self.behind = port
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"rtsps://127.0.0.1:{self.listener.getsockname()[1]}/video"
        self.connections: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                near, _ = self.listener.accept()
                threading.Thread(target=self._serve, args=(near,), daemon=True).start()

    def _serve(self, near: socket.socket) -> None:
        with contextlib.suppress(OSError):
            near = self.context.wrap_socket(near, server_side=True)
            far = socket.create_connection(("127.0.0.1", self.behind))
            self.connections += [near, far]
            threading.Thread(target=self._pass, args=(far, near), daemon=True).start()
            self._pass(near, far)

    @staticmethod
    def _pass(source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                sink.sendall(data)
        for side in (source, sink):
            with contextlib.suppress(OSError):
                side.shutdown(socket.SHUT_RDWR)

    def cut(self) -> None:
        """Ends all connections."""
        for side in self.connections:
            with contextlib.suppress(OSError):
                side.shutdown(socket.SHUT_RDWR)
        self.connections.clear()


@pytest.fixture(scope="module")
def front(certificate: Certificate) -> Iterator[TlsFront]:
    with Camera() as camera:
        yield TlsFront(certificate[0], certificate[1], camera.port)


def test_camera_with_the_expected_certificate_is_seen_and_seen_again(
    barrelman: pathlib.Path, front: TlsFront, certificate: Certificate, check: Check
) -> None:
    options = ["--select", SELECTION, "--video-certificate-sha256", certificate[2].replace(":", "")]
    child = spawn([barrelman, "run", "--headless", "--no-record", "--video", front.url, *options])
    errors = Lines(child.stderr)
    errors.wait_for(UP)
    errors.wait_for("following the selection")
    ups = errors.count(UP)
    front.cut()
    wait_until(lambda: errors.count(UP) > ups, "the video after a lost connection")
    check("the run ends with exit 0", end(child) == 0)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        pytest.param(["--video-certificate-sha256", "0" * 64], "SHA-256", id="another certificate"),
        pytest.param([], "certificate", id="a certificate that no authority has signed"),
    ],
)
def test_certificate_is_refused_with_the_reason(
    barrelman: pathlib.Path, front: TlsFront, options: list[str], expected: str
) -> None:
    child = spawn(
        [barrelman, "run", "--headless", "--no-record", "--video", front.url, "--select", SELECTION, *options]
    )
    errors = Lines(child.stderr)
    _, line = errors.wait_for("no video yet")
    end(child)
    assert expected in line
    assert UP not in errors.text()


def test_check_sees_the_first_picture(
    barrelman: pathlib.Path, front: TlsFront, certificate: Certificate
) -> None:
    checked = run(
        [
            barrelman,
            "check",
            "--video",
            front.url,
            "--video-certificate-sha256",
            certificate[2].replace(":", ""),
        ]
    )
    assert f"{WIDTH}x{HEIGHT} pictures" in checked.stdout
