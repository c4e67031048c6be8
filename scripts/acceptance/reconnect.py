"""Tests the return of a page whose network was cut: its connections go silent without an end, and new ones work at once.

The page in headless Chromium reaches the program through a relay on loopback, which drops all bytes of the connections that
it has, and closes none: as after a change of the wireless network.
"""
import contextlib
import signal
import socket
import sys
import threading
import time

import common
from common import Table
from console_page import Page, Program

BACK_WITHIN = 10.0


class Relay:
    """Passes the bytes of connections to a port, until they are cut."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.host = f"127.0.0.1:{self.listener.getsockname()[1]}"
        self.cuts = []

    def lead_to(self, port):
        threading.Thread(target=self._accept, args=(port,), daemon=True).start()

    def cut(self):
        """Drops from now on what the present connections carry."""
        for is_cut in self.cuts:
            is_cut.set()

    def _accept(self, port):
        while True:
            near, _ = self.listener.accept()
            far = socket.create_connection(("127.0.0.1", port))
            is_cut = threading.Event()
            self.cuts.append(is_cut)
            for source, sink in ((near, far), (far, near)):
                threading.Thread(target=self._pass_on, args=(source, sink, is_cut), daemon=True).start()

    @staticmethod
    def _pass_on(source, sink, is_cut):
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if not is_cut.is_set():
                    sink.sendall(data)
            if not is_cut.is_set():
                sink.shutdown(socket.SHUT_WR)


def main():
    args = common.arguments(__doc__)
    folder = common.temporary_folder()
    table = Table("A page whose network is cut")
    relay = Relay()
    config = folder / "hosts.toml"
    config.write_text(f'[console]\nhosts = ["{relay.host}"]\n')
    program = Program(args, "run", config, "--video", "sim:arena1", "--link", "sim:", "--no-record")
    relay.lead_to(int(program.host.rsplit(":", 1)[1]))
    page = Page(program.url.replace(program.host, relay.host), folder)
    page.ready()
    cut = time.monotonic()
    relay.cut()
    page.wait(lambda data: data["connected"] == "no", 10, "the loss of the connection")
    lost = time.monotonic() - cut
    table.require("the page says that the connection is lost", lost <= 3, f"after {lost:.1f} s", "3 s")
    try:
        page.wait(lambda data: data["connected"] == "yes", 90, "a new connection")
        back = time.monotonic() - cut
    except TimeoutError:
        back = float("inf")
    table.require("the page is connected again, and has the control", back <= BACK_WITHIN and page.data["controlling"] == "yes", f"after {back:.1f} s", f"{BACK_WITHIN:.0f} s")
    page.end()
    program.child.send_signal(signal.SIGTERM)
    table.require("the run ends with exit 0", program.child.wait(timeout=10) == 0)
    return table.finish(args, back_s=back)


if __name__ == "__main__":
    sys.exit(main())
