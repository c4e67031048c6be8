"""The operator's console in headless Chromium, on `run` with an emulated ground station.

The log of the ground station has the rates that arrived.
"""

import contextlib
import os
import pathlib
import signal
import time
from collections.abc import Iterator
from typing import Any

import pytest
from selenium.webdriver.common.by import By

from client import ENGAGE, REQUESTS, UNKNOWN, Program, is_inside
from conftest import Check
from drives import repeats
from emulator import Emulator
from machine import Delay, poll, wait_until
from page import Page, started
from process import run

pytestmark = pytest.mark.realtime

SIZE = "960x540"
# Processes and threads from a press to the rates in force: driver, browser, console, pilot, link, guard,
# emulator.
HOPS = 7
STOPS_AMONG_REQUESTS = 8
ATTEMPTS = 4


class Station:
    """A run with an emulated ground station, which can be pulled out and put back, and the page in
    control."""

    def __init__(self, barrelman: pathlib.Path, folder: pathlib.Path) -> None:
        self.barrelman, self.folder, self.record = barrelman, folder, folder / "run.mcap"
        self.world = ["--world", f"sim:arena1?size={SIZE}", "--video-listen"]
        self.emulator = Emulator(barrelman, folder, *self.world, "127.0.0.1:0", name="station")
        self.video = self.emulator.video
        link = ["--video", self.video, "--link", self.emulator.url]
        self.program = Program(barrelman, "run", *link, "--record", self.record, "--law", "schema")
        self.page = started(self.program, folder, "control")

    def put_back(self) -> None:
        self.emulator = Emulator(
            self.barrelman, self.folder, "--force", *self.world, self.video.split("/")[2], name="station"
        )

    def zeros_after(self, moment: float) -> Delay:
        """The time from `moment` to the first zero that the ground station heard after its last rate;
        infinite without one."""
        time.sleep(1.0)
        rows = [row for row in self.emulator.since(moment) if row.is_motion]
        last = max((row.at for row in rows if row.moves), default=moment)
        return Delay.between(
            moment, next((row.at for row in rows if row.is_zero and row.at >= last), float("inf")), HOPS
        )

    def nudged(self, key: str) -> None:
        """Turns the camera by a key that stays down. Without fresh video the key does nothing, and is let
        go."""
        self.page.disengage()

        def is_nudging() -> bool:
            self.page.press(key)
            if poll(lambda: self.page.data["mode"] == "nudging", 5.0, 0.03):
                return True
            self.page.release(key)
            return False

        began = time.monotonic()
        wait_until(is_nudging, lambda: f"the nudge ({self.page.data}; {self.page.text('toast')})")
        self.emulator.wait_for(lambda row: row.moves, "a rate", began)

    def ends_well(self, barrelman: pathlib.Path, check: Check) -> None:
        code = self.program.end()
        check("SIGINT ends the run with exit 0", code == 0, self.program.errors.text()[-200:] if code else "")
        repeats(barrelman, check, None, self.record)


@pytest.fixture(scope="class")
def station(barrelman: pathlib.Path, folder: pathlib.Path) -> Iterator[Station]:
    station = Station(barrelman, folder)
    yield station
    station.page.end()
    station.program.end()
    station.emulator.close()


REASONS = [
    ({}, None),
    ({"mode": {"name": "nudging"}}, None),
    ({"link": {"state": "simulated", "in_control": None, "flight": None}}, None),
    ({"mode": {"name": "servoing"}}, "nudge"),
    ({"mode": {"name": "stopped"}}, "nudge"),
    ({"link": {"state": "dry-run"}}, "nudgeDryRun"),
    ({"link": {"state": "starting"}}, "nudgeLink"),
    ({"link": {"state": "up", "in_control": False}}, "nudgeControl"),
    ({"link": {"state": "up", "flight": "emergency"}}, "nudgeFlight"),
    ({"video": {"state": "lost"}}, "nudgeVideo"),
    ({"alarms": ["no-video"]}, "nudgeVideo"),
]
REFUSED: dict[str, tuple[int, dict[str, Any]]] = {
    "no token": (401, {"token": None}),
    "a wrong token": (401, {"token": "x" * 22}),
    "metrics without a token": (401, {"path": "/metrics", "token": None}),
    "a socket without a token": (
        401,
        {
            "path": "/api/v1/socket",
            "token": None,
            "headers": {
                "Connection": "Upgrade",
                "Upgrade": "websocket",
                "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
            },
        },
    ),
    "a foreign Host": (403, {"headers": {"Host": "evil.example"}}),
    "a foreign Origin": (403, {"headers": {"Origin": "http://evil.example"}}),
    "a foreign page's fetch": (403, {"headers": {"Sec-Fetch-Site": "cross-site"}}),
    "a path with ..": (404, {"path": "/console/../../etc/passwd"}),
    "an encoded path with ..": (404, {"path": "/console/%2e%2e%2f%2e%2e%2fetc%2fpasswd"}),
    "a body of 5000 bytes": (413, {"method": "POST", "path": REQUESTS, "body": "x" * 5000}),
    "a request that is none": (400, {"method": "POST", "path": REQUESTS, "body": UNKNOWN.body}),
    "a form in place of JSON": (
        415,
        {"method": "POST", "path": REQUESTS, "body": "kind=stop", "headers": {"Content-Type": "text/plain"}},
    ),
}


