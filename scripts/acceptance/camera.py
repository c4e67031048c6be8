"""A camera on loopback: an RTSP server that draws CLOCK_MONOTONIC and a slow red patch into every picture."""

import pathlib
import subprocess
from typing import Self

from conftest import skip
from process import Child, Lines, free_port, run, spawn

SERVER = pathlib.Path(__file__).with_name("timecode_server.py")
# The system's Python, which has GStreamer's bindings.
PYTHON = "/usr/bin/python3"
WIDTH, HEIGHT, FPS = 1280, 720, 30
# The patch of the server rests in the middle for some seconds, and moves at most 170 px/s then.
SELECTION = f"{WIDTH // 2 - 26},{HEIGHT // 2 - 26},52,52"


class Camera:
    def __init__(self) -> None:
        try:
            done = run([PYTHON, SERVER, "--check"])
            missing = done.stderr.strip().splitlines()[-1] if done.returncode else None
        except OSError as error:
            missing = str(error)
        if missing:
            skip(f"no RTSP server to try ({missing}): scripts/setup.sh test installs one")
        self.port = free_port()
        self.url = f"rtsp://127.0.0.1:{self.port}/video"
        self.child: Child
        self.start()

    def start(self) -> float:
        """Starts the server, and gives the time at which it began to listen."""
        command = [
            PYTHON,
            SERVER,
            "--port",
            self.port,
            "--pattern",
            "timecode",
            "--size",
            f"{WIDTH}x{HEIGHT}",
            "--fps",
            FPS,
        ]
        self.child = spawn(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        return Lines(self.child.stdout).wait_for("rtsp://")[0]

    def kill(self) -> None:
        self.child.kill()
        self.child.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()
