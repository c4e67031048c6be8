"""Another gimbal, camera or media profile in the place of the one in use: the camera stops, and the log names
both."""

import pathlib
import time
from typing import Any

import pytest

from client import ENGAGE, EngagedRun
from conftest import Check
from independent_gimbal import judging
from independent_onvif import Camera
from machine import wait_until
from test_onvif import options

pytestmark = pytest.mark.apart

# The boat leaves the region after seven seconds, and stays in the picture for ten more.
WORLD = "sim:arena2?seed=2&size=640x360"


def is_stopped(status: Any) -> bool:
    return bool(status["mode"]["cause"] == "exchanged")


def judge(program: EngagedRun, check: Check, event: str) -> None:
    """The run has stopped for an exchange, says so in these words, and goes on only when it is engaged."""
    program.wait(is_stopped, "the stop")
    command = program.status()["command"]
    check("the camera rests", command == {"pan": 0, "tilt": 0, "zoom": 0}, command)
    wait_until(lambda: event in program.errors.text(), "the names of old and new")
    program.wait(lambda status: status["link"]["state"] == "up", "the link")
    time.sleep(1)
    check("it stays stopped", is_stopped(program.status()), program.status()["mode"])
    program.request(ENGAGE)
    program.wait(lambda status: status["mode"]["engaged"], "the engagement")


def test_another_gimbal_device_stops_the_camera(barrelman: pathlib.Path, check: Check) -> None:
    words = ["--profile", "mavlink-gimbal"]
    with judging() as manager, EngagedRun(barrelman, *words, "--link", manager.url, video=WORLD) as program:
        wait_until(manager.is_turning, "the first motion")
        manager.exchange(2)
        judge(program, check, "the gimbal is another one: device 2 of 1/1 instead of device 1 of 1/1")


def test_another_camera_at_the_same_component_stops_the_camera(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    config = tmp_path / "zoom.toml"
    config.write_text('[vehicle]\nprofile = "mavlink-gimbal"\n\n[camera.zoom]\nratio = 8\n')
    with judging() as manager, EngagedRun(barrelman, config, "--link", manager.url, video=WORLD) as program:
        program.wait(lambda status: status["link"]["camera"], "the camera's name")
        manager.model = b"Replacement"
        judge(
            program,
            check,
            "the camera is another one: 1/100 Acme Replacement instead of 1/100 Acme Independent",
        )


@pytest.mark.parametrize("what", ["profile", "source"])
def test_another_media_profile_or_video_source_stops_the_camera(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, what: str
) -> None:
    with Camera() as camera, EngagedRun(barrelman, *options(tmp_path, camera.url), video=WORLD) as program:
        program.wait(lambda status: status["link"]["stream"], "the stream's name")
        if what == "profile":
            camera.profile = "replacement"
        else:
            # The camera is joined anew, with another source.
            camera.source, camera.refuses_login = "source-2", True
            program.wait(lambda status: status["link"]["state"] != "up", "the end of the link")
            camera.refuses_login = False
        now = f"{camera.profile} of video source {camera.source}"
        before = "main-profile of video source source-1"
        judge(program, check, f"the stream is another one: {now} instead of {before}")
