"""Objects with numbers, and marks that hold on to people, in a simulated world with people in the water.

What stands out from the water must be shown with numbers; a number must select the boat. A mark on a person
must be held, and be where the tracker sees the person, while the camera follows the boat and the boat goes to
the person. The recording must repeat bit for bit, with the marks in it.
"""

import math
import pathlib
from typing import Any

import pytest

from client import Program, Request
from conftest import Check
from machine import poll, wait_until
from page import Page
from process import run
from recording import Recording
from test_taps import iou, middle

pytestmark = pytest.mark.apart

BORDER_PX = 4.0
WORLD = "sim:first-drive?size=960x540&seed=4"


def boat_number(program: Program, page: Page) -> int | None:
    """The number of the candidate that is red, as the boat is."""
    box, size = page.find_red()
    if box is None:
        return None
    scale = program.status()["video"]["size"][0] / size[0]
    red = [scale * side for side in box]
    found = [candidate for candidate in program.status()["candidates"] if iou(candidate["box"], red) > 0.1]
    return found[0]["number"] if found else None


def others(status: Any) -> list[dict[str, Any]]:
    """The candidates that are whole and not the boat, the farthest from it first: its wake may be one."""
    box, (width, height) = status["track"]["box"], status["video"]["size"]
    boat = middle(box)
    found = [
        candidate
        for candidate in status["candidates"]
        if iou(candidate["box"], box) == 0 and is_whole(candidate["box"], width, height)
    ]
    return sorted(found, key=lambda candidate: -math.dist(middle(candidate["box"]), boat))


def is_whole(box: list[float], width: float, height: float) -> bool:
    """Whether a box does not touch the border of the picture."""
    u, v, w, h = box
    return min(u, v, width - u - w, height - v - h) > BORDER_PX


def people(status: Any) -> list[dict[str, Any]]:
    return [mark for mark in status["vessel"]["marks"] if mark["kind"] == "person"]


def is_held(mark: dict[str, Any]) -> bool:
    return bool(mark["held"]) and mark["held"]["state"] == "tracking"


def test_boat_is_taken_by_its_number(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    options = ["--video", "sim:first-drive?size=640x360", "--link", "sim:", "--no-record", "--hands-on"]
    with Program(barrelman, "run", *options) as program, Page(program.url, tmp_path) as page:
        page.ready()
        wait_until(lambda: boat_number(program, page), "the boat among the candidates", pause=0.1)
        page.screenshot(pytestconfig.getoption("--screenshots"), "candidates")
        page.type(str(boat_number(program, page)))
        status = program.wait(is_followed, "the boat that is followed")
        check("no candidates are shown now", not status["candidates"], status["candidates"])
        complaints = page.complaints()
        check("the browser has nothing to complain about", not complaints, complaints)
        check("nor has the program", "WARN" not in program.errors.text(), program.errors.text())


def is_followed(status: Any) -> bool:
    return status["track"]["state"] == "tracking" and not status["track"]["confirming"]


def mark_somebody(program: Program) -> bool:
    """Marks candidates as people, one after the other, until one is held."""
    status = program.wait(lambda status: is_followed(status) and others(status), "a candidate")
    for person in others(status):
        program.request(Request("unmark-all"))
        u, v = middle(person["box"])
        program.request(
            Request("mark", mark="person", at={"u": u, "v": v}, captured_ns=person["captured_ns"])
        )
        if poll(lambda: any(map(is_held, people(program.status()))), 2.0):
            return True
    return False


def test_person_is_marked_held_and_reached(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    path = tmp_path / "held.mcap"
    options = ["--video", WORLD, "--link", "sim:", "--vessel", "sim:", "--record", path, "--engage"]
    with Program(barrelman, "run", *options) as program:
        program.wait(is_followed, "the boat that is followed")
        program.request(Request("candidates", shown=True))
        wait_until(lambda: mark_somebody(program), "a mark that is held", pause=0.1)
        program.request(Request("candidates", shown=False))
        with Page(program.url, tmp_path) as page:
            page.ready()
            page.click_enabled("guide")
            status = program.wait(
                lambda status: status["vessel"]["guidance"] == "standing-off", "the boat before the person"
            )
            page.screenshot(pytestconfig.getoption("--screenshots"), "held")
        mark_now = people(status)[0]
        check("the mark is held", is_held(mark_now), mark_now)
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
    replayed = run([barrelman, "replay", path, "--compare"])
    check("a replay gives the same marks", replayed.returncode == 0, replayed.stdout[-300:])
    marks = [mark for outcome in Recording(path).outcomes for mark in outcome.vessel.marks]
    share = sum(mark.HasField("held") for mark in marks) / max(len(marks), 1)
    check("the recording says that the mark is held", share > 0.5, share)
