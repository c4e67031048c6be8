"""`barrelman check` of a gimbal behind a gimbal manager: what it says; it moves and claims nothing."""

import pathlib
import subprocess
from collections.abc import Iterator

import pytest

from independent_gimbal import CLAIM, OTHER, GimbalManager, judging
from process import Lines, end, free_port, run, spawn

pytestmark = pytest.mark.apart


@pytest.fixture
def manager() -> Iterator[GimbalManager]:
    """A gimbal whose every message must have kept the rules at the end."""
    with judging() as manager:
        yield manager


def check_says(barrelman: pathlib.Path, url: str, *patterns: str, code: int | None = 0) -> None:
    done = run([barrelman, "check", "--profile", "mavlink-gimbal", "--video", "sim:arena1", "--link", url])
    assert all(pattern in done.stdout for pattern in patterns), done.stdout
    assert code in (None, done.returncode)


def test_check_says_axes_end_stops_and_who_has_the_control(
    barrelman: pathlib.Path, manager: GimbalManager
) -> None:
    check_says(barrelman, manager.url, "pitch from -90 to 20 degrees", "nobody has the control")
    manager.primary = OTHER
    check_says(barrelman, manager.url, "255/190 has the control", code=None)
    assert not manager.rates_since(0), "check moves"
    assert not manager.commands(CLAIM), "check claims"


def test_check_lists_gimbals_cameras_and_streams_with_what_chooses_them(
    barrelman: pathlib.Path, manager: GimbalManager
) -> None:
    manager.devices = [1, 3]
    check_says(
        barrelman,
        manager.url,
        "device 1 of 1/1 has pan and tilt: used; vehicle.gimbal_device = 1 chooses it",
        "device 3 of 1/1 has pan and tilt: not used; vehicle.gimbal_device = 3 chooses it",
        "camera: 1/100 Acme Independent, which zooms: not used; vehicle.camera = 100 chooses it",
        "stream: stream 1 of 1/100 (main): rtsp://***@192.0.2.7/main; video.url, or --video, chooses it",
    )


def test_check_says_that_no_heartbeat_comes(barrelman: pathlib.Path, manager: GimbalManager) -> None:
    manager.is_silent = True
    check_says(barrelman, manager.url, "no heartbeat", code=1)


def test_check_says_that_the_axes_are_not_described(barrelman: pathlib.Path) -> None:
    with judging(withholds=True) as manager:
        check_says(barrelman, manager.url, "does not say which axes")


def test_check_says_that_nobody_is_there(barrelman: pathlib.Path) -> None:
    check_says(barrelman, f"udp://127.0.0.1:{free_port()}", "nobody takes packets there", code=1)


def test_check_says_that_there_is_no_gimbal(barrelman: pathlib.Path) -> None:
    withholding = ["--withhold-information", "--withhold-status"]
    emulator = spawn(
        [barrelman, "emulate", "gimbal", "--listen", "udp://127.0.0.1:0", *withholding],
        stdout=subprocess.PIPE,
    )
    _, line = Lines(emulator.stdout).wait_for("answers at")
    check_says(barrelman, line.split("answers at ")[1].strip(), "no gimbal manager answers", code=1)
    end(emulator)
