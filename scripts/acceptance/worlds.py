"""A run that closes the loop: a vehicle moves the camera of the simulated world that the run sees."""

import csv
import pathlib
import time

from client import Program
from conftest import Check
from process import run

SECONDS = 15


def first_box(barrelman: pathlib.Path, folder: pathlib.Path) -> str:
    """The boat of WORLD in its first picture."""
    clip, truth = folder / "first.mp4", folder / "first.csv"
    done = run(
        [
            barrelman,
            "render",
            "arena1",
            "--seed",
            3,
            "--seconds",
            0.2,
            "--size",
            "640x360",
            "--output",
            clip,
            "--truth",
            truth,
        ]
    )
    assert done.returncode == 0, done.stderr
    with truth.open(newline="") as file:
        box = next(csv.DictReader(file))
    return ",".join(f"{float(box[key]):.0f}" for key in "xywh")


def follow_boat(program: Program, check: Check) -> None:
    program.wait(lambda status: status["video"]["captured_ns"], "the first video frame")
    seen = []
    for _ in range(10 * SECONDS):
        seen.append(program.status())
        time.sleep(0.1)
    followed = [state for state in seen if state["percept"] and state["track"]["state"] == "tracking"]
    inside = sum(state["percept"]["p"] <= 1 for state in followed) / max(len(followed), 1)
    check("the boat is tracked", len(followed) >= 0.9 * len(seen), f"{len(followed)} of {len(seen)} states")
    check("the boat stays in the region", inside >= 0.7, f"{inside:.0%} of the time")
