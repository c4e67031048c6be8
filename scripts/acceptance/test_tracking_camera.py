"""Barrelman as a tracking camera with ground stations of others' writing: pymavlink with QGroundControl's
habits, MAVSDK.

The video is a simulated world's. The selection's truth is the box that the console's status shows.
"""

import itertools
import json
import math
import os
import pathlib
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from client import DESELECT, DISENGAGE, ENGAGE, STOP, WORLD, EngagedRun
from conftest import Check
from machine import NEVER, Delay, poll, took, wait_until
from process import Lines, end, free_port, run, spawn

os.environ["MAVLINK20"] = "1"
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.camera.camera import Camera, CameraError
from mavsdk.plugins.gimbal.gimbal import Gimbal
from mavsdk.plugins.mavlink_direct.mavlink_direct import MavlinkDirect, MavlinkMessage
from pymavlink import mavutil

mav = mavutil.mavlink
CAMERA = (1, 100)
# QGroundControl waits so long for CAMERA_INFORMATION after the acknowledgement.
INFORMATION_WITHIN = 1.0
# MAVSDK sends a command again after this time.
REPEATED_AFTER = 0.5
IDLE, ACTIVE = 0, 1
ACCEPTED, DENIED, UNSUPPORTED = 0, 2, 3

Box = tuple[float, float, float, float]


class GroundStation:
    """A ground station and an autopilot behind one UDP socket, as a router has them."""

    def __init__(self) -> None:
        self.port = free_port()
        self.url = f"udp://127.0.0.1:{self.port}"
        self.link = mavutil.mavlink_connection(
            f"udpin:127.0.0.1:{self.port}", source_system=255, source_component=190
        )
        self.heard: list[tuple[float, Any]] = []
        self.lock = threading.Lock()
        self.is_ended = False
        self.thread = threading.Thread(target=self._listen, daemon=True)
        self.thread.start()

    def _listen(self) -> None:
        beat_at = 0.0
        while not self.is_ended:
            message = self.link.recv_match(blocking=True, timeout=0.05)
            if message is not None:
                with self.lock:
                    self.heard.append((time.monotonic(), message))
            if self.link.clients_last_alive and time.monotonic() >= beat_at:
                beat_at = time.monotonic() + 1.0
                self._send_from(
                    255,
                    190,
                    lambda: self.link.mav.heartbeat_send(
                        mav.MAV_TYPE_GCS, mav.MAV_AUTOPILOT_INVALID, 0, 0, 4
                    ),
                )
                self._send_from(
                    1,
                    1,
                    lambda: self.link.mav.heartbeat_send(
                        mav.MAV_TYPE_QUADROTOR, mav.MAV_AUTOPILOT_ARDUPILOTMEGA, 0, 0, 4
                    ),
                )

    def _send_from(self, system: int, component: int, send: Callable[[], None]) -> None:
        with self.lock:
            self.link.mav.srcSystem, self.link.mav.srcComponent = system, component
            send()
            self.link.mav.srcSystem, self.link.mav.srcComponent = 255, 190

    def command(self, number: int, *parameters: float) -> float:
        values = [*parameters, *[0.0] * (7 - len(parameters))]
        at = time.monotonic()
        self._send_from(255, 190, lambda: self.link.mav.command_long_send(*CAMERA, number, 0, *values))
        return at

    def since(self, at: float, kind: str) -> list[tuple[float, Any]]:
        with self.lock:
            found = [(when, message) for when, message in self.heard if when >= at]
        return [
            (when, m)
            for when, m in found
            if m.get_type() == kind and (m.get_srcSystem(), m.get_srcComponent()) == CAMERA
        ]

    def wait(
        self, at: float, kind: str, condition: Callable[[Any], bool] = bool, seconds: float = 20.0
    ) -> tuple[float, Any] | None:
        """The time and the content of the first such message after `at`; None where it does not come."""
        found: tuple[float, Any] | None = poll(
            lambda: next((one for one in self.since(at, kind) if condition(one[1])), None), seconds, 0.01
        )
        return found

    def wait_for_status(self, at: float, status: int, seconds: float = 20.0) -> tuple[float, Any] | None:
        return self.wait(
            at, "CAMERA_TRACKING_IMAGE_STATUS", lambda message: message.tracking_status == status, seconds
        )

    def ask(self, number: int, *parameters: float) -> tuple[Delay, int | None]:
        """Sends a command. The time to its acknowledgement, and the result; None where there is none."""
        at = self.command(number, *parameters)
        answer = self.wait(at, "COMMAND_ACK", lambda message: message.command == number, 10.0)
        return (Delay.between(at, answer[0], processes=3), answer[1].result) if answer else (NEVER, None)

    def end(self) -> None:
        self.is_ended = True
        self.thread.join()
        self.link.close()


