"""A run against an ONVIF camera with code of its own (independent_onvif.py), which judges every message; and
the emulated camera against a client of another's making (onvif-zeep).

The video is a simulated world's, whose camera nothing moves: the boat leaves the region, and the camera law
asks for motion. A last test closes the loop.
"""

import json
import pathlib
import signal
import socket
import subprocess
import time
from typing import Any

import pytest
from lxml import etree
from onvif import ONVIFCamera, ONVIFError

from client import STOP, WORLD, EngagedRun
from conftest import Check
from independent_onvif import PASSWORD, SOAP, USER, Camera, envelope_of, wsdl_folder
from machine import Delay, wait_until
from process import ENDS_WITHIN, Lines, end, free_port, run, secret, spawn
from worlds import first_box, follow_boat

pytestmark = pytest.mark.apart

# The time-out of a motion, and the time of a request on a busy machine.
TIMEOUT_LIMIT = 1.1
STOP_LIMIT = 0.2
# Processes and threads from an event to the velocity in force: console or this test, the pilot, the link, the
# camera.
HOPS = 4
# Those of the emulated camera (emulators/src/onvif.rs).
SPEEDS = """
[vehicle.speeds]
pan = [[0.05, 0.02], [0.2, 0.1], [0.5, 0.3], [0.8, 0.7], [1.0, 1.2]]
tilt = [[0.05, 0.016], [0.2, 0.08], [0.5, 0.24], [0.8, 0.56], [1.0, 0.96]]
"""


def options(folder: pathlib.Path, url: str, speeds: str = SPEEDS) -> list[Any]:
    """The configuration, and the options of the link."""
    config = folder / "onvif.toml"
    config.write_text(f'[vehicle]\nprofile = "onvif-ptz"\n{speeds}')
    return [
        config,
        "--link",
        url,
        "--link-login-file",
        secret(folder / "camera.login", f"{USER}:{PASSWORD}"),
    ]


class Run(EngagedRun):
    """A run against a camera."""

    def __init__(
        self, barrelman: pathlib.Path, folder: pathlib.Path, camera: Camera, speeds: str = SPEEDS
    ) -> None:
        self.camera = camera
        super().__init__(barrelman, *options(folder, camera.url, speeds))

    def wait_for_acceptance(self, acceptance: str) -> None:
        self.wait(lambda status: status["link"].get("acceptance") == acceptance, f"acceptance {acceptance}")

    def wait_until_it_moves(self) -> None:
        wait_until(self.camera.is_turning, "the first motion")
        time.sleep(0.3)
        wait_until(self.camera.is_turning, "the next motion")


def rest_after(camera: Camera, at: float, seconds: float = 3.0) -> Delay:
    """The time from `at` until nothing turns the camera any more, as the camera has it."""
    until = last = at
    while until < at + seconds:
        until = time.monotonic()
        if camera.is_turning():
            last = until
        time.sleep(0.002)
    return Delay.between(at, last, HOPS)


@pytest.mark.parametrize("http_digest", [False, True], ids=["proof in the message", "HTTP's digest"])
def test_every_message_keeps_the_rules(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, http_digest: bool
) -> None:
    with Camera(http_digest) as camera, Run(barrelman, tmp_path, camera) as program:
        program.wait_until_it_moves()
        at = time.monotonic()
        program.request(STOP)
        check.in_time("Stop while the camera turns: rest", rest_after(camera, at), STOP_LIMIT)
        asked = [name for _, name in camera.requests]
        check("the camera's time is asked for first", asked[0] == "GetSystemDateAndTime", asked[:6])
        first = next(name for name in asked if name in ("ContinuousMove", "Stop"))
        check("the first command is a stop", first == "Stop", first)
        zeros = [velocity for when, velocity, _ in camera.motions if when > at + 0.1 and velocity == (0, 0)]
        check("both kinds of zero are sent", zeros and "Stop" in asked, zeros)
        check("the run ends with exit 0", end(program.child) == 0)
        program.errors.join()
        log = program.errors.text()
        check("no log line holds the password", PASSWORD not in log and "w&amp;rd" not in log)
        check("no message breaks a rule", not camera.violations, sorted(set(camera.violations)))


