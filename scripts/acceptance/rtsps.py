"""Tests live video over RTSP in TLS: a TLS server of another's writing (Python's ssl) before an RTSP server on loopback."""
import contextlib
import signal
import socket
import ssl
import subprocess
import sys
import threading

import common
import live
from common import Lines, Table


class TlsFront:
    """Takes TLS connections, and passes their bytes to a port without TLS."""

    def __init__(self, certificate, key, port):
        self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self.context.load_cert_chain(certificate, key)
        self.behind = port
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.connections = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                near, _ = self.listener.accept()
                threading.Thread(target=self._serve, args=(near,), daemon=True).start()

    def _serve(self, near):
        with contextlib.suppress(OSError):
            near = self.context.wrap_socket(near, server_side=True)
            far = socket.create_connection(("127.0.0.1", self.behind))
            self.connections += [near, far]
            threading.Thread(target=self._pass, args=(far, near), daemon=True).start()
            self._pass(near, far)

    @staticmethod
    def _pass(source, sink):
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                sink.sendall(data)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def cut(self):
        """Ends all connections."""
        for end in self.connections:
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
        self.connections.clear()


def run(args, url, *options):
    command = [args.barrelman, "run", "--headless", "--no-record", "--video", url, "--select", live.SELECTION, *options]
    child = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    return child, Lines(child.stderr)


def end(child):
    child.send_signal(signal.SIGTERM)
    return child.wait(timeout=10)


def main():
    args = common.arguments(__doc__)
    live.needs_server()
    folder = common.temporary_folder()
    table = Table("Live video over RTSP in TLS")
    port = live.free_port()
    live.serve(port)
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    made = common.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", key, "-out", certificate, "-days", "2", "-subj", "/CN=camera"])
    table.require("a certificate to try with", made.returncode == 0, made.stderr[-80:] if made.returncode else "")
    fingerprint = common.run(["openssl", "x509", "-in", certificate, "-noout", "-fingerprint", "-sha256"]).stdout.split("=")[1].strip().replace(":", "")
    front = TlsFront(certificate, key, port)
    url = f"rtsps://127.0.0.1:{front.port}/video"

    child, err = run(args, url, "--video-certificate-sha256", fingerprint)
    err.wait_for("video: up", 20)
    err.wait_for("following the selection", 10)
    table.require("the camera with the expected certificate is seen, and its boat followed", True)
    ups = sum("video: up" in line for _, line in list(err.lines))
    front.cut()
    live.wait_for_frames(err, ups)
    table.require("a lost connection is made again", True)
    code = end(child)
    table.require("the run ends with exit 0", code == 0, f"exit {code}")

    for name, options, expected in (
        ("another certificate", ("--video-certificate-sha256", "0" * 64), "SHA-256"),
        ("a certificate that no authority has signed", (), "certificate"),
    ):
        child, err = run(args, url, *options)
        _, line = err.wait_for("no video yet", 20)
        end(child)
        table.require(f"{name} is refused, with the reason", expected in line and "video: up" not in err.text(), line.split("(", 1)[-1][:70])

    checked = common.run([args.barrelman, "check", "--video", url, "--video-certificate-sha256", fingerprint], timeout=30)
    table.require("check sees the first picture", f"{live.WIDTH}x{live.HEIGHT} pictures" in checked.stdout, next((line for line in checked.stdout.splitlines() if "video" in line), checked.stdout)[:80])
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
