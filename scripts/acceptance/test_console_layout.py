"""The console's layout in headless Chromium: no control moves by the state, and everything is in reach.

One demo serves the page; its messages are changed on their way to the page, so that every state comes up.
"""

import pathlib
from collections.abc import Iterator
from typing import Any

import pytest
from selenium.webdriver.common.keys import Keys

from altered import AlteredPage
from client import Program
from console_states import BOX, OTHER, PERSON, PERSON_AT, STATES, State, mode
from machine import wait_until
from page import Page, scroll_bars

SIZES = ((1280, 800), (1920, 1080), (768, 1024), (390, 844), (844, 390))
LEVELS = ("operate", "expert")
Rectangles = dict[str, list[float]]


def size_of(size: tuple[int, int]) -> str:
    return f"{size[0]}x{size[1]}"


RECTANGLES = """
const all = {};
const shown = 'button, select, summary, #mode, #next-action, #seat, #picture, #boat-mode, #stage';
for (const element of document.querySelectorAll(shown)) {
  if (element.closest('dialog, #asking, #entry, #hint') || !element.checkVisibility()) continue;
  const { x, y, width, height } = element.getBoundingClientRect();
  all[element.id || element.parentElement.id] = [x, y, width, height];
}
return all;
"""


@pytest.fixture(scope="module")
def page(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[AlteredPage]:
    options = ["demo", "open", "--hands-on", "--size", "640x360"]
    with Program(barrelman, *options) as program:
        program.resume()
        with AlteredPage(program, tmp_path_factory.mktemp("layout")) as page:
            yield page


def show(page: AlteredPage, size: tuple[int, int], level: str) -> None:
    page.alter({}, "d.connected === 'yes' && d.old === 'no' && d.controlling === 'yes'")
    page.resize(*size)
    if page.data["level"] != level:
        page.click("level")
    page.script("document.querySelector('main').scrollTop = 0")


def enter(page: AlteredPage, state: State) -> Rectangles:
    changes = {"snapshot": state.snapshot, **state.more}
    if state.press:
        page.alter(changes, f"!document.getElementById('{state.press}').disabled")
        page.script("document.getElementById(arguments[0]).click()", state.press)
    page.alter(changes, state.shown)
    rectangles: Rectangles = page.script(RECTANGLES)
    if state.press:
        page.type(Keys.ESCAPE)
    return rectangles


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("size", SIZES, ids=size_of)
def test_no_control_moves_by_the_state(page: AlteredPage, size: tuple[int, int], level: str) -> None:
    show(page, size, level)
    found = {name: enter(page, state) for name, state in STATES.items()}
    first = found["disengaged"]
    assert {"stop", "engage", "disengage", "mark", "guide", "nudge-up", "helm-up", "pause"} <= set(first)
    moved = {
        f"{control}, {name}": (first.get(control), rectangles.get(control))
        for name, rectangles in found.items()
        for control in set(first) | set(rectangles)
        if first.get(control) != rectangles.get(control)
    }
    assert not moved


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("size", SIZES, ids=size_of)
def test_freezing_moves_nothing(page: AlteredPage, size: tuple[int, int], level: str) -> None:
    show(page, size, level)
    page.wait(lambda data: data["frozen"] == "no", "the end of the freeze before")
    before = page.script(RECTANGLES)
    # Within one task of the page: the freeze lasts 1.3 s.
    frozen, is_frozen = page.script(f"""
        document.getElementById('freeze').click();
        const rectangles = (() => {{ {RECTANGLES} }})();
        return [rectangles, !document.getElementById('frozen').hidden]""")
    assert is_frozen
    assert not {name: (before.get(name), at) for name, at in frozen.items() if before.get(name) != at}
    assert set(before) == set(frozen)


@pytest.mark.parametrize("size", SIZES, ids=size_of)
def test_controls_do_not_overlap(page: AlteredPage, size: tuple[int, int]) -> None:
    """Mode, advice, picture, Stop, Engage and the pad of the boat are whole in view, under nothing else."""
    show(page, size, "operate")
    covered = page.script("""
        const names = ['mode', 'next-action', 'picture', 'stop', 'engage', 'disengage', 'helm-up'];
        return names.filter((name) => {
          const element = document.getElementById(name);
          const { left, top, right, bottom } = element.getBoundingClientRect();
          const isWhole = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
          const middle = [(left + right) / 2, (top + bottom) / 2];
          const points = [[left + 9, top + 9], [right - 9, bottom - 9], middle];
          const isFree = ([x, y]) => element.contains(document.elementFromPoint(x, y));
          return !isWhole || !points.every(isFree);
        });""")
    assert not covered


@pytest.mark.parametrize("size", SIZES, ids=size_of)
def test_every_advice_and_mode_fits_its_room(page: AlteredPage, size: tuple[int, int]) -> None:
    show(page, size, "operate")
    too_long = page.driver.execute_async_script("""
        const done = arguments[0];
        const files = [import('/console/status.js'), import('/console/words.js')];
        Promise.all(files).then(([{ showAdvice, showMode }, { words, sentence }]) => {
          const [advice, mode] = ['next-action', 'mode'].map((name) => document.getElementById(name));
          const isWhole = (e) => e.scrollHeight <= e.clientHeight && e.scrollWidth <= e.clientWidth;
          const found = [];
          const alarms = Object.values(words.alarms).map((text) => `${sentence(text)}.`);
          for (const text of [...Object.values(words.next), ...alarms]) {
            showAdvice(text);
            if (!isWhole(advice)) found.push(text);
          }
          for (const name of Object.keys(words.modes)) {
            const isCaused = name === 'holding' || name === 'stopped';
            for (const cause of isCaused ? Object.keys(words.causes) : [null]) {
              showMode({ mode: { name, cause }, track: { confirming: false } }, null, 0);
              if (!isWhole(mode)) found.push(`${name}: ${cause}`);
            }
          }
          done(found);
        }, (error) => done([String(error)]));""")
    assert not too_long


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("size", [*SIZES, (1280, 790), (1280, 720), (1280, 600), (900, 500)], ids=size_of)
def test_there_is_one_scroll_bar_at_most(page: AlteredPage, size: tuple[int, int], level: str) -> None:
    show(page, size, level)
    bars = scroll_bars(page)
    assert len(bars) <= 1, bars
    if size[0] == 1280 and size[1] >= 720:
        assert not set(bars) - {"events"}


def spread(page: AlteredPage, x: float, y: float) -> None:
    """Two fingers go apart on the screen."""

    def touch(kind: str, *points: tuple[float, float]) -> None:
        fingers = [{"x": u, "y": v, "id": number} for number, (u, v) in enumerate(points)]
        page.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})

    touch("touchStart", (x - 6, y))
    touch("touchStart", (x - 6, y), (x + 6, y))
    for way in range(0, 80, 8):
        touch("touchMove", (x - 6 - way, y), (x + 6 + way, y))
    touch("touchEnd")


