"""The boat that is commanded from the console: marks, guidance, driving by hand, and every way to stop it.

In the simulated world `rescue`, the boat is selected in headless Chromium, a person is marked in the picture,
and the boat goes there. The boat must wait before the stand-off. Stop, "stop boat", a helm that is let go and
a page that is closed must make the boat neutral. The recording must replay to the bit.

Then the laboratory's datagrams, heard by a receiver that knows nothing of Barrelman: their bytes, their rate,
and how long the boat goes on when the program is killed or hangs, or the page is closed. At last the emulated
boat is driven by hand through its own datagrams, seen in its own video.
"""

import itertools
import json
import os
import pathlib
import signal
import struct
import subprocess
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from boat import HOPS, NEUTRAL_WITHIN, Receiver, goes, going, mark, open_water
from client import GUIDE, PAUSE, Program
from conftest import Check
from drives import repeats
from emulator import url_in
from machine import Delay, took, wait_until
from page import Page, started
from process import ENDS_WITHIN, Lines, spawn
from recording import Recording

pytestmark = [pytest.mark.realtime, pytest.mark.clocked]

SIZE = "960x540"
#: Distance that the boat keeps from its person, metres.
STAND_OFF_M = 2.0
#: A page that is gone is noticed after a second.
GONE_WITHIN = 1.0


def neutral_after(program: Program, cause: Callable[[], Any]) -> Delay:
    """The time from a cause until the boat is neutral."""
    begin = time.monotonic()
    cause()
    program.wait(
        lambda status: status["vessel"]["throttle"] == 0 and status["vessel"]["rudder"] == 0,
        "the neutral boat",
    )
    return Delay.since(begin, HOPS)


def drag_mark(page: Page, program: Program, marked: Any) -> Any:
    """Drags a mark with the mouse. Returns the vessel before and after."""
    # Each picture is drawn with the marks that there were when it was processed: one that has the mark must
    # be shown first.
    captured_ns = program.status()["track"]["captured_ns"]
    page.wait(lambda data: int(data["captured"]) > captured_ns, "a picture with the mark")

    def of(status: Any) -> Any:
        return next(mark for mark in status["vessel"]["marks"] if mark["id"] == marked["id"])

    before = program.status()
    u, v = of(before)["at"]
    size = before["video"]["size"]
    # Towards the middle of the picture.
    page.drag([u, v, 40 if u < size[0] / 2 else -40, 0], size)
    after = program.wait(lambda status: of(status)["water_m"] != marked["water_m"], "the moved mark")
    return before["vessel"], after["vessel"]


def goes_to_a_person(program: Program, page: Page, check: Check, screenshots: pathlib.Path | None) -> None:
    size = program.status()["video"]["size"]
    person = mark(page, program, "person", open_water(program), size)
    check(
        "a marked person is the destination, with distances",
        person["destination"] and person["water_m"] and len(person["ring"]) > 10,
        person,
    )
    page.click_enabled("guide")
    going_to = goes(program)["vessel"]
    check("Go: the boat goes over the water", going_to["basis"] == "water", going_to["text"])
    page.screenshot(screenshots, "vessel")
    nearest = float("inf")

    def arrived(status: Any) -> bool:
        nonlocal nearest
        progress = status["vessel"]["progress"]
        assert status["vessel"]["mode"] != "stopped", status["vessel"]["text"]
        nearest = min(nearest, progress["distance_m"]) if progress else nearest
        return bool(status["vessel"]["guidance"] == "standing-off" and progress["speed_m_per_s"] < 0.5)

    distance = program.wait(arrived, "the boat before the person", 240)["vessel"]["progress"]["distance_m"]
    check("the boat waits before the person", STAND_OFF_M <= distance <= 6, f"{distance:.1f} m away")
    check("and came no nearer than the stand-off", nearest >= STAND_OFF_M, f"{nearest:.1f} m")
    page.screenshot(screenshots, "vessel-arrived")


