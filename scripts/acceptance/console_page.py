"""Shared code of the console's scripts: the page in headless Chromium, and the console's interface for programs."""
import http.client
import json
import shutil
import signal
import subprocess
import sys
import time

import common
from common import Lines
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys


def installed(*names):
    """The path of the first of these programs that is installed; without one, the script ends."""
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        sys.exit(f"{names[0]} is not installed: scripts/setup.sh test installs it")
    return found


class Program:
    """A running `demo` or `run` with its console."""

    def __init__(self, args, command, *options):
        words = [args.barrelman, command, "--listen", "127.0.0.1:0", *options]
        self.child = common.spawn(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.lines, self.errors = Lines(self.child.stdout), Lines(self.child.stderr)
        _, line = self.lines.wait_for(r"console.*http://", 30)
        self.url = line.split(": ", 1)[1].strip()
        self.watch_url = None
        if "#token=" in self.url:
            self.watch_url = self.lines.wait_for(r"watch only: http://", 5)[1].split(": ", 1)[1].strip()
        self.host = self.url.split("http://")[1].split("/")[0]
        self.token = self.url.partition("#token=")[2]
        self.watch_token = (self.watch_url or "").partition("#token=")[2]

    def ask(self, method, path, body=None, headers=None, token=...):
        """The status, the body and the headers of an answer."""
        headers = dict(headers or {})
        token = self.token if token is ... else token
        if token:
            headers.setdefault("Authorization", f"Bearer {token}")
        if body is not None:
            headers.setdefault("Content-Type", "application/json")
        connection = http.client.HTTPConnection(self.host, timeout=15)
        text = body if body is None or isinstance(body, (str, bytes)) else json.dumps(body)
        connection.request(method, path, text, headers)
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, content, answer.headers

    def status(self):
        return json.loads(self.ask("GET", "/api/v1/status")[1])

    def request(self, kind, **more):
        """Makes a request as a program, and returns its answer."""
        code, body, _ = self.ask("POST", "/api/v1/requests", {"request": {"kind": kind, **more}})
        return json.loads(body) if code == 200 else {"answer": f"HTTP {code}", "reason": body.decode()}

    def wait(self, condition, seconds, what):
        """Waits for a state. In a demo, the seconds are the simulated world's, which may run slower than the clock."""
        first = self.status()
        start = time.monotonic()
        while True:
            status = self.status()
            if condition(status):
                return status
            world = (status["drive"] or {}).get("time_s"), (first["drive"] or {}).get("time_s")
            passed = world[0] - world[1] if None not in world else time.monotonic() - start
            if passed > seconds or time.monotonic() - start > 6 * seconds + 20:
                raise TimeoutError(f"{what} did not come within {seconds} s: {json.dumps(status)[:900]}")
            time.sleep(0.05)

    def end(self):
        self.child.send_signal(signal.SIGINT)
        return self.child.wait(timeout=30)


class Page:
    """A console in headless Chromium."""

    KEYS = {"up": Keys.ARROW_UP, "left": Keys.ARROW_LEFT, "right": Keys.ARROW_RIGHT, "down": Keys.ARROW_DOWN, "space": Keys.SPACE, "enter": Keys.ENTER}

    def __init__(self, url, folder, name="chromium", size=(1280, 800)):
        options = webdriver.ChromeOptions()
        options.binary_location = installed("chromium", "google-chrome")
        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars", f"--user-data-dir={folder / name}"]
        for flag in flags:
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options, webdriver.ChromeService(installed("chromedriver")))
        self.resize(*size)
        self.driver.get(url)

    def resize(self, width, height):
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    @property
    def data(self):
        """The state that the page shows, from the attributes that the page has for scripts."""
        return self.driver.execute_script("return {...document.documentElement.dataset}")

    def wait(self, condition, seconds, what):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            data = self.data
            if condition(data):
                return data
            time.sleep(0.03)
        raise TimeoutError(f"{what} did not come within {seconds} s: {self.data}; {self.complaints()}")

    def wait_for_picture(self):
        """Waits until the page shows a picture. The picture's size."""
        script = "const v = document.getElementById('picture')?.dataset.size; return v ? v.split('x').map(Number) : null"
        common.wait_until(lambda: self.driver.execute_script(script), 30, "the picture")
        return self.driver.execute_script(script)

    def wait_until_enabled(self, name):
        # The page is connected before a button that depends on the program is shown.
        button = self.element(name)
        common.wait_until(lambda: button.is_displayed() and button.is_enabled(), 10, f"the button {name}")

    def ready(self):
        return self.wait(lambda data: data.get("connected") == "yes" and int(data.get("drawn", 0)) > 3, 30, "the first pictures")

    def element(self, name):
        return self.driver.find_element(By.ID, name)

    def click(self, name):
        self.element(name).click()

    def press(self, name):
        ActionChains(self.driver).key_down(self.KEYS.get(name, name)).perform()

    def release(self, name):
        ActionChains(self.driver).key_up(self.KEYS.get(name, name)).perform()

    def type(self, name):
        self.press(name)
        self.release(name)

    def hold(self, name):
        """Holds the mouse down on a button."""
        ActionChains(self.driver).move_to_element(self.element(name)).click_and_hold().perform()

    def let_go(self):
        ActionChains(self.driver).release().perform()

    def picture_box(self, box, size):
        """Converts a box of the picture to corners on the page."""
        area = self.driver.execute_script("const r = document.getElementById('picture').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]")
        scale = min(area[2] / size[0], area[3] / size[1])
        left, top = area[0] + (area[2] - size[0] * scale) / 2, area[1] + (area[3] - size[1] * scale) / 2
        corner = lambda u, v: (round(left + u * scale), round(top + v * scale))
        return corner(box[0], box[1]), corner(box[0] + box[2], box[1] + box[3])

    def drag(self, box, size):
        """Drags a box of the picture with the mouse."""
        (x1, y1), (x2, y2) = self.picture_box(box, size)
        builder = ActionBuilder(self.driver, duration=20)
        pointer = builder.pointer_action
        pointer.move_to_location(x1, y1).pointer_down()
        pointer.move_to_location((x1 + x2) // 2, (y1 + y2) // 2).move_to_location(x2, y2).pointer_up()
        builder.perform()

    def complaints(self):
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]

    def screenshot(self, path):
        self.driver.save_screenshot(str(path))

    def end(self):
        self.driver.quit()


