#!/usr/bin/python3
"""Prints the time that an encoder of scripts/rtsp_server.py takes for a picture, ms: the median.

Runs with the Python that has GStreamer: `encoder_time.py h264|h265 WIDTH HEIGHT`.
"""

import pathlib
import statistics
import sys
import time

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstApp", "1.0")
from gi.repository import Gst, GstApp  # noqa: E402, F401

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from rtsp_server import ENCODERS  # noqa: E402
from timecode_server import timecode  # noqa: E402

FPS, PICTURES, WARM_UP = 30, 120, 15


def main() -> None:
    codec, width, height = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    caps = f"video/x-raw,format=I420,width={width},height={height},framerate={FPS}/1"
    pipeline = Gst.parse_launch(
        f"appsrc name=source is-live=true format=time caps={caps} ! {ENCODERS[codec].format(fps=FPS)}"
        " ! appsink name=sink sync=false"
    )
    source, sink = pipeline.get_by_name("source"), pipeline.get_by_name("sink")
    pipeline.set_state(Gst.State.PLAYING)
    took = []
    for number in range(PICTURES):
        buffer = Gst.Buffer.new_wrapped(timecode(width, height))
        buffer.pts, buffer.duration = number * Gst.SECOND // FPS, Gst.SECOND // FPS
        began = time.monotonic()
        source.emit("push-buffer", buffer)
        assert sink.try_pull_sample(5 * Gst.SECOND), "no picture came out of the encoder"
        took.append((time.monotonic() - began) * 1e3)
        time.sleep(max(0.0, 1 / FPS - (time.monotonic() - began)))
    pipeline.set_state(Gst.State.NULL)
    print(statistics.median(took[WARM_UP:]))


if __name__ == "__main__":
    Gst.init(None)
    main()
