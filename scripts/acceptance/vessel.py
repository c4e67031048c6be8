"""Tests the boat that is commanded from the console: marks, guidance, driving by hand, and every way to stop it.

In the simulated world `rescue`, the script selects the boat in headless Chromium, marks a person in the picture, and lets
the boat go there. The boat must wait before the stand-off. Stop, "stop boat", a helm that is let go and a page that is
closed must make the boat neutral. The recording must replay to the bit.

Then the laboratory's datagrams, heard by a receiver of this script that knows nothing of Barrelman: their bytes, their
rate, and how long the boat goes on when the program is killed or hangs, or the page is closed. At last the emulated boat
is driven by hand through its own datagrams, seen in its own video.
"""
import json
import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import threading
import time

import common
from common import Lines, Recording, Table
from console_page import Page, Program, select_boat
from selenium.webdriver.common.actions.action_builder import ActionBuilder

SIZE = "960x540"
#: What a loaded machine may take beyond a limit, seconds: the processes of the browser need the processor, too.
SLACK_S = 0.5
#: Distance that the boat keeps from its person, metres.
STAND_OFF_M = 2.0


def tap(page, at, size):
    """Taps a point of the picture."""
    (x, y), _ = page.picture_box([*at, 0, 0], size)
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


def drag_mark(table, page, program, marked, size):
    """Drags a mark with the mouse, and requires that it is the same mark elsewhere."""
    # Each picture is drawn with the marks that there were when it was processed: one that has the mark must be shown first.
    captured_ns = program.status()["track"]["captured_ns"]
    page.wait(lambda data: int(data["captured"]) > captured_ns, 10, "a picture with the mark")

    def of(status):
        return next(mark_ for mark_ in status["vessel"]["marks"] if mark_["id"] == marked["id"])

    before = program.status()
    u, v = of(before)["at"]
    # Towards the middle of the picture.
    page.drag([u, v, 40 if u < size[0] / 2 else -40, 0], size)
    status = program.wait(lambda status: of(status)["water_m"] != marked["water_m"], 5, "the moved mark")
    (x, y), count = of(status)["water_m"], len(before["vessel"]["marks"])
    table.require("a mark is dragged, and is the same mark", len(status["vessel"]["marks"]) == count, f"{marked['kind']} {marked['id']} to {x:.1f}, {y:.1f} m")


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
    # The boat drives away meanwhile on a busy machine, and is then smaller in the picture than a person.
    program.request("pause")
    program.wait(lambda status: (status["drive"] or {}).get("paused"), 5, "the pause")
    page = Page(program.url, folder)
    page.wait(lambda data: data.get("connected") == "yes", 30, "the page's connection")
    page.wait_until_enabled("pause")
    page.click("pause")
    page.ready()
    vessel = boat(program)
    table.require("before anything is asked, the boat is not commanded", vessel["mode"] == "released" and vessel["throttle"] == 0, vessel["text"])
    answer = program.request("guide")
    table.require("a program without a page cannot let the boat go", answer["answer"] == "refused", answer["reason"])
    refused = page.driver.execute_script("return document.getElementById('guide').disabled")
    table.require("without a mark, Go is not offered", refused)
    select_boat(table, page, folder)
    page.click("engage")
    program.wait(lambda status: status["mode"]["engaged"], 5, "the camera to follow")

    size = program.status()["video"]["size"]
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
    drag_mark(table, page, program, place, size)
    page.wait_until_enabled("next-mark")
    page.click("next-mark")
    program.wait(lambda status: any(m["id"] == place["id"] and m["destination"] for m in status["vessel"]["marks"]), 5, "the place as the destination")
    page.click("guide")
    program.wait(lambda status: status["vessel"]["mode"] == "guided" and status["vessel"]["throttle"] > 0, 10, "the boat to go to the place")
    neutral_within(table, program, "the page is closed while the boat goes: the boat is neutral", page.end, 1.3 + SLACK_S)
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


