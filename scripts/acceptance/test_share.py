"""The annotated live video for programs of others: FFmpeg, GStreamer and a client that misbehaves read it.

The video comes from a camera on loopback, which draws the time and a red patch that moves.
"""

import collections
import contextlib
import dataclasses
import fcntl
import itertools
import json
import os
import pathlib
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest

from camera import HEIGHT, SELECTION, WIDTH, Camera
from client import CONTROL_TOKEN, WATCH_TOKEN, Program
from conftest import Check
from machine import Delay, median, percentile, poll, wait_until
from process import Child, clear_away, free_port, is_alive, run, secret, spawn, stat, threads_of
from rtsp_client import USER, RtspClient
from timecodes import BIT_ROWS

pytestmark = [pytest.mark.clocked("module"), pytest.mark.alone]

ACCENT = np.array((212, 234, 94))  # the colour of the box: blue, green, red
FRAME_BYTES = WIDTH * HEIGHT * 3 // 2
MOST_BEHIND_S = 0.150
# FFmpeg holds about three pictures back.
MOST_BEHIND_BY_FFMPEG_S = 0.250
MOST_READERS = 8
WORLD = "sim:arena1?seed=3&size=640x360"
# From the drawing of the time to the reader: camera, program, barrelman-media, reader, test.
PROCESSES = 5