def test_camera_that_was_not_measured_is_not_turned(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    with Camera() as camera, Run(barrelman, tmp_path, camera, speeds="") as program:
        program.wait_for_acceptance("not-calibrated")
        time.sleep(3)
        check("nothing is turned", not [one for one in camera.motions if any(one[1])], camera.motions)


def test_refused_login_is_told_ends_the_motion_and_does_not_hammer(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    with Camera() as camera, Run(barrelman, tmp_path, camera) as program:
        program.wait_until_it_moves()
        camera.refuses_login = True
        at = time.monotonic()
        program.wait_for_acceptance("login-refused")
        check.in_time("the motion ends by its time-out", rest_after(camera, at, 2.5), TIMEOUT_LIMIT)
        before = len(camera.requests)
        time.sleep(4)
        asked = len(camera.requests) - before
        check("the camera is not hammered", asked <= 8, f"{asked} requests in 4 s")
        camera.refuses_login = False
        program.wait_for_acceptance("accepted")


def test_stop_reaches_a_camera_that_ignores_stops(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    with Camera() as camera, Run(barrelman, tmp_path, camera) as program:
        camera.ignores_stops = True
        program.wait_until_it_moves()
        at = time.monotonic()
        program.request(STOP)
        check.in_time("Stop: rest by a velocity of 0", rest_after(camera, at), STOP_LIMIT + 0.15)


def test_motion_on_a_camera_that_hangs_ends_by_its_time_out_and_the_link_comes_back(
    barrelman: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    with Camera() as camera, Run(barrelman, tmp_path, camera) as program:
        program.wait_until_it_moves()
        camera.hangs.set()
        at = time.monotonic()
        rest = rest_after(camera, at)
        time.sleep(2)
        camera.hangs.clear()
        program.wait_for_acceptance("accepted")
        assert not camera.violations
    rest.judge(TIMEOUT_LIMIT)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=lambda number: number.name)
def test_motion_of_a_program_that_is_gone_ends_by_its_time_out(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, number: signal.Signals
) -> None:
    with Camera() as camera, Run(barrelman, tmp_path, camera) as program:
        program.wait_until_it_moves()
        at = time.monotonic()
        program.child.send_signal(number)
        rest = rest_after(camera, at)
        program.child.send_signal(signal.SIGCONT)
        program.child.kill()
        program.child.wait()
    rest.judge(TIMEOUT_LIMIT)


def test_check_reads_and_moves_nothing(barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check) -> None:
    with Camera() as camera:
        done = run([barrelman, "check", *options(tmp_path, camera.url), "--video", "sim:arena1"])
        check("the profile that moves is named", "main-profile" in done.stdout, done.stdout)
        listed = 'main-profile of video source source-1 (b): used; video.stream = "main-profile" chooses it'
        check("it is listed with what chooses it", listed in done.stdout, done.stdout)
        check("its missing zoom is told", "the camera does not zoom" in done.stdout, done.stdout)
        check("the measured speeds are shown", "1.1 to 69 deg/s" in done.stdout, done.stdout)
        moved = [name for _, name in camera.requests if name in ("ContinuousMove", "Stop")]
        check("nothing is moved", not moved, moved)
        camera.refuses_login = True
        done = run([barrelman, "check", *options(tmp_path, camera.url), "--video", "sim:arena1"])
        check("a wrong login is told with the remedy", "--link-login-file" in done.stdout, done.stdout)


class Emulated:
    """The emulated camera."""

    def __init__(self, barrelman: pathlib.Path, folder: pathlib.Path, *more: Any) -> None:
        self.port, self.log = free_port(), folder / "emulated.jsonl"
        command = [
            barrelman,
            "emulate",
            "onvif",
            "--listen",
            f"127.0.0.1:{self.port}",
            "--login-file",
            secret(folder / "emulated.login", f"{USER}:{PASSWORD}"),
            "--log",
            self.log,
            *more,
        ]
        self.child = spawn(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        Lines(self.child.stdout).wait_for("answers at")

    def rows(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in self.log.read_text().splitlines()]

    def end(self) -> None:
        self.child.terminate()
        self.child.wait(timeout=ENDS_WITHIN)


def test_emulated_camera_understands_a_client_of_anothers_making(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    emulated = Emulated(barrelman, tmp_path)
    camera = ONVIFCamera("127.0.0.1", emulated.port, USER, PASSWORD, str(wsdl_folder()), adjust_time=True)
    media, ptz = camera.create_media_service(), camera.create_ptz_service()
    profile = next(one for one in media.GetProfiles() if one.PTZConfiguration)
    options = ptz.GetConfigurationOptions({"ConfigurationToken": profile.PTZConfiguration.token})
    space = options.Spaces.ContinuousPanTiltVelocitySpace[0]
    check("the range of the velocity", (space.XRange.Min, space.XRange.Max) == (-1, 1), space)
    setup = {"Stream": "RTP-Unicast", "Transport": {"Protocol": "RTSP"}}
    uri = media.GetStreamUri({"StreamSetup": setup, "ProfileToken": profile.token}).Uri
    check("the address of the video", uri.startswith("rtsp://"), uri)
    move = {"ProfileToken": profile.token, "Velocity": {"PanTilt": {"x": 0.5, "y": 0}}, "Timeout": "PT1S"}
    ptz.ContinuousMove(move)
    time.sleep(0.3)
    before = ptz.GetStatus({"ProfileToken": profile.token})
    check("it moves", before.MoveStatus.PanTilt == "MOVING", before)
    time.sleep(1.5)
    after = ptz.GetStatus({"ProfileToken": profile.token})
    check("it ends by its time-out", after.MoveStatus.PanTilt == "IDLE", after)
    check("it was turned right", after.Position.PanTilt.x > before.Position.PanTilt.x, after.Position)
    for key, value in (("Velocity", {"PanTilt": {"x": 1.5, "y": 0}}), ("Timeout", "PT90S")):
        with pytest.raises(ONVIFError):
            ptz.ContinuousMove({**move, key: value})
    with pytest.raises(ONVIFError):
        ONVIFCamera("127.0.0.1", emulated.port, USER, "wrong", str(wsdl_folder())).create_media_service()
    emulated.end()


@pytest.mark.realtime
def test_emulated_camera_keeps_the_boat_in_the_region(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    """Over RTSP, at the address that the camera tells."""
    world = ["--world", WORLD, "--video-listen", f"127.0.0.1:{free_port()}"]
    emulated = Emulated(barrelman, tmp_path, *world)
    select = first_box(barrelman, tmp_path)
    link = options(tmp_path, f"onvif://127.0.0.1:{emulated.port}")
    with EngagedRun(barrelman, *link, "--select", select, video=None) as closed:
        closed.wait(lambda status: status["link"].get("acceptance") == "accepted", "acceptance")
        follow_boat(closed, check)
        check("the run ends with exit 0", end(closed.child) == 0)
    emulated.end()
    turned = [row for row in emulated.rows() if row.get("pan_deg_per_s") or row.get("tilt_deg_per_s")]
    check("the camera of the world was turned", len(turned) > 3, f"{len(turned)} changes of the rates")
    refused = [row for row in emulated.rows() if row.get("status", 200) != 200]
    check("the camera refuses nothing", not refused, refused[:2])


def test_discovered_cameras_are_listed_with_their_links(barrelman: pathlib.Path, check: Check) -> None:
    """A camera on the loopback interface in the place of the group."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as camera:
        camera.bind(("127.0.0.1", 0))
        camera.settimeout(10)
        where = f"127.0.0.1:{camera.getsockname()[1]}"
        child = spawn([barrelman, "check", "--discover", where], stdout=subprocess.PIPE)
        question, client = camera.recvfrom(8192)
        probe = etree.fromstring(question)
        asked = probe.find(f"{{{SOAP}}}Body")[0]
        check("the question is a Probe", etree.QName(asked).localname == "Probe", question)
        scopes = "onvif://www.onvif.org/name/Pier%20east onvif://www.onvif.org/hardware/M50"
        camera.sendto(b"lollipop", client)
        body = (
            f"<d:ProbeMatch><d:Scopes>{scopes}</d:Scopes><d:XAddrs>http://192.0.2.7:81/onvif/device_service"
        )
        body += " https://[2001:db8::7]/onvif/device_service</d:XAddrs></d:ProbeMatch>"
        space = etree.QName(asked).namespace
        answer = envelope_of(f'<d:ProbeMatches xmlns:d="{space}">{body}</d:ProbeMatches>')
        camera.sendto(answer.encode(), client)
        camera.sendto(answer.encode(), client)
        said, _ = child.communicate(timeout=ENDS_WITHIN)
    lines = [line for line in said.splitlines() if "Pier east, M50" in line]
    check("it is listed once", len(lines) == 1, said)
    links = "--link onvif://192.0.2.7:81 or onvifs://[2001:db8::7]"
    check("with its links", lines and links in lines[0], lines)