class Run(EngagedRun):
    """A run that is a tracking camera for a ground station."""

    def __init__(self, barrelman: pathlib.Path, url: str) -> None:
        super().__init__(barrelman, "--link", "sim:", "--mavlink", url)

    def follows(self) -> bool:
        return (self.status()["track"] or {}).get("state") == "tracking"

    def boat(self) -> Box:
        """The box of the target in pixels."""
        box: Box = self.status()["track"]["box"]
        return box


def shares(box: Box, margin: float = 0.0, size: tuple[int, int] = (640, 360)) -> tuple[float, ...]:
    """Left, top, right and bottom of a box as shares of the picture."""
    u, v, w, h = box
    sides = (
        (u - margin * w) / size[0],
        (v - margin * h) / size[1],
        (u + (1 + margin) * w) / size[0],
        (v + (1 + margin) * h) / size[1],
    )
    return tuple(min(max(value, 0.0), 1.0) for value in sides)


def iou(first: tuple[float, ...], second: tuple[float, ...]) -> float:
    overlap = [
        min(first[2], second[2]) - max(first[0], second[0]),
        min(first[3], second[3]) - max(first[1], second[1]),
    ]
    both = max(overlap[0], 0.0) * max(overlap[1], 0.0)
    areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (first, second)]
    return both / (sum(areas) - both) if sum(areas) > both else 0.0


def select_until_followed(run: Run, box: Box, select: Callable[..., Any]) -> Any:
    """Selects around a box, wider each time, until the track follows: the boat moves on while a busy machine
    answers.

    `box`: where the boat was last. The world's camera rests. Returns what the last selection returned.
    """
    said = []
    for margin in (0.15, 0.4, 0.7, 1.0):
        said.append(select(*shares(box, margin)))
        if poll(run.follows, 3):
            return said[-1]
    track = run.status()["track"]
    raise TimeoutError(
        f"no selection around {box} was followed; the answers were {said}; the track is {track}"
    )


@pytest.fixture(scope="module")
def station() -> Iterator[GroundStation]:
    station = GroundStation()
    yield station
    station.end()


@pytest.fixture(scope="module")
def camera(barrelman: pathlib.Path, station: GroundStation) -> Iterator[Run]:
    with Run(barrelman, station.url) as run:
        wait_until(run.follows, "the track")
        wait_until(lambda: len(station.since(0, "HEARTBEAT")) >= 4, "four heartbeats")
        yield run


@pytest.mark.usefixtures("camera")
class TestDiscovery:
    def test_heartbeats_come_at_1_hz(self, station: GroundStation) -> None:
        beats = station.since(0, "HEARTBEAT")
        for (earlier, _), (later, _) in itertools.pairwise(beats[-3:]):
            assert later - earlier >= 0.8
            Delay.between(earlier, later).judge(1.3)

    def test_heartbeats_are_those_of_a_camera(self, station: GroundStation) -> None:
        assert station.since(0, "HEARTBEAT")[-1][1].type == mav.MAV_TYPE_CAMERA

    @pytest.mark.parametrize(
        ("number", "parameter"), [(512, 259), (521, 1)], ids=["512 with 259", "521, as before"]
    )
    def test_camera_information_is_sent(self, station: GroundStation, number: int, parameter: int) -> None:
        at = time.monotonic()
        delay, result = station.ask(number, parameter)
        assert result == ACCEPTED
        found = station.wait(at, "CAMERA_INFORMATION")
        assert found
        information = found[1]
        assert (information.resolution_h, information.resolution_v, information.cam_definition_uri) == (
            640,
            360,
            "",
        )
        # It offers points and rectangles, and no modes.
        assert information.flags & (512 + 1024) == 512 + 1024
        assert not information.flags & 4
        Delay.between(at + delay.seconds, found[0]).judge(INFORMATION_WITHIN)

    @pytest.mark.parametrize(
        ("number", "first"),
        [(522, 1), (525, 0), (527, 1), (2504, 0), (2505, 0), (530, 1), (531, 2), (2000, 0)],
    )
    def test_every_command_is_answered(self, station: GroundStation, number: int, first: int) -> None:
        result = station.ask(number, first)[1]
        assert result == UNSUPPORTED if number == 530 else result is not None


