"""The operator's console in headless Chromium, on `demo` and on a file.

The boat is found in the picture by its colour, as an operator finds it, and a box is dragged around the boat.
The camera is engaged, turned by hand and stopped.
"""

import pathlib
import signal
import subprocess
import time
from collections.abc import Iterator
from typing import Any

import pytest
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.mouse_button import MouseButton
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from client import Program, is_inside
from conftest import Check, Clip
from drives import repeats
from machine import poll, wait_until
from page import Page, started
from process import Lines, end, spawn
from slow_line import SlowLine

pytestmark = pytest.mark.realtime

SIZE = "960x540"
# The world of a demo may run slower than the clock.
PATIENCE_S = 240.0
# Sizes of windows: laptops with and without the browser's bars, a screen enlarged to 125 %, tablets,
# telephones.
WINDOWS = (
    (1280, 800),
    (1280, 720),
    (1280, 600),
    (1280, 420),
    (1024, 576),
    (900, 500),
    (768, 1024),
    (640, 800),
    (390, 760),
    (844, 390),
)


def size_of(window: tuple[int, int]) -> str:
    return f"{window[0]}x{window[1]}"


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
      const lock = await request(kind).catch((error) => {
        window.spied.refusal = String(error);
        throw error;
      });
      window.spied.locks += 1;
      lock.addEventListener("release", () => { window.spied.locks -= 1; });
      return lock;
    };