def is_stopped_and_driven_by_hand(program: Program, page: Page, check: Check) -> None:
    page.click("stop-boat")
    status = program.wait(lambda status: status["vessel"]["mode"] == "stopped", "the boat's stop")
    check(
        "stop boat: the boat alone is stopped",
        status["mode"]["engaged"] and status["vessel"]["throttle"] == 0,
        status["vessel"]["text"],
    )

    page.press("up")
    program.wait(
        lambda status: status["vessel"]["mode"] == "by-hand" and status["vessel"]["throttle"] > 0.5,
        "the hand at the helm",
    )
    # The key is still held: Stop must hold against it.
    check.in_time(
        "Stop, with the key still down: the boat is neutral",
        neutral_after(program, lambda: page.type("space")),
        0.5,
    )
    time.sleep(0.6)
    status = program.status()
    is_stopped = (status["vessel"]["mode"], status["vessel"]["throttle"], status["mode"]["name"]) == (
        "stopped",
        0,
        "stopped",
    )
    check("and stays neutral while the key is down", is_stopped, status["vessel"]["text"])
    page.release("up")


def stops_without_its_page(program: Program, page: Page, check: Check) -> None:
    size = program.status()["video"]["size"]
    page.click_enabled("engage")
    place = mark(page, program, "place", open_water(program), size)
    before, after = drag_mark(page, program, place)
    check("a mark is dragged, and is the same mark", len(after["marks"]) == len(before["marks"]))
    page.click_enabled("next-mark")
    program.wait(
        lambda status: any(m["id"] == place["id"] and m["destination"] for m in status["vessel"]["marks"]),
        "the place as the destination",
    )
    page.click_enabled("guide")
    goes(program)
    gone = neutral_after(program, page.end)
    check.in_time(
        "the page is closed while the boat goes: the boat is neutral", gone, GONE_WITHIN + NEUTRAL_WITHIN
    )
    check("the camera stays engaged", program.status()["mode"]["engaged"])


