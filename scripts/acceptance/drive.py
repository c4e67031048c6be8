"""Tests drives and simulated worlds: the demo's console, a stored drive that is repeated, a world as video and link.

The script steers the boat with the arrow keys in headless Chromium. The boat must leave the ellipse, and the camera
must bring the boat back. A repeated drive must be equal bit for bit. A simulated world must serve `run` as a vehicle
does: through `--link sim:`, and through an emulated ground station with its protocol and with video over RTSP. The
number of pictures drawn in a second depends on the machine, so it is only shown.
"""
import pathlib
import signal
import subprocess
import sys
import time

import common
from common import Lines, Recording, Table
from console_page import Page, Program

SIZE = "480x270"


def again(table, args, store, record):
    """Repeats a stored drive, and replays its recording."""
    driven = common.run([args.barrelman, "demo", "--replay", store], timeout=300)
    table.require("the drive runs again bit for bit", driven.returncode == 0 and "bit for bit" in driven.stdout, driven.stdout.splitlines()[0] if driven.stdout else driven.stderr)
    replayed = common.run([args.barrelman, "replay", record, "--compare"], timeout=300)
    table.require("its recording replays bit for bit", replayed.returncode == 0 and "bit for bit" in replayed.stdout, replayed.stdout.splitlines()[0] if replayed.stdout else replayed.stderr)


def drive(table, args, folder):
    """Drives with the paper's law, which waits until the boat has left the ellipse; the optimal law prevents that."""
    store, record = folder / "drive.jsonl", folder / "drive.mcap"
    program = Program(args, "demo", "open", "--size", SIZE, "--law", "schema", "--store", store, "--record", record)
    program.wait(lambda status: status["track"]["state"] == "tracking", 10, "the track")
    page = Page(program.url, folder)
    page.ready()
    # The first pictures may come before the first H.264 unit.
    data = page.wait(lambda data: data["path"] == "h264", 10, "H.264")
    table.require("a drive that is recorded is drawn by WebCodecs", True, data["path"])

    page.press("up")
    state = program.wait(lambda status: status["drive"]["thrust"] > 0, 5, "thrust")["drive"]
    table.require("arrow up, held: thrust, and the page has the helm", state["helm"] == "page" and state["rudder"] == 0, f"thrust {state['thrust']:+.1f}, rudder {state['rudder']:+.1f}")
    for key, sign in (("left", 1), ("right", -1)):
        page.press(key)
        state = program.wait(lambda status: status["drive"]["rudder"] != 0, 5, "rudder")["drive"]
        table.require(f"arrow {key}: the rudder, to {key}", state["rudder"] * sign > 0 and state["thrust"] > 0, f"thrust {state['thrust']:+.1f}, rudder {state['rudder']:+.1f}")
        page.release(key)
        program.wait(lambda status: status["drive"]["rudder"] == 0, 5, "a rudder amidships")
    out = program.wait(lambda status: p_of(status) > 1.05, 60, "an excursion")
    table.require("the boat leaves the ellipse", True, f"P {p_of(out):.2f}, {out['drive']['speed_m_per_s']:.1f} m/s, {out['drive']['helm']} at the helm")
    if args.screenshot:
        page.screenshot(pathlib.Path(args.screenshot))
    page.release("up")
    state = program.wait(lambda status: status["drive"]["thrust"] == 0, 5, "a neutral helm")["drive"]
    table.require("keys let go: the helm is neutral, and still the page's", state["helm"] == "page")
    moved = program.wait(lambda status: any(status["command"].values()), 5, "a rate")
    table.require("the camera moves", True, f"pan {moved['command']['pan']:+.2f}, tilt {moved['command']['tilt']:+.2f} rad/s, P {p_of(moved):.2f}")
    back = program.wait(lambda status: 0 < p_of(status) < 1, 30, "the boat in the ellipse")
    table.require("and brings the boat back", True, f"P {p_of(back):.2f} after {back['drive']['time_s'] - out['drive']['time_s']:.1f} s")

    page.press("up")
    program.wait(lambda status: status["drive"]["thrust"] > 0, 5, "thrust")
    page.end()
    program.wait(lambda status: status["drive"]["thrust"] == 0, 5, "a neutral helm")
    table.require("the page is closed with the key down: the helm goes back to neutral", True)
    # The seat of a page that is gone is kept for two seconds.
    time.sleep(2.5)

    page = Page(program.url, folder)
    page.ready()
    page.wait(lambda data: data["controlling"] == "yes", 5, "the control")
    page.type("p")
    common.wait_until(lambda: program.status()["drive"]["paused"], 5, "the pause")
    still = program.status()["drive"]["tick"]
    time.sleep(0.3)
    table.require("p: the time stands still", program.status()["drive"]["tick"] == still)
    page.type("p")
    common.wait_until(lambda: not program.status()["drive"]["paused"], 5, "the end of the pause")
    page.type("space")
    stopped = program.wait(lambda status: not status["mode"]["engaged"], 5, "the stop")
    table.require("space: the camera is stopped", not any(stopped["command"].values()), stopped["mode"]["name"])
    # The page offers Engage when it has shown the stop; until then the key does nothing.
    page.wait_until_enabled("engage")
    page.type("h")
    page.type("e")
    program.wait(lambda status: status["mode"]["engaged"] and status["drive"]["helm"] == "helmsman", 5, "the helmsman")
    complaints = page.complaints()
    table.require("the browser has nothing to complain about", not complaints, "; ".join(complaints)[:200])
    page.end()

    pace = program.status()["drive"]["pace"]
    code = program.end()
    table.require("Ctrl-C ends it with exit 0", code == 0, f"exit {code}")
    table.show("simulated seconds in each second", f"{pace:.2f}", f"at {SIZE}, with a recording")
    again(table, args, store, record)


