"""A run against a Fotokite Sigma with code of its own (independent_sigma.py), which judges every request.

The video is a simulated world's, whose camera nothing moves: the boat leaves the region, and the camera law
asks for motion. A last test closes the loop: the emulated Sigma moves the camera of the world that the run
sees.
"""

import itertools
import json
import pathlib
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from client import ENGAGE, STOP, WORLD, EngagedRun
from conftest import Check
from independent_sigma import COMMAND, TOKEN, Sigma
from machine import NEVER, Delay, lost, wait_until
from process import ENDS_WITHIN, Lines, end, free_port, run, secret, spawn
from worlds import first_box, follow_boat

pytestmark = pytest.mark.apart

# The duration of a command, and the time of a request on a busy machine.
DURATION_LIMIT = 0.5
STOP_LIMIT = 0.15
# Processes and threads from an event to the rates in force: console or this test, the pilot, the link, the
# vehicle.
HOPS = 4


@pytest.fixture
def sigma() -> Iterator[Sigma]:
    sigma = Sigma()
    yield sigma
    sigma.close()


class Run(EngagedRun):
    """A run against a Sigma."""

    def __init__(
        self,
        barrelman: pathlib.Path,
        folder: pathlib.Path,
        sigma: Sigma | str,
        *more: Any,
        token: str = TOKEN,
        video: str | None = WORLD,
    ) -> None:
        self.sigma = sigma
        url = sigma if isinstance(sigma, str) else sigma.url
        super().__init__(barrelman, *self.link_options(url, folder, token), *more, video=video)

    @staticmethod
    def link_options(url: str, folder: pathlib.Path, token: str = TOKEN) -> list[Any]:
        return [
            "--profile",
            "fotokite-sigma",
            "--link",
            url,
            "--link-token-file",
            secret(folder / "vehicle.token", token),
        ]

    def wait_for_acceptance(self, acceptance: str) -> None:
        self.wait(lambda status: status["link"].get("acceptance") == acceptance, f"acceptance {acceptance}")

    def wait_until_it_moves(self) -> None:
        assert isinstance(self.sigma, Sigma)
        wait_until(self.sigma.is_turning, "the first motion")
        time.sleep(0.3)
        wait_until(self.sigma.is_turning, "the next motion")


def rest_after(sigma: Sigma, at: float, seconds: float = 3.0) -> Delay:
    """The time from `at` until nothing turns the camera any more, as the vehicle has it."""
    until = last = at
    while until < at + seconds:
        until = time.monotonic()
        if sigma.is_turning():
            last = until
        time.sleep(0.002)
    return Delay.between(at, last, HOPS)


def test_every_request_keeps_the_rules(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, sigma: Sigma, check: Check
) -> None:
    with Run(barrelman, tmp_path, sigma) as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.request(STOP)
        check.in_time("Stop while the camera turns: rest", rest_after(sigma, at), STOP_LIMIT)
        # What was commanded before the program read the request has that limit: motion, or a rest.
        # It may arrive late, on another connection.
        after = [json.loads(body) for _, body in sigma.commands_since(at)]
        is_motion = [bool(command["pan_speed"] or command["tilt_speed"]) for command in after]
        zeros = len(is_motion) if True not in is_motion else is_motion[::-1].index(True)
        check("Stop: explicit zeros, then nothing", 3 <= zeros <= 14, is_motion)
        time.sleep(4)
        check("the first command is a zero", not any(sigma.motions[0][1]))
        asked = [at for at, _, path, _ in sigma.requests if path.endswith("control/request")]
        check("the control is asked for again", len(asked) >= 2, f"{len(asked)} times")
        gap = max(
            (Delay.between(*pair) for pair in itertools.pairwise(asked)),
            default=NEVER,
            key=lambda gap: gap.seconds,
        )
        check.in_time("well before 10 s", gap, 5)
        check("one WebSocket tells the camera's state", sigma.sockets == 1, sigma.sockets)
        check("the tablet shows a state", bool(sigma.shown), sigma.shown)
        link = run.status()["link"]
        check(
            "tilt and control reach the console",
            link.get("in_control") is True and link.get("tilt_deg") is not None,
            link,
        )
        code = end(run.child)
        check(
            "the run ends with exit 0, and releases the control", (code, sigma.ours_until) == (0, 0.0), code
        )
        run.errors.join()
        check("no log line holds the token", TOKEN not in run.errors.text())
    check("no request breaks a rule", not sigma.violations, sorted(set(sigma.violations)))


