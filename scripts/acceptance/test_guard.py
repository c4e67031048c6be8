"""The guard rests the camera whatever becomes of the program, with real processes.

Each case runs the practice clip with the camera engaged over a pseudo-terminal or TCP, waits until the camera
moves, and causes one event: the program is killed, crashes, runs out of memory, is stopped, loses its
terminal, or loses its guard. The emulator's log has what the ground station received, and the rates in force.
The worst ground station is emulated, too: one whose `stop` leaves the rates in force.
"""

import dataclasses
import itertools
import os
import pathlib
import resource
import shutil
import signal
import time
from collections.abc import Callable
from typing import Any, Self

import cv2
import pytest

from client import HARDLY_RESTS
from conftest import Check, Clip
from emulator import Emulator, Row
from machine import Delay, lost, wait_until
from process import Lines, Terminal, end, guards_of, is_alive, run, spawn

pytestmark = [pytest.mark.realtime, pytest.mark.clocked]

REST_LIMIT = 0.35
UP_AGAIN_LIMIT = 4.0
GUARD_ENDS_WITHIN = 8.0
TOLD_WITHIN = 2.0
SILENT_GUARD_LIMIT = 5.0
GROWS_AT_FRAME = 150
# When a fault of a file begins: the camera turns again and again by then.
FAULT_AT_S = 7.0
# How often a fault whose time is fixed is given a camera in motion.
TRIES_TO_HIT_A_MOTION = 4
# Processes from an event to the rates in force: this test, the program, the guard, the emulator.
HOPS = 4


def growing_pictures(clip: Clip, folder: pathlib.Path, first: int) -> str:
    """The first frames of the clip as a folder of pictures, followed by one that takes 44 MB."""
    folder.mkdir()
    video = cv2.VideoCapture(str(clip.video))
    for frame in range(first):
        picture = video.read()[1]
        cv2.imwrite(str(folder / f"{frame:04}.jpg"), picture)
    for frame in range(first, first + 30):
        cv2.imwrite(str(folder / f"{frame:04}.jpg"), cv2.resize(picture, (5120, 2880)))
    return f"{folder}?fps=30"


class Run:
    """A run with an emulator of its own, and its guard."""

    def __init__(
        self,
        barrelman: pathlib.Path,
        clip: Clip,
        folder: pathlib.Path,
        port: str,
        station: tuple[str, ...] = (),
        is_on_terminal: bool = False,
        grows: bool = False,
        faults: str = "",
        number: int = 0,
        guard: pathlib.Path | None = None,
    ) -> None:
        folder.mkdir(exist_ok=True)
        more: list[Any] = ["--guard", guard] if guard else []
        if faults:
            (folder / "faults").write_text(faults + "\n")
            more += ["--faults", folder / "faults"]
        # Another moment in each try: at one of them the camera may rest.
        first = GROWS_AT_FRAME + 11 * number
        video = growing_pictures(clip, folder / "pictures", first) if grows else clip.video
        self.emulator = Emulator(barrelman, folder, *station, is_tcp=port == "tcp")
        what = f"--tracker camshift --mode {HARDLY_RESTS} --no-record --select {clip.selection}".split()
        what += ["--video", f"file:{video}"]
        self.terminal = Terminal() if is_on_terminal else None
        streams = (
            {"stdin": self.terminal.inside, "stdout": self.terminal.inside, "start_new_session": True}
            if self.terminal
            else {}
        )
        self.started = time.monotonic()
        self.child = spawn(
            [barrelman, "run", "--headless", "--engage", *what, "--link", self.emulator.url, *more], **streams
        )
        if self.terminal:
            self.terminal.start()
        self.errors = Lines(self.child.stderr)
        self.guards: list[int] = []
        self.back_at: float | None = None

    def guard(self) -> int:
        """The guard's process."""
        [found] = guards_of(self.child.pid)
        self.guards.append(found)
        return found

    def wait_for_a_rate(self) -> float:
        """Waits for the first rate, and gives its time: enough where the time of the event is fixed."""
        first = self.emulator.wait_for(lambda row: row.moves, "the first rate")
        self.guard()
        return first.at

    def wait_until_it_moves(self) -> int:
        self.emulator.wait_until_it_moves()
        return self.guard()

    def zeros_come_first(self, at: float) -> bool:
        """After a session began anew, zeros must come before anything else."""
        heard = [row for row in self.emulator.heard() if row.at > at]
        before = list(itertools.takewhile(lambda row: row.raw != "stop", heard))
        return len(before) == len(heard) or any(row.is_zero for row in before)

    def guards_have_ended(self) -> bool:
        return not any(is_alive(pid) for pid in self.guards)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.guards += guards_of(self.child.pid)
        if self.child.poll() is None:
            self.child.send_signal(signal.SIGCONT)
            self.child.kill()
            self.child.wait()
        # A guard whose port is gone holds the lock of its vehicle for a minute, and a pseudo-terminal's name
        # is used again.
        wait_until(self.guards_have_ended, "the guard's end")
        if self.terminal:
            self.terminal.hang_up()
        self.emulator.close()


