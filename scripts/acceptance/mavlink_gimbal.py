"""Tests `barrelman run --profile mavlink-gimbal` against a gimbal manager that is written with pymavlink, and against the
emulator.

The gimbal manager here is an independent reading of the protocol. It behaves as ArduPilot was measured to: it obeys rates of
anybody and keeps a rate for ever. It judges every message: the CRC (pymavlink refuses a wrong one), the sender, the target, the
flags, the angles (NaN), the rates, and what may be sent at all. Each case runs the practice clip with the camera engaged and
causes one event.
"""
import concurrent.futures
import math
import os
import signal
import socket
import subprocess
import sys
import threading
import time

os.environ["MAVLINK20"] = "1"

import common  # noqa: E402
from common import Lines, Table  # noqa: E402
from pymavlink.dialects.v20 import common as mavlink  # noqa: E402

OWN = (245, 191)
OTHER = (255, 190)
LIMIT = 0.5 + 1e-6
MOVES_WITHIN = 12.0
REST_LIMIT = 0.35
RENEWED_WITHIN = 0.2
# A packet that was under way when the control was taken.
UNDER_WAY = 0.1
MAY_BE_ASKED_FOR = {mavlink.MAV_CMD_REQUEST_MESSAGE: (280, 281), mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: (281, 285)}


