"""Floods the console as a watcher, or as somebody without a token, while the operator turns the camera and presses Stop.

The operator holds the control on a WebSocket, turns the camera by hand and presses Stop, by turns on the socket and by a
request over HTTP on a connection of its own. Measured are the times from the press to the answer, and to the zero rate at
the emulated ground station, and the largest memory of the program. Each flood is a process of its own, which connects
again as soon as the program disconnects it.

A delay is limited by LIMIT_MS and, for each process between the press and its effect, by the longest time for which a
process of this machine had to wait for the processor meanwhile.
"""
import bisect
import contextlib
import http.client
import json
import re
import socket
import subprocess
import sys
import threading
import time

import common
import live
from common import Emulator, Lines, Recording, Standstills, Table

CONTROL_TOKEN = "control-token-of-the-test"
WATCH_TOKEN = "watch-token-of-the-test"
LIMIT_MS = 100
# Processes and threads between a press and its answer (server, pilot, this script), and the zero (link, guard, emulator).
ANSWER_HOPS, ZERO_HOPS = 3, 5
NUDGE_INTERVAL = 0.05
# Between two rounds of a short flood, seconds: a debug build answers a tenth of the connections.
SHORT_PAUSE = 0.02
MEMORY_MB = 32
# A stop of the operator, as recorded.
STOPPED = {"kind": "stop", "cause": "operator"}
STOP = json.dumps({"request": {"kind": "stop"}}).encode()


def head(line, token, *more):
    words = [f"{line} HTTP/1.1", "Host: HOST", *more]
    words += [f"Authorization: Bearer {token}"] if token else []
    return ("\r\n".join(words) + "\r\n\r\n").encode()


def masked(kind, content=b""):
    size = bytes([0x80 | len(content)]) if len(content) < 126 else b"\xfe" + len(content).to_bytes(2, "big")
    return bytes([kind]) + size + b"\0\0\0\0" + content


UPGRADE = ("Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==")
SOCKET = head("GET /api/v1/socket", WATCH_TOKEN, *UPGRADE)
POST = head("POST /api/v1/requests", WATCH_TOKEN, "Content-Type: application/json", f"Content-Length: {len(STOP)}") + STOP
TINY = masked(0x81, b'{"type":"ping","sent_ms":0}')
LARGE = masked(0x81, b'{"type":"ping","sent_ms":' + b" " * 4000 + b"1}")

STOPS = "POSTs of stops"

# What each connection of a flood sends first, and then again and again.
FLOODS = {
    "pings": (SOCKET, masked(0x89) * 500),
    "pongs": (SOCKET, masked(0x8A) * 500),
    "empty parts of a message": (SOCKET + masked(0x01, b"{"), masked(0x00) * 500),
    "tiny messages": (SOCKET, TINY * 100),
    "large messages": (SOCKET, LARGE * 4),
    "GETs of the status": (b"", head("GET /api/v1/status", WATCH_TOKEN) * 10),
    "GETs of the metrics": (b"", head("GET /metrics", WATCH_TOKEN) * 10),
    "GETs of the page, without a token": (b"", head("GET /console/main.js", None) * 10),
    STOPS: (b"", POST * 10),
    "new connections": None,
    "slow heads, without a token": (b"GET / HTTP/1.1\r\nHost:", b""),
    "new sockets": (SOCKET, b""),
    "sockets that read no pictures": (SOCKET + masked(0x81, b'{"type":"video","path":"jpeg"}'), TINY),
}
# How many connections a flood holds, and after how many seconds a connection that only waits is replaced.
CONNECTIONS = {"slow heads, without a token": (100, 3.0), "new sockets": (20, 0.0), "sockets that read no pictures": (16, 60.0)}


