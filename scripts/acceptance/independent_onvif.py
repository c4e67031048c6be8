"""An ONVIF camera that judges every message: its body is read by zeep with ONVIF's own WSDL, its proof of who
asks is computed anew. What breaks a rule is a violation. Motion ends with the time-out of its command.
"""

import base64
import contextlib
import datetime
import hashlib
import http.server
import pathlib
import re
import socketserver
import sysconfig
import threading
import time
from typing import Any, Self

import zeep
from lxml import etree

USER, PASSWORD = "operator", "pass:w&rd"
PROFILE, CONFIGURATION = "main-profile", "ptz-configuration"
SOAP = "http://www.w3.org/2003/05/soap-envelope"
WSSE = "http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-wssecurity-secext-1.0.xsd"
WSU = "http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-wssecurity-utility-1.0.xsd"
DEVICE = "http://www.onvif.org/ver10/device/wsdl"
MEDIA = "http://www.onvif.org/ver10/media/wsdl"
PTZ = "http://www.onvif.org/ver20/ptz/wsdl"
WSDL_FILES = {DEVICE: "devicemgmt.wsdl", MEDIA: "media.wsdl", PTZ: "ptz.wsdl"}
PATHS = {DEVICE: "/onvif/device_service", MEDIA: "/Media", PTZ: "/ptz?service=1"}
SPACE = "http://www.onvif.org/ver10/tptz/PanTiltSpaces"
# What the camera's clock is behind by, seconds: three years.
BEHIND_S = 94_608_000
REALM, NONCE = "camera", "a1b2c3d4"


def wsdl_folder() -> pathlib.Path:
    """ONVIF's WSDL files, as the package onvif-zeep installs them."""
    places = [pathlib.Path(sysconfig.get_path("purelib")), pathlib.Path(sysconfig.get_path("data"))]
    return next(found for place in places for found in [place / "wsdl"] if (found / "ptz.wsdl").exists())


def schemas() -> dict[str, Any]:
    folder = wsdl_folder()
    return {space: zeep.Client(str(folder / name)).wsdl.types for space, name in WSDL_FILES.items()}


class NoProfileError(Exception):
    """A profile that the camera had before."""


