"""Shared code of the acceptance scripts: start the program and the emulator, read their logs, print the table.

Times are seconds of CLOCK_MONOTONIC unless a name says otherwise. The emulator's log has this time in `mono_ns`. The
first message of a recording has the time of the recording's start on this clock in `monotonic_ns`.
"""
import argparse
import atexit
import contextlib
import json
import os
import pathlib
import pty
import queue
import re
import select
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared"
WIDTH, HEIGHT = 1280, 720
# By how much a line may be read late, seconds: the emulator looks at its port every 10 ms at the least, and two cores are
# shared with the decoder.
LISTENING_JITTER = 0.015
# How often what fails is tried on a machine that stood still meanwhile.
ATTEMPTS = 4
# The optimal law's mode that moves the camera nearly all the time, so that each case finds the camera in motion.
HARDLY_RESTS = "minimum-energy"

_children = []
_cleanups = []


def _end_children():
    for child in _children:
        if child.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                child.kill()
    for child in _children:
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(timeout=5)
    for cleanup in _cleanups:
        cleanup()


def _leave(number, _frame):
    _end_children()
    os._exit(128 + number)


def arguments(description, **more):
    """Parses the options that every script has, and the options `more`: name -> keywords of add_argument."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--barrelman", default=str(ROOT / "target/release/barrelman"), help="the program")
    parser.add_argument("--json", metavar="FILE", help="write the figures here, too")
    for name, keywords in more.items():
        parser.add_argument(f"--{name.replace('_', '-')}", **keywords)
    args = parser.parse_args()
    args.barrelman = str(pathlib.Path(args.barrelman).resolve())
    if not os.access(args.barrelman, os.X_OK):
        sys.exit(f"{args.barrelman} is not there: cargo build --release, or give --barrelman PATH")
    atexit.register(_end_children)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _leave)
    return args


def temporary_folder():
    folder = tempfile.TemporaryDirectory(prefix="barrelman-")
    _cleanups.append(folder.cleanup)
    return pathlib.Path(folder.name)


def shared(*parts):
    """A folder of the data beside the repository; None, said, if the folder is absent. In CI the script fails then."""
    path = SHARED.joinpath(*parts)
    if path.exists():
        return path
    print(f"skipped: {path} is not there")
    if os.environ.get("CI"):
        sys.exit(1)
    return None


def shared_or_skip(*parts):
    """A folder of the data beside the repository; the script ends if the folder is absent."""
    return shared(*parts) or sys.exit(0)


class Table:
    """Prints requirements and measurements at once, and gives the exit code at the end."""

    def __init__(self, title):
        self.rows = []
        self.failed = 0
        self.lock = threading.Lock()
        print(f"{title}\n", flush=True)

    def require(self, name, holds, measured="", wanted=""):
        with self.lock:
            self.rows.append({"name": name, "measured": measured, "wanted": wanted, "holds": bool(holds)})
            self.failed += not holds
            self._print("ok  " if holds else "FAIL", name, measured, wanted)
        return bool(holds)

    def require_in_time(self, standstills, name, holds, measured="", wanted=""):
        """Requires what holds only without standstills of the machine; a failure after one is shown and not judged."""
        if holds or not standstills.found:
            return self.require(name, holds, measured, wanted)
        self.show(name, measured, f"{wanted} NOT JUDGED: {standstills}".strip())
        return True

    def try_again_through_standstills(self, act):
        """Calls `act` again while a requirement fails and the machine stood still, at most ATTEMPTS times.

        `act` gets the rows for its requirements. A fault of the program fails in every attempt, and in an attempt
        without a standstill.
        """
        for _ in range(ATTEMPTS):
            rows = Rows()
            with Standstills() as standstills:
                figures = act(rows)
            if rows.hold() or not standstills.found:
                break
        for row in rows.rows:
            self.require_in_time(standstills, *row)
        return figures

    def show(self, name, measured, note=""):
        with self.lock:
            self.rows.append({"name": name, "measured": measured, "wanted": note, "holds": None})
            self._print("    ", name, measured, note)

    @staticmethod
    def _print(mark, name, measured, wanted):
        print(f"{mark} {name:<62} {measured!s:<30} {wanted}".rstrip(), flush=True)

    def finish(self, args, **more):
        counted = sum(row["holds"] is not None for row in self.rows)
        print(f"\n{counted - self.failed} of {counted} requirements hold")
        if args.json:
            pathlib.Path(args.json).write_text(json.dumps({"rows": self.rows, **more}, indent=1, default=str) + "\n")
        return 1 if self.failed else 0


class Rows:
    """Requirements that are not in the table yet."""

    def __init__(self):
        self.rows = []

    def require(self, name, holds, measured="", wanted=""):
        self.rows.append((name, bool(holds), measured, wanted))
        return bool(holds)

    def hold(self):
        return all(holds for _, holds, *_ in self.rows)


class Standstills:
    """Detects standstills of the machine: a process that sleeps for 2 ms is woken late.

    A shared machine may pause all processes for tens of milliseconds. A pause says nothing about the program, and a
    requirement of a few milliseconds cannot be measured during a pause.
    """

    LEAST_S = 0.01
    WATCH = "import time\nthen = time.monotonic()\nwhile True:\n    time.sleep(0.002)\n    now = time.monotonic()\n    now - then > %r and print(now - then, flush=True)\n    then = now\n"

    def __enter__(self):
        self.found = []
        self.child = spawn([sys.executable, "-c", self.WATCH % self.LEAST_S], stdout=subprocess.PIPE, text=True)
        return self

    def __exit__(self, *_):
        self.child.kill()
        self.found = [float(line) for line in self.child.communicate()[0].split()]

    def __str__(self):
        return f"the machine stood still {len(self.found)} times, for up to {max(self.found, default=0) * 1e3:.0f} ms"


def environment():
    """The environment of a child: without the variables that make the program print backtraces and more log lines."""
    return {name: value for name, value in os.environ.items() if name not in ("RUST_BACKTRACE", "RUST_LOG")}


def spawn(command, **keywords):
    """Starts a child process, which is killed when this script ends."""
    keywords.setdefault("env", environment())
    child = subprocess.Popen([str(word) for word in command], **keywords)
    _children.append(child)
    return child


def run(command, timeout=60, **keywords):
    """Runs a command to its end; the result has standard output and standard error as text."""
    keywords.setdefault("env", environment())
    return subprocess.run(
        [str(word) for word in command], timeout=timeout, capture_output=True, text=True, stdin=subprocess.DEVNULL, **keywords
    )


def wait_until(condition, seconds, what):
    """Waits until a condition holds, and returns its value."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.005)
    raise TimeoutError(f"{what} did not come within {seconds} s")