def flood(name, host, pause):
    """Floods a program until this process is killed, with a pause between two rounds of its connections."""
    address = (host.split(":")[0], int(host.split(":")[1]))
    if FLOODS[name] is None:
        while True:
            for _ in range(20):
                with socket.socket() as new:
                    new.connect(address)
            time.sleep(pause)
    begin, again = (data.replace(b"HOST", host.encode()) for data in FLOODS[name])
    count, lasts = CONNECTIONS.get(name, (8, 60.0))
    reads = "read no" not in name
    connections = {}
    while True:
        is_idle = True
        for slot in range(count):
            try:
                if slot not in connections:
                    new = socket.create_connection(address, timeout=2)
                    new.sendall(begin)
                    new.setblocking(False)
                    connections[slot] = [new, b"", time.monotonic()]
                    is_idle = False
                held = connections[slot]
                if reads:
                    try:
                        if not held[0].recv(65536):
                            raise ConnectionError
                        is_idle = False
                    except BlockingIOError:
                        pass
                held[1] = held[1] or again
                if held[1]:
                    try:
                        held[1] = held[1][held[0].send(held[1]) :]
                        is_idle = False
                    except BlockingIOError:
                        pass
                elif time.monotonic() - held[2] > lasts:
                    raise ConnectionError
            except OSError:
                if slot in connections:
                    connections.pop(slot)[0].close()
        time.sleep(max(pause, (0.005 if is_idle else 0) if reads else 0.05))