class Camera:
    """The camera: what turns it until when, and what was asked."""

    def __init__(self, http_digest: bool = False) -> None:
        self.lock = threading.RLock()
        self.http_digest = http_digest
        self.schemas = schemas()
        self.violations: list[str] = []
        self.requests: list[tuple[float, str]] = []
        self.motions: list[tuple[float, tuple[float, float], float]] = []
        self.velocity, self.until = (0.0, 0.0), 0.0
        self.nonces: set[str] = set()
        self.refuses_login = self.ignores_stops = False
        self.profile, self.source = PROFILE, "source-1"
        self.hangs = threading.Event()
        handler = type("Handler", (Handler,), {"camera": self})
        self.server = Server(("127.0.0.1", 0), handler)
        self.port = self.server.server_address[1]
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    @property
    def url(self) -> str:
        return f"onvif://127.0.0.1:{self.port}"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.hangs.clear()
        self.server.shutdown()
        self.server.server_close()

    def is_turning(self) -> bool:
        with self.lock:
            return self.velocity != (0.0, 0.0) and time.monotonic() < self.until

    def clock(self) -> datetime.datetime:
        return datetime.datetime.now(datetime.UTC) - datetime.timedelta(seconds=BEHIND_S)

    def answer(self, path: str, message: bytes, is_proved: bool) -> tuple[int, str]:
        envelope = etree.fromstring(message)
        body = envelope.find(f"{{{SOAP}}}Body")
        asked = body[0] if body is not None and len(body) == 1 else None
        if asked is None:
            return self.violated("not one question in the body")
        name = etree.QName(asked)
        with self.lock:
            self.requests.append((time.monotonic(), name.localname))
        if PATHS.get(name.namespace) != path:
            return self.violated(f"{name.localname} at {path}")
        try:
            question = (
                self.schemas[name.namespace].get_element(name).parse(asked, self.schemas[name.namespace])
            )
        except Exception as error:
            return self.violated(f"{name.localname} is not of the schema: {error}")
        if name.localname != "GetSystemDateAndTime" and not self.admits(envelope, is_proved):
            return fault("ter:NotAuthorized")
        try:
            reply: str | None = getattr(self, handler_of(name.localname), lambda _: None)(question)
        except NoProfileError:
            return fault("ter:NoProfile")
        return (
            self.violated(f"{name.localname} is not asked by a client that only watches and turns")
            if (reply is None)
            else (200, envelope_of(reply))
        )

    def violated(self, what: str) -> tuple[int, str]:
        with self.lock:
            self.violations.append(what)
        return fault("ter:InvalidArgVal")

    def admits(self, envelope: Any, is_proved: bool) -> bool:
        if self.refuses_login:
            return False
        if self.http_digest:
            return is_proved
        token = envelope.find(f"{{{SOAP}}}Header/{{{WSSE}}}Security/{{{WSSE}}}UsernameToken")
        if token is None:
            return False
        created, nonce = token.findtext(f"{{{WSU}}}Created"), token.findtext(f"{{{WSSE}}}Nonce")
        raw = base64.b64decode(nonce) + created.encode() + PASSWORD.encode()
        expected = base64.b64encode(hashlib.sha1(raw).digest()).decode()
        age = abs((self.clock() - datetime.datetime.fromisoformat(created)).total_seconds())
        with self.lock:
            if nonce in self.nonces:
                self.violations.append("a nonce is used twice")
            self.nonces.add(nonce)
        return (
            token.findtext(f"{{{WSSE}}}Username") == USER
            and token.findtext(f"{{{WSSE}}}Password") == expected
            and age < 5
        )

    def on_get_system_date_and_time(self, _: Any) -> str:
        now = self.clock()
        return (
            f'<d:GetSystemDateAndTimeResponse xmlns:d="{DEVICE}"><d:SystemDateAndTime>'
            f"<t:DateTimeType>NTP</t:DateTimeType><t:DaylightSavings>true</t:DaylightSavings>"
            f"<t:UTCDateTime><t:Time><t:Hour>{now.hour}</t:Hour><t:Minute>{now.minute}</t:Minute>"
            f"<t:Second>{now.second}</t:Second></t:Time><t:Date><t:Year>{now.year}</t:Year>"
            f"<t:Month>{now.month}</t:Month><t:Day>{now.day}</t:Day></t:Date></t:UTCDateTime>"
            f"</d:SystemDateAndTime></d:GetSystemDateAndTimeResponse>"
        )

    def on_get_services(self, _: Any) -> str:
        # Another host than the camera's, as behind a router.
        listed = "".join(
            f"<d:Service><d:Namespace>{space}</d:Namespace><d:XAddr>http://192.0.2.1:81{path}</d:XAddr>"
            f"<d:Version><t:Major>2</t:Major><t:Minor>6</t:Minor></d:Version></d:Service>"
            for space, path in PATHS.items()
        )
        return f'<d:GetServicesResponse xmlns:d="{DEVICE}">{listed}</d:GetServicesResponse>'

    def on_get_profiles(self, _: Any) -> str:
        return (
            f'<m:GetProfilesResponse xmlns:m="{MEDIA}">'
            f'<m:Profiles token="fixed"><t:Name>a</t:Name></m:Profiles>'
            f'<m:Profiles token="{self.profile}"><t:Name>b</t:Name><t:VideoSourceConfiguration token="v">'
            f"<t:Name>d</t:Name><t:UseCount>1</t:UseCount><t:SourceToken>{self.source}</t:SourceToken>"
            f'<t:Bounds x="0" y="0" width="1" height="1"/></t:VideoSourceConfiguration>'
            f'<t:PTZConfiguration token="{CONFIGURATION}">'
            f"<t:Name>c</t:Name><t:UseCount>1</t:UseCount><t:NodeToken>n</t:NodeToken></t:PTZConfiguration>"
            f"</m:Profiles></m:GetProfilesResponse>"
        )

    def on_get_configuration_options(self, question: Any) -> str:
        self.expect(question.ConfigurationToken == CONFIGURATION, f"the configuration {question}")
        ends = "<t:Min>-1</t:Min><t:Max>1</t:Max>"
        return (
            f'<p:GetConfigurationOptionsResponse xmlns:p="{PTZ}"><p:PTZConfigurationOptions><t:Spaces>'
            f"<t:ContinuousPanTiltVelocitySpace><t:URI>{SPACE}/VelocityGenericSpace</t:URI>"
            f"<t:XRange>{ends}</t:XRange><t:YRange>{ends}</t:YRange></t:ContinuousPanTiltVelocitySpace>"
            f"</t:Spaces><t:PTZTimeout><t:Min>PT1S</t:Min><t:Max>P0Y0M0DT0H1M0.000S</t:Max></t:PTZTimeout>"
            f"</p:PTZConfigurationOptions></p:GetConfigurationOptionsResponse>"
        )

    def on_get_status(self, question: Any) -> str:
        self.expect_profile(question.ProfileToken)
        moving = "MOVING" if self.is_turning() else "IDLE"
        return (
            f'<p:GetStatusResponse xmlns:p="{PTZ}"><p:PTZStatus><t:MoveStatus><t:PanTilt>{moving}</t:PanTilt>'
            f"</t:MoveStatus><t:UtcTime>2020-01-01T00:00:00Z</t:UtcTime></p:PTZStatus></p:GetStatusResponse>"
        )

    def on_continuous_move(self, question: Any) -> str:
        self.expect_profile(question.ProfileToken)
        vector, timeout = question.Velocity.PanTilt, question.Timeout
        self.expect(max(abs(vector.x), abs(vector.y)) <= 1, f"the velocity {vector.x}, {vector.y}")
        self.expect(timeout is not None and 1 <= timeout.total_seconds() <= 60, f"the time-out {timeout}")
        now = time.monotonic()
        with self.lock:
            self.velocity, self.until = (vector.x, vector.y), now + timeout.total_seconds()
            self.motions.append((now, self.velocity, timeout.total_seconds()))
        return f'<p:ContinuousMoveResponse xmlns:p="{PTZ}"/>'

    def on_stop(self, question: Any) -> str:
        self.expect_profile(question.ProfileToken)
        self.expect(question.PanTilt is True, "a Stop of something else")
        if not self.ignores_stops:
            with self.lock:
                self.velocity = (0.0, 0.0)
        return f'<p:StopResponse xmlns:p="{PTZ}"/>'

    def expect_profile(self, token: str) -> None:
        self.expect(token in (PROFILE, self.profile), f"the profile {token}")
        if token != self.profile:
            raise NoProfileError

    def expect(self, holds: bool, what: str) -> None:
        if not holds:
            self.violated(what)