Act = Callable[[Run], float]


def killed(number: int) -> Act:
    def act(run: Run) -> float:
        run.wait_until_it_moves()
        at = time.monotonic()
        # The program takes the first SIGSEGV that nothing caused for an overflowed stack that was none.
        while run.child.poll() is None:
            run.child.send_signal(number)
            time.sleep(0.001)
        return at

    return act


def out_of_memory(run: Run) -> float:
    """No further memory: the pictures of the video become larger, and need some."""
    run.wait_for_a_rate()
    time.sleep(0.2)
    resource.prlimit(run.child.pid, resource.RLIMIT_AS, (1 << 20, 1 << 20))
    # The clock runs from the death of the program: until then it renews its rates.
    # It was alive at `at`: the guard may be heard before the death is seen.
    at = time.monotonic()

    def has_ended() -> bool:
        nonlocal at
        now = time.monotonic()
        if run.child.poll() is None:
            at = now
        return run.child.poll() is not None

    wait_until(has_ended, "the end of the memory", pause=0.001)
    assert run.child.returncode == -signal.SIGABRT
    return at


def stopped(seconds: float, watched_for: float = 0.0) -> Act:
    """`watched_for`: for how long the camera must not move again, as the operator is waited for."""

    def act(run: Run) -> float:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        run.child.send_signal(signal.SIGCONT)
        if watched_for:
            run.back_at = time.monotonic()
            time.sleep(watched_for)
        return at

    return act


def guard_gets(number: int) -> Act:
    def act(run: Run) -> float:
        pid = run.wait_until_it_moves()
        at = time.monotonic()
        os.kill(pid, number)
        return at

    return act


def terminal_closed(run: Run) -> float:
    run.wait_until_it_moves()
    assert run.terminal
    return run.terminal.hang_up()


def by_itself(run: Run) -> float:
    """A fault of the program's own file of faults. Its times count from the program's start."""
    run.wait_for_a_rate()
    at = run.started + FAULT_AT_S
    time.sleep(max(0.0, at - time.monotonic()))
    return at


@dataclasses.dataclass
class Case:
    """`guard`: what becomes of it: it must end by itself, another one must follow, or nothing."""

    name: str
    act: Act
    guard: str = ""
    options: dict[str, Any] = dataclasses.field(default_factory=dict)


CASES = [
    Case("SIGKILL", killed(signal.SIGKILL), "ends"),
    Case("SIGSEGV", killed(signal.SIGSEGV), "ends"),
    Case("SIGABRT", killed(signal.SIGABRT), "ends"),
    Case("SIGSTOP for 5 s", stopped(5.0)),
    Case("memory limit (RLIMIT_AS)", out_of_memory, "ends", {"grows": True}),
    Case("SIGSTOP for 1.3 s, then no motion", stopped(1.3, watched_for=2.0)),
    Case("guard killed", guard_gets(signal.SIGKILL), "another"),
    Case("guard hangs (SIGSTOP)", guard_gets(signal.SIGSTOP), "another"),
    Case("terminal closed", terminal_closed, "ends", {"is_on_terminal": True}),
    Case("the pilot hangs (--faults)", by_itself, "", {"faults": f"pilot: hang@{FAULT_AT_S}"}),
    Case("suspended for 3 s (--faults)", by_itself, "", {"faults": f"program: suspend@{FAULT_AT_S}+3"}),
]
PORTS = ("pty", "tcp")
STATIONS: list[tuple[str, ...]] = [(), ("--stop-keeps-rates",)]


