"""Live video from an RTSP server on loopback: the latency up to the localisation, and restarts of the server.

The server draws CLOCK_MONOTONIC into every picture, so that the latency covers the encoder, the network, the
decoder and the tracker.
"""

import dataclasses
import functools
import pathlib
import time
from collections.abc import Iterator

import pytest

from camera import FPS, SELECTION, Camera
from conftest import Check
from machine import Delay, lost, median, percentile, took, wait_until
from process import Lines, end, memory_mb, spawn, threads_of
from recording import Recording
from timecodes import read_codes

SECONDS = 12.0
LATENCY_LIMIT_MS = 10
BACK_WITHIN = 3.0
GROWS_AT_MOST_MB = 4.0
UP = "video: up"


@pytest.fixture(scope="module")
def camera() -> Iterator[Camera]:
    with Camera() as camera:
        yield camera


@dataclasses.dataclass
class Latency:
    """`to_localisation_ms`: from the time code to the localisation, without the first second, which starts
    encoder and decoder."""

    frames: int
    tracked: int
    seconds: float
    to_localisation_ms: list[float]


@pytest.fixture(scope="module")
def latency(barrelman: pathlib.Path, camera: Camera, tmp_path_factory: pytest.TempPathFactory) -> Latency:
    folder = tmp_path_factory.mktemp("latency")
    record = folder / "latency.mcap"
    child = spawn(
        [barrelman, "run", "--headless", "--video", camera.url, "--select", SELECTION, "--record", record]
    )
    Lines(child.stderr).wait_for(UP)
    time.sleep(1.0)
    began, cpu = time.monotonic(), sum(threads_of(child).values())
    time.sleep(SECONDS)
    seconds, cpu = took(began, time.monotonic()), (sum(threads_of(child).values()) - cpu) / SECONDS
    end(child)
    recording = Recording(record)
    code_of = read_codes(recording, folder)
    outcomes = {outcome.step: outcome for outcome in recording.outcomes}
    found = []
    for frame in recording.frames:
        at_ms = recording.at(outcomes[frame.step].now_ns) * 1e3
        found.append((at_ms - code_of[frame.captured_ns] + 2**31) % 2**32 - 2**31)
    tracked = sum(outcomes[frame.step].track.state == 1 for frame in recording.frames)
    middle, worst = median(found[FPS:]), percentile(found[FPS:], 0.95)
    print(f"{cpu:.2f} of a core; time code to localisation: {middle:.1f} ms, {worst:.1f} ms")
    return Latency(len(found), tracked, seconds, found[FPS:])


def test_nearly_every_frame_is_localised(latency: Latency) -> None:
    assert latency.tracked > 0.95 * latency.frames


def test_nearly_every_frame_is_looked_at(latency: Latency) -> None:
    assert latency.frames >= 0.9 * FPS * latency.seconds


@pytest.mark.strict
def test_localisation_is_at_most_10_ms_behind_the_time_code(latency: Latency) -> None:
    assert median(latency.to_localisation_ms) <= LATENCY_LIMIT_MS


def is_up_again(errors: Lines, ups: int) -> bool:
    return errors.count(UP) > ups


@pytest.mark.parametrize("restarts", [2, pytest.param(10, marks=pytest.mark.long)])
def test_video_returns_after_each_restart_of_the_server(
    barrelman: pathlib.Path, camera: Camera, tmp_path: pathlib.Path, check: Check, restarts: int
) -> None:
    record = tmp_path / "restarts.mcap"
    child = spawn([barrelman, "run", "--headless", "--video", camera.url, "--record", record])
    errors = Lines(child.stderr)
    errors.wait_for(UP)
    returns, memory = [], []
    for restart in range(restarts):
        time.sleep(1.0)
        ups = errors.count(UP)
        camera.kill()
        time.sleep(0.5 + 0.3 * (restart % 4))
        returns.append(camera.start())
        wait_until(functools.partial(is_up_again, errors, ups), UP)
        time.sleep(1.5)
        memory.append(memory_mb(child))
    # A server that hangs without a word: nothing closes the connection.
    camera.child.send_signal(19)
    hung = time.monotonic()
    wait_until(
        lambda: any(at > hung and "lost" in line for at, line in errors.lines), "the loss of the video"
    )
    time.sleep(max(0.0, hung + 3.5 - time.monotonic()))
    camera.child.send_signal(18)
    resumed = time.monotonic()
    time.sleep(3.5 + lost(hung, resumed))
    code = end(child)
    recording = Recording(record)
    times = [recording.at(frame.now_ns) for frame in recording.frames]
    for number, back in enumerate([*returns, resumed]):
        delay = Delay.between(back, next((at for at in times if at > back), float("inf")), processes=3)
        name = f"restart {number + 1}" if number < restarts else "a server that hung"
        check.in_time(f"frames flow again after {name}", delay, BACK_WITHIN)
    check(
        "memory does not grow from the second restart on", memory[-1] - memory[1] <= GROWS_AT_MOST_MB, memory
    )
    check("the run ends with exit 0", code == 0, code)


def test_camera_that_ends_its_stream_is_lost_and_comes_back_where_gstreamer_reads_it(
    barrelman: pathlib.Path, camera: Camera, tmp_path: pathlib.Path, check: Check
) -> None:
    config = tmp_path / "gstreamer.toml"
    config.write_text('[video]\nengine = "gstreamer"\n')
    child = spawn([barrelman, "run", config, "--headless", "--no-record", "--video", camera.url])
    errors = Lines(child.stderr)
    errors.wait_for(UP)
    ups = errors.count(UP)
    # The server closes its connections in order.
    camera.child.terminate()
    camera.child.wait()
    wait_until(lambda: errors.count("lost"), "the loss of the video")
    camera.start()
    wait_until(functools.partial(is_up_again, errors, ups), UP)
    check("the run ends with exit 0", end(child) == 0)
