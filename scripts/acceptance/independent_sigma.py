"""A Fotokite Sigma written from its API document, which judges every request. Only the standard library.

Each request is kept with its time; what breaks a rule is a violation. Motion ends with the duration of its
command.
"""

import base64
import hashlib
import http.server
import json
import pathlib
import socketserver
import ssl
import struct
import threading
import time
from typing import Any

TOKEN = "acceptance-token"
LEAST, LARGEST = 2.0, 25.0
ALLOWED = {
    ("GET", "/v1/health"),
    ("GET", "/v1/camera/info"),
    ("GET", "/v1/camera/state"),
    ("GET", "/v1/camera/state/subscribe"),
    ("GET", "/v1/videostreams"),
    ("GET", "/v1/videostreams/zoom/state"),
    ("GET", "/v1/flight/state"),
    ("GET", "/v1/system/state"),
    ("GET", "/v1/handoff/state"),
    ("GET", "/v1/notifications/state"),
    ("POST", "/v1/handoff/control/request"),
    ("POST", "/v1/handoff/control/release"),
    ("POST", "/v1/camera/control/rotate_with_speed"),
    ("POST", "/v1/auth/plugin/update"),
}
COMMAND = "/v1/camera/control/rotate_with_speed"


class Sigma:
    """The vehicle: who controls, what turns until when, and what was asked."""

    def __init__(
        self,
        certificate: tuple[pathlib.Path, pathlib.Path] | None = None,
        token: str = TOKEN,
        websocket: bool = True,
    ) -> None:
        self.lock = threading.RLock()
        self.token, self.websocket = token, websocket
        self.requests: list[tuple[float, str, str, bytes]] = []
        self.violations: list[str] = []
        # When, the speeds, and whether the camera was moving.
        self.motions: list[tuple[float, tuple[float, float], bool]] = []
        self.ours_until = 0.0
        self.other_controls = False
        self.taken_at: float | None = None
        self.speeds, self.until = (0.0, 0.0), 0.0
        self.hangs = threading.Event()
        self.status: int | None = None
        self.sockets = 0
        self.shown = ""
        self.pan, self.tilt, self.moved_at = 10.0, 24.0, time.monotonic()
        vehicle = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            # Small answers leave at once.
            wbufsize = -1
            disable_nagle_algorithm = True

            def log_message(self, *_: object) -> None:
                pass

            def do_GET(self) -> None:
                vehicle.serve(self, "GET")

            def do_POST(self) -> None:
                vehicle.serve(self, "POST")

        class Server(socketserver.ThreadingMixIn, http.server.HTTPServer):
            daemon_threads = True
            request_queue_size = 32

            def handle_error(self, *_: object) -> None:
                pass

        self.server = Server(("127.0.0.1", 0), Handler)
        self.scheme = "http"
        if certificate:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(*certificate)
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
            self.scheme = "https"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    @property
    def url(self) -> str:
        return f"{self.scheme}://127.0.0.1:{self.server.server_address[1]}/api"

    def close(self) -> None:
        self.server.shutdown()
        self.server.server_close()

    def serve(self, handler: http.server.BaseHTTPRequestHandler, method: str) -> None:
        body = handler.rfile.read(int(handler.headers.get("Content-Length") or 0))
        if self.hangs.is_set():
            # The request is never carried out.
            while self.hangs.is_set():
                time.sleep(0.02)
            handler.close_connection = True
            return
        path = handler.path.removeprefix("/api")
        if (
            path == "/v1/camera/state/subscribe"
            and self.websocket
            and "websocket" in handler.headers.get("Upgrade", "").lower()
        ):
            self.note(method, path, body)
            if handler.headers.get("Authorization") == f"Bearer {self.token}":
                self.speak(handler)
                return
        status, answer = self.answer(method, path, handler.headers.get("Authorization"), body)
        data = b"" if answer is None else json.dumps(answer).encode()
        handler.send_response(status)
        handler.send_header("Content-Length", str(len(data)))
        handler.end_headers()
        handler.wfile.write(data)

    def note(self, method: str, path: str, body: bytes) -> None:
        with self.lock:
            self.requests.append((time.monotonic(), method, path, body))
            if (method, path) not in ALLOWED:
                self.violations.append(f"forbidden path {method} {path}")

    def violate(self, text: str) -> None:
        self.violations.append(text)

    def answer(self, method: str, path: str, authorization: str | None, body: bytes) -> tuple[int, Any]:
        now = time.monotonic()
        self.note(method, path, body)
        with self.lock:
            if path == "/v1/health":
                return 200, {"status": "OK", "api_version": "1.1.2"}
            if authorization != f"Bearer {self.token}":
                return 401, {"code": "unauthorized", "message": "the token is not known"}
            if self.status and (method == "POST") and path != "/v1/auth/plugin/update":
                return self.status, {"code": "x", "message": "refused on purpose"}
            if path == "/v1/camera/info":
                speeds = {
                    f"{axis}_speed_{end}": speed
                    for axis in ("pan", "tilt")
                    for end, speed in (("min", LEAST), ("max", LARGEST))
                }
                return 200, {
                    "model": "x",
                    **speeds,
                    "tilt_min": -11,
                    "tilt_max": 80,
                    "roll_min": -1,
                    "roll_max": 1,
                }
            if path == "/v1/camera/state":
                return 200, self.camera()
            if path == "/v1/flight/state":
                return 200, {"flight_state": "Flying", "is_rotating": False}
            if path == "/v1/system/state":
                return 200, {"kite_battery_level": 88, "gs_battery_level": 91.5}
            if path == "/v1/notifications/state":
                return 200, [
                    {
                        "severity": "Info",
                        "code": "hello",
                        "message": "x",
                        "begin_time": "2026-01-01T00:00:00Z",
                    }
                ]
            if path == "/v1/videostreams":
                return 200, [{"stream_id": "zoom", "type": "Color", "rtsp_url": "rtsp://127.0.0.1:1/zoom"}]
            if path == "/v1/videostreams/zoom/state":
                return 200, {
                    "stream_id": "zoom",
                    "is_streaming": True,
                    "fov_horizontal": 63.7,
                    "zoom_level": 1,
                }
            if path == "/v1/handoff/state":
                return 200, {
                    "controlling_client": {"plugin_id": "2", "operator_name": "the tablet"}
                    if self.other_controls
                    else None,
                    "requesting_clients": [],
                }
            if path == "/v1/auth/plugin/update":
                update = json.loads(body)
                self.shown = update["self_status_text"]
                if len(self.shown) > 160 or update["self_status"] not in (
                    "None",
                    "Connected",
                    "Warning",
                    "Error",
                ):
                    self.violate(f"plugin update {update}")
                return 204, None
            if path == "/v1/handoff/control/request":
                if not json.loads(body).get("operator_name"):
                    self.violate("no operator_name")
                if self.other_controls:
                    return 202, {}
                self.ours_until = now + 10.0
                return 201, {}
            if path == "/v1/handoff/control/release":
                self.ours_until = 0.0
                return 204, None
            if path == COMMAND:
                return self.command(json.loads(body), now)
            return 404, {"code": "not_found", "message": path}

    def command(self, body: dict[str, Any], now: float) -> tuple[int, Any]:
        pan, tilt, duration = body.get("pan_speed", 0.0), body.get("tilt_speed", 0.0), body.get("duration")
        for speed in (pan, tilt):
            if speed != 0 and not LEAST <= abs(speed) <= LARGEST:
                self.violate(f"speed {speed}")
        if duration is None or not 0.1 <= duration <= 10:
            self.violate(f"duration {duration}")
        elif duration > 0.5 and (pan or tilt):
            self.violate(f"duration {duration} is longer than half a second")
        if self.other_controls or now >= self.ours_until:
            # The first refusals tell the client that the control is gone.
            if self.taken_at is None or now - self.taken_at > 0.5:
                self.violate("a command while another client controls")
            return 403, {"code": "forbidden", "message": "another client controls"}
        self.settle(now)
        is_moving = any(self.speeds) and now < self.until
        self.motions.append((now, (pan, tilt), is_moving))
        self.speeds, self.until = (pan, tilt), now + (duration or 0.0)
        return 202, {}

    def settle(self, now: float) -> None:
        """Turns the camera by what was in force until now."""
        seconds = max(0.0, min(now, self.until) - self.moved_at)
        self.pan += self.speeds[0] * seconds
        self.tilt += self.speeds[1] * seconds
        self.moved_at = now

    def camera(self) -> dict[str, Any]:
        self.settle(time.monotonic())
        return {
            "online_state": "Online",
            "pan_ned": (self.pan + 180) % 360 - 180,
            "tilt_ned": self.tilt,
            "roll_ned": 0.0,
        }

    def is_turning(self) -> bool:
        with self.lock:
            return any(self.speeds) and time.monotonic() < self.until

    def take(self) -> None:
        with self.lock:
            self.other_controls, self.taken_at = True, time.monotonic()
            self.speeds = (0.0, 0.0)

    def give_back(self) -> None:
        with self.lock:
            self.other_controls, self.taken_at, self.ours_until = False, None, 0.0

    def commands_since(self, at: float) -> list[tuple[float, bytes]]:
        with self.lock:
            return [(when, body) for when, _, path, body in self.requests if when > at and path == COMMAND]

    def speak(self, handler: http.server.BaseHTTPRequestHandler) -> None:
        """The WebSocket of the camera's state: ten messages a second, until the client is gone."""
        key = handler.headers["Sec-WebSocket-Key"] + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
        accept = base64.b64encode(hashlib.sha1(key.encode()).digest()).decode()
        handler.close_connection = True
        upgrade = "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        handler.wfile.write(f"{upgrade}Sec-WebSocket-Accept: {accept}\r\n\r\n".encode())
        handler.wfile.flush()
        self.sockets += 1
        try:
            while True:
                if not self.hangs.is_set():
                    with self.lock:
                        data = json.dumps(self.camera()).encode()
                    head = (
                        bytes([0x81, len(data)])
                        if len(data) < 126
                        else b"\x81\x7e" + struct.pack(">H", len(data))
                    )
                    handler.wfile.write(head + data)
                    handler.wfile.flush()
                time.sleep(0.1)
        except OSError:
            pass
