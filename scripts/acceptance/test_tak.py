"""Events for TAK: a receiver on loopback reads them by takproto, which is of others' making.

The vehicle is a gimbal with code of its own (independent_gimbal.py), which reports where it is. The video is
a simulated world's, whose boat takes no commands here.
"""

import contextlib
import itertools
import json
import math
import pathlib
import select
import socket
import ssl
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
import takproto

from authority import Authority
from client import Program
from conftest import Check
from independent_gimbal import GimbalManager
from located_gimbal import LATITUDE, LONGITUDE, WORLD, LocatedGimbal, distance_m, located_run, place_of
from machine import PATIENCE_S, wait_until
from process import run, threads_of

pytestmark = pytest.mark.apart

UNKNOWN = 9999999.0
CALLSIGN = "R&D <1> \"two\" 'ü'"


@pytest.fixture
def gimbal() -> Iterator[LocatedGimbal]:
    gimbal = LocatedGimbal()
    yield gimbal
    gimbal.close()


def away_m(event: Any, place: tuple[float, float]) -> float:
    return distance_m((event.lat, event.lon), place)


def started(
    barrelman: pathlib.Path, folder: pathlib.Path, gimbal: GimbalManager, *options: str, keys: str = ""
) -> Program:
    """A run that follows the boat, and has a place and a person marked."""
    config = folder / "barrelman.toml"
    config.write_text(f"[tak]\ncallsign = {json.dumps(CALLSIGN)}\n{keys}", encoding="utf-8")
    return located_run(barrelman, gimbal, config, *options)


