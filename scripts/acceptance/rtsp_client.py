"""A client of RTSP that does what a test asks of it: it gives any login, stops reading, goes on."""

import base64
import contextlib
import hashlib
import re
import socket
import time
from typing import Self

USER = "watch"


class RtspClient:
    """A connection. `password`: None for a client without a login."""

    def __init__(self, url: str, password: str | None = None, way: str = "digest") -> None:
        found = re.fullmatch(r"rtsp://([^:/]+):(\d+)/.+", url)
        assert found, url
        self.url, self.password, self.way = url, password, way
        self.socket = socket.socket()
        # What the test does not read stays with the server, not in a buffer here.
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 64 * 1024)
        self.socket.settimeout(30)
        self.socket.connect((found[1], int(found[2])))
        self.sequence, self.realm, self.nonce, self.session = 0, "", "", ""
        self.received = b""

    def authorization(self, method: str, url: str) -> str:
        if self.password is None:
            return ""
        if self.way == "basic":
            login = base64.b64encode(f"{USER}:{self.password}".encode()).decode()
            return f"Authorization: Basic {login}\r\n"
        if not self.nonce:
            return ""
        first, second = (
            hashlib.md5(text.encode()).hexdigest()
            for text in (f"{USER}:{self.realm}:{self.password}", f"{method}:{url}")
        )
        response = hashlib.md5(f"{first}:{self.nonce}:{second}".encode()).hexdigest()
        return (
            f'Authorization: Digest username="{USER}", realm="{self.realm}", nonce="{self.nonce}", '
            f'uri="{url}", response="{response}"\r\n'
        )

    def ask(self, method: str, path: str = "", more: str = "") -> tuple[int, str]:
        """The status of an answer, and its head and body. Answers a challenge for a digest once."""
        status, answer = self._ask_once(method, self.url + path, more)
        challenge = re.search(r'Digest realm="([^"]*)", nonce="([^"]*)"', answer)
        if status == 401 and challenge and not self.nonce and self.password and self.way == "digest":
            self.realm, self.nonce = challenge[1], challenge[2]
            status, answer = self._ask_once(method, self.url + path, more)
        return status, answer

    def _ask_once(self, method: str, url: str, more: str) -> tuple[int, str]:
        self.sequence += 1
        session = f"Session: {self.session}\r\n" if self.session else ""
        head = f"{method} {url} RTSP/1.0\r\nCSeq: {self.sequence}\r\n"
        self.socket.sendall((head + session + self.authorization(method, url) + more + "\r\n").encode())
        head = self._until(b"\r\n\r\n").decode()
        length = re.search(r"Content-Length: (\d+)", head)
        body = self._exactly(int(length[1])).decode() if length else ""
        return int(head.split()[1]), head + body

    def play(self) -> None:
        """Asks for the video, in the TCP connection."""
        status, answer = self.ask("DESCRIBE", more="Accept: application/sdp\r\n")
        assert status == 200, answer
        track = re.findall(r"a=control:(\S+)", answer)[-1]
        status, answer = self.ask("SETUP", f"/{track}", "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\n")
        assert status == 200, answer
        found = re.search(r"Session: ([^;\r]+)", answer)
        assert found, answer
        self.session = found[1]
        status, answer = self.ask("PLAY")
        assert status == 200, answer

    def packet(self) -> bytes:
        """The next RTP packet."""
        while True:
            head = self._exactly(4)
            assert head[:1] == b"$", head
            packet = self._exactly(int.from_bytes(head[2:], "big"))
            if head[1] == 0:
                return packet

    def times(self, seconds: float) -> list[float]:
        """The times of the pictures, seconds of their RTP clock, that come within this time."""
        times: list[float] = []
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            at = int.from_bytes(self.packet()[4:8], "big") / 90_000
            if not times or times[-1] != at:
                times.append(at)
        return times

    def _until(self, mark: bytes) -> bytes:
        while mark not in self.received:
            self._receive()
            # Packets may come before the answer.
            while self.received[:1] == b"$" and len(self.received) >= 4:
                size = 4 + int.from_bytes(self.received[2:4], "big")
                if len(self.received) < size:
                    break
                self.received = self.received[size:]
        found, _, self.received = self.received.partition(mark)
        return found + mark

    def _exactly(self, count: int) -> bytes:
        while len(self.received) < count:
            self._receive()
        found, self.received = self.received[:count], self.received[count:]
        return found

    def _receive(self) -> None:
        part = self.socket.recv(65_536)
        if not part:
            raise ConnectionError("the server closed the connection")
        self.received += part

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self.socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
