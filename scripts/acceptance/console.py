"""Tests the operator's console in headless Chromium: on `demo`, and on `run` with an emulated ground station.

The script finds the boat in the picture by its colour, as an operator does, and drags a box around the boat. It
engages the camera, turns the camera by hand and stops it. The log of the ground station has the rates that arrived.
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import common
from common import Emulator, Lines, Table
from console_page import Page, Program, select_boat
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.mouse_button import MouseButton
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

SIZE = "960x540"


TURNS = {"mode": {"name": "idle"}, "link": {"state": "up", "in_control": True, "flight": "flying"}, "video": {"state": "up"}, "alarms": []}
OBSTACLES = [
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


def turn_buttons(table, page):
    """What keeps the buttons that turn the camera from working, and whether each reason has its words."""
    script = """
        const [cases, done] = arguments;
        Promise.all([import("/console/nudge_obstacle.js"), import("/console/words.en.js")]).then(([{ nudgeObstacle }, words]) => {
          const found = cases.map((one) => nudgeObstacle(one));
          done([found, found.every((key) => key === null || key in words.default.reasons)]);
        }, (error) => done([String(error), false]));
    """
    found, has_words = page.driver.execute_async_script(script, [{**TURNS, **change} for change, _ in OBSTACLES])
    expected = [key for _, key in OBSTACLES]
    is_right = found == expected and has_words
    table.require("the camera can be turned by hand where commands reach it only", is_right, f"{len(expected)} cases", "" if is_right else f"{found}, not {expected}")


def screenshots(page, keep, name):
    """Pictures of the page in the sizes of a laptop, a tablet and a telephone."""
    if not keep:
        return
    pathlib.Path(keep).mkdir(parents=True, exist_ok=True)
    for width, height in ((1280, 800), (768, 1024), (390, 844)):
        page.resize(width, height)
        time.sleep(0.6)
        page.screenshot(pathlib.Path(keep) / f"{name}-{width}x{height}.png")
    page.resize(1280, 800)
    time.sleep(0.3)


# Sizes of windows: laptops with and without the browser's bars, a screen enlarged to 125 %, tablets, telephones.
WINDOWS = ((1280, 800), (1280, 720), (1280, 600), (1280, 420), (1024, 576), (900, 500), (768, 1024), (640, 800), (390, 760), (844, 390))


def out_of_view(page, names):
    """What a window of some size does not show whole, without scrolling, or shows under something else."""
    hidden = []
    for width, height in WINDOWS:
        page.resize(width, height)
        time.sleep(0.3)
        for name in names:
            is_shown = page.driver.execute_script("""
                const element = document.getElementById(arguments[0]), { left, top, right, bottom } = element.getBoundingClientRect();
                const isWhole = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
                return isWhole && element.contains(document.elementFromPoint((left + right) / 2, (top + bottom) / 2));""", name)
            if not is_shown:
                hidden.append(f"{name} at {width}x{height}")
    page.resize(1280, 800)
    return hidden


def stop_beside_dialog(page, width, height):
    """Presses Stop by the mouse while the help is open, in a window of a size. Returns whether it was taken, and what is wrong with the help."""
    page.resize(width, height)
    page.click("keys")
    before = int(page.data["stops"])
    page.click("stop")
    page.wait(lambda data: int(data["stops"]) > before, 3, "the stop")
    faults = page.driver.execute_script("""
        const dialog = document.getElementById('keys-dialog'), title = document.getElementById('keys-title').getBoundingClientRect();
        const words = [...dialog.querySelectorAll('dd')].map((word) => word.clientWidth);
        return [dialog.open && title.top >= 0 ? '' : 'the title is out of view', Math.min(...words) >= 100 ? '' : `a column of ${Math.min(...words)} px`].filter(Boolean);""")
    page.type(Keys.ESCAPE)
    if page.driver.execute_script("return document.getElementById('keys-dialog').open"):
        faults.append("Escape does not close it")
    page.resize(1280, 800)
    return faults


# Records the tones that the page plays, and how many wake locks of the screen it holds.
SPIES = """
    window.spied = { tones: [], locks: 0, refusal: null };
    const make = AudioContext.prototype.createOscillator;
    AudioContext.prototype.createOscillator = function () {
      const tone = make.call(this);
      const start = tone.start.bind(tone);
      tone.start = (at) => { window.spied.tones.push(tone.frequency.value); start(at); };
      return tone;
    };
    const request = navigator.wakeLock.request.bind(navigator.wakeLock);
    navigator.wakeLock.request = async (kind) => {
      const lock = await request(kind).catch((error) => { window.spied.refusal = String(error); throw error; });
      window.spied.locks += 1;
      lock.addEventListener("release", () => { window.spied.locks -= 1; });
      return lock;
    };
