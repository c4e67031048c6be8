"""The processes of GStreamer die, stop or crash while the camera follows: it rests, and the video returns.

A camera on loopback sends H.265, which the program leaves to `barrelman-media`: one process reads the stream,
another decodes it. In turns, one of them receives a signal while the camera turns.
"""

import bisect
import math
import os
import pathlib
import signal
import time

import pytest

from camera import SELECTION, Camera
from client import HARDLY_RESTS
from conftest import Check
from emulator import Emulator
from machine import Delay, poll, wait_until
from process import Lines, end, spawn
from recording import Recording

pytestmark = [pytest.mark.realtime, pytest.mark.clocked]

REST_LIMIT, RETURN_LIMIT = 0.35, 3.0
# Threads and processes from a signal to the rates in force: the source or decoder, the video's thread, the
# pilot, the link, the emulator.
HOPS = 5


def media_processes(parent: int) -> list[int]:
    """The living processes `barrelman-media` of a run, in the order of their start."""
    children = pathlib.Path(f"/proc/{parent}/task").glob("*/children")
    found = [int(child) for path in children for child in path.read_text().split()]
    return sorted(
        child
        for child in found
        if (text := pathlib.Path(f"/proc/{child}/stat").read_text()).split()[1] == "(barrelman-media)"
        and text.rsplit(")", 1)[1].split()[0] != "Z"
    )


@pytest.mark.parametrize("name", ["SIGKILL", "SIGSTOP", "SIGSEGV"])
@pytest.mark.parametrize("times", [1, pytest.param(10, marks=pytest.mark.long)])
def test_camera_rests_until_the_video_returns(
    barrelman: pathlib.Path, folder: pathlib.Path, check: Check, name: str, times: int
) -> None:
    record = folder / "run.mcap"
    with Camera("tcp", "h265") as camera, Emulator(barrelman, folder) as emulator:
        what = ["--video", camera.url, "--select", SELECTION, "--mode", HARDLY_RESTS, "--record", record]
        child = spawn([barrelman, "run", "--headless", "--engage", "--link", emulator.url, *what])
        errors = Lines(child.stderr)
        struck = []
        for turn in range(times):
            emulator.wait_until_it_moves()
            processes = wait_until(
                lambda: found if len(found := media_processes(child.pid)) == 2 else None,
                "a source and a decoder",
            )
            struck.append(time.monotonic())
            os.kill(processes[turn % 2], signal.Signals[name])
            time.sleep(RETURN_LIMIT)
        poll(lambda: emulator.rows()[-1].moves, RETURN_LIMIT)
        code = end(child, signal.SIGTERM)
        rows = emulator.rows()
    check("the run ends with exit 0", code == 0, errors.text()[-300:])
    recording = Recording(record)
    now = {outcome.step: recording.at(outcome.now_ns) for outcome in recording.outcomes}
    seen = sorted(now[frame.step] for frame in recording.frames)
    for at in struck:
        back = next((row for row in seen[bisect.bisect(seen, at + 0.05) :]), math.inf)
        rest = next((row.at for row in rows if row.at >= at and row.rates == (0.0, 0.0)), math.inf)
        # Where a picture comes before that time, the camera may go on.
        if back - at > REST_LIMIT:
            check.in_time("the camera rests", Delay.between(at, rest, HOPS), REST_LIMIT)
        check.in_time("the video returns", Delay.between(at, back, HOPS), RETURN_LIMIT)
