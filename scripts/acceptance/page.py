"""The console's page in headless Chromium."""

import contextlib
import pathlib
import shutil
import time
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Self

import cv2
import numpy
from axe_selenium_python import Axe
from selenium import webdriver
from selenium.common.exceptions import ElementClickInterceptedException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from client import Program
from machine import PATIENCE_S, poll, wait_until
from process import ends

Size = Sequence[int]
Data = dict[str, str]


def installed(*names: str, needs: str = "test") -> str:
    """The path of the first of these programs that is installed. `needs`: the set-up that installs it."""
    found = next(filter(None, map(shutil.which, names)), None)
    assert found, f"{names[0]} is not installed: scripts/setup.sh {needs} installs it"
    return found


class Page:
    """A console in headless Chromium."""

    KEYS: ClassVar = {
        "up": Keys.ARROW_UP,
        "left": Keys.ARROW_LEFT,
        "right": Keys.ARROW_RIGHT,
        "down": Keys.ARROW_DOWN,
        "space": Keys.SPACE,
        "enter": Keys.ENTER,
    }

    def __init__(self, url: str, folder: pathlib.Path, name: str = "chromium", before: str = "") -> None:
        """`before`: a script that runs before the page's own."""
        self.profile = folder / name
        options = webdriver.ChromeOptions()
        options.binary_location = installed("chromium", "google-chrome")
        for flag in (
            "headless=new",
            "no-sandbox",
            "disable-gpu",
            "no-first-run",
            "disable-background-networking",
            "disable-component-update",
            "disable-sync",
            "hide-scrollbars",
            f"user-data-dir={self.profile}",
        ):
            options.add_argument(f"--{flag}")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options, webdriver.ChromeService(installed("chromedriver")))
        self.is_open = True
        ends.append(self.end)
        if before:
            self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": before})
        self.resize(1280, 800)
        self.driver.get(url)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def end(self) -> None:
        if self.is_open:
            self.is_open = False
            self.driver.quit()

    def script(self, text: str, *arguments: Any) -> Any:
        return self.driver.execute_script(text, *arguments)

    def resize(self, width: int, height: int) -> None:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    @property
    def data(self) -> Data:
        """The state that the page shows, from the attributes that the page has for scripts."""
        data: Data = self.script("return {...document.documentElement.dataset}")
        return data

    def wait(self, condition: Callable[[Data], Any], what: str, seconds: float = PATIENCE_S) -> Data:
        def holds() -> Data | None:
            data = self.data
            return data if condition(data) else None

        found: Data = wait_until(holds, lambda: f"{what} ({self.data}; {self.complaints()})", seconds, 0.03)
        return found

    def wait_for_mode(self, mode: str) -> Data:
        return self.wait(lambda data: data["mode"] == mode, f"the mode {mode}")

    def size(self) -> Size | None:
        """The size of the picture, once there is one."""
        size: Size | None = self.script("""
            const size = document.getElementById('picture')?.dataset.size;
            return size ? size.split('x').map(Number) : null""")
        return size

    def wait_until_enabled(self, name: str) -> None:
        # The page is connected before a button that depends on the program is shown.
        button = self.element(name)
        wait_until(lambda: button.is_displayed() and button.is_enabled(), f"the button {name}")

    def ready(self) -> Data:
        return self.wait(
            lambda data: data.get("connected") == "yes" and int(data.get("drawn", 0)) > 0,
            "the first picture",
        )

    def element(self, name: str) -> WebElement:
        return self.driver.find_element(By.ID, name)

    def text(self, name: str) -> str:
        return self.element(name).text

    def click(self, name: str) -> None:
        """Clicks an element, which may move while the page is laid out anew."""

        def is_clicked() -> bool:
            with contextlib.suppress(ElementClickInterceptedException):
                self.element(name).click()
                return True
            return False

        wait_until(is_clicked, f"a click on {name}")

    def click_enabled(self, name: str) -> None:
        self.wait_until_enabled(name)
        self.click(name)

    def press(self, name: str) -> None:
        ActionChains(self.driver).key_down(self.KEYS.get(name, name)).perform()

    def release(self, name: str) -> None:
        ActionChains(self.driver).key_up(self.KEYS.get(name, name)).perform()

    def key(self, event: str, key: str, code: str, *, repeat: bool = False) -> None:
        """An event of a key, as a keyboard makes it whose keys change their names with Shift or AltGr."""
        self.script(
            "dispatchEvent(new KeyboardEvent(arguments[0], arguments[1]))",
            event,
            {"key": key, "code": code, "repeat": repeat, "bubbles": True, "cancelable": True},
        )

    def type(self, name: str) -> None:
        self.press(name)
        self.release(name)

    def hold(self, name: str) -> None:
        """Holds the mouse down on a button."""
        ActionChains(self.driver).move_to_element(self.element(name)).click_and_hold().perform()

    def let_go(self) -> None:
        ActionChains(self.driver).release().perform()

    def picture_box(self, box: Sequence[float], size: Size) -> tuple[tuple[int, int], tuple[int, int]]:
        """Converts a box of the picture to corners on the page."""
        area = self.script("""
            const area = document.getElementById('picture').getBoundingClientRect();
            return [area.left, area.top, area.width, area.height]""")
        scale = min(area[2] / size[0], area[3] / size[1])
        left, top = area[0] + (area[2] - size[0] * scale) / 2, area[1] + (area[3] - size[1] * scale) / 2
        u, v, w, h = box
        return (round(left + u * scale), round(top + v * scale)), (
            round(left + (u + w) * scale),
            round(top + (v + h) * scale),
        )

    def drag(self, box: Sequence[float], size: Size) -> None:
        """Drags a box of the picture with the mouse; one without a size is tapped."""
        (x1, y1), (x2, y2) = self.picture_box(box, size)
        builder = ActionBuilder(self.driver, duration=20)
        pointer = builder.pointer_action
        pointer.move_to_location(x1, y1).pointer_down()
        if (x1, y1) != (x2, y2):
            pointer.move_to_location((x1 + x2) // 2, (y1 + y2) // 2).move_to_location(x2, y2)
        pointer.pointer_up()
        builder.perform()

    def complaints(self) -> list[str]:
        return [
            entry["message"]
            for entry in self.driver.get_log("browser")
            if entry["level"] in ("SEVERE", "WARNING")
        ]

    def screenshot(self, folder: pathlib.Path | None, name: str) -> None:
        """Keeps a picture of the page, if there is a folder for it."""
        if folder:
            folder.mkdir(parents=True, exist_ok=True)
            self.driver.save_screenshot(str(folder / f"{name}.png"))

    def screenshots(self, folder: pathlib.Path | None, name: str) -> None:
        """Pictures of the page in the sizes of a laptop, a tablet and a telephone."""
        for width, height in ((768, 1024), (390, 844), (1280, 800)) if folder else ():
            self.resize(width, height)
            time.sleep(0.6)
            self.screenshot(folder, f"{name}-{width}x{height}")

    def disengage(self) -> None:
        if self.data["mode"] != "idle":
            self.type("r")
            self.wait_for_mode("idle")

    def follow_boat(self) -> None:
        if self.data["track"] != "tracking":
            self.select_boat()

    def find_red(self) -> tuple[list[float] | None, Size]:
        """The box around the largest red object in the picture that the page shows, and the size of the
        picture."""
        size: Size = wait_until(self.size, "the picture")
        (left, top), (right, bottom) = self.picture_box([0, 0, *size], size)
        screen = cv2.imdecode(
            numpy.frombuffer(self.driver.get_screenshot_as_png(), numpy.uint8), cv2.IMREAD_COLOR
        )
        assert screen is not None
        shown = screen[top:bottom, left:right]
        red: Any = (shown[:, :, 2].astype(int) - numpy.maximum(shown[:, :, 0], shown[:, :, 1]) > 45).astype(
            numpy.uint8
        )
        red = cv2.morphologyEx(red, cv2.MORPH_CLOSE, numpy.ones((5, 5), numpy.uint8))
        count, _, stats, _ = cv2.connectedComponentsWithStats(red)
        if count < 2:
            return None, size
        u, v, w, h, area = max(stats[1:], key=lambda row: int(row[4]))
        scale = size[0] / (right - left)
        box = [float(side) * scale for side in (u - 2, v - 2, w + 4, h + 4)]
        return (box if area >= 12 else None), size

    def select_boat(self) -> None:
        """Drags a box around the boat until the track is confirmed.

        A boat near the border leaves before a busy machine answers, and the boat of `arena1` leaves a camera
        at rest after 5 s, to the left. The camera is then turned by hand, as an operator does, to where the
        boat was seen; one that was engaged is engaged again afterwards.
        """
        across, said = 0.0, ["no red boat well inside the picture"]
        was_engaged = self.data["mode"] != "idle"

        def is_followed() -> bool:
            nonlocal across
            box, size = self.find_red()
            down = 0.0
            if box:
                across, down = (box[0] + box[2] / 2) / size[0], (box[1] + box[3] / 2) / size[1]
            if box and 0.1 <= across <= 0.9 and 0.1 <= down <= 0.9:
                self.drag(box, size)
                said.append(
                    f"{self.text('toast') or 'no answer'} (box {[round(side) for side in box]} of {size})"
                )
                return bool(poll(lambda: self.data["track"] == "tracking", 5, 0.03))
            self.disengage()
            key = "a" if across < 0.5 else "d"
            self.press(key)
            time.sleep(0.5)
            self.release(key)
            return False

        wait_until(is_followed, lambda: f"the track after {len(said) - 1} boxes: {said[-1]}", 90, 0.4)
        if was_engaged and self.data["mode"] == "idle":
            self.click("engage")


def started(program: Program, folder: pathlib.Path, name: str = "chromium", query: str = "") -> Page:
    """A page of a program, once it shows pictures."""
    page = Page(
        program.url.replace("/#", f"/{query}#") if "#" in program.url else program.url + query, folder, name
    )
    page.ready()
    return page


def axe_finds(page: Page) -> list[Any]:
    """What axe-core finds on the page that is serious or critical."""
    axe = Axe(page.driver)
    # The page runs its own scripts alone; the driver's are not bound by that.
    axe.inject()
    found = axe.run()["violations"]
    serious = [violation for violation in found if violation["impact"] in ("serious", "critical")]
    return [(violation["id"], violation["nodes"][0]["target"]) for violation in serious]


def scroll_bars(page: Page) -> list[str]:
    """The elements that scroll."""
    bars: list[str] = page.script("""
        const scrolls = (element) => {
          const { overflowX, overflowY } = getComputedStyle(element);
          const isRoot = element === document.documentElement;
          const can = (overflow) => ['auto', 'scroll'].includes(overflow) || isRoot;
          return (can(overflowY) && element.scrollHeight > element.clientHeight)
            || (can(overflowX) && element.scrollWidth > element.clientWidth);
        };
        return [...document.querySelectorAll('html, html *')].filter((e) => e.checkVisibility() && scrolls(e))
          .map((element) => element.id || element.tagName);""")
    return bars
