"""Compares `barrelman track --tracker camshift` with OpenCV's CamShift: boxes on real clips, and CPU time.

OpenCV's CamShift runs without blur and equalisation. The hue histogram of the selection has 16 bins and counts pixels
with S >= 60 and V >= 32; the back projection has the same mask. The search ends after 10 steps or below 1 px. The
score is the success AUC: the share of labelled frames whose IoU exceeds a threshold, averaged over the 21 thresholds
0, 0.05 .. 1. The selection's frame does not count.
"""
import csv
import json
import sys
import time

import common
from common import Table

SATURATION_FLOOR, VALUE_FLOOR, BINS = 60, 32, 16
LOST_BELOW = 0.1
AUC_WANTED = {"raft_whitewater": 0.61, "orange_taxi": 0.58}
AGREEMENT_WANTED = 0.85
CPU_SHARE_WANTED = 0.25
PRINTED_ONLY = "stress_redboat_small320"


def labels(path):
    with open(path, newline="") as file:
        return {int(row["frame"]): tuple(float(row[key]) for key in "xywh") for row in csv.DictReader(file)}


def iou(a, b):
    if a is None or b is None:
        return 0.0
    w = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    h = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    if w <= 0 or h <= 0:
        return 0.0
    return w * h / (a[2] * a[3] + b[2] * b[3] - w * h)


def score(boxes, truth):
    """(AUC, share lost) over the labelled frames in which the target is visible."""
    overlaps = [iou(boxes.get(frame), box) for frame, box in truth.items() if frame > 0 and box[2] and box[3]]
    auc = sum(sum(overlap > step / 20 for overlap in overlaps) / len(overlaps) for step in range(21)) / 21
    return auc, sum(overlap < LOST_BELOW for overlap in overlaps) / len(overlaps)


def opencv(video, selection):
    """OpenCV's boxes by frame, its CPU milliseconds of each frame, and the area of a picture in pixels."""
    import cv2
    import numpy

    cv2.setNumThreads(1)
    capture = cv2.VideoCapture(str(video))
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1)
    low, high = (0, SATURATION_FLOOR, VALUE_FLOOR), (180, 255, 255)
    boxes, cpu = {}, []
    histogram = None
    window = tuple(round(value) for value in selection)
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
            histogram = cv2.calcHist([numpy.ascontiguousarray(hsv[part])], [0], numpy.ascontiguousarray(mask[part]), [BINS], [0, 180])
            cv2.normalize(histogram, histogram, 0, 255, cv2.NORM_MINMAX)
            boxes[0] = window
        else:
            projection = cv2.calcBackProject([hsv], [0], histogram, [0, 180], 1)
            projection &= mask
            if window[2] > 0 and window[3] > 0:
                _, window = cv2.CamShift(projection, window, criteria)
            cpu.append((time.thread_time_ns() - began) / 1e6)
            boxes[frame] = tuple(float(value) for value in window) if window[2] and window[3] else None
        frame += 1


def barrelman(args, video, selection, folder):
    output = folder / f"{video.parent.name}.csv"
    command = [args.barrelman, "track", video, "--select", ",".join(f"{value:g}" for value in selection), "--tracker", "camshift", "--output", output, "--json"]
    done = common.run(command, timeout=120)
    if done.returncode:
        raise RuntimeError(f"track {video}: exit {done.returncode}: {done.stderr}")
    boxes = {}
    with open(output, newline="") as file:
        for row in csv.DictReader(file):
            boxes[int(row["frame"])] = tuple(float(row[key]) for key in "xywh") if row["state"] != "lost" else None
    return boxes, json.loads(done.stdout)