class TestRun:
    def test_engaged_camera_turns_to_the_boat_and_to_one_that_is_selected_again(
        self, station: Station
    ) -> None:
        """First of all: the boat leaves a camera that rests."""
        page = station.page
        page.follow_boat()
        began = time.monotonic()
        page.click("engage")
        page.wait(lambda data: data["mode"] in ("servoing", "holding"), "the engagement")
        # A boat that is left outside of the ellipse may leave the picture before the next box is drawn. A
        # busy machine may lose it.
        for _ in range(ATTEMPTS):
            if is_inside(
                station.program.wait(
                    lambda status: is_inside(status) or status["track"]["state"] == "lost",
                    "the boat in the ellipse",
                )
            ):
                break
            page.click("disengage")
            page.select_boat()
            page.click("engage")
        else:
            pytest.fail(f"the boat was lost {ATTEMPTS} times before the camera had it in the ellipse")
        station.emulator.wait_for(lambda row: row.moves, "a rate at the ground station", began)
        page.click("deselect")
        page.wait(lambda data: (data["mode"], data["track"]) == ("holding", "unseeded"), "nothing followed")
        page.select_boat()
        page.wait_for_mode("servoing")
        page.click("disengage")

    @pytest.mark.parametrize("name", REFUSED)
    def test_server_refuses(self, station: Station, name: str) -> None:
        code, options = REFUSED[name]
        assert station.program.ask(**{"method": "GET", "path": "/api/v1/status", **options})[0] == code

    def test_page_itself_needs_no_token(self, station: Station) -> None:
        code, body, _ = station.program.ask("GET", "/", token=None)
        assert code == 200
        assert b"<title>Barrelman" in body

    def test_page_cannot_be_embedded_and_runs_its_own_scripts_alone(self, station: Station) -> None:
        headers = station.program.ask("GET", "/", token=None)[2]
        policy = headers["Content-Security-Policy"]
        assert "frame-ancestors 'none'" in policy
        assert "unsafe-inline" not in policy
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"

    def test_metrics_are_for_prometheus(self, station: Station) -> None:
        code, body, _ = station.program.ask("GET", "/metrics")
        assert code == 200
        assert b"# TYPE barrelman_p gauge" in body or b"barrelman_steps_total" in body

    def test_healthz_needs_no_token(self, station: Station) -> None:
        assert station.program.ask("GET", "/healthz", token=None)[1] == b"ok\n"

    def test_received_stream_is_drawn_by_webcodecs(self, station: Station) -> None:
        # The first pictures may come before the first H.264 unit.
        station.page.wait(lambda data: data["path"] == "h264", "H.264")

    def test_token_is_gone_from_the_address(self, station: Station) -> None:
        assert "token" not in station.page.driver.current_url

    @pytest.mark.parametrize(("change", "reason"), REASONS)
    def test_camera_can_be_turned_by_hand_where_commands_reach_it_only(
        self, station: Station, change: dict[str, Any], reason: str | None
    ) -> None:
        turns = {
            "mode": {"name": "idle"},
            "link": {"state": "up", "in_control": True, "flight": "flying"},
            "video": {"state": "up"},
            "alarms": [],
        }
        script = """
            const [state, done] = arguments;
            const files = [import("/console/nudge_obstacle.js"), import("/console/words.en.js")];
            Promise.all(files).then(([{ nudgeObstacle }, words]) => {
              const key = nudgeObstacle(state);
              done([key, key === null || key in words.default.reasons]);
            }, (error) => done([String(error), false]));"""
        assert station.page.driver.execute_async_script(script, {**turns, **change}) == [reason, True]

    def test_watcher_may_stop_and_nothing_else(
        self, station: Station, folder: pathlib.Path, check: Check
    ) -> None:
        program = station.program
        with Page(program.watch_url, folder, "watch") as watcher:
            watcher.ready()
            script = """
                const commands = ['engage', 'disengage', 'law', 'nudge-up'];
                return commands.every((id) => document.getElementById(id).disabled)"""
            check(
                "a page with the watch link cannot command",
                watcher.script(script) and watcher.data["controlling"] == "no",
                watcher.text("seat"),
            )
            answer = program.request(ENGAGE, token=program.watch_token)
            check("its token is refused a command", answer["answer"] == "refused", answer)
            watcher.click("stop")
            station.page.wait_for_mode("stopped")

            def may_ask() -> Any:
                return watcher.script("""
                    const ask = document.getElementById('ask-control');
                    return ask.checkVisibility() && !ask.disabled""")

            # The address differs in what stands behind #, so that the browser by itself loads nothing.
            check("it may not ask for the control", not may_ask())
            watcher.driver.get(program.url)
            wait_until(may_ask, "the page with the control link in the watcher's tab")

    def test_control_is_asked_for_and_given_and_taken(
        self, station: Station, folder: pathlib.Path, check: Check
    ) -> None:
        page = station.page
        page.disengage()
        with started(station.program, folder, "other") as other:
            check(
                "a second control page does not control by itself",
                other.data["controlling"] == "no",
                other.text("seat"),
            )
            other.click("ask-control")
            wait_until(lambda: page.driver.find_elements(By.CSS_SELECTOR, "[data-give]"), "the question")
            page.driver.find_element(By.CSS_SELECTOR, "[data-give]").click()
            other.wait(lambda data: data["controlling"] == "yes", "the control")
            page.wait(lambda data: data["controlling"] == "no", "the change")
            page.click("take-control")
            before = int(page.data["stops"])
            page.click("stop")
            page.wait(lambda data: int(data["stops"]) > before, "the stop")
            check(
                "Stop is taken while a question is open",
                page.script("return document.getElementById('take-dialog').open"),
            )
            page.driver.find_element(By.CSS_SELECTOR, "#take-dialog button[value=take]").click()
            page.wait(lambda data: data["controlling"] == "yes", "the control")
            other.wait(lambda data: data["controlling"] == "no", "the notice")
            told = other.text("toast")
            check("the other page is told", "took the control" in told, told)

    def test_reload_keeps_the_control(self, station: Station) -> None:
        station.page.driver.refresh()
        station.page.ready()
        station.page.wait(lambda data: data["controlling"] == "yes", "the control")

    def test_jpeg_is_drawn_where_it_is_asked_for(self, station: Station, folder: pathlib.Path) -> None:
        with started(station.program, folder, "jpeg", "?video=jpeg") as jpeg:
            assert jpeg.data["path"] == "jpeg"

    def test_recording_replays_bit_for_bit_with_every_request(
        self, barrelman: pathlib.Path, station: Station, check: Check
    ) -> None:
        station.ends_well(barrelman, check)


