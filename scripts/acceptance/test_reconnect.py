"""The return of a page whose network was cut: its connections go silent without an end, and new ones work at
once.

The page in headless Chromium reaches the program through a relay on loopback, which drops all bytes of the
connections that it has, and closes none: as after a change of the wireless network.
"""

import contextlib
import pathlib
import signal
import socket
import threading
import time

import pytest

from client import Program
from conftest import Check
from machine import Delay
from page import Page
from process import end

LOST_WITHIN, BACK_WITHIN = 3.0, 10.0


class Relay:
    """Passes the bytes of connections to a port, until they are cut."""

    def __init__(self) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.host = f"127.0.0.1:{self.listener.getsockname()[1]}"
        self.cuts: list[threading.Event] = []

    def lead_to(self, port: int) -> None:
        threading.Thread(target=self._accept, args=(port,), daemon=True).start()

    def cut(self) -> None:
        """Drops from now on what the present connections carry."""
        for is_cut in self.cuts:
            is_cut.set()

    def _accept(self, port: int) -> None:
        while True:
            near, _ = self.listener.accept()
            far = socket.create_connection(("127.0.0.1", port))
            is_cut = threading.Event()
            self.cuts.append(is_cut)
            for source, sink in ((near, far), (far, near)):
                threading.Thread(target=self._pass_on, args=(source, sink, is_cut), daemon=True).start()

    @staticmethod
    def _pass_on(source: socket.socket, sink: socket.socket, is_cut: threading.Event) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if not is_cut.is_set():
                    sink.sendall(data)


@pytest.mark.apart
def test_page_whose_network_is_cut_comes_back(
    barrelman: pathlib.Path, folder: pathlib.Path, check: Check
) -> None:
    relay = Relay()
    config = folder / "hosts.toml"
    config.write_text(f'[console]\nhosts = ["{relay.host}"]\n')
    program = Program(barrelman, "run", config, "--video", "sim:arena1", "--link", "sim:", "--no-record")
    relay.lead_to(int(program.host.rsplit(":", 1)[1]))
    with Page(program.url.replace(program.host, relay.host), folder) as page:
        page.ready()
        cut = time.monotonic()
        relay.cut()
        page.wait(lambda data: data["connected"] == "no", "the loss of the connection")
        check.in_time("the page says that the connection is lost", Delay.since(cut, processes=3), LOST_WITHIN)
        page.wait(lambda data: data["connected"] == "yes", "a new connection")
        check.in_time("the page is connected again", Delay.since(cut, processes=3), BACK_WITHIN)
        check("and has the control", page.data["controlling"] == "yes")
    check("the run ends with exit 0", end(program.child, signal.SIGTERM) == 0)
