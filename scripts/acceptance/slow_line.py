"""A slow line with a large buffer between a page and the program, as a weak radio has."""

import contextlib
import queue
import socket
import threading
import time
from typing import Self

PIECE = 1 << 12


class SlowLine:
    """Takes connections, and passes them on to a port: to the program at once, to the page as slowly as said.

    What the program sends is taken at once, and waits here: the program does not feel how slow the line is.
    """

    def __init__(self) -> None:
        # Where the program listens.
        self.leads_to = 0
        # Bytes a second to the page; None: no limit.
        self.rate: float | None = None
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.host = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                page, _ = self._listener.accept()
                program = socket.create_connection(("127.0.0.1", self.leads_to))
                threading.Thread(target=self._pass_on, args=(page, program), daemon=True).start()
                threading.Thread(target=self._delay, args=(program, page), daemon=True).start()

    @staticmethod
    def _pass_on(source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while piece := source.recv(PIECE):
                sink.sendall(piece)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def _delay(self, source: socket.socket, sink: socket.socket) -> None:
        waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()

        def send() -> None:
            with contextlib.suppress(OSError):
                while piece := waiting.get():
                    sink.sendall(piece)
                    if self.rate:
                        time.sleep(len(piece) / self.rate)
                sink.shutdown(socket.SHUT_RDWR)

        threading.Thread(target=send, daemon=True).start()
        with contextlib.suppress(OSError):
            while piece := source.recv(PIECE):
                waiting.put(piece)
        waiting.put(b"")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()
