"""Tests that the guard rests the camera whatever becomes of the program, with real processes.

Each case runs the practice clip with the camera engaged over a pseudo-terminal or TCP, waits until the camera moves, and
causes one event: the program is killed, crashes, runs out of memory, is stopped, loses its terminal, or loses its guard. The
emulator's log has what the ground station received, and the rates in force. The worst ground station is emulated, too: one
whose `stop` leaves the rates in force.
"""
import concurrent.futures
import contextlib
import itertools
import os
import pathlib
import resource
import signal
import subprocess
import sys
import time

import common
from common import Emulator, Lines, Table

MOVES_WITHIN = 10.0
REST_LIMIT = 0.35
UP_AGAIN_LIMIT = 4.0
GUARD_ENDS_WITHIN = 8.0
HANG_S = 5.0
AWAY_S = 1.3
SILENT_GUARD_LIMIT = 5.0
GROWS_AT_FRAME = 150


class TcpEmulator(Emulator):
    """An emulated Fotokite Pro behind TCP."""

    def __init__(self, barrelman, folder, *options):
        self.log = pathlib.Path(folder) / "fotokite.jsonl"
        command = [barrelman, "emulate", "fotokite-pro", "--listen", "127.0.0.1:0", "--log", self.log, *options]
        self.child = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.lines = Lines(self.child.stdout)
        _, line = self.lines.wait_for("answers at", 10)
        self.address = line.split("answers at ")[1].strip()

    @property
    def url(self):
        return self.address


def children(pid):
    """The processes that a process started, and their names."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                stat = (entry / "stat").read_text()
            except OSError:
                continue
            name, rest = stat[stat.index("(") + 1 : stat.rindex(")")], stat[stat.rindex(")") + 2 :].split()
            if int(rest[1]) == pid:
                found[int(entry.name)] = name
    return found


def is_alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


class Run:
    """A run with an emulator of its own, and its guard."""

    def __init__(self, args, clip, selection, folder, port, more=(), station=(), terminal=False, grows=False, faults=None):
        folder.mkdir()
        if faults:
            (folder / "faults").write_text(faults + "\n")
            more = (*more, "--faults", folder / "faults")
        video = growing_pictures(clip, folder / "pictures") if grows else clip
        self.emulator = Emulator(args.barrelman, folder, "fotokite", *station) if port == "pty" else TcpEmulator(args.barrelman, folder, *station)
        command = [args.barrelman, "run", "--headless", "--engage", "--tracker", "camshift", "--mode", common.HARDLY_RESTS, "--no-record", "--video", f"file:{video}"]
        command += ["--select", selection, "--link", self.emulator.url, *more]
        self.terminal = common.Terminal() if terminal else None
        streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        if terminal:
            streams.update(stdin=self.terminal.inside, stdout=self.terminal.inside, start_new_session=True)
        self.started = time.monotonic()
        self.child = common.spawn(command, text=True, **streams)
        if terminal:
            self.terminal.start()
        self.err = Lines(self.child.stderr)
        self.guards = []
        self.back_at = None

    def guard(self):
        """The guard's process."""
        found = [pid for pid, name in children(self.child.pid).items() if name.startswith("barrelman-guard")]
        if len(found) != 1:
            raise AssertionError(f"{len(found)} guards instead of one")
        self.guards.append(found[0])
        return found[0]

    def wait_until_it_moves(self):
        self.emulator.wait_for(lambda row: row.moves, MOVES_WITHIN, "the first rate")
        time.sleep(0.2)
        return self.guard()

    def close(self):
        guards = {pid for pid, name in children(self.child.pid).items() if name.startswith("barrelman-guard")} | set(self.guards)
        if self.child.poll() is None:
            self.child.send_signal(signal.SIGCONT)
            self.child.kill()
            self.child.wait()
        # A guard whose port is gone holds the lock of its vehicle for a minute, and a pseudo-terminal's name is used again.
        with contextlib.suppress(TimeoutError):
            common.wait_until(lambda: not any(is_alive(pid) for pid in guards), GUARD_ENDS_WITHIN, "the guard's end")
        if self.terminal is not None:
            self.terminal.hang_up()
        self.emulator.close()


def killed(number):
    def act(run):
        run.wait_until_it_moves()
        at = time.monotonic()
        # The program takes the first SIGSEGV that nothing caused for an overflowed stack that was none.
        while run.child.poll() is None:
            run.child.send_signal(number)
            time.sleep(0.001)
        return at

    return act


