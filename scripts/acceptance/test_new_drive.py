"""The first minute of the demo, and New drive.

Begun with `--hands-on`, the world must wait for the first box, and the page must point at the boat. Hints
must come once each. A world must last past the end of the boat's path; New drive alone must end it, with a
stop, and without marks. What was recorded and stored before and after must repeat bit for bit.
"""

import pathlib
import time
from typing import Any

import pytest
from selenium.webdriver.common.by import By

from client import Program, Request
from conftest import Check
from drives import repeats
from machine import wait_until
from page import Page, started

pytestmark = pytest.mark.apart

SIZE = "480x270"
PATIENCE_S = 240.0


def new_drive(scenario: str, seed: int) -> Request:
    return Request("new-drive", scenario=scenario, seed=seed)


def mark_person(status: Any) -> Request:
    """A mark of a person in the middle of the newest picture."""
    width, height = status["video"]["size"]
    at = {"u": width / 2, "v": height / 2}
    return Request("mark", mark="person", at=at, captured_ns=status["video"]["captured_ns"])


def test_hands_on_world_waits_for_the_first_box_and_the_page_points_at_the_boat(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    pictures = pytestconfig.getoption("--screenshots")
    with Program(barrelman, "demo", "--hands-on") as program:
        waiting = program.wait(lambda status: status["drive"] and status["drive"]["waits"], "the wait")
        with Page(program.url, tmp_path) as page:
            page.wait(lambda data: data.get("pointer") and page.size(), "the mark at the boat")
            time.sleep(0.5)
            state = program.status()
            check(
                "the world stands still", state["drive"]["tick"] == waiting["drive"]["tick"], state["drive"]
            )
            size, box = page.size(), state["world"]["boat"]
            assert size
            check("the scenario is first-drive", state["world"]["scenario"] == "first-drive", state["world"])
            check("the boat is at least 50 pixels long", box[2] >= 50, box)
            check("the page says what to do", "Tap the boat" in page.text("next-action"))
            check("the hint is about selecting", "Tap the boat" in page.text("hint-text"))
            page.screenshot(pictures, "first-drive")
            page.drag([box[0] - 4, box[1] - 4, box[2] + 8, box[3] + 8], size)
            program.wait(lambda status: status["track"]["state"] == "tracking", "the track", PATIENCE_S)
            program.wait(
                lambda status: not status["drive"]["waits"] and status["world"]["boat"] is None,
                "the end of the wait",
            )
            page.wait(lambda data: data["pointer"] == "", "the end of the mark")
            hints_come_once(page, check, pictures)
            complaints = page.complaints()
            check("the browser has nothing to complain about", not complaints, complaints)


def hints_come_once(page: Page, check: Check, pictures: pathlib.Path | None) -> None:
    def wait_for_hint(part: str) -> None:
        hint = page.element("hint-text")
        wait_until(lambda: part in hint.text, f"a hint about {part}")

    wait_for_hint("arrow keys")
    page.screenshot(pictures, "hint")
    buttons = page.script("""
        const hint = document.getElementById('hint').getBoundingClientRect();
        const covers = (button) => {
          const { left, right, top, bottom, width } = button.getBoundingClientRect();
          const isBeside =
            left >= hint.right || right <= hint.left || top >= hint.bottom || bottom <= hint.top;
          return width && !isBeside && button.id !== 'hint-close';
        };
        return [...document.querySelectorAll('button, select')].filter(covers).map(({ id }) => id)""")
    check("the hint covers no control", buttons == [], buttons)
    page.press("up")
    wait_for_hint("Mark a person")
    page.release("up")
    page.click("hint-close")
    hint = page.element("hint")
    check("a hint that was read goes", not hint.is_displayed())
    page.driver.refresh()
    page.ready()
    time.sleep(0.5)
    check("and does not come again", not page.element("hint").is_displayed())
    page.click("keys")
    page.click("hints-again")
    wait_for_hint("arrow keys")


def test_new_drive_of_a_demo_stops_forgets_the_marks_and_repeats(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    store, record = tmp_path / "drive.jsonl", tmp_path / "drive.mcap"
    program = Program(barrelman, "demo", "rescue", "--size", SIZE, "--store", store, "--record", record)
    program.wait_for_track()
    marked = program.request(mark_person(program.status()))
    check("a person is marked", marked["answer"] == "accepted", marked)
    state = program.wait(lambda status: status["drive"]["time_s"] > 20, "the time after the path", PATIENCE_S)
    check("the drive outlasts its path, with its mark", len(state["vessel"]["marks"]) == 1, state["vessel"])
    refused = program.request(new_drive("/etc/passwd.toml", 1))
    check("a file is no scenario", "there is no scenario" in refused.get("reason", ""), refused)
    with started(program, tmp_path) as page:
        page.wait(lambda data: data["controlling"] == "yes", "the control")
        page.driver.find_element(By.TAG_NAME, "body").send_keys("k")
        page.script("""
            const list = document.getElementById('scenario');
            list.value = 'arena2';
            list.dispatchEvent(new Event('change'))""")
        check("the dialog describes the scenario", page.text("scenario-summary") != "")
        check("the next seed is offered", page.element("seed").get_attribute("value") == "2")
        page.screenshot(pytestconfig.getoption("--screenshots"), "new-drive")
        page.element("drive-form").find_element(By.CSS_SELECTOR, "[value=begin]").click()
        page.wait(lambda data: data["world"] == "arena2 2", "the new world", PATIENCE_S)
        events = page.script("return document.getElementById('events').textContent")
        check("the events tell it", "new drive: arena2, seed 2: the camera is disengaged" in events, events)
        state = program.wait(lambda status: status["track"]["state"] == "tracking", "the track", PATIENCE_S)
        check("it begins disengaged", not state["mode"]["engaged"], state["mode"])
        check("and without marks", state["vessel"]["marks"] == [], state["vessel"])
        check("at its beginning", state["drive"]["time_s"] < 20, state["drive"])
        page.wait_until_enabled("engage")
        page.type("e")
        program.wait(lambda status: status["mode"]["engaged"], "the engagement")
        complaints = page.complaints()
        check("the browser has nothing to complain about", not complaints, complaints)
    check("Ctrl-C ends it with exit 0", program.end() == 0)
    repeats(barrelman, check, store, record)
    repeats(barrelman, check, tmp_path / "drive-2.jsonl", tmp_path / "drive-2.mcap")


def test_new_drive_of_a_run_goes_on_in_the_same_recording(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    record = tmp_path / "run.mcap"
    video = f"sim:rescue?size={SIZE}"
    options = ["--video", video, "--link", "sim:", "--vessel", "sim:", "--engage", "--record", record]
    with Program(barrelman, "run", *options) as program:
        program.wait_for_track()
        program.request(mark_person(program.status()))
        paused = program.request(Request("pause"))
        check("the time of a run cannot be paused", paused["answer"] == "refused", paused)
        answer = program.request(new_drive("open", 5))
        check("the new drive is accepted", answer["answer"] == "accepted", answer)
        state = program.status()
        check(
            "another world", state["world"] == {"scenario": "open", "seed": 5, "boat": None}, state["world"]
        )
        check("the camera is stopped", state["mode"]["name"] == "stopped", state["mode"])
        check("no mark is left", state["vessel"]["marks"] == [], state["vessel"])
        program.wait_for_track()
        program.request(Request("engage"))
        program.wait(lambda status: status["mode"]["engaged"], "the engagement")
        time.sleep(2.0)
        check("Ctrl-C ends it with exit 0", program.end() == 0)
    repeats(barrelman, check, None, record)