def test_control_that_is_stolen_in_mid_motion_comes_back_by_engage(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    sigma = Sigma(websocket=False)
    with Run(barrelman, tmp_path, sigma) as run:
        run.wait_until_it_moves()
        sigma.take()
        at = time.monotonic()
        run.wait_for_acceptance("other-client")
        time.sleep(4)
        until = at + 0.5 + lost(at, at + 0.5, HOPS)
        late = [
            path
            for when, _, path, _ in sigma.requests
            if when > until and path.endswith((COMMAND, "control/request"))
        ]
        check("no command and no request is sent any more", not late, late)
        mode = run.status()["mode"]
        check("the engagement has ended", mode["cause"] == "control-lost" or "control" in str(mode), mode)
        sigma.give_back()
        time.sleep(3)
        check("control that is free again is not taken unasked", sigma.ours_until == 0.0)
        run.request(ENGAGE)
        run.wait_for_acceptance("accepted")
        check("Engage takes the free control", sigma.ours_until > 0.0)
        read = sum(path == "/v1/camera/state" for _, _, path, _ in sigma.requests)
        check("without a WebSocket the camera's state is read", read > 20, f"{read} times")
    check("no request breaks a rule", not sigma.violations, sorted(set(sigma.violations)))
    sigma.close()


def test_wrong_token_is_told_and_does_not_hammer_the_vehicle(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, sigma: Sigma, check: Check
) -> None:
    with Run(barrelman, tmp_path, sigma, token="another-token") as run:
        run.wait_for_acceptance("token-refused")
        check("no command is sent", not sigma.commands_since(0))
        time.sleep(4)
        refused = [path for _, _, path, _ in sigma.requests if path != "/v1/health"]
        check("the vehicle is not hammered", len(refused) <= 4, f"{len(refused)} requests in 4 s")


@pytest.mark.parametrize(("status", "expected"), [(409, "flight-state"), (503, "not-ready"), (502, "fault")])
def test_refusal_is_told_and_ends_the_motion(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, sigma: Sigma, status: int, expected: str
) -> None:
    with Run(barrelman, tmp_path, sigma) as run:
        run.wait_until_it_moves()
        sigma.status = status
        at = time.monotonic()
        run.wait_for_acceptance(expected)
        rest = rest_after(sigma, at, 1.5)
        sigma.status = None
        run.wait_for_acceptance("accepted")
    assert not sigma.violations
    rest.judge(DURATION_LIMIT)


def test_motion_on_a_server_that_hangs_ends_by_its_duration_and_the_link_comes_back(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, sigma: Sigma
) -> None:
    with Run(barrelman, tmp_path, sigma) as run:
        run.wait_until_it_moves()
        sigma.hangs.set()
        at = time.monotonic()
        rest = rest_after(sigma, at)
        time.sleep(2)
        sigma.hangs.clear()
        run.wait_for_acceptance("accepted")
    assert not sigma.violations
    rest.judge(DURATION_LIMIT)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=lambda number: number.name)
def test_motion_of_a_program_that_is_gone_ends_by_its_duration(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, sigma: Sigma, number: signal.Signals
) -> None:
    with Run(barrelman, tmp_path, sigma) as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.send_signal(number)
        rest = rest_after(sigma, at)
        run.child.send_signal(signal.SIGCONT)
        run.child.kill()
        run.child.wait()
    rest.judge(DURATION_LIMIT)


def test_tls_takes_the_pinned_certificate_alone(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, certificate: Any, check: Check
) -> None:
    path, key, fingerprint = certificate
    plain, wrong = fingerprint.replace(":", "").lower(), "00" * 32
    sigma = Sigma(certificate=(path, key))
    link = ["--headless", "--no-record", "--video", WORLD, *Run.link_options(sigma.url, tmp_path)]
    refused = run([barrelman, "run", *link, "--link-certificate-sha256", wrong])
    says_both = plain in refused.stderr and wrong in refused.stderr
    check(
        "a wrong pin is refused, with both fingerprints",
        refused.returncode == 1 and says_both,
        refused.stderr[-300:],
    )
    refused = run([barrelman, "run", *link])
    check(
        "a certificate that nobody has signed is refused without a pin",
        refused.returncode == 1,
        refused.returncode,
    )
    check("no request was made", not sigma.requests, len(sigma.requests))
    with Run(barrelman, tmp_path, sigma, "--link-certificate-sha256", fingerprint) as pinned:
        pinned.wait_until_it_moves()
    check("no request breaks a rule", not sigma.violations, sorted(set(sigma.violations)))
    sigma.close()


def wrong_token(sigma: Sigma) -> None:
    sigma.token = "right"


@pytest.mark.parametrize(
    ("state", "says"),
    [
        pytest.param(lambda _: None, "2 to 25", id="all is well, with the least rates"),
        pytest.param(Sigma.take, "controls", id="the control is held by another client"),
        pytest.param(wrong_token, "token", id="the token is wrong"),
        pytest.param(Sigma.close, "not usable", id="nobody is there"),
    ],
)
def test_check_says(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, state: Callable[[Sigma], None], says: str
) -> None:
    sigma = Sigma()
    url = sigma.url
    state(sigma)
    done = run([barrelman, "check", "--video", "sim:arena1", *Run.link_options(url, tmp_path)])
    assert any(says in line for line in done.stdout.splitlines()), done.stdout
    assert all(method == "GET" for _, method, _, _ in sigma.requests)


@pytest.mark.realtime
def test_emulated_sigma_keeps_the_boat_in_the_region(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    """Over RTSP, at the address that the vehicle tells."""
    port, log = free_port(), tmp_path / "emulated.jsonl"
    world = ["--world", WORLD, "--video-listen", f"127.0.0.1:{free_port()}"]
    command = [
        barrelman,
        "emulate",
        "fotokite-sigma",
        "--listen",
        f"127.0.0.1:{port}",
        *world,
        "--token",
        TOKEN,
        "--log",
        log,
    ]
    emulator = spawn(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    Lines(emulator.stdout).wait_for("answers at")
    select = first_box(barrelman, tmp_path)
    with Run(barrelman, tmp_path, f"http://127.0.0.1:{port}/api", "--select", select, video=None) as closed:
        closed.wait_for_acceptance("accepted")
        follow_boat(closed, check)
        check("video comes from the vehicle's own address", closed.status()["video"]["state"] == "up")
        check("the run ends with exit 0", end(closed.child) == 0)
    emulator.terminate()
    emulator.wait(timeout=ENDS_WITHIN)
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    turned = [row for row in rows if row.get("pan_deg_per_s") or row.get("tilt_deg_per_s")]
    check("the camera of the world was turned", len(turned) > 3, f"{len(turned)} changes of the rates")
    refused = [row for row in rows if row.get("status") in (400, 404)]
    check("the emulator refuses nothing as unusable", not refused, refused[:2])