"""


def spied(page):
    return page.driver.execute_script("return window.spied")


def sounds_and_screen(table, page):
    """Engages and stops: the tones, and the screen that is kept awake."""
    page.driver.execute_script(SPIES)
    page.click("engage")
    page.wait(lambda data: data["mode"] == "servoing", 5, "the engagement")
    common.wait_until(lambda: spied(page)["locks"] or spied(page)["refusal"], 5, "the wake lock")
    seen = spied(page)
    table.require("engaged: the screen is kept awake", seen["locks"] == 1, seen["refusal"] or f"{seen['locks']} wake lock")
    table.require("no sound that was not asked for", not seen["tones"], f"{seen['tones']}")
    page.click("sound")
    is_marked = page.element("sound").get_attribute("aria-pressed") == "true"
    table.require("the button Sound plays a tone, and says that it is on", is_marked and spied(page)["tones"] == [660, 880], f"{spied(page)['tones']} Hz")
    page.type("space")
    page.wait(lambda data: data["mode"] == "stopped", 5, "the stop")
    common.wait_until(lambda: spied(page)["locks"] == 0, 5, "the release of the wake lock")
    table.require("stopped: the screen may sleep again", True)
    table.require("Stop has a tone of its own", spied(page)["tones"][2:3] == [330], f"{spied(page)['tones'][2:]} Hz")
    page.click("sound")
    before = len(spied(page)["tones"])
    page.type("r")
    page.wait(lambda data: data["mode"] == "idle", 5, "disengaged")
    table.require("switched off: no sound", len(spied(page)["tones"]) == before and page.element("sound").get_attribute("aria-pressed") == "false")


def leave_ellipse(program, page):
    """Waits until a boat that is driven ahead has left the ellipse. A boat that goes straight away from the camera is turned."""
    is_out = lambda status: (status["percept"] or {}).get("p", 0) > 1.05
    for _ in range(4):
        try:
            return program.wait(is_out, 15, "an excursion")
        except TimeoutError:
            page.press("right")
            time.sleep(1.0)
            page.release("right")
    return program.wait(is_out, 15, "an excursion")


def demo(table, args, folder):
    print("\ndemo --hands-on", flush=True)
    store = folder / "drive.jsonl"
    program = Program(args, "demo", "open", "--hands-on", "--law", "schema", "--size", SIZE, "--store", store)
    page = Page(program.url, folder)
    data = page.ready()
    table.require("a drive without encoding is drawn as JPEG", data["path"] == "jpeg", data["path"])
    table.require("it begins unselected and disengaged", (data["mode"], data["track"]) == ("idle", "unseeded"), f"{data['mode']}, {data['track']}")
    height = page.driver.execute_script("return document.documentElement.scrollHeight")
    table.require("the page fits 1280x800", height <= 800, f"{height} px high", "at most 800")
    hidden = out_of_view(page, ("stop", "engage", "disengage", "mode"))
    table.require("Stop, Engage and the mode are in view in every window, however low", not hidden, ", ".join(hidden) or f"{len(WINDOWS)} sizes")
    faults = [f"{width}x{height}: {fault}" for width, height in ((1280, 800), (390, 760), (844, 390)) for fault in stop_beside_dialog(page, width, height)]
    table.require("Stop is taken while the keys are shown, and the keys are readable", not faults, ", ".join(faults) or "by mouse, three sizes")
    thrust = lambda: program.status()["drive"]["thrust"]
    page.hold("helm-up")
    common.wait_until(lambda: thrust() > 0, 5, "the thrust")
    page.let_go()
    common.wait_until(lambda: thrust() == 0, 5, "the neutral boat")
    right = ActionBuilder(page.driver)
    right.pointer_action.move_to(page.element("helm-up")).pointer_down(MouseButton.RIGHT)
    right.perform()
    time.sleep(0.4)
    table.require("a pad is held by the left button alone", thrust() == 0, f"thrust {thrust():.2f}")
    up = ActionBuilder(page.driver)
    up.pointer_action.pointer_up(MouseButton.RIGHT)
    up.perform()
    select_boat(table, page, folder)
    sounds_and_screen(table, page)
    page.click("engage")
    page.wait(lambda data: data["mode"] == "servoing", 5, "the engagement")
    page.press("up")
    out = leave_ellipse(program, page)
    table.require("arrow up, held: the boat leaves the ellipse", out["drive"]["helm"] == "page", f"P {out['percept']['p']:.2f}")
    moved = program.wait(lambda status: abs(status["command"]["pan"]) + abs(status["command"]["tilt"]) > 0, 10, "a rate")
    table.require("the camera follows", True, f"pan {moved['command']['pan']:+.2f}, tilt {moved['command']['tilt']:+.2f} rad/s")
    screenshots(page, args.screenshots, "following")
    page.release("up")
    back = program.wait(lambda status: (status["percept"] or {}).get("p", 9) < 1, 40, "the boat in the ellipse")
    table.require("and brings the boat back", True, f"P {back['percept']['p']:.2f}")
    page.type("space")
    page.wait(lambda data: data["mode"] == "stopped" and int(data["stops"]) >= 1, 5, "the stop")
    status = program.status()
    table.require("space: stopped, and acknowledged", status["command"] == {"pan": 0.0, "tilt": 0.0}, status["mode"]["cause"])
    page.type("r")
    page.wait(lambda data: data["mode"] == "idle", 5, "disengaged")
    page.press("d")
    data = page.wait(lambda data: data["mode"] == "nudging", 5, "the nudge")
    page.release("d")
    page.wait(lambda data: data["mode"] == "idle", 5, "the end of the nudge")
    table.require("d, held, turns the camera by hand", float(data["pan"]) > 0, f"pan {data['pan']} rad/s")
    page.click("reject")
    page.wait(lambda data: data["track"] == "lost", 5, "the rejection")
    table.require("Not that one: the track is given up", True)
    page.click("deselect")
    page.wait(lambda data: data["track"] == "unseeded", 5, "the deselection")
    Select(page.element("law")).select_by_value("eco")
    program.wait(lambda status: status["law"] == "eco", 5, "the law")
    table.require("the law is switched while disengaged", True, "eco")
    complaints = page.complaints()
    table.require("the browser has nothing to complain about", not complaints, "; ".join(complaints)[:200])
    page.end()
    table.require("Ctrl-C ends it with exit 0", program.end() == 0)
    again = common.run([args.barrelman, "demo", "--replay", store], timeout=300)
    table.require("the drive runs again bit for bit, with every request", again.returncode == 0 and "bit for bit" in again.stdout, again.stdout.splitlines()[0] if again.stdout else again.stderr[-300:])


def zeros_after(emulator, moment, seconds=3.0):
    """Seconds from `moment` to the first zero that the ground station heard after its last rate; None without one."""
    time.sleep(min(seconds, 1.0))
    rows = [row for row in emulator.heard() if row.is_motion and row.at >= moment]
    moving = [row.at for row in rows if row.moves]
    last = max(moving, default=moment)
    zero = next((row.at for row in rows if row.is_zero and row.at >= last), None)
    return None if zero is None else zero - moment


def stop_among_requests(table, args, page, emulator):
    """Presses Stop among 200 requests at once, while the camera turns."""
    delays = []
    fire = "const l = document.getElementById('law'); for (let i = 0; i < 200; i++) { l.value = i % 2 ? 'eco' : 'minimum-energy'; l.dispatchEvent(new Event('change')); if (i === 100) document.getElementById('stop').click(); }"
    for number in range(args.stops):
        if page.data["mode"] != "idle":
            page.type("r")
        page.wait(lambda data: data["mode"] == "idle", 5, "disengaged")
        # To and fro, so that the boat stays in view.
        key = "ad"[number % 2]
        page.press(key)
        page.wait(lambda data: data["mode"] == "nudging", 5, "the nudge")
        emulator.wait_for(lambda row: row.moves and row.at > time.monotonic() - 0.3, 5, "a rate")
        moment = time.monotonic()
        page.driver.execute_script(fire)
        page.wait(lambda data: data["mode"] == "stopped", 5, "the stop")
        delays.append(zeros_after(emulator, moment))
        page.release(key)
        # The limit of requests fills again.
        time.sleep(0.6)
    known = [delay * 1e3 for delay in delays if delay is not None]
    holds = len(known) == len(delays) and common.median(known) <= 150 and max(known) <= 350
    table.require(f"Stop among 200 requests, {len(delays)} times: at rest at the ground station", holds, f"median {common.median(known):.0f} ms, worst {max(known, default=0):.0f} ms", "150 and 350 ms")


def bring_inside(table, program, page, folder):
    """Waits until the camera has the boat in the ellipse. A busy machine may lose the boat: then the boat is selected again."""
    is_inside = lambda status: (status["percept"] or {}).get("p", 9) < 1
    for _ in range(common.ATTEMPTS):
        if is_inside(program.wait(lambda status: is_inside(status) or status["track"]["state"] == "lost", 60, "the boat in the ellipse")):
            return
        page.click("disengage")
        select_boat(table, page, folder, "the boat that was lost")
        page.click("engage")
    raise TimeoutError(f"the boat was lost {common.ATTEMPTS} times before the camera had it in the ellipse")


def run(table, args, folder):
    print("\nrun, with an emulated ground station", flush=True)
    record = folder / "run.mcap"
    options = ["--world", f"sim:arena1?size={SIZE}", "--video-listen", "127.0.0.1:0"]
    emulator = Emulator(args.barrelman, folder, "station", *options)
    _, line = emulator.lines.wait_for("rtsp://", 10)
    url = next(word for word in line.split() if word.startswith("rtsp://")).rstrip(";")
    program = Program(args, "run", "--video", url, "--link", emulator.url, "--record", record, "--law", "schema")
    refusals(table, program)
    page = Page(program.url, folder, "control")
    page.ready()
    # The first pictures may come before the first H.264 unit.
    data = page.wait(lambda data: data["path"] == "h264", 10, "H.264")
    table.require("a received stream is drawn by WebCodecs", True, data["path"])
    table.require("the token is gone from the address", "token" not in page.driver.current_url, page.driver.current_url)
    turn_buttons(table, page)
    select_boat(table, page, folder)
    page.click("engage")
    page.wait(lambda data: data["mode"] == "servoing", 5, "the engagement")
    heard = emulator.wait_for(lambda row: row.moves, 90, "a rate at the ground station")
    table.require("engaged: the ground station hears rates", True, heard.raw)
    data = page.data
    table.show("capture to drawing by the page's own clock, WebCodecs", f"median {data['delayMs']} ms, 95 % {data['delayP95Ms']} ms", "with the latency of the simulated video")
    # A boat that is left outside of the ellipse may leave the picture before the next box is drawn.
    bring_inside(table, program, page, folder)
    page.click("deselect")
    page.wait(lambda data: (data["mode"], data["track"]) == ("holding", "unseeded"), 5, "nothing followed")
    select_boat(table, page, folder, "the boat, again, while engaged")
    page.wait(lambda data: data["mode"] == "servoing", 5, "the camera")
    page.click("disengage")

    watchers(table, args, folder, program, page)

    page.driver.refresh()
    page.ready()
    table.require("a reload keeps the control", page.wait(lambda data: data["controlling"] == "yes", 5, "the control")["controlling"] == "yes")
    stop_among_requests(table, args, page, emulator)

    jpeg = Page(program.url.replace("/#", "/?video=jpeg#"), folder, "jpeg")
    data = jpeg.ready()
    table.require("JPEG is drawn where it is asked for", data["path"] == "jpeg", data["path"])
    jpeg.end()

    emulator.close()
    page.wait(lambda data: data["next"] in ("link", "video"), 20, "the alarm")
    table.require("the cable is pulled: the page says so", True, page.element("next-action").text)
    emulator = Emulator(args.barrelman, folder, "station", "--force", *options[:2], "--video-listen", url.split("/")[2])
    page.wait(lambda data: data["link"] == "up", 30, "the link")
    table.require("and back: the link is up again", True)
    page.wait(lambda data: data["next"] in ("select", "reselect", "stopped"), 30, "the video")
    page.type("r")
    page.wait(lambda data: data["mode"] == "idle", 5, "the end of the stop")

    page.press("d")
    page.wait(lambda data: data["mode"] == "nudging", 5, "the nudge")
    emulator.wait_for(lambda row: row.moves, 5, "a rate")
    processes = common.run(["pgrep", "-f", str(folder / "control")]).stdout.split()
    moment = time.monotonic()
    for process in processes:
        try:
            os.kill(int(process), signal.SIGKILL)
        except ProcessLookupError:
            pass
    rest = zeros_after(emulator, moment)
    table.require("the page is killed during a nudge: rest at the ground station", rest is not None and rest <= 0.35, "never" if rest is None else f"{rest * 1e3:.0f} ms", "350 ms")
    time.sleep(2.5)
    events = program.errors.text()
    table.require("SIGINT ends it with exit 0", program.end() == 0, events[-200:] if program.child.returncode else "")
    emulator.close()
    replayed = common.run([args.barrelman, "replay", record, "--compare"], timeout=600)
    table.require("the recording replays bit for bit, with every request", replayed.returncode == 0 and "bit for bit" in replayed.stdout, replayed.stdout.splitlines()[0] if replayed.stdout else replayed.stderr[-300:])


def hanging_pilot(table, args, folder):
    print("\nrun, with a pilot that hangs", flush=True)
    program = Program(args, "run", "--video", f"sim:open?size={SIZE}", "--link", "sim:", "--no-record", "--fault", "pilot:hang@12")
    page = Page(program.url, folder, "hang")
    page.ready()
    said = lambda: page.element("lost").text
    before = said()
    common.wait_until(lambda: said(), 20, "what the page says of a program that hangs")
    table.require("a program that hangs is not shown as one that decides", before == "" and "HANGS" in said(), said())
    page.end()
    program.child.kill()
    program.child.wait()


def recorded_file(table, args, folder):
    """A run on a file: the page holds the first picture until the box is drawn, and becomes the console."""
    clip, truth = common.practice_clip(args, folder)
    words = [args.barrelman, "run", "--listen", "127.0.0.1:0", "--video", f"file:{clip}", "--no-record"]
    child = common.spawn(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    lines, errors = Lines(child.stdout), Lines(child.stderr)
    url = errors.wait_for(r"draw the box around the boat: http://", 30)[1].split(": ", 1)[1].strip()
    table.require("a file: the page for the first picture asks for the token", "#token=" in url, url.partition("#")[0])
    page = Page(url, folder, "picker")
    size = page.wait_for_picture()
    table.require("  the file does not play while the box is drawn", not lines.text(), lines.text()[-120:])
    page.drag([float(value) for value in common.selection(truth).split(",")], size)
    page.wait_until_enabled("take")
    page.click("take")
    followed = page.wait(lambda data: data.get("connected") == "yes" and data.get("track") == "tracking", 30, "the console, with the track")
    table.require("  the same page becomes the console, and the box of the first picture is followed", True, followed["track"])
    page.end()
    child.send_signal(signal.SIGINT)
    table.require("  SIGINT ends it with exit 0", child.wait(timeout=30) == 0)


def watchers(table, args, folder, program, page):
    """Tests a second page that only watches, and a third page that takes and gives the control."""
    watcher = Page(program.watch_url, folder, "watch")
    watcher.ready()
    disabled = watcher.driver.execute_script("return ['engage','disengage','law','nudge-up'].every((id) => document.getElementById(id).disabled)")
    table.require("a page with the watch link cannot command", disabled and watcher.data["controlling"] == "no", watcher.element("seat").text)
    code, body, _ = program.ask("POST", "/api/v1/requests", {"request": {"kind": "engage"}}, token=program.watch_token)
    table.require("  its token is refused a command", code == 200 and json.loads(body)["answer"] == "refused", json.loads(body).get("reason", ""))
    watcher.click("stop")
    page.wait(lambda data: data["mode"] == "stopped", 5, "the watcher's stop")
    table.require("  but its Stop is taken", True)
    # The address differs in what stands behind #, so that the browser by itself loads nothing.
    may_ask = lambda: watcher.driver.execute_script("const ask = document.getElementById('ask-control'); return ask.checkVisibility() && !ask.disabled")
    could_ask = may_ask()
    watcher.driver.get(program.url)
    common.wait_until(may_ask, 5, "the page with the control link")
    table.require("  the control link, opened in its tab, makes it a control page", not could_ask)
    watcher.end()
    page.type("r")
    other = Page(program.url, folder, "other")
    other.ready()
    table.require("a second control page does not control by itself", other.data["controlling"] == "no", other.element("seat").text)
    other.click("ask-control")
    common.wait_until(lambda: page.driver.find_elements(By.CSS_SELECTOR, "[data-give]"), 5, "the question")
    page.driver.find_element(By.CSS_SELECTOR, "[data-give]").click()
    other.wait(lambda data: data["controlling"] == "yes", 5, "the control")
    table.require("control is asked for, and given", page.wait(lambda data: data["controlling"] == "no", 5, "the change")["controlling"] == "no")
    page.click("take-control")
    before = int(page.data["stops"])
    page.click("stop")
    page.wait(lambda data: int(data["stops"]) > before, 3, "the stop")
    table.require("Stop is taken while a question is open", page.driver.execute_script("return document.getElementById('take-dialog').open"))
    page.driver.find_element(By.CSS_SELECTOR, "#take-dialog button[value=take]").click()
    page.wait(lambda data: data["controlling"] == "yes", 5, "the control")
    told = other.wait(lambda data: data["controlling"] == "no", 5, "the notice") and other.element("toast").text
    table.require("control is taken, and the other page is told", "took the control" in told, told)
    other.end()


def refusals(table, program):
    """Tests the requests that the server refuses."""
    get = lambda path, token=..., **headers: program.ask("GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()}, token=token)
    rows = [
        ("no token", get("/api/v1/status", token=None)[0], 401),
        ("a wrong token", get("/api/v1/status", token="x" * 22)[0], 401),
        ("metrics without a token", get("/metrics", token=None)[0], 401),
        ("a socket without a token", get("/api/v1/socket", token=None, Connection="Upgrade", Upgrade="websocket", Sec_WebSocket_Version="13", Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==")[0], 401),
        ("a foreign Host", get("/api/v1/status", Host="evil.example")[0], 403),
        ("a foreign Origin", get("/api/v1/status", Origin="http://evil.example")[0], 403),
        ("a foreign page's fetch", get("/api/v1/status", Sec_Fetch_Site="cross-site")[0], 403),
        ("a path with ..", get("/console/../../etc/passwd")[0], 404),
        ("an encoded path with ..", get("/console/%2e%2e%2f%2e%2e%2fetc%2fpasswd")[0], 404),
        ("a body of 5000 bytes", program.ask("POST", "/api/v1/requests", "x" * 5000)[0], 413),
        ("a request that is none", program.ask("POST", "/api/v1/requests", {"request": {"kind": "fly"}})[0], 400),
        ("a form in place of JSON", program.ask("POST", "/api/v1/requests", "kind=stop", {"Content-Type": "text/plain"})[0], 415),
    ]
    for name, code, wanted in rows:
        table.require(f"refused: {name}", code == wanted, f"HTTP {code}", f"HTTP {wanted}")
    code, body, headers = get("/", token=None)
    table.require("the page itself needs no token", code == 200 and b"<title>Barrelman" in body)
    policy = headers.get("Content-Security-Policy", "")
    table.require("it cannot be embedded, and runs its own scripts alone", "frame-ancestors 'none'" in policy and "unsafe-inline" not in policy and headers.get("Cross-Origin-Resource-Policy") == "same-origin")
    code, body, _ = get("/metrics")
    table.require("/metrics for Prometheus", code == 200 and b"# TYPE barrelman_p gauge" in body or b"barrelman_steps_total" in body, f"{len(body)} bytes")
    table.require("/healthz", get("/healthz", token=None)[1] == b"ok\n")


def main():
    args = common.arguments(__doc__, screenshots={"metavar": "DIR", "help": "keep pictures of the page here"}, stops={"type": int, "default": 20, "help": "how often Stop is pressed among 200 requests"}, only={"choices": ["demo", "run"], "help": "one half alone"})
    folder = common.temporary_folder()
    table = Table("The operator's console")
    if args.only != "run":
        demo(table, args, folder)
    if args.only != "demo":
        recorded_file(table, args, folder)
        run(table, args, folder)
        hanging_pilot(table, args, folder)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
