"""The engines of video in turns: the delay from capture to localisation, and the processor time."""

import pathlib
import resource

import pytest

from camera import Camera
from conftest import Check
from machine import median, percentile
from process import run
from test_sources import watch

pytestmark = [pytest.mark.alone, pytest.mark.clocked, pytest.mark.long]

ROUNDS = 4
ENCODER_TIME = pathlib.Path(__file__).with_name("encoder_time.py")
SIZE = (1280, 720)
MORE_IN_MIDDLE_MS, MORE_AT_WORST_MS, MORE_FOR_H265_MS = 4.0, 8.0, 8.0


def test_gstreamer_is_hardly_later_than_the_built_in_engine(
    barrelman: pathlib.Path, folder: pathlib.Path, check: Check
) -> None:
    ways = {"built-in h264": [], "gstreamer h264": [], "gstreamer h265": []}  # type: dict[str, list[float]]
    seconds, pictures = dict.fromkeys(ways, 0.0), dict.fromkeys(ways, 0)
    encoding = {"h264": [], "h265": []}  # type: dict[str, list[float]]
    for turn in range(ROUNDS):
        for codec, times in encoding.items():
            done = run(["/usr/bin/python3", ENCODER_TIME, codec, *map(str, SIZE)], timeout=60)
            times.append(float(done.stdout))
        for way, delays in ways.items():
            engine, codec = way.split()
            place = folder / f"{engine}-{codec}-{turn}"
            place.mkdir()
            config = place / "engine.toml"
            config.write_text(f'[video]\nengine = "{engine}"\n')
            with Camera("tcp", codec) as camera:
                before = resource.getrusage(resource.RUSAGE_CHILDREN)
                watched = watch(barrelman, camera.url, place, config)
                after = resource.getrusage(resource.RUSAGE_CHILDREN)
            delays += watched.delays_ms
            seconds[way] += after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            pictures[way] += len(watched.recording.frames)
    middle = {way: median(delays) for way, delays in ways.items()}
    high = {way: percentile(delays, 0.95) for way, delays in ways.items()}
    shown = "; ".join(
        f"{way}: {middle[way]:.1f} ms, 95 %: {high[way]:.1f} ms, "
        f"{seconds[way] / pictures[way] * 1e3:.1f} ms of processor time a picture, {pictures[way]} pictures"
        for way in ways
    )
    # A camera encodes H.265 by hardware: the time that x265 takes more than x264 is taken off.
    more_encoding = median(encoding["h265"]) - median(encoding["h264"])
    shown += f"; x265 takes {more_encoding:.1f} ms more than x264"
    more = {way: middle[way] - middle["built-in h264"] for way in ways}
    more["gstreamer h265"] -= more_encoding
    worse = high["gstreamer h264"] - high["built-in h264"]
    check("H.264: the median", more["gstreamer h264"] <= MORE_IN_MIDDLE_MS, shown)
    check("H.264: the 95th percentile", worse <= MORE_AT_WORST_MS, shown)
    check("H.265: the median", more["gstreamer h265"] <= MORE_FOR_H265_MS, shown)
