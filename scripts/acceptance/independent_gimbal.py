"""A gimbal manager that judges every message, written with pymavlink, an independent reading of the protocol.

It behaves as ArduPilot was measured to: it obeys rates of anybody and keeps a rate for ever, says who has the
control at changes and on request, and reports the attitude only after it was asked to. It judges the CRC and
the signature (pymavlink refuses a wrong one), the sender, the target, the flags, the angles (NaN), the rates,
who has the control, and what may be sent at all.
"""

import contextlib
import hashlib
import math
import os
import random
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

os.environ["MAVLINK20"] = "1"

from pymavlink.dialects.v20 import common as mavlink

Who = tuple[int, int]
OWN = (245, 191)
OTHER = (255, 190)
NOBODY = (0, 0)
CLAIM = 1001
LIMIT = 0.5 + 1e-6
# A packet that was under way when the control was taken.
UNDER_WAY = 0.1
# An exchanged device is still sent rates: three seconds, and the interval of the status that is asked for.
NOTICED_WITHIN = 4.5
MAY_BE_ASKED_FOR = {
    mavlink.MAV_CMD_REQUEST_MESSAGE: (280, 281, 259, 269),
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: (281, 285, 33, 30, 271),
}
# The component of the camera that zooms.
CAMERA = 100
OF_CAMERA = (271, 259, 269)


