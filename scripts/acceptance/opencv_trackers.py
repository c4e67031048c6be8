"""Runs OpenCV's CSRT, NanoTrack and CamShift on clips, for `cargo run --release -p barrelman-eval -- tracker --opencv`.

The argument is the folder of NanoTrack's models, nanotrack_backbone_sim.onnx and nanotrack_head_sim.onnx. Each line of
standard input is a job: {"video": path, "start": frame, "selection": [x, y, w, h]}. The answer to a job is one line: for
every frame after the start, the boxes of CSRT and of NanoTrack (null where the tracker gives no box), and the CPU
milliseconds of all three. Every tracker runs on one thread; decoding is not timed. The settings of CamShift are those of
camshift.py.
"""
import json
import pathlib
import sys
import time

import cv2

import camshift


def nanotrack(models):
    parameters = cv2.TrackerNano_Params()
    parameters.backbone = str(models / "nanotrack_backbone_sim.onnx")
    parameters.neckhead = str(models / "nanotrack_head_sim.onnx")
    return cv2.TrackerNano_create(parameters)


def run(tracker, job):
    """The boxes and the CPU milliseconds of a tracker in every frame after the start."""
    capture = cv2.VideoCapture(job["video"])
    for _ in range(job["start"]):
        capture.read()
    there, picture = capture.read()
    if not there:
        raise RuntimeError(f"{job['video']}: no frame {job['start']}")
    tracker.init(picture, tuple(round(value) for value in job["selection"]))
    boxes, cpu = [], []
    while True:
        there, picture = capture.read()
        if not there:
            return {"boxes": boxes, "cpu_ms": cpu}
        began = time.thread_time_ns()
        found, box = tracker.update(picture)
        cpu.append((time.thread_time_ns() - began) / 1e6)
        boxes.append([float(value) for value in box] if found else None)


def main():
    models = pathlib.Path(sys.argv[1])
    cv2.setNumThreads(1)
    # OpenCV warns about the models' targets at each start.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    for line in sys.stdin:
        job = json.loads(line)
        answer = {"csrt": run(cv2.TrackerCSRT_create(), job), "nanotrack": run(nanotrack(models), job)}
        _, answer["lean_camshift_cpu_ms"], _ = camshift.opencv(job["video"], job["selection"])
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