def out_of_memory(run):
    """No further memory: the pictures of the video become larger, and need some."""
    run.wait_until_it_moves()
    resource.prlimit(run.child.pid, resource.RLIMIT_AS, (1 << 20, 1 << 20))
    # The clock runs from the death of the program: until then it renews its rates.
    at, end = time.monotonic(), time.monotonic() + 15
    while run.child.poll() is None and time.monotonic() < end:
        at = time.monotonic()
        time.sleep(0.001)
    if run.child.returncode != -signal.SIGABRT:
        raise AssertionError(f"exit {run.child.returncode} instead of running out of memory")
    return at


def growing_pictures(clip, folder):
    """The first seconds of the clip as a folder of pictures, followed by one that takes 44 MB."""
    import cv2

    folder.mkdir()
    video = cv2.VideoCapture(str(clip))
    for frame in range(GROWS_AT_FRAME):
        picture = video.read()[1]
        cv2.imwrite(str(folder / f"{frame:04}.jpg"), picture)
    for frame in range(GROWS_AT_FRAME, GROWS_AT_FRAME + 30):
        cv2.imwrite(str(folder / f"{frame:04}.jpg"), cv2.resize(picture, (5120, 2880)))
    return f"{folder}?fps=30"


def stopped(run):
    run.wait_until_it_moves()
    at = time.monotonic()
    run.child.send_signal(signal.SIGSTOP)
    time.sleep(HANG_S)
    run.child.send_signal(signal.SIGCONT)
    return at


def away(run):
    """The program is away for longer than a second, and waits for the operator afterwards."""
    run.wait_until_it_moves()
    at = time.monotonic()
    run.child.send_signal(signal.SIGSTOP)
    time.sleep(AWAY_S)
    run.child.send_signal(signal.SIGCONT)
    run.back_at = time.monotonic()
    time.sleep(2.0)
    return at


def guard_hangs(run):
    pid = run.wait_until_it_moves()
    at = time.monotonic()
    os.kill(pid, signal.SIGSTOP)
    return at


def guard_killed(run):
    pid = run.wait_until_it_moves()
    at = time.monotonic()
    os.kill(pid, signal.SIGKILL)
    return at


def terminal_closed(run):
    run.wait_until_it_moves()
    return run.terminal.hang_up()


def by_itself(seconds):
    """A fault of the program's own file of faults. Its times count from the program's start, at the script's clock."""

    def act(run):
        run.wait_until_it_moves()
        at = run.started + seconds
        time.sleep(max(0.0, at - time.monotonic()))
        return at

    return act


# When a fault of a file begins: the camera turns again and again by then.
FAULT_AT_S = 7.0


# Name, what happens, whether the guard must end by itself, further options of the run.
CASES = [
    ("SIGKILL", killed(signal.SIGKILL), True, {}),
    ("SIGSEGV", killed(signal.SIGSEGV), True, {}),
    ("SIGABRT", killed(signal.SIGABRT), True, {}),
    ("SIGSTOP for 5 s", stopped, False, {}),
    ("memory limit (RLIMIT_AS)", out_of_memory, True, {"grows": True}),
    ("SIGSTOP for 1.3 s, then no motion", away, False, {}),
    ("guard killed", guard_killed, False, {}),
    ("guard hangs (SIGSTOP)", guard_hangs, False, {}),
    ("terminal closed", terminal_closed, True, {"terminal": True}),
    ("the pilot hangs (--faults)", by_itself(FAULT_AT_S), False, {"faults": f"pilot: hang@{FAULT_AT_S}"}),
    ("suspended for 3 s (--faults)", by_itself(FAULT_AT_S), False, {"faults": f"program: suspend@{FAULT_AT_S}+3"}),
]
TRIES_TO_HIT_A_MOTION = 4
STATIONS = [("", ()), (", stop keeps rates", ("--stop-keeps-rates",))]


def check_first_bytes(run, rows, since):
    """After a session began anew, zeros must come before anything else."""
    heard = [row for row in rows if row.direction == "in" and row.at > since]
    first_stop = next((index for index, row in enumerate(heard) if row.raw == "stop"), None)
    return [] if first_stop is None or any(row.is_zero for row in heard[:first_stop]) else ["`stop` came before the zeros"]


