"""Runs OpenCV's CSRT and CamShift on clips, for `cargo run --release -p barrelman-eval -- tracker`.

Each line of standard input is a job: {"video": path, "start": frame, "selection": [x, y, w, h]}. The answer to a job is
one line: for every frame after the start, the box of CSRT (null where CSRT gives no box) and the CPU milliseconds of
both trackers. Both run on one thread; decoding is not timed. The settings of CamShift are those of camshift.py.
"""
import json
import sys
import time

import cv2

import camshift


def csrt(job):
    capture = cv2.VideoCapture(job["video"])
    for _ in range(job["start"]):
        capture.read()
    there, picture = capture.read()
    if not there:
        raise RuntimeError(f"{job['video']}: no frame {job['start']}")
    tracker = cv2.TrackerCSRT_create()
    tracker.init(picture, tuple(round(value) for value in job["selection"]))
    boxes, cpu = [], []
    while True:
        there, picture = capture.read()
        if not there:
            return boxes, cpu
        began = time.thread_time_ns()
        found, box = tracker.update(picture)
        cpu.append((time.thread_time_ns() - began) / 1e6)
        boxes.append([float(value) for value in box] if found else None)


def main():
    cv2.setNumThreads(1)
    for line in sys.stdin:
        job = json.loads(line)
        boxes, cpu = csrt(job)
        _, lean_cpu, _ = camshift.opencv(job["video"], job["selection"])
        print(json.dumps({"boxes": boxes, "cpu_ms": cpu, "lean_camshift_cpu_ms": lean_cpu}), flush=True)


if __name__ == "__main__":
    main()
