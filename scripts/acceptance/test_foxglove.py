"""Foxglove's live view: a WebSocket client reads what is recorded, while it is recorded."""

import http.client
import json
import pathlib
import re
import socket
import ssl
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

    def __init__(self, url: str, authority: pathlib.Path | None = None) -> None:
        tls = {"ca_certs": str(authority)} if authority else {}
        self.socket = websocket.create_connection(url, subprotocols=[PROTOCOL], timeout=20, sslopt=tls)
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
    live = LiveView(f"ws://127.0.0.1:{port}")
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


def test_other_devices_come_in_with_a_token_over_tls(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "states"))
    at, record = f"127.0.0.1:{free_port()}", tmp_path / "run.mcap"
    # As off loopback: the tests listen on loopback alone.
    options = ("--tls-on-loopback", "--foxglove", at, "--record", record)
    program = Program(barrelman, "run", "--video", "sim:arena1?size=320x180", "--link", "sim:", *options)
    program.errors.wait_for(re.escape(f"wss://{at}/?token="))
    authority = tmp_path / "authority.pem"
    unverified = ssl.create_default_context()
    unverified.check_hostname, unverified.verify_mode = False, ssl.CERT_NONE
    authority.write_bytes(fetched(program, unverified, "GET", "/authority.pem"))
    for query in ("", "?token=", "?token=wrong-0123456789", f"?other={program.token}"):
        with pytest.raises(websocket.WebSocketBadStatusException, match="401"):
            LiveView(f"wss://{at}/{query}", authority)
    with pytest.raises(websocket.WebSocketBadStatusException, match="400"):
        LiveView(f"ws://{at}/?token={program.watch_token}")
    with pytest.raises(ssl.SSLCertVerificationError):
        LiveView(f"wss://{at}/?token={program.watch_token}")
    silent = socket.create_connection(("127.0.0.1", int(at.rpartition(":")[2])))
    views = [
        LiveView(f"wss://{at}/?token={token}", authority) for token in (program.watch_token, program.token)
    ]
    for live in views:
        check("there is video", len(live.next_of("/video")[1]) > 100)
    told = program.errors.text()
    check("no token is in the log", program.watch_token not in told and program.token not in told)
    fetched(program, ssl.create_default_context(cafile=authority), "POST", "/api/v1/links")
    for live in views:
        check("the old token's view ends", ends(live))
    with pytest.raises(websocket.WebSocketBadStatusException, match="401"):
        LiveView(f"wss://{at}/?token={program.watch_token}", authority)
    silent.close()
    check("the run ends well", program.end() == 0, program.errors.text()[-300:])


def ends(live: LiveView) -> bool:
    """Whether a view ends. A timeout is no end."""
    try:
        while live.socket.recv():
            pass
    except websocket.WebSocketTimeoutException:
        return False
    except (websocket.WebSocketException, OSError):
        pass
    return True


def fetched(program: Program, context: ssl.SSLContext, method: str, path: str) -> bytes:
    connection = http.client.HTTPSConnection(program.host, timeout=15, context=context)
    connection.request(method, path, headers={"Authorization": f"Bearer {program.token}"})
    answer = connection.getresponse()
    content = answer.read()
    assert answer.status == 200, content
    return content


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--foxglove", "0.0.0.0:8765"], "leave out --headless"),
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
