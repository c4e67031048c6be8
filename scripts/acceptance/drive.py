"""A boat to drive: the demo's page, a drive that is stored and driven again, and simulated worlds as video and link.

The boat is steered with the arrow keys in headless Chromium. What counts is that it leaves the ellipse and that the
camera brings it back, that a drive runs again bit for bit, and that a simulated world does for `run` what a vehicle does: through
`--link sim:`, and through the real bytes of an emulated ground station with the video over RTSP. How many pictures a
second are drawn is a matter of the machine, and only shown.
"""
import http.client
import json
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import common
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from common import Lines, Recording, Table

SIZE = "480x270"


class Demo:
    """A running demo, and its page."""

    def __init__(self, args, *options):
        command = [args.barrelman, "demo", "--listen", "127.0.0.1:0", "--size", SIZE, *options]
        self.child = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.lines, self.errors = Lines(self.child.stdout), Lines(self.child.stderr)
        _, line = self.lines.wait_for(r"http://", 20)
        self.host = line.split("http://")[1].rstrip("/")

    def ask(self, method, path, body=None, headers=None):
        """The status and the body of an answer."""
        connection = http.client.HTTPConnection(self.host, timeout=10)
        connection.request(method, path, None if body is None else json.dumps(body), headers or {})
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, content

    def status(self):
        return json.loads(self.ask("GET", "/status")[1])

    def helm(self, thrust, rudder):
        return self.ask("POST", "/helm", {"thrust": thrust, "rudder": rudder})[0]

    def do(self, what):
        return self.ask("POST", "/do", {"input": what})[0]

    def wait(self, condition, seconds, what, meanwhile=lambda: None):
        """Waits by the world's clock, which may be slower than ours."""
        first = self.status()
        while True:
            meanwhile()
            status = self.status()
            if condition(status):
                return status
            if status["time_s"] - first["time_s"] > seconds:
                raise TimeoutError(f"{what} did not come within {seconds} s: {status}")
            time.sleep(0.08)

    def end(self):
        self.child.send_signal(signal.SIGINT)
        return self.child.wait(timeout=30)


class Browser:
    """A page in headless Chromium."""

    KEYS = {"up": Keys.ARROW_UP, "left": Keys.ARROW_LEFT, "right": Keys.ARROW_RIGHT, "down": Keys.ARROW_DOWN, "p": "p", "space": Keys.SPACE, "h": "h", "e": "e"}

    def __init__(self, url, folder):
        options = webdriver.ChromeOptions()
        options.binary_location = installed("chromium", "google-chrome")
        for option in ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--window-size=1280,800", f"--user-data-dir={folder / 'chromium'}"):
            options.add_argument(option)
        # The live picture never ends: nothing waits for it.
        options.page_load_strategy = "eager"
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options, webdriver.ChromeService(installed("chromedriver")))
        self.driver.get(url)

    def press(self, name):
        ActionChains(self.driver).key_down(self.KEYS[name]).perform()

    def release(self, name):
        ActionChains(self.driver).key_up(self.KEYS[name]).perform()

    def type(self, name):
        self.press(name)
        self.release(name)

    def complaints(self):
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]

    def screenshot(self, path):
        self.driver.save_screenshot(str(path))

    def end(self):
        self.driver.quit()


def installed(*names):
    """A program's path."""
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        sys.exit(f"{names[0]} is not installed: scripts/setup.sh test installs it")
    return found


def page(table, demo):
    code, html = demo.ask("GET", "/")
    table.require("the page is one file", code == 200 and b"<title>Barrelman" in html and b"http://" not in html, f"{len(html)} bytes")
    code, jpeg = demo.ask("GET", "/picture.jpg")
    table.require("its pictures are JPEG", code == 200 and jpeg[:2] == b"\xff\xd8" and jpeg[-2:] == b"\xff\xd9", f"{len(jpeg)} bytes")
    refused = [
        ("a foreign name", demo.ask("GET", "/status", headers={"Host": "rebound.example"})[0], 403),
        ("a foreign page", demo.ask("POST", "/do", {"input": "stop"}, {"Origin": "http://evil.example"})[0], 403),
        ("a file", demo.ask("GET", "/../../etc/passwd")[0], 404),
        ("a helm beyond its stops", demo.helm(7, 0), 400),
        ("an unknown wish", demo.do("fly"), 400),
        ("a long body", demo.ask("POST", "/do", {"input": "x" * 4000})[0], 413),
    ]
    for name, code, wanted in refused:
        table.require(f"  {name} is refused", code == wanted, f"HTTP {code}", f"HTTP {wanted}")


def again(table, args, store, record):
    """Drives a stored drive again, and replays its recording."""
    driven = common.run([args.barrelman, "demo", "--replay", store], timeout=300)
    table.require("the drive runs again bit for bit", driven.returncode == 0 and "bit for bit" in driven.stdout, driven.stdout.splitlines()[0] if driven.stdout else driven.stderr)
    replayed = common.run([args.barrelman, "replay", record, "--compare"], timeout=300)
    table.require("its recording replays bit for bit", replayed.returncode == 0 and "bit for bit" in replayed.stdout, replayed.stdout.splitlines()[0] if replayed.stdout else replayed.stderr)