class Receiver:
    """The laboratory's receiver, written from its description: two little-endian doubles, throttle and rudder."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.heard = []
        self.malformed = 0
        threading.Thread(target=self._listen, daemon=True).start()

    @property
    def url(self):
        return f"udp://127.0.0.1:{self.socket.getsockname()[1]}"

    def _listen(self):
        while True:
            datagram = self.socket.recv(64)
            if len(datagram) == 16:
                self.heard.append((time.monotonic(), *struct.unpack("<dd", datagram)))
            else:
                self.malformed += 1

    def since(self, begin):
        return [row for row in list(self.heard) if row[0] >= begin]

    def last_motion_after(self, begin):
        """Seconds from `begin` to the last datagram that was not neutral, and whether a neutral one followed."""
        rows = self.since(begin)
        moving = [at for at, throttle, rudder in rows if throttle or rudder]
        return (moving[-1] - begin if moving else 0.0), bool(rows) and rows[-1][1:] == (0.0, 0.0)


def going_boat(args, folder, receiver, name):
    """A run with the boat under way to a place, over datagrams to the receiver."""
    program = Program(args, "run", "--video", "sim:rescue?size=640x360", "--link", "sim:", "--no-record", "--vessel", receiver.url, "--vessel-profile", "lab-udp")
    page = Page(program.url, folder, name)
    page.ready()
    page.wait(lambda data: data["track"] == "tracking", 15, "the track")
    size = program.status()["video"]["size"]
    mark(page, program, "place", person_at(program), size)
    page.wait_until_enabled("guide")
    page.click("guide")
    program.wait(lambda status: status["vessel"]["mode"] == "guided" and status["vessel"]["throttle"] > 0, 10, "the boat to go")
    time.sleep(0.5)
    return program, page


def datagrams(table, args, folder):
    receiver = Receiver()
    program, page = going_boat(args, folder, receiver, "going")
    begin = time.monotonic()
    time.sleep(1.0)
    rows = receiver.since(begin)
    gaps = [b[0] - a[0] for a, b in zip(rows, rows[1:])]
    table.require("the laboratory's datagrams come at a steady rate", len(rows) >= 15 and receiver.malformed == 0, f"{len(rows)} in a second, longest gap {1e3 * max(gaps):.0f} ms", "at least 15")
    vessel = boat(program)
    table.require("and carry throttle and rudder", all(0 <= row[1] <= 0.6 and abs(row[2]) <= 1 for row in rows), f"throttle {rows[-1][1]:.2f}, rudder {rows[-1][2]:+.2f}; {vessel['text']}, by {vessel['basis']}")
    begin = time.monotonic()
    page.type("space")
    time.sleep(1.0)
    moved, is_neutral = receiver.last_motion_after(begin)
    table.require("Stop: neutral on the wire", is_neutral and moved <= 0.3 + SLACK_S, f"{1e3 * moved:.0f} ms", f"at most 300 ms, and {1e3 * SLACK_S:.0f} of the machine")
    page.wait_until_enabled("guide")
    page.click("guide")
    program.wait(lambda status: status["vessel"]["mode"] == "guided" and status["vessel"]["throttle"] > 0, 10, "the boat to go again")
    begin = time.monotonic()
    page.end()
    time.sleep(2.5)
    moved, is_neutral = receiver.last_motion_after(begin)
    table.require("the page is closed: neutral on the wire", is_neutral and moved <= 1.3 + SLACK_S, f"{moved:.2f} s", f"at most 1.3 s, and {SLACK_S} of the machine")
    code = program.end()
    table.require("Ctrl-C ends it with exit 0", code == 0, f"exit {code}")

    for name, number, wait in (("SIGKILL", signal.SIGKILL, 1.5), ("SIGSTOP", signal.SIGSTOP, 3.0)):
        program, page = going_boat(args, folder, receiver, name)
        begin = time.monotonic()
        os.kill(program.child.pid, number)
        time.sleep(wait)
        moved, is_neutral = receiver.last_motion_after(begin)
        table.require(f"{name} of the program: the guard makes the boat neutral", is_neutral and moved <= 0.3 + SLACK_S, f"{1e3 * moved:.0f} ms", f"at most 300 ms, and {1e3 * SLACK_S:.0f} of the machine")
        program.child.kill()
        program.child.wait(timeout=10)
        page.end()


def emulated(table, args, folder):
    """The emulated boat, driven by hand through its datagrams."""
    log = folder / "boat.jsonl"
    command = [args.barrelman, "emulate", "vessel", "--listen", "127.0.0.1:0", "--world", "sim:rescue?size=640x360", "--video-listen", "127.0.0.1:0", "--log", log]
    child = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    lines = Lines(child.stdout)
    _, video = lines.wait_for("rtsp://", 20)
    _, port = lines.wait_for("datagrams at", 20)
    url = next(word for word in video.split() if word.startswith("rtsp://")).rstrip(";")
    program = Program(args, "run", "--video", url, "--no-record", "--vessel", port.split()[-1], "--vessel-profile", "lab-udp")
    page = Page(program.url, folder, "emulated")
    page.ready()
    page.press("up")
    program.wait(lambda status: status["vessel"]["mode"] == "by-hand", 5, "the hand at the helm")
    time.sleep(1.5)
    page.release("up")
    time.sleep(1.0)
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    ahead = [row for row in rows if row["throttle"] > 0.5]
    table.require("the emulated boat is driven by hand, without a track", len(ahead) > 10 and rows[-1]["throttle"] == 0, f"{len(ahead)} datagrams ahead, throttle channel up to {max(row['throttle_us'] for row in rows)} us, neutral at the end")
    before = len(rows)
    page.end()
    code = program.end()
    table.require("Ctrl-C ends it with exit 0", code == 0, f"exit {code}")
    time.sleep(0.8)
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    table.require("the end is neutral, several times", len(rows) > before and all(row["throttle"] == 0 for row in rows[-3:]))
    child.send_signal(signal.SIGINT)
    table.require("the emulator ends with exit 0", child.wait(timeout=15) == 0)


def main():
    args = common.arguments(__doc__, screenshot={"metavar": "FILE.png", "help": "keep pictures of the page in Chromium here"})
    folder = common.temporary_folder()
    table = Table("The boat, commanded from the console")
    to_the_person(table, args, folder)
    datagrams(table, args, folder)
    emulated(table, args, folder)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
