"""The drills of the demo: an alarm that is answered by STOP, the result on the page, and the next drill."""

import pathlib
from collections.abc import Iterator

import pytest

from client import Program, Request
from conftest import Check
from machine import wait_until
from page import Page, started

pytestmark = pytest.mark.apart


@pytest.fixture(scope="module")
def program(barrelman: pathlib.Path) -> Program:
    return Program(barrelman, "demo", "--drill", "stop-on-alarm", "--seed", 3, "--size", "640x360")


@pytest.fixture(scope="module")
def page(program: Program, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with started(program, tmp_path_factory.mktemp("drills")) as page:
        yield page


class TestDrills:
    def test_stop_after_the_alarm_is_a_result(
        self, program: Program, page: Page, check: Check, pytestconfig: pytest.Config
    ) -> None:
        pictures = pytestconfig.getoption("--screenshots")
        drill = program.status()["drill"]
        check("the drill goes on", drill["name"] == "stop-on-alarm" and drill["result"] is None, drill)
        check("its name is over the picture", "Stop on an alarm" in page.text("drill-text"))
        page.wait_for_mode("servoing")
        page.wait(lambda data: data["next"] == "drill", "the alarm on the page")
        page.screenshot(pictures, "drill-alarm")
        page.type("space")
        drill = program.wait(lambda status: status["drill"]["result"], "the result")["drill"]
        result = drill["result"]
        check("the sentence says how long it took", "s after the alarm" in result["sentence"], result)
        check("nothing is left of the time", drill["left_s"] == 0, drill)
        check("the alarm has ended", "drill" not in program.status()["alarms"])
        wait_until(lambda: page.element("result-dialog").is_displayed(), "the result on the page")
        rows = page.text("result-rows").splitlines()
        check("there are three rows", len(rows) == 3, rows)
        for who in ("person", "schema", "default_law"):
            figures = result[who]
            check(f"the camera of {who} kept the boat", figures["in_picture"] > 0.9, result)
        page.screenshot(pictures, "drill-result")

    def test_next_drill_begins_from_the_result(self, program: Program, page: Page, check: Check) -> None:
        page.click_enabled("drill-next")
        status = program.wait(lambda status: status["drill"]["name"] == "keep-in-view", "the next drill")
        check("it begins disengaged", not status["mode"]["engaged"], status["mode"])
        check("it has a new seed", status["drill"]["seed"] == 4, status["drill"])
        wait_until(
            lambda: "Keep the boat in view" in page.text("drill-text"), lambda: page.text("drill-text")
        )
        wait_until(lambda: "Turn the camera by hand" in page.text("toast"), lambda: page.text("toast"))

    def test_list_has_every_drill(
        self, program: Program, page: Page, check: Check, pytestconfig: pytest.Config
    ) -> None:
        page.click_enabled("drills")
        buttons = [button.text for button in page.element("drill-list").find_elements("tag name", "button")]
        check("there are five drills", len(buttons) == 5, buttons)
        page.screenshot(pytestconfig.getoption("--screenshots"), "drills")
        page.element("drill-list").find_elements("css selector", "[value=find-the-boat]")[0].click()
        status = program.wait(
            lambda status: status["drill"]["name"] == "find-the-boat", "a drill of the list"
        )
        check("the boat is out of the picture", status["drive"]["in_picture"] is False, status["drive"])
        check("the boat is not pointed at", status["world"]["boat"] is None, status["world"])
        check("nothing is wrong on the page", page.complaints() == [], page.complaints())

    def test_new_drive_ends_the_drill(self, program: Program, page: Page, check: Check) -> None:
        answer = program.request(Request("new-drive", scenario="open", seed=1))
        check("a program may not begin one while the page controls", answer["answer"] == "refused", answer)
        page.end()
        wait_until(
            lambda: program.request(Request("new-drive", scenario="open", seed=1))["answer"] == "accepted",
            "the drive",
        )
        status = program.wait(lambda status: status["drill"] is None, "a drive that is no drill")
        check("it is the wanted world", status["world"]["scenario"] == "open", status["world"])
        check("the program ends well", program.end() == 0)


def test_drill_of_a_run_is_refused(barrelman: pathlib.Path, check: Check) -> None:
    program = Program(barrelman, "run", "--video", "sim:open?size=320x180", "--link", "sim:", "--no-record")
    answer = program.request(Request("drill", drill="keep-in-view", seed=1))
    check("it says where drills are", "barrelman demo --drill" in (answer["reason"] or ""), answer)
    program.end()
