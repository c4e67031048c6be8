"""The camera comes to rest and the vehicle receives `stop`, whatever ends or silences a run.

Each case runs the practice clip with the camera engaged, waits until the camera moves, and causes one event.
The emulator's log then has what the ground station received: zeros for both axes, `stop` as the last line,
and their times. The tracker is the paper's, whose track of this clip is known, so that the camera moves at
the event.
"""

import contextlib
import os
import pathlib
import signal
import subprocess
import time
from collections.abc import Callable
from typing import Any, Self

import cv2
import pytest

from client import HARDLY_RESTS
from conftest import Check, Clip
from emulator import Emulator
from machine import NEVER, Delay, lost, poll, wait_until
from process import Lines, Terminal, environment, spawn
from recording import Recording

pytestmark = [pytest.mark.realtime, pytest.mark.clocked]

# The boat is in the right-hand sector from 3.2 s to 5.7 s of the clip; the link is up after 2.4 s.
FAULT_AT = 3.7
STALL_LIMIT = 0.35
KEY_LIMIT = 0.1
ENDS_WITHIN = 6.0
# Signals, closed outputs and panics have no limit of their own in the requirements; more than this would mean
# that the zeros waited for something that they should not wait for.
EVENT_LIMIT = 0.1
# Elsewhere than on a terminal a status line comes every 5 s.
STATUS_LINE_AT = 5.0
# Threads and processes from an event to the rates in force: the pilot or a signal's thread, the link, guard,
# emulator.
HOPS = 4


class Run:
    """A run with an emulator of its own. `full`: the output that becomes a pipe which nobody reads."""

    def __init__(
        self,
        barrelman: pathlib.Path,
        clip: Clip,
        folder: pathlib.Path,
        video: str = "",
        video_fault: str = "",
        link_fault: str = "",
        is_on_terminal: bool = False,
        full: str = "",
        backtrace: bool = False,
        more: tuple[Any, ...] = (),
    ) -> None:
        self.emulator = Emulator(barrelman, folder)
        self.record = folder / "record.mcap"
        what = f"--tracker camshift --mode {HARDLY_RESTS} --select {clip.selection}".split()
        what += ["--video", f"file:{video or clip.video}{video_fault}"]
        command = [
            barrelman,
            "run",
            "--headless",
            "--engage",
            *what,
            "--link",
            f"{self.emulator.url}{link_fault}",
            "--record",
            self.record,
            *more,
        ]
        self.terminal = Terminal() if is_on_terminal else None
        streams: dict[str, Any] = {"stdout": subprocess.PIPE}
        if self.terminal:
            streams |= {"stdin": self.terminal.inside, "stdout": self.terminal.inside}
        self.pipe = -1
        if full:
            self.pipe, streams[full] = os.pipe()
        self.started = time.monotonic()
        self.child = spawn(
            command, env={**environment(), **({"RUST_BACKTRACE": "1"} if backtrace else {})}, **streams
        )
        if full:
            # A description of our own, so that not waiting is our own affair.
            self.filler = os.open(f"/proc/self/fd/{streams[full]}", os.O_WRONLY | os.O_NONBLOCK)
            os.close(streams[full])
        if self.terminal:
            self.terminal.start()
        self.errors = Lines(self.child.stderr)

    def fill(self) -> None:
        for size in (4096, 1):
            with contextlib.suppress(BlockingIOError):
                while os.write(self.filler, b"x" * size):
                    pass

    def wait_until_it_moves(self, more: float = 0.3) -> None:
        self.emulator.wait_for(lambda row: row.moves, "the first rate")
        time.sleep(more)

    def key(self, key: bytes) -> float:
        assert self.terminal
        return self.terminal.type(key)

    def signal(self, number: int) -> float:
        at = time.monotonic()
        self.child.send_signal(number)
        return at

    def sleep_until(self, seconds: float) -> None:
        """Sleeps until the run is so old."""
        time.sleep(max(0.0, self.started + seconds - time.monotonic()))

    def wait(self) -> int:
        wait_until(
            lambda: self.child.poll() is not None,
            lambda: f"the end of the run after {self.errors.text()[-800:]!r}",
            ENDS_WITHIN,
        )
        self.errors.join()
        # The emulator hears the last line within its listening period.
        time.sleep(0.05)
        return int(self.child.returncode)

    def rest_for_good(self, at: float) -> tuple[Delay, bool]:
        """The time from `at` until both axes rest for good, and whether an axis turned until about `at`.

        `at` may be late where it comes from a line that the program printed, so the order is taken from the
        log alone.
        """
        rows = self.emulator.rows()
        last = max((index for index, row in enumerate(rows) if any(row.rates)), default=None)
        if last is None:
            return NEVER, False
        rest = Delay.between(at, rows[last + 1].at, HOPS) if last + 1 < len(rows) else NEVER
        # While an axis turns, telemetry says so ten times a second and more.
        return rest, rows[last].at > at - 0.3 - lost(at - 0.3, at)

    def ended_well(self, check: Check) -> None:
        heard = self.emulator.heard()
        motions = [row for row in heard if row.is_motion]
        wait = heard[-1].at - motions[-1].at
        is_late = wait >= 0.48 - lost(motions[-1].at - 0.1, heard[-1].at)
        check(
            "`stop` is the last line, half a second after the last zero",
            heard[-1].raw == "stop" and is_late,
            f"{heard[-1].raw} after {wait:.3f} s",
        )
        check("no rate is in force", heard[-1].rates == (0.0, 0.0), heard[-1].rates)
        check("the last motion is a zero", motions[-1].is_zero, motions[-1].raw)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.child.poll() is None:
            self.child.kill()
            self.child.wait()
        if self.terminal:
            self.terminal.hang_up()
        if self.pipe >= 0:
            os.close(self.pipe)
            os.close(self.filler)
        self.emulator.close()