class TestRates:
    """A run of its own, whose world is at its start."""

    def test_stop_among_200_requests_rests_the_camera(self, station: Station, check: Check) -> None:
        """While the camera turns, at the ground station."""
        page, delays = station.page, []
        fire = """
            const law = document.getElementById('law');
            for (let i = 0; i < 200; i++) {
              law.value = i % 2 ? 'eco' : 'minimum-energy';
              law.dispatchEvent(new Event('change'));
              if (i === 100) document.getElementById('stop').click();
            }"""
        for number in range(STOPS_AMONG_REQUESTS):
            # To and fro, so that the boat stays in view.
            key = "ad"[number % 2]
            station.nudged(key)
            moment = time.monotonic()
            page.script(fire)
            page.wait_for_mode("stopped")
            delays.append(station.zeros_after(moment))
            page.release(key)
            # The limit of requests fills again.
            time.sleep(0.6)
        delays.sort(key=lambda delay: delay.seconds)
        check.in_time("the median is small", delays[len(delays) // 2], 0.15)
        check.in_time("the worst is small", delays[-1], 0.35)

    def test_cable_that_is_pulled_is_told_and_comes_back(self, station: Station) -> None:
        station.emulator.close()
        station.page.wait(lambda data: data["next"] in ("link", "video"), "the alarm")
        station.put_back()
        station.page.wait(lambda data: data["link"] == "up", "the link")
        station.page.wait(lambda data: data["next"] in ("select", "reselect", "stopped"), "the video")

    def test_page_that_is_killed_during_a_nudge_rests_the_camera(self, station: Station) -> None:
        station.nudged("d")
        processes = run(["pgrep", "-f", station.page.profile]).stdout.split()
        moment = time.monotonic()
        for process in processes:
            with contextlib.suppress(ProcessLookupError):
                os.kill(int(process), signal.SIGKILL)
        station.zeros_after(moment).judge(0.35)

    def test_recording_replays_bit_for_bit_with_every_request(
        self, barrelman: pathlib.Path, station: Station, check: Check
    ) -> None:
        # The seat of a page that is gone is kept for two seconds.
        time.sleep(2.5)
        station.ends_well(barrelman, check)