def test_boat_goes_to_a_person_is_driven_by_hand_and_stops(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    store, record = tmp_path / "vessel.jsonl", tmp_path / "vessel.mcap"
    program = Program(
        barrelman, "demo", "rescue", "--size", SIZE, "--hands-on", "--store", store, "--record", record
    )
    # The boat drives away meanwhile on a busy machine, and is then smaller in the picture than a person.
    program.request(PAUSE)
    program.wait(lambda status: (status["drive"] or {}).get("paused"), "the pause")
    page = Page(program.url, tmp_path)
    page.wait(lambda data: data.get("connected") == "yes", "the page's connection")
    page.click_enabled("pause")
    page.ready()
    vessel = program.status()["vessel"]
    check(
        "before anything is asked, the boat is not commanded",
        (vessel["mode"], vessel["throttle"]) == ("released", 0),
        vessel["text"],
    )
    answer = program.request(GUIDE)
    check("a program without a page cannot let the boat go", answer["answer"] == "refused", answer)
    check(
        "without a mark, Go is not offered", page.script("return document.getElementById('guide').disabled")
    )
    page.select_boat()
    page.click("engage")
    program.wait(lambda status: status["mode"]["engaged"], "the camera to follow")

    goes_to_a_person(program, page, check, pytestconfig.getoption("--screenshots"))
    is_stopped_and_driven_by_hand(program, page, check)
    stops_without_its_page(program, page, check)
    check("Ctrl-C ends it with exit 0", program.end() == 0)
    repeats(barrelman, check, store, record)
    outcomes = [outcome for outcome in Recording(record).outcomes if outcome.HasField("vessel")]
    check(
        "the recording holds what the boat did",
        any(outcome.vessel.throttle > 0 for outcome in outcomes),
        f"{len(outcomes)} outcomes",
    )


class Laboratory(Receiver):
    """The laboratory's receiver, written from its description: two little-endian doubles, throttle and
    rudder."""

    def __init__(self) -> None:
        super().__init__()
        self.malformed = 0
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while True:
            datagram = self.socket.recv(64)
            if len(datagram) == 16:
                throttle, rudder = struct.unpack("<dd", datagram)
                self.heard.append((time.monotonic(), throttle, rudder))
            else:
                self.malformed += 1


def going_boat(barrelman: pathlib.Path, folder: pathlib.Path, receiver: Laboratory) -> tuple[Program, Page]:
    """A run with the boat under way to a place, over datagrams to the receiver."""
    vessel = ["--vessel", receiver.url, "--vessel-profile", "lab-udp"]
    program, page = going(
        barrelman, folder, "--video", "sim:rescue?size=640x360", "--link", "sim:", "--no-record", *vessel
    )
    page.click_enabled("guide")
    goes(program)
    time.sleep(0.5)
    return program, page


def test_datagrams_come_steadily_and_end_neutral(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    receiver = Laboratory()
    program, page = going_boat(barrelman, tmp_path, receiver)
    begin = time.monotonic()
    time.sleep(1.0)
    rows, until = receiver.since(begin), time.monotonic()
    gap = max(later[0] - earlier[0] for earlier, later in itertools.pairwise(rows))
    is_steady = len(rows) >= 15 * took(begin, until) and receiver.malformed == 0
    check(
        "the datagrams come at a steady rate",
        is_steady,
        f"{len(rows)} in a second, longest gap {1e3 * gap:.0f} ms",
    )
    check(
        "and carry throttle and rudder",
        all(0 <= throttle <= 0.6 and abs(rudder) <= 1 for _, throttle, rudder in rows),
        rows[-1],
    )
    begin = time.monotonic()
    page.type("space")
    time.sleep(1.0)
    moved, is_neutral = receiver.last_motion_after(begin)
    check("Stop: neutral on the wire", is_neutral)
    check.in_time("Stop: neutral in time", moved, NEUTRAL_WITHIN)
    page.click_enabled("guide")
    goes(program)
    begin = time.monotonic()
    page.end()
    time.sleep(2.5)
    moved, is_neutral = receiver.last_motion_after(begin)
    check("the page is closed: neutral on the wire", is_neutral)
    check.in_time("the page is closed: neutral in time", moved, GONE_WITHIN + NEUTRAL_WITHIN)
    check("Ctrl-C ends it with exit 0", program.end() == 0)


@pytest.mark.parametrize(
    ("number", "seconds"), [(signal.SIGKILL, 1.5), (signal.SIGSTOP, 3.0)], ids=["SIGKILL", "SIGSTOP"]
)
def test_guard_makes_the_boat_neutral_after(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, number: int, seconds: float
) -> None:
    receiver = Laboratory()
    program, page = going_boat(barrelman, tmp_path, receiver)
    begin = time.monotonic()
    os.kill(program.child.pid, number)
    time.sleep(seconds)
    moved, is_neutral = receiver.last_motion_after(begin)
    program.child.kill()
    page.end()
    assert is_neutral
    moved.judge(NEUTRAL_WITHIN)


def test_emulated_boat_is_driven_by_hand_in_its_own_video(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    log = tmp_path / "boat.jsonl"
    world = ["--world", "sim:rescue?size=640x360", "--video-listen", "127.0.0.1:0"]
    child = spawn(
        [barrelman, "emulate", "vessel", "--listen", "127.0.0.1:0", *world, "--log", log],
        stdout=subprocess.PIPE,
    )
    lines = Lines(child.stdout)
    url, port = url_in(lines.wait_for("rtsp://")[1]), lines.wait_for("datagrams at")[1].split()[-1]
    program = Program(
        barrelman, "run", "--video", url, "--no-record", "--vessel", port, "--vessel-profile", "lab-udp"
    )
    page = started(program, tmp_path)

    def rows() -> list[Any]:
        text = log.read_text()
        return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]

    page.press("up")
    program.wait(lambda status: status["vessel"]["mode"] == "by-hand", "the hand at the helm")
    # Without a track.
    wait_until(lambda: sum(row["throttle"] > 0.5 for row in rows()) > 10, "datagrams ahead")
    page.release("up")
    wait_until(lambda: rows()[-1]["throttle"] == 0, "the neutral boat")
    before = len(rows())
    page.end()
    check("Ctrl-C ends it with exit 0", program.end() == 0)
    time.sleep(0.8)
    check(
        "the end is neutral, several times",
        len(rows()) > before and all(row["throttle"] == 0 for row in rows()[-3:]),
    )
    child.send_signal(signal.SIGINT)
    check("the emulator ends with exit 0", child.wait(timeout=ENDS_WITHIN) == 0)
