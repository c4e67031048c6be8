"""The zoom: by hand over each vehicle's protocol; ended by Stop, by silence, and by the program's end."""

import json
import pathlib
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from client import DISENGAGE, STOP, Program, Request, nudge
from conftest import Check
from independent_gimbal import judging
from machine import Delay, wait_until
from page import started
from process import ENDS_WITHIN, Lines, end, free_port, secret, spawn

pytestmark = [pytest.mark.apart, pytest.mark.realtime, pytest.mark.clocked]

# Its camera zooms, and nothing moves it but what is measured.
WORLD = "sim:open?seed=3&size=640x360"
SPEEDS = "\n[vehicle.speeds]\npan = [[0.05, 0.02], [1.0, 1.2]]\ntilt = [[0.05, 0.02], [1.0, 1.2]]\n"
HOPS = 4
REST_LIMIT = 0.35


def hold(program: Program, zoom: float, seconds: float) -> Any:
    """Holds the zoom as a page does, and gives the last answer."""
    until, answer = time.monotonic() + seconds, None
    while time.monotonic() < until:
        answer = program.request(nudge(0, 0, zoom))
        time.sleep(0.08)
    return answer


def ratio(status: Any) -> float:
    return float(status["zoom"]["ratio"])


def config_of(folder: pathlib.Path, profile: str) -> pathlib.Path:
    config = folder / "zoom.toml"
    speeds = SPEEDS if profile == "onvif-ptz" else ""
    config.write_text(f'[vehicle]\nprofile = "{profile}"\n{speeds}\n[camera.zoom]\nratio = 8\n')
    return config