class Lines:
    """The lines that a child prints, with their times. A thread reads each line at once, so that the child never blocks."""

    def __init__(self, stream):
        self.lines = []
        self._new = queue.Queue()
        self._thread = threading.Thread(target=self._read, args=(stream,), daemon=True)
        self._thread.start()

    def _read(self, stream):
        for line in stream:
            self.lines.append((time.monotonic(), line.rstrip("\n")))
            self._new.put(line)
        self._new.put(None)

    def wait_for(self, pattern, seconds):
        end = time.monotonic() + seconds
        while True:
            for at, line in list(self.lines):
                if re.search(pattern, line):
                    return at, line
            left = end - time.monotonic()
            if left <= 0:
                raise TimeoutError(f"no line with {pattern!r} within {seconds} s; the last were {self.text()[-400:]!r}")
            with contextlib.suppress(queue.Empty):
                self._new.get(timeout=min(left, 0.1))

    def text(self):
        return "\n".join(line for _, line in self.lines)

    def join(self):
        self._thread.join(timeout=5)


class Emulator:
    """An emulated Fotokite Pro on a pseudo-terminal."""

    def __init__(self, barrelman, folder, name="fotokite", *options):
        self.port = pathlib.Path(folder) / name
        self.log = pathlib.Path(folder) / f"{name}.jsonl"
        command = [barrelman, "emulate", "fotokite-pro", "--pty", self.port, "--log", self.log, *options]
        self.child = spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.lines = Lines(self.child.stdout)
        self.lines.wait_for("answers at", 10)

    @property
    def url(self):
        return f"serial:{self.port}"

    def rows(self):
        """The rows of the log so far, without a line that is not complete yet."""
        text = self.log.read_text()
        return [Row(json.loads(line)) for line in text[: text.rfind("\n") + 1].splitlines()]

    def heard(self):
        return [row for row in self.rows() if row.direction == "in"]

    def wait_for(self, condition, seconds, what):
        """Waits for a row of the log that fulfils the condition; each look reads only new text."""
        end = time.monotonic() + seconds
        with open(self.log) as file:
            rest = ""
            while time.monotonic() < end:
                rest += file.read()
                *lines, rest = rest.split("\n")
                for line in lines:
                    row = Row(json.loads(line))
                    if condition(row):
                        return row
                time.sleep(0.003)
        raise TimeoutError(f"{what} did not come within {seconds} s")

    def close(self):
        if self.child.poll() is None:
            self.child.terminate()
            try:
                self.child.wait(timeout=5)
            except subprocess.TimeoutExpired:
                self.child.kill()
                self.child.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Row:
    """A line of the emulator's log."""

    MOTION = re.compile(r"(Yaw|GimbalPitch|Gimbal) (.+)")

    def __init__(self, row):
        self.at = row["mono_ns"] / 1e9
        self.direction = row["direction"]
        self.raw = row["raw"]
        self.state = row["state"]
        self.rates = (row["state"]["yaw_rate"], row["state"]["pitch_rate"])
        match = self.MOTION.fullmatch(self.raw) if self.direction == "in" else None
        self.name = match[1] if match else None
        self.values = tuple(float(value) for value in match[2].split(",")) if match else ()

    @property
    def is_motion(self):
        return self.name is not None

    @property
    def is_zero(self):
        return self.is_motion and not any(self.values)

    @property
    def moves(self):
        return self.is_motion and any(self.values)