def try_case(args, clip, selection, folder, table, case, port, station):
    name, act, ends, options = case
    suffix, station_options = station
    run = Run(args, clip, selection, folder, port, station=station_options, **options)
    title = f"{name}, {port}{suffix}"
    try:
        at = act(run)
        time.sleep(0.6)
        rows = run.emulator.rows()
        before = next((row.rates for row in reversed(rows) if row.at < at), (0.0, 0.0))
        rest = next((row.at - at for row in rows if row.at >= at and row.rates == (0.0, 0.0)), float("inf"))
        faults = []
        if not any(before):
            faults.append("the camera did not move when it happened")
        if rest > REST_LIMIT:
            faults.append(f"later than {REST_LIMIT} s")
        faults += check_first_bytes(run, rows, at)
        if run.back_at is not None and any(row.moves for row in rows if row.at > run.back_at):
            faults.append("the camera moved again without Engage")
        if ends:
            common.wait_until(lambda: not any(is_alive(pid) for pid in run.guards), GUARD_ENDS_WITHIN, "the guard's end")
            time.sleep(0.05)
            heard = run.emulator.heard()
            if heard[-1].raw != "stop" or heard[-1].rates != (0.0, 0.0):
                faults.append(f"the last line is {heard[-1].raw!r}, the rates {heard[-1].rates}")
        elif act in (guard_killed, guard_hangs):
            run.err.wait_for("camera may be turning", 2)
            again = run.emulator.wait_for(lambda row: row.direction == "in" and row.at > at and row.raw == "RemoteControl start", 6, "another guard")
            if again.at - at > UP_AGAIN_LIMIT:
                faults.append(f"up again after {again.at - at:.1f} s")
        table.require(title, not faults, f"rest after {rest * 1e3:.0f} ms", "; ".join(faults))
        return {"case": title, "rest_ms": rest * 1e3, "was_moving": any(before)}
    finally:
        run.close()


def try_port_lost(args, clip, selection, folder, table, port):
    """The port goes away for two seconds and comes back: up again within 4 s, without a restart, zeros first."""
    lost_at, gone_for = 5.0, 2.0
    run = Run(args, clip, selection, folder, port, station=("--fault", f"disconnect@{lost_at}+{gone_for}"))
    try:
        run.wait_until_it_moves()
        run.err.wait_for("the link was lost", 8)
        began = time.monotonic()
        zeros = run.emulator.wait_for(lambda row: row.is_zero and row.at > began, 6, "zeros after the port's return")
        up = run.emulator.wait_for(lambda row: row.direction == "in" and row.raw.startswith("Get_Gimbal") and row.at > zeros.at, 6, "the link's return")
        faults = check_first_bytes(run, run.emulator.rows(), began)
        taken = up.at - zeros.at + 0.3
        if taken > UP_AGAIN_LIMIT:
            faults.append(f"later than {UP_AGAIN_LIMIT} s")
        table.require(f"the port is gone for {gone_for:.0f} s, {port}", not faults, f"up again after {taken:.1f} s", "; ".join(faults))
        return {"case": f"port lost, {port}", "up_again_s": taken}
    finally:
        run.close()


def try_control_taken(args, clip, selection, folder, table, port):
    """The control is taken at the ground station itself, in mid-motion: nothing is sent any more, until a new Engage."""
    folder.mkdir()
    at_s = FAULT_AT_S
    run = Run(args, clip, selection, folder / "run", port, station=("--fault", f"takeover@{at_s}"))
    try:
        run.wait_until_it_moves()
        taken = run.emulator.wait_for(lambda row: row.state["station"] == "shell" and row.at > run.started + at_s / 2, at_s + 4, "the ground station in its menu")
        told_at = taken.at
        time.sleep(2.0)
        rows = run.emulator.rows()
        moves = [row for row in rows if row.moves and row.at > told_at + REST_LIMIT]
        faults = [f"{len(moves)} rates after the control was taken"] if moves else []
        faults += ["the control was taken back"] if any(row.raw == "RemoteControl start" and row.at > told_at for row in rows if row.direction == "in") else []
        table.require(f"control taken in mid-motion, {port}", not faults, "no rate without a new Engage", "; ".join(faults))
        return {"case": f"control taken, {port}"}
    finally:
        run.close()


