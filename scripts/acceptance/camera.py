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
    """`way`: "tcp" and "udp" for an RTSP server, "rtp" and "ts" for packets that are sent to `url`."""

    def __init__(self, way: str = "tcp", codec: str = "h264") -> None:
        try:
            done = run([PYTHON, SERVER, "--check"])
            missing = done.stderr.strip().splitlines()[-1] if done.returncode else None
        except OSError as error:
            missing = str(error)
        if missing:
            skip(f"no RTSP server to try ({missing}): scripts/setup.sh test installs one")
        self.port = free_port()
        is_server = way in ("tcp", "udp")
        self.url = f"rtsp://127.0.0.1:{self.port}/video" if is_server else f"udp://127.0.0.1:{self.port}"
        self.options = [*(["--transport", way] if is_server else ["--send", way]), "--codec", codec]
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
            *self.options,
        ]
        self.child = spawn(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        return Lines(self.child.stdout).wait_for("://")[0]

    def kill(self) -> None:
        self.child.kill()
        self.child.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()
