"""Tests that no server fills the program's memory, and that no password goes where it should not.

Each hostile server speaks to a run of its own for some seconds; the most memory that the run ever had (VmHWM) is the figure.
"""
import base64
import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import common
from common import Lines, Table
from independent_sigma import TOKEN, Sigma

MEMORY_LIMIT_MB = 150
LASTS_S = 8.0
NOISE = os.urandom(1 << 16).replace(b"\n", b"x").replace(b"\r", b"x")
SPS, PPS = base64.b64decode("Z0LAHtoCgL/lmoCAgKAAAAMAIAAAB4HixdQ="), base64.b64decode("aM48gA==")


class RtspServer:
    """Answers each request of a client by `answer(server, connection, method, cseq, head)`; keeps the heads that it got."""

    def __init__(self, answer):
        self.answer, self.heads, self.ended = answer, [], False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def url(self, login=""):
        return f"rtsp://{login}127.0.0.1:{self.port}/live"

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                connection, _ = self.listener.accept()
                threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with contextlib.suppress(OSError, ValueError, StopIteration):
            held = b""
            while data := connection.recv(65536):
                held += data
                while b"\r\n\r\n" in held:
                    head, held = held.split(b"\r\n\r\n", 1)
                    self.heads.append(head.decode())
                    method = head.split(b" ", 1)[0].decode()
                    cseq = next(line.split(b":")[1].strip().decode() for line in head.split(b"\r\n") if line.lower().startswith(b"cseq"))
                    self.answer(self, connection, method, cseq, head.decode())
        connection.close()

    def close(self):
        self.ended = True
        self.listener.close()


def reply(connection, cseq, status="200 OK", headers=(), body=b""):
    lines = [f"RTSP/1.0 {status}", f"CSeq: {cseq}", *headers] + ([f"Content-Length: {len(body)}"] if body else [])
    connection.sendall(("\r\n".join(lines) + "\r\n\r\n").encode() + body)


def flood(server, connection, piece):
    while not server.ended:
        connection.sendall(piece)


def endless_head(server, connection, method, cseq, head):
    connection.sendall(f"RTSP/1.0 200 OK\r\nCSeq: {cseq}\r\nX: ".encode())
    flood(server, connection, NOISE)


def many_header_lines(server, connection, method, cseq, head):
    connection.sendall(f"RTSP/1.0 200 OK\r\nCSeq: {cseq}\r\n".encode())
    flood(server, connection, b"X: y\r\n" * 10_000)


def endless_body(server, connection, method, cseq, head):
    connection.sendall(f"RTSP/1.0 200 OK\r\nCSeq: {cseq}\r\nContent-Length: 4294967290\r\n\r\n".encode())
    flood(server, connection, NOISE)


def large_sdp(server, connection, method, cseq, head):
    line = b"a=x:" + b"y" * 1000 + b"\r\n"
    reply(connection, cseq, headers=["Content-Type: application/sdp"], body=b"v=0\r\n" + line * 50_000)


def sdp():
    sets = f"{base64.b64encode(SPS).decode()},{base64.b64encode(PPS).decode()}"
    return (f"v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=x\r\nt=0 0\r\na=control:*\r\nm=video 0 RTP/AVP 96\r\nc=IN IP4 0.0.0.0\r\n"
            f"a=rtpmap:96 H264/90000\r\na=fmtp:96 packetization-mode=1;profile-level-id={SPS[1:4].hex()};sprop-parameter-sets={sets}\r\n"
            f"a=control:trackID=1\r\n").encode()


def started(connection, method, cseq):
    """Answers until PLAY. Returns whether the stream begins."""
    if method == "DESCRIBE":
        reply(connection, cseq, headers=["Content-Type: application/sdp"], body=sdp())
    elif method == "SETUP":
        reply(connection, cseq, headers=["Transport: RTP/AVP/TCP;unicast;interleaved=0-1", "Session: 7"])
    else:
        reply(connection, cseq, headers=["Session: 7"])
    return method == "PLAY"


