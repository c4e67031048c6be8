"""`barrelman track --tracker camshift` beside OpenCV's CamShift (opencv_trackers.py): boxes on real clips,
and CPU time.

The score is the success AUC: the share of labelled frames whose IoU exceeds a threshold, averaged over the 21
thresholds 0, 0.05 .. 1. The selection's frame does not count.
"""

import csv
import dataclasses
import functools
import json
import pathlib
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from conftest import Clip, shared
from machine import median
from opencv_trackers import Box, opencv
from process import run

LOST_BELOW = 0.1
AUC_WANTED = {"raft_whitewater": 0.61, "orange_taxi": 0.58}
AGREEMENT_WANTED = 0.85
CPU_SHARE_WANTED = 0.25
# A window that covers more of the picture is too large for a limit.
LARGEST_WINDOW = 0.25


def iou(a: Sequence[float] | None, b: Sequence[float] | None) -> float:
    if a is None or b is None:
        return 0.0
    w = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    h = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    return w * h / (a[2] * a[3] + b[2] * b[3] - w * h) if w > 0 and h > 0 else 0.0


@dataclasses.dataclass
class Comparison:
    """Our boxes and OpenCV's on a clip, against the truth, and both CPU times of a frame, milliseconds."""

    auc: float
    lost_share: float
    agreement: float
    covered: float
    figures: dict[str, Any]
    opencv_cpu_ms: float


def compared(
    barrelman: pathlib.Path, video: pathlib.Path, truth: dict[int, Box], output: pathlib.Path
) -> Comparison:
    selection = ",".join(f"{value:g}" for value in truth[0])
    done = run(
        [
            barrelman,
            "track",
            video,
            "--select",
            selection,
            "--tracker",
            "camshift",
            "--output",
            output,
            "--json",
        ]
    )
    assert done.returncode == 0, done.stderr
    with output.open(newline="") as file:
        ours = {
            int(row["frame"]): [float(row[key]) for key in "xywh"] if row["state"] != "lost" else None
            for row in csv.DictReader(file)
        }
    theirs, cpu, area = opencv(video, truth[0])
    overlaps = [iou(ours.get(frame), box) for frame, box in truth.items() if frame > 0 and box[2] and box[3]]
    agreement = [iou(ours.get(frame), box) for frame, box in theirs.items() if frame > 0 and box]
    return Comparison(
        auc=sum(sum(overlap > step / 20 for overlap in overlaps) / len(overlaps) for step in range(21)) / 21,
        lost_share=sum(overlap < LOST_BELOW for overlap in overlaps) / len(overlaps),
        agreement=sum(agreement) / len(agreement),
        covered=max(box[2] * box[3] / area for box in ours.values() if box),
        figures=json.loads(done.stdout),
        opencv_cpu_ms=median(cpu),
    )


@pytest.fixture(scope="module")
def compare(
    barrelman: pathlib.Path, clip: Clip, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], Comparison]:
    """The comparison on a clip by its name, made once."""

    @functools.cache
    def compare(name: str) -> Comparison:
        if name == "practice":
            truth: dict[int, Box] = {
                int(row["frame"]): (row["x"], row["y"], row["w"], row["h"]) for row in clip.truth
            }
            x, y, w, h = map(float, clip.selection.split(","))
            video, truth[0] = clip.video, (x, y, w, h)
        else:
            video = shared("data", "clips", name) / "video.mp4"
            with video.with_name("gt.csv").open(newline="") as file:
                truth = {
                    int(row["frame"]): (float(row["x"]), float(row["y"]), float(row["w"]), float(row["h"]))
                    for row in csv.DictReader(file)
                }
        return compared(barrelman, video, truth, tmp_path_factory.mktemp("camshift") / "track.csv")

    return compare


@pytest.mark.parametrize(("name", "wanted"), AUC_WANTED.items())
def test_auc_on_a_real_clip_is_good(compare: Callable[[str], Comparison], name: str, wanted: float) -> None:
    assert compare(name).auc >= wanted


@pytest.mark.parametrize("name", AUC_WANTED)
def test_boat_of_a_real_clip_is_never_lost(compare: Callable[[str], Comparison], name: str) -> None:
    assert (compare(name).lost_share, compare(name).figures["lost_frames"]) == (0, 0)


@pytest.mark.parametrize("name", AUC_WANTED)
def test_boxes_agree_with_those_of_opencv(compare: Callable[[str], Comparison], name: str) -> None:
    assert compare(name).agreement >= AGREEMENT_WANTED


@pytest.mark.parametrize("name", ["orange_taxi", "practice"])
def test_tracker_takes_a_quarter_of_the_cpu_time_of_opencv(
    compare: Callable[[str], Comparison], name: str
) -> None:
    """On clips of 1280x720 pixels."""
    result = compare(name)
    share = result.figures["tracker_cpu_ms"]["median"] / result.opencv_cpu_ms
    assert share <= CPU_SHARE_WANTED or result.covered > LARGEST_WINDOW