def combinations() -> list[Any]:
    """Each case on each port with each ground station; all but one of each case are long."""
    found = []
    for number, case in enumerate(CASES):
        for port, station in itertools.product(PORTS, STATIONS):
            is_short = (port, station) == (PORTS[number % 2], STATIONS[number // 2 % 2])
            name = ", ".join([case.name, port, *(["stop keeps rates"] if station else [])])
            found.append(
                pytest.param(case, port, station, id=name, marks=[] if is_short else [pytest.mark.long])
            )
    return found


@pytest.mark.parametrize(("case", "port", "station"), combinations())
def test_camera_rests(
    barrelman: pathlib.Path,
    clip: Clip,
    tmp_path: pathlib.Path,
    check: Check,
    case: Case,
    port: str,
    station: tuple[str, ...],
) -> None:
    for number in range(TRIES_TO_HIT_A_MOTION):
        with Run(
            barrelman, clip, tmp_path / str(number), port, station, number=number, **case.options
        ) as run:
            at = case.act(run)
            time.sleep(0.6)
            # A fault whose time is fixed may find the camera at rest, which shows nothing.
            if any(run.emulator.rates_at(at)):
                judge(check, run, at, case)
                return
    pytest.fail("the camera did not move when it happened")


def judge(check: Check, run: Run, at: float, case: Case) -> None:
    check.in_time("the camera rests in time", Delay.between(at, run.emulator.rest_at(at), HOPS), REST_LIMIT)
    check("zeros come before `stop`", run.zeros_come_first(at))
    if run.back_at is not None:
        check(
            "the camera moves only after Engage",
            not any(row.moves for row in run.emulator.since(run.back_at)),
        )
    if case.guard == "ends":
        wait_until(run.guards_have_ended, "the guard's end", GUARD_ENDS_WITHIN)
        time.sleep(0.05)
        last = run.emulator.heard()[-1]
        check(
            "the last line is `stop`, at rest",
            (last.raw, last.rates) == ("stop", (0.0, 0.0)),
            f"{last.raw} {last.rates}",
        )
    elif case.guard == "another":
        run.errors.wait_for("camera may be turning", TOLD_WITHIN)
        again = run.emulator.wait_for(
            lambda row: row.is_heard and row.raw == "RemoteControl start", "another guard", at
        )
        check.in_time("another guard is up in time", Delay.between(at, again.at, HOPS), UP_AGAIN_LIMIT)


def test_guards_that_come_to_nothing_leave_the_zeros_to_the_program(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check
) -> None:
    """As during an upgrade: the file of the guard is another one when a guard is lost."""
    guard = tmp_path / "barrelman-guard"
    shutil.copy(barrelman.with_name("barrelman-guard"), guard)
    with Run(barrelman, clip, tmp_path / "run", "tcp", guard=guard) as run:
        pid = run.wait_until_it_moves()
        guard.unlink()
        guard.write_text("#!/bin/sh\nexit 2\n")
        guard.chmod(0o755)
        at = time.monotonic()
        os.kill(pid, signal.SIGKILL)
        time.sleep(3.0)
        rest = Delay.between(at, run.emulator.rest_at(at), HOPS)
        check.in_time("the camera rests in time", rest, REST_LIMIT)
        check(
            "it does not move before there is a guard",
            not any(row.moves for row in run.emulator.since(at + 1)),
        )
        # The guard that was killed, and the first of those that came to nothing.
        check("guards without end are told once", run.errors.count("the guard is gone") == 2)
        shutil.copy(barrelman.with_name("barrelman-guard"), tmp_path / "whole")
        (tmp_path / "whole").rename(guard)
        restored_at = time.monotonic()
        again = run.emulator.wait_for(
            lambda row: row.is_heard and row.raw.startswith("Get_Gimbal"), "a link by a guard", restored_at
        )
        check.in_time("the link is up again", Delay.between(restored_at, again.at, HOPS), UP_AGAIN_LIMIT + 1)
        run.guard()


@pytest.mark.parametrize("port", PORTS)
def test_port_that_was_gone_is_up_again_with_zeros_first(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check, port: str
) -> None:
    with Run(barrelman, clip, tmp_path, port, ("--fault", "disconnect@5.0+2.0")) as run:
        run.wait_for_a_rate()
        run.errors.wait_for("the link was lost")
        lost_at = time.monotonic()
        zeros = run.emulator.wait_for(lambda row: row.is_zero, "zeros after the port's return", lost_at)
        up = run.emulator.wait_for(
            lambda row: row.is_heard and row.raw.startswith("Get_Gimbal"), "the link's return", zeros.at
        )
        check("zeros come first", run.zeros_come_first(lost_at))
        check.in_time(
            "the link is up again in time", Delay.between(zeros.at - 0.3, up.at, HOPS), UP_AGAIN_LIMIT
        )


@pytest.mark.parametrize("port", PORTS)
def test_control_that_is_taken_in_mid_motion_is_left_alone(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check, port: str
) -> None:
    with Run(barrelman, clip, tmp_path, port, ("--fault", f"takeover@{FAULT_AT_S}")) as run:
        moved_at = run.wait_for_a_rate()
        taken_at = run.emulator.wait_for(
            lambda row: row.station == "shell", "the ground station in its menu", moved_at
        ).at
        time.sleep(2.0)
        heard: list[Row] = [row for row in run.emulator.since(taken_at) if row.is_heard]
        late = [
            row.raw
            for row in heard
            if row.moves and row.at > taken_at + REST_LIMIT + lost(taken_at, row.at, HOPS)
        ]
        check("no rate is sent without a new Engage", not late, late)
        check("the control is not taken back", not any(row.raw == "RemoteControl start" for row in heard))


def test_guard_links_neither_decoder_nor_renderer(barrelman: pathlib.Path) -> None:
    program = barrelman.with_name("barrelman-guard").read_bytes()
    assert not [
        name for name in (b"openh264", b"WelsCreateDecoder", b"tiny_skia", b"retina") if name in program
    ]


class TestRefusal:
    """Without its guard the program refuses this vehicle, unless told otherwise, and one guard serves one
    run."""

    @pytest.fixture
    def emulator(self, barrelman: pathlib.Path, tmp_path: pathlib.Path) -> Any:
        with Emulator(barrelman, tmp_path) as emulator:
            yield emulator

    @pytest.fixture
    def command(self, barrelman: pathlib.Path, clip: Clip, emulator: Emulator) -> list[Any]:
        what = ["--video", f"file:{clip.video}", "--select", clip.selection, "--link", emulator.url]
        return [barrelman, "run", "--headless", "--no-record", *what]

    def test_run_without_a_guard_is_refused_with_the_remedy(
        self, emulator: Emulator, command: list[Any], tmp_path: pathlib.Path
    ) -> None:
        refused = run([*command, "--guard", tmp_path / "none"])
        assert refused.returncode == 1
        assert "--without-guard" in refused.stderr
        assert not emulator.heard()

    def test_run_without_a_guard_by_choice_warns(self, command: list[Any]) -> None:
        child = spawn([*command, "--without-guard", "--engage"])
        errors = Lines(child.stderr)
        errors.wait_for("goes on turning")
        errors.wait_for("link up")
        assert not guards_of(child.pid)
        end(child)

    def test_guard_that_says_nothing_is_refused_in_time(
        self, command: list[Any], tmp_path: pathlib.Path
    ) -> None:
        silent = tmp_path / "silent"
        silent.write_text("#!/bin/sh\nexec sleep 60\n")
        silent.chmod(0o755)
        began = time.monotonic()
        refused = run([*command, "--guard", silent])
        delay = Delay.since(began)
        assert refused.returncode == 1
        assert "has said nothing" in refused.stderr
        delay.judge(SILENT_GUARD_LIMIT)

    def test_second_run_is_refused_and_the_next_one_waits_for_the_guard_of_a_killed_run(
        self, command: list[Any]
    ) -> None:
        child = spawn([*command, "--engage"])
        Lines(child.stderr).wait_for("link up")
        second = run(command)
        assert second.returncode == 1
        assert f"process {child.pid}" in second.stderr
        child.kill()
        child.wait()
        third = spawn(command)
        errors = Lines(third.stderr)
        errors.wait_for("waiting for the guard")
        errors.wait_for("link up")
        end(third)