Act = Callable[[Run], float]


def signalled(number: int) -> Act:
    def act(run: Run) -> float:
        run.wait_until_it_moves()
        return run.signal(number)

    return act


def signalled_twice(run: Run) -> float:
    run.wait_until_it_moves()
    at = run.signal(signal.SIGINT)
    run.signal(signal.SIGINT)
    time.sleep(0.2)  # Between the zeros and the `stop`.
    run.signal(signal.SIGTERM)
    return at


def output_closed(run: Run) -> float:
    run.wait_until_it_moves()
    at = time.monotonic()
    assert run.child.stdout
    run.child.stdout.close()
    return at


def errors_closed(run: Run) -> float:
    run.wait_until_it_moves()
    assert run.child.stderr
    os.dup2(os.open(os.devnull, os.O_RDONLY), run.child.stderr.fileno())
    return run.signal(signal.SIGTERM)


def terminal_gone(run: Run) -> float:
    run.wait_until_it_moves()
    assert run.terminal
    return run.terminal.hang_up()


def quit_key_at_once(run: Run) -> float:
    return run.key(b"q")


def terminated(run: Run) -> float:
    return run.signal(signal.SIGTERM)


def output_held(then: Callable[[Run], float]) -> Act:
    """Ctrl-S blocks the output of a terminal. Blocked output must not block the control of the camera."""

    def act(run: Run) -> float:
        run.wait_until_it_moves()
        run.key(b"\x13")
        time.sleep(0.5)  # Some status lines want out meanwhile.
        return then(run)

    return act


def output_not_read(run: Run) -> float:
    """The output has a reader that does not read. Its pipe is full, so the next status line cannot be
    written."""
    run.wait_until_it_moves()
    run.fill()
    run.sleep_until(STATUS_LINE_AT + 0.3)
    return run.signal(signal.SIGTERM)


def panic_unseen(run: Run) -> float:
    """Nothing tells on stderr when the pilot panics: the last frame that it recorded does."""
    run.wait_until_it_moves(more=0.0)
    run.fill()
    run.wait()
    recording = Recording(run.record)
    return recording.at(recording.frames[-1].now_ns)


def quit_key(run: Run) -> float:
    run.wait_until_it_moves()
    return run.key(b"q")


def panicked(run: Run) -> float:
    return run.errors.wait_for("panic")[0]


def held_up(run: Run) -> float:
    """The pilot stalls for less than a second. The link rests the camera by itself, and goes on when the
    pilot does."""
    run.errors.wait_for("held up")
    time.sleep(0.2)  # The emulator hears and logs the zeros.
    at = run.started + FAULT_AT
    rest = Delay.between(at, run.emulator.rest_at(at), HOPS)
    run.sleep_until(FAULT_AT + 2.2)
    rest.judge(0.45)
    return run.signal(signal.SIGTERM)


def fault(where: str, lasts: str = "") -> dict[str, Any]:
    return {"more": ("--fault", f"{where}@{FAULT_AT}s{lasts}")}


def event(name: str, act: Act, code: int = 0, **options: Any) -> Any:
    return pytest.param(act, code, options, id=name)


def panic(thread: str, **options: Any) -> Any:
    return event(f"panic in the {thread} thread", panicked, 1, **fault(f"{thread}:panic"), **options)


