"""The sources of video: live streams of every kind and codec, files of every kind, pipes, pipelines.

The live ones come from real GStreamer servers and senders, which draw CLOCK_MONOTONIC and a slow red patch
into every picture.
"""

import contextlib
import dataclasses
import pathlib
import re
import shutil
import socket
import subprocess
import threading
import time

import pytest

from camera import FPS, SELECTION, Camera
from conftest import Check, Clip
from machine import median, percentile
from process import Lines, end, run, spawn
from recording import Recording
from timecodes import read_codes

UP = "video: up"
SECONDS = 6.0
FORMATS = {"h264": 1, "h265": 5, "vp9": 6, "av1": 7}
ENCODERS = {
    "h264": "-c:v libx264 -preset ultrafast -g 30",
    "h265": "-c:v libx265 -preset ultrafast -g 30 -x265-params log-level=none",
}
NO_MEDIA = "scripts/setup.sh media && cargo build --release -p barrelman-media"


@dataclasses.dataclass
class Run:
    """A run on a live source. `delays_ms`: from time code to localisation, without the first second."""

    recording: Recording
    path: pathlib.Path
    tracked: float
    delays_ms: list[float]
    log: str


def watch(barrelman: pathlib.Path, url: str, folder: pathlib.Path, *options: object) -> Run:
    path = folder / "run.mcap"
    command = [
        barrelman,
        "run",
        "--headless",
        "--video",
        url,
        "--select",
        SELECTION,
        "--record",
        path,
        *options,
    ]
    child = spawn(command)
    errors = Lines(child.stderr)
    errors.wait_for(UP)
    time.sleep(SECONDS)
    end(child)
    recording = Recording(path)
    outcomes = {outcome.step: outcome for outcome in recording.outcomes}
    codes = read_codes(recording, folder)
    delays = [
        (recording.at(outcomes[frame.step].now_ns) * 1e3 - codes[frame.captured_ns] + 2**31) % 2**32 - 2**31
        for frame in recording.frames
        if frame.captured_ns in codes
    ]
    states = [outcomes[frame.step].track.state for frame in recording.frames][FPS:]
    tracked = sum(state == 1 for state in states) / max(len(states), 1)
    return Run(recording, path, tracked, delays[FPS:], errors.text())


@pytest.mark.realtime
@pytest.mark.parametrize("codec", ["h264", "h265"])
@pytest.mark.parametrize("way", ["tcp", "udp", "rtp", "ts"])
def test_live_stream_is_tracked(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, way: str, codec: str
) -> None:
    with Camera(way, codec) as camera:
        watched = watch(barrelman, camera.url, tmp_path)
    units = watched.recording["/video/unit"]
    check("the units are stored as they came", {unit.codec for unit in units} == {FORMATS[codec]})
    check("the boat is tracked", watched.tracked > 0.9, watched.tracked)
    check("nearly every picture is looked at", len(watched.recording.frames) > 0.75 * FPS * SECONDS)
    middle, high = median(watched.delays_ms), percentile(watched.delays_ms, 0.95)
    check("the picture's age is measured", 0 < middle < 1000, f"{middle:.1f} ms, 95 %: {high:.1f} ms")
    replayed = run([barrelman, "replay", watched.path, "--compare"])
    check("a replay decodes the same pictures", replayed.returncode == 0, replayed.stdout[-300:])


@pytest.mark.realtime
@pytest.mark.parametrize("codec", ["h264", "h265"])
def test_stream_that_is_announced_as_another_is_tracked(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, codec: str
) -> None:
    names = [b"H264/90000", b"H265/90000"]
    announced, sent = names if codec == "h265" else reversed(names)
    with Camera("tcp", codec) as camera:
        port = replacing_relay(camera.port, sent, announced)
        watched = watch(barrelman, f"rtsp://127.0.0.1:{port}/video", tmp_path)
    assert watched.tracked > 0.9, watched.log


def replacing_relay(to: int, found: bytes, put: bytes) -> int:
    """A port that leads to another one, whose answers have one text replaced by another of its length."""
    listener = socket.create_server(("127.0.0.1", 0))

    def accept() -> None:
        while True:
            near, _ = listener.accept()
            far = socket.create_connection(("127.0.0.1", to))
            for source, sink in ((near, far), (far, near)):
                threading.Thread(target=pass_on, args=(source, sink), daemon=True).start()

    def pass_on(source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                sink.sendall(data.replace(found, put))
            sink.shutdown(socket.SHUT_WR)

    threading.Thread(target=accept, daemon=True).start()
    return int(listener.getsockname()[1])


@pytest.mark.parametrize("codec", ["h264", "h265"])
@pytest.mark.parametrize("container", ["mkv", "mp4", "ts"])
def test_file_is_tracked(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, container: str, codec: str
) -> None:
    path = tmp_path / f"clip.{container}"
    convert(clip.video, path, ENCODERS[codec])
    assert track(barrelman, path, clip.selection) > 0.9


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("motion.avi", "-c:v mjpeg -q:v 3"),
        ("film.webm", "-c:v libvpx-vp9 -deadline realtime -cpu-used 8 -b:v 2M"),
        ("new.mkv", "-c:v libaom-av1 -cpu-used 8 -usage realtime -b:v 2M -frames:v 60"),
        ("deep.mp4", "-c:v libx264 -preset ultrafast -pix_fmt yuv420p10le"),
        ("broadcast.mkv", "-c:v libx265 -preset ultrafast -pix_fmt yuv422p10le -x265-params log-level=none"),
        ("interlaced.mp4", "-c:v libx264 -preset ultrafast -flags +ildct+ilme -x264-params tff=1"),
        ("old.mpg", "-c:v mpeg2video -q:v 3"),
        ("apple.mov", "-c:v prores_ks -profile:v 0"),
        ("large.mp4", "-vf scale=5312:2988 -c:v libx264 -preset ultrafast -crf 35 -frames:v 20"),
    ],
)
def test_file_of_another_kind_is_tracked(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, name: str, options: str
) -> None:
    path = tmp_path / name
    convert(clip.video, path, options)
    selection = clip.selection
    if name == "large.mp4":
        # Pictures above 4096 pixels are scaled down to that.
        selection = ",".join(f"{float(value) * 4096 / 1280:.0f}" for value in selection.split(","))
    assert track(barrelman, path, selection) > 0.9