"""


@pytest.fixture(scope="class")
def store(folder: pathlib.Path) -> pathlib.Path:
    return folder / "drive.jsonl"


@pytest.fixture(scope="class")
def demo(barrelman: pathlib.Path, store: pathlib.Path) -> Iterator[Program]:
    with Program(
        barrelman, "demo", "open", "--hands-on", "--law", "schema", "--size", SIZE, "--store", store
    ) as program:
        program.resume()
        yield program


@pytest.fixture(scope="class")
def demo_page(demo: Program, folder: pathlib.Path) -> Iterator[Page]:
    with started(demo, folder) as page:
        yield page


class TestDemo:
    def test_drive_without_encoding_is_drawn_as_jpeg(self, demo_page: Page) -> None:
        assert demo_page.data["path"] == "jpeg"

    def test_it_begins_unselected_and_disengaged(self, demo_page: Page) -> None:
        assert (demo_page.data["mode"], demo_page.data["track"]) == ("idle", "unseeded")

    def test_page_fits_1280x800(self, demo_page: Page) -> None:
        assert demo_page.script("return document.documentElement.scrollHeight") <= 800

    @pytest.mark.parametrize("window", WINDOWS, ids=size_of)
    def test_stop_engage_and_mode_are_in_view(self, demo_page: Page, window: tuple[int, int]) -> None:
        """Whole, without scrolling, and under nothing else."""
        demo_page.resize(*window)
        time.sleep(0.3)
        script = """
            const element = document.getElementById(arguments[0]);
            const { left, top, right, bottom } = element.getBoundingClientRect();
            const isWhole = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
            const above = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
            return isWhole && element.contains(above);"""
        hidden = [
            name for name in ("stop", "engage", "disengage", "mode") if not demo_page.script(script, name)
        ]
        demo_page.resize(1280, 800)
        assert not hidden

    @pytest.mark.parametrize("window", [(1280, 800), (390, 760), (844, 390)], ids=size_of)
    def test_stop_is_taken_while_the_keys_are_shown_and_the_keys_are_readable(
        self, demo_page: Page, window: tuple[int, int]
    ) -> None:
        demo_page.resize(*window)
        demo_page.click("keys")
        before = int(demo_page.data["stops"])
        demo_page.click("stop")
        demo_page.wait(lambda data: int(data["stops"]) > before, "the stop")
        is_open, title_top, narrowest = demo_page.script("""
            const dialog = document.getElementById('keys-dialog');
            const title = document.getElementById('keys-title').getBoundingClientRect();
            const widths = [...dialog.querySelectorAll('dd')].map((word) => word.clientWidth);
            return [dialog.open, title.top, Math.min(...widths)];""")
        demo_page.type(Keys.ESCAPE)
        is_open_after = demo_page.script("return document.getElementById('keys-dialog').open")
        demo_page.resize(1280, 800)
        assert is_open
        assert title_top >= 0
        assert narrowest >= 100
        assert not is_open_after

    def test_pad_is_held_by_the_left_button_alone(self, demo: Program, demo_page: Page) -> None:
        demo_page.hold("helm-up")
        demo.wait(lambda status: status["vessel"]["throttle"] > 0, "the throttle")
        demo_page.let_go()
        demo.wait(lambda status: status["vessel"]["throttle"] == 0, "the neutral boat")
        for act in ("pointer_down", "pointer_up"):
            right = ActionBuilder(demo_page.driver)
            getattr(right.pointer_action.move_to(demo_page.element("helm-up")), act)(MouseButton.RIGHT)
            right.perform()
            time.sleep(0.4)
            assert demo.status()["vessel"]["throttle"] == 0

    def test_key_whose_release_the_meta_key_swallows_is_not_held(
        self, demo: Program, demo_page: Page
    ) -> None:
        demo_page.press("up")
        demo.wait(lambda status: status["vessel"]["throttle"] > 0, "the throttle")
        demo_page.press(Keys.META)
        demo.wait(lambda status: status["vessel"]["throttle"] == 0, "the neutral boat")
        demo_page.release(Keys.META)
        # The browser repeats a key that is down, which holds it anew.
        demo_page.release("up")
        time.sleep(0.4)
        assert demo.status()["vessel"]["throttle"] == 0

    @pytest.mark.parametrize(
        ("pressed", "let_go", "code"),
        [("ArrowUp", "8", "Numpad8"), ("d", "ð", "KeyD")],
        ids=["number pad under Shift", "letter under AltGr"],
    )
    def test_key_is_let_go_whatever_its_name_is_by_then(
        self, demo: Program, demo_page: Page, pressed: str, let_go: str, code: str
    ) -> None:
        def is_held() -> bool:
            status = demo.status()
            return bool(status["vessel"]["throttle"] > 0 or status["command"]["pan"] > 0)

        demo_page.disengage()
        demo_page.key("keydown", pressed, code)
        wait_until(is_held, "the key to be held")
        demo_page.key("keyup", let_go, code)
        wait_until(lambda: not is_held(), "rest")
        time.sleep(0.4)
        assert not is_held()

    def test_wheel_that_turns_back_at_once_holds_nothing(self, demo: Program, demo_page: Page) -> None:
        demo_page.disengage()
        demo_page.script("""
            const turn = (deltaY) => document.getElementById('picture')
                .dispatchEvent(new WheelEvent('wheel', { deltaY, shiftKey: true, cancelable: true }));
            turn(-100);
            setTimeout(() => turn(100), 60);""")
        demo.wait(lambda status: status["command"]["zoom"] < 0, "the zoom out")
        demo.wait(lambda status: status["command"]["zoom"] == 0, "the end of the zoom")
        time.sleep(0.4)
        assert demo.status()["command"]["zoom"] == 0

    def test_key_that_is_held_through_a_stop_steers_no_more(self, demo: Program, demo_page: Page) -> None:
        demo_page.key("keydown", "ArrowUp", "ArrowUp")
        demo.wait(lambda status: status["vessel"]["throttle"] > 0, "the throttle")
        demo_page.type("space")
        demo.wait(lambda status: status["vessel"]["throttle"] == 0, "the neutral boat")
        # The operator brakes, and lets that key go: the first one is still down, and repeats.
        demo_page.key("keydown", "ArrowDown", "ArrowDown")
        demo.wait(lambda status: status["vessel"]["throttle"] < 0, "the boat to go astern", 8)
        demo_page.key("keyup", "ArrowDown", "ArrowDown")
        for _ in range(4):
            demo_page.key("keydown", "ArrowUp", "ArrowUp", repeat=True)
            time.sleep(0.1)
        throttle = demo.status()["vessel"]["throttle"]
        demo_page.key("keyup", "ArrowUp", "ArrowUp")
        assert throttle == 0

    def test_sounds_are_asked_for_and_the_screen_is_kept_awake(self, demo_page: Page, check: Check) -> None:
        page = demo_page
        page.follow_boat()
        page.script(SPIES)

        def spied() -> Any:
            return page.script("return window.spied")

        page.click("engage")
        page.wait_for_mode("servoing")
        wait_until(lambda: spied()["locks"] or spied()["refusal"], "the wake lock")
        check("engaged: the screen is kept awake", spied()["locks"] == 1, spied()["refusal"])
        check("no sound that was not asked for", not spied()["tones"], spied()["tones"])
        page.click("sound")
        is_marked = page.element("sound").get_attribute("aria-pressed")
        check(
            "the button Sound plays a tone, and says that it is on",
            (is_marked, spied()["tones"]) == ("true", [660, 880]),
            spied()["tones"],
        )
        page.type("space")
        page.wait_for_mode("stopped")
        wait_until(lambda: spied()["locks"] == 0, "the release of the wake lock")
        check("Stop has a tone of its own", spied()["tones"][2:3] == [330], spied()["tones"])
        page.click("sound")
        before = len(spied()["tones"])
        page.disengage()
        is_marked = page.element("sound").get_attribute("aria-pressed")
        check("switched off: no sound", (is_marked, len(spied()["tones"])) == ("false", before))

    def test_camera_follows_the_boat_that_leaves_and_brings_it_back(
        self, demo: Program, demo_page: Page, check: Check, pytestconfig: pytest.Config
    ) -> None:
        page = demo_page
        page.follow_boat()
        page.click("engage")
        page.wait_for_mode("servoing")
        page.press("up")

        def is_out() -> bool:
            """A boat that goes straight away from the camera is turned."""
            if poll(lambda: (demo.status()["percept"] or {}).get("p", 0) > 1.05, 20.0, 0.05):
                return True
            page.press("right")
            time.sleep(1.0)
            page.release("right")
            return False

        wait_until(is_out, "an excursion", PATIENCE_S)
        check("arrow up, held: the page has the helm", demo.status()["drive"]["helm"] == "page")
        demo.wait(lambda status: any(status["command"].values()), "a rate", PATIENCE_S)
        page.screenshots(pytestconfig.getoption("--screenshots"), "following")
        page.release("up")
        demo.wait(is_inside, "the boat in the ellipse", PATIENCE_S)

    def test_space_stops_and_d_turns_the_camera_by_hand(
        self, demo: Program, demo_page: Page, check: Check
    ) -> None:
        page = demo_page
        before = int(page.data["stops"])
        page.type("space")
        page.wait(
            lambda data: data["mode"] == "stopped" and int(data["stops"]) > before, "the acknowledged stop"
        )
        check("space: no rate", demo.status()["command"] == {"pan": 0.0, "tilt": 0.0, "zoom": 0.0})
        page.disengage()
        page.press("d")
        data = page.wait_for_mode("nudging")
        page.release("d")
        page.wait_for_mode("idle")
        check("d, held, turns the camera by hand", float(data["pan"]) > 0, data["pan"])

    def test_track_is_given_up_by_not_that_one_and_by_deselect(self, demo_page: Page) -> None:
        demo_page.follow_boat()
        demo_page.click("reject")
        demo_page.wait(lambda data: data["track"] == "lost", "the rejection")
        demo_page.click("deselect")
        demo_page.wait(lambda data: data["track"] == "unseeded", "the deselection")

    def test_law_is_switched_while_disengaged(self, demo: Program, demo_page: Page) -> None:
        demo_page.disengage()
        demo_page.click("level")
        Select(demo_page.element("law")).select_by_value("eco")
        demo.wait(lambda status: status["law"] == "eco", "the law")

    def test_browser_has_nothing_to_complain_about(self, demo_page: Page) -> None:
        assert not demo_page.complaints()

    def test_drive_runs_again_bit_for_bit_with_every_request(
        self, barrelman: pathlib.Path, demo: Program, demo_page: Page, store: pathlib.Path, check: Check
    ) -> None:
        demo_page.end()
        check("Ctrl-C ends it with exit 0", demo.end() == 0)
        repeats(barrelman, check, store, None)


def test_program_that_hangs_is_not_shown_as_one_that_decides(
    barrelman: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    program = Program(
        barrelman,
        "run",
        "--video",
        f"sim:open?size={SIZE}",
        "--link",
        "sim:",
        "--no-record",
        "--fault",
        "pilot:hang@12",
    )
    with started(program, tmp_path) as page:
        before = page.text("lost")
        wait_until(lambda: "HANGS" in page.text("lost"), "what the page says of a program that hangs")
        assert before == ""
    program.child.kill()


# Slower than the state alone.
SLOW_BYTES_PER_SECOND, SLOW_FOR_S, MOST_LATE_S = 60_000.0, 15.0, 6.0


@pytest.mark.alone
@pytest.mark.parametrize("path", ["stream", "jpeg"])
def test_page_behind_a_slow_line_is_late_by_seconds_at_most_and_says_so(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, path: str
) -> None:
    """The line's buffer has no bound, so that the program feels nothing of it."""
    with SlowLine() as line:
        config = tmp_path / "barrelman.toml"
        config.write_text(f'[console]\nhosts = ["{line.host}"]\n')
        record = ("--no-record",) if path == "jpeg" else ("--record", tmp_path / "run.mcap")
        what = ("--video", f"sim:open?size={SIZE}", "--link", "sim:", config, *record)
        program = Program(barrelman, "run", *what)
        line.leads_to = int(program.host.rpartition(":")[2])
        with Page(program.url.replace(program.host, line.host), tmp_path) as page:
            page.ready()
            wait_until(lambda: page.text("lost") == "", "a page that keeps up")
            line.rate = SLOW_BYTES_PER_SECOND
            wait_until(lambda: "LATE" in page.text("lost"), "what the page says of a slow line")
            wait_until(lambda: page.data["stale"] == "yes", "a picture that is dimmed")
            # What was under way when the line became slow takes some seconds.
            late = []
            for _ in range(round(SLOW_FOR_S / 0.1)):
                late.append((program.status()["at_ns"] - int(page.data["captured"])) / 1e9)
                time.sleep(0.1)
            later = late[len(late) // 2 :]
            check("the picture is late by seconds at most", max(later) < MOST_LATE_S, late[::10])
            page.type("space")
            program.wait(lambda status: status["stops_taken"], "a Stop over the slow line")
            line.rate = None
            page.wait(lambda data: data["loss"] == "" and data["stale"] == "no", "a page that keeps up again")
            check("nothing is wrong on the page", page.complaints() == [], page.complaints())
        assert program.end() == 0


def test_page_of_a_file_holds_the_first_picture_and_becomes_the_console(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check
) -> None:
    child = spawn(
        [barrelman, "run", "--listen", "127.0.0.1:0", "--video", f"file:{clip.video}", "--no-record"],
        stdout=subprocess.PIPE,
    )
    lines, errors = Lines(child.stdout), Lines(child.stderr)
    url = errors.wait_for(r"draw the box around the boat: http://")[1].split(": ", 1)[1].strip()
    check("the page for the first picture asks for the token", "#token=" in url, url.partition("#")[0])
    with Page(url, tmp_path) as page:
        size = wait_until(page.size, "the picture")
        check("the file does not play while the box is drawn", not lines.text(), lines.text()[-120:])
        page.drag([float(value) for value in clip.selection.split(",")], size)
        page.click_enabled("take")
        page.wait(
            lambda data: data.get("connected") == "yes" and data.get("track") == "tracking",
            "the console, with the track",
        )
    check("SIGINT ends it with exit 0", end(child, signal.SIGINT) == 0)