def check_refusal(args, clip, selection, folder, table):
    """Without its guard the program refuses this vehicle, unless it is told otherwise."""
    folder.mkdir()
    with Emulator(args.barrelman, folder) as emulator:
        command = [args.barrelman, "run", "--headless", "--no-record", "--video", f"file:{clip}", "--select", selection, "--link", emulator.url]
        refused = common.run([*command, "--guard", folder / "none"])
        table.require("no guard: refused, with the remedy", refused.returncode == 1 and "--without-guard" in refused.stderr and not emulator.heard(), f"exit {refused.returncode}")
        child = common.spawn([*command, "--without-guard", "--engage"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        err = Lines(child.stderr)
        err.wait_for("goes on turning", 5)
        err.wait_for("link up", 8)
        table.require("--without-guard: runs, with a warning", not children(child.pid))
        child.send_signal(signal.SIGTERM)
        child.wait(timeout=8)
        # A guard that says nothing.
        silent = folder / "silent"
        silent.write_text("#!/bin/sh\nexec sleep 60\n")
        silent.chmod(0o755)
        began = time.monotonic()
        refused = common.run([*command, "--guard", silent])
        taken = time.monotonic() - began
        table.require("a guard that says nothing: refused in time", refused.returncode == 1 and "has said nothing" in refused.stderr and taken < SILENT_GUARD_LIMIT, f"{taken:.1f} s", refused.stderr[-200:])
        # A second run on the same vehicle.
        child = common.spawn([*command, "--engage"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        err = Lines(child.stderr)
        err.wait_for("link up", 8)
        second = common.run(command)
        table.require("a second run: refused, with the first one's process", second.returncode == 1 and f"process {child.pid}" in second.stderr, f"exit {second.returncode}", second.stderr[-200:])
        # A run right after the first one was killed: its guard is waited for.
        child.kill()
        child.wait()
        third = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        err = Lines(third.stderr)
        waited, _ = err.wait_for("waiting for the guard", 3)
        err.wait_for("link up", 8)
        table.require("a run right after a kill -9: waits for the guard", True, "and is up")
        third.send_signal(signal.SIGTERM)
        third.wait(timeout=8)


def main():
    args = common.arguments(
        __doc__, clip=common.CLIP, repeat={"type": int, "default": 1, "help": "how often each case runs"}, at_once={"type": int, "default": 2},
        only={"metavar": "TEXT", "help": "only the cases with this in their name"},
        few={"action": "store_true", "help": "each case once: over pseudo-terminal and TCP in turns"},
    )
    folder = common.temporary_folder()
    clip, truth = common.practice_clip(args, folder)
    selection = common.selection(truth)
    table = Table("What becomes of the camera without the program")
    guard = pathlib.Path(args.barrelman).with_name("barrelman-guard")
    program = guard.read_bytes()
    linked = [name for name in (b"openh264", b"WelsCreateDecoder", b"tiny_skia", b"retina") if name in program]
    table.require("the guard links neither decoder nor renderer", not linked, f"{len(program) / 1e6:.1f} MB", str(linked) if linked else "")
    combinations = list(itertools.product(CASES, ("pty", "tcp"), STATIONS))
    if args.few:
        combinations = [(case, ("pty", "tcp")[number % 2], STATIONS[number // 2 % 2]) for number, case in enumerate(CASES)]
    jobs = [(f"{case[0]}, {port}{station[0]}", lambda where, rows, job=(case, port, station): try_case(args, clip, selection, where, rows, *job)) for case, port, station in combinations * args.repeat]
    jobs += [(f"the port is gone, {port}", lambda where, rows, port=port: try_port_lost(args, clip, selection, where, rows, port)) for port in ("pty", "tcp")]
    jobs += [(f"control taken, {port}", lambda where, rows, port=port: try_control_taken(args, clip, selection, where, rows, port)) for port in ("pty", "tcp")]
    jobs += [("no guard", lambda where, rows: check_refusal(args, clip, selection, where, rows))]
    jobs = [job for job in jobs if not args.only or args.only in job[0]]

    def attempt(job):
        number, (name, act) = job
        places = (folder / f"case{number}-{attempt}" for attempt in itertools.count(1))

        def safely(rows):
            try:
                # An event that hits a camera at rest shows nothing: the case is made again.
                for _ in range(TRIES_TO_HIT_A_MOTION):
                    judged = common.Rows()
                    figures = act(next(places), judged)
                    if figures is None or figures.pop("was_moving", True):
                        break
                for row in judged.rows:
                    rows.require(*row)
                return figures
            except Exception as error:  # One case that goes astray must not hide the others.
                rows.require(name, False, type(error).__name__, str(error)[-300:])
                return {"case": name, "error": str(error)}

        return table.try_again_through_standstills(safely)

    with concurrent.futures.ThreadPoolExecutor(args.at_once) as pool:
        figures = list(pool.map(attempt, enumerate(jobs)))
    rests = [figure["rest_ms"] for figure in figures if figure and "rest_ms" in figure]
    if rests:
        table.show("time to rest: median, worst", f"{common.median(rests):.0f}, {max(rests):.0f} ms", f"{len(rests)} runs, at most {REST_LIMIT * 1e3:.0f} ms")
    return table.finish(args, cases=figures)


if __name__ == "__main__":
    sys.exit(main())