def find_red(page, folder):
    """The box around the largest red object in the picture that the page shows, and the size of the picture."""
    import cv2
    import numpy

    path = folder / "find.png"
    page.screenshot(path)
    size = page.driver.execute_script("const v = document.getElementById('picture').dataset; return v.size ? v.size.split('x').map(Number) : null")
    (left, top), (right, bottom) = page.picture_box([0, 0, *size], size)
    shown = cv2.imread(str(path))[top:bottom, left:right]
    red = (shown[:, :, 2].astype(int) - numpy.maximum(shown[:, :, 0], shown[:, :, 1]) > 45).astype(numpy.uint8)
    red = cv2.morphologyEx(red, cv2.MORPH_CLOSE, numpy.ones((5, 5)))
    count, _, stats, _ = cv2.connectedComponentsWithStats(red)
    if count < 2:
        return None, size
    u, v, w, h, area = max(stats[1:], key=lambda row: row[4])
    scale = size[0] / (right - left)
    box = [(u - 2) * scale, (v - 2) * scale, (w + 4) * scale, (h + 4) * scale]
    return ([float(value) for value in box] if area >= 12 else None), size


def select_boat(table, page, folder, what="the boat", seconds=90):
    """Drags a box around the boat until the track is confirmed.

    A boat near the border leaves before a busy machine answers, and the boat of `arena1` leaves a camera at rest after
    5 s, to the left. The script turns a camera that is not engaged by hand, as an operator does, to where the boat was seen.
    """
    end = time.monotonic() + seconds
    attempts, said = 0, "no red boat well inside the picture"
    across = 0.0
    while time.monotonic() < end:
        box, size = find_red(page, folder)
        if box:
            across, down = (box[0] + box[2] / 2) / size[0], (box[1] + box[3] / 2) / size[1]
        if not box or not (0.1 <= across <= 0.9 and 0.1 <= down <= 0.9):
            if page.data["mode"] == "idle":
                key = "a" if across < 0.5 else "d"
                page.press(key)
                time.sleep(0.5)
                page.release(key)
            time.sleep(0.3)
            continue
        attempts += 1
        page.drag(box, size)
        try:
            data = page.wait(lambda data: data["track"] == "tracking", 5, "the track")
            return table.require(f"a box is dragged around {what}: the track is confirmed", True, f"attempt {attempts}, P {data['p']}")
        except TimeoutError:
            said = f"{page.element('toast').text or 'no answer'} (box {[round(side) for side in box]} of {size})"
        time.sleep(0.4)
    return table.require(f"a box is dragged around {what}: the track is confirmed", False, f"{attempts} attempts; {said}")
