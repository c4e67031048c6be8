"""Tests the boat that is commanded from the console: marks, guidance, driving by hand, and every way to stop it.

In the simulated world `rescue`, the script selects the boat in headless Chromium, marks the person that it sees, and lets
the boat go there. The boat must wait before the stand-off. Stop, "stop boat", a helm that is let go and a page that is
closed must make the boat neutral. The recording must replay to the bit.
"""
import pathlib
import sys
import time

import common
from common import Recording, Table
from console_page import Page, Program, find_red

SIZE = "960x540"
#: Distance that the boat keeps from its person, metres.
STAND_OFF_M = 2.0


def tap(page, at, size):
    """Taps a point of the picture."""
    (x, y), _ = page.picture_box([*at, 0, 0], size)
    from selenium.webdriver.common.actions.action_builder import ActionBuilder

    builder = ActionBuilder(page.driver, duration=20)
    builder.pointer_action.move_to_location(x, y).pointer_down().pointer_up()
    builder.perform()


def mark(page, program, kind, at, size):
    """Marks a point, and waits until the program has the mark."""
    before = len(program.status()["vessel"]["marks"])
    page.driver.execute_script("document.getElementById('mark-kind').value = arguments[0]", kind)
    page.click("mark")
    tap(page, at, size)
    status = program.wait(lambda status: len(status["vessel"]["marks"]) > before, 5, f"the mark {kind}")
    return status["vessel"]["marks"][-1]


def person_at(program):
    """A point of the water to which the boat has a way to go: to the side of the boat, in the picture."""
    status = program.status()
    u, v = status["track"]["centre"]
    width, height = status["video"]["size"]
    return [width - u if abs(width / 2 - u) > width / 6 else u + width / 4, min(0.8 * height, v + 0.12 * height)]


def boat(program):
    return program.status()["vessel"]


def neutral_within(table, program, what, begin, seconds):
    """Requires that the boat is neutral soon after `begin`."""
    start = time.monotonic()
    begin()
    while True:
        vessel = boat(program)
        if vessel["throttle"] == 0 and vessel["rudder"] == 0:
            break
        if time.monotonic() - start > seconds + 5:
            break
        time.sleep(0.02)
    taken = time.monotonic() - start
    table.require(what, taken <= seconds, f"{taken:.2f} s: {vessel['text']}", f"at most {seconds} s")


