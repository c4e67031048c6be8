"""A detector of the operator's own: a small model that answers where the picture is red, as the boat is.

The boat must become a candidate with class and score, on the page too, and its number must select it. Nothing
may be followed before. Where the model calls it a person, a mark must be proposed, and set by a tap alone.
The recording must repeat bit for bit without the model.
"""

import pathlib
import re
import shutil
from typing import Any

import pytest

from client import Program
from conftest import Check
from machine import wait_until
from page import Page
from process import run, threads_of
from recording import Recording

pytestmark = pytest.mark.apart

FIXTURES = pathlib.Path(__file__).parents[2] / "fixtures/detector"
WORLD = "sim:first-drive?size=640x360"
# Notes the texts that the page draws.
NOTING = """
window.drawn = [];
const draw = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
  window.drawn = [...window.drawn.slice(-99), text];
  return draw.call(this, text, ...place);
};
"""


def named(status: Any) -> list[Any]:
    return [candidate for candidate in status["candidates"] if candidate["class"] is not None]


def is_drawn(page: Page, pattern: str) -> bool:
    return any(re.fullmatch(pattern, text) for text in page.script("return window.drawn"))


def model_of(folder: pathlib.Path, name: str) -> pathlib.Path:
    """The red model, whose class has this name."""
    settings = (FIXTURES / "detector.toml").read_text()
    (folder / "detector.toml").write_text(settings.replace('"boat"', f'"{name}"'))
    return pathlib.Path(shutil.copy(FIXTURES / "red-yolo.onnx", folder))


def started(barrelman: pathlib.Path, *options: Any) -> Program:
    """A run whose boat drifts until it is commanded, so that it stays in the picture."""
    links = ["--link", "sim:", "--vessel", "sim:"]
    return Program(barrelman, "run", "--video", WORLD, *links, "--hands-on", *options)


def test_detected_boat_is_selected_by_its_number(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    path = tmp_path / "detected.mcap"
    model = model_of(tmp_path, "boat")
    with started(barrelman, "--detector", model, "--record", path) as program:
        check("the detector has a thread", "detector" in threads_of(program.child), threads_of(program.child))
        with Page(program.url, tmp_path, before=NOTING) as page:
            page.ready()
            status = program.wait(named, "a candidate with a class")
            found = named(status)
            check("the class is that of detector.toml", found[0]["class"] == "boat", found)
            check("the score is one", 0.2 <= found[0]["score"] <= 1.0, found)
            wait_until(
                lambda: is_drawn(page, r"\d: boat [01]\.\d\d"), "class and score on the page", pause=0.1
            )
            page.screenshot(pytestconfig.getoption("--screenshots"), "detected")
            status = program.status()
            check("nothing was selected", status["track"]["state"] == "unseeded", status["track"])
            check(
                "nothing was moved",
                status["command"] == {"pan": 0.0, "tilt": 0.0, "zoom": 0.0},
                status["command"],
            )
            page.wait(lambda data: data["controlling"] == "yes", "the control")
            found = named(program.wait(named, "a candidate with a class"))
            page.type(str(max(found, key=lambda candidate: candidate["score"])["number"]))
            program.wait_for_track()
        program.errors.wait_for(r"--detector .*: [\d.]+ ms for a picture")
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
    inputs = Recording(path)["/input/detections"]
    check("the detections are recorded", any(one.found for one in inputs), len(inputs))
    model.unlink()
    replayed = run([barrelman, "replay", path, "--compare"])
    check("a replay repeats them without the model", replayed.returncode == 0, replayed.stdout[-300:])


def test_detected_person_is_proposed_and_marked_by_a_tap(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    def marks(status: Any) -> list[Any]:
        return [mark for mark in status["vessel"]["marks"] if mark["kind"] == "person"]

    model = model_of(tmp_path, "person")
    program = started(barrelman, "--detector", model, "--no-record")
    with program, Page(program.url, tmp_path, before=NOTING) as page:
        page.ready()
        page.wait(lambda data: data["controlling"] == "yes", "the control")
        status = program.wait(named, "a candidate with a class")
        check("a mark is proposed", named(status)[0]["mark"] == "person", named(status))
        wait_until(lambda: is_drawn(page, r"\d: person [01]\.\d\d\? tap to mark"), "the proposal on the page")
        page.screenshot(pytestconfig.getoption("--screenshots"), "detected-person")
        check("nothing is marked without a tap", not marks(program.status()), program.status()["vessel"])
        u, v, w, h = named(program.wait(named, "the candidate"))[0]["box"]
        page.drag([u + w / 2, v + h / 2, 0, 0], page.size() or ())
        status = program.wait(marks, "the mark")
        check("a tap marks one person", len(marks(status)) == 1, marks(status))
        check("and selects nothing", status["track"]["state"] == "unseeded", status["track"])
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])


def test_run_without_detector_has_no_thread_and_no_class(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    path = tmp_path / "plain.mcap"
    with started(barrelman, "--record", path) as program:
        status = program.wait(lambda status: status["candidates"], "a candidate")
        check("no candidate has a class", not named(status), status["candidates"])
        threads = threads_of(program.child)
        check("there is no thread of a detector", "detector" not in threads, threads)
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
    check("no detections are recorded", not Recording(path)["/input/detections"])


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("none", "there is no file"),
        ("truncated", "not a model in ONNX"),
        ("unknown-operator", "Wish"),
        ("grey-input", "takes an input of"),
        ("not-a-number", "not finite"),
        ("seven-values", "correct [output] and classes"),
        ("too-many-boxes", "answers 200000 boxes"),
    ],
)
def test_model_that_cannot_be_used_is_refused_at_the_start(
    barrelman: pathlib.Path, name: str, reason: str, check: Check
) -> None:
    model = FIXTURES / f"{name}.onnx"
    for command in ("run", "check"):
        options = ["--headless", "--no-record"] if command == "run" else []
        ended = run([barrelman, command, "--video", WORLD, "--detector", model, *options])
        text = ended.stdout + ended.stderr
        check(f"{command}: it fails", ended.returncode != 0, ended.returncode)
        check(f"{command}: the reason is said", reason in text and model.name in text, text[-600:])


def test_scores_that_are_no_numbers_are_left_out(barrelman: pathlib.Path, check: Check) -> None:
    with started(barrelman, "--detector", FIXTURES / "dark-only.onnx", "--no-record") as program:
        program.errors.wait_for("is not finite")
        status = program.wait(lambda status: status["candidates"], "a candidate")
        check("no candidate has a class", not named(status), status["candidates"])
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
