"""Tests the MAVLink boat against a boat that is written with pymavlink, an independent reading of the protocol.

The boat behaves as ArduPilot was measured to: set-points count in GUIDED and armed only, manual control in MANUAL, both for three
seconds. It judges the sender, the kind of each message, the frame, the mask and the sizes of each command, and that nothing arms it. The script
drives it from the console in headless Chromium.
"""
import os
import signal
import socket
import sys
import threading
import time

os.environ["MAVLINK20"] = "1"

import common
from common import Table
from console_page import Page, Program
from pymavlink.dialects.v20 import common as mavlink
from vessel import SLACK_S, mark, person_at

GUIDED, MANUAL, HOLD = 15, 0, 4
MASK = 0x5C7
FULL_SPEED, FULL_TURN = 3.6, 1.0


class Drive:
    """A way to drive the boat: the profile, who speaks, its mode, and the mode that the remote control's switch chooses to take it."""

    def __init__(self, profile, own, mode, others):
        self.profile, self.own, self.mode, self.others = profile, own, mode, others
        self.name = "GUIDED" if mode == GUIDED else "MANUAL"


DRIVES = [Drive("mavlink-rover", (245, 191), GUIDED, MANUAL), Drive("mavlink-rover-manual", (255, 191), MANUAL, HOLD)]


class Boat:
    """An ArduPilot boat at a UDP port of loopback."""

    def __init__(self, drive, is_ready=True, armed=True):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.01)
        self.out = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.parser = mavlink.MAVLink(None)
        self.drive, self.armed = drive, armed
        self.mode = drive.mode if is_ready else drive.others
        self.client = None
        self.is_silent = False
        self.set_points = []
        self.asked = []
        self.faults = []
        self.heartbeat_at = time.monotonic()
        threading.Thread(target=self._run, daemon=True).start()

    @property
    def url(self):
        return f"udp://127.0.0.1:{self.socket.getsockname()[1]}"

    def switch(self, mode):
        """The switch of the remote control."""
        self.mode, self.heartbeat_at = mode, 0.0

    def _send(self, message):
        packet = message.pack(self.out)
        self.out.seq = (self.out.seq + 1) % 256
        if self.client and not self.is_silent:
            self.socket.sendto(packet, self.client)

    def _run(self):
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
                self._send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed, self.mode, mavlink.MAV_STATE_ACTIVE, 3))

    def _is_newly_switched(self):
        """Whether the program may not know the mode yet: no heartbeat has told it, or the first one half a second ago at most."""
        return self.heartbeat_at == 0.0 or time.monotonic() < self.heartbeat_at - 0.5

    def _require(self, holds, what):
        if not holds:
            self.faults.append(what)

    def _take(self, message):
        name = message.get_type()
        sender = (message.get_srcSystem(), message.get_srcComponent())
        self._require(sender == self.drive.own, f"{name} from {sender}")
        if name == "HEARTBEAT":
            return
        if name == "MANUAL_CONTROL" and self.drive.mode == MANUAL:
            self._require(message.target == 1 and message.x == message.r == message.buttons == 0, f"manual control {message.to_dict()}")
            self._require(abs(message.y) <= 1000 and abs(message.z) <= 1000, f"manual control {message.y}, {message.z}")
            self._require(self.mode == MANUAL or self._is_newly_switched(), f"manual control in mode {self.mode}")
            self.set_points.append((time.monotonic(), message.z / 1000, message.y / 1000))
            return
        if name == "SET_POSITION_TARGET_LOCAL_NED" and self.drive.mode == GUIDED:
            self._require((message.target_system, message.target_component) == (1, 1), f"set-point to {message.target_system}/{message.target_component}")
            self._require(message.coordinate_frame == mavlink.MAV_FRAME_BODY_NED and message.type_mask == MASK, f"frame {message.coordinate_frame}, mask {message.type_mask:#x}")
            self._require(abs(message.vx) <= FULL_SPEED + 1e-6 and abs(message.yaw_rate) <= FULL_TURN + 1e-6 and message.vy == message.vz == 0, f"set-point {message.vx}, {message.yaw_rate}")
            self._require(self.mode == GUIDED or self._is_newly_switched(), f"a set-point in mode {self.mode}")
            self.set_points.append((time.monotonic(), message.vx, message.yaw_rate))
            return
        if name == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_DO_SET_MODE:
            self.asked.append(int(message.param2))
            self.mode, self.heartbeat_at = int(message.param2), 0.0
            self._send(mavlink.MAVLink_command_ack_message(message.command, mavlink.MAV_RESULT_ACCEPTED, 0, 0, *sender))
            return
        if name == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            self._require(int(message.param1) in (33, 74, 1), f"an interval for message {message.param1}")
            self._send(mavlink.MAVLink_command_ack_message(message.command, mavlink.MAV_RESULT_ACCEPTED, 0, 0, *sender))
            return
        self._require(False, f"{name} {getattr(message, 'command', '')} is not expected")

    def since(self, begin):
        return [row for row in list(self.set_points) if row[0] >= begin]

    def last_motion_after(self, begin):
        """Seconds from `begin` to the last set-point that was not neutral, and whether a neutral one followed."""
        rows = self.since(begin)
        moving = [at for at, speed, turn in rows if speed or turn]
        return (moving[-1] - begin if moving else 0.0), bool(rows) and rows[-1][1:] == (0.0, 0.0)