class Boxes:
    """The newest boxes of the status, which a thread reads all the time."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.newest: collections.deque[Any] = collections.deque(maxlen=1000)
        self.is_read = True
        self.thread = threading.Thread(target=self._read, daemon=True)
        self.thread.start()

    def _read(self) -> None:
        while self.is_read:
            track = self.program.status()["track"] or {}
            if track.get("box"):
                self.newest.append(track["box"])
            time.sleep(0.01)

    def __enter__(self) -> "Boxes":
        return self

    def __exit__(self, *_: object) -> None:
        self.is_read = False
        self.thread.join(timeout=5)


@dataclasses.dataclass
class Shared:
    """A run that shares the video of a camera."""

    program: Program
    url: str

    def url_for(self, password: str = WATCH_TOKEN) -> str:
        return self.url.replace("://", f"://{USER}:{password}@")

    def media(self) -> int:
        """The process that serves; 0 if there is none."""
        return next(iter(media_of(self.program.child)), 0)


def media_of(child: Child) -> list[int]:
    """The processes of barrelman-media that a program started."""
    entries = [int(entry.name) for entry in pathlib.Path("/proc").iterdir() if entry.name.isdigit()]
    found = [(pid, stat(str(pid))) for pid in entries]
    return [
        pid
        for pid, known in found
        if known and known[0].startswith("barrelman-media") and int(known[1][1]) == child.pid
    ]


class Reader:
    """A program that reads the video. Its pictures come through a pipe."""

    def __init__(self, way: str, url: str) -> None:
        command = {
            "ffmpeg": f"ffmpeg -v error -rtsp_transport tcp -fflags nobuffer -flags low_delay -threads 1 "
            f"-analyzeduration 0 -i {url} -fps_mode passthrough -f rawvideo -pix_fmt yuv420p pipe:1",
            "gstreamer": f"gst-launch-1.0 -q rtspsrc location={url} latency=0 ! rtph264depay "
            "! avdec_h264 max-threads=1 ! videoconvert ! video/x-raw,format=I420 ! fdsink sync=false",
        }[way]
        self.child = spawn(command.split(), stdout=subprocess.PIPE)
        assert self.child.stdout is not None
        self.pipe = self.child.stdout.buffer  # type: ignore[attr-defined]
        # Most of a picture at once: each turn of two processes takes its time on a busy machine.
        fcntl.fcntl(self.pipe, fcntl.F_SETPIPE_SZ, 1 << 20)

    def picture(self) -> tuple[float, Any]:
        """The time at which the next picture had come, and its planes: Y, below it U and V."""
        data = self.pipe.read(FRAME_BYTES)
        at = time.monotonic()
        if len(data) < FRAME_BYTES:
            self.child.wait(timeout=10)
            assert self.child.stderr is not None
            raise ConnectionError(f"the reader has ended: {self.child.stderr.read()[-400:]}")
        return at, np.frombuffer(data, np.uint8).reshape(HEIGHT * 3 // 2, WIDTH)

    def delays(self, count: int) -> list[Delay]:
        """How far behind the next pictures are, from the drawing of their times to their arrival."""
        found = []
        for _ in range(count):
            at, planes = self.picture()
            behind = ((at * 1e3 - code_of(planes) + 2**31) % 2**32 - 2**31) / 1e3
            found.append((at - behind, at))
        # Later than the pictures: a standstill is told of once it is over.
        return [Delay.between(begin, end, PROCESSES) for begin, end in found]

    def __enter__(self) -> "Reader":
        return self

    def __exit__(self, *_: object) -> None:
        clear_away(self.child)


def code_of(planes: Any) -> int:
    """The time that the camera has drawn, ms."""
    rows = planes[8 : BIT_ROWS - 8]
    bits = [rows[:, bit * WIDTH // 32 + 8 : (bit + 1) * WIDTH // 32 - 8].mean() > 128 for bit in range(32)]
    return sum(1 << (31 - bit) for bit, one in enumerate(bits) if one)


def has_box(picture: Any, box: Any) -> bool:
    """Whether the four corners of a box are drawn in their colour."""
    left, top, width, height = box
    corners = itertools.product((left, left + width), (top, top + height))
    return all(is_drawn(picture, round(u), round(v)) for u, v in corners)


def is_drawn(picture: Any, u: int, v: int) -> bool:
    near = picture[max(v - 3, 0) : v + 4, max(u - 3, 0) : u + 4].reshape(-1, 3).astype(int)
    return bool(len(near)) and bool(np.abs(near - ACCENT).max(axis=1).min() < 60)


@pytest.fixture(scope="module")
def shared(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shared]:
    tokens = secret(tmp_path_factory.mktemp("share") / "tokens", CONTROL_TOKEN, WATCH_TOKEN)
    url = f"rtsp://127.0.0.1:{free_port()}/boat"
    with (
        Camera() as camera,
        Program(
            barrelman,
            "run",
            *("--no-record", "--video", camera.url, "--select", SELECTION),
            *("--console-token-file", tokens, "--share", url),
        ) as program,
    ):
        program.token = CONTROL_TOKEN
        program.wait_for_track()
        yield Shared(program, url)


@pytest.mark.parametrize("way", ["ffmpeg", "gstreamer"])
def test_a_reader_sees_the_box(shared: Shared, check: Check, way: str) -> None:
    with Boxes(shared.program) as boxes, Reader(way, shared.url_for()) as reader:
        read = [reader.picture()[1] for _ in range(60)]
        pictures = [cv2.cvtColor(planes, cv2.COLOR_YUV2BGR_I420) for planes in read]
        # Later than the pictures, so that their boxes have been read.
        known = list(boxes.newest)
        seen = sum(any(has_box(picture, box) for box in known) for picture in pictures)
        check("the box of the status is drawn", seen > 50, f"in {seen} of {len(pictures)} pictures")
        left, top, width, height = boxes.newest[-1]
        check("nowhere else", not has_box(pictures[-1], (left, top - 120, width, height)))


@pytest.mark.parametrize("way", ["ffmpeg", "gstreamer"])
def test_a_reader_is_hardly_behind(shared: Shared, check: Check, way: str) -> None:
    alone_ms = step_ms(shared)
    with Reader(way, shared.url_for()) as reader:
        reader.delays(30)
        delays = reader.delays(150)
        read_ms = step_ms(shared, reader)
    seconds = [delay.seconds for delay in delays]
    limit = MOST_BEHIND_BY_FFMPEG_S if way == "ffmpeg" else MOST_BEHIND_S
    check.in_time("the median from the camera to the reader", middle_of(delays), limit)
    high = percentile(seconds, 0.95) * 1e3
    check("it is measured", min(seconds) > 0, f"{median(seconds) * 1e3:.0f} ms, 95 %: {high:.0f} ms")
    check(
        "the run loop does not wait", read_ms < 3 * alone_ms + 5, f"{alone_ms:.2f}, {read_ms:.2f} ms a step"
    )


def step_ms(shared: Shared, reader: Reader | None = None) -> float:
    """The median of the step times of a second or two, meanwhile with a reader."""
    times = []
    for _ in range(40):
        times.append(shared.program.status()["video"]["step_ms"])
        if reader:
            reader.picture()
        else:
            time.sleep(0.033)
    return median(times)


def middle_of(delays: list[Delay]) -> Delay:
    return sorted(delays, key=lambda delay: delay.seconds)[len(delays) // 2]


def test_a_login_is_asked_for_by_digest_alone(shared: Shared, check: Check) -> None:
    with RtspClient(shared.url) as client:
        status, answer = client.ask("DESCRIBE")
        check("without a login: 401", status == 401, status)
        check("digest is asked for", "Digest realm=" in answer and "Basic" not in answer, answer)
    cases = [
        ("digest", WATCH_TOKEN, 200),
        ("digest", CONTROL_TOKEN, 401),
        ("digest", "", 401),
        ("basic", WATCH_TOKEN, 401),
        ("basic", CONTROL_TOKEN, 401),
    ]
    for way, password, expected in cases:
        with RtspClient(shared.url, password, way) as client:
            status, answer = client.ask("DESCRIBE")
            check(f"{way} with {password or 'nothing'}: {expected}", status == expected, answer)
    with RtspClient(shared.url, WATCH_TOKEN) as client:
        status, _ = client.ask("DESCRIBE", "/other")
        check("another path: 404", status == 404, status)
        transport = "Transport: RTP/AVP;unicast;client_port=40000-40001\r\n"
        status, _ = client.ask("SETUP", "/stream=0", transport)
        check("packets over UDP: 461", status == 461, status)
    told = shared.program.errors.text()
    check("no token is in the log", WATCH_TOKEN not in told and CONTROL_TOKEN not in told)


def test_a_reader_that_stops_delays_nobody_and_loses_pictures(shared: Shared, check: Check) -> None:
    with RtspClient(shared.url, WATCH_TOKEN) as stopped, Reader("gstreamer", shared.url_for()) as other:
        stopped.play()
        before = stopped.times(1.0)
        other.delays(30)
        check.in_time("the other reader's median", middle_of(other.delays(240)), MOST_BEHIND_S)
        size = memory_mb_of(shared.media())
        after = stopped.times(2.0)
        gaps = [later - earlier for earlier, later in itertools.pairwise(before + after)]
        check("it gets pictures again", len(after) > 20, len(after))
        check("it has lost some", max(gaps) > 2, f"{max(gaps):.1f} s")
        kept = sum(1 for _ in itertools.takewhile(lambda gap: gap < 2, gaps[len(before) :]))
        check("the server has kept few for it", kept < 60, f"{kept} pictures")
        check("the server stays small", size < 200, f"{size:.0f} MB")


def memory_mb_of(pid: int) -> float:
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmRSS:")[1].split()[0]) / 1024


def test_readers_come_and_go(shared: Shared, check: Check) -> None:
    for _ in range(6):
        with RtspClient(shared.url, WATCH_TOKEN) as client:
            client.play()
            assert len(client.times(0.3)) > 1
    with contextlib.ExitStack() as readers:
        for _ in range(MOST_READERS):
            reader = readers.enter_context(RtspClient(shared.url, WATCH_TOKEN))
            wait_until(lambda reader=reader: has_joined(reader), "a reader")  # type: ignore[misc]
        with RtspClient(shared.url, WATCH_TOKEN) as ninth:
            status, _ = ninth.ask("DESCRIBE")
            check("a ninth reader is refused", status == 453, status)
    with RtspClient(shared.url, WATCH_TOKEN) as client:
        wait_until(lambda: has_joined(client), "a reader after the others")
        client.ask("TEARDOWN")
    wait_until(lambda: busy_s(shared, 0.5) < 0.02, "a thread that rests while nobody reads")


def serves(shared: Shared) -> bool:
    """Whether a new reader gets pictures."""
    with contextlib.suppress(OSError), RtspClient(shared.url, WATCH_TOKEN) as client:
        return has_joined(client) and len(client.times(0.5)) > 2
    return False


def has_joined(client: RtspClient) -> bool:
    """Whether a client plays. Those that have left may still be counted for a moment."""
    with contextlib.suppress(AssertionError):
        client.play()
        return True
    return False


def busy_s(shared: Shared, seconds: float) -> float:
    """Processor time of the thread that draws and encodes, within this time."""
    before = threads_of(shared.program.child)["share"]
    time.sleep(seconds)
    return threads_of(shared.program.child)["share"] - before


def test_bad_clients_hold_nobody_up(shared: Shared, check: Check) -> None:
    port = int(shared.url.split(":")[2].split("/")[0])
    media = shared.media()
    with Reader("gstreamer", shared.url_for()) as reader, contextlib.ExitStack() as opened:
        reader.delays(10)
        parts = (b"", b"DESCRIBE rtsp", os.urandom(2000), b"$\x00\xff\xff" + bytes(500))
        for part in parts * 15:
            bad = opened.enter_context(socket.create_connection(("127.0.0.1", port)))
            with contextlib.suppress(OSError):
                bad.sendall(part)
        for content in (b"A" * 300_000, b"GET / HTTP/1.1\r\n\r\n", b"SETUP * RTSP/9.9\r\nCSeq: x\r\n\r\n"):
            with contextlib.suppress(OSError):
                opened.enter_context(socket.create_connection(("127.0.0.1", port))).sendall(content)
        for _ in range(20):
            with contextlib.suppress(OSError), RtspClient(shared.url, "wrong") as wrong:
                wrong.ask("DESCRIBE")
        check.in_time("the reader's median meanwhile", middle_of(reader.delays(60)), MOST_BEHIND_S)
        with RtspClient(shared.url, WATCH_TOKEN) as another:
            another.play()
            check("another reader comes in", len(another.times(0.5)) > 2)
    check("the process is the same", shared.media() == media)
    check("the run goes on", shared.program.child.poll() is None)


def test_a_killed_process_is_replaced(shared: Shared, check: Check) -> None:
    media = shared.media()
    steps = shared.program.status()["video"]["captured_ns"]
    with Reader("gstreamer", shared.url_for()) as reader:
        reader.picture()
        os.kill(media, signal.SIGKILL)
        begin = time.monotonic()
        with pytest.raises(ConnectionError):
            reader.delays(1000)
    wait_until(lambda: serves(shared), "a reader that is served")
    check("another process serves soon", time.monotonic() - begin < 30, time.monotonic() - begin)
    check("by another process", shared.media() not in (0, media), shared.media())
    told = shared.program.errors.count("signal: 9")
    check("the log tells it once", told == 1, shared.program.errors.text()[-400:])
    status = shared.program.status()
    check("the run goes on", status["video"]["captured_ns"] > steps, status["video"])
    check("the boat is tracked", status["track"]["state"] == "tracking", status["track"])


def described(url: str, password: str) -> int:
    """The status of a reader's first request; 0 while nobody serves."""
    try:
        with RtspClient(url, password) as client:
            return client.ask("DESCRIBE")[0]
    except OSError:
        return 0


