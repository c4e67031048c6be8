"""A newcomer's path: the page opens, the boat is driven, tapped, followed, sent to a mark, stopped.

The sortie is watched again, and its film is fetched. No step may take long, on any size of the window.
"""

import pathlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import pytest

from client import Program
from conftest import Check
from firefox import FirefoxPage
from machine import poll, wait_until
from page import Page

pytestmark = pytest.mark.apart

SIZES = [(1280, 800), (768, 1024), (390, 844), (844, 390)]
# A step on an idle machine takes a second; two cores are busy here with two browsers and a world.
LONGEST_S = 10.0


class Path:
    """The steps of the path, each with the time until its effect is seen."""

    def __init__(self) -> None:
        self.took: dict[str, float] = {}

    def step(self, what: str, act: Callable[[], object], seen: Callable[[], object]) -> None:
        began = time.monotonic()
        act()
        wait_until(seen, what, pause=0.03)
        self.took[what] = round(time.monotonic() - began, 2)


@contextmanager
def chromium(url: str, folder: pathlib.Path, size: tuple[int, int]) -> Iterator[Page]:
    with Page("about:blank", folder) as page:
        page.resize(*size)
        page.driver.get(url)
        yield page


@contextmanager
def firefox(url: str, folder: pathlib.Path, size: tuple[int, int]) -> Iterator[Page]:
    with FirefoxPage(url, folder, size) as page:
        yield page


BROWSERS = [
    *(pytest.param(chromium, size, id="x".join(map(str, size))) for size in SIZES),
    pytest.param(firefox, SIZES[0], id="firefox", marks=pytest.mark.long),
]


@pytest.mark.parametrize(("browser", "size"), BROWSERS)
def test_newcomer_gets_from_the_page_to_the_film(
    barrelman: pathlib.Path,
    tmp_path: pathlib.Path,
    check: Check,
    browser: Callable[..., Any],
    size: tuple[int, int],
    pytestconfig: pytest.Config,
    record_property: Callable[[str, object], None],
) -> None:
    pictures = pytestconfig.getoption("--screenshots")
    name = f"newcomer-{browser.__name__}-{size[0]}x{size[1]}"
    (tmp_path / "config.toml").write_text(f'[recording]\nfolder = "{tmp_path}"\n')
    sim = ["--video", "sim:first-drive?size=480x270", "--link", "sim:", "--vessel", "sim:", "--hands-on"]
    path = Path()
    with Program(barrelman, "run", tmp_path / "config.toml", *sim) as program:
        with browser(program.url, tmp_path, size) as page:
            fly(program, page, path, check)
            page.screenshot(pictures, f"{name}-stopped")
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
    watch(barrelman, tmp_path, browser, size, path, pictures and pictures / f"{name}-watched.png")
    record_property("took_s", path.took)
    slow = {what: took for what, took in path.took.items() if took > LONGEST_S}
    check("no step takes long", not slow, path.took)


def fly(program: Program, page: Page, path: Path, check: Check) -> None:
    """From the first picture to the stop."""
    path.step("the first picture", lambda: None, lambda: int(page.data.get("drawn", 0)) > 0)
    path.step("the boat driven", lambda: page.press("up"), lambda: vessel(program)["mode"] == "by-hand")
    page.release("up")
    tap_boat(program, page, path)
    path.step("engaged", lambda: page.click("engage"), lambda: page.data["mode"] in ("servoing", "holding"))
    path.step("marking", lambda: page.click("mark"), lambda: "marking" in classes(page))
    (width, height) = page.size() or (480, 270)
    at = (width / 2, height * 0.45, 0, 0)
    path.step("a mark", lambda: page.drag(at, (width, height)), lambda: vessel(program)["marks"])
    path.step(
        "the boat under way", lambda: go(page), lambda: vessel(program)["mode"] in ("guided", "holding")
    )
    path.step("stopped", lambda: page.type("space"), lambda: page.data["mode"] == "stopped")
    check("the boat is stopped, too", vessel(program)["mode"] == "stopped", vessel(program)["mode"])
    complaints = page.complaints()
    check("the browser has nothing to complain about", not complaints, complaints)


def tap_boat(program: Program, page: Page, path: Path) -> None:
    """Taps the boat until it is followed: a first tap proposes it, or takes it where it has a number."""

    def is_proposed() -> bool:
        box, size = page.find_red()
        if box is None:
            return False
        page.drag((box[0] + box[2] / 2, box[1] + box[3] / 2, 0, 0), size)
        return bool(poll(lambda: program.status()["proposal"] or is_taken(), 2.0, 0.03))

    def is_taken() -> bool:
        track = program.status()["track"]
        return bool(track["confirming"] or track["state"] == "tracking")

    def is_followed() -> bool:
        proposal = program.status()["proposal"]
        if proposal:
            u, v, w, h = proposal["box"]
            page.drag((u + w / 2, v + h / 2, 0, 0), page.size() or (480, 270))
        elif not is_taken() and not is_proposed():
            # A busy machine shows the picture late, and the boat has moved on.
            return False
        return bool(poll(lambda: program.status()["track"]["state"] == "tracking", 2.0, 0.03))

    path.step("a proposal", lambda: None, is_proposed)
    path.step("the boat followed", lambda: None, is_followed)


def go(page: Page) -> None:
    """Presses Go; a second time where the page asks for it."""
    page.click_enabled("guide")


def classes(page: Page) -> str:
    return str(page.script("return document.getElementById('stage').className"))


def vessel(program: Program) -> Any:
    return program.status()["vessel"]


def watch(
    barrelman: pathlib.Path,
    folder: pathlib.Path,
    browser: Callable[..., Any],
    size: tuple[int, int],
    path: Path,
    picture: pathlib.Path | None,
) -> None:
    """The library of the next run plays the sortie, and its film is fetched."""
    recording = next(folder.glob("run-*.mcap")).name
    second = folder / "second"
    second.mkdir()
    options = [folder / "config.toml", "--video", "sim:arena1?size=320x180", "--no-record"]
    with (
        Program(barrelman, "run", *options) as program,
        browser(program.url, second, size) as page,
    ):
        path.step("the second page", lambda: None, lambda: int(page.data.get("drawn", 0)) > 0)

        def place() -> float:
            return float(page.script("return document.getElementById('scene')?.dataset.ms ?? -1"))

        address = f"http://{program.host}/library#{recording}"
        path.step("the sortie opened", lambda: page.driver.get(address), lambda: place() >= 0)
        path.step("the sortie played", lambda: page.click("play-button"), lambda: place() > 1000)
        if picture:
            picture.parent.mkdir(parents=True, exist_ok=True)
            page.driver.save_screenshot(str(picture))
        page.click("make-film")
        link = "return document.querySelector('#files a[href$=\"annotated.mp4\"]')?.href"
        wait_until(lambda: page.script(link), "the film", 120.0)
        status, film, _ = program.ask("GET", f"/api/v1/recordings/{recording}/annotated.mp4")
        assert status == 200
        (folder / "film.mp4").write_bytes(film)
        assert cv2.VideoCapture(str(folder / "film.mp4")).read()[0], "the film has a first picture"
