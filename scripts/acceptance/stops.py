"""Tests that the camera comes to rest and the vehicle receives `stop`, whatever ends or silences a run.

Each case runs the practice clip with the camera engaged, waits until the camera moves, and causes one event. The
emulator's log then has what the ground station received: zeros for both axes, `stop` as the last line, and their
times. The tracker is the paper's, whose track of this clip is known, so that the camera moves at the event.
"""
import concurrent.futures
import contextlib
import itertools
import os
import signal
import subprocess
import sys
import time
import traceback

import common
from common import Emulator, Lines, Recording, Table

# The boat is in the right-hand sector from 3.2 s to 5.7 s of the clip; the link is up after 2.4 s.
FAULT_AT = 3.7
MOVES_WITHIN = 8.0
STALL_LIMIT = 0.35
KEY_LIMIT = 0.1
# Signals, closed outputs and panics have no limit of their own in the requirements; more than this would mean that the
# zeros waited for something that they should not wait for.
EVENT_LIMIT = 0.1
ENDS_WITHIN = 6.0
# Elsewhere than on a terminal a status line comes every 5 s.
STATUS_LINE_AT = 5.0


class Run:
    """A run with an emulator of its own."""

    def __init__(self, args, clip, selection, folder, video_fault="", link_fault="", terminal=False, full="", backtrace=False, more=()):
        folder.mkdir()
        self.emulator = Emulator(args.barrelman, folder)
        self.record = folder / "record.mcap"
        command = [args.barrelman, "run", "--headless", "--engage", "--tracker", "camshift", "--mode", common.HARDLY_RESTS, "--video", f"file:{clip}{video_fault}", "--select", selection]
        command += ["--link", f"{self.emulator.url}{link_fault}", "--record", self.record, *more]
        self.terminal = common.Terminal() if terminal else None
        self.pipe = None
        streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        environment = {**common.environment(), **({"RUST_BACKTRACE": "1"} if backtrace else {})}
        if terminal:
            streams.update(stdin=self.terminal.inside, stdout=self.terminal.inside)
        if full:
            self.pipe, inside = os.pipe()
            streams[full] = inside
        self.started = time.monotonic()
        self.child = common.spawn(command, text=True, env=environment, **streams)
        if full:
            # A description of our own, so that not waiting is our own affair.
            self.filler = os.open(f"/proc/self/fd/{inside}", os.O_WRONLY | os.O_NONBLOCK)
            os.close(inside)
        if terminal:
            self.terminal.start()
        self.err = Lines(self.child.stderr if self.child.stderr else [])

    def fill(self):
        with contextlib.suppress(BlockingIOError):
            while os.write(self.filler, b"x" * 4096):
                pass
        with contextlib.suppress(BlockingIOError):
            while os.write(self.filler, b"x"):
                pass

    def wait_until_it_moves(self, more=0.3):
        self.emulator.wait_for(lambda row: row.moves, MOVES_WITHIN, "the first rate")
        time.sleep(more)

    def key(self, key):
        at = time.monotonic()
        self.terminal.type(key)
        return at

    def signal(self, number):
        at = time.monotonic()
        self.child.send_signal(number)
        return at

    def wait(self):
        code = self.child.wait(timeout=ENDS_WITHIN)
        self.err.join()
        # The emulator hears the last line within its listening period.
        time.sleep(0.05)
        return code

    def rates_before(self, at):
        return next((row.rates for row in reversed(self.emulator.rows()) if row.at < at), (0.0, 0.0))

    def rest_after(self, at):
        """Time from `at` until both axes rest, seconds."""
        return next((row.at - at for row in self.emulator.rows() if row.at >= at and row.rates == (0.0, 0.0)), float("inf"))

    def rest_for_good(self, at):
        """Time from `at` until both axes rest for good, seconds, and whether an axis turned until about `at`.

        `at` may be late where it comes from a line that the program printed, so the order is taken from the log alone.
        """
        rows = self.emulator.rows()
        last = max((index for index, row in enumerate(rows) if any(row.rates)), default=None)
        if last is None:
            return 0.0, False
        rest = rows[last + 1].at - at if last + 1 < len(rows) else float("inf")
        # While an axis turns, telemetry says so ten times a second and more.
        return max(rest, 0.0), rows[last].at > at - 0.3

    def ended_well(self):
        heard = self.emulator.heard()
        motions = [row for row in heard if row.is_motion]
        wait = heard[-1].at - motions[-1].at
        faults = []
        if heard[-1].raw != "stop":
            faults.append(f"the last line is {heard[-1].raw!r}")
        elif wait < 0.48:
            faults.append(f"`stop` {wait:.3f} s after the last zero")
        if heard[-1].rates != (0.0, 0.0):
            faults.append(f"the rates in force are {heard[-1].rates}")
        if not motions[-1].is_zero:
            faults.append(f"the last motion is {motions[-1].raw!r}")
        return faults

    def close(self):
        if self.child.poll() is None:
            self.child.kill()
            self.child.wait()
        if self.terminal is not None:
            self.terminal.hang_up()
        if self.pipe is not None:
            os.close(self.pipe)
            os.close(self.filler)
        self.emulator.close()