def p_of(status):
    """P of a status; 0 if the position of the boat is not known."""
    return (status["percept"] or {}).get("p", 0.0)


def drive_by_default(table, args, folder):
    """Lets the boat steer itself, with the law that is the default."""
    store, record = folder / "default.jsonl", folder / "default.mcap"
    program = Program(args, "demo", "arena1", "--size", SIZE, "--store", store, "--record", record)
    moved = program.wait(lambda status: any(status["command"].values()), 60, "a movement of the camera")
    command = moved["command"]
    table.require("unless another is named: the optimal law, one movement for each excursion", moved["law"] == "intermittent", f"pan {command['pan']:+.3f}, tilt {command['tilt']:+.3f} rad/s after {moved['drive']['time_s']:.1f} s, P {p_of(moved):.2f}")
    beside = moved["work"]["schema_p"]
    table.require("and beside it P as the schema would have kept it", isinstance(beside, float), f"{beside:.2f}")
    program.end()
    again(table, args, store, record)


def share_inside(record):
    """Share of the steps with a percept in which P <= 1, and the number of steps with a percept."""
    seen = [outcome.percept.p for outcome in Recording(record).outcomes if outcome.HasField("percept")]
    return (sum(p <= 1 for p in seen) / len(seen) if seen else 0.0), len(seen)


def run_for(table, args, seconds, name, *options):
    """Runs `run` for this number of seconds after the selection, requires exit code 0 and returns the log."""
    child = common.spawn([args.barrelman, "run", "--headless", "--engage", *options], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    errors = Lines(child.stderr)
    errors.wait_for("following the selection", 30)
    time.sleep(seconds)
    child.send_signal(signal.SIGINT)
    code = child.wait(timeout=15)
    table.require(f"{name}: SIGINT ends it with exit 0", code == 0, f"exit {code}", "" if code == 0 else errors.text()[-300:])
    return errors


def worlds(table, args, folder):
    record = folder / "sim.mcap"
    errors = run_for(table, args, args.seconds, "--link sim:", "--video", f"sim:arena1?size={SIZE}", "--link", "sim:", "--record", record)
    table.require("a world says where its boat is", "no --select" in errors.text())
    inside, steps = share_inside(record)
    table.require("--link sim: keeps the boat in the ellipse", inside > 0.5, f"{inside:.0%} of {steps} steps", "more than half")
    replayed = common.run([args.barrelman, "replay", record, "--compare"], timeout=300)
    table.require("its recording replays bit for bit", replayed.returncode == 0 and "bit for bit" in replayed.stdout, replayed.stdout.splitlines()[0] if replayed.stdout else replayed.stderr)

    # The selection is read from the same world: the first picture is the same for the same seed.
    box = next(line for _, line in errors.lines if "no --select" in line).split("boat is, ")[1]
    numbers = [float(word) for word in "".join(c if c in "0123456789.-" else " " for c in box).split()][:4]
    record = folder / "bytes.mcap"
    options = ["--world", f"sim:arena1?size={SIZE}", "--video-listen", "127.0.0.1:0"]
    with common.Emulator(args.barrelman, folder, "world", *options) as emulator:
        _, line = emulator.lines.wait_for("rtsp://", 10)
        url = next(word for word in line.split() if word.startswith("rtsp://")).rstrip(";")
        select = ",".join(f"{value:.1f}" for value in (numbers[0] - 4, numbers[1] - 4, numbers[2] + 8, numbers[3] + 8))
        run_for(table, args, args.seconds, "the real bytes", "--video", url, "--link", emulator.url, "--select", select, "--record", record)
        rows = emulator.rows()
    inside, steps = share_inside(record)
    table.require("the real bytes keep the boat in the ellipse, too", inside > 0.5, f"{inside:.0%} of {steps} steps", "more than half")
    # A movement of both axes may change both rates at every picture.
    busiest = common.busiest_second(rows)
    table.require("rates that the ground station heard in the busiest second", 0 < busiest <= 20, f"{busiest}, {sum(row.moves for row in rows)} in all", "at most 20")


def main():
    args = common.arguments(__doc__, seconds={"type": float, "default": 12.0, "help": "how long each run lasts"}, screenshot={"metavar": "FILE.png", "help": "keep a picture of the page in Chromium here"})
    folder = common.temporary_folder()
    table = Table("A boat to drive, and simulated worlds")
    drive(table, args, folder)
    drive_by_default(table, args, folder)
    worlds(table, args, folder)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
