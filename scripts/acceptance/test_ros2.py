"""`barrelman-ros2`: what a participant of another make (Cyclone DDS) reads, and what its calls do.

All runs in a network of its own that has loopback alone: DDS finds its participants by multicast.
"""

import itertools
import pathlib
import signal
import time
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest

from client import WORLD, EngagedRun, Program, Socket, ask
from conftest import Check
from located_gimbal import LATITUDE, LONGITUDE, LocatedGimbal, distance_m, located_run, place_of
from machine import Delay, median, poll, wait_until
from process import Child, Lines, end, free_port, run, secret, spawn, threads_of
from ros2_peer import Listener, Peer, names_call, network_of_loopback

pytestmark = [pytest.mark.apart, pytest.mark.realtime, pytest.mark.clocked]

RUN = ("run", "--no-record", "--video", WORLD, "--link", "sim:")
# A stop passes through DDS, the program's own thread, the console's server and the run loop.
STOP_LIMIT, HOPS = 0.3, 6


@pytest.fixture(scope="module", autouse=True)
def network() -> Iterator[None]:
    with network_of_loopback():
        yield


class Node:
    """A running `barrelman-ros2`, as the program is started by hand."""

    def __init__(self, barrelman: pathlib.Path, console: str, *options: Any) -> None:
        self.command = [barrelman.with_name("barrelman-ros2"), "--console", console, *options]
        self.child: Child = spawn(self.command)
        self.errors = Lines(self.child.stderr)

    def end(self) -> int:
        return end(self.child, signal.SIGINT)


@pytest.fixture
def token_file(tmp_path: pathlib.Path) -> pathlib.Path:
    return tmp_path / "token"


def node_of(program: Program, barrelman: pathlib.Path, file: pathlib.Path, token: str, *more: Any) -> Node:
    """A node that is connected to a program."""
    node = Node(
        barrelman,
        f"http://{program.host}",
        *("--token-file", secret(file, token), "--dds-address", "127.0.0.1", *more),
    )
    node.errors.wait_for("connected to the console")
    return node