def signalled(number):
    def case(run):
        run.wait_until_it_moves()
        return run.signal(number)

    return case


def signalled_twice(run):
    run.wait_until_it_moves()
    at = run.signal(signal.SIGINT)
    run.signal(signal.SIGINT)
    time.sleep(0.2)  # Between the zeros and the `stop`.
    run.signal(signal.SIGTERM)
    return at


def output_closed(run):
    run.wait_until_it_moves()
    at = time.monotonic()
    run.child.stdout.close()
    return at


def errors_closed(run):
    run.wait_until_it_moves()
    os.dup2(os.open(os.devnull, os.O_RDONLY), run.child.stderr.fileno())
    return run.signal(signal.SIGTERM)


def terminal_gone(run):
    run.wait_until_it_moves()
    return run.terminal.hang_up()


def output_held(run):
    """Ctrl-S blocks the output of a terminal. Blocked output must not block the control of the camera."""
    run.wait_until_it_moves()
    run.key(b"\x13")
    time.sleep(0.5)  # Some status lines want out meanwhile.
    return run.key(b"q")


def output_held_and_signalled(run):
    run.wait_until_it_moves()
    run.key(b"\x13")
    time.sleep(0.5)
    return run.signal(signal.SIGTERM)


def output_not_read(run):
    """The output has a reader that does not read. Its pipe is full, so the next status line cannot be written."""
    run.wait_until_it_moves()
    run.fill()
    time.sleep(max(0.0, run.started + STATUS_LINE_AT + 0.3 - time.monotonic()))
    return run.signal(signal.SIGTERM)


def panic_unseen(run):
    """Nothing tells on stderr when the pilot panics: the last frame that it recorded does."""
    run.wait_until_it_moves(more=0.0)
    run.fill()
    run.wait()
    recording = Recording(run.record)
    return recording.at(recording.frames[-1].now_ns)


def quit_key(run):
    run.wait_until_it_moves()
    return run.key(b"q")


def panicked(run):
    at, _ = run.err.wait_for("panic", MOVES_WITHIN)
    return at


def held_up(run):
    """The pilot stalls for less than a second. The link rests the camera by itself, and goes on when the pilot does."""
    run.err.wait_for("held up", MOVES_WITHIN)
    time.sleep(0.2)  # The emulator hears and logs the zeros.
    rest = run.rest_after(run.started + FAULT_AT)
    if rest > 0.45:
        raise AssertionError(f"the camera went on turning for {rest:.3f} s")
    time.sleep(max(0.0, run.started + FAULT_AT + 2.2 - time.monotonic()))
    return run.signal(signal.SIGTERM)


class Case:
    def __init__(self, name, act, code=0, limit=EVENT_LIMIT, **options):
        self.name, self.act, self.code, self.limit, self.options = name, act, code, limit, options