class GimbalManager:
    """An autopilot with a gimbal at a UDP port of loopback.

    loss: share of the packets that get lost, both ways. held: another commander has the control from the
    start. withholds: no answer to requests for 280. denies: claims are denied. drops: number of claims that
    get lost. passphrase: packets are signed. zooms: whether the camera says that it does.
    """

    def __init__(
        self,
        loss: float = 0.0,
        held: bool = False,
        withholds: bool = False,
        denies: bool = False,
        drops: int = 0,
        passphrase: str | None = None,
        zooms: bool = True,
    ) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.01)
        self.out = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.parser = mavlink.MAVLink(None)
        if passphrase:
            for end in (self.out, self.parser):
                end.signing.secret_key = hashlib.sha256(passphrase.encode()).digest()
                # Units of 10 us since the beginning of 2015.
                end.signing.timestamp = int((time.time() - 1_420_070_400) * 1e5)
            self.out.signing.sign_outgoing = True
        self.loss, self.withholds, self.denies, self.drops = loss, withholds, denies, drops
        self.zooms, self.model = zooms, b"Independent"
        # The first one is moved.
        self.devices = [1]
        # A device that was exchanged for the first one, and when.
        self.left: tuple[int, float] | None = None
        self.random = random.Random(7)
        self.client: Any = None
        self.booted = time.monotonic()
        self.angles = [0.0, -0.4]
        self.rates: tuple[float, float] = (0.0, 0.0)
        self.zoom = 0.0
        self.primary: Who = OTHER if held else NOBODY
        self.taken_at: float | None = self.booted if held else None
        self.attitude_interval: float | None = None
        self.denied_at: float | None = None
        self.is_silent = False
        # Commands get lost, and reports arrive.
        self.is_deaf = False
        self.may_be_turning = False
        self.messages: list[tuple[float, Any]] = []
        self.faults: list[str] = []
        self.is_over = False
        self.lock = threading.Lock()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    @property
    def url(self) -> str:
        return f"udp://127.0.0.1:{self.socket.getsockname()[1]}"

    def _is_lost(self) -> bool:
        return self.random.random() < self.loss

    def _send(self, message: Any) -> None:
        packet = message.pack(self.out)
        self.out.seq = (self.out.seq + 1) % 256
        if self.client and not self.is_silent and not self._is_lost():
            self.socket.sendto(packet, self.client)

    def _send_of_camera(self, message: Any) -> None:
        self.out.srcComponent = CAMERA
        self._send(message)
        self.out.srcComponent = 1

    def _camera_information(self) -> Any:
        flags = mavlink.CAMERA_CAP_FLAGS_HAS_BASIC_ZOOM if self.zooms else 0
        names = [name.ljust(32, b"\0") for name in (b"Acme", self.model)]
        return mavlink.MAVLink_camera_information_message(
            self._ms(), *names, 0, math.nan, math.nan, math.nan, 0, 0, 0, flags, 0, b""
        )

    def _stream_information(self) -> Any:
        return mavlink.MAVLink_video_stream_information_message(
            1, 1, 0, 1, 25.0, 1280, 720, 0, 0, 60, b"main", b"rtsp://user:secret@192.0.2.7/main"
        )

    def _ms(self) -> int:
        return int((time.monotonic() - self.booted) * 1e3)

    def _run(self) -> None:
        heartbeat_at = attitude_at = last = time.monotonic()
        while not self.is_over:
            try:
                datagram, sender = self.socket.recvfrom(2048)
                with self.lock:
                    if not self.is_deaf and not self._is_lost():
                        self._take(datagram, sender)
            except (TimeoutError, ConnectionError):
                pass
            now = time.monotonic()
            with self.lock:
                self.angles = [
                    angle + rate * (now - last) for angle, rate in zip(self.angles, self.rates, strict=True)
                ]
                last = now
                if now >= heartbeat_at:
                    heartbeat_at = now + 1.0
                    self._send(mavlink.MAVLink_heartbeat_message(2, 3, 1, 0, 4, 3))
                    self._send_of_camera(
                        mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_CAMERA, 8, 0, 0, 4, 3)
                    )
                if self.attitude_interval and now >= attitude_at:
                    attitude_at = now + self.attitude_interval
                    self._send(self._attitude())

    def _attitude(self) -> Any:
        yaw, pitch = (angle / 2 for angle in self.angles)
        q = [
            math.cos(yaw) * math.cos(pitch),
            -math.sin(yaw) * math.sin(pitch),
            math.cos(yaw) * math.sin(pitch),
            math.sin(yaw) * math.cos(pitch),
        ]
        return mavlink.MAVLink_gimbal_device_attitude_status_message(
            0, 0, self._ms(), 44, q, math.nan, math.nan, math.nan, 0, math.nan, math.nan, 0
        )

    def _status(self) -> None:
        for device in self.devices:
            self._send(
                mavlink.MAVLink_gimbal_manager_status_message(self._ms(), 12, device, *self.primary, 0, 0)
            )

    def _fault(self, text: str) -> None:
        if len(self.faults) < 20:
            self.faults.append(text)

    def _take(self, datagram: bytes, sender: Any) -> None:
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

    def _judge(self, message: Any) -> None:
        now = time.monotonic()
        if (message.get_srcSystem(), message.get_srcComponent()) != OWN:
            self._fault(f"from {message.get_srcSystem()}/{message.get_srcComponent()}")
        kind = message.get_type()
        self.messages.append((now, message))
        if kind == "HEARTBEAT":
            if message.type != mavlink.MAV_TYPE_ONBOARD_CONTROLLER:
                self._fault(f"a heartbeat of type {message.type}")
            return
        # Each component that is heard is asked what it is.
        is_question = kind == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_REQUEST_MESSAGE
        is_of_camera = kind == "COMMAND_LONG" and (
            message.command == mavlink.MAV_CMD_SET_CAMERA_ZOOM or int(message.param1) in OF_CAMERA
        )
        components = (0, 1, CAMERA) if is_question else (CAMERA,) if is_of_camera else (0, 1)
        if message.target_system not in (0, 1) or message.target_component not in components:
            self._fault(f"{kind} to {message.target_system}/{message.target_component}")
        if kind == "GIMBAL_MANAGER_SET_PITCHYAW":
            self._judge_rates(message, now)
        elif kind == "COMMAND_LONG":
            self._command(message)
        else:
            self._fault(f"{kind} must not leave")

    def _judge_rates(self, message: Any, now: float) -> None:
        rates = (message.yaw_rate, message.pitch_rate)
        if message.flags != 12:
            self._fault(f"flags {message.flags}")
        if not (math.isnan(message.pitch) and math.isnan(message.yaw)):
            self._fault("an angle")
        if not all(math.isfinite(rate) and abs(rate) <= LIMIT for rate in rates):
            self._fault(f"rates {rates}")
        to = (message.target_system, message.target_component, message.gimbal_device_id)
        if self.left and to == (1, 1, self.left[0]) and now < self.left[1] + NOTICED_WITHIN:
            return
        if any(rates) and to != (1, 1, self.devices[0]):
            self._fault("motion that is not for the gimbal alone")
        is_under_way = self.taken_at is not None and now <= self.taken_at + UNDER_WAY
        if self.primary != OWN and not is_under_way and (any(rates) or not self.may_be_turning):
            self._fault(f"rates {rates} while {self.primary} has the control")
        if self.primary == OWN:
            self.may_be_turning = False
        self.rates = rates

    def _command(self, message: Any) -> None:
        number = message.command
        asked = int(message.param1)
        result = mavlink.MAV_RESULT_ACCEPTED
        if number in MAY_BE_ASKED_FOR and asked not in MAY_BE_ASKED_FOR[number]:
            self._fault(f"command {number} for message {asked}")
        is_of_camera = message.target_component == CAMERA
        if number == mavlink.MAV_CMD_REQUEST_MESSAGE and is_of_camera != (asked in OF_CAMERA):
            result = mavlink.MAV_RESULT_UNSUPPORTED
        elif number == mavlink.MAV_CMD_REQUEST_MESSAGE and asked == 280:
            if self.withholds:
                return
            for device in self.devices:
                self._send(
                    mavlink.MAVLink_gimbal_manager_information_message(
                        self._ms(), 32 + 256, device, 0, 0, -math.pi / 2, 0.35, -math.pi, math.pi
                    )
                )
        elif number == mavlink.MAV_CMD_REQUEST_MESSAGE and asked == 259:
            self._send_of_camera(self._camera_information())
        elif number == mavlink.MAV_CMD_REQUEST_MESSAGE and asked == 269:
            self._send_of_camera(self._stream_information())
        elif number == mavlink.MAV_CMD_REQUEST_MESSAGE:
            self._status()
        elif number == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL and asked == 285:
            self.attitude_interval = message.param2 / 1e6
        elif number == mavlink.MAV_CMD_SET_CAMERA_ZOOM:
            self._judge_zoom(message)
        elif number == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            result = mavlink.MAV_RESULT_FAILED
        elif number == mavlink.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE:
            if self.drops:
                self.drops -= 1
                return
            result = self._configure(
                (int(message.param1), int(message.param2)), (message.param3, message.param4), message.param7
            )
        else:
            self._fault(f"command {number} must not leave")
        self._send(mavlink.MAVLink_command_ack_message(number, result, 0, 0, *OWN))

    def _judge_zoom(self, message: Any) -> None:
        """A camera keeps the speed until the next one."""
        speed = message.param2
        if message.param1 != mavlink.ZOOM_TYPE_CONTINUOUS or not abs(speed) <= 1:
            self._fault(f"zoom {message.param1}, {speed}")
        if speed and not self.zooms:
            self._fault(f"zoom {speed} of a camera without zoom")
        if speed and self.primary != OWN:
            self._fault(f"zoom {speed} while {self.primary} has the control")
        self.zoom = speed

    def _configure(self, claim: Who, secondary: tuple[float, float], device: float) -> Any:
        if secondary != (-1, -1) or device not in (0, self.devices[0]):
            self._fault(f"secondary control {secondary}, device {device}")
        before = self.primary
        if claim == OWN:
            if self.primary == OTHER and not self.may_be_claimed:
                self._fault("the control of another commander is claimed unasked")
            if self.denies:
                self.denied_at = self.denied_at or time.monotonic()
                return mavlink.MAV_RESULT_DENIED
            self.primary, self.taken_at = OWN, None
        elif claim == (-3, -3):
            if self.primary == OWN:
                self.primary = NOBODY
            elif self.primary == OTHER:
                self._fault("the control of another commander is released")
        else:
            self._fault(f"a claim for {claim}")
        if self.primary != before:
            self._status()
        return mavlink.MAV_RESULT_ACCEPTED

    # Whether the operator has asked for the control of another client's gimbal.
    may_be_claimed = False

    def take(self) -> float:
        """Another commander takes the control in mid-motion."""
        with self.lock:
            self.primary, self.taken_at = OTHER, time.monotonic()
            self._status()
            return self.taken_at or 0.0

    def exchange(self, device: int) -> None:
        """Another device takes the place of the one that is moved."""
        with self.lock:
            self.left = (self.devices[0], time.monotonic())
            self.devices, self.rates, self.primary = [device], (0.0, 0.0), NOBODY
            self.may_be_turning = True
            self._status()

    def give_back(self) -> None:
        """The other commander gives the control back."""
        with self.lock:
            self.primary = NOBODY
            self._status()

    def rates_since(self, at: float) -> list[tuple[float, tuple[float, float]]]:
        kind = "GIMBAL_MANAGER_SET_PITCHYAW"
        with self.lock:
            return [
                (when, (message.yaw_rate, message.pitch_rate))
                for when, message in self.messages
                if when >= at and message.get_type() == kind
            ]

    def commands(self, number: int) -> list[tuple[float, Any]]:
        """The commands of this number, with their times."""
        with self.lock:
            return [
                (when, message)
                for when, message in self.messages
                if message.get_type() == "COMMAND_LONG" and message.command == number
            ]

    def is_turning(self) -> bool:
        return any(self.rates)

    def close(self) -> None:
        self.is_over = True
        self.thread.join()
        self.socket.close()


@contextlib.contextmanager
def judging(**options: Any) -> Iterator[GimbalManager]:
    """A gimbal whose every message must have kept the rules at the end."""
    manager = GimbalManager(**options)
    yield manager
    faults = sorted(set(manager.faults))
    manager.close()
    assert not faults, "; ".join(faults)