class GimbalManager:
    """An autopilot with a gimbal at a UDP port of loopback."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.01)
        self.out = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.parser = mavlink.MAVLink(None)
        self.client = None
        self.booted = time.monotonic()
        self.angles = [0.0, -0.4]
        self.rates = (0.0, 0.0)
        self.primary = (0, 0)
        self.taken_at = None
        self.attitude_interval = None
        self.is_silent = False
        self.messages = []
        self.faults = []
        self.is_over = False
        self.lock = threading.Lock()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    @property
    def url(self):
        return f"udp://127.0.0.1:{self.socket.getsockname()[1]}"

    def _send(self, message):
        if self.client and not self.is_silent:
            self.socket.sendto(message.pack(self.out), self.client)
            self.out.seq = (self.out.seq + 1) % 256

    def _ms(self):
        return int((time.monotonic() - self.booted) * 1e3)

    def _run(self):
        heartbeat_at = attitude_at = last = time.monotonic()
        while not self.is_over:
            try:
                datagram, sender = self.socket.recvfrom(2048)
                with self.lock:
                    self._take(datagram, sender)
            except TimeoutError:
                pass
            now = time.monotonic()
            with self.lock:
                self.angles = [angle + rate * (now - last) for angle, rate in zip(self.angles, self.rates)]
                last = now
                if now >= heartbeat_at:
                    heartbeat_at = now + 1.0
                    self._send(mavlink.MAVLink_heartbeat_message(2, 3, 1, 0, 4, 3))
                if self.attitude_interval and now >= attitude_at:
                    attitude_at = now + self.attitude_interval
                    self._send(self._attitude())

    def _attitude(self):
        yaw, pitch = (angle / 2 for angle in self.angles)
        q = [math.cos(yaw) * math.cos(pitch), -math.sin(yaw) * math.sin(pitch), math.cos(yaw) * math.sin(pitch), math.sin(yaw) * math.cos(pitch)]
        return mavlink.MAVLink_gimbal_device_attitude_status_message(0, 0, self._ms(), 44, q, math.nan, math.nan, math.nan, 0, math.nan, math.nan, 0)

    def _status(self):
        self._send(mavlink.MAVLink_gimbal_manager_status_message(self._ms(), 12, 1, *self.primary, 0, 0))

    def _fault(self, text):
        if len(self.faults) < 20:
            self.faults.append(text)

    def _take(self, datagram, sender):
        self.client = sender
        try:
            messages = self.parser.parse_buffer(datagram) or []
        except mavlink.MAVError as error:
            self._fault(f"a datagram that pymavlink refuses: {error}")
            return
        if len(messages) != 1:
            self._fault(f"{len(messages)} messages in a datagram")
        for message in messages:
            self._judge(message)

    def _judge(self, message):
        now = time.monotonic()
        if (message.get_srcSystem(), message.get_srcComponent()) != OWN:
            self._fault(f"from {message.get_srcSystem()}/{message.get_srcComponent()}")
        kind = message.get_type()
        if not self.messages and kind != "GIMBAL_MANAGER_SET_PITCHYAW":
            self._fault(f"the first message is {kind} instead of zeros")
        self.messages.append((now, message))
        if kind == "HEARTBEAT":
            if message.type != mavlink.MAV_TYPE_ONBOARD_CONTROLLER:
                self._fault(f"a heartbeat of type {message.type}")
            return
        if self.taken_at and self.primary == OTHER and now > self.taken_at + UNDER_WAY:
            self._fault(f"{kind} though another commander has the control")
        if message.target_system not in (0, 1) or message.target_component not in (0, 1):
            self._fault(f"{kind} to {message.target_system}/{message.target_component}")
        if kind == "GIMBAL_MANAGER_SET_PITCHYAW":
            self._judge_rates(message)
        elif kind == "COMMAND_LONG":
            self._command(message)
        else:
            self._fault(f"{kind} must not leave")

    def _judge_rates(self, message):
        rates = (message.yaw_rate, message.pitch_rate)
        if message.flags != 12:
            self._fault(f"flags {message.flags}")
        if not (math.isnan(message.pitch) and math.isnan(message.yaw)):
            self._fault("an angle")
        if not all(math.isfinite(rate) and abs(rate) <= LIMIT for rate in rates):
            self._fault(f"rates {rates}")
        if any(rates) and (message.target_system, message.target_component, message.gimbal_device_id) != (1, 1, 1):
            self._fault("motion that is not for the gimbal alone")
        if any(rates) and self.primary != OWN:
            self._fault("motion without the control") if not self.taken_at or time.monotonic() > self.taken_at + UNDER_WAY else None
        self.rates = rates

    def _command(self, message):
        number = message.command
        asked = int(message.param1)
        result = mavlink.MAV_RESULT_ACCEPTED
        if number in MAY_BE_ASKED_FOR and asked not in MAY_BE_ASKED_FOR[number]:
            self._fault(f"command {number} for message {asked}")
        if number == mavlink.MAV_CMD_REQUEST_MESSAGE and asked == 280:
            self._send(mavlink.MAVLink_gimbal_manager_information_message(self._ms(), 32 + 256, 1, 0, 0, -math.pi / 2, 0.35, -math.pi, math.pi))
        elif number == mavlink.MAV_CMD_REQUEST_MESSAGE:
            self._status()
        elif number == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL and asked == 285:
            self.attitude_interval = message.param2 / 1e6
        elif number == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            result = mavlink.MAV_RESULT_FAILED
        elif number == mavlink.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE:
            claim = (int(message.param1), int(message.param2))
            if claim == OWN:
                self.primary = OWN
            elif claim == (-3, -3) and self.primary == OWN:
                self.primary = (0, 0)
            elif claim != (-3, -3):
                self._fault(f"a claim for {claim}")
            self._status()
        else:
            self._fault(f"command {number} must not leave")
        self._send(mavlink.MAVLink_command_ack_message(number, result, 0, 0, *OWN))

    def take(self):
        """Another commander takes the control in mid-motion, and rests the gimbal."""
        with self.lock:
            self.primary, self.taken_at = OTHER, time.monotonic()
            self._status()
            return self.taken_at

    def rates_since(self, at):
        with self.lock:
            return [(when, (message.yaw_rate, message.pitch_rate)) for when, message in self.messages if when >= at and message.get_type() == "GIMBAL_MANAGER_SET_PITCHYAW"]

    def wait_until_it_moves(self):
        common.wait_until(lambda: any(self.rates), MOVES_WITHIN, "the first rate")
        time.sleep(0.3)

    def close(self):
        self.is_over = True
        self.thread.join()
        self.socket.close()


class Run:
    """A run against a gimbal manager of its own."""

    def __init__(self, args, clip, selection):
        self.manager = GimbalManager()
        command = [args.barrelman, "run", "--headless", "--engage", "--tracker", "camshift", "--no-record", "--video", f"file:{clip}"]
        command += ["--select", selection, "--profile", "mavlink-gimbal", "--link", self.manager.url]
        self.child = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.out, self.err = Lines(self.child.stdout), Lines(self.child.stderr)

    def close(self):
        if self.child.poll() is None:
            self.child.kill()
            self.child.wait()
        self.manager.close()


def rest_after(run, at):
    """Seconds until zeros were in force for good."""
    common.wait_until(lambda: not any(run.manager.rates), 5, "rest")
    return next((when - at for when, rates in run.manager.rates_since(at) if not any(rates)), math.inf)


def follow(run, rows):
    run.manager.wait_until_it_moves()
    began = time.monotonic()
    rests = lambda sent: len(sent) >= 6 and not any(any(rates) for _, rates in sent[-6:])
    common.wait_until(lambda: rests(run.manager.rates_since(began)), 15, "the boat inside of the region")
    sent = run.manager.rates_since(began)
    gaps = [later[0] - earlier[0] for earlier, later in zip(sent, sent[1:]) if any(earlier[1])]
    rows.require("follow: rates are renewed steadily while moving", gaps and max(gaps) <= RENEWED_WITHIN, f"at most {max(gaps, default=0) * 1e3:.0f} ms apart", f"{RENEWED_WITHIN * 1e3:.0f} ms")
    zeros = [later[0] - earlier[0] for earlier, later in zip(sent, sent[1:]) if not any(earlier[1]) and not any(later[1])]
    rows.require("follow: zeros are explicit and refreshed at rest", zeros and max(zeros) <= 0.35, f"{len(zeros)} of them, at most {max(zeros, default=0) * 1e3:.0f} ms apart")


def stop(run, rows):
    run.manager.wait_until_it_moves()
    at = time.monotonic()
    run.child.send_signal(signal.SIGTERM)
    rest = rest_after(run, at)
    run.child.wait(timeout=8)
    rows.require("SIGTERM: zeros", rest <= REST_LIMIT, f"after {rest * 1e3:.0f} ms", f"{REST_LIMIT * 1e3:.0f} ms")
    rows.require("SIGTERM: the control is released at the end", run.manager.primary == (0, 0), f"primary control {run.manager.primary}")
    zeros = [rates for _, rates in run.manager.rates_since(at)]
    rows.require("SIGTERM: zeros are repeated", len([rates for rates in zeros if not any(rates)]) >= 12, f"{len(zeros)} messages")


def stolen(run, rows):
    run.manager.wait_until_it_moves()
    at = run.manager.take()
    time.sleep(3.0)
    late = [when - at for when, _ in run.manager.rates_since(at)]
    rows.require("control stolen in mid-motion: nothing more is sent", not late or max(late) <= UNDER_WAY, f"{len(late)} rates, the last after {max(late, default=0) * 1e3:.0f} ms")
    rows.require("control stolen: it is not taken back", run.manager.primary == OTHER)
    run.out.wait_for("control away", 6)
    run.child.send_signal(signal.SIGTERM)
    run.child.wait(timeout=8)
    rows.require("control stolen: nothing is released at the end", run.manager.primary == OTHER)


def silent(run, rows):
    run.manager.wait_until_it_moves()
    run.manager.is_silent = True
    at = time.monotonic()
    run.err.wait_for("does not answer", 6)
    told = time.monotonic() - at
    rest = rest_after(run, at)
    rows.require("gimbal silent: told, and zeros", told <= 4.5 and rest < 5, f"told after {told:.1f} s, zeros after {rest:.1f} s", "3 s of silence")
    run.manager.is_silent = False
    common.wait_until(lambda: run.manager.primary == OWN and len(run.manager.rates_since(time.monotonic() - 0.5)) > 0, 8, "the link's return")
    rows.require("gimbal heard again: zeros until the next Engage", not any(run.manager.rates))


def killed(run, rows):
    run.manager.wait_until_it_moves()
    at = time.monotonic()
    run.child.kill()
    rest = rest_after(run, at)
    rows.require("SIGKILL: zeros from the guard", rest <= REST_LIMIT, f"after {rest * 1e3:.0f} ms", f"{REST_LIMIT * 1e3:.0f} ms")
    common.wait_until(lambda: run.manager.primary == (0, 0), 6, "the release")
    rows.require("SIGKILL: the guard releases the control", True)


def check_says(args, table):
    """What `barrelman check` says of a gimbal, of nobody, and of one that somebody else has."""
    manager = GimbalManager()
    check = [args.barrelman, "check", "--profile", "mavlink-gimbal", "--link"]
    found = common.run([*check, manager.url])
    table.require("check: the gimbal's axes and end stops", "pitch from -90 to 20 degrees" in found.stdout and "nobody has the control" in found.stdout, "", found.stdout[-200:] if found.returncode else "")
    manager.primary = OTHER
    held = common.run([*check, manager.url])
    table.require("check: another's control", "255/190 has the control" in held.stdout)
    moved = [message for _, message in manager.messages if message.get_type() == "GIMBAL_MANAGER_SET_PITCHYAW"]
    claims = [message for _, message in manager.messages if message.get_type() == "COMMAND_LONG" and message.command == 1001]
    table.require("check: moves and claims nothing", not moved and not claims)
    manager.is_silent = True
    none = common.run([*check, manager.url])
    table.require("check: no heartbeat", none.returncode == 1 and "no heartbeat" in none.stdout)
    manager.close()


def main():
    args = common.arguments(__doc__, clip=common.CLIP, at_once={"type": int, "default": 2})
    folder = common.temporary_folder()
    clip, truth = common.practice_clip(args, folder)
    selection = common.selection(truth)
    table = Table("A MAVLink gimbal, judged by pymavlink")

    def attempt(case):
        def safely(rows):
            run = Run(args, clip, selection)
            try:
                case(run, rows)
                rows.require(f"{case.__name__}: every message is right", not run.manager.faults, f"{len(run.manager.messages)} messages", "; ".join(sorted(set(run.manager.faults)))[:200])
            except Exception as error:  # One case that goes astray must not hide the others.
                rows.require(case.__name__, False, type(error).__name__, f"{error} {run.err.text()[-300:]}")
            finally:
                run.close()

        return table.try_again_through_standstills(safely)

    with concurrent.futures.ThreadPoolExecutor(args.at_once) as pool:
        list(pool.map(attempt, [follow, stop, stolen, silent, killed]))
    check_says(args, table)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