def boat_is_selected(camera: Run, station: GroundStation, check: Check) -> None:
    camera.request(DISENGAGE)
    at = time.monotonic()
    delay, result = station.ask(2005, *shares(camera.boat(), margin=0.15))
    check("2005 selects the boat", result == ACCEPTED, result)
    check.in_time("and is answered before MAVSDK would repeat it", delay, REPEATED_AFTER)
    active = station.wait_for_status(at, ACTIVE)
    assert active
    check(
        "275 comes unasked, always a rectangle, in the status",
        (active[1].tracking_mode, active[1].target_data) == (2, 4),
        active[1],
    )

    def overlap() -> float:
        """IoU of the next rectangle and the box that the console shows a moment later: the boat moves."""
        found = station.wait_for_status(time.monotonic(), ACTIVE)
        if not found:
            return 0.0
        status, box = found[1], camera.boat()
        sides = status.rec_top_x, status.rec_top_y, status.rec_bottom_x, status.rec_bottom_y
        return iou(sides, shares(box))

    shown = max(overlap() for _ in range(10))
    check("the rectangle is where the console shows the boat", shown >= 0.7, f"IoU {shown:.2f}")
    check("a selection does not engage", not camera.status()["mode"]["engaged"])


def status_comes_at_its_rate_and_nonsense_is_refused(
    camera: Run, station: GroundStation, check: Check
) -> None:
    # The camera keeps the boat in the picture from here on.
    camera.request(ENGAGE)
    for interval_us, least, most in ((500_000, 3, 6), (100_000, 15, 22)):
        _, result = station.ask(511, 275, interval_us)
        at = time.monotonic()
        time.sleep(2)
        count, late = len(station.since(at, "CAMERA_TRACKING_IMAGE_STATUS")), 2 - took(at, time.monotonic())
        check(
            f"511: 275 every {interval_us // 1000} ms",
            result == ACCEPTED and least - max(late, 0) * 1e6 / interval_us <= count <= most,
            f"{count} in 2 s",
        )
    before = camera.boat()
    for name, number, parameters in (
        ("NaN", 2005, (math.nan, 0.1, 0.5, 0.5)),
        ("an inverted box", 2005, (0.5, 0.5, 0.1, 0.1)),
        ("pixels", 2005, (100, 100, 200, 200)),
        ("a box outside", 2005, (-0.5, 0.1, 0.5, 0.5)),
        ("a point in pixels", 2004, (320, 180, 0.05)),
    ):
        check(f"{name} is refused", station.ask(number, *parameters)[1] == DENIED)
    check("and the track goes on", camera.follows(), f"{before} -> {camera.status()['track']['box']}")


def point_is_selected_and_let_go(camera: Run, station: GroundStation, check: Check) -> Box:
    left, top, right, bottom = shares(camera.boat())
    at = time.monotonic()
    delay, result = station.ask(2004, (left + right) / 2, (top + bottom) / 2, 20 / 640)
    check(
        "2004 selects what is around a point",
        result == ACCEPTED and station.wait_for_status(at + delay.seconds, ACTIVE),
        f"{result} in {delay}",
    )
    box, at = camera.boat(), time.monotonic()
    _, result = station.ask(2010)
    is_idle, state = station.wait_for_status(at, IDLE), camera.status()["track"]["state"]
    check("2010 forgets the target", result == ACCEPTED and is_idle and state == "unseeded", state)
    again, off = station.ask(2010)[1], station.ask(511, 275, -1)[1]
    at = time.monotonic()
    time.sleep(0.5)
    is_off = not station.since(at + 0.1, "CAMERA_TRACKING_IMAGE_STATUS")
    check(
        "2010 with nothing tracked, and 511 with -1, are accepted",
        (again, off) == (ACCEPTED, ACCEPTED) and is_off,
        f"{again}, {off}",
    )
    return box


