"""What the tests of the commanded boat share: marks on the page, a boat that goes, and a receiver of its
commands."""

import pathlib
import socket
from collections.abc import Sequence
from typing import Any

from client import Program
from machine import Delay
from page import Page, Size, started

# From the loss of the program, or from Stop, until the boat is neutral, seconds.
NEUTRAL_WITHIN = 0.3
# Processes and threads from a press or a signal to the boat: driver, browser, console, pilot, guard, this
# test.
HOPS = 6


class Receiver:
    """A boat at a UDP port of loopback. `heard`: each command's time, and its throttle or speed and its
    rudder or turn."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.heard: list[tuple[float, float, float]] = []

    @property
    def url(self) -> str:
        return f"udp://127.0.0.1:{self.socket.getsockname()[1]}"

    def since(self, begin: float) -> list[tuple[float, float, float]]:
        return [row for row in list(self.heard) if row[0] >= begin]

    def last_motion_after(self, begin: float) -> tuple[Delay, bool]:
        """The time from `begin` to the last command that was not neutral, and whether a neutral one
        followed."""
        rows = self.since(begin)
        moving = [at for at, throttle, rudder in rows if throttle or rudder]
        return Delay.between(begin, moving[-1] if moving else begin, HOPS), bool(rows) and rows[-1][1:] == (
            0.0,
            0.0,
        )


def mark(page: Page, program: Program, kind: str, at: Sequence[float], size: Size) -> Any:
    """Marks a point, and waits until the program has the mark."""
    before = len(program.status()["vessel"]["marks"])
    page.script("document.getElementById('mark-kind').value = arguments[0]", kind)
    page.click("mark")
    page.drag([*at, 0, 0], size)
    status = program.wait(lambda status: len(status["vessel"]["marks"]) > before, f"the mark {kind}")
    return status["vessel"]["marks"][-1]


def open_water(program: Program) -> list[float]:
    """A point of the water to which the boat has a way to go: to the side of the boat, in the picture."""
    status = program.status()
    u, v = status["track"]["centre"]
    width, height = status["video"]["size"]
    return [
        width - u if abs(width / 2 - u) > width / 6 else u + width / 4,
        min(0.8 * height, v + 0.12 * height),
    ]


def goes(program: Program) -> Any:
    return program.wait(
        lambda status: status["vessel"]["mode"] == "guided" and status["vessel"]["throttle"] > 0,
        "the boat to go",
    )


def is_linked(status: Any) -> bool:
    return bool(status["vessel"]["link"] == "up")


def going(
    barrelman: pathlib.Path, folder: pathlib.Path, *options: Any, answers: bool = False
) -> tuple[Program, Page]:
    """A run whose page offers Go to a place. `answers`: the boat does, so that its link comes up."""
    program = Program(barrelman, "run", *options)
    page = started(program, folder)
    page.wait(lambda data: data["track"] == "tracking", "the track")
    if answers:
        program.wait(is_linked, "the boat's link")
    mark(page, program, "place", open_water(program), program.status()["video"]["size"])
    page.wait_until_enabled("guide")
    return program, page