def busiest_second(rows):
    """The largest number of lines with a rate other than zero that the ground station received within a second.

    The program sends such lines 50 ms apart, so exactly 20 in a second. The second is shortened by the jitter of the
    times in the log, so that a line that was read late does not count as the 21st.
    """
    moving = [row.at for row in rows if row.moves]
    return max((sum(at <= other < at + 1 - LISTENING_JITTER for other in moving) for at in moving), default=0)


class Recording:
    """A recording, read with the Python package up to its end or to the place where the recording is cut off."""

    def __init__(self, path):
        from mcap.exceptions import McapError
        from mcap.reader import NonSeekingReader
        from mcap_protobuf.decoder import DecoderFactory

        self.topics = {}
        self.schemas = {}
        self.start = None
        self.cut = None
        with open(path, "rb") as file:
            try:
                for schema, channel, message, decoded in NonSeekingReader(
                    file, decoder_factories=[DecoderFactory()]
                ).iter_decoded_messages(log_time_order=False):
                    self.topics.setdefault(channel.topic, []).append(decoded)
                    self.schemas[channel.topic] = schema.name
            except (McapError, EOFError, ValueError) as error:
                self.cut = error
        if self["/recording/start"]:
            self.start = self["/recording/start"][0].monotonic_ns / 1e9

    def __getitem__(self, topic):
        return self.topics.get(topic, [])

    def at(self, ns):
        """Converts a time of the recording to the machine's clock, seconds."""
        return self.start + ns / 1e9

    @property
    def outcomes(self):
        return self["/outcome"]

    @property
    def frames(self):
        return self["/input/frame"]

    def requests(self):
        """The requests, each with the time of its step in nanoseconds."""
        return [(message.now_ns, json.loads(message.request)) for message in self["/input/request"]]

    def stopped_at(self):
        """The time of the first stop on the machine's clock, seconds; None without one."""
        return next((self.at(now_ns) for now_ns, request in self.requests() if request["kind"] == "stop"), None)


def practice_clip(args, folder):
    """The practice clip and its truth, newly drawn, or from the folder of `--clip DIR`."""
    if getattr(args, "clip", None):
        where = pathlib.Path(args.clip).resolve()
    else:
        where = folder / "practice"
        done = run([args.barrelman, "demo", "--clip", "--draw-only", "--output", where], timeout=180)
        if done.returncode:
            sys.exit(f"the practice clip could not be drawn: {done.stderr}")
    return where / "practice.mp4", read_truth(where / "truth.csv")


CLIP = {"metavar": "DIR", "help": "take practice.mp4 and truth.csv from here instead of drawing them"}


def read_truth(path):
    import csv

    with open(path, newline="") as file:
        return [{name: float(value) if value else None for name, value in row.items()} for row in csv.DictReader(file)]


def selection(truth):
    """A box that lies within the hull at every heading of the boat."""
    cx, cy = truth[0]["cx"], truth[0]["cy"]
    return f"{cx - 13:.0f},{cy - 13:.0f},26,26"


def memory_mb(child, figure="VmRSS"):
    """Memory of a process, MB: what is resident now, or with `VmHWM` the most that ever was. Infinite after its end."""
    text = pathlib.Path(f"/proc/{child.pid}/status").read_text()
    found = re.search(rf"{figure}:\s+(\d+)", text)
    return int(found[1]) / 1024 if found else float("inf")


def median(values):
    return statistics.median(values) if values else float("nan")


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


class Terminal:
    """A terminal for a program, whose output is read until the terminal is hung up: a terminal without a reader fills up."""

    def __init__(self):
        self.outside, self.inside = pty.openpty()
        self.is_read = True
        self.reader = threading.Thread(target=self._read, daemon=True)

    def start(self):
        """The program has its end of the terminal now."""
        os.close(self.inside)
        self.reader.start()

    def _read(self):
        while self.is_read:
            drain(self.outside, 0.02)

    def type(self, key):
        os.write(self.outside, key)

    def hang_up(self):
        """Closes the terminal once no read is under way, and returns the time of that. A closed one stays so."""
        if not self.is_read:
            return None
        self.is_read = False
        self.reader.join()
        at = time.monotonic()
        os.close(self.outside)
        return at


def drain(descriptor, seconds=0.0):
    """The output of a terminal that can be read now."""
    text = b""
    while select.select([descriptor], [], [], seconds)[0]:
        try:
            piece = os.read(descriptor, 65536)
        except OSError:
            # The other end has gone, which is told at once and for ever.
            time.sleep(seconds)
            break
        if not piece:
            break
        text += piece
    return text
