"""Tests recordings of killed runs: at most the last second is lost, and the rest can be replayed and exported.

The runs are killed with SIGKILL at random times from a seed. Then a complete recording is decoded in full.
"""
import concurrent.futures
import random
import signal
import subprocess
import sys
import time

import common
from common import Lines, Recording, Table

# It is flushed twice a second, so that a late turn of a busy machine still stays within the last second.
LOSES_AT_MOST = 1.0
FIRST, LAST = 0.4, 9.0


def start(args, clip, selection, record):
    command = [args.barrelman, "run", "--headless", "--engage", "--mode", common.HARDLY_RESTS, "--video", f"file:{clip}", "--select", selection, "--record", record]
    return common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def pictures(video):
    """Number of pictures that OpenCV decodes from a file."""
    import cv2

    capture = cv2.VideoCapture(str(video))
    count = 0
    while capture.read()[0]:
        count += 1
    return count


def csv_rows(path):
    return sum(1 for _ in open(path)) - 1 if path.exists() else 0


def try_kill(args, clip, selection, folder, number, moment):
    record = folder / f"killed{number}.mcap"
    began = time.monotonic()
    child = start(args, clip, selection, record)
    err = Lines(child.stderr)
    time.sleep(moment)
    at = time.monotonic()
    child.send_signal(signal.SIGKILL)
    child.wait()
    faults = []
    if child.returncode != -signal.SIGKILL:
        faults.append(f"it had ended before: {err.text()[-200:]}")
    recording = Recording(record)
    if recording.start is None:
        return {"moment": at - began, "lost": float("inf"), "faults": ["nothing could be read"], "cut": str(recording.cut)}
    last = max((outcome.now_ns for outcome in recording.outcomes), default=0)
    lost = at - recording.at(last)
    if lost > LOSES_AT_MOST:
        faults.append(f"{lost:.2f} s are lost")
    done = common.run([args.barrelman, "replay", record, "--compare"])
    # A run that was killed within its first second may have left nothing to compare, which is then said.
    if done.returncode and (recording.outcomes or "no outcome" not in done.stderr):
        faults.append(f"replay: exit {done.returncode}: {done.stdout[-200:]} {done.stderr[-200:]}")
    said = done.stderr
    out = folder / f"exported{number}"
    done = common.run([args.barrelman, "export", record, "--output", out])
    # Exit 1 says that the recording was cut, as with a CSV file that was; what there is must be there all the same.
    if done.returncode and "cut off" not in done.stderr:
        faults.append(f"export: exit {done.returncode}: {done.stderr[-200:]}")
    outcomes = csv_rows(out / "outcome.csv")
    if outcomes < len(recording.outcomes):
        faults.append(f"exported {outcomes} of {len(recording.outcomes)} outcomes")
    stored = len(recording["/video"])
    shown = pictures(out / "video.mp4") if stored else 0
    if shown < stored:
        faults.append(f"{shown} of {stored} pictures in the exported video")
    return {"moment": at - began, "lost": lost, "outcomes": len(recording.outcomes), "pictures": shown, "cut": str(recording.cut), "faults": faults, "said": said + done.stderr}


def check_complete(table, args, clip, selection, folder):
    from mcap.reader import make_reader

    record = folder / "complete.mcap"
    child = start(args, clip, selection, record)
    err = Lines(child.stderr)
    time.sleep(4.0)
    child.send_signal(signal.SIGTERM)
    child.wait(timeout=10)
    table.require("a run that was asked to end", child.returncode == 0, f"exit {child.returncode}", "" if child.returncode == 0 else err.text()[-200:])
    recording = Recording(record)
    table.require("its recording is whole", recording.cut is None, "", recording.cut or "")
    with open(record, "rb") as file:
        summary = make_reader(file).get_summary()
    counts = {summary.channels[channel].topic: count for channel, count in summary.statistics.channel_message_counts.items()}
    decoded = {topic: len(messages) for topic, messages in recording.topics.items()}
    table.require("every message of every channel decodes with its schema", decoded == counts, f"{sum(decoded.values())} messages, {len(decoded)} channels", "" if decoded == counts else str(counts))
    for topic, count in sorted(decoded.items()):
        table.show(f"  {topic}", count, recording.schemas[topic])
    video = recording["/video"]
    formats = {message.format for message in video}
    table.require("/video is foxglove.CompressedVideo in h264", recording.schemas.get("/video") == "foxglove.CompressedVideo" and formats == {"h264"}, f"{recording.schemas.get('/video')}, {formats}")
    stream = folder / "stream.h264"
    stream.write_bytes(b"".join(message.data for message in video))
    seen = pictures(stream)
    table.require("the stored H.264 is decoded by another decoder", seen == len(video), f"{seen} of {len(video)} pictures")
    table.require("every picture that the pilot saw is stored", {frame.captured_ns for frame in recording.frames} <= {unit.captured_ns for unit in recording["/video/unit"]}, f"{len(recording.frames)} frames")
    table.require("every frame has a hash of its luma", all(frame.luma_hash for frame in recording.frames), f"{len({frame.luma_hash for frame in recording.frames})} different")


def main():
    args = common.arguments(
        __doc__, clip=common.CLIP, count={"type": int, "default": 20, "help": "how many runs are killed"}, seed={"type": int, "default": 1}, at_once={"type": int, "default": 4}
    )
    folder = common.temporary_folder()
    clip, truth = common.practice_clip(args, folder)
    selection = common.selection(truth)
    chance = random.Random(args.seed)
    moments = [chance.uniform(FIRST, LAST) for _ in range(args.count)]
    table = Table(f"{args.count} recordings whose run was killed with -9")
    with concurrent.futures.ThreadPoolExecutor(args.at_once) as pool:
        kills = list(pool.map(lambda job: try_kill(args, clip, selection, folder, *job), enumerate(moments)))
    for number, kill in enumerate(kills):
        measured = f"{kill['lost']:.2f} s lost, {kill.get('outcomes', 0)} outcomes, {kill.get('pictures', 0)} pictures"
        table.require(f"kill {number + 1} after {kill['moment']:.2f} s: read, replayed, exported", not kill["faults"], measured, "; ".join(kill["faults"]))
    table.show("lost at the end: median, largest", f"{common.median([kill['lost'] for kill in kills]):.2f}, {max(kill['lost'] for kill in kills):.2f} s", f"at most {LOSES_AT_MOST:.1f} s")
    for line in sorted({line.strip() for kill in kills for line in kill.get("said", "").splitlines()}):
        table.show("said on stderr", line)
    check_complete(table, args, clip, selection, folder)
    return table.finish(args, kills=kills)


if __name__ == "__main__":
    sys.exit(main())