def compare(table, args, name, video, truth, folder, auc_wanted=None):
    selection = truth[0]
    ours, figures = barrelman(args, video, selection, folder)
    theirs, cpu, area = opencv(video, selection)
    auc, lost = score(ours, truth)
    their_auc, their_lost = score(theirs, truth)
    agreement = [iou(ours.get(frame), box) for frame, box in theirs.items() if frame > 0 and box]
    agreement = sum(agreement) / len(agreement) if agreement else float("nan")
    covered = max(box[2] * box[3] / area for box in ours.values() if box)
    their_covered = max(box[2] * box[3] / area for box in theirs.values() if box)
    if auc_wanted:
        table.require(f"{name}: AUC", auc >= auc_wanted, f"{auc:.3f} (OpenCV {their_auc:.3f})", f"at least {auc_wanted}")
        table.require(f"{name}: share of labelled frames lost", lost == 0 and figures["lost_frames"] == 0, f"{lost:.2f} (OpenCV {their_lost:.2f}), {figures['lost_frames']} lost", "never")
        table.require(f"{name}: mean IoU with OpenCV's box", agreement >= AGREEMENT_WANTED, f"{agreement:.3f}", f"at least {AGREEMENT_WANTED}")
    else:
        table.show(f"{name}: AUC, lost", f"{auc:.3f}, {lost:.2f}", f"OpenCV {their_auc:.3f}, {their_lost:.2f}; mean IoU with it {agreement:.3f}")
    table.show(f"{name}: largest box, share of the picture", f"{covered:.3f} (OpenCV {their_covered:.3f})")
    return figures, cpu, covered, {"clip": name, "auc": auc, "lost": lost, "opencv_auc": their_auc, "opencv_lost": their_lost, "agreement": agreement, "track": figures, "opencv_cpu_ms": common.median(cpu)}


def compare_cost(table, name, figures, cpu, covered):
    """Compares the CPU times on a clip of 1280x720 pixels."""
    ours, theirs = figures["tracker_cpu_ms"], {"median": common.median(cpu), "p99": common.percentile(cpu, 0.99)}
    share = ours["median"] / theirs["median"]
    wanted = f"at most {CPU_SHARE_WANTED} of OpenCV's {theirs['median']:.2f} ms"
    if covered > 0.25:
        table.show(f"{name}: tracker's CPU, median", f"{ours['median']:.3f} ms = {share:.2f}", f"the window is too large for a limit (OpenCV {theirs['median']:.2f} ms)")
    else:
        table.require(f"{name}: tracker's CPU, median", share <= CPU_SHARE_WANTED, f"{ours['median']:.3f} ms = {share:.3f}", wanted)
    table.show(f"{name}: tracker's CPU, p99", f"{ours['p99']:.3f} ms", f"OpenCV {theirs['p99']:.2f} ms")
    for key, value in figures.items():
        if key.endswith("cpu_ms") and key != "tracker_cpu_ms":
            table.show(f"{name}: {key}", ", ".join(f"{part} {figure:.3f}" for part, figure in value.items()), "ms")
        elif key not in ("frames", "lost_frames", "tracker_cpu_ms"):
            table.show(f"{name}: {key}", value)


def main():
    args = common.arguments(__doc__, clip=common.CLIP)
    clips = common.shared_or_skip("data", "clips")
    folder = common.temporary_folder()
    table = Table("CamShift beside OpenCV's")
    results = []
    costs = []
    for name in (*AUC_WANTED, PRINTED_ONLY):
        video = clips / name / "video.mp4"
        figures, cpu, covered, result = compare(table, args, name, video, labels(clips / name / "gt.csv"), folder, AUC_WANTED.get(name))
        results.append(result)
        if name == "orange_taxi":
            costs.append((name, figures, cpu, covered))
    practice, truth = common.practice_clip(args, folder)
    boxes = {int(row["frame"]): (row["x"], row["y"], row["w"], row["h"]) for row in truth}
    boxes[0] = tuple(float(value) for value in common.selection(truth).split(","))
    figures, cpu, covered, result = compare(table, args, "practice clip", practice, boxes, folder)
    results.append(result)
    costs.append(("practice clip", figures, cpu, covered))
    for cost in costs:
        compare_cost(table, *cost)
    return table.finish(args, clips=results)


if __name__ == "__main__":
    sys.exit(main())
