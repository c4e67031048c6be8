"""The MAVLink boat against a boat that is written with pymavlink, an independent reading of the protocol.

The boat behaves as ArduPilot was measured to: set-points count in GUIDED and armed only, manual control in
MANUAL, both for three seconds. It judges the sender, the kind of each message, the frame, the mask and the
sizes of each command, and that nothing arms it. The console in headless Chromium drives it.
"""

import dataclasses
import os
import pathlib
import signal
import threading
import time
from typing import Any

os.environ["MAVLINK20"] = "1"

import pytest
from pymavlink.dialects.v20 import common as mavlink

from boat import NEUTRAL_WITHIN, Receiver, goes, going, is_linked
from client import Program
from conftest import Check
from machine import Delay, took, wait_until
from page import Page

GUIDED, MANUAL, HOLD = 15, 0, 4
MASK = 0x5C7
FULL_SPEED, FULL_TURN = 3.6, 1.0


@dataclasses.dataclass(frozen=True)
class Drive:
    """A way to drive the boat: the profile, who speaks, its mode, and the mode that the remote control's
    switch chooses to take it."""

    profile: str
    own: tuple[int, int]
    mode: int
    others: int


DRIVES = {
    "GUIDED": Drive("mavlink-rover", (245, 191), GUIDED, MANUAL),
    "MANUAL": Drive("mavlink-rover-manual", (255, 191), MANUAL, HOLD),
}


class Boat(Receiver):
    """An ArduPilot boat at a UDP port of loopback."""

    def __init__(self, drive: Drive, is_ready: bool = True, armed: bool = True) -> None:
        super().__init__()
        self.socket.settimeout(0.01)
        self.out = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.parser = mavlink.MAVLink(None)
        self.drive, self.armed = drive, armed
        self.mode = drive.mode if is_ready else drive.others
        self.client: Any = None
        self.is_silent = False
        self.asked: list[int] = []
        self.faults: list[str] = []
        self.heartbeat_at = time.monotonic()
        threading.Thread(target=self._run, daemon=True).start()

    def switch(self, mode: int) -> None:
        """The switch of the remote control."""
        self.mode, self.heartbeat_at = mode, 0.0

    def _send(self, message: Any) -> None:
        packet = message.pack(self.out)
        self.out.seq = (self.out.seq + 1) % 256
        if self.client and not self.is_silent:
            self.socket.sendto(packet, self.client)

    def _run(self) -> None:
        while True:
            try:
                datagram, self.client = self.socket.recvfrom(2048)
                for message in self.parser.parse_buffer(datagram) or []:
                    self._take(message)
            except (TimeoutError, ConnectionError):
                pass
            now = time.monotonic()
            if now >= self.heartbeat_at:
                self.heartbeat_at = now + 1.0
                armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
                kind = mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
                flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed
                self._send(
                    mavlink.MAVLink_heartbeat_message(*kind, flags, self.mode, mavlink.MAV_STATE_ACTIVE, 3)
                )

    def _is_newly_switched(self) -> bool:
        """Whether the program may not know the mode yet: no heartbeat has told it, or the first one half a
        second ago at most."""
        return self.heartbeat_at == 0.0 or time.monotonic() < self.heartbeat_at - 0.5

    def _require(self, holds: object, what: str) -> None:
        if not holds:
            self.faults.append(what)

    def _take(self, message: Any) -> None:
        name = message.get_type()
        sender = (message.get_srcSystem(), message.get_srcComponent())
        self._require(sender == self.drive.own, f"{name} from {sender}")
        if name == "HEARTBEAT":
            return
        if name == "MANUAL_CONTROL" and self.drive.mode == MANUAL:
            self._require(
                message.target == 1 and message.x == message.r == message.buttons == 0,
                f"manual control {message.to_dict()}",
            )
            self._require(
                abs(message.y) <= 1000 and abs(message.z) <= 1000, f"manual control {message.y}, {message.z}"
            )
            self._require(
                self.mode == MANUAL or self._is_newly_switched(), f"manual control in mode {self.mode}"
            )
            self.heard.append((time.monotonic(), message.z / 1000, message.y / 1000))
            return
        if name == "SET_POSITION_TARGET_LOCAL_NED" and self.drive.mode == GUIDED:
            form = (
                message.target_system,
                message.target_component,
                message.coordinate_frame,
                message.type_mask,
            )
            self._require(
                form == (1, 1, mavlink.MAV_FRAME_BODY_NED, MASK),
                f"a set-point with target, frame and mask {form}",
            )
            is_small = abs(message.vx) <= FULL_SPEED + 1e-6 and abs(message.yaw_rate) <= FULL_TURN + 1e-6
            self._require(
                is_small and message.vy == message.vz == 0, f"set-point {message.vx}, {message.yaw_rate}"
            )
            self._require(
                self.mode == GUIDED or self._is_newly_switched(), f"a set-point in mode {self.mode}"
            )
            self.heard.append((time.monotonic(), message.vx, message.yaw_rate))
            return
        if name == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_DO_SET_MODE:
            self.asked.append(int(message.param2))
            self.mode, self.heartbeat_at = int(message.param2), 0.0
            self._send(
                mavlink.MAVLink_command_ack_message(
                    message.command, mavlink.MAV_RESULT_ACCEPTED, 0, 0, *sender
                )
            )
            return
        if name == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            self._require(int(message.param1) in (33, 74, 1), f"an interval for message {message.param1}")
            self._send(
                mavlink.MAVLink_command_ack_message(
                    message.command, mavlink.MAV_RESULT_ACCEPTED, 0, 0, *sender
                )
            )
            return
        self._require(False, f"{name} {getattr(message, 'command', '')} is not expected")