def handler_of(question: str) -> str:
    """The name of the method that answers: GetStatus, on_get_status."""
    return "on" + re.sub("[A-Z]", lambda letter: f"_{letter[0].lower()}", question)


def envelope_of(body: str) -> str:
    return (
        f'<e:Envelope xmlns:e="{SOAP}" xmlns:t="http://www.onvif.org/ver10/schema"><e:Body>{body}</e:Body>'
        f"</e:Envelope>"
    )


def fault(subcode: str) -> tuple[int, str]:
    return 400, envelope_of(
        f'<e:Fault xmlns:ter="http://www.onvif.org/ver10/error"><e:Code><e:Value>e:Sender</e:Value><e:Subcode>'
        f"<e:Value>{subcode}</e:Value></e:Subcode></e:Code><e:Reason>"
        f'<e:Text xml:lang="en">no</e:Text></e:Reason></e:Fault>'
    )


class Handler(http.server.BaseHTTPRequestHandler):
    camera: Camera
    protocol_version = "HTTP/1.1"
    # Headers and body are two writes: without this, the second one waits for the first one's receipt.
    disable_nagle_algorithm = True

    def do_POST(self) -> None:
        while self.camera.hangs.is_set():
            time.sleep(0.02)
        message = self.rfile.read(int(self.headers["Content-Length"]))
        if not self.headers["Content-Type"].startswith("application/soap+xml"):
            self.camera.violated(f"the type {self.headers['Content-Type']}")
        is_proved = self.is_proved()
        if self.camera.http_digest and not is_proved and b"GetSystemDateAndTime" not in message:
            self.reply(401, "", ("WWW-Authenticate", f'Digest realm="{REALM}", nonce="{NONCE}", qop="auth"'))
            return
        status, text = self.camera.answer(self.path, message, is_proved)
        self.reply(status, text)

    def is_proved(self) -> bool:
        """Whether the header proves the login (RFC 7616, MD5)."""
        given = dict(re.findall(r'(\w+)="?([^",]*)"?', self.headers.get("Authorization", "")))

        def md5(*parts: str) -> str:
            return hashlib.md5(":".join(parts).encode()).hexdigest()

        expected = md5(
            md5(USER, REALM, PASSWORD),
            NONCE,
            given.get("nc", ""),
            given.get("cnonce", ""),
            "auth",
            md5("POST", self.path),
        )
        return given.get("response") == expected and given.get("uri") == self.path

    def reply(self, status: int, text: str, *more: tuple[str, str]) -> None:
        content = text.encode()
        self.send_response(status)
        for name, value in (("Content-Length", str(len(content))), *more):
            self.send_header(name, value)
        self.end_headers()
        # The client has gone.
        with contextlib.suppress(BrokenPipeError):
            self.wfile.write(content)

    def log_message(self, *_: Any) -> None:
        pass


class Server(socketserver.ThreadingMixIn, http.server.HTTPServer):
    daemon_threads = True
