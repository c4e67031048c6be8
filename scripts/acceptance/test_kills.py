"""Recordings of killed runs: at most the last second is lost, and the rest can be replayed and exported.

The runs are killed with SIGKILL at random times from a seed. Then a complete recording is decoded in full.
"""

import pathlib
import random
import signal
import time

import cv2
import pytest
from mcap.reader import make_reader

from client import HARDLY_RESTS
from conftest import Check, Clip
from machine import Delay
from process import Child, Lines, end, run, spawn
from recording import Recording

# It is flushed twice a second, so that a late turn of a busy machine still stays within the last second.
LOSES_AT_MOST = 1.0
CHANCE = random.Random(1)
MOMENTS = [CHANCE.uniform(0.4, 9.0) for _ in range(20)]


def start(barrelman: pathlib.Path, clip: Clip, record: pathlib.Path) -> Child:
    what = [
        "--mode",
        HARDLY_RESTS,
        "--video",
        f"file:{clip.video}",
        "--select",
        clip.selection,
        "--record",
        record,
    ]
    return spawn([barrelman, "run", "--headless", "--engage", *what])


def pictures(video: pathlib.Path) -> int:
    """Number of pictures that OpenCV decodes from a file."""
    capture = cv2.VideoCapture(str(video))
    count = 0
    while capture.read()[0]:
        count += 1
    return count


@pytest.mark.alone
@pytest.mark.apart
@pytest.mark.parametrize(
    "moment",
    [*MOMENTS[:3], *(pytest.param(moment, marks=pytest.mark.long) for moment in MOMENTS[3:])],
    ids=lambda moment: f"{moment:.2f} s",
)
def test_recording_of_a_killed_run_is_read_replayed_and_exported(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check, moment: float
) -> None:
    record, out = tmp_path / "killed.mcap", tmp_path / "exported"
    child = start(barrelman, clip, record)
    errors = Lines(child.stderr)
    time.sleep(moment)
    at = time.monotonic()
    child.kill()
    assert child.wait() == -signal.SIGKILL, f"it had ended before: {errors.text()}"
    recording = Recording(record)
    assert recording.start is not None, f"nothing could be read: {recording.cut}"
    outcomes, stored = recording.outcomes, len(recording["/video"])
    stored_until = recording.at(max((outcome.now_ns for outcome in outcomes), default=0))
    check.in_time("at most the last second is lost", Delay.between(stored_until, at), LOSES_AT_MOST)
    done = run([barrelman, "replay", record, "--compare"])
    # A run that was killed within its first second may have left nothing to compare, which is then said.
    check(
        "the rest is replayed",
        done.returncode == 0 or (not outcomes and "no outcome" in done.stderr),
        done.stderr[-200:],
    )
    done = run([barrelman, "export", record, "--output", out])
    # Exit 1 says that the recording was cut, as with a CSV file that was; what there is must be there all the
    # same.
    check("the rest is exported", done.returncode == 0 or "cut off" in done.stderr, done.stderr[-200:])
    rows = len((out / "outcome.csv").read_text().splitlines()) - 1 if (out / "outcome.csv").exists() else 0
    check("every outcome is exported", rows >= len(outcomes), f"{rows} of {len(outcomes)}")
    shown = pictures(out / "video.mp4") if stored else 0
    check("every picture is exported", shown >= stored, f"{shown} of {stored}")


def test_complete_recording_is_decoded_in_full(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check
) -> None:
    record = tmp_path / "complete.mcap"
    child = start(barrelman, clip, record)
    errors = Lines(child.stderr)
    time.sleep(4.0)
    code = end(child)
    check(
        "the run that was asked to end does so with exit 0", code == 0, errors.text()[-200:] if code else ""
    )
    recording = Recording(record)
    check("the recording is whole", recording.cut is None, recording.cut or "")
    with record.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    counts = {
        summary.channels[channel].topic: count
        for channel, count in summary.statistics.channel_message_counts.items()
    }
    decoded = {topic: len(messages) for topic, messages in recording.topics.items()}
    check(
        "every message of every channel decodes with its schema", decoded == counts, f"{decoded} of {counts}"
    )
    video = recording["/video"]
    form = recording.schemas.get("/video"), {message.format for message in video}
    check("/video is foxglove.CompressedVideo in h264", form == ("foxglove.CompressedVideo", {"h264"}), form)
    seen = pictures(recording.stream(tmp_path / "stream.h264"))
    check("another decoder decodes the stored H.264", seen == len(video), f"{seen} of {len(video)} pictures")
    is_stored = {frame.captured_ns for frame in recording.frames} <= {
        unit.captured_ns for unit in recording["/video/unit"]
    }
    check("every picture that the pilot saw is stored", is_stored, f"{len(recording.frames)} frames")
    check("every frame has a hash of its luma", all(frame.luma_hash for frame in recording.frames))