class Display:
    """A display on loopback."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(20)

    @property
    def url(self) -> str:
        return f"udp://127.0.0.1:{self.socket.getsockname()[1]}"

    def events(self, count: int) -> dict[str, list[Any]]:
        """At least so many events of each of the four subjects, by the last part of their uids."""
        found: dict[str, list[Any]] = {}
        deadline = time.monotonic() + PATIENCE_S
        while len(found) < 4 or min(map(len, found.values())) < count:
            assert time.monotonic() < deadline, {name: len(events) for name, events in found.items()}
            event = takproto.parse_proto(bytearray(self.socket.recv(65_536))).cotEvent
            found.setdefault(event.uid.split("-", 2)[2], []).append(event)
        return found

    def boat_error_m(self, program: Program) -> float:
        """How far the boat of an event is from where distance and direction in the API had it then."""
        deadline = time.monotonic() + PATIENCE_S
        places: list[tuple[float, tuple[float, float]]] = []
        while True:
            assert time.monotonic() < deadline, "no event of the boat"
            while not select.select([self.socket], [], [], 0.02)[0]:
                boat = program.status()["boat"]
                if boat and boat["on_earth"]:
                    direction = math.radians(boat["direction_deg"])
                    distance = boat["distance_m"]
                    place = place_of(distance * math.sin(direction), distance * math.cos(direction))
                    places.append((time.time() * 1e3, place))
            event = takproto.parse_proto(bytearray(self.socket.recv(65_536))).cotEvent
            errors = [away_m(event, place) for at, place in places if abs(at - event.startTime) < 150]
            if event.uid.endswith("-boat") and errors:
                return min(errors)


def test_a_display_is_told_where_boat_camera_and_marks_are(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, gimbal: LocatedGimbal, check: Check
) -> None:
    display = Display()
    program = started(barrelman, tmp_path, gimbal, "--tak", display.url)
    found = display.events(3)
    newest = {name: events[-1] for name, events in found.items()}
    camera, boat, place, person = (newest[name] for name in ("camera", "boat", "mark-1", "mark-2"))
    kinds = {name: event.type for name, event in newest.items()}
    wanted = {"camera": "a-f-A-M-H-Q", "boat": "a-f-S-C-U", "mark-1": "b-m-p-s-m", "mark-2": "b-m-p-s-m"}
    check("each subject has its type", kinds == wanted, kinds)
    uids = {event.uid.split("-")[1] for events in found.values() for event in events}
    check("all uids are of one run", len(uids) == 1, uids)
    names = {name: event.detail.contact.callsign for name, event in newest.items()}
    check("the callsign arrives as it is", names["boat"] == f"{CALLSIGN} boat", names)
    check("a mark is named", names["mark-2"] == f"{CALLSIGN} person 2", names)

    status = program.status()
    check("the camera is where it says", away_m(camera, (LATITUDE, LONGITUDE)) < 0.02, camera)
    marked = status["vessel"]["marks"][0]
    error = away_m(place, place_of(*marked["water_m"]))
    check("the place is where the geometry has it", error < 0.05, f"{error:.3f} m")
    check("its error is known", abs(place.ce - marked["std_dev_m"]) < 0.06, place.ce)
    error = display.boat_error_m(program)
    check("the boat is at the distance and in the direction that the API has", error < 1, f"{error:.2f} m")
    check("the boat's error is known", 0 < boat.ce < 50, boat.ce)
    unknown = [camera.ce, camera.hae, boat.hae, boat.le, place.hae, person.le]
    check("what is not known is said", unknown == [UNKNOWN] * 6, unknown)
    check("the source is said", "mavlink-gimbal" in boat.detail.xmlDetail, boat.detail.xmlDetail)

    now = time.time() * 1e3
    for name, event in newest.items():
        check(f"{name}: the time is that of the machine", abs(event.sendTime - now) < 10_000, event.sendTime)
        check(f"{name}: it goes stale", event.staleTime - event.startTime == 6000, event)
        check(f"{name}: it was known before it was sent", 0 <= event.sendTime - event.startTime < 3000, event)
    sent = [event.sendTime for event in found["camera"]]
    gaps = [later - earlier for earlier, later in itertools.pairwise(sent)]
    check("an event comes about each second", all(900 < gap < 2500 for gap in gaps), gaps)
    check("there is a thread of its own", "tak" in threads_of(program.child))
    check("the run ends well", program.end() == 0, program.errors.text()[-300:])


def test_a_server_gets_a_stream_and_is_found_again(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, gimbal: LocatedGimbal, check: Check
) -> None:
    server = socket.create_server(("127.0.0.1", 0))
    server.settimeout(20)
    program = started(barrelman, tmp_path, gimbal, "--tak", f"tcp://127.0.0.1:{server.getsockname()[1]}")
    for attempt in ("first", "second"):
        connection, _ = server.accept()
        connection.settimeout(20)
        received = b""
        while received.count(b"</event>") < 8:
            part = connection.recv(65_536)
            assert part, "the connection was closed"
            received += part
        events = [part + b"</event>" for part in received.split(b"</event>")[:8]]
        uids = {takproto.parse_proto(bytearray(event)).cotEvent.uid.split("-", 2)[2] for event in events}
        check(f"the {attempt} connection has all events", {"boat", "camera"} <= uids, uids)
        connection.close()
    wait_until(lambda: program.errors.find("events are sent again"), "the end of the failure in the log")
    check("the failure is told", program.errors.find("--tak tcp://.*events lost so far"))
    check("the run ends well", program.end() == 0, program.errors.text()[-300:])


def tls_keys(authority: Authority, client: Authority) -> str:
    """The keys of the section [tak]: whom to trust, and the own certificate."""
    certificate, key = client.issue("client.example")
    paths = {"ca_file": authority.path, "client_certificate": certificate, "client_key": key}
    return "".join(f"{name} = {json.dumps(str(path))}\n" for name, path in paths.items())


@pytest.fixture
def authorities(tmp_path: pathlib.Path) -> tuple[Authority, Authority]:
    return Authority(tmp_path / "own"), Authority(tmp_path / "foreign")


def test_an_encrypted_server_gets_events_if_it_is_the_right_one(
    barrelman: pathlib.Path,
    tmp_path: pathlib.Path,
    gimbal: LocatedGimbal,
    authorities: tuple[Authority, Authority],
    check: Check,
) -> None:
    own, foreign = authorities
    listener = socket.create_server(("127.0.0.1", 0))
    contexts = [foreign.server("127.0.0.1"), own.server("tak.example"), own.server("127.0.0.1")]
    alerts, received = [], bytearray()

    def serve() -> None:
        while contexts:
            accepted, _ = listener.accept()
            accepted.settimeout(20)
            try:
                with contexts[0].wrap_socket(accepted, server_side=True) as server:
                    server.sendall(b"<event>of somebody else</event>" * 1000)
                    while received.count(b"</event>") < 8:
                        received.extend(server.recv(65_536))
                    contexts.clear()
            except ssl.SSLError as error:
                alerts.append(error.reason)
                contexts.pop(0)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    url = f"tls://127.0.0.1:{listener.getsockname()[1]}"
    program = started(barrelman, tmp_path, gimbal, "--tak", url, keys=tls_keys(own, own))
    wait_until(lambda: not thread.is_alive(), lambda: f"the events ({program.errors.text()[-600:]})")
    refused = ["TLSV1_ALERT_UNKNOWN_CA", "SSLV3_ALERT_BAD_CERTIFICATE"]
    check("a foreign authority and a wrong name are refused", alerts == refused, alerts)
    uids = {
        takproto.parse_proto(bytearray(part + b"</event>")).cotEvent.uid.split("-", 2)[2]
        for part in received.split(b"</event>")[:8]
    }
    check("the right one has all events", {"boat", "camera"} <= uids, uids)
    told = program.errors.text()
    check("the foreign authority is told", "UnknownIssuer" in told, told[-600:])
    check("the wrong name is told", "not valid for name" in told, told[-600:])
    check("the run ends well", program.end() == 0, program.errors.text()[-300:])


@pytest.mark.parametrize(
    ("trusted", "shown", "name", "says"),
    [
        ("own", "own", "127.0.0.1", "encrypted; its certificate is accepted"),
        ("foreign", "own", "127.0.0.1", "UnknownIssuer"),
        ("own", "own", "tak.example", "not valid for name"),
        ("own", "foreign", "127.0.0.1", "received fatal alert"),
    ],
    ids=["right", "foreign authority", "wrong name", "foreign client"],
)
def test_check_says_whether_an_encrypted_server_is_the_right_one(
    barrelman: pathlib.Path,
    tmp_path: pathlib.Path,
    authorities: tuple[Authority, Authority],
    trusted: str,
    shown: str,
    name: str,
    says: str,
) -> None:
    by_name = {authority.folder.name: authority for authority in authorities}
    context = by_name["own"].server(name)
    listener = socket.create_server(("127.0.0.1", 0))
    url = f"tls://127.0.0.1:{listener.getsockname()[1]}"
    config = tmp_path / "barrelman.toml"
    config.write_text(f'[tak]\naddress = "{url}"\n' + tls_keys(by_name[trusted], by_name[shown]))

    def serve() -> None:
        with contextlib.suppress(OSError):
            accepted, _ = listener.accept()
            with context.wrap_socket(accepted, server_side=True) as server:
                server.recv(1)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    found = checked(barrelman, url, config)
    thread.join(timeout=10)
    assert says in found["details"], found
    assert (found["verdict"] == "ok") == says.startswith("encrypted"), found


@pytest.mark.parametrize(
    ("address", "keys", "says"),
    [
        ("tcp://127.0.0.1:8087", 'ca_file = "a.pem"', "are about tls://"),
        ("tls://127.0.0.1:8089", 'client_key = "a.key"', "belong together"),
        ("tls://127.0.0.1:8089", 'ca_file = "missing.pem"', "missing.pem"),
    ],
)
def test_unusable_keys_of_tls_are_refused(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, address: str, keys: str, says: str
) -> None:
    config = tmp_path / "barrelman.toml"
    config.write_text(f'[tak]\naddress = "{address}"\n{keys}\n')
    done = run([barrelman, "run", config, "--headless", "--no-record", "--video", WORLD])
    assert done.returncode != 0
    assert says in done.stderr, done.stderr


def test_without_the_option_nothing_is_sent(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, gimbal: LocatedGimbal, check: Check
) -> None:
    program = started(barrelman, tmp_path, gimbal)
    check("there is no thread", "tak" not in threads_of(program.child), threads_of(program.child))
    check("the run ends well", program.end() == 0, program.errors.text()[-300:])


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("239.2.3.1:6969", "udp://HOST:PORT"),
        ("ssl://127.0.0.1:8089", "write tls://"),
        ("udp://127.0.0.1", "names no host and port"),
        ("tcp://127.0.0.1:99999", "from 1 to 65535"),
        ("tcp://tak.invalid:8087", "give its IP address"),
    ],
)
def test_other_addresses_are_refused(barrelman: pathlib.Path, address: str, says: str) -> None:
    done = run([barrelman, "run", "--headless", "--no-record", "--video", WORLD, "--tak", address])
    assert done.returncode != 0
    assert says in done.stderr, done.stderr
    assert "--tak, or tak.address" in done.stderr, done.stderr


def checked(barrelman: pathlib.Path, address: str, *config: pathlib.Path) -> Any:
    done = run([barrelman, "check", *config, "--json", "--video", WORLD, "--tak", address])
    return next(result for result in json.loads(done.stdout) if result["what"] == f"tak {address}")


def test_check_says_whether_events_can_be_sent(barrelman: pathlib.Path, check: Check) -> None:
    display, server = Display(), socket.create_server(("127.0.0.1", 0))
    found = checked(barrelman, display.url)
    check("there is a way to a display", found["verdict"] == "ok" and "127.0.0.1" in found["details"], found)
    display.socket.setblocking(False)
    with pytest.raises(BlockingIOError):
        display.socket.recv(65_536)
    address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
    check("a server takes a connection", checked(barrelman, address)["verdict"] == "ok")
    found = checked(barrelman, "tcp://127.0.0.1:1")
    check("nobody takes one there", found["verdict"] == "failed" and "refused" in found["details"], found)