EVENTS = [
    *(
        event(number.name, signalled(number))
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGTSTP)
    ),
    event("SIGINT twice, then SIGTERM", signalled_twice),
    event("standard output closed", output_closed),
    event("standard error closed, then SIGTERM", errors_closed),
    event("key q on a terminal", quit_key, is_on_terminal=True),
    event("Ctrl-S holds the terminal, then key q", output_held(quit_key_at_once), is_on_terminal=True),
    event("Ctrl-S holds the terminal, then SIGTERM", output_held(terminated), is_on_terminal=True),
    event("nobody reads a full standard output, then SIGTERM", output_not_read, full="stdout"),
    event("nobody reads a full standard error, then SIGTERM", output_not_read, full="stderr"),
    event(
        "nobody reads a full standard error, panic in the pilot",
        panic_unseen,
        1,
        full="stderr",
        **fault("pilot:panic"),
    ),
    event("the terminal goes away", terminal_gone, is_on_terminal=True),
    event("panic in the video thread", panicked, 1, video_fault=f"?fault=panic@{FAULT_AT}s"),
    event("panic in the link thread", panicked, 1, link_fault=f"?fault=panic@{FAULT_AT}s"),
    *(panic(thread) for thread in ("pilot", "recorder", "terminal", "status")),
    event("panic in the pilot, with RUST_BACKTRACE=1", panicked, 1, backtrace=True, **fault("pilot:panic")),
    event("the pilot is held up for 0.6 s, then SIGTERM", held_up, **fault("pilot:stall", "+0.6")),
    event("panic in the overlay", panicked, 1, overlay=True, **fault("overlay:panic")),
]


@pytest.mark.parametrize(("act", "code", "options"), EVENTS)
def test_camera_rests_after(
    barrelman: pathlib.Path,
    clip: Clip,
    tmp_path: pathlib.Path,
    check: Check,
    act: Act,
    code: int,
    options: dict[str, Any],
) -> None:
    options = dict(options)
    if options.pop("overlay", False):
        options["more"] += ("--overlay", tmp_path / "overlay.mp4")
    with Run(barrelman, clip, tmp_path, **options) as run:
        at = act(run)
        ended = run.wait()
        run.ended_well(check)
        rest, moved = run.rest_for_good(at)
        check("the camera moved when it happened", moved)
        check.in_time("and rests in time", rest, EVENT_LIMIT)
        check(
            "the exit code tells of it",
            ended == code,
            f"{ended}: {run.errors.text()[-300:]}" if ended != code else ended,
        )


def test_camera_rests_at_the_end_of_the_video(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check
) -> None:
    """The clip's first frames are a folder of pictures, so that the video ends while the camera moves."""
    pictures = tmp_path / "pictures"
    pictures.mkdir()
    video = cv2.VideoCapture(str(clip.video))
    for frame in range(int(FAULT_AT * 30)):
        cv2.imwrite(str(pictures / f"{frame}.jpg"), video.read()[1])
    with Run(barrelman, clip, tmp_path, str(pictures), "?fps=30") as run:
        code = run.wait()
        run.ended_well(check)
        at = Recording(run.record).stopped_at()
        assert at is not None, "the end was not put to the pilot"
        check("the camera moved when it happened", any(run.emulator.rates_at(at)))
        check.in_time("and rests in time", Delay.between(at, run.emulator.rest_at(at), HOPS), EVENT_LIMIT)
        check("the exit code is 0", code == 0, run.errors.text()[-300:] if code else "")


def test_camera_rests_when_the_video_stalls(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check
) -> None:
    with Run(barrelman, clip, tmp_path, video_fault=f"?fault=stall@{FAULT_AT}s") as run:
        run.wait_until_it_moves(more=0.0)
        run.sleep_until(FAULT_AT - 0.2)
        run.emulator.wait_for(lambda row: row.is_zero and row.name == "Yaw", "the zero", time.monotonic())
        time.sleep(0.5)
        run.signal(signal.SIGTERM)
        code = run.wait()
        recording = Recording(run.record)
        run.ended_well(check)
        fresh = recording.at(recording.frames[-1].now_ns)
        check("the camera moved when it happened", any(run.emulator.rates_at(fresh)))
        rest = Delay.between(fresh, run.emulator.rest_at(fresh), HOPS)
        check.in_time("it rests in time from the last fresh frame on", rest, STALL_LIMIT)
        check("the exit code is 0", code == 0, code)


def test_keys_of_a_terminal_rest_engage_and_end(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check
) -> None:
    with Run(barrelman, clip, tmp_path, is_on_terminal=True) as run:
        run.wait_until_it_moves()
        at = run.key(b" ")
        wait_until(lambda: run.emulator.rest_at(at) < float("inf"), "rest after space")
        time.sleep(0.5)
        rested_at = run.emulator.rest_at(at)
        check.in_time("space: the camera rests", Delay.between(at, rested_at, HOPS), KEY_LIMIT)
        check("and goes on resting", not any(any(row.rates) for row in run.emulator.since(rested_at)))
        at = run.key(b"e")
        moved = poll(lambda: next((row.at for row in run.emulator.since(at) if row.moves), None), 5.0)
        check.in_time("e engages it again", Delay.between(at, moved, HOPS) if moved else NEVER, 0.2)
        run.key(b"q")
        code = run.wait()
        run.ended_well(check)
        check("q ends the run", code == 0, code)
