"""The page of the recordings: a sortie is recorded, found in the list, watched again, renamed and deleted."""

import json
import pathlib
import time
from collections.abc import Callable
from typing import Any

import cv2
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from client import DISENGAGE, ENGAGE, Program, Request
from conftest import Check
from machine import wait_until
from page import Page, axe_finds, scroll_bars, started
from process import ROOT, end, memory_mb, run
from recording import Recording, prolonged

pytestmark = pytest.mark.realtime

EXPORTED = ["annotated.mp4", "report.html", "video.mp4", "trial.csv"]
WORLD = "sim:arena1?seed=3&size=640x360"


def recordings(program: Program) -> dict[str, dict[str, Any]]:
    status, body, _ = program.ask("GET", "/api/v1/recordings")
    assert status == 200, body
    return {recording["name"]: recording for recording in json.loads(body)}


@pytest.fixture(scope="module")
def sorties(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """A folder with a recording, and a configuration that names the folder."""
    folder = tmp_path_factory.mktemp("sorties")
    (folder / "config.toml").write_text(f'[recording]\nfolder = "{folder}"\n')
    for name in ("first.mcap", "second.mcap"):
        options = ["--video", WORLD, "--link", "sim:", "--engage", "--record", folder / name]
        with Program(barrelman, "run", *options) as program:
            program.wait(lambda status: status["mode"]["name"] == "servoing", "the engagement")
            time.sleep(5)
    return folder


@pytest.fixture
def program(barrelman: pathlib.Path, sorties: pathlib.Path) -> Program:
    return Program(barrelman, "run", sorties / "config.toml", "--video", WORLD, "--link", "sim:")


def seek(page: Page, ms: int) -> None:
    """Draws the slider to a time, as a pointer does."""
    page.script(
        "const slider = document.getElementById('position'); slider.value = arguments[0];"
        "slider.dispatchEvent(new Event('input', { bubbles: true }))",
        ms,
    )


def test_sortie_is_watched_again(program: Program, folder: pathlib.Path, check: Check) -> None:
    listed = recordings(program)
    current = next(name for name in listed if name.startswith("run-"))
    check("the present sortie is told", listed[current]["state"] == "being-recorded", listed[current])
    with Page(program.url, folder) as page:
        page.ready()
        # The cookie of the console is the one of the library.
        page.driver.get(f"http://{program.host}/library#first.mcap")
        driver = page.driver

        def text(name: str) -> str:
            return str(driver.find_element(By.ID, name).text)

        wait_until(lambda: text("name") == "first.mcap", "the chosen recording")
        images = "return [...document.querySelectorAll('#recordings img')].map((image) => image.naturalWidth)"
        wait_until(
            lambda: page.script(images) == [640, 640], lambda: f"two thumbnails ({page.script(images)})"
        )
        check("the summary is there", "Engaged" in text("summary"), text("summary"))

        def drawn() -> float:
            """The time of the newest picture, ms; -1 before the first."""
            return float(page.script("return document.getElementById('scene').dataset.ms ?? -1"))

        def position() -> float:
            return float(page.script("return document.getElementById('position').value"))

        began = time.monotonic()
        wait_until(lambda: drawn() >= 0, lambda: text("no-picture"))
        check("the first picture is there soon", time.monotonic() - began < 3.0, time.monotonic() - began)
        driver.find_element(By.ID, "play-button").click()
        wait_until(lambda: position() > 1500, lambda: f"the play ({position()})")
        wait_until(lambda: "FOLLOWING" in text("scene"), lambda: text("scene"))
        ink = """
            const canvas = document.getElementById('strips');
            const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
            return pixels.filter((value, index) => index % 4 === 3 && value > 0).length"""
        wait_until(lambda: page.script(ink) > 3000, lambda: f"the strips ({page.script(ink)} pixels)")
        driver.find_element(By.ID, "play-button").click()
        wait_until(lambda: text("play-button") == "Play", lambda: text("play-button"))
        stood = drawn()
        driver.find_element(By.ID, "on").click()
        wait_until(lambda: stood < drawn() < stood + 300, lambda: f"a picture on ({drawn()}, {stood})")
        forward = drawn()
        driver.find_element(By.ID, "back").click()
        wait_until(lambda: drawn() < forward, lambda: f"a picture back ({drawn()}, {forward})")
        began = time.monotonic()
        seek(page, 4000)
        wait_until(lambda: 0 <= 4000 - drawn() < 300, lambda: f"the picture at 4 s ({drawn()})")
        check("the place is found soon", time.monotonic() - began < 2.0, time.monotonic() - began)
        driver.save_screenshot(str(folder / "library.png"))
        Select(driver.find_element(By.ID, "beside")).select_by_visible_text("second.mcap")
        wait_until(lambda: text("second-scene") != "", "the recording beside it")
        driver.save_screenshot(str(folder / "beside.png"))
        driver.find_element(By.ID, "make-film").click()
        wait_until(lambda: recordings(program)["first.mcap"]["film"] == "ready", "the film")
        exported = recordings(program)["first.mcap"]["exported"]
        check("film, report and table are there", exported == EXPORTED, exported)
        report = program.ask("GET", "/api/v1/recordings/first.mcap/report.html")[1].decode()
        check("the report speaks of a sortie", "sortie" in report.lower(), report[:200])
        film = folder / "film.mp4"
        film.write_bytes(program.ask("GET", "/api/v1/recordings/first.mcap/annotated.mp4")[1])
        opened = cv2.VideoCapture(str(film))
        length = opened.get(cv2.CAP_PROP_FRAME_COUNT) / opened.get(cv2.CAP_PROP_FPS)
        # The world is slower than the clock on a busy machine.
        sortie = recordings(program)["first.mcap"]["sortie"]["length_s"]
        check(
            "the film is as long as the sortie", sortie - 0.6 < length <= sortie + 0.2, f"{length}, {sortie}"
        )
        for theme in ("day", "night"):
            page.script("document.documentElement.dataset.theme = arguments[0]", theme)
            found = axe_finds(page)
            check(f"axe-core finds nothing serious by {theme}", not found, found)
            check(f"there is one scroll bar by {theme}", len(scroll_bars(page)) <= 1, scroll_bars(page))
        ticks = driver.find_elements(By.CSS_SELECTOR, "#ticks button")
        check("the moments are ticks on the time bar", len(ticks) >= 1, len(ticks))
        errors = [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]
        check("no error on the page", not errors, errors)
    end(program.child)


# Until the picture of a time is drawn, ms; `arguments[0]`: the time, `arguments[1]`: what asks for it.
UNTIL_DRAWN = """
const [ms, ask, done] = arguments;
const [slider, scene] = ["position", "scene"].map((name) => document.getElementById(name));
const began = performance.now();
delete scene.dataset.ms;
if (ask === "seek") {
  slider.value = ms;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
} else document.querySelector(`#recordings li:nth-child(${ask}) button`).click();
const isDrawn = () => Math.abs((scene.dataset.ms ?? -1000) - ms) < 300;
const look = () => (isDrawn() ? done(performance.now() - began) : requestAnimationFrame(look));
look();
"""


def test_library_asks_a_stranger_for_the_token(program: Program, folder: pathlib.Path) -> None:
    with program, Page(f"http://{program.host}/library", folder, "stranger") as page:
        wait_until(lambda: page.element("entry").is_displayed(), "the question")
        page.element("token").send_keys(program.token, Keys.ENTER)
        wait_until(lambda: "run-" in page.text("recordings"), "the list")


def test_half_an_hour_opens_and_seeks_at_once(
    barrelman: pathlib.Path,
    sorties: pathlib.Path,
    folder: pathlib.Path,
    check: Check,
    record_property: Callable[[str, object], None],
) -> None:
    library = folder / "long"
    library.mkdir()
    prolonged(sorties / "first.mcap", library / "long.mcap", 1800)
    (library / "config.toml").write_text(f'[recording]\nfolder = "{library}"\n')
    video = ["--video", "sim:arena1?size=320x180", "--no-record"]
    with (
        Program(barrelman, "run", library / "config.toml", *video) as program,
        Page(program.url, folder, "long") as page,
    ):
        page.ready()
        page.driver.set_script_timeout(30)
        page.driver.get(f"http://{program.host}/library")
        wait_until(lambda: page.script("return document.querySelector('#recordings button')"), "the list")
        before = memory_mb(program.child)
        opened = page.driver.execute_async_script(UNTIL_DRAWN, 0, 1)
        places = range(90_000, 1_800_000, 170_000)
        sought = sorted(page.driver.execute_async_script(UNTIL_DRAWN, ms, "seek") for ms in places)
        record_property("opened_ms", opened)
        record_property("sought_ms", [round(ms) for ms in sought])
        check("it opens within a second", opened < 1000, opened)
        median = sought[len(sought) // 2]
        check("it seeks within 0.3 s, in the median", median < 300, sought)
        grown = memory_mb(program.child) - before
        check("the program keeps none of it", grown < 80, grown)


def test_recording_is_renamed_and_deleted_while_disengaged_alone(
    program: Program, sorties: pathlib.Path, check: Check
) -> None:
    (sorties / "copy.mcap").write_bytes((sorties / "first.mcap").read_bytes())

    def ask(method: str, path: str, body: object = None) -> int:
        return program.ask(method, f"/api/v1/recordings/{path}", body)[0]

    check("a name leads nowhere else", ask("DELETE", "..%2Fcopy.mcap") == 400)
    check("an unknown recording is none", ask("DELETE", "third.mcap") == 404)
    check("a name is not taken twice", ask("POST", "copy.mcap/name", {"to": "first.mcap"}) == 409)
    check("it is renamed", ask("POST", "copy.mcap/name", {"to": "Übung 2.mcap"}) == 204)
    check("to that name", (sorties / "Übung 2.mcap").exists())
    program.wait(lambda status: status["track"]["state"] == "tracking", "the boat")
    program.request(ENGAGE)
    program.wait(lambda status: status["mode"]["name"] == "servoing", "the engagement")
    check("it is not deleted while the camera follows", ask("DELETE", "%C3%9Cbung%202.mcap") == 409)
    program.request(DISENGAGE)
    program.wait(lambda status: status["mode"]["name"] == "idle", "the rest")
    check("it is deleted", ask("DELETE", "%C3%9Cbung%202.mcap") == 204)
    check("for good", not (sorties / "Übung 2.mcap").exists())
    end(program.child)


def test_marked_moment_is_found_again(
    barrelman: pathlib.Path, sorties: pathlib.Path, folder: pathlib.Path, check: Check
) -> None:
    program = Program(barrelman, "run", sorties / "config.toml", "--video", WORLD, "--link", "sim:")
    with started(program, folder) as page:
        page.wait_until_enabled("note")
        page.type("m")
        wait_until(lambda: "marked" in page.text("toast"), lambda: page.text("toast"))
    text = "smoke at the pier"
    check("a program's note", program.request(Request("note", text=text))["answer"] == "accepted")
    long = program.request(Request("note", text="x" * 201))
    check("a text that is too long is named", "201 characters" in long["reason"], long)
    name = next(name for name, one in recordings(program).items() if one["state"] == "being-recorded")
    end(program.child)
    path = sorties / name
    listed = json.loads(run([barrelman, "library", path, "--json"]).stdout)
    notes = [moment["text"] for moment in listed["sortie"]["moments"] if moment["what"] == "noted"]
    check("both are in the summary", notes == ["", text], listed)
    done = run([barrelman, "report", path, "--output", folder / "report.html"])
    check("the report speaks of a sortie", "1 sortie" in done.stdout, done)
    page_text = (folder / "report.html").read_text()
    check("and has the moment", f"moment marked: {text}" in page_text and "1 sortie" in page_text)
    run([barrelman, "export", path, "--output", folder / "export"])
    rows = (folder / "export/note.csv").read_text().splitlines()
    check("the export has them", len(rows) == 3 and rows[2].endswith(text), rows)
    done = run([barrelman, "replay", path, "--compare"], timeout=120)
    check("the replay is unchanged", done.returncode == 0, done)


def test_recording_that_was_cut_has_its_figures_or_says_why_not(
    program: Program, sorties: pathlib.Path, folder: pathlib.Path, check: Check
) -> None:
    whole = (sorties / "first.mcap").read_bytes()
    (sorties / "cut.mcap").write_bytes(whole[: len(whole) * 2 // 3])
    (sorties / "empty.mcap").write_bytes(whole[:8])

    def summary(name: str) -> tuple[int, bytes]:
        return program.ask("GET", f"/api/v1/recordings/{name}/sortie.json")[:2]

    complete = json.loads(summary("first.mcap")[1])
    check("the summary is downloaded", complete == recordings(program)["first.mcap"]["sortie"], complete)
    status, body = summary("cut.mcap")
    check("one of a cut recording, too", status == 200, body)
    length = json.loads(body)["length_s"]
    check("of what is there", 1 < length < complete["length_s"], length)
    status, body = summary("empty.mcap")
    reason = b"empty.mcap is no recording that can be read"
    check("or the reason is told", status == 422 and body.startswith(reason), (status, body))
    with Page(program.url, folder, "cut") as page:
        page.ready()
        page.driver.get(f"http://{program.host}/library#cut.mcap")
        wait_until(lambda: "Engaged" in page.text("summary"), lambda: page.text("no-summary"))
        check("the page says so", "cut off" in page.text("no-summary"), page.text("no-summary"))
        page.driver.save_screenshot(str(folder / "cut.png"))
    end(program.child)


def strings(value: Any) -> list[str]:
    """All strings of a JSON value, the keys of its objects among them."""
    if isinstance(value, dict):
        return [text for key, item in value.items() for text in [key, *strings(item)]]
    if isinstance(value, list):
        return [text for item in value for text in strings(item)]
    return [value] if isinstance(value, str) else []


@pytest.mark.parametrize("name", ["foxglove-layout.json", "lichtblick-layout.json"])
def test_layout_names_what_a_recording_holds(sorties: pathlib.Path, check: Check, name: str) -> None:
    record = Recording(sorties / "first.mcap")
    layout = json.loads((ROOT / "docs" / name).read_text())
    named = {text for text in strings(layout) if text.startswith("/")}
    check("something is named", len(named) >= 9, named)
    # A simulated boat has no latitude and longitude.
    for path in named - {"/boat/location"}:
        topic, *fields = path.split(".")
        check(f"{topic} is recorded", record[topic], sorted(record.topics))
        found = type(record[topic][0]).DESCRIPTOR
        for field in fields:
            check(f"{path} is a field", field in found.fields_by_name, list(found.fields_by_name))
            found = found.fields_by_name[field].message_type