def drive(table, args, folder):
    """By the paper's law, which waits until the boat has left: the other sees to it that it does not."""
    store, record = folder / "drive.jsonl", folder / "drive.mcap"
    demo = Demo(args, "open", "--law", "schema", "--store", store, "--record", record)
    page(table, demo)
    demo.wait(lambda status: status["track"] == "tracking", 10, "the track")
    browser = Browser(f"http://{demo.host}/", folder)

    browser.press("up")
    helm = demo.wait(lambda status: status["thrust"] > 0, 5, "thrust")
    table.require("arrow up, held: thrust, and the page has the helm", helm["helm"] == "page" and helm["rudder"] == 0, f"thrust {helm['thrust']:+.1f}, rudder {helm['rudder']:+.1f}")
    for key, sign in (("left", 1), ("right", -1)):
        browser.press(key)
        helm = demo.wait(lambda status: status["rudder"] != 0, 5, "rudder")
        table.require(f"arrow {key}: the rudder, to {key}", helm["rudder"] * sign > 0 and helm["thrust"] > 0, f"thrust {helm['thrust']:+.1f}, rudder {helm['rudder']:+.1f}")
        browser.release(key)
        demo.wait(lambda status: status["rudder"] == 0, 5, "a rudder amidships")
    out = demo.wait(lambda status: (status["p"] or 0) > 1.05, 60, "an excursion")
    table.require("the boat leaves the ellipse", True, f"P {out['p']:.2f}, {out['speed_m_per_s']:.1f} m/s, {out['helm']} at the helm")
    if args.screenshot:
        browser.screenshot(pathlib.Path(args.screenshot))
    browser.release("up")
    rest = demo.wait(lambda status: status["thrust"] == 0, 5, "a neutral helm")
    table.require("keys let go: the helm is neutral, and still the page's", rest["helm"] == "page")
    moved = demo.wait(lambda status: abs(status["pan"]) + abs(status["tilt"]) > 0, 5, "a rate")
    table.require("the camera moves", True, f"pan {moved['pan']:+.2f}, tilt {moved['tilt']:+.2f} rad/s, P {moved['p']:.2f}")
    back = demo.wait(lambda status: status["p"] is not None and status["p"] < 1, 30, "the boat in the ellipse")
    table.require("and brings the boat back", True, f"P {back['p']:.2f} after {back['time_s'] - out['time_s']:.1f} s")

    browser.press("up")
    demo.wait(lambda status: status["thrust"] > 0, 5, "thrust")
    browser.driver.close()
    rest = demo.wait(lambda status: status["thrust"] == 0, 5, "a neutral helm")
    table.require("the page is closed with the key down: the helm goes back to neutral", True)
    browser.end()

    browser = Browser(f"http://{demo.host}/", folder)
    browser.type("p")
    common.wait_until(lambda: demo.status()["paused"], 5, "the pause")
    still = demo.status()["tick"]
    time.sleep(0.3)
    table.require("p: the time stands still", demo.status()["tick"] == still)
    browser.type("p")
    common.wait_until(lambda: not demo.status()["paused"], 5, "the end of the pause")
    browser.type("space")
    stopped = demo.wait(lambda status: not status["engaged"], 5, "the stop")
    table.require("space: the camera is stopped", stopped["pan"] == 0 and stopped["tilt"] == 0, stopped["mode"])
    browser.type("h")
    browser.type("e")
    demo.wait(lambda status: status["engaged"] and status["helm"] == "helmsman", 5, "the helmsman")
    complaints = browser.complaints()
    table.require("the browser has nothing to complain about", not complaints, "; ".join(complaints)[:200])
    browser.end()

    pace = demo.status()["pace"]
    code = demo.end()
    table.require("Ctrl-C ends it with exit 0", code == 0, f"exit {code}")
    table.show("simulated seconds in each second", f"{pace:.2f}", f"at {SIZE}, with a recording")
    again(table, args, store, record)


def drive_by_default(table, args, folder):
    """Nobody at the helm, the law that nobody named."""
    store, record = folder / "default.jsonl", folder / "default.mcap"
    demo = Demo(args, "arena1", "--store", store, "--record", record)
    common.wait_until(demo.status, 10, "the first status")
    moved = demo.wait(lambda status: abs(status["pan"]) > 0 and abs(status["tilt"]) > 0, 60, "both axes at once")
    table.require("unless another is named: the optimal law, both axes at once", moved["law"] == "optimal", f"pan {moved['pan']:+.3f}, tilt {moved['tilt']:+.3f} rad/s after {moved['time_s']:.1f} s, P {moved['p']:.2f}")
    table.require("and beside it P as the schema would have kept it", isinstance(moved["schema_p"], float), f"{moved['schema_p']:.2f}")
    demo.end()
    again(table, args, store, record)


def share_inside(record):
    """Share of the steps with a percept that have P <= 1, and how many there are."""
    seen = [outcome.percept.p for outcome in Recording(record).outcomes if outcome.HasField("percept")]
    return (sum(p <= 1 for p in seen) / len(seen) if seen else 0.0), len(seen)


def run_for(table, args, seconds, name, *options):
    """`run` for a while; its exit code and log."""
    child = common.spawn([args.barrelman, "run", "--engage", *options], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
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
    # The optimal law has something new to say of both axes at every picture.
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
