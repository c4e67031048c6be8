"""A run against a gimbal manager with code of its own (independent_gimbal.py), which judges every message.

The video is a simulated world's, whose camera nothing moves: the boat leaves the region, and the camera law
asks for motion. Each test causes one event. A last test closes the loop: the emulated gimbal moves the camera
of the world that the run sees, over a line that loses packets.
"""

import itertools
import json
import os
import pathlib
import signal
import subprocess
import time
from collections.abc import Iterator
from typing import Any

import pytest

from client import ENGAGE, STOP, WORLD, EngagedRun
from conftest import Check
from independent_gimbal import CLAIM, NOBODY, OTHER, OWN, UNDER_WAY, GimbalManager, judging
from machine import NEVER, Delay, lost, wait_until
from process import Lines, end, free_port, guards_of, secret, spawn
from worlds import first_box, follow_boat

pytestmark = [pytest.mark.realtime, pytest.mark.clocked]

REST_LIMIT = 0.35
# The laboratory's camera turns on for half a second; half a second of reports shows that it does not get
# slower.
TOLD_WITHIN = 1.4
# The guard looks at its pipe, and the peer at its socket.
RENEWED_WITHIN = 0.2
PASSPHRASE = "a passphrase of the test"
# The boat leaves the region after seven seconds, and stays in the picture for ten more: in WORLD it has left
# the picture by then.
LASTING_WORLD = "sim:arena2?seed=2&size=640x360"
# Processes and threads from an event to the rates in force: console or this test, the pilot, the guard, the
# gimbal.
HOPS = 4


class Run(EngagedRun):
    """A run against a gimbal manager."""

    def __init__(
        self, barrelman: pathlib.Path, manager: GimbalManager | str, *more: Any, video: str = WORLD
    ) -> None:
        self.manager = manager
        url = manager if isinstance(manager, str) else manager.url
        super().__init__(barrelman, "--profile", "mavlink-gimbal", "--link", url, *more, video=video)

    def wait_until_it_moves(self) -> None:
        assert isinstance(self.manager, GimbalManager)
        wait_until(
            self.manager.is_turning,
            lambda: f"the first motion; the run's last lines: {self.errors.text()[-600:]!r}",
        )
        time.sleep(0.3)
        wait_until(self.manager.is_turning, "the next motion")

    def wait_for_control(self, is_ours: bool) -> None:
        self.wait(lambda status: status["link"].get("in_control") is is_ours, f"control {is_ours}")

    def wait_for_alarm(self, is_raised: bool) -> None:
        self.wait(lambda status: ("camera-turns" in status["alarms"]) is is_raised, f"alarm {is_raised}")

    def guard(self) -> int:
        [guard] = guards_of(self.child.pid)
        return guard


@pytest.fixture
def manager() -> Iterator[GimbalManager]:
    """A gimbal whose every message must have kept the rules at the end."""
    with judging() as manager:
        yield manager


def rest_after(manager: GimbalManager, at: float) -> Delay:
    """The time from `at` until zeros were in force for good."""
    wait_until(lambda: not manager.is_turning(), "rest")
    time.sleep(0.6)
    sent = manager.rates_since(at)
    moving = [index for index, (_, rates) in enumerate(sent) if any(rates)]
    first = moving[-1] + 1 if moving else 0
    return Delay.between(at, sent[first][0], HOPS) if first < len(sent) else NEVER


def rests(check: Check, manager: GimbalManager, at: float, limit: float = REST_LIMIT) -> None:
    check.in_time("zeros are in force in time", rest_after(manager, at), limit)


def longest(delays: list[Delay]) -> Delay:
    return max(delays, default=NEVER, key=lambda delay: delay.seconds)


def late(times: list[float], at: float) -> list[float]:
    """What was sent later than what was under way at a moment, as seconds from that moment."""
    return [when - at for when in times if when - at > UNDER_WAY + lost(at, when, HOPS)]


