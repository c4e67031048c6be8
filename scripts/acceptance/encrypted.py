"""Connections over TLS."""

import contextlib
import select
import socket
import ssl
import threading


class Encrypted:
    """A connection over TLS, which two threads may use at a time: one reads, one sends."""

    def __init__(self, plain: socket.socket, tls: ssl.SSLContext, name: str) -> None:
        self.tls, self.lock = tls.wrap_socket(plain, server_hostname=name), threading.Lock()
        self.tls.setblocking(False)

    def _ready(self, reads: bool) -> None:
        waiting = [self.tls]
        if not any(select.select(waiting if reads else [], [] if reads else waiting, [], 10)):
            raise TimeoutError

    def recv(self, count: int) -> bytes:
        while True:
            with self.lock, contextlib.suppress(ssl.SSLWantReadError):
                return self.tls.recv(count)
            self._ready(reads=True)

    def sendall(self, data: bytes) -> None:
        while data:
            with self.lock, contextlib.suppress(ssl.SSLWantWriteError):
                data = data[self.tls.send(data) :]
                continue
            self._ready(reads=False)

    def close(self) -> None:
        self.tls.close()