@pytest.mark.parametrize("size", [(390, 844), (844, 390)], ids=size_of)
def test_two_fingers_beside_the_picture_do_not_zoom_the_page(
    page: AlteredPage, size: tuple[int, int]
) -> None:
    show(page, size, "operate")
    # Only a telephone's browser zooms the page by two fingers.
    telephone = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": True}
    page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", telephone)
    page.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})
    for name in ("stop", "next-action", "nudge-up", "engage", "picture"):
        x, y = page.script(
            """
            const { x, y, width, height } = document.getElementById(arguments[0]).getBoundingClientRect();
            return [x + width / 2, y + height / 2]""",
            name,
        )
        spread(page, x, y)
        assert page.script("return visualViewport.scale") == 1, name
    page.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})
    page.script("document.getElementById('zoom-reset').click()")


def test_video_that_does_not_come_is_said_across_the_picture(page: AlteredPage) -> None:
    show(page, (1280, 800), "expert")
    page.wait(lambda data: data["delayMs"], "a delay")
    page.alter({"drops": "video"}, "d.stale === 'yes'")
    wait_until(lambda: "No video for 2 s" in page.text("no-video"), lambda: page.text("no-video"))
    assert page.data["delayMs"] == ""
    assert "ms" not in page.text("path")
    assert "brightness" in page.script("return getComputedStyle(document.getElementById('picture')).filter")
    page.alter({}, "d.stale === 'no'")
    assert page.text("no-video") == ""


def test_lost_connection_does_not_go_on_saying_following(page: AlteredPage) -> None:
    show(page, (1280, 800), "operate")
    page.alter({"snapshot": {"mode": mode("servoing")}}, "d.mode === 'servoing'")
    fill = "return getComputedStyle(document.getElementById('mode')).backgroundColor"
    before = page.script(fill)
    page.alter({"drops": "all"}, "d.old === 'yes'")
    wait_until(lambda: "last known, 3 s ago" in page.text("mode"), lambda: page.text("mode"))
    assert page.script(fill) != before
    assert "CONNECTION LOST" in page.text("lost")