def test_rates_are_sent_steadily_and_stop_ends_them(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        began = time.monotonic()
        time.sleep(4)
        sent = manager.rates_since(began)
        gaps = [
            Delay.between(earlier, later, 3)
            for (earlier, was), (later, rates) in itertools.pairwise(sent)
            if any(was) and any(rates)
        ]
        check.in_time("rates are sent steadily while moving", longest(gaps), RENEWED_WITHIN)
        moving = [when for when, rates in sent if any(rates)]
        check("and no faster than 21 times a second", len(moving) <= 21 * 4, f"{len(moving)} in 4 s")
        at = time.monotonic()
        run.request(STOP)
        rests(check, manager, at)
        time.sleep(1.5)
        zeros = [when for when, rates in manager.rates_since(at) if not any(rates)]
        check("zeros are explicit, and repeated at rest", len(zeros) >= 5, f"{len(zeros)} of them")
        check.in_time(
            "and not far apart",
            longest([Delay.between(*pair, 3) for pair in itertools.pairwise(zeros)]),
            0.35,
        )
        check("the tilt of the gimbal is on the console", run.status()["link"].get("tilt_deg") is not None)
        intervals = {message.param2 for _, message in manager.commands(511) if int(message.param1) == 285}
        check("the attitude is asked for at 20 Hz", intervals == {50_000.0}, intervals)
        code = end(run.child)
    check(
        "the run ends with exit 0, and releases the control",
        (code, manager.primary) == (0, NOBODY),
        f"{code}, {manager.primary}",
    )


def test_alarm_tells_of_commands_that_are_lost_one_way(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    """A Stop that does not arrive, while the gimbal's reports do."""
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        wait_until(lambda: max(map(abs, manager.rates)) >= 0.1, "a fast motion")
        manager.is_deaf = True
        at = time.monotonic()
        run.request(STOP)
        run.wait_for_alarm(True)
        check.in_time("the alarm is raised in time", Delay.since(at, HOPS), TOLD_WITHIN)
        time.sleep(3)
        check("the alarm lasts as long as the motion", "camera-turns" in run.status()["alarms"])
        manager.is_deaf = False
        rests(check, manager, time.monotonic())
        run.wait_for_alarm(False)


def test_sigterm_sends_zeros_several_times_and_releases_the_control(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.terminate()
        rests(check, manager, at)
        end(run.child)
        zeros = [rates for _, rates in manager.rates_since(at) if not any(rates)]
        check("zeros come several times", len(zeros) >= 10, f"{len(zeros)} zeros")
        check("then the control is released", manager.primary == NOBODY, manager.primary)


def test_guard_of_a_killed_program_sends_zeros_and_releases_the_control(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.kill()
        rests(check, manager, at)
        wait_until(lambda: manager.primary == NOBODY, "the release")


def test_gimbal_of_a_stopped_program_stays_at_rest(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.send_signal(signal.SIGSTOP)
        rests(check, manager, at)
        resting = at + REST_LIMIT + lost(at, at + REST_LIMIT, HOPS)
        time.sleep(3)
        check("the gimbal stays at rest", not any(any(rates) for _, rates in manager.rates_since(resting)))
        # The guard has released the control, and the next one may come with zeros.
        manager.may_be_turning = True


def test_guard_that_is_killed_is_followed_by_another_with_zeros_first(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        manager.may_be_turning = True
        at = time.monotonic()
        os.kill(run.guard(), signal.SIGKILL)
        zero = wait_until(
            lambda: next((when for when, rates in manager.rates_since(at) if not any(rates)), None), "zeros"
        )
        check.in_time("zeros of the next one come in time", Delay.between(at, zero, HOPS), REST_LIMIT)
        run.wait_until_it_moves()


def test_control_that_is_stolen_in_mid_motion_stays_away_until_engage(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        at = manager.take()
        run.wait_for_control(False)
        time.sleep(3)
        more = late([when for when, _ in manager.rates_since(at)], at)
        check("nothing more is sent", not more, more)
        mode = run.status()["mode"]
        check(
            "the engagement has ended, the control stays away",
            (mode["cause"], manager.primary) == ("control-lost", OTHER),
            mode,
        )
        manager.may_be_claimed = True
        run.request(ENGAGE)
        run.wait_for_control(True)
        check("Engage takes the control back", manager.primary == OWN)


def test_guard_that_follows_after_a_loss_of_control_does_not_claim_it(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        manager.take()
        run.wait_for_control(False)
        manager.give_back()
        claims, before, at = len(manager.commands(CLAIM)), run.guard(), time.monotonic()
        os.kill(before, signal.SIGKILL)
        wait_until(lambda: guards_of(run.child.pid) not in ([], [before]), "the next guard")
        time.sleep(4)
        sent = manager.rates_since(at)
        check(
            "the next guard claims nothing, and sends nothing",
            len(manager.commands(CLAIM)) == claims and not sent,
            sent,
        )
        run.request(ENGAGE)
        run.wait_until_it_moves()
        check("Engage claims the control", manager.primary == OWN)


def test_control_that_is_held_by_another_is_taken_by_engage_alone(
    barrelman: pathlib.Path, check: Check
) -> None:
    with judging(held=True) as manager, Run(barrelman, manager) as run:
        run.wait_for_control(False)
        time.sleep(3)
        check("no rate is sent, and no claim", not manager.rates_since(0) and not manager.commands(CLAIM))
        manager.may_be_claimed = True
        run.request(ENGAGE)
        run.wait_until_it_moves()
        check("Engage takes it, and the gimbal moves", manager.primary == OWN)


def test_gimbal_that_falls_silent_gets_zeros_until_the_next_engage(
    barrelman: pathlib.Path, manager: GimbalManager, check: Check
) -> None:
    with Run(barrelman, manager, video=LASTING_WORLD) as run:
        run.wait_until_it_moves()
        manager.is_silent = manager.may_be_turning = True
        at = time.monotonic()
        told = Delay.between(at, run.errors.wait_for("does not answer")[0], HOPS)
        check.in_time("silence is told in time", told, 4.5)
        rests(check, manager, at, 5.0)
        manager.is_silent = False
        run.wait_for_control(True)
        time.sleep(1)
        check("zeros are in force until the next Engage", not manager.is_turning())
        run.request(ENGAGE)
        run.wait_until_it_moves()


def test_zeros_are_in_force_where_3_of_10_packets_are_lost(barrelman: pathlib.Path, check: Check) -> None:
    with judging(loss=0.3) as manager, Run(barrelman, manager, video=LASTING_WORLD) as run:
        run.wait_until_it_moves()
        time.sleep(2)
        at = time.monotonic()
        run.child.terminate()
        # Two zeros may get lost.
        rests(check, manager, at, 0.6)
        end(run.child)


def test_gimbal_that_describes_nothing_is_found_by_its_status(barrelman: pathlib.Path) -> None:
    with judging(withholds=True, drops=2) as manager, Run(barrelman, manager) as run:
        run.wait_until_it_moves()
        assert manager.primary == OWN


def test_claim_that_is_denied_is_not_made_again(barrelman: pathlib.Path, check: Check) -> None:
    with judging(denies=True) as manager, Run(barrelman, manager) as run:
        run.wait_for_control(False)
        at = wait_until(lambda: manager.denied_at, "the first denial")
        time.sleep(3)
        # A claim may be repeated until its answer is there.
        more = late([when for when, _ in manager.commands(CLAIM)], at)
        check("it is not asked again", not more, more)
        check("no rate is sent", not manager.rates_since(0))


def test_every_packet_is_signed_with_the_key(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    key = secret(tmp_path / "signing-key", PASSPHRASE)
    with (
        judging(passphrase=PASSPHRASE) as manager,
        Run(barrelman, manager, "--link-signing-key-file", key) as run,
    ):
        run.wait_until_it_moves()
        check("every packet is signed", all(message.get_signed() for _, message in manager.messages))
        check("no log line holds the key", PASSPHRASE not in run.errors.text())


def test_another_key_is_told_and_nothing_is_read(barrelman: pathlib.Path, tmp_path: pathlib.Path) -> None:
    key = secret(tmp_path / "another-key", "another passphrase")
    with (
        judging(passphrase=PASSPHRASE) as manager,
        Run(barrelman, manager, "--link-signing-key-file", key) as run,
    ):
        run.errors.wait_for("signing key")
        assert manager.primary == NOBODY
        # Packets with another key are faults, here.
        manager.is_over = True
        manager.thread.join()
        manager.faults.clear()


def test_emulated_gimbal_keeps_the_boat_in_the_region(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    """On a line that loses one packet of ten."""
    video, log = free_port(), tmp_path / "emulated.jsonl"
    world = ["--world", WORLD, "--video-listen", f"127.0.0.1:{video}", "--loss", "10"]
    emulator = spawn(
        [barrelman, "emulate", "gimbal", "--listen", "udp://127.0.0.1:0", *world, "--log", log],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    _, line = Lines(emulator.stdout).wait_for("answers at")
    select = first_box(barrelman, tmp_path)
    with Run(
        barrelman,
        line.split("answers at ")[1].strip(),
        "--select",
        select,
        video=f"rtsp://127.0.0.1:{video}/world",
    ) as closed:
        closed.wait_for_control(True)
        follow_boat(closed, check)
        check("the run ends with exit 0", end(closed.child) == 0)
    end(emulator)
    states = [json.loads(row)["state"] for row in log.read_text().splitlines()]
    turned = sum(1 for state in states if state["yaw_rate"] or state["pitch_rate"])
    check("the camera was turned", turned > 20, f"{turned} rows in motion of {len(states)}")
    check("and rests at the end", not states[-1]["yaw_rate"] and not states[-1]["pitch_rate"], states[-1])