CASES = [
    Case("SIGINT", signalled(signal.SIGINT)),
    Case("SIGTERM", signalled(signal.SIGTERM)),
    Case("SIGHUP", signalled(signal.SIGHUP)),
    Case("SIGQUIT", signalled(signal.SIGQUIT)),
    Case("SIGTSTP", signalled(signal.SIGTSTP)),
    Case("SIGINT twice, then SIGTERM", signalled_twice),
    Case("standard output closed", output_closed),
    Case("standard error closed, then SIGTERM", errors_closed),
    Case("key q on a terminal", quit_key, terminal=True),
    Case("Ctrl-S holds the terminal, then key q", output_held, terminal=True),
    Case("Ctrl-S holds the terminal, then SIGTERM", output_held_and_signalled, terminal=True),
    Case("nobody reads a full standard output, then SIGTERM", output_not_read, full="stdout"),
    Case("nobody reads a full standard error, then SIGTERM", output_not_read, full="stderr"),
    Case("nobody reads a full standard error, panic in the pilot", panic_unseen, code=1, full="stderr", more=["--fault", f"pilot:panic@{FAULT_AT}s"]),
    Case("the terminal goes away", terminal_gone, terminal=True),
    Case("panic in the video thread", panicked, code=1, video_fault=f"?fault=panic@{FAULT_AT}s"),
    Case("panic in the link thread", panicked, code=1, link_fault=f"?fault=panic@{FAULT_AT}s"),
    Case("panic in the pilot", panicked, code=1, more=["--fault", f"pilot:panic@{FAULT_AT}s"]),
    Case("panic in the pilot, with RUST_BACKTRACE=1", panicked, code=1, backtrace=True, more=["--fault", f"pilot:panic@{FAULT_AT}s"]),
    Case("the pilot is held up for 0.6 s, then SIGTERM", held_up, more=["--fault", f"pilot:stall@{FAULT_AT}s+0.6"]),
    Case("panic in the recorder", panicked, code=1, more=["--fault", f"recorder:panic@{FAULT_AT}s"]),
    Case("panic in the overlay", panicked, code=1, overlay=True, more=["--fault", f"overlay:panic@{FAULT_AT}s"]),
    Case("panic in the terminal thread", panicked, code=1, more=["--fault", f"terminal:panic@{FAULT_AT}s"]),
    Case("panic in the status thread", panicked, code=1, more=["--fault", f"status:panic@{FAULT_AT}s"]),
]


def try_case(case, args, clip, selection, folder, table):
    more = list(case.options.get("more", ()))
    if case.options.get("overlay"):
        more += ["--overlay", folder.parent / f"{folder.name}.mp4"]
    options = {name: value for name, value in case.options.items() if name in ("video_fault", "link_fault", "terminal", "full", "backtrace")}
    run = Run(args, clip, selection, folder, more=more, **options)
    try:
        at = case.act(run)
        try:
            code, late = run.wait(), []
        except subprocess.TimeoutExpired:
            code, late = None, [f"it has not ended after {ENDS_WITHIN:.0f} s"]
        faults = late + run.ended_well()
        rest, moved = run.rest_for_good(at)
        if not moved:
            faults.append("the camera did not move when it happened")
        if code is not None and code != case.code:
            faults.append(f"exit {code} instead of {case.code}: {run.err.text()[-300:]}")
        if rest > case.limit:
            faults.append(f"later than {case.limit} s")
        table.require(case.name, not faults, f"rest after {rest * 1e3:.1f} ms, exit {code}", "; ".join(faults))
        return {"case": case.name, "rest_ms": rest * 1e3, "exit": code}
    finally:
        run.close()


def try_end_of_video(args, clip, selection, folder, table):
    """Runs the clip's first frames as a folder of pictures, so that the video ends while the camera moves."""
    import cv2

    pictures = folder.parent / f"{folder.name}-pictures"
    pictures.mkdir()
    video = cv2.VideoCapture(str(clip))
    for frame in range(int(FAULT_AT * 30)):
        cv2.imwrite(str(pictures / f"{frame}.jpg"), video.read()[1])
    run = Run(args, pictures, selection, folder, video_fault="?fps=30")
    try:
        code = run.wait()
        faults = run.ended_well()
        recording = Recording(run.record)
        at = recording.stopped_at()
        if at is None:
            faults.append("the end was not put to the pilot")
            at = recording.at(recording.outcomes[-1].now_ns)
        if not any(run.rates_before(at)):
            faults.append("the camera did not move when it happened")
        if code:
            faults.append(f"exit {code}: {run.err.text()[-300:]}")
        rest = run.rest_after(at)
        if rest > EVENT_LIMIT:
            faults.append(f"later than {EVENT_LIMIT} s")
        table.require("end of the video", not faults, f"rest after {rest * 1e3:.1f} ms, exit {code}", "; ".join(faults))
        return {"case": "end of the video", "rest_ms": rest * 1e3, "exit": code}
    finally:
        run.close()