def endless_unit(server, connection, method, cseq, head):
    """Fragments of one access unit that never ends."""
    if started(connection, method, cseq):
        sequence = 0
        while not server.ended:
            indicator = bytes([0x7C, 0x85 if sequence == 0 else 0x05])
            packet = bytes([0x80, 96]) + sequence.to_bytes(2, "big") + bytes(4) + bytes([1, 2, 3, 4]) + indicator + NOISE[:60_000]
            connection.sendall(b"$\0" + len(packet).to_bytes(2, "big") + packet)
            sequence = (sequence + 1) & 0xFFFF


def server_requests(server, connection, method, cseq, head):
    """Requests of the server, as fast as they are taken."""
    if started(connection, method, cseq):
        threading.Thread(target=lambda: drain(connection), daemon=True).start()
        with contextlib.suppress(OSError):
            for number in range(1 << 30):
                if server.ended:
                    return
                connection.sendall(f"OPTIONS rtsp://127.0.0.1/ RTSP/1.0\r\nCSeq: {number}\r\n\r\n".encode())
                time.sleep(0.01)


def drain(connection):
    with contextlib.suppress(OSError):
        while connection.recv(65536):
            pass


class PingingSigma(Sigma):
    """Pings as fast as the socket takes them, and reads no answer."""

    def speak(self, handler):
        handler.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        super_write = handler.wfile.write
        calls = []

        def write(data):
            super_write(data)
            calls.append(1)
            if len(calls) > 1:
                handler.wfile.flush()
                while True:
                    handler.connection.sendall((b"\x89\x7d" + b"p" * 125) * 500)

        handler.wfile.write = write
        super().speak(handler)


class LongAnswers(Sigma):
    """Answers the camera's state with a body that does not end."""

    def serve(self, handler, method):
        if handler.path.endswith(("/camera/state", "/flight/state", "/system/state")):
            handler.wfile.write(b"HTTP/1.1 200 OK\r\nContent-Length: 4294967290\r\n\r\n")
            with contextlib.suppress(OSError):
                while True:
                    handler.wfile.write(NOISE)
        super().serve(handler, method)


class LongHeads(Sigma):
    """Answers the flight state with a head that does not end."""

    def serve(self, handler, method):
        if handler.path.endswith("/flight/state"):
            handler.wfile.write(b"HTTP/1.1 200 OK\r\nX: ")
            with contextlib.suppress(OSError):
                while True:
                    handler.wfile.write(NOISE)
        super().serve(handler, method)


