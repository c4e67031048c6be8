"""A run with two videos: another camera on the same vehicle.

The page must show either, say in which one the boat is followed, and draw no box on the other. The
followed one is changed at rest alone. Both are recorded; the recording must repeat bit for bit over a
change, and an export must give both films.
"""

import pathlib
from collections.abc import Iterator

import cv2
import pytest

from client import WORLD, Program
from conftest import Check
from emulator import Emulator
from machine import wait_until
from page import Page, started
from process import run
from recording import Recording
from worlds import first_box

pytestmark = pytest.mark.apart

FIRST, SECOND = [640, 360], [480, 270]
LISTEN = ("--video-listen", "127.0.0.1:0")


@pytest.fixture(scope="class")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return tmp_path_factory.mktemp("two")


@pytest.fixture(scope="class")
def program(barrelman: pathlib.Path, folder: pathlib.Path) -> Iterator[Program]:
    """A run on the videos of two worlds, the first of which has the link.

    The run selects the boat and engages by itself: the boat would leave a camera at rest before a busy
    machine has shown the page.
    """
    select = first_box(barrelman, folder)
    with (
        Emulator(barrelman, folder, "--world", WORLD, *LISTEN, name="one") as one,
        Emulator(barrelman, folder, "--world", "sim:first-drive?size=480x270", *LISTEN, name="two") as two,
        Program(
            barrelman,
            "run",
            *("--video", one.video, "--video", two.video, "--link", one.url),
            *("--select", select, "--engage", "--record", folder / "run.mcap"),
        ) as program,
    ):
        yield program


@pytest.fixture(scope="class")
def page(program: Program, folder: pathlib.Path) -> Iterator[Page]:
    with started(program, folder) as page:
        yield page


class TestTwoVideos:
    def test_page_shows_either_and_says_where_the_boat_is_followed(
        self, program: Program, page: Page, check: Check, pytestconfig: pytest.Config
    ) -> None:
        pictures = pytestconfig.getoption("--screenshots")
        program.wait(lambda status: (status["other_video"] or {}).get("state") == "up", "the second video")
        check("the first video is shown", page.size() == FIRST, page.size())
        check("it is followed", "Video 1: the boat is followed here" in page.text("video"))
        page.screenshot(pictures, "two-videos-first")
        page.type("v")
        wait_until(lambda: page.size() == SECOND, lambda: f"the second video ({page.size()})")
        wait_until(lambda: "watched only" in page.text("video"), lambda: page.text("video"))
        page.drag([200, 100, 60, 40], SECOND)
        wait_until(lambda: "followed in the other video" in page.text("toast"), lambda: page.text("toast"))
        page.screenshot(pictures, "two-videos-second")
        check("the boat is still followed in the first", program.status()["video"]["number"] == "first")
        check("the track lasts", program.status()["track"]["state"] != "unseeded")

    def test_video_is_changed_at_rest_alone(self, page: Page, check: Check) -> None:
        check("the run is engaged", page.data["mode"] != "idle", page.data)
        wait_until(lambda: not page.element("track-video").is_enabled(), lambda: "the button")
        page.disengage()

    def test_boat_is_followed_in_the_second_video(
        self, program: Program, page: Page, check: Check, pytestconfig: pytest.Config
    ) -> None:
        page.click_enabled("track-video")
        status = program.wait(
            lambda status: status["video"]["number"] == "second" and status["video"]["size"], "the second"
        )
        check("its pictures are the second's", status["video"]["size"] == SECOND, status["video"])
        check("nothing is followed yet", status["track"]["state"] == "unseeded", status["track"])
        check("the first is the other one", status["other_video"]["number"] == "first", status)
        wait_until(lambda: "Video 2: the boat is followed here" in page.text("video"), lambda: "the words")
        # Nothing turns the second world's camera, so its boat may have left: what counts is the answer.
        page.drag([180, 90, 120, 90], SECOND)
        program.wait(
            lambda status: status["track"]["state"] == "tracking" or page.text("toast"), "the answer"
        )
        page.screenshot(pytestconfig.getoption("--screenshots"), "two-videos-changed")
        check("nothing is wrong on the page", page.complaints() == [], page.complaints())

    def test_boat_is_followed_in_the_first_again(self, program: Program, page: Page) -> None:
        page.type("v")
        page.click_enabled("track-video")
        program.wait(lambda status: status["video"]["number"] == "first", "the first")
        wait_until(lambda: page.size() == FIRST, lambda: f"the first video ({page.size()})")

    def test_recording_repeats_and_gives_both_films(
        self, program: Program, barrelman: pathlib.Path, folder: pathlib.Path, check: Check
    ) -> None:
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
        record = Recording(folder / "run.mcap")
        check("both videos are recorded", record["/video"] and record["/second/video"])
        of_second = [frame.second for frame in record.frames]
        check("frames of both were followed", {True, False} == set(of_second), set(of_second))
        replayed = run([barrelman, "replay", folder / "run.mcap", "--compare"], timeout=600)
        check("the recording repeats", "bit for bit" in replayed.stdout, replayed.stdout + replayed.stderr)
        exported = run(
            [barrelman, "export", folder / "run.mcap", "--output", folder / "films", "--annotated"],
            timeout=600,
        )
        check("the export ends well", exported.returncode == 0, exported.stderr[-300:])
        for name, size in (("video.mp4", FIRST), ("video2.mp4", SECOND), ("annotated.mp4", FIRST)):
            film = cv2.VideoCapture(str(folder / "films" / name))
            found = [film.get(cv2.CAP_PROP_FRAME_WIDTH), film.get(cv2.CAP_PROP_FRAME_HEIGHT)]
            check(f"{name} has its size", found == size, found)


def test_what_cannot_be_a_second_video_is_refused(barrelman: pathlib.Path, check: Check) -> None:
    for options, reason in (
        (["--video", "a.mp4", "--video", "sim:arena1"], "cannot be the second video"),
        (["--video", "a.mp4", "--video", "b.mp4", "--video", "c.mp4"], "omit c.mp4"),
    ):
        done = run([barrelman, "run", *options, "--headless", "--no-record"])
        check(f"{options[-1]} is refused", done.returncode != 0 and reason in done.stderr, done.stderr)