class Emulated:
    """An emulated vehicle whose camera is that of a simulated world, and the options of a run with it."""

    def __init__(self, barrelman: pathlib.Path, folder: pathlib.Path, vehicle: str) -> None:
        port, self.log = free_port(), folder / "emulated.jsonl"
        address = f"127.0.0.1:{port}"
        video = free_port()
        choices: dict[str, tuple[list[Any], str, list[Any]]] = {
            "onvif": (["--linear"], "onvif-ptz", ["--link", f"onvif://{address}"]),
            "fotokite-sigma": (
                [],
                "fotokite-sigma",
                [
                    "--link",
                    f"http://{address}/api/v1",
                    "--link-token-file",
                    secret(folder / "token", "emulated"),
                ],
            ),
            "gimbal": ([], "mavlink-gimbal", ["--link", f"tcp://{address}"]),
        }
        more, profile, self.link = choices[vehicle]
        listen = f"tcp://{address}" if vehicle == "gimbal" else address
        words = ["emulate", vehicle, "--listen", listen, "--log", self.log, "--world", WORLD]
        command = [barrelman, *words, "--video-listen", f"127.0.0.1:{video}", *more]
        self.child = spawn(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        said = Lines(self.child.stdout).wait_for("answers at")[1]
        if vehicle == "fotokite-sigma":
            self.link[1] = said.split("answers at ")[1].split()[0]
        self.options = [config_of(folder, profile), *self.link]
        if vehicle == "gimbal":
            self.options += ["--video", f"rtsp://127.0.0.1:{video}/stream"]

    def speeds(self) -> list[float]:
        """The speeds of the zoom at the vehicle, where they changed."""
        rows = [json.loads(line) for line in self.log.read_text().splitlines()]
        speeds = [
            row["zoom"] if "zoom" in row else row["state"]["zoom"]
            for row in rows
            if "zoom" in row or "state" in row
        ]
        return [speed for index, speed in enumerate(speeds) if index == 0 or speeds[index - 1] != speed]

    def end(self) -> None:
        self.child.terminate()
        self.child.wait(timeout=ENDS_WITHIN)


@pytest.mark.parametrize("vehicle", ["onvif", "fotokite-sigma", "gimbal"])
def test_zoom_by_hand_reaches_the_camera_and_ends(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, vehicle: str
) -> None:
    emulated = Emulated(barrelman, tmp_path, vehicle)
    with Program(barrelman, "run", "--no-record", *emulated.options) as program:
        program.wait(
            lambda status: (
                status["link"]["state"] == "up"
                and status["link"].get("acceptance") in (None, "accepted")
                and status["link"].get("in_control") is not False
                and status["video"]["state"] == "up"
                and status["zoom"]
            ),
            "link, video and zoom",
        )
        # Video that is late for a moment, on a busy machine, refuses.
        wait_until(lambda: hold(program, 1.0, 2.0)["answer"] == "accepted", "the zoom to be accepted")
        # The pictures tell of it, the later the busier the machine is.
        wait_until(lambda: hold(program, 1.0, 0.1) and ratio(program.status()) > 1.2, "a closer view")
        program.wait(lambda status: status["command"]["zoom"] == 0, "the end of the zoom")
        wait_until(lambda: emulated.speeds()[-1] == 0, "the camera to rest")
        check("the camera zoomed", max(emulated.speeds()) > 0, emulated.speeds())
        hold(program, -1.0, 0.5)
        program.request(STOP)
        check("a stop ends it", program.status()["command"]["zoom"] == 0)
        answer = program.request(nudge(0, 0, 1))
        check("after a stop nothing zooms", answer["answer"] == "refused", answer)
        check("the run ends with exit 0", end(program.child) == 0)
    time.sleep(0.5)
    check("the camera rests at the end", emulated.speeds()[-1] == 0, emulated.speeds())
    emulated.end()


@pytest.fixture
def zooming(barrelman: pathlib.Path, tmp_path: pathlib.Path) -> Iterator[Callable[[], tuple[Any, Program]]]:
    """A run that zooms the camera of a vehicle of another's making."""
    options = [config_of(tmp_path, "mavlink-gimbal"), "--video", WORLD]
    with (
        judging() as manager,
        Program(barrelman, "run", "--no-record", *options, "--link", manager.url) as program,
    ):

        def begin() -> tuple[Any, Program]:
            program.wait(lambda status: status["zoom"] is not None, "the zoom")
            hold(program, 1.0, 1.0)
            # A zoom that is not renewed ends by itself.
            wait_until(lambda: bool(program.request(nudge(0, 0, 1)) and manager.zoom == 1.0), "the zoom")
            return manager, program

        yield begin


@pytest.mark.parametrize("zooms", [True, False])
def test_a_mavlink_camera_is_zoomed_if_it_says_that_it_can(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, zooms: bool
) -> None:
    options = [config_of(tmp_path, "mavlink-gimbal"), "--video", WORLD]
    with (
        judging(zooms=zooms) as manager,
        Program(barrelman, "run", "--no-record", *options, "--link", manager.url) as program,
    ):
        wait_until(lambda: any(asked.param1 == 259 for _, asked in manager.commands(512)), "the question")
        wait_until(lambda: (program.status()["zoom"] is not None) == zooms, "the answer")
        link = program.wait(lambda status: status["link"]["camera"], "the camera's name")["link"]
        used = (link["gimbal"], link["camera"], link["stream"])
        check("what is used is named", used == ("device 1 of 1/1", "1/100 Acme Independent", None), used)
        for request in (nudge(0, 0, 1), Request("keep-size", keep=True)):
            answer = program.request(request)
            is_refused = answer["answer"] == "refused" and "zoom" in answer["reason"]
            check(f"{request['kind']}, zooms: {zooms}", is_refused != zooms, answer)
        with started(program, tmp_path) as page:
            page.ready()
            for button in ("lens-up", "lens-down", "keep-size"):
                check(f"{button}, zooms: {zooms}", page.element(button).is_displayed() == zooms)
            page.click("level")
            wait_until(lambda: "camera 1/100 Acme" in page.text("figures"), "the names at the expert level")
        speeds = [message.param2 for _, message in manager.commands(531)]
        check("a camera without zoom is not zoomed", zooms or not any(speeds), speeds)


def rest_after(manager: Any, at: float) -> Delay:
    wait_until(lambda: manager.zoom == 0, "rest")
    sent = [when for when, message in manager.commands(531) if when >= at and message.param2 == 0]
    return Delay.between(at, sent[0], HOPS)


@pytest.mark.parametrize("how", ["stop", "silence of the page", "kill -9"])
def test_a_camera_that_keeps_its_speed_is_rested(
    zooming: Callable[[], tuple[Any, Program]], check: Check, how: str
) -> None:
    manager, program = zooming()
    at = time.monotonic()
    if how == "stop":
        program.request(STOP)
    elif how == "kill -9":
        program.child.send_signal(signal.SIGKILL)
    check.in_time(f"{how}: the zoom rests", rest_after(manager, at), REST_LIMIT)
    time.sleep(0.5)
    zeros = [message.param2 for when, message in manager.commands(531) if when >= at]
    check("zero is repeated", zeros[-3:] == [0, 0, 0], zeros)


def test_keeping_the_size_is_for_cameras_that_zoom(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    keep = Request("keep-size", keep=True)
    with Program(
        barrelman, "run", "--no-record", "--video", "sim:arena1?size=640x360", "--link", "sim:"
    ) as fixed:
        fixed.wait(lambda status: status["step"] > 0, "the first step")
        check("this camera has no zoom", fixed.status()["zoom"] is None)
        answer = fixed.request(keep)
        check("it is refused in words", "does not zoom" in answer.get("reason", ""), answer)
    config = config_of(tmp_path, "fotokite-pro")
    with Program(barrelman, "run", config, "--no-record", "--video", WORLD, "--link", "sim:") as zooms:
        zooms.wait(lambda status: status["video"]["state"] == "up" and status["zoom"], "the zoom")
        zooms.request(keep)
        status = zooms.wait(lambda status: status["zoom"]["keeps_size"], "the size to be kept")
        check("nothing zooms without an engagement", status["command"]["zoom"] == 0)
        hold(zooms, 1.0, 1.0)
        status = zooms.wait(lambda status: not status["zoom"]["keeps_size"], "the end by hand")
        check("the operator has zoomed", ratio(status) > 1.1, status["zoom"])
        zooms.request(DISENGAGE)