def run(args, *options):
    command = [args.barrelman, "run", "--headless", "--no-record", *options]
    return common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def measure(table, args, name, *options):
    child = run(args, *options)
    err = Lines(child.stderr)
    most, end = 0.0, time.monotonic() + LASTS_S
    while time.monotonic() < end and child.poll() is None:
        most = max(most, common.memory_mb(child, "VmHWM"))
        time.sleep(0.1)
    ended = child.poll()
    if ended is None:
        child.send_signal(signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(timeout=8)
        child.kill()
    table.require(name, 0 < most < MEMORY_LIMIT_MB, f"{most:.0f} MB", f"less than {MEMORY_LIMIT_MB} MB; {err.text()[-200:]}")
    return {"case": name, "most_mb": most, "lines": len(err.text().splitlines())}


def hold_memory(table, args, folder):
    figures = []
    for answer in (endless_head, many_header_lines, endless_body, large_sdp, endless_unit, server_requests):
        server = RtspServer(answer)
        figures.append(measure(table, args, f"RTSP: {answer.__name__.replace('_', ' ')}", "--video", server.url(), "--select", "100,100,40,40"))
        if answer is server_requests:
            table.require("RTSP: requests of the server fill no log", figures[-1]["lines"] < 30, f"{figures[-1]['lines']} lines")
        server.close()
    token = folder / "token"
    token.write_text(TOKEN + "\n")
    token.chmod(0o600)
    for vehicle in (PingingSigma, LongAnswers, LongHeads):
        sigma = vehicle()
        link = ["--profile", "fotokite-sigma", "--link", sigma.url, "--link-token-file", token]
        figures.append(measure(table, args, f"Sigma: {vehicle.__name__}", "--video", "sim:arena1?size=320x180", *link))
        sigma.close()
    return figures


def basic_only(server, connection, method, cseq, head):
    if "Authorization" in head:
        reply(connection, cseq, "404 Not Found")
    else:
        reply(connection, cseq, "401 Unauthorized", ['WWW-Authenticate: Basic realm="x"'])


def digest_or_basic(server, connection, method, cseq, head):
    if "Authorization" in head:
        reply(connection, cseq, "404 Not Found")
    else:
        reply(connection, cseq, "401 Unauthorized", ['WWW-Authenticate: Digest realm="x", nonce="0123"', 'WWW-Authenticate: Basic realm="x"'])


def check_logins(table, args, folder):
    """What a server gets of a login, and whom a vehicle can have it sent to."""
    login = folder / "login"
    login.write_text("admin:s3cret\n")
    login.chmod(0o600)
    config = folder / "basic.toml"
    for answer, options, name, sends in (
        (basic_only, (), "a server that takes Basic alone gets no password", "nothing"),
        (basic_only, (config,), "video.allow_basic_login sends it", "Basic"),
        (digest_or_basic, (), "a server that takes Digest, too, gets Digest", "Digest"),
    ):
        server = RtspServer(answer)
        config.write_text("[video]\nallow_basic_login = true\n")
        child = run(args, *options, "--video", server.url(), "--video-login-file", login, "--select", "100,100,40,40")
        err = Lines(child.stderr)
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(timeout=4)
        child.kill()
        err.join()
        sent = [line for head in server.heads for line in head.splitlines() if line.startswith("Authorization")]
        kinds = {line.split()[1] for line in sent} or {"nothing"}
        told = sends != "nothing" or ("rtsps://" in err.text() and "allow_basic_login" in err.text())
        table.require(name, kinds == {sends} and told, ", ".join(kinds), err.text()[-300:])
        server.close()
    named_by_vehicle(table, args, folder, login)


class NamingSigma(Sigma):
    """Names this address of its video."""

    video = ""

    def answer(self, method, path, authorization, body):
        status, answer = super().answer(method, path, authorization, body)
        if path == "/v1/videostreams" and status == 200:
            answer[0]["rtsp_url"] = self.video
        return status, answer


def named_by_vehicle(table, args, folder, login):
    token = folder / "token"
    token.write_text(TOKEN + "\n")
    token.chmod(0o600)
    for video, name in (
        ("sim:arena1", "a simulated world"), ("file:/etc/hostname", "a file"), ("SIM:arena1", "a scheme in capitals"),
        ("rtsp://127.0.0.2:8554/x", "another host"), ("rtsp://u:p@127.0.0.1:8554/x", "a login"), ("rtsp://127.0.0.1:8554/x?fault=stall%401", "an option"),
    ):
        sigma = NamingSigma()
        sigma.video = video
        child = run(args, "--engage", "--profile", "fotokite-sigma", "--link", sigma.url, "--link-token-file", token)
        err = Lines(child.stderr)
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(timeout=5)
        ended = child.poll()
        child.kill()
        err.join()
        moving = [motion for motion in sigma.motions if any(motion[1])]
        table.require(f"a vehicle that names {name}: refused", ended == 1 and not moving and "the vehicle names" in err.text(), f"exit {ended}", err.text()[-200:])
        sigma.close()
    server = RtspServer(digest_or_basic)
    for second_line, name, is_sent in (("", "without its address in the file, gets no login", False), (f"host 127.0.0.1:{server.port}\n", "whose address is in the file, gets it", True)):
        login.write_text("admin:s3cret\n" + second_line)
        sigma = NamingSigma()
        sigma.video = server.url()
        server.heads.clear()
        child = run(args, "--profile", "fotokite-sigma", "--link", sigma.url, "--link-token-file", token, "--video-login-file", login)
        err = Lines(child.stderr)
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(timeout=4)
        child.kill()
        err.join()
        has_login = any("Authorization" in head for head in server.heads)
        table.require(f"a video that the vehicle names, {name}", has_login == is_sent, f"{len(server.heads)} requests", err.text()[-200:])
        sigma.close()
    server.close()


def main():
    args = common.arguments(__doc__)
    folder = common.temporary_folder()
    table = Table("Hostile servers")
    figures = hold_memory(table, args, folder)
    check_logins(table, args, folder)
    return table.finish(args, cases=figures)


if __name__ == "__main__":
    sys.exit(main())