def test_old_place_of_a_person_is_renewed_by_one_tap(page: AlteredPage) -> None:
    show(page, (1280, 800), "operate")
    person = {"mode": mode("servoing"), "track": BOX, "vessel": {"marks": [PERSON], "mode": "guided"}}
    page.alter({"snapshot": person}, "d.next === 'person'")
    assert "Drag the mark onto the person" in page.text("next-action")
    page.script("""
        window.sent = [];
        const send = WebSocket.prototype.send;
        WebSocket.prototype.send = function (data) {
          window.sent.push(JSON.parse(data));
          send.call(this, data);
        };""")
    page.drag([*PERSON_AT, 0, 0], page.size() or ())

    def moves() -> Any:
        sent = page.script(
            "return window.sent.filter(({ type }) => type === 'request').map((m) => m.request)"
        )
        return [request for request in sent if request["kind"] == "move-mark"]

    request = wait_until(moves, "the request")[0]
    u, v = PERSON_AT
    assert (request["id"], request["at"]) == (PERSON["id"], {"u": u, "v": v})


def test_escape_leaves_marking_wherever_the_focus_is(page: AlteredPage) -> None:
    show(page, (1280, 800), "operate")
    page.click_enabled("mark")
    page.wait(lambda data: data["marking"] == "yes", "marking")
    page.type(Keys.ESCAPE)
    page.wait(lambda data: data["marking"] == "no", "the end of marking")


def test_asking_for_control_shows_that_it_asked(page: AlteredPage) -> None:
    show(page, (1280, 800), "operate")
    page.alter({"hello": {"client": 12}, "control": {"holder": OTHER, "asking": [12]}}, "d.next === 'asked'")
    assert page.text("ask-control") == "Asked: waiting"
    assert not page.element("ask-control").is_enabled()
    page.alter({"control": {"holder": OTHER, "asking": []}}, "d.next === 'watch'")
    assert page.text("ask-control") == "Ask for control"


def test_list_of_laws_shows_the_law_in_force_after_a_new_start(page: AlteredPage) -> None:
    show(page, (1280, 800), "expert")
    law = "return document.getElementById('law').value"
    page.alter({"snapshot": {"law": "eco"}}, "document.getElementById('law').value === 'eco'")
    # The first message comes again, with a list of its own, as after a new start.
    page.alter({"snapshot": {"law": "eco"}}, "d.connected === 'yes'")
    wait_until(lambda: page.script(law) == "eco", "the law in force")


def test_level_is_remembered_and_begins_with_operate(page: AlteredPage) -> None:
    page.script("localStorage.removeItem('level')")
    page.driver.refresh()
    page.ready()
    assert page.data["level"] == "operate"
    assert not page.element("figures").is_displayed()
    page.click("level")
    page.driver.refresh()
    page.ready()
    assert page.data["level"] == "expert"
    assert page.element("figures").is_displayed()


def test_no_figure_is_minus_zero(page: AlteredPage) -> None:
    show(page, (1280, 800), "expert")
    tiny = {
        "net_yaw_deg": -0.2,
        "command": {"pan": -0.001, "tilt": -0.0001, "zoom": 0.1},
        "zoom": {"ratio": 2.0, "keeps_size": True},
        "drive": {"speed_m_per_s": -0.01},
        "boat": {"distance_m": 40.0, "std_dev_m": 0.4, "direction_deg": -0.3, "on_earth": None},
        "vessel": {"rudder": -0.001, "throttle": -0.001},
    }
    page.alter({"snapshot": tiny}, "d.pan === '-0.001'")
    text = page.script("return document.body.innerText.replaceAll('\\u2212', '-')")
    assert not [
        word
        for word in text.split()
        if word.rstrip("°%,").strip("+").replace(".", "") in ("-0", "-00", "-000")
    ]


def test_wrong_token_of_a_link_is_said_to_be_wrong(barrelman: pathlib.Path, tmp_path: pathlib.Path) -> None:
    options = ["--video", "sim:open?size=640x360", "--link", "sim:", "--no-record"]
    with (
        Program(barrelman, "run", *options) as program,
        Page(f"http://{program.host}/#token={'x' * 22}", tmp_path) as page,
    ):
        wait_until(lambda: page.element("entry").is_displayed(), "the question for a token")
        assert "token of the link that was opened is not known" in page.text("entry-error")
        assert page.driver.title == "Barrelman: access"


def test_orderly_end_of_the_program_is_no_lost_connection(
    barrelman: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    options = ["--video", "sim:open?size=640x360", "--link", "sim:", "--no-record"]
    program = Program(barrelman, "run", *options)
    with Page(program.url, tmp_path) as page:
        page.ready()
        assert program.end() == 0
        wait_until(lambda: page.text("lost"), "what the page says of the end")
        assert page.text("lost") == "The program has ended; the camera rests."
        page.wait(lambda data: data["next"] == "ended", "the advice")
        assert page.text("mode") == "ENDED"