def try_stall(args, clip, selection, folder, table):
    run = Run(args, clip, selection, folder, video_fault=f"?fault=stall@{FAULT_AT}s")
    try:
        run.wait_until_it_moves(more=0.0)
        since = time.monotonic()
        run.emulator.wait_for(lambda row: row.is_zero and row.name == "Yaw" and row.at > since, 5, "the zero")
        time.sleep(0.5)
        run.signal(signal.SIGTERM)
        code = run.wait()
        recording = Recording(run.record)
        fresh = recording.at(recording.frames[-1].now_ns)
        captured = recording.at(recording.frames[-1].captured_ns)
        faults = run.ended_well()
        if not any(run.rates_before(fresh)):
            faults.append("the camera did not move when it happened")
        rest = run.rest_after(fresh)
        if rest > STALL_LIMIT:
            faults.append(f"later than {STALL_LIMIT} s")
        if code:
            faults.append(f"exit {code}")
        table.require("the video stalls (from its last fresh frame)", not faults, f"rest after {rest * 1e3:.1f} ms, exit {code}", "; ".join(faults))
        return {"case": "stall", "rest_ms": rest * 1e3, "from_capture_ms": (fresh - captured + rest) * 1e3, "exit": code}
    finally:
        run.close()


def try_space(args, clip, selection, folder, table):
    run = Run(args, clip, selection, folder, terminal=True)
    try:
        run.wait_until_it_moves()
        at = run.key(b" ")
        time.sleep(0.5)
        rest = run.rest_after(at)
        rested = not any(any(row.rates) for row in run.emulator.rows() if row.at > at + rest)
        table.require("space on a terminal: the camera rests, and goes on resting", rest <= KEY_LIMIT and rested, f"rest after {rest * 1e3:.1f} ms", f"at most {KEY_LIMIT * 1e3:.0f} ms")
        at = run.key(b"e")
        with contextlib.suppress(TimeoutError):
            run.emulator.wait_for(lambda row: row.moves and row.at > at, 1.0, "a rate")
        moved = next((row.at - at for row in run.emulator.rows() if row.moves and row.at > at), float("inf"))
        table.require("then e engages it again", moved <= 0.2, f"moves after {moved * 1e3:.1f} ms", "at most 200 ms")
        at = run.key(b"q")
        code = run.wait()
        faults = run.ended_well()
        table.require("and q ends the run", code == 0 and not faults, f"rest after {run.rest_after(at) * 1e3:.1f} ms, exit {code}", "; ".join(faults))
        return {"case": "space", "rest_ms": rest * 1e3, "again_ms": moved * 1e3, "exit": code}
    finally:
        run.close()


def main():
    args = common.arguments(
        __doc__, clip=common.CLIP, only={"metavar": "TEXT", "help": "only the cases with this in their name"}, at_once={"type": int, "default": 2, "help": "runs at the same time"}
    )
    began = time.monotonic()
    folder = common.temporary_folder()
    clip, truth = common.practice_clip(args, folder)
    selection = common.selection(truth)
    table = Table("What stops the camera, one by one")
    special = [("the video stalls", try_stall), ("space on a terminal", try_space), ("end of the video", try_end_of_video)]
    jobs = [(name, lambda where, rows, act=act: act(args, clip, selection, where, rows)) for name, act in special]
    jobs += [(case.name, lambda where, rows, case=case: try_case(case, args, clip, selection, where, rows)) for case in CASES]
    jobs = [job for job in jobs if not args.only or args.only in job[0]]

    def attempt(job):
        number, (name, act) = job
        places = (folder / f"case{number}-{attempt}" for attempt in itertools.count(1))

        def safely(rows):
            try:
                return act(next(places), rows)
            except Exception as error:  # One case that goes astray must not hide the others.
                rows.require(name, False, type(error).__name__, str(error)[-300:])
                if not isinstance(error, (TimeoutError, subprocess.TimeoutExpired)):
                    traceback.print_exc()
                return {"case": name, "error": str(error)}

        return table.try_again_through_standstills(safely)

    with concurrent.futures.ThreadPoolExecutor(args.at_once) as pool:
        figures = list(pool.map(attempt, enumerate(jobs)))
    print(f"\n{time.monotonic() - began:.0f} s")
    return table.finish(args, cases=figures)


if __name__ == "__main__":
    sys.exit(main())