def to_the_person(table, args, folder):
    store, record = folder / "vessel.jsonl", folder / "vessel.mcap"
    program = Program(args, "demo", "rescue", "--size", SIZE, "--hands-on", "--store", store, "--record", record)
    page = Page(program.url, folder)
    page.ready()
    vessel = boat(program)
    table.require("before anything is asked, the boat is not commanded", vessel["mode"] == "released" and vessel["throttle"] == 0, vessel["text"])
    answer = program.request("guide")
    table.require("a program without a page cannot let the boat go", answer["answer"] == "refused", answer["reason"])
    refused = page.driver.execute_script("return document.getElementById('guide').disabled")
    table.require("without a mark, Go is not offered", refused)
    common.wait_until(lambda: find_red(page, folder)[0], 30, "a red boat in the picture")
    box, size = find_red(page, folder)
    page.drag(box, size)
    page.wait(lambda data: data["track"] == "tracking", 15, "the track")
    page.click("engage")
    program.wait(lambda status: status["mode"]["engaged"], 5, "the camera to follow")

    person = mark(page, program, "person", person_at(program), size)
    table.require("a person is marked in the picture: the destination, with distances", person["destination"] and person["water_m"] and len(person["ring"]) > 10, f"{person['kind']} {person['id']} at {person['water_m'][0]:.1f}, {person['water_m'][1]:.1f} m")
    page.wait_until_enabled("guide")
    page.click("guide")
    going = program.wait(lambda status: status["vessel"]["mode"] == "guided" and status["vessel"]["throttle"] > 0, 5, "the boat to go")
    table.require("Go: the boat goes by itself, over the water", going["vessel"]["basis"] == "water", going["vessel"]["text"])
    if args.screenshot:
        time.sleep(2)
        page.screenshot(pathlib.Path(args.screenshot))
    moved = [mark_["at"] for mark_ in going["vessel"]["marks"]]
    nearest = [float("inf")]

    def arrived(status):
        progress = status["vessel"]["progress"]
        if progress:
            nearest[0] = min(nearest[0], progress["distance_m"])
        return status["vessel"]["guidance"] == "standing-off" and progress["speed_m_per_s"] < 0.5

    status = program.wait(arrived, 60, "the boat before the person")
    table.require("the boat waits before the person", STAND_OFF_M <= status["vessel"]["progress"]["distance_m"] <= 6, f"{status['vessel']['progress']['distance_m']:.1f} m away", f"{STAND_OFF_M} to 6 m")
    table.require("and came no nearer than the stand-off", nearest[0] >= STAND_OFF_M, f"{nearest[0]:.1f} m", f"at least {STAND_OFF_M} m")
    now = status["vessel"]["marks"][0]["at"]
    shift = max(abs(a - b) for a, b in zip(moved[0], now))
    table.show("the mark in the picture, as the camera followed the boat", f"moved by {shift:.0f} px")
    if args.screenshot:
        name = pathlib.Path(args.screenshot)
        page.screenshot(name.with_stem(f"{name.stem}-arrived"))

    page.click("stop-boat")
    status = program.wait(lambda status: status["vessel"]["mode"] == "stopped", 5, "the boat's stop")
    table.require("stop boat: the boat alone is stopped", status["mode"]["engaged"] and status["vessel"]["throttle"] == 0, f"boat {status['vessel']['text']}, camera {status['mode']['name']}")

    page.press("up")
    status = program.wait(lambda status: status["vessel"]["mode"] == "by-hand" and status["vessel"]["throttle"] > 0.5, 5, "the hand at the helm")
    table.require("arrow up, held: the boat is driven by hand", True, f"throttle {status['vessel']['throttle']:.2f}")
    # The key is still held: Stop must hold against it.
    neutral_within(table, program, "Stop, with the key still down: the boat is neutral", lambda: page.type("space"), 0.5)
    time.sleep(0.6)
    status = program.status()
    table.require("and stays neutral while the key is down", status["vessel"]["mode"] == "stopped" and status["vessel"]["throttle"] == 0 and status["mode"]["name"] == "stopped", f"boat {status['vessel']['text']}, camera {status['mode']['name']}")
    page.release("up")

    page.wait_until_enabled("engage")
    page.click("engage")
    place = mark(page, program, "place", person_at(program), size)
    page.wait_until_enabled("next-mark")
    page.click("next-mark")
    program.wait(lambda status: any(m["id"] == place["id"] and m["destination"] for m in status["vessel"]["marks"]), 5, "the place as the destination")
    page.click("guide")
    program.wait(lambda status: status["vessel"]["mode"] == "guided" and status["vessel"]["throttle"] > 0, 10, "the boat to go to the place")
    neutral_within(table, program, "the page is closed while the boat goes: the boat is neutral", page.end, 1.3 + common.SLACK_S if hasattr(common, "SLACK_S") else 3.0)
    status = program.status()
    table.require("the camera stays engaged", status["mode"]["engaged"], f"boat {status['vessel']['text']}, camera {status['mode']['name']}")

    code = program.end()
    table.require("Ctrl-C ends it with exit 0", code == 0, f"exit {code}")
    driven = common.run([args.barrelman, "demo", "--replay", store], timeout=300)
    table.require("the drive runs again bit for bit", driven.returncode == 0 and "bit for bit" in driven.stdout, driven.stdout.splitlines()[0] if driven.stdout else driven.stderr)
    replayed = common.run([args.barrelman, "replay", record, "--compare"], timeout=300)
    table.require("its recording replays bit for bit", replayed.returncode == 0 and "bit for bit" in replayed.stdout, replayed.stdout.splitlines()[0] if replayed.stdout else replayed.stderr)
    outcomes = [outcome for outcome in Recording(record).outcomes if outcome.HasField("vessel")]
    table.require("the recording holds what the boat did", any(outcome.vessel.throttle > 0 for outcome in outcomes), f"{len(outcomes)} outcomes")


def main():
    args = common.arguments(__doc__, screenshot={"metavar": "FILE.png", "help": "keep pictures of the page in Chromium here"})
    table = Table("The boat, commanded from the console")
    to_the_person(table, args, common.temporary_folder())
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
