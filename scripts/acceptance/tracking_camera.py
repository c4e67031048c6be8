"""Tests Barrelman as a tracking camera with ground stations of others' writing: pymavlink with QGroundControl's habits, MAVSDK.

The video is a simulated world's. The selection's truth is the box that the console's status shows.
"""
import contextlib
import itertools
import json
import math
import os
import signal
import subprocess
import sys
import threading
import time

import common
import live
from common import Lines, Table
from console_run import WORLD, ConsoleRun

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil  # noqa: E402  (it reads the environment)

mav = mavutil.mavlink
CAMERA = (1, 100)
# QGroundControl waits so long for CAMERA_INFORMATION after the acknowledgement, and for the answer to a track command.
INFORMATION_WITHIN = 1.0
TRACK_ANSWER_WITHIN = 3.0
# MAVSDK sends a command again after this time.
REPEATED_AFTER = 0.5


class GroundStation:
    """A ground station and an autopilot behind one UDP socket, as a router has them."""

    def __init__(self):
        self.port = live.free_port()
        self.url = f"udp://127.0.0.1:{self.port}"
        self.link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{self.port}", source_system=255, source_component=190)
        self.heard = []
        self.lock = threading.Lock()
        self.is_ended = False
        self.sends_heartbeats = True
        self.thread = threading.Thread(target=self._listen, daemon=True)
        self.thread.start()

    def _listen(self):
        beat_at = 0.0
        while not self.is_ended:
            message = self.link.recv_match(blocking=True, timeout=0.05)
            if message is not None:
                with self.lock:
                    self.heard.append((time.monotonic(), message))
            if self.link.clients_last_alive and self.sends_heartbeats and time.monotonic() >= beat_at:
                beat_at = time.monotonic() + 1.0
                self._send_from(255, 190, lambda: self.link.mav.heartbeat_send(mav.MAV_TYPE_GCS, mav.MAV_AUTOPILOT_INVALID, 0, 0, 4))
                self._send_from(1, 1, lambda: self.link.mav.heartbeat_send(mav.MAV_TYPE_QUADROTOR, mav.MAV_AUTOPILOT_ARDUPILOTMEGA, 0, 0, 4))

    def _send_from(self, system, component, send):
        with self.lock:
            self.link.mav.srcSystem, self.link.mav.srcComponent = system, component
            send()
            self.link.mav.srcSystem, self.link.mav.srcComponent = 255, 190

    def command(self, number, *parameters, to=CAMERA):
        values = [*parameters, *[0.0] * (7 - len(parameters))]
        at = time.monotonic()
        self._send_from(255, 190, lambda: self.link.mav.command_long_send(*to, number, 0, *values))
        return at

    def since(self, at, kind=None, source=CAMERA):
        with self.lock:
            found = [(when, message) for when, message in self.heard if when >= at]
        return [(when, m) for when, m in found if (kind is None or m.get_type() == kind) and (m.get_srcSystem(), m.get_srcComponent()) == source]

    def wait(self, at, kind, seconds, condition=lambda message: True):
        """The time after `at` and the first such message; None where it does not come."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for when, message in self.since(at, kind):
                if condition(message):
                    return when - at, message
            time.sleep(0.01)
        return None

    def ask(self, number, *parameters, seconds=3.0, to=CAMERA):
        """Sends a command. The time to its acknowledgement, and the result; None where there is none."""
        at = self.command(number, *parameters, to=to)
        answer = self.wait(at, "COMMAND_ACK", seconds, lambda message: message.command == number)
        return (answer[0], answer[1].result) if answer else (math.inf, None)

    def end(self):
        self.is_ended = True
        self.thread.join()
        self.link.close()


def follows(run):
    """Whether the run is up and follows its target."""
    with contextlib.suppress(OSError):
        return (run.ask("status")["track"] or {}).get("state") == "tracking"
    return False


def boat(run):
    """The box of the target and the size of the picture, as shares of the picture and in pixels."""
    return run.ask("status")["track"]["box"]


def shares(box, size=(640, 360), margin=0.0):
    u, v, w, h = box
    left, right = (u - margin * w) / size[0], (u + (1 + margin) * w) / size[0]
    top, bottom = (v - margin * h) / size[1], (v + (1 + margin) * h) / size[1]
    return [min(max(value, 0.0), 1.0) for value in (left, top, right, bottom)]


def iou(first, second):
    overlap = [min(first[2], second[2]) - max(first[0], second[0]), min(first[3], second[3]) - max(first[1], second[1])]
    both = max(overlap[0], 0.0) * max(overlap[1], 0.0)
    areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (first, second)]
    return both / (sum(areas) - both) if sum(areas) > both else 0.0


def corners(status):
    return [status.rec_top_x, status.rec_top_y, status.rec_bottom_x, status.rec_bottom_y]


def select_until_followed(run, box, select):
    """Selects around a box, wider each time, until the track follows: the boat moves on while a busy machine answers.

    `box`: where the boat was last. The world's camera rests. Returns what the last selection returned.
    """
    said = []
    for margin in (0.15, 0.4, 0.7, 1.0):
        answer = select(*shares(box, margin=margin))
        said.append(answer)
        with contextlib.suppress(TimeoutError):
            common.wait_until(lambda: follows(run), 3, "the track")
            return answer
    raise TimeoutError(f"no selection around {box} was followed; the answers were {said}; the track is {run.ask('status')['track']}")


def overlap(station, run):
    """IoU of the next rectangle and the box that the console shows a moment later. The boat moves between the two."""
    at = time.monotonic()
    found = station.wait(at, "CAMERA_TRACKING_IMAGE_STATUS", 2, lambda status: status.tracking_status == 1)
    box = boat(run)
    return iou(corners(found[1]), shares(box)) if found and box else 0.0


def discovery(table, station):
    beats = []
    common.wait_until(lambda: len(station.since(0, "HEARTBEAT")) >= 4, 15, "four heartbeats")
    beats = station.since(0, "HEARTBEAT")
    gaps = [later[0] - earlier[0] for earlier, later in itertools.pairwise(beats)]
    table.require("heartbeats at 1 Hz, of a camera of the vehicle's system", all(0.8 <= gap <= 1.3 for gap in gaps[-2:]) and beats[-1][1].type == mav.MAV_TYPE_CAMERA, f"{gaps[-1]:.2f} s, type {beats[-1][1].type}")
    for number, parameters, name in ((512, (259,), "512 with 259"), (521, (1,), "521, as before")):
        at = time.monotonic()
        delay, result = station.ask(number, *parameters)
        information = station.wait(at, "CAMERA_INFORMATION", INFORMATION_WITHIN)
        table.require(f"CAMERA_INFORMATION by {name}", result == 0 and information is not None, f"answered in {delay * 1e3:.0f} ms", f"within {INFORMATION_WITHIN:.0f} s")
    information = information[1]
    size = (information.resolution_h, information.resolution_v)
    text = lambda field: bytes(field).split(b"\0")[0].decode()
    table.require("its resolution is the picture's, its definition is empty", size == (640, 360) and information.cam_definition_uri == "", f"{size[0]}x{size[1]}, {text(information.vendor_name)} {text(information.model_name)}")
    table.require("it offers points and rectangles, and no modes", information.flags & (512 + 1024) == 512 + 1024 and not information.flags & 4, f"flags {information.flags}")
    results = {number: station.ask(number, first)[1] for number, first in ((522, 1), (525, 0), (527, 1), (2504, 0), (2505, 0), (530, 1), (531, 2), (2000, 0))}
    table.require("every command is answered, what is not there as unsupported", None not in results.values() and results[530] == 3, f"{results}")


def selecting(table, station, run):
    select = shares(boat(run), margin=0.15)
    at = time.monotonic()
    delay, result = station.ask(2005, *select, seconds=TRACK_ANSWER_WITHIN)
    table.require("2005 selects the boat", result == 0, f"{result} in {delay * 1e3:.0f} ms", f"before {REPEATED_AFTER * 1e3:.0f} ms")
    table.require("and is answered before MAVSDK would repeat it", delay < REPEATED_AFTER, f"{delay * 1e3:.0f} ms")
    active = station.wait(at + delay, "CAMERA_TRACKING_IMAGE_STATUS", 3, lambda status: status.tracking_status == 1)
    table.require("275 comes unasked, exactly ACTIVE", active is not None, f"{active[0] * 1e3:.0f} ms later" if active else "")
    status = active[1]
    table.require("always a rectangle, in the status", (status.tracking_mode, status.target_data) == (2, 4), f"mode {status.tracking_mode}, data {status.target_data}")
    shown = max(overlap(station, run) for _ in range(10))
    table.require("the rectangle is where the console shows the boat", shown >= 0.7, f"IoU {shown:.2f}", "at least 0.7")
    table.require("a selection does not engage", not run.ask("status")["mode"]["engaged"], run.ask("status")["mode"]["name"])
    # The camera keeps the boat in the picture from here on.
    run.request("engage")
    for interval, least, most in ((500_000, 3, 6), (100_000, 15, 22)):
        _, result = station.ask(511, 275, interval)
        at = time.monotonic()
        time.sleep(2)
        count = len(station.since(at, "CAMERA_TRACKING_IMAGE_STATUS"))
        table.require(f"511: 275 every {interval // 1000} ms", result == 0 and least <= count <= most, f"{count} in 2 s")
    before = boat(run)
    refused = {}
    for name, number, parameters in (
        ("NaN", 2005, (math.nan, 0.1, 0.5, 0.5)), ("inverted", 2005, (0.5, 0.5, 0.1, 0.1)), ("pixels", 2005, (100, 100, 200, 200)),
        ("outside", 2005, (-0.5, 0.1, 0.5, 0.5)), ("point in pixels", 2004, (320, 180, 0.05)),
    ):
        refused[name] = station.ask(number, *parameters)[1]
    kept = run.ask("status")["track"]
    table.require("bad rectangles and points are refused", set(refused.values()) == {2}, f"{refused}")
    table.require("and the track goes on", kept["state"] == "tracking" and boat(run) is not None, f"{before[0]:.0f} -> {kept['box'][0]:.0f} px")
    left, top, right, bottom = shares(boat(run))
    at = time.monotonic()
    delay, result = station.ask(2004, (left + right) / 2, (top + bottom) / 2, 20 / 640, seconds=TRACK_ANSWER_WITHIN)
    active = station.wait(at + delay, "CAMERA_TRACKING_IMAGE_STATUS", 3, lambda status: status.tracking_status == 1)
    table.require("2004 selects what is around a point", result == 0 and active is not None, f"{result} in {delay * 1e3:.0f} ms")
    box, at = boat(run), time.monotonic()
    delay, result = station.ask(2010)
    idle = station.wait(at, "CAMERA_TRACKING_IMAGE_STATUS", 2, lambda status: status.tracking_status == 0)
    track = run.ask("status")["track"]["state"]
    table.require("2010 forgets the target", result == 0 and idle is not None and track == "unseeded", f"{result} in {delay * 1e3:.0f} ms, {track}")
    again, off = station.ask(2010)[1], station.ask(511, 275, -1)[1]
    at = time.monotonic()
    time.sleep(0.5)
    table.require("2010 with nothing tracked, and 511 with -1, are accepted", (again, off) == (0, 0) and not station.since(at + 0.1, "CAMERA_TRACKING_IMAGE_STATUS"), f"{again}, {off}")
    return box


def engaged(table, station, run, box):
    """A camera that is engaged follows what is selected; 2010 rests the camera, and the Stop latch is another thing.

    `box`: where the boat was a second ago. The world's camera rests meanwhile.
    """
    run.request("engage")
    _, result = select_until_followed(run, box, lambda *corners: station.ask(2005, *corners, seconds=TRACK_ANSWER_WITHIN))
    mode = run.ask("status")["mode"]
    table.require("an engaged camera goes on with a target of the ground station's", result == 0 and mode["engaged"], mode["name"])
    box = boat(run)
    station.ask(2010)
    mode = run.ask("status")
    table.require("2010 rests the camera and does not stop", mode["command"] == {"pan": 0.0, "tilt": 0.0} and mode["mode"]["name"] != "stopped", mode["mode"]["name"])
    run.request("stop")
    station.ask(2005, *shares(box, margin=0.4), seconds=TRACK_ANSWER_WITHIN)
    time.sleep(1)
    mode = run.ask("status")["mode"]
    table.require("a selection does not end a stop", mode["name"] == "stopped", mode["name"])


def with_a_ground_station(table, args, folder):
    station = GroundStation()
    with ConsoleRun(args, folder, "qgc", "--link", "sim:", "--mavlink", station.url, video=WORLD) as run:
        common.wait_until(lambda: follows(run), 20, "the track")
        discovery(table, station)
        run.request("disengage")
        box = selecting(table, station, run)
        engaged(table, station, run, box)
        run.child.send_signal(signal.SIGTERM)
        run.child.wait(timeout=10)
        table.require("the run ends as it should", run.child.returncode == 0, f"exit {run.child.returncode}")
    station.end()


def with_mavsdk(table, args, folder):
    from mavsdk import ComponentType, Configuration, Mavsdk
    from mavsdk.plugins.camera.camera import Camera, CameraError

    port = live.free_port()
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
    with ConsoleRun(args, folder, "mavsdk", "--link", "sim:", "--mavlink", f"udp://127.0.0.1:{port}", video=WORLD) as run:
        common.wait_until(lambda: follows(run), 20, "the track")
        began = time.monotonic()
        common.wait_until(lambda: any(system.has_camera() for system in sdk.get_systems()), 15, "the camera")
        system = next(system for system in sdk.get_systems() if system.has_camera())
        camera = Camera(system)
        common.wait_until(lambda: camera.camera_list().cameras, 15, "the list of cameras")
        found = camera.camera_list().cameras[0]
        table.require("MAVSDK finds the camera", (found.vendor_name, found.horizontal_resolution_px, found.vertical_resolution_px) == ("Barrelman", 640, 360), f"{found.vendor_name} {found.model_name}, {time.monotonic() - began:.1f} s")
        box = boat(run)
        run.request("deselect")

        def tried(act):
            began = time.monotonic()
            try:
                act()
                return "accepted", time.monotonic() - began
            except CameraError as error:
                return str(error), time.monotonic() - began

        result, seconds = select_until_followed(run, box, lambda *corners: tried(lambda: camera.track_rectangle(found.component_id, *corners)))
        table.require("MAVSDK starts tracking a rectangle", result == "accepted", f"{result} in {seconds * 1e3:.0f} ms")
        result, _ = tried(lambda: camera.track_rectangle(found.component_id, 0.5, 0.5, 0.2, 0.2))
        table.require("and hears that an inverted one is refused", "DENIED" in result.upper(), result)
        result, _ = tried(lambda: camera.track_stop(found.component_id))
        state = run.ask("status")["track"]["state"]
        table.require("MAVSDK ends the tracking", result == "accepted" and state == "unseeded", f"{result}, {state}")
    sdk.destroy()


def mavsdk_reads_the_gimbal(table, args, folder):
    """The emulated gimbal beside the camera: MAVSDK finds a gimbal only where its attitude arrives, so that it is asked for."""
    from mavsdk import ComponentType, Configuration, Mavsdk
    from mavsdk.plugins.gimbal.gimbal import Gimbal
    from mavsdk.plugins.mavlink_direct.mavlink_direct import MavlinkDirect, MavlinkMessage

    port = live.free_port()
    emulator = common.spawn([args.barrelman, "emulate", "gimbal", "--listen", f"udp://127.0.0.1:{port}"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    Lines(emulator.stdout).wait_for("gimbal", 10)
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    sdk.add_any_connection(f"udpout://127.0.0.1:{port}")
    common.wait_until(lambda: sdk.get_systems(), 15, "the autopilot")
    system = sdk.get_systems()[0]
    fields = {"target_system": 1, "target_component": 1, "command": 511, "confirmation": 0, "param1": 285.0, "param2": 200_000.0, **{f"param{index}": 0.0 for index in range(3, 8)}}
    MavlinkDirect(system).send_message(MavlinkMessage(message_name="COMMAND_LONG", system_id=245, component_id=190, target_system_id=1, target_component_id=1, fields_json=json.dumps(fields)))
    gimbal = Gimbal(system)
    common.wait_until(lambda: gimbal.gimbal_list().gimbals, 15, "the gimbal")
    number = gimbal.gimbal_list().gimbals[0].gimbal_id
    pitch = gimbal.get_attitude(number).euler_angle_forward.pitch_deg
    table.require("MAVSDK reads the emulated gimbal", abs(pitch + 24.0) < 0.1, f"pitch {pitch:.1f} degrees", "-24")
    sdk.destroy()
    emulator.terminate()
    emulator.wait(timeout=10)


def without_a_ground_station(table, args, folder):
    port = live.free_port()
    with ConsoleRun(args, folder, "alone", "--link", "sim:", "--mavlink", f"udp://127.0.0.1:{port}", video=WORLD) as run:
        run.err.wait_for("no ground station on --mavlink yet", 15)
        common.wait_until(lambda: follows(run), 20, "the track")
        table.require("a ground station that is not there holds nothing up", True, "said once, the track goes on")
    for url in ("sim:", "http://127.0.0.1/api", "127.0.0.1:14550"):
        wrong = common.run([args.barrelman, "run", "--headless", "--no-record", "--video", WORLD, "--link", "sim:", "--mavlink", url])
        table.require(f"--mavlink {url} is refused", wrong.returncode != 0 and "--mavlink" in wrong.stderr, wrong.stderr.strip().splitlines()[-1][:90])


def main():
    args = common.arguments(__doc__)
    folder = common.temporary_folder()
    table = Table("A tracking camera for MAVLink ground stations")
    with_a_ground_station(table, args, folder)
    with_mavsdk(table, args, folder)
    mavsdk_reads_the_gimbal(table, args, folder)
    without_a_ground_station(table, args, folder)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