def test_ground_station_selects_and_lets_go_and_cannot_end_a_stop(
    camera: Run, station: GroundStation, check: Check
) -> None:
    boat_is_selected(camera, station, check)
    status_comes_at_its_rate_and_nonsense_is_refused(camera, station, check)
    box = point_is_selected_and_let_go(camera, station, check)
    camera.request(ENGAGE)
    _, result = select_until_followed(camera, box, lambda *corners: station.ask(2005, *corners))
    mode = camera.status()["mode"]
    check(
        "an engaged camera goes on with a target of the ground station's",
        result == ACCEPTED and mode["engaged"],
        mode,
    )
    box = camera.boat()
    station.ask(2010)
    status = camera.status()
    check(
        "2010 rests the camera and does not stop",
        status["command"] == {"pan": 0.0, "tilt": 0.0, "zoom": 0.0} and status["mode"]["name"] != "stopped",
        status["mode"],
    )
    camera.request(STOP)
    station.ask(2005, *shares(box, margin=0.4))
    time.sleep(1)
    check("a selection does not end a stop", camera.status()["mode"]["name"] == "stopped")
    code = end(camera.child, signal.SIGTERM)
    check("the run ends with exit 0", code == 0, code)


@pytest.mark.apart
def test_mavsdk_finds_the_camera_and_tracks(barrelman: pathlib.Path, check: Check) -> None:
    port = free_port()
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
    with Run(barrelman, f"udp://127.0.0.1:{port}") as run:
        wait_until(run.follows, "the track")
        wait_until(lambda: any(system.has_camera() for system in sdk.get_systems()), "the camera")
        camera = Camera(next(system for system in sdk.get_systems() if system.has_camera()))
        wait_until(lambda: camera.camera_list().cameras, "the list of cameras")
        found = camera.camera_list().cameras[0]
        named = found.vendor_name, found.horizontal_resolution_px, found.vertical_resolution_px
        check("MAVSDK finds the camera", named == ("Barrelman", 640, 360), named)
        box = run.boat()
        run.request(DESELECT)

        def tried(act: Callable[..., None], *more: float) -> str:
            try:
                act(found.component_id, *more)
            except CameraError as error:
                return str(error)
            return "accepted"

        result = select_until_followed(run, box, lambda *corners: tried(camera.track_rectangle, *corners))
        check("MAVSDK starts tracking a rectangle", result == "accepted", result)
        result = tried(camera.track_rectangle, 0.5, 0.5, 0.2, 0.2)
        check("and hears that an inverted one is refused", "DENIED" in result.upper(), result)
        result, state = tried(camera.track_stop), run.status()["track"]["state"]
        check("MAVSDK ends the tracking", (result, state) == ("accepted", "unseeded"), f"{result}, {state}")
    sdk.destroy()


@pytest.mark.apart
def test_mavsdk_reads_the_emulated_gimbal(barrelman: pathlib.Path) -> None:
    """MAVSDK finds a gimbal only where its attitude arrives, so that it is asked for."""
    port = free_port()
    command = [barrelman, "emulate", "gimbal", "--listen", f"udp://127.0.0.1:{port}"]
    emulator = spawn(command, stdout=subprocess.PIPE)
    Lines(emulator.stdout).wait_for("gimbal")
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    sdk.add_any_connection(f"udpout://127.0.0.1:{port}")
    wait_until(sdk.get_systems, "the autopilot")
    system = sdk.get_systems()[0]
    fields: dict[str, Any] = {"target_system": 1, "target_component": 1, "command": 511, "confirmation": 0}
    fields |= {f"param{number}": value for number, value in enumerate((285.0, 200_000.0, *[0.0] * 5), 1)}
    MavlinkDirect(system).send_message(MavlinkMessage("COMMAND_LONG", 245, 190, 1, 1, json.dumps(fields)))
    gimbal = Gimbal(system)
    wait_until(lambda: gimbal.gimbal_list().gimbals, "the gimbal")
    pitch = gimbal.get_attitude(gimbal.gimbal_list().gimbals[0].gimbal_id).euler_angle_forward.pitch_deg
    sdk.destroy()
    end(emulator)
    assert pitch == pytest.approx(-24.0, abs=0.1)


@pytest.mark.apart
def test_ground_station_that_is_not_there_holds_nothing_up(barrelman: pathlib.Path) -> None:
    with Run(barrelman, f"udp://127.0.0.1:{free_port()}") as run:
        run.errors.wait_for("no ground station on --mavlink yet")
        wait_until(run.follows, "the track")


@pytest.mark.apart
@pytest.mark.parametrize("url", ["sim:", "http://127.0.0.1/api", "127.0.0.1:14550"])
def test_mavlink_address_is_refused(barrelman: pathlib.Path, url: str) -> None:
    what = ["--headless", "--no-record", "--video", WORLD, "--link", "sim:", "--mavlink", url]
    wrong = run([barrelman, "run", *what])
    assert wrong.returncode != 0
    assert "--mavlink" in wrong.stderr
