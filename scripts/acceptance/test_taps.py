"""Select by a tap.

A tap on the boat must propose a box that overlaps the truth of the simulated world by an IoU of at least 0.5,
and follow nothing; a tap on plain water must say that nothing stands out there. Engage, or a second tap, must
take the proposal. What is followed must not change at a tap. What was recorded and stored must repeat bit for
bit. The page in headless Chromium must do the same by the mouse.
"""

import pathlib
from collections.abc import Sequence
from typing import Any

import pytest

from client import ENGAGE, Program, Request
from conftest import Check
from drives import repeats
from page import Page

pytestmark = pytest.mark.apart

PATIENCE_S = 240.0
LEAST_IOU = 0.5
NOTHING = "nothing stands out here"
# Shares of the picture: of these points, that farthest from the boat shows water.
CORNERS = ((0.15, 0.75), (0.85, 0.75), (0.15, 0.9), (0.85, 0.9))


def iou(a: Sequence[float], b: Sequence[float]) -> float:
    """Intersection over union of two boxes: left, top, width, height."""
    w = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    h = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    both = max(w, 0.0) * max(h, 0.0)
    return both / (a[2] * a[3] + b[2] * b[3] - both)


def middle(box: Sequence[float]) -> tuple[float, float]:
    return box[0] + box[2] / 2, box[1] + box[3] / 2


def water(status: Any, boat: Sequence[float]) -> tuple[float, float]:
    """A point of the picture that shows water, far from the boat."""
    (width, height), (u, v) = status["video"]["size"], middle(boat)
    points = [(x * width, y * height) for x, y in CORNERS]
    return max(points, key=lambda point: abs(point[0] - u) + abs(point[1] - v))


def tap(status: Any, at: tuple[float, float]) -> Request:
    """A tap on the newest picture of a status."""
    return Request("propose", at={"u": at[0], "v": at[1]}, captured_ns=status["video"]["captured_ns"])


def waiting_world(program: Program) -> Any:
    """The state of a world that waits for the first selection, with its boat in the picture."""
    return program.wait(
        lambda status: status["drive"] and status["drive"]["waits"] and status["world"]["boat"], "the wait"
    )


def test_tap_proposes_the_boat_and_engage_takes_it(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    store, record = tmp_path / "taps.jsonl", tmp_path / "taps.mcap"
    with Program(barrelman, "demo", "--hands-on", "--store", store, "--record", record) as program:
        state = waiting_world(program)
        boat = state["world"]["boat"]
        answer = program.request(tap(state, water(state, boat)))
        check(
            "a tap on water is refused with the reason",
            answer["answer"] == "refused" and answer["reason"] == NOTHING,
            answer,
        )
        check("and nothing is proposed", program.status()["proposal"] is None)
        answer = program.request(tap(state, middle(boat)))
        check("a tap on the boat is accepted", answer["answer"] == "accepted", answer)
        proposed = program.wait(lambda status: status["proposal"], "the proposal")
        overlap = iou(proposed["proposal"]["box"], boat)
        check("the proposed box is the boat's", overlap >= LEAST_IOU, f"IoU {overlap:.2f}")
        check("and nothing is followed", proposed["track"]["state"] == "unseeded", proposed["track"])
        program.request(ENGAGE)
        followed = program.wait(
            lambda status: status["track"]["state"] == "tracking" and not status["track"]["confirming"],
            "the track",
            PATIENCE_S,
        )
        check("Engage takes the proposal", followed["proposal"] is None, followed["proposal"])
        check("and the camera is engaged", followed["mode"]["engaged"], followed["mode"])
        taps_while_following(program, check)
        check("Ctrl-C ends it with exit 0", program.end() == 0)
    repeats(barrelman, check, store, record)


def taps_while_following(program: Program, check: Check) -> None:
    """Nothing that is followed changes until a proposal is taken."""
    state = program.status()
    answer = program.request(tap(state, water(state, state["track"]["box"])))
    check("a tap on water while following is refused", answer.get("reason") == NOTHING, answer)
    state = program.status()
    answer = program.request(tap(state, middle(state["track"]["box"])))
    check("a tap on the followed boat is accepted", answer["answer"] == "accepted", answer)
    state = program.wait(lambda status: status["proposal"], "the second proposal")
    goes_on = state["track"]["state"] == "tracking" and not state["track"]["confirming"]
    check("and the track goes on", goes_on, state["track"])
    answer = program.request(tap(state, middle(state["proposal"]["box"])))
    check("a tap within the proposal takes it", answer["answer"] == "accepted", answer)
    check("by the way of a selection", "following" in (answer.get("reason") or ""), answer)


def test_page_taps_twice_to_follow(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    pictures = pytestconfig.getoption("--screenshots")
    with Program(barrelman, "demo", "--hands-on") as program:
        state = waiting_world(program)
        boat = state["world"]["boat"]
        with Page(program.url, tmp_path) as page:
            page.wait(lambda data: data.get("pointer") and page.size(), "the mark at the boat")
            size = page.size()
            assert size
            page.drag([*water(state, boat), 0, 0], size)
            page.wait(lambda _: NOTHING in page.text("toast"), "the reason")
            page.drag([*middle(boat), 0, 0], size)
            proposed = program.wait(lambda status: status["proposal"], "the proposal")
            overlap = iou(proposed["proposal"]["box"], boat)
            check("the proposed box is the boat's", overlap >= LEAST_IOU, f"IoU {overlap:.2f}")
            page.wait(lambda data: data["next"] == "proposed", "the next action")
            check("the page says how to go on", "Tap it again" in page.text("next-action"))
            page.screenshot(pictures, "proposed")
            page.drag([*middle(proposed["proposal"]["box"]), 0, 0], size)
            program.wait(lambda status: status["track"]["state"] == "tracking", "the track", PATIENCE_S)
            complaints = page.complaints()
            check("the browser has nothing to complain about", not complaints, complaints)