class Operator:
    """The page in control: a WebSocket that turns the camera by hand, and whose answers have their times."""

    def __init__(self, host):
        self.host = host
        name, port = host.split(":")
        self.socket = socket.create_connection((name, int(port)), timeout=10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.sendall(head("GET /api/v1/socket?client=ab", CONTROL_TOKEN, *UPGRADE).replace(b"HOST", host.encode()))
        self.file = self.socket.makefile("rb")
        while self.file.readline().strip():
            pass
        self.lock, self.answers, self.number, self.pan = threading.Lock(), {}, 1000, 0.0
        self.is_open = True
        threading.Thread(target=self._read, daemon=True).start()
        threading.Thread(target=self._turn, daemon=True).start()

    def _read(self):
        with contextlib.suppress(OSError):
            self._read_messages()
        self.is_open = False

    def _read_messages(self):
        while True:
            start = self.file.read(2)
            if len(start) < 2 or start[0] & 15 == 8:
                break
            size = start[1] & 127
            size = int.from_bytes(self.file.read({126: 2, 127: 8}[size]), "big") if size > 125 else size
            content = self.file.read(size)
            if start[0] & 15 != 1:
                continue
            message = json.loads(content)
            if message["type"] == "answer":
                self.answers[message["id"]] = (time.monotonic(), message["answer"])

    def _turn(self):
        while self.is_open:
            if self.pan:
                self.request("nudge", pan=self.pan, tilt=0.0)
            else:
                self._send({"type": "ping", "sent_ms": 0})
            time.sleep(NUDGE_INTERVAL)

    def _send(self, message):
        with self.lock:
            try:
                self.socket.sendall(masked(0x81, json.dumps(message).encode()))
            except OSError:
                self.is_open = False

    def request(self, kind, **more):
        self.number += 1
        self._send({"type": "request", "id": self.number, "request": {"kind": kind, **more}})
        return self.number

    def stop_on_socket(self):
        """Presses Stop; returns the seconds until it is answered, infinity without an answer."""
        begin, number = time.monotonic(), self.request("stop")
        end = begin + 5
        while number not in self.answers and time.monotonic() < end and self.is_open:
            time.sleep(0.001)
        at, answer = self.answers.get(number, (float("inf"), ""))
        return at - begin if answer == "accepted" else float("inf")

    def stop_over_http(self):
        """The same, by a request on a new connection."""
        begin = time.monotonic()
        code, body = ask(self.host, "POST", "/api/v1/requests", CONTROL_TOKEN, STOP)
        is_accepted = code == 200 and json.loads(body)["answer"] == "accepted"
        return time.monotonic() - begin if is_accepted else float("inf")


def ask(host, method, path, token, body=None):
    """The status and the body of an answer; status 0 without one."""
    connection = http.client.HTTPConnection(host, timeout=5)
    try:
        connection.request(method, path, body, {"Authorization": f"Bearer {token}", "Content-Type": "application/json"})
        answer = connection.getresponse()
        return answer.status, answer.read()
    except (OSError, http.client.HTTPException):
        return 0, b""
    finally:
        connection.close()


class Vehicle:
    """The rates in force at the ground station, by the rows of its log, read as they come."""

    def __init__(self, emulator):
        self.file, self.rest, self.rows = open(emulator.log), "", []

    def read(self):
        self.rest += self.file.read()
        *lines, self.rest = self.rest.split("\n")
        self.rows += [common.Row(json.loads(line)) for line in lines]

    def first(self, since, condition, seconds):
        """The first row since a time that fulfils a condition, waited for; None without one."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.read()
            index = bisect.bisect_left(self.rows, since, key=lambda row: row.at)
            found = next((row for row in self.rows[index:] if condition(row)), None)
            if found is not None:
                return found
            time.sleep(0.002)
        return None

    def rests_after(self, pressed):
        """Seconds from a press until no rate is in force; None for a camera that rested already, as its hand was not heard in time."""
        if self.first(pressed, lambda row: True, 5) is None:
            return float("inf")
        before = self.rows[: bisect.bisect_left(self.rows, pressed, key=lambda row: row.at)]
        if not any(before[-1].rates):
            return None
        row = self.first(pressed, lambda row: not any(row.rates), 5)
        return float("inf") if row is None else row.at - pressed


def press_stops(operator, vehicle, count, turns):
    """Turns the camera and stops it, `count` times. Returns the seconds to the answers and to the zeros at the vehicle.

    Without `turns` the camera rests, as others stop it all the time.
    """
    answers, zeros = {"socket": [], "HTTP": []}, []
    for number in range(count):
        if not turns:
            time.sleep(0.1)
            answers["socket"].append(operator.stop_on_socket())
            answers["HTTP"].append(operator.stop_over_http())
            continue
        operator.request("disengage")
        operator.pan = 0.5 if number % 2 else -0.5
        began = time.monotonic()
        if vehicle.first(began, lambda row: any(row.rates), 10) is None:
            # The operator is kept out.
            answers["socket"].append(float("inf"))
            break
        time.sleep(0.1)
        way = ("socket", "HTTP")[number % 2]
        # The hand lets go with the press: what is sent before it is older.
        operator.pan = 0.0
        pressed = time.monotonic()
        answers[way].append(operator.stop_on_socket() if way == "socket" else operator.stop_over_http())
        rests = vehicle.rests_after(pressed)
        zeros += [rests] if rests is not None else []
    return answers, zeros


def endless_world(args, folder):
    """The address of a world whose boat goes round for an hour."""
    text = common.run([args.barrelman, "scenarios", "open"]).stdout
    text = re.sub(r"way_points = \[(\[.*\])\]", lambda found: f"way_points = [{', '.join([found[1]] * 30)}]", text, count=1)
    scenario = folder / "endless.toml"
    scenario.write_text(re.sub(r"longest_s = \d+", "longest_s = 3600", text))
    return f"sim:{scenario}?seed=3&size=640x360"


def judge(table, name, standstills, answers, zeros):
    """Requires that the delays are within their limits."""
    longest = max(standstills.found, default=0) * 1e3
    for what, delays, hops in [*((f"answer, {way}", found, ANSWER_HOPS) for way, found in answers.items()), *([("zero rate", zeros, ZERO_HOPS)] if zeros else [])]:
        known = [delay * 1e3 for delay in delays]
        limit = LIMIT_MS + hops * longest
        wanted = f"{LIMIT_MS} ms" + (f", and {hops} waits of {longest:.0f} ms" if longest else "")
        table.require(f"{name}: {what}", known and max(known) <= limit, f"median {common.median(known):.0f}, worst {max(known, default=0):.0f} ms", wanted)


def floods(table, args, program, operator, emulator, host):
    before, vehicle = common.memory_mb(program, "VmHWM"), Vehicle(emulator)
    for name in [None, *(name for name in FLOODS if args.only in (None, name))]:
        command = [sys.executable, __file__, "--flood", name, host, SHORT_PAUSE if args.short else 0]
        flooding = common.spawn(command, stdout=subprocess.DEVNULL) if name else None
        time.sleep(0.5)
        with Standstills() as standstills:
            answers, zeros = press_stops(operator, vehicle, args.stops, turns=name != STOPS)
        judge(table, name or "no flood", standstills, answers, zeros)
        if flooding:
            table.require(f"{name}: the flood went on, and the operator's page stays", flooding.poll() is None and operator.is_open)
            flooding.kill()
            flooding.wait()
    after = common.memory_mb(program, "VmHWM")
    table.require("the largest memory of the program", after - before <= MEMORY_MB, f"{before:.0f}, then {after:.0f} MB", f"{MEMORY_MB} MB more")


def connections(table, host):
    """Connections without a token do not keep the operator out."""
    name, port = host.split(":")
    waiting = [socket.create_connection((name, int(port))) for _ in range(512)]
    with Standstills() as standstills:
        begin = time.monotonic()
        code, _ = ask(host, "GET", "/api/v1/status", CONTROL_TOKEN)
        delay = (time.monotonic() - begin) * 1e3
    limit = LIMIT_MS + 2 * max(standstills.found, default=0) * 1e3
    table.require("512 connections without a token: the operator is let in", code == 200 and delay <= limit, f"HTTP {code}, {delay:.0f} ms", f"{LIMIT_MS} ms")
    for connection in waiting:
        connection.close()


def counts(table, args, program, operator, record, host):
    """A watcher's stops are acknowledged and not recorded; other requests are refused beyond the limit."""
    operator.pan = 0.0
    operator.stop_on_socket()
    before, end, codes = record.stat().st_size, time.monotonic() + args.seconds, []
    connection = http.client.HTTPConnection(host, timeout=5)
    began = time.monotonic()
    while time.monotonic() < end:
        connection.request("POST", "/api/v1/requests", STOP, {"Authorization": f"Bearer {WATCH_TOKEN}", "Content-Type": "application/json"})
        answer = connection.getresponse()
        codes.append(answer.status if json.loads(answer.read())["answer"] == "accepted" else 0)
    passed = time.monotonic() - began
    table.require("every stop of a watcher is acknowledged", set(codes) == {200}, f"{len(codes)} in {passed:.1f} s")
    seen = [ask(host, "GET", "/api/v1/status", WATCH_TOKEN)[0] for _ in range(500)]
    table.require("a watcher's other requests are refused beyond the limit", 429 in seen, f"{seen.count(200)} answered, {seen.count(429)} refused")
    table.require("  and the operator's are not", ask(host, "GET", "/api/v1/status", CONTROL_TOKEN)[0] == 200)
    return began, len(codes), (record.stat().st_size - before) / passed


def main():
    if "--flood" in sys.argv:
        return flood(sys.argv[2], sys.argv[3], float(sys.argv[4]))
    args = common.arguments(
        __doc__,
        short={"action": "store_true", "help": "few stops and short floods"},
        stops={"type": int, "help": "how often Stop is pressed in each flood; default: 40, short: 4"},
        seconds={"type": float, "help": "how long a watcher sends stops; default: 6, short: 1"},
        only={"choices": [name for name in FLOODS], "help": "this flood alone"},
    )
    args.stops = args.stops or (4 if args.short else 40)
    args.seconds = args.seconds or (1.0 if args.short else 6.0)
    folder = common.temporary_folder()
    table = Table("Stop, while others flood the console")
    tokens, record = folder / "tokens", folder / "run.mcap"
    tokens.write_text(f"{CONTROL_TOKEN}\n{WATCH_TOKEN}\n")
    tokens.chmod(0o600)
    host = f"127.0.0.1:{live.free_port()}"
    with Emulator(args.barrelman, folder) as emulator:
        command = [args.barrelman, "run", "--video", endless_world(args, folder), "--link", emulator.url, "--listen", host, "--console-token-file", tokens, "--record", record]
        program = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        out, err = Lines(program.stdout), Lines(program.stderr)
        out.wait_for("console.*http://", 30)
        table.require("tokens of a file are not printed", CONTROL_TOKEN not in out.text() + err.text())
        err.wait_for("link up", 15)
        operator = Operator(host)
        floods(table, args, program, operator, emulator, host)
        connections(table, host)
        began, stops, growth = counts(table, args, program, operator, record, host)
        program.terminate()
        program.wait(timeout=10)
    recording = Recording(record)
    recorded = sum(request == STOPPED and recording.at(now_ns) >= began for now_ns, request in recording.requests())
    table.require("none of a watcher's stops is recorded while one is in force", recorded == 0, f"{recorded} of {stops}")
    table.show("the recording's growth during a watcher's stops", f"{growth / 1e3:.0f} kB/s", f"{stops} stops")
    table.require("the recording is for its owner alone", record.stat().st_mode & 0o777 == 0o600, oct(record.stat().st_mode & 0o777))
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
