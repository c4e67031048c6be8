"""Tests the console's interface for programs: the client of docs/api.md, the schemas, and clients that break the rules."""
import json
import os
import re
import socket
import sys
import time

import common
import live
from common import Table
from console_page import Program

TEXT, CLOSE = 1, 8


class Socket:
    """A minimal WebSocket client: reads unmasked frames, sends masked frames."""

    def __init__(self, program, token=None, send_buffer=None):
        host, port = program.host.split(":")
        self.socket = socket.create_connection((host, int(port)), timeout=10)
        if send_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, send_buffer)
        token = token or program.token
        authorization = f"Authorization: Bearer {token}\r\n" if token else ""
        self.socket.sendall(f"GET /api/v1/socket HTTP/1.1\r\nHost: {program.host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{authorization}\r\n".encode())
        head = b""
        while b"\r\n\r\n" not in head:
            piece = self.socket.recv(1)
            if not piece:
                break
            head += piece
        self.accepted = b" 101 " in head.split(b"\r\n")[0]

    def send(self, message):
        data = message if isinstance(message, bytes) else json.dumps(message).encode()
        size = bytes([0x80 | len(data)]) if len(data) < 126 else b"\xfe" + len(data).to_bytes(2, "big") if len(data) < 65536 else b"\xff" + len(data).to_bytes(8, "big")
        self.socket.sendall(b"\x81" + size + b"\0\0\0\0" + data)

    def read(self):
        """The next message as (opcode, content); None if the connection has ended."""
        try:
            head = self._exactly(2)
            size = head[1] & 127
            size = int.from_bytes(self._exactly(2), "big") if size == 126 else int.from_bytes(self._exactly(8), "big") if size == 127 else size
            kind, content = head[0] & 15, self._exactly(size)
            return None if kind == CLOSE else (kind, content)
        except (OSError, EOFError):
            return None

    def until(self, kind, seconds=5):
        """The next text message of this type; None if the connection ends or no such message arrives in time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            message = self.read()
            if message is None:
                return None
            if message[0] == TEXT and json.loads(message[1])["type"] == kind:
                return json.loads(message[1])
        return None

    def is_closed(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.read() is None:
                return True
        return False

    def _exactly(self, count):
        data = b""
        while len(data) < count:
            piece = self.socket.recv(count - len(data))
            if not piece:
                raise EOFError
            data += piece
        return data


def client(table, args, folder, program):
    """Runs the client that docs/api.md shows, unchanged."""
    text = (common.ROOT / "docs/api.md").read_text()
    script = folder / "client.py"
    script.write_text(re.search(r"```python\n(.*?)```", text, re.S)[1])
    done = common.run([sys.executable, script, program.host, program.token])
    lines = done.stdout.split("\n")
    works = done.returncode == 0 and lines[0] == "idle" and "accepted" in lines[1] and "accepted" in lines[2] and int(lines[3] or 0) >= 1
    table.require("the client of docs/api.md: status, engage, stop", works, " | ".join(lines[:4]) if works else done.stderr[-300:])


def schemas(table, args, program):
    """Validates messages against the schemas that the program prints."""
    import jsonschema

    printed = json.loads(common.run([args.barrelman, "config", "api"]).stdout)
    check = lambda name, value: jsonschema.Draft202012Validator({"$ref": f"#/components/schemas/{name}", **printed}).validate(value)
    check("StatusSnapshot", program.status())
    check("Answer", program.request("disengage"))
    check("RequestBody", {"id": 1, "request": {"kind": "select", "bounds": {"u": 1, "v": 2, "w": 3, "h": 4}, "captured_ns": 5}})
    check("MessageToProgram", {"type": "request", "id": 7, "request": {"kind": "ask-control"}})
    page, seen = Socket(program), set()
    page.send({"type": "ping", "sent_ms": 1.5})
    page.send({"type": "request", "id": 7, "request": {"kind": "ask-control"}})
    wanted, end = {"hello", "events", "control", "snapshot", "pong", "answer"}, time.monotonic() + 5
    while time.monotonic() < end and not seen >= wanted:
        kind, content = page.read()
        if kind == TEXT:
            message = json.loads(content)
            check("MessageToPage", message)
            seen.add(message["type"])
    table.require("every message fits its schema", seen >= wanted, ", ".join(sorted(seen)))
    page.socket.close()


def rules(table, program):
    """Breaks the rules as a client: the program refuses or disconnects that client, and still answers others."""
    watcher = Socket(program, token=program.watch_token)
    watcher.send({"type": "request", "id": 1, "request": {"kind": "engage"}})
    answer = watcher.until("answer")
    table.require("a watcher who commands is refused", answer and answer["answer"] == "refused", answer and answer["reason"])
    watcher.send({"type": "request", "id": 2, "request": {"kind": "stop"}})
    answer = watcher.until("answer")
    table.require("a watcher's stop is taken", answer and answer["answer"] == "accepted")
    watcher.socket.close()

    page = Socket(program)
    page.send(b'{"type":"ping","sent_ms":' + b" " * 5000 + b"1}")
    table.require("an oversized message ends the connection", page.is_closed(5))
    page = Socket(program)
    page.send(b"not JSON")
    table.require("a message that is none ends the connection", page.is_closed(5))
    page = Socket(program)
    try:
        for number in range(3000):
            page.send({"type": "ping", "sent_ms": number})
    except OSError:
        pass
    table.require("a flood of messages ends the connection", page.is_closed(5))

    host, port = program.host.split(":")
    slow = socket.create_connection((host, int(port)))
    slow.sendall(b"GET / HTTP/1.1\r\nHost:")
    slow.settimeout(12)
    begin = time.monotonic()
    try:
        answer = slow.recv(100)
    except TimeoutError:
        answer = None
    passed = time.monotonic() - begin
    table.require("slow headers end the connection", answer is not None and passed < 9, f"{passed:.1f} s")

    idle = [socket.create_connection((host, int(port))) for _ in range(80)]
    time.sleep(0.3)
    for connection in idle:
        connection.close()
    time.sleep(0.3)
    table.require("80 connections at once: the server still answers", program.ask("GET", "/healthz", token=None)[1] == b"ok\n")
    pages = [Socket(program) for _ in range(20)]
    answered = program.status()["step"] > 0
    open_pages = sum(page.accepted for page in pages)
    first_gone = pages[0].is_closed(3) or pages[1].is_closed(3)
    table.require("20 pages at once: the idlest go, the server answers", answered and first_gone, f"{open_pages} were accepted, 16 stay")
    for page in pages:
        page.socket.close()
    silent = Socket(program)
    begin = time.monotonic()
    gone = silent.is_closed(20)
    table.require("a page that is silent is dropped", gone, f"after {time.monotonic() - begin:.1f} s", "10 s")


def threads_of(child):
    """CPU time of each thread of a process, in seconds, by the thread's name."""
    ticks = os.sysconf("SC_CLK_TCK")
    times = {}
    for task in os.listdir(f"/proc/{child.pid}/task"):
        try:
            text = open(f"/proc/{child.pid}/task/{task}/stat").read()
        except OSError:
            continue
        name, rest = text[text.index("(") + 1 : text.rindex(")")], text[text.rindex(")") + 2 :].split()
        times[name] = times.get(name, 0) + (int(rest[11]) + int(rest[12])) / ticks
    return times


