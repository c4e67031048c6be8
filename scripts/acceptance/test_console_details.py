"""Small matters of the page in headless Chromium: the trail, one mark that is removed, hints, scroll bars."""

import json
import pathlib
from collections.abc import Iterator
from typing import Any

import pytest

from altered import AlteredPage
from client import Program
from console_states import ALARMS, BOX, PERSON, PERSON_AT, mode
from machine import wait_until
from page import Page, axe_finds, scroll_bars


@pytest.fixture(scope="module")
def page(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[AlteredPage]:
    with Program(barrelman, "demo", "open", "--hands-on", "--size", "640x360") as program:
        program.resume()
        with AlteredPage(program, tmp_path_factory.mktemp("details")) as page:
            yield page


def test_tile_that_did_not_come_is_asked_for_again_unless_there_is_none(page: AlteredPage) -> None:
    asked = page.driver.execute_async_script("""
        const done = arguments[0];
        const { fetch } = window;
        const finish = (result) => {
          window.fetch = fetch;
          done(result);
        };
        // A copy of the module of its own: the page's map stays as it is.
        import('/console/map_tiles.js?copy').then(async ({ setMap, drawTiles }) => {
          const asked = { come: 0, none: 0 };
          const picture = await new Promise((made) => document.createElement('canvas').toBlob(made));
          window.fetch = async (address) => {
            const name = address.endsWith('/0/0/0') ? 'come' : 'none';
            asked[name] += 1;
            if (name === 'none') return new Response(null, { status: 404 });
            if (asked.come === 1) return new Response(null, { status: 429 });
            if (asked.come === 2) throw new TypeError('lost');
            return new Response(picture);
          };
          setMap({ min_zoom: 0, max_zoom: 1, attribution: null });
          let drawn = 0;
          const pen = new Proxy({}, { get: (_, name) => () => (drawn += Number(name === 'drawImage')) });
          const place = { below_camera: { latitude_deg: 60, longitude_deg: -90 }, ahead_deg: 0 };
          const metres = 2 * Math.PI * 6378137 * Math.cos(60 * Math.PI / 180);
          const draw = () => {
            for (const zoom of [0, 1]) {
              drawTiles(pen, place, [0, 0], 255 * 2 ** zoom / metres, [-1, -1, 2], 1);
            }
            if (drawn > 0) return finish(asked);
            setTimeout(draw, 50);
          };
          draw();
        }).catch((error) => finish(String(error)));""")
    assert asked == {"come": 3, "none": 1}


def test_trail_expires_while_the_boat_is_lost(page: AlteredPage) -> None:
    lengths = page.driver.execute_async_script("""
        const done = arguments[0];
        import('/console/overlay.js').then(({ Trail }) => {
          const trail = new Trail();
          let points = 0;
          const pen = new Proxy({}, { get: (_, name) => () => { points += /To$/.test(name) ? 1 : 0; } });
          const drawn = () => {
            points = 0;
            trail.draw(pen, { toCanvas: (at) => at }, 1);
            return points;
          };
          const at = (s, track) => ({ track, video: { captured_ns: s * 1e9 } });
          const seen = (s) => at(s, { centre: [s, s], captured_ns: s * 1e9 });
          const lost = (s) => at(s, { centre: null, captured_ns: null });
          const lengths = [];
          for (const s of [10, 11, 12]) trail.add(seen(s));
          lengths.push(drawn());
          for (const s of [13, 16.5, 18]) {
            trail.add(lost(s));
            lengths.push(drawn());
          }
          done(lengths);
        }, (error) => done(String(error)));""")
    assert lengths == [3, 3, 1, 0]


# Notes the requests of the page.
NOTE_REQUESTS = """
window.sent = [];
window.send ??= WebSocket.prototype.send;
WebSocket.prototype.send = function (data) {
  const message = JSON.parse(data);
  if (message.type === 'request') window.sent.push(message.request);
  window.send.call(this, data);
};
"""


def sent(page: Page) -> list[Any]:
    requests: list[Any] = page.script("return window.sent")
    return requests


def test_one_mark_is_removed_and_the_other_stays(page: AlteredPage) -> None:
    page.resize(1280, 800)
    place = {**PERSON, "id": 8, "kind": "place", "destination": False, "at": [500.0, 250.0]}
    marked = {"mode": mode("servoing"), "track": BOX, "vessel": {"marks": [PERSON, place], "mode": "stopped"}}
    page.alter({"snapshot": marked}, "d.marks === '2'")
    page.script(NOTE_REQUESTS)
    page.drag([*PERSON_AT, 0, 0], page.size() or ())
    wait_until(lambda: [request["kind"] for request in sent(page)] == ["move-mark"], "the tap")
    page.type("u")
    wait_until(lambda: len(sent(page)) == 2, "the request")
    assert sent(page)[1] == {"kind": "unmark", "id": PERSON["id"]}


def test_a_doubt_of_the_detector_is_answered_by_engage(page: AlteredPage) -> None:
    doubted = {"mode": mode("holding", "doubted"), "track": {**BOX, "doubted": True}}
    page.alter({"snapshot": doubted}, "d.next === 'doubted' && d.cause === 'doubted'")
    assert "detector" in page.text("mode-cause")
    page.script(NOTE_REQUESTS)
    page.click_enabled("engage")
    wait_until(lambda: [request["kind"] for request in sent(page)] == ["engage"], "the request")
    page.alter(
        {"snapshot": {"mode": mode("servoing"), "track": BOX}}, "document.getElementById('engage').disabled"
    )


def test_a_hint_does_not_recommend_the_size_that_is_in_use(page: AlteredPage) -> None:
    def hint(size: list[int]) -> str:
        page.alter({"snapshot": {"drive": {"pace": 0.5}, "video": {"size": size}}}, "true")
        wait_until(lambda: "50 %" in facts(), facts)
        return facts()

    def facts() -> str:
        return str(page.script("return document.getElementById('facts').textContent"))

    if page.data["level"] != "expert":
        page.click("level")
    assert "try --size 640x360" in hint([1280, 720])
    wait_until(lambda: "--size" not in hint([640, 360]), facts)
    page.click("level")


@pytest.mark.parametrize("size", [(1280, 800), (768, 1024), (390, 844), (844, 390)], ids=str)
def test_there_is_one_scroll_bar_at_most_at_night(page: AlteredPage, size: tuple[int, int]) -> None:
    page.alter({}, "d.connected === 'yes'")
    if page.data["theme"] != "night":
        page.click("theme")
    page.resize(*size)
    bars = scroll_bars(page)
    page.resize(1280, 800)
    assert len(bars) <= 1, bars


@pytest.mark.parametrize("theme", ["day", "night"])
def test_manual_is_accessible_and_has_one_scroll_bar(page: AlteredPage, theme: str) -> None:
    if page.data["theme"] != theme:
        page.click("theme")
    console = page.script("return location.href")
    page.driver.get(console.split("#")[0].rstrip("/") + "/help")
    try:
        assert page.data["theme"] == theme
        assert page.driver.title == "Barrelman: manual"
        assert not axe_finds(page)
        for size in ((1280, 800), (390, 844)):
            page.resize(*size)
            assert scroll_bars(page) == ["HTML"], size
        broken = page.script("return [...document.images].filter((i) => !i.naturalWidth).map((i) => i.src)")
        assert not broken
        hosts = page.script("""
            const files = performance.getEntriesByType('resource');
            return [...new Set(files.map((entry) => new URL(entry.name).host))]""")
        assert hosts == [page.program.host]
        assert not page.complaints()
    finally:
        page.resize(1280, 800)
        page.driver.get(console)
        page.ready()


@pytest.mark.parametrize(
    ("snapshot", "place", "words"),
    [
        ({"mode": mode("servoing"), "track": BOX, "alarms": []}, "following", "the law moves the camera"),
        ({"alarms": ["track-lost", "net-yaw"]}, "alarm-net-yaw", "Tether winds up"),
        ({"alarms": ALARMS}, "alarm-camera-turns", "Camera turns although zero is commanded"),
    ],
    ids=["the mode", "an alarm", "the first alarm"],
)
def test_manual_opens_where_it_speaks_of_the_state(
    page: AlteredPage, snapshot: Any, place: str, words: str
) -> None:
    page.wait(lambda data: data["controlling"] == "yes", "the control")
    page.alter({"snapshot": snapshot}, "true")
    count = len(snapshot["alarms"])
    wait_until(
        lambda: page.script("return document.querySelectorAll('#alarms li').length") == count, "the alarms"
    )
    page.type("?")
    before = set(page.driver.window_handles)
    page.click("help")
    wait_until(lambda: set(page.driver.window_handles) - before, "the manual")
    console = page.driver.current_window_handle
    page.driver.switch_to.window((set(page.driver.window_handles) - before).pop())
    try:
        wait_until(lambda: page.script("return location.hash") == f"#{place}", "the place")
        row = page.script("return document.querySelector(':target')?.closest('tr')?.textContent ?? ''")
        assert words in row
        assert page.script("return document.querySelector(':target').getBoundingClientRect().top") >= 0
    finally:
        page.driver.close()
        page.driver.switch_to.window(console)
        page.script("document.getElementById('keys-dialog').close()")


def test_a_moment_is_not_marked_where_nothing_is_recorded(page: AlteredPage) -> None:
    page.alter({}, "d.connected === 'yes'")
    assert not page.element("note").is_enabled()
    status, body, _ = page.program.ask("POST", "/api/v1/requests", {"request": {"kind": "note"}})
    assert status == 200
    assert json.loads(body)["reason"].startswith("nothing is recorded")


def test_pictures_that_the_program_made_smaller_come_as_jpeg(
    barrelman: pathlib.Path, folder: pathlib.Path
) -> None:
    recorded = ["--record", folder / "run.mcap"]
    with (
        Program(
            barrelman, "run", "--video", "sim:arena1?size=640x360", "--link", "sim:", *recorded
        ) as program,
        AlteredPage(program, folder) as page,
    ):
        page.alter({}, "d.path === 'h264'")
        # Boxes are in pixels of what the program saw; the page's decoder gives the picture as it came.
        page.alter({"snapshot": {"video": {"size": [320, 180]}}}, "d.path === 'jpeg'")
        drawn = int(page.data["drawn"])
        page.wait(lambda data: int(data["drawn"]) > drawn, "a picture")