def test_new_links_change_the_password(barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check) -> None:
    tokens = secret(tmp_path / "tokens", CONTROL_TOKEN, WATCH_TOKEN)
    url = f"rtsp://127.0.0.1:{free_port()}/boat"
    options = ["--no-record", "--video", WORLD, "--console-token-file", tokens, "--share", url]
    with Program(barrelman, "run", *options) as program:
        program.token = CONTROL_TOKEN
        wait_until(lambda: described(url, WATCH_TOKEN) == 200, "a reader with the first password", pause=0.2)
        links = json.loads(program.ask("POST", "/api/v1/links")[1])
        password = links["watch"].partition("#token=")[2]
        wait_until(lambda: described(url, password) == 200, "a reader with the new password", pause=0.2)
        check("the old one is refused", described(url, WATCH_TOKEN) == 401)
        told = program.errors.text()
        check("that is no failure", "is started again" not in told, told[-400:])


def test_the_process_ends_with_the_run_and_without_the_option_there_is_none(
    barrelman: pathlib.Path, check: Check
) -> None:
    url = f"rtsp://127.0.0.1:{free_port()}/boat"
    with Program(barrelman, "run", "--no-record", "--video", WORLD, "--share", url) as program:
        media = wait_until(lambda: media_of(program.child), "the process")[0]
        rights = pathlib.Path(f"/proc/{media}/status")
        limited = poll(lambda: "NoNewPrivs:\t1\nSeccomp:\t2" in rights.read_text(), 20)
        check("it gives up its rights", limited)
    check("it ends with the run", poll(lambda: not is_alive(media), 10))
    with Program(barrelman, "run", "--no-record", "--video", WORLD) as program:
        program.wait_for_track()
        check("no thread without the option", "share" not in threads_of(program.child))
        check("no process without the option", not media_of(program.child))


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("rtsp://0.0.0.0:8554", "names no path"),
        ("rtsps://127.0.0.1:8554/boat", "not encrypted"),
        ("rtsp://watch:secret@127.0.0.1:8554/boat", "the console's watch token"),
        ("rtsp://0.0.0.0:8554/boat", "there is none: leave out --headless"),
    ],
)
def test_other_addresses_are_refused(barrelman: pathlib.Path, address: str, says: str) -> None:
    done = run([barrelman, "run", "--headless", "--no-record", "--video", WORLD, "--share", address])
    assert done.returncode != 0
    assert says in done.stderr, done.stderr
    assert "secret" not in done.stderr, done.stderr
    assert "--share, or share.address" in done.stderr, done.stderr


def checked(barrelman: pathlib.Path, address: str) -> Any:
    done = run([barrelman, "check", "--json", "--video", WORLD, "--share", address])
    return next(result for result in json.loads(done.stdout) if result["what"] == f"share {address}")


def test_check_says_whether_the_address_can_be_listened_on(barrelman: pathlib.Path, check: Check) -> None:
    found = checked(barrelman, f"rtsp://127.0.0.1:{free_port()}/boat")
    check("a free port", found["verdict"] == "ok", found)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        found = checked(barrelman, f"rtsp://127.0.0.1:{taken.getsockname()[1]}/boat")
        check("a port in use", found["verdict"] == "failed" and "in use" in found["details"], found)
    found = checked(barrelman, "rtsp://192.0.2.1:8554/boat")
    check("an address of another machine", found["verdict"] == "failed", found)
