"""Foxglove's live view: a WebSocket client reads what is recorded, while it is recorded."""

import json
import pathlib
import re
import struct
from typing import Any

import pytest
import websocket

from client import Program
from conftest import Check
from machine import wait_until
from process import free_port, run

pytestmark = pytest.mark.apart

PROTOCOL = "foxglove.sdk.v1"
MESSAGE_DATA = 1


class LiveView:
    """A client of Foxglove's protocol (https://github.com/foxglove/ws-protocol)."""

    def __init__(self, port: int) -> None:
        self.socket = websocket.create_connection(
            f"ws://127.0.0.1:{port}", subprotocols=[PROTOCOL], timeout=20
        )
        self.channels: dict[str, dict[str, Any]] = {}

    def advertised(self, topic: str) -> dict[str, Any]:
        while topic not in self.channels:
            message = json.loads(self.socket.recv())
            for channel in message.get("channels", []):
                self.channels[channel["topic"]] = channel
        return self.channels[topic]

    def next_of(self, topic: str) -> tuple[int, bytes]:
        """The time, nanoseconds since 1970, and the content of the next message of a topic."""
        wanted = {"id": 7, "channelId": self.advertised(topic)["id"]}
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": [wanted]}))
        while True:
            message = self.socket.recv()
            if isinstance(message, bytes) and message[0] == MESSAGE_DATA:
                number, at = struct.unpack_from("<IQ", message, 1)
                if number == wanted["id"]:
                    self.socket.send(json.dumps({"op": "unsubscribe", "subscriptionIds": [7]}))
                    return at, message[13:]


def test_what_is_recorded_is_seen_live(barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check) -> None:
    port, record = free_port(), tmp_path / "run.mcap"
    program = Program(
        barrelman,
        "run",
        *("--video", "sim:arena1?size=320x180", "--link", "sim:", "--engage"),
        *("--foxglove", f"127.0.0.1:{port}", "--record", record),
    )
    check("the terminal says where", program.errors.find(re.escape(f"ws://127.0.0.1:{port}")))
    program.wait(lambda status: status["mode"]["name"] == "servoing", "the engagement")
    live = LiveView(port)
    channel = live.advertised("/video")
    check("the video has Foxglove's schema", channel["schemaName"] == "foxglove.CompressedVideo", channel)
    check("the configuration is not shown", "/recording/start" not in live.channels, list(live.channels))
    at, content = live.next_of("/video")
    check("there is video", len(content) > 100, len(content))
    later, _ = live.next_of("/outcome")
    check("the times are those of now", later > at > 1.6e18, (at, later))
    check("there are drawings", live.next_of("/video/annotations")[1])
    live.socket.close()
    check("the run ends well", program.end() == 0, program.errors.text()[-300:])
    wait_until(lambda: record.stat().st_size > 0, "the recording")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--foxglove", "0.0.0.0:8765"], "ssh -L 8765:127.0.0.1:8765"),
        (["--foxglove", "127.0.0.1:8765", "--no-record"], "cannot be used with"),
        (["--foxglove", "localhost"], "ADDRESS:PORT"),
    ],
)
def test_other_ways_are_refused(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, options: list[str], says: str
) -> None:
    record = [] if "--no-record" in options else ["--record", tmp_path / "run.mcap"]
    done = run([barrelman, "run", "--headless", "--video", "sim:arena1?size=320x180", *options, *record])
    assert done.returncode != 0
    assert says in done.stderr, done.stderr


def test_run_without_a_recording_is_refused(barrelman: pathlib.Path, tmp_path: pathlib.Path) -> None:
    config = tmp_path / "barrelman.toml"
    config.write_text("[recording]\nenabled = false\n")
    video = ("--video", "sim:arena1?size=320x180")
    done = run([barrelman, "run", "--headless", config, *video, "--foxglove", "127.0.0.1:0"])
    assert done.returncode != 0
    assert "--foxglove shows what is recorded" in done.stderr, done.stderr
