"""Objects with numbers, and marks that hold on to people, in a simulated world with people in the water.

What stands out from the water must be shown with numbers; a number must select the boat. A mark on a person
must be held, and be where the tracker sees the person, while the camera follows the boat and the boat goes to
the person. The recording must repeat bit for bit, with the marks in it.
"""

import pathlib
from typing import Any

import pytest

from client import DESELECT, ENGAGE, GUIDE, Program, Request
from conftest import Check
from page import Page
from process import run
from recording import Recording
from test_taps import iou, middle, waiting_world

pytestmark = pytest.mark.apart

WORLD = "sim:rescue?size=960x540&seed=4"


def candidate_on(status: Any, box: list[float]) -> dict[str, Any] | None:
    """The candidate whose box is this one."""
    found = [candidate for candidate in status["candidates"] if iou(candidate["box"], box) > 0.2]
    return found[0] if found else None


def others(status: Any, box: list[float]) -> list[dict[str, Any]]:
    """The candidates that are not the object of a box."""
    return [candidate for candidate in status["candidates"] if iou(candidate["box"], box) == 0]


def people(status: Any) -> list[dict[str, Any]]:
    return [mark for mark in status["vessel"]["marks"] if mark["kind"] == "person"]


def is_held(mark: dict[str, Any]) -> bool:
    return bool(mark["held"]) and mark["held"]["state"] == "tracking"


def begin(program: Program) -> None:
    """Lets the world begin, which waits for a selection, with nothing that is followed."""
    status = waiting_world(program)
    program.request(Request("select-next", **dict(zip("uvwh", status["world"]["boat"], strict=True))))
    program.wait(lambda status: status["track"]["state"] == "tracking", "the first track")
    program.request(DESELECT)


def test_person_is_marked_held_and_reached(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    pictures = pytestconfig.getoption("--screenshots")
    path = tmp_path / "held.mcap"
    options = ["--video", WORLD, "--link", "sim:", "--vessel", "sim:", "--record", path, "--hands-on"]
    with Program(barrelman, "run", *options) as program:
        with Page(program.url, tmp_path) as page:
            page.ready()
            begin(program)
            status = program.wait(
                lambda status: status["world"]["boat"] and candidate_on(status, status["world"]["boat"]),
                "the boat among the candidates",
            )
            page.screenshot(pictures, "candidates")
            number = candidate_on(status, status["world"]["boat"])["number"]
            page.type(str(number))
            program.wait(
                lambda status: status["track"]["state"] == "tracking" and not status["track"]["confirming"],
                "the boat that is followed",
            )
            program.request(ENGAGE)
            check("none are shown while it is followed", not program.status()["candidates"])
            program.request(Request("candidates", shown=True))
            status = program.wait(
                lambda status: others(status, status["track"]["box"] or [0, 0, 1, 1]), "a person"
            )
            person = others(status, status["track"]["box"])[0]
            u, v = middle(person["box"])
            mark = Request("mark", mark="person", at={"u": u, "v": v}, captured_ns=person["captured_ns"])
            answer = program.request(mark)
            check("the person is marked", answer["answer"] == "accepted", answer)
            program.request(Request("candidates", shown=False))
            program.wait(lambda status: any(map(is_held, people(status))), "the held mark")
            answer = program.request(GUIDE)
            check("the boat goes", answer["answer"] == "accepted", answer)
            status = program.wait(
                lambda status: status["vessel"]["guidance"] == "standing-off", "the boat before the person"
            )
            page.screenshot(pictures, "held")
            mark_now = people(status)[0]
            held = mark_now["held"]
            check(
                "the mark has a tracker", held is not None and held["state"] in ("tracking", "coasting"), held
            )
            check("and is not old", mark_now["std_dev_m"] < 1.5, mark_now["std_dev_m"])
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
    replayed = run([barrelman, "replay", path, "--compare"])
    check("a replay gives the same marks", replayed.returncode == 0, replayed.stdout[-300:])
    marks = [mark for outcome in Recording(path).outcomes for mark in outcome.vessel.marks]
    share = sum(mark.HasField("held") for mark in marks) / max(len(marks), 1)
    check("the recording says that the mark is held", share > 0.5, share)