def viewer_that_does_not_read(table, args, program):
    """Checks that memory does not grow while a page requests video and reads nothing."""
    page = Socket(program, send_buffer=4096)
    page.send({"type": "video", "path": "h264"})
    time.sleep(4)
    before = common.memory_mb(program.child)
    steps = program.status()["step"]
    end = time.monotonic() + args.seconds
    while time.monotonic() < end:
        try:
            page.send({"type": "ping", "sent_ms": 0})
        except OSError:
            page = Socket(program, send_buffer=4096)
            page.send({"type": "video", "path": "h264"})
        time.sleep(1)
    after = common.memory_mb(program.child)
    table.require(f"a page that does not read, for {args.seconds:.0f} s: memory is flat", after - before < 20, f"{before:.0f} to {after:.0f} MB", "less than 20 MB more")
    rate = (program.status()["step"] - steps) / args.seconds
    table.require("  and the pilot goes on", rate > 10, f"{rate:.0f} steps a second")
    page.socket.close()


def main():
    live.needs_server()
    args = common.arguments(__doc__, seconds={"type": float, "default": 60.0, "help": "how long the page that does not read stays"})
    folder = common.temporary_folder()
    table = Table("The console's interface for programs")
    program = Program(args, "run", "--video", "sim:arena1?size=640x360", "--link", "sim:", "--record", folder / "run.mcap")
    program.wait(lambda status: status["track"]["state"] == "tracking", 30, "the track")
    client(table, args, folder, program)
    schemas(table, args, program)
    rules(table, program)
    table.require("SIGINT ends it with exit 0", program.end() == 0)
    # A stream that does not end.
    port = live.free_port()
    live.serve(port)
    program = Program(args, "run", "--video", f"rtsp://127.0.0.1:{port}/video", "--select", live.SELECTION, "--record", folder / "long.mcap")
    program.wait(lambda status: status["track"]["state"] == "tracking", 30, "the track")
    viewer_that_does_not_read(table, args, program)
    table.require("  and SIGINT ends it with exit 0", program.end() == 0)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