@pytest.fixture(params=DRIVES)
def drive(request: pytest.FixtureRequest) -> Drive:
    return DRIVES[request.param]


@dataclasses.dataclass
class Bench:
    """Makes runs of the program with a boat, a marked place, and a page."""

    barrelman: pathlib.Path
    folder: pathlib.Path

    def start(self, boat: Boat) -> tuple[Program, Page]:
        options = ["--video", "sim:arena1?size=640x360", "--link", "sim:", "--engage", "--no-record"]
        return going(
            self.barrelman,
            self.folder,
            *options,
            "--vessel",
            boat.url,
            "--vessel-profile",
            boat.drive.profile,
            answers=True,
        )


@pytest.fixture
def bench(barrelman: pathlib.Path, tmp_path: pathlib.Path) -> Bench:
    return Bench(barrelman, tmp_path)


def ended(program: Program, page: Page, boat: Boat, check: Check) -> None:
    page.end()
    code = program.end()
    check("Ctrl-C ends it with exit 0", code == 0, code)
    check("every message was as it has to be", not boat.faults, boat.faults[:3])


pytestmark = [pytest.mark.realtime, pytest.mark.clocked]


def test_boat_is_asked_for_its_mode_left_to_its_sticks_and_missed_when_silent(
    bench: Bench, drive: Drive, check: Check
) -> None:
    boat = Boat(drive, is_ready=False)
    program, page = bench.start(boat)
    time.sleep(1.0)
    check("a boat in another mode hears no command", not boat.heard and not boat.asked, boat.asked)
    page.click_enabled("guide")
    wait_until(
        lambda: boat.asked,
        lambda: f"the question for the mode ({page.text('toast')}; {program.status()['vessel']['text']})",
        20.0,
    )
    check(
        "Go asks a boat in another mode for it, once, and does not go",
        boat.asked == [drive.mode] and not boat.heard,
        boat.asked,
    )
    time.sleep(0.5)
    page.click_enabled("guide")
    goes(program)
    begin = time.monotonic()
    time.sleep(1.0)
    rows, until = boat.since(begin), time.monotonic()
    is_steady = 8 * took(begin, until) <= len(rows) <= 26 * (until - begin) and rows[-1][1] > 0
    check("Go again: commands at a steady rate", is_steady, f"{len(rows)} in a second")
    boat.switch(drive.others)
    time.sleep(0.5)
    program.wait(lambda status: status["vessel"]["mode"] == "stopped", "the boat's stop")
    begin = time.monotonic()
    time.sleep(1.0)
    check(
        "the sticks take the boat: nothing more is sent",
        not boat.since(begin),
        program.status()["vessel"]["text"],
    )
    boat.switch(drive.mode)
    time.sleep(1.5)
    moving = [row for row in boat.since(time.monotonic() - 1.0) if row[1] or row[2]]
    check("the mode by the sticks again: the boat waits for Go", not moving, moving)
    page.click_enabled("guide")
    goes(program)
    boat.is_silent = True
    begin = time.monotonic()
    program.wait(lambda status: status["vessel"]["link"] != "up", "the loss of the silent boat")
    delay = Delay.since(begin, 3)
    check("a boat that falls silent is given some time", delay.seconds >= 2, delay)
    check.in_time("a boat that falls silent is told", delay, 6)
    boat.is_silent = False
    ended(program, page, boat, check)


def test_guard_of_a_killed_program_makes_the_boat_neutral(bench: Bench, drive: Drive, check: Check) -> None:
    boat = Boat(drive)
    program, page = bench.start(boat)
    page.click_enabled("guide")
    goes(program)
    time.sleep(0.5)
    begin = time.monotonic()
    os.kill(program.child.pid, signal.SIGKILL)
    time.sleep(1.5)
    moved, is_neutral = boat.last_motion_after(begin)
    check("the boat is neutral", is_neutral)
    check.in_time("the boat is neutral in time", moved, NEUTRAL_WITHIN)
    page.end()
    check("every message was as it has to be", not boat.faults, boat.faults[:3])


def test_boat_that_is_not_armed_is_not_commanded_and_never_armed(
    bench: Bench, drive: Drive, check: Check
) -> None:
    boat = Boat(drive, armed=False)
    program, page = bench.start(boat)
    page.click_enabled("guide")
    time.sleep(1.0)

    def is_at_rest() -> bool:
        return not boat.asked and not any(speed or turn for _, speed, turn in boat.heard)

    check("it is not commanded", is_at_rest(), program.status()["vessel"]["text"])
    boat.is_silent = True
    program.wait(lambda status: status["vessel"]["link"] != "up", "the loss of the silent boat")
    boat.is_silent = False
    program.wait(is_linked, "the boat's link again")
    page.click_enabled("guide")
    time.sleep(1.0)
    boat.armed, boat.heartbeat_at = True, 0.0
    time.sleep(1.5)
    check(
        "nor after its link was lost, nor when it is armed later",
        is_at_rest(),
        program.status()["vessel"]["text"],
    )
    ended(program, page, boat, check)