def check_detections(check: Check, program: Program, peer: Peer) -> None:
    """Each box of the API comes as a detection, to the bit, with the time of its picture."""
    wait_until(lambda: peer.take("picture"), "the first picture")
    tracks, pictures = [], []
    detections = [message for _, message in peer.take("detections")]
    for _ in range(20):
        tracks.append(program.status()["track"])
        time.sleep(0.1)
        detections += [message for _, message in peer.take("detections")]
        pictures += [message for _, message in peer.take("picture")]
    tracks = [track for track in tracks if track["state"] == "tracking"]
    boxes = {}
    for message in detections:
        for found in message.detections:
            centre, box = found.bbox.center.position, found.bbox
            hypothesis = found.results[0].hypothesis
            boxes[centre.x, centre.y, box.size_x, box.size_y, hypothesis.score] = (found, hypothesis)
    shown = [
        (u + w / 2, v + h / 2, w, h, track["confidence"]) for track in tracks for u, v, w, h in [track["box"]]
    ]
    check("each box and confidence of the API is a detection", tracks and set(shown) <= boxes.keys(), shown)
    check("the object is a boat", {hypothesis.class_id for _, hypothesis in boxes.values()} == {"boat"})
    frames = {message.header.frame_id for message in [*detections, *pictures]}
    check("box and picture have one frame of reference", frames == {"barrelman/camera_optical"}, frames)
    of_both = {message.header.stamp.ns for message in detections} & {
        message.header.stamp.ns for message in pictures
    }
    check("box and picture of a video frame have one time", len(of_both) >= len(pictures) // 2 > 0, of_both)
    picture = cv2.imdecode(np.frombuffer(bytes(pictures[-1].data), np.uint8), cv2.IMREAD_COLOR)
    size = program.status()["video"]["size"]
    check("a picture is a JPEG file", picture is not None and [*picture.shape[1::-1]] == size, size)
    check("its format is said", pictures[-1].format == "jpeg", pictures[-1].format)


def check_places(check: Check, program: Program, peer: Peer) -> None:
    fixes = [message for _, message in peer.collect("marks", 4)]
    newest = {fix.header.frame_id: fix for fix in fixes}
    check("each mark is named", newest.keys() == {"barrelman/place_1", "barrelman/person_2"}, newest.keys())
    marked = program.status()["vessel"]["marks"][0]
    fix = newest["barrelman/place_1"]
    error = distance_m((fix.latitude, fix.longitude), place_of(*marked["water_m"]))
    check("the mark is where the geometry has it", error < 0.05, f"{error:.3f} m")
    variance = fix.position_covariance[0]
    check("its error is known", abs(variance**0.5 - marked["std_dev_m"]) < 0.06, variance)
    check("north and east have it alike", fix.position_covariance[4] == variance)
    boat = peer.collect("boat", 1)[-1][1]
    status = program.status()["boat"]["on_earth"]
    error = distance_m((boat.latitude, boat.longitude), (status["latitude_deg"], status["longitude_deg"]))
    check("the boat is where the API has it", error < 3, f"{error:.2f} m")
    away = distance_m((boat.latitude, boat.longitude), (LATITUDE, LONGITUDE))
    check("the boat is not where the camera is", away > 1, f"{away:.1f} m")
    check("no altitude is claimed", boat.altitude != boat.altitude, boat.altitude)


def check_diagnostics(check: Check, peer: Peer) -> None:
    came = peer.collect("diagnostics", 4)
    gaps = [(later - earlier) / 1e9 for (earlier, _), (later, _) in itertools.pairwise(came)]
    check("diagnostics come each second", all(0.7 < gap < 2.5 for gap in gaps), gaps)
    states = {status.name: status for status in came[-1][1].status}
    parts = ("console", "mode", "video", "track", "link", "alarms")
    check("each part has a state", states.keys() == {f"barrelman: {part}" for part in parts}, states.keys())
    check("the vehicle is named", states["barrelman: link"].hardware_id == "mavlink-gimbal")
    video = states["barrelman: video"]
    check("the video is up", (video.level, video.message) == (0, "up"), video)
    values = {pair.key: pair.value for pair in video.values}
    check("its rate is said", float(values["frames_per_s"]) > 1, values)


def test_topics_say_what_the_console_says(
    barrelman: pathlib.Path, token_file: pathlib.Path, check: Check
) -> None:
    gimbal = LocatedGimbal()
    program = located_run(barrelman, gimbal)
    node = node_of(program, barrelman, token_file, program.watch_token)
    peer = Peer()
    check_detections(check, program, peer)
    check_places(check, program, peer)
    check_diagnostics(check, peer)
    delays = [(at - message.header.stamp.ns) / 1e6 for at, message in peer.collect("picture", 60)]
    age = program.status()["video"]["age_ms"]
    check("a picture is as late as a picture is", all(0 < delay < 5000 for delay in delays))
    check(
        "delay from capture to the subscriber", True, f"median {median(delays):.0f} ms (pilot: {age:.0f} ms)"
    )

    before = sum(threads_of(node.child).values())
    time.sleep(3)
    share = (sum(threads_of(node.child).values()) - before) / 3
    check("the share of a core is small", share < 0.6, f"{share:.1%}")
    peer.close()

    def pictures_s() -> float:
        return threads_of(program.child).get("pictures", 0.0)

    def rests() -> bool:
        before = pictures_s()
        time.sleep(1)
        return pictures_s() == before

    check("no picture is made for nobody", pictures_s() > 0 and poll(rests, 20), threads_of(program.child))
    check("the node ends well", node.end() == 0, node.errors.text())
    # A link that is only just coming back has nothing to send the last zeros over.
    program.wait(lambda status: status["link"]["state"] == "up", "the link")
    check("the run ends well", program.end() == 0, program.errors.text()[-300:])
    gimbal.close()


def moves(message: Any) -> bool:
    return bool(message.twist.angular.y or message.twist.angular.z)


@pytest.mark.parametrize("rmw", ["rmw_fastrtps_cpp", "rmw_cyclonedds_cpp"])
def test_a_service_engages_and_a_service_stops(
    barrelman: pathlib.Path, token_file: pathlib.Path, check: Check, rmw: str
) -> None:
    program = EngagedRun(barrelman, "--link", "sim:")
    node = node_of(program, barrelman, token_file, program.token, "--rmw", rmw)
    peer = Peer("camera_rate", is_cyclone=rmw == "rmw_cyclonedds_cpp")
    holder = program.ask("GET", "/api/v1/control")[1]
    check("the seat is left to a page", b'"holder":null' in holder, holder)
    program.wait(lambda status: status["mode"]["name"] == "servoing", "the engagement")
    with Listener() as listener:
        check("a stop is confirmed", peer.call("stop") == (True, "stopped"))
        answers = [packet for packet in listener.packets() if b"stopped\0" in packet]
    writer = peer.calls["stop"][0].guid.bytes
    named = answers and all(names_call(packet, writer, 1) for packet in answers)
    check("the answer names the call", peer.is_cyclone or named, len(answers))
    check(
        "and is a stop",
        program.status()["mode"] == {"name": "stopped", "cause": "operator", "engaged": False},
    )
    check("the camera is engaged", peer.call("engage") == (True, "engaged"))
    check("and is so in the API", program.status()["mode"]["engaged"], program.status()["mode"])

    wait_until(lambda: any(moves(message) for _, message in peer.take("camera_rate")), "a camera that moves")
    command = program.wait(lambda status: any(status["command"].values()), "a rate")["command"]
    rates = [(-command["tilt"], -command["pan"])]
    seen = [
        (message.twist.angular.y, message.twist.angular.z) for _, message in peer.collect("camera_rate", 1)
    ]
    check(
        "rates are rotations to the left and downwards",
        all((a == 0 or b == 0 or (a > 0) == (b > 0)) for a, b in zip(rates[0], seen[0], strict=True)),
        (rates, seen),
    )
    began = time.monotonic()
    answer = peer.call("stop")
    check.in_time("a stop is confirmed in time", Delay.since(began, HOPS), STOP_LIMIT)
    status = program.status()
    check("a stop while the camera moves", answer == (True, "stopped"), answer)
    check("no rate is in force", status["command"] == {"pan": 0, "tilt": 0, "zoom": 0}, status["command"])
    check("the mode is that of Stop", status["mode"]["cause"] == "operator", status["mode"])
    rests = poll(lambda: [m for _, m in peer.take("camera_rate") if not moves(m)], 5)
    check("the topic says so", rests)

    page = Socket(program.host, program.token)
    program.wait(lambda _: b'"holder":null' not in program.ask("GET", "/api/v1/control")[1], "the page")
    success, reason = peer.call("engage")
    check("a page in control is not overruled", not success and "a page is in control" in reason, reason)
    check("whereas anybody stops", peer.call("stop") == (True, "stopped"))
    page.socket.close()
    peer.close()
    check("the node ends well", node.end() == 0, node.errors.text())


def test_the_watch_token_stops_and_does_not_engage(
    barrelman: pathlib.Path, token_file: pathlib.Path, check: Check
) -> None:
    program = Program(barrelman, *RUN)
    node = node_of(program, barrelman, token_file, program.watch_token)
    peer = Peer("diagnostics")
    success, reason = peer.call("engage")
    check("who watches does not engage", not success and "may only watch and stop" in reason, reason)
    check("who watches stops", peer.call("stop") == (True, "stopped"))
    check("and the run is stopped", program.status()["mode"]["cause"] == "operator")
    peer.close()
    check("the node ends well", node.end() == 0, node.errors.text())


def test_a_console_that_goes_away_is_found_again_and_a_stop_waits_for_it(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    port = free_port()
    tokens = secret(tmp_path / "tokens", "control-token-of-the-test", "watch-token-of-the-test")
    command = [barrelman, *RUN, "--listen", f"127.0.0.1:{port}", "--console-token-file", tokens]

    def is_served() -> bool:
        try:
            return ask(f"127.0.0.1:{port}", "GET", "/healthz")[0] == 200
        except OSError:
            return False

    first = spawn(command)
    errors = Lines(first.stderr)
    wait_until(is_served, lambda: errors.text())
    node = Node(barrelman, f"http://127.0.0.1:{port}", "--token-file", tokens)
    node.errors.wait_for("connected to the console")
    peer = Peer("diagnostics")
    end(first, signal.SIGKILL)
    node.errors.wait_for("no console at")
    state = wait_until(
        lambda: next((s for _, m in peer.take("diagnostics") for s in m.status if s.level == 3), None),
        "a stale state",
    )
    check("the diagnostics say it", state.name == "barrelman: console", state)
    success, reason = peer.call("engage")
    check("nothing is engaged", not success and "refused" in reason, reason)
    success, reason = peer.call("stop")
    check("a stop is not claimed", not success and "has not confirmed the stop" in reason, reason)
    success, reason = peer.call("engage")
    check("nothing is engaged before the stop", not success and "a stop is not confirmed" in reason, reason)
    second = spawn(command)
    later = Lines(second.stderr)
    wait_until(is_served, lambda: later.text())
    wait_until(lambda: node.errors.count("connected to the console") == 2, "the console again")
    check("the loss is said once", node.errors.count("no console at") == 1, node.errors.text())
    host, token = f"127.0.0.1:{port}", "watch-token-of-the-test"
    stopped = poll(lambda: b'"operator"' in ask(host, "GET", "/api/v1/status", token=token)[1], 10)
    check("the stop reaches the program that comes", stopped)
    peer.close()
    check("the node ends well", node.end() == 0, node.errors.text())


def test_https_is_for_the_authority_that_is_given(
    barrelman: pathlib.Path,
    tmp_path: pathlib.Path,
    token_file: pathlib.Path,
    certificate: tuple[pathlib.Path, pathlib.Path, str],
    check: Check,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "states"))
    program = Program(barrelman, *RUN, "--tls-on-loopback")
    authority = tmp_path / "authority.pem"
    fetched = run(["curl", "-sSk", f"https://{program.host}/authority.pem", "-o", authority])
    assert fetched.returncode == 0, fetched.stderr
    token = ("--token-file", secret(token_file, program.watch_token))
    other = Node(barrelman, f"https://{program.host}", *token, "--ca", certificate[0])
    said = other.errors.wait_for("no console at https://")[1]
    check("another authority is not believed", "certificate" in said, said)
    check("the other node ends well", other.end() == 0)
    node = Node(barrelman, f"https://{program.host}", *token, "--ca", authority)
    node.errors.wait_for("connected to the console at https://")
    peer = Peer("diagnostics")
    check("a stop passes through TLS", peer.call("stop") == (True, "stopped"))
    peer.close()
    check("the node ends well", node.end() == 0, node.errors.text())


def test_a_token_that_is_not_known_ends_the_node(
    barrelman: pathlib.Path, token_file: pathlib.Path, check: Check
) -> None:
    program = Program(barrelman, *RUN)
    node = Node(barrelman, f"http://{program.host}", "--token-file", secret(token_file, "no-such-token-here"))
    check("the node ends", node.child.wait(timeout=30) == 1)
    check("and says why", node.errors.wait_for("does not accept the token"))
    check("without the token", "no-such-token-here" not in node.errors.text())


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--console", "http://192.168.1.5:8480"], "would be readable on the network"),
        (["--console", "https://192.168.1.5:8480"], "give --ca FILE"),
        (["--console", "http://127.0.0.1:8480", "--ca", "a.pem"], "--ca is for a console over https"),
        (["--namespace", "2nd"], "is no name of ROS 2"),
        (["--token-file", "/nowhere/token"], "there is no file /nowhere/token"),
        (["--dds-address", "192.0.2.7"], "--dds-address"),
    ],
)
def test_what_cannot_work_is_refused(barrelman: pathlib.Path, options: list[str], says: str) -> None:
    done = run([barrelman.with_name("barrelman-ros2"), *options], timeout=30)
    assert done.returncode == 1
    assert says in done.stderr, done.stderr
