"""Runs OpenCV's CSRT, NanoTrack and CamShift on clips, for `cargo run --release -p barrelman-eval -- tracker
--opencv`.

The argument is the folder of NanoTrack's models, nanotrack_backbone_sim.onnx and nanotrack_head_sim.onnx.
Each line of standard input is a job: {"video": path, "start": frame, "selection": [x, y, w, h]}. The answer
to a job is one line: for every frame after the start, the boxes of CSRT and of NanoTrack (null where the
tracker gives no box), and the CPU milliseconds of all three. Every tracker runs on one thread; decoding is
not timed.

OpenCV's CamShift runs without blur and equalisation. The hue histogram of the selection has 16 bins and
counts pixels with S >= 60 and V >= 32; the back projection has the same mask. The search ends after 10 steps
or below 1 px.
"""

import json
import pathlib
import sys
import time
from collections.abc import Sequence
from typing import Any

import cv2
import numpy

SATURATION_FLOOR, VALUE_FLOOR, BINS = 60, 32, 16

Box = tuple[float, ...]
# OpenCV has no types for these trackers.
trackers: Any = cv2


def opencv(
    video: pathlib.Path | str, selection: Sequence[float]
) -> tuple[dict[int, Box | None], list[float], int]:
    """OpenCV's boxes by frame, its CPU milliseconds of each frame, and the area of a picture in pixels."""
    cv2.setNumThreads(1)
    capture = cv2.VideoCapture(str(video))
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1)
    low, high = (0, SATURATION_FLOOR, VALUE_FLOOR), (180, 255, 255)
    boxes: dict[int, Box | None] = {}
    cpu: list[float] = []
    histogram: Any = None
    picture_area = 0
    window: Any = tuple(round(value) for value in selection)
    frame = 0
    while True:
        there, picture = capture.read()
        if not there:
            return boxes, cpu, picture_area
        picture_area = picture.shape[0] * picture.shape[1]
        began = time.thread_time_ns()
        hsv = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)
        mask = cv2.inRange(hsv, low, high)
        if histogram is None:
            x, y, w, h = window
            part = (slice(y, y + h), slice(x, x + w))
            histogram = cv2.calcHist(
                [numpy.ascontiguousarray(hsv[part])],
                [0],
                numpy.ascontiguousarray(mask[part]),
                [BINS],
                [0, 180],
            )
            cv2.normalize(histogram, histogram, 0, 255, cv2.NORM_MINMAX)
            boxes[0] = window
        else:
            projection: Any = cv2.calcBackProject([hsv], [0], histogram, [0, 180], 1)
            projection &= mask
            if window[2] > 0 and window[3] > 0:
                _, window = cv2.CamShift(projection, window, criteria)
            cpu.append((time.thread_time_ns() - began) / 1e6)
            boxes[frame] = (*map(float, window),) if window[2] and window[3] else None
        frame += 1


def nanotrack(models: pathlib.Path) -> Any:
    parameters = trackers.TrackerNano_Params()
    parameters.backbone = str(models / "nanotrack_backbone_sim.onnx")
    parameters.neckhead = str(models / "nanotrack_head_sim.onnx")
    return trackers.TrackerNano_create(parameters)


def run(tracker: Any, job: dict[str, Any]) -> dict[str, Any]:
    """The boxes and the CPU milliseconds of a tracker in every frame after the start."""
    capture = cv2.VideoCapture(job["video"])
    for _ in range(job["start"]):
        capture.read()
    there, picture = capture.read()
    if not there:
        raise RuntimeError(f"{job['video']}: no frame {job['start']}")
    tracker.init(picture, tuple(round(value) for value in job["selection"]))
    boxes: list[list[float] | None] = []
    cpu: list[float] = []
    while True:
        there, picture = capture.read()
        if not there:
            return {"boxes": boxes, "cpu_ms": cpu}
        began = time.thread_time_ns()
        found, box = tracker.update(picture)
        cpu.append((time.thread_time_ns() - began) / 1e6)
        boxes.append([float(value) for value in box] if found else None)


def main() -> None:
    models = pathlib.Path(sys.argv[1])
    cv2.setNumThreads(1)
    # OpenCV warns about the models' targets at each start.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    for line in sys.stdin:
        job = json.loads(line)
        answer: dict[str, Any] = {
            "csrt": run(trackers.TrackerCSRT_create(), job),
            "nanotrack": run(nanotrack(models), job),
        }
        _, answer["lean_camshift_cpu_ms"], _ = opencv(job["video"], job["selection"])
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