def test_track_that_is_switched_off_is_not_read(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path
) -> None:
    path = tmp_path / "preview.mp4"
    film = "-map 0:v -map 0:v -c:v libx264 -preset ultrafast -s:v:0 160x90 -s:v:1 640x360 -frames:v 5"
    convert(clip.video, path, f"{film} -disposition:v:0 0 -disposition:v:1 default")
    done = run([barrelman, "snapshot", path, "--output", tmp_path / "picture.png"])
    assert "640x360" in done.stdout, done.stdout + done.stderr


def test_part_of_a_longer_video_begins_at_once(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path
) -> None:
    path = tmp_path / "part.mp4"
    convert(clip.video, path, f"{ENCODERS['h264']} -output_ts_offset 3600 -movflags frag_keyframe+empty_moov")
    command = [barrelman, "run", "--headless", "--no-record", "--video", path, "--select", clip.selection]
    done = run(command, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "the video has ended" in done.stderr


def test_pipes_are_read(barrelman: pathlib.Path, clip: Clip, check: Check) -> None:
    for name, options in [
        ("Y4M", "-f yuv4mpegpipe"),
        ("MPEG-TS", "-c:v libx264 -preset ultrafast -f mpegts"),
    ]:
        words = f"ffmpeg -v error -t 3 -i {clip.video} -pix_fmt yuv420p {options} -".split()
        with subprocess.Popen(words, stdout=subprocess.PIPE) as writer:
            command = [str(barrelman), "track", "-", "--select", clip.selection]
            done = subprocess.run(command, stdin=writer.stdout, capture_output=True, text=True, check=False)
        share = tracked_share(done.stdout)
        check(f"{name} through a pipe is tracked", done.returncode == 0 and share > 0.9, done.stderr[-300:])


def test_pipeline_of_the_users_own(barrelman: pathlib.Path, tmp_path: pathlib.Path) -> None:
    picture = tmp_path / "picture.png"
    source = "gst:videotestsrc is-live=true ! video/x-raw,width=640,height=360,framerate=30/1"
    done = run([barrelman, "snapshot", source, "--output", picture])
    assert done.returncode == 0, done.stderr
    assert "640x360" in done.stdout
    assert picture.stat().st_size > 1000


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("/dev/video97", r"/dev/video97.*"),
        ("gst:videotestsrc ! nosuchelement", "nosuchelement"),
        ("gst:audiotestsrc", "no video"),
        ("udp://127.0.0.1:1?codec=h999", "codec=h265"),
        ("127.0.0.1:554/live", "rtsp://127.0.0.1:554/live"),
        ("nowhere.sdp", "nowhere.sdp"),
    ],
)
def test_address_that_cannot_be_used_says_why(barrelman: pathlib.Path, address: str, said: str) -> None:
    done = run([barrelman, "check", "--video", address], timeout=40)
    assert done.returncode == 1
    line = next(line for line in done.stdout.splitlines() if line.startswith("FAILED"))
    assert re.search(said, line), line


def test_without_the_second_program_the_two_commands_are_named(
    barrelman: pathlib.Path, clip: Clip, tmp_path: pathlib.Path, check: Check
) -> None:
    alone = tmp_path / "barrelman"
    shutil.copy(barrelman, alone)
    path = tmp_path / "clip.mkv"
    convert(clip.video, path, ENCODERS["h265"])
    for address in [path, "udp://127.0.0.1:5600", "/dev/video0", "gst:videotestsrc"]:
        done = run([alone, "snapshot", address, "--output", tmp_path / "x.png"], timeout=60)
        check(f"{address}", done.returncode == 1 and NO_MEDIA in done.stderr, done.stderr)


def convert(source: pathlib.Path, to: pathlib.Path, options: str) -> None:
    done = run(["ffmpeg", "-v", "error", "-y", "-t", "4", "-i", source, "-an", *options.split(), to])
    assert done.returncode == 0, done.stderr


def track(barrelman: pathlib.Path, path: pathlib.Path, selection: str) -> float:
    """The share of the frames on which the boat is tracked."""
    done = run([barrelman, "track", path, "--select", selection])
    assert done.returncode == 0, done.stderr
    return tracked_share(done.stdout)


def tracked_share(rows: str) -> float:
    states = [line.split(",")[2] for line in rows.splitlines()[1:]]
    return states.count("tracking") / len(states) if len(states) >= 20 else 0.0
