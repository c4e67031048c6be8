"""Tests live video from an RTSP server on loopback: the latency up to the localisation, and restarts of the server.

The server draws CLOCK_MONOTONIC into every picture, so that the latency covers the encoder, the network, the decoder
and the tracker. The latency depends on the machine: the script fails over the latency only with --strict. After each
restart of the server the video must return, and memory must not grow: these requirements always count.
"""
import os
import pathlib
import signal
import socket
import subprocess
import sys
import time

import common
from common import HEIGHT, WIDTH, Lines, Recording, Table

SERVER = pathlib.Path(__file__).with_name("timecode_server.py")
PYTHON = "/usr/bin/python3"
FPS = 30
LATENCY_LIMIT_MS = 10
BACK_WITHIN = 3.0
GROWS_AT_MOST_MIB = 4.0
# The patch of the server rests in the middle for some seconds, and moves at most 170 px/s then.
SELECTION = f"{WIDTH // 2 - 26},{HEIGHT // 2 - 26},52,52"
BIT_ROWS = HEIGHT // 16


def needs_server():
    try:
        done = common.run([PYTHON, SERVER, "--check"], timeout=30)
        missing = done.stderr.strip().splitlines()[-1] if done.returncode else None
    except OSError as error:
        missing = str(error)
    if missing:
        print(f"skipped: no RTSP server to try ({missing}): scripts/setup.sh test installs one")
        sys.exit(1 if os.environ.get("CI") else 0)


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def serve(port):
    """Starts the server; returns the server and the time at which it began to listen."""
    command = [PYTHON, SERVER, "--port", port, "--pattern", "timecode", "--size", f"{WIDTH}x{HEIGHT}", "--fps", FPS]
    child = common.spawn(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    at, _ = Lines(child.stdout).wait_for("rtsp://", 15)
    return child, at


def cpu_seconds(child):
    fields = pathlib.Path(f"/proc/{child.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def read_codes(stream):
    """The time code of every picture, in milliseconds of CLOCK_MONOTONIC (its lower 32 bits)."""
    import cv2

    capture = cv2.VideoCapture(str(stream))
    codes = []
    while True:
        there, picture = capture.read()
        if not there:
            return codes
        grey = cv2.cvtColor(picture[: BIT_ROWS - 8], cv2.COLOR_BGR2GRAY)
        bits = [grey[8:, bit * WIDTH // 32 + 8 : (bit + 1) * WIDTH // 32 - 8].mean() > 128 for bit in range(32)]
        codes.append(sum(1 << (31 - bit) for bit, one in enumerate(bits) if one))


def latencies(record, folder):
    """(recording, ms from time code to localisation, ms from time code to time of capture, frames localised)."""
    recording = Recording(record)
    stream = folder / "stream.h264"
    stream.write_bytes(b"".join(message.data for message in recording["/video"]))
    codes = read_codes(stream)
    units = recording["/video/unit"]
    if len(codes) != len(units):
        raise RuntimeError(f"{len(codes)} pictures decoded of {len(units)} stored")
    code_of = {unit.captured_ns: code for unit, code in zip(units, codes)}
    outcomes = {outcome.step: outcome for outcome in recording.outcomes}
    found, tracked, captured = [], 0, []
    for frame in recording.frames:
        outcome = outcomes[frame.step]
        code = code_of[frame.captured_ns]
        tracked += outcome.track.state == 1
        found.append((recording.at(outcome.now_ns) * 1e3 - code + 2**31) % 2**32 - 2**31)
        captured.append((recording.at(frame.captured_ns) * 1e3 - code + 2**31) % 2**32 - 2**31)
    return recording, found, captured, tracked


def wait_for_frames(err, ups):
    """Waits until the log has more than `ups` lines with `video: up`."""
    return common.wait_until(lambda: sum("video: up" in line for _, line in list(err.lines)) > ups, 15, "`video: up`")


def main():
    args = common.arguments(
        __doc__, restarts={"type": int, "default": 10}, seconds={"type": float, "default": 12.0, "help": "how long to measure latency"}, strict={"action": "store_true", "help": "fail over the latency, too"}
    )
    needs_server()
    folder = common.temporary_folder()
    table = Table(f"Live video over RTSP, {WIDTH}x{HEIGHT} at {FPS} fps")
    port = free_port()
    server, _ = serve(port)
    url = f"rtsp://127.0.0.1:{port}/video"

    record = folder / "latency.mcap"
    began = time.monotonic()
    child = common.spawn([args.barrelman, "run", "--headless", "--video", url, "--select", SELECTION, "--record", record], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    err = Lines(child.stderr)
    err.wait_for("video: up", 15)
    time.sleep(1.0)
    cpu, since = cpu_seconds(child), time.monotonic()
    time.sleep(args.seconds)
    cpu = (cpu_seconds(child) - cpu) / (time.monotonic() - since)
    child.send_signal(signal.SIGTERM)
    child.wait(timeout=10)
    recording, found, captured, tracked = latencies(record, folder)
    table.show("from the program's start to its first frame", f"{recording.at(recording.frames[0].now_ns) - began:.2f} s")
    # The first second is the start of encoder and decoder.
    settled = found[FPS:]
    table.require("frames localised", tracked > 0.95 * len(found), f"{tracked} of {len(found)}")
    table.require("frames a second", len(found) >= 0.9 * FPS * args.seconds, f"{len(found) / (args.seconds + 1):.1f}")
    middle = common.median(settled)
    measured = f"{middle:.1f}, {common.percentile(settled, 0.95):.1f}, {max(settled):.1f} ms"
    name = "time code to localisation: median, p95, largest"
    if args.strict:
        table.require(name, middle <= LATENCY_LIMIT_MS, measured, f"median at most {LATENCY_LIMIT_MS} ms")
    else:
        table.show(name, measured, f"wanted: median at most {LATENCY_LIMIT_MS} ms")
    table.show("time code to the time of capture that it was given: median", f"{common.median(captured[FPS:]):.1f} ms")
    table.show("load of the program", f"{cpu * 100:.0f} % of a core")

    record = folder / "restarts.mcap"
    child = common.spawn([args.barrelman, "run", "--headless", "--video", url, "--record", record], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    err = Lines(child.stderr)
    err.wait_for("video: up", 15)
    returns, memory = [], []
    for restart in range(args.restarts):
        time.sleep(1.0)
        ups = sum("video: up" in line for _, line in list(err.lines))
        server.kill()
        server.wait()
        time.sleep(0.5 + 0.3 * (restart % 4))
        server, at = serve(port)
        returns.append(at)
        try:
            wait_for_frames(err, ups)
        except TimeoutError as error:
            table.require(f"restart {restart + 1}", False, str(error), err.text()[-300:])
            break
        time.sleep(1.5)
        memory.append(common.memory_mb(child))
    # A server that hangs without a word: nothing closes the connection.
    ups = sum("video: up" in line for _, line in list(err.lines))
    server.send_signal(signal.SIGSTOP)
    hung = time.monotonic()
    time.sleep(3.5)
    noticed = next((at - hung for at, line in err.lines if at > hung and "lost" in line), None)
    server.send_signal(signal.SIGCONT)
    resumed = time.monotonic()
    time.sleep(3.5)
    child.send_signal(signal.SIGTERM)
    child.wait(timeout=10)
    recording = Recording(record)
    times = [recording.at(frame.now_ns) for frame in recording.frames]
    waits = [next((at - back for at in times if at > back), float("inf")) for back in returns]
    table.require("frames flow again after the server's return", len(waits) == args.restarts and max(waits) <= BACK_WITHIN, f"{len(waits)} times, {min(waits):.2f} to {max(waits):.2f} s", f"at most {BACK_WITHIN:.0f} s")
    if args.restarts > 2:
        growth = memory[-1] - memory[1]
        table.require("memory after the last restart, over that after the second", growth <= GROWS_AT_MOST_MIB, f"{growth:+.2f} MiB ({memory[1]:.1f} -> {memory[-1]:.1f})", f"at most {GROWS_AT_MOST_MIB:.0f} MiB")
    else:
        table.show("memory after each restart", " ".join(f"{mib:.1f}" for mib in memory), "MiB")
    flowing = next((at - resumed for at in times if at > resumed), float("inf"))
    table.require("a server that hangs is noticed, and its video comes back", noticed is not None and flowing <= BACK_WITHIN, f"after {noticed or float('inf'):.2f} s; back after {flowing:.2f} s", f"at most {BACK_WITHIN:.0f} s")
    table.require("the run ends with exit 0", child.returncode == 0, f"exit {child.returncode}")
    table.show("lines on stderr meanwhile", len(err.lines))
    for line in dict.fromkeys(line.strip() for _, line in err.lines):
        table.show("  said", line)
    return table.finish(args, latency_ms=settled, waits_s=waits, memory_mib=memory)


if __name__ == "__main__":
    sys.exit(main())