def start(args, folder, boat, name):
    """A run with a marked place, and its page."""
    program = Program(args, "run", "--video", "sim:arena1?size=640x360", "--link", "sim:", "--engage", "--no-record", "--vessel", boat.url, "--vessel-profile", boat.drive.profile)
    page = Page(program.url, folder, name)
    page.ready()
    page.wait(lambda data: data["track"] == "tracking", 15, "the track")
    program.wait(lambda status: status["vessel"]["link"] == "up", 10, "the boat's link")
    mark(page, program, "place", person_at(program), program.status()["video"]["size"])
    page.wait_until_enabled("guide")
    return program, page


def goes(program):
    return program.wait(lambda status: status["vessel"]["mode"] == "guided" and status["vessel"]["throttle"] > 0, 10, "the boat to go")


def modes(table, args, folder, drive):
    boat = Boat(drive, is_ready=False)
    program, page = start(args, folder, boat, f"modes-{drive.name}")
    time.sleep(1.0)
    table.require(f"{drive.name}: a boat in another mode hears no command", not boat.set_points and not boat.asked, f"{len(boat.set_points)} set-points")
    page.click("guide")
    common.wait_until(lambda: boat.asked, 5, f"the question for {drive.name}")
    table.require(f"Go asks a boat in another mode for {drive.name}, once, and does not go", boat.asked == [drive.mode] and not boat.set_points, f"asked for mode {boat.asked}")
    time.sleep(0.5)
    page.click("guide")
    goes(program)
    begin = time.monotonic()
    time.sleep(1.0)
    rows = boat.since(begin)
    table.require(f"{drive.name}: Go again: commands at a steady rate", 8 <= len(rows) <= 26 and rows[-1][1] > 0, f"{len(rows)} in a second, {rows[-1][1]:.2f}, {rows[-1][2]:+.2f}")
    boat.switch(drive.others)
    time.sleep(0.5)
    late = boat.since(time.monotonic())
    program.wait(lambda status: status["vessel"]["mode"] == "stopped", 5, "the boat's stop")
    time.sleep(1.0)
    table.require(f"{drive.name}: the sticks take the boat: nothing more is sent", not boat.since(time.monotonic() - 1.0) and not late, program.status()["vessel"]["text"])
    boat.switch(drive.mode)
    time.sleep(1.5)
    moving = [row for row in boat.since(time.monotonic() - 1.0) if row[1] or row[2]]
    table.require(f"{drive.name} by the sticks again: the boat waits for Go", not moving, f"{len(moving)} set-points that move")
    page.click("guide")
    goes(program)
    boat.is_silent = True
    begin = time.monotonic()
    program.wait(lambda status: status["vessel"]["link"] != "up", 8, "the loss of the silent boat")
    moved = time.monotonic() - begin
    table.require(f"{drive.name}: a boat that falls silent is told", 2 <= moved <= 6, f"after {moved:.1f} s: {program.status()['vessel']['text']}")
    boat.is_silent = False
    page.end()
    code = program.end()
    table.require(f"{drive.name}: Ctrl-C ends it with exit 0", code == 0, f"exit {code}")
    table.require(f"{drive.name}: every message was as it has to be", not boat.faults, "; ".join(boat.faults[:3]))


def killed(table, args, folder, drive):
    boat = Boat(drive)
    program, page = start(args, folder, boat, f"killed-{drive.name}")
    page.click("guide")
    goes(program)
    time.sleep(0.5)
    begin = time.monotonic()
    os.kill(program.child.pid, signal.SIGKILL)
    time.sleep(1.5)
    moved, is_neutral = boat.last_motion_after(begin)
    table.require(f"{drive.name}: SIGKILL of the program: the guard makes the boat neutral", is_neutral and moved <= 0.3 + SLACK_S, f"{1e3 * moved:.0f} ms", f"at most 300 ms, and {1e3 * SLACK_S:.0f} of the machine")
    page.end()
    program.child.wait(timeout=10)
    table.require(f"{drive.name}: every message was as it has to be", not boat.faults, "; ".join(boat.faults[:3]))


def disarmed(table, args, folder, drive):
    boat = Boat(drive, armed=False)
    program, page = start(args, folder, boat, f"disarmed-{drive.name}")
    page.click("guide")
    time.sleep(1.0)

    def is_at_rest():
        return not boat.asked and not any(speed or turn for _, speed, turn in boat.set_points)

    table.require(f"{drive.name}: a boat that is not armed is not commanded, and never armed", is_at_rest(), program.status()["vessel"]["text"])
    boat.is_silent = True
    program.wait(lambda status: status["vessel"]["link"] != "up", 8, "the loss of the silent boat")
    boat.is_silent = False
    program.wait(lambda status: status["vessel"]["link"] == "up", 15, "the boat's link again")
    page.wait_until_enabled("guide")
    page.click("guide")
    time.sleep(1.0)
    boat.armed, boat.heartbeat_at = True, 0.0
    time.sleep(1.5)
    table.require(f"{drive.name}: nor after its link was lost, nor when it is armed later", is_at_rest(), program.status()["vessel"]["text"])
    page.end()
    code = program.end()
    table.require(f"{drive.name}: Ctrl-C ends it with exit 0", code == 0, f"exit {code}")
    table.require(f"{drive.name}: every message was as it has to be", not boat.faults, "; ".join(boat.faults[:3]))


def main():
    args = common.arguments(__doc__)
    folder = common.temporary_folder()
    table = Table("A MAVLink boat, judged by pymavlink")
    for drive in DRIVES:
        modes(table, args, folder, drive)
        killed(table, args, folder, drive)
        disarmed(table, args, folder, drive)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
