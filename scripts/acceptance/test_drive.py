"""Drives and simulated worlds: the demo's console, a stored drive that is repeated, a world as video and
link.

The arrow keys steer the boat in headless Chromium. The boat must leave the ellipse, and the camera must bring
the boat back. A repeated drive must be equal bit for bit. A simulated world must serve `run` as a vehicle
does: through `--link sim:`, and through an emulated ground station with its protocol and with video over
RTSP.
"""

import pathlib
import re
import signal
import time
from typing import Any

import pytest

from client import Program
from conftest import Check
from drives import repeats
from emulator import Emulator, busiest_second
from page import Page, started
from process import Lines, end, spawn
from recording import Recording

pytestmark = pytest.mark.apart

SIZE = "480x270"
SECONDS = 12.0


def p_of(status: Any) -> float:
    """P of a status; 0 if the position of the boat is not known."""
    return float((status["percept"] or {}).get("p", 0.0))


def test_drive_by_the_keys_leaves_the_ellipse_and_the_camera_brings_the_boat_back(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    """With the paper's law, which waits until the boat has left the ellipse; the optimal law prevents
    that."""
    store, record = tmp_path / "drive.jsonl", tmp_path / "drive.mcap"
    program = Program(
        barrelman, "demo", "open", "--size", SIZE, "--law", "schema", "--store", store, "--record", record
    )
    program.wait_for_track()

    def boat(condition: Any, what: str) -> Any:
        """The state once the condition holds for the boat's throttle and rudder."""
        return program.wait(lambda status: condition(status["vessel"]), what)

    with started(program, tmp_path) as page:
        # The first pictures may come before the first H.264 unit. A drive that is recorded is drawn by
        # WebCodecs.
        page.wait(lambda data: data["path"] == "h264", "H.264")
        page.press("up")
        boat(lambda boat: boat["throttle"] > 0, "throttle")
        # The state of the world is published apart from that of the boat.
        state = program.wait(lambda status: status["drive"]["helm"] == "page", "the page's helm")
        check(
            "arrow up, held: throttle, and the rudder amidships",
            state["vessel"]["throttle"] > 0 and state["vessel"]["rudder"] == 0,
            state,
        )
        for key, sign in (("left", -1), ("right", 1)):
            page.press(key)
            state = boat(lambda boat: boat["rudder"] != 0, "rudder")["vessel"]
            check(
                f"arrow {key}: the rudder, to {key}",
                state["rudder"] * sign > 0 and state["throttle"] > 0,
                state,
            )
            page.release(key)
            boat(lambda boat: boat["rudder"] == 0, "a rudder amidships")
        program.wait(lambda status: p_of(status) > 1.05, "an excursion")
        page.screenshot(pytestconfig.getoption("--screenshots"), "drive")
        page.release("up")
        state = boat(lambda boat: boat["throttle"] == 0, "a neutral helm")
        check(
            "keys let go: the helm is neutral, and still the page's", state["drive"]["helm"] == "page", state
        )
        program.wait(lambda status: any(status["command"].values()), "a rate")
        program.wait(lambda status: 0 < p_of(status) < 1, "the boat in the ellipse")
        page.press("up")
        boat(lambda boat: boat["throttle"] > 0, "throttle")
    # The page is closed with the key down.
    boat(lambda boat: boat["throttle"] == 0, "a neutral helm")
    # The seat of a page that is gone is kept for two seconds.
    time.sleep(2.5)
    with started(program, tmp_path, "again") as page:
        pause_and_stop(program, page, check)
    check("Ctrl-C ends it with exit 0", program.end() == 0)
    repeats(barrelman, check, store, record)


def pause_and_stop(program: Program, page: Page, check: Check) -> None:
    page.wait(lambda data: data["controlling"] == "yes", "the control")
    page.type("p")
    still = program.wait(lambda status: status["drive"]["paused"], "the pause")["drive"]["tick"]
    time.sleep(0.3)
    check("p: the time stands still", program.status()["drive"]["tick"] == still)
    page.type("p")
    program.wait(lambda status: not status["drive"]["paused"], "the end of the pause")
    page.type("space")
    stopped = program.wait(lambda status: not status["mode"]["engaged"], "the stop")
    check("space: the camera is stopped", not any(stopped["command"].values()), stopped["command"])
    # The page offers Engage when it has shown the stop; until then the key does nothing.
    page.wait_until_enabled("engage")
    page.type("h")
    page.type("e")
    program.wait(
        lambda status: status["mode"]["engaged"] and status["drive"]["helm"] == "helmsman", "the helmsman"
    )
    complaints = page.complaints()
    check("the browser has nothing to complain about", not complaints, complaints)


def test_law_is_the_optimal_one_unless_another_is_named(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    store, record = tmp_path / "default.jsonl", tmp_path / "default.mcap"
    with Program(
        barrelman, "demo", "arena1", "--size", SIZE, "--store", store, "--record", record
    ) as program:
        moved = program.wait(lambda status: any(status["command"].values()), "a movement of the camera")
        check("one movement for each excursion", moved["law"] == "intermittent", moved["law"])
        check(
            "and beside it P as the schema would have kept it",
            isinstance(moved["work"]["schema_p"], float),
            moved["work"],
        )
    repeats(barrelman, check, store, record)


def run_for_a_while(barrelman: pathlib.Path, *options: Any) -> Lines:
    """Runs for SECONDS after the selection, requires exit code 0 and returns the log."""
    child = spawn([barrelman, "run", "--headless", "--engage", *options])
    errors = Lines(child.stderr)
    errors.wait_for("following the selection")
    time.sleep(SECONDS)
    code = end(child, signal.SIGINT)
    assert code == 0, errors.text()[-300:]
    return errors


def is_kept_in_the_ellipse(record: pathlib.Path) -> bool:
    """Whether P <= 1 in most of the steps with a percept."""
    seen = [outcome.percept.p for outcome in Recording(record).outcomes if outcome.HasField("percept")]
    return bool(sum(p <= 1 for p in seen) > 0.5 * len(seen))


def test_world_keeps_the_boat_in_the_ellipse_as_link_and_through_real_bytes(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    record, bytes_record = tmp_path / "sim.mcap", tmp_path / "bytes.mcap"
    errors = run_for_a_while(
        barrelman, "--video", f"sim:arena1?size={SIZE}", "--link", "sim:", "--record", record
    )
    check("a world says where its boat is", errors.find("no --select"))
    check("--link sim: keeps the boat in the ellipse", is_kept_in_the_ellipse(record))
    repeats(barrelman, check, None, record)

    # The selection is read from the same world: the first picture is the same for the same seed.
    x, y, w, h = map(
        float, re.findall(r"-?\d+\.?\d*", errors.wait_for("no --select")[1].split("boat is, ")[1])[:4]
    )
    with Emulator(
        barrelman,
        tmp_path,
        "--world",
        f"sim:arena1?size={SIZE}",
        "--video-listen",
        "127.0.0.1:0",
        name="world",
    ) as emulator:
        select = f"{x - 4:.1f},{y - 4:.1f},{w + 8:.1f},{h + 8:.1f}"
        run_for_a_while(
            barrelman,
            "--video",
            emulator.video,
            "--link",
            emulator.url,
            "--select",
            select,
            "--record",
            bytes_record,
        )
        rows = emulator.rows()
    check("the real bytes keep the boat in the ellipse, too", is_kept_in_the_ellipse(bytes_record))
    # A movement of both axes may change both rates at every picture.
    busiest = busiest_second(rows)
    check("the busiest second has at most 20 lines with a rate", 0 < busiest <= 20, busiest)
