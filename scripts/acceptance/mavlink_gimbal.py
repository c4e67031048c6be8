"""Tests a run against a gimbal manager of another's writing (independent_gimbal.py), which judges every message.

The video is a simulated world's, whose camera nothing moves: the boat leaves the region, and the camera law asks for motion.
Each case causes one event. A last case closes the loop: the emulated gimbal moves the camera of the world that the run sees,
over a line that loses packets.
"""
import concurrent.futures
import csv
import itertools
import json
import math
import os
import signal
import subprocess
import sys
import time

import common
import live
from common import Lines, Table
from console_run import WORLD, ConsoleRun
from guard import children
from independent_gimbal import NOBODY, OTHER, OWN, GimbalManager, UNDER_WAY

MOVES_WITHIN = 25.0
REST_LIMIT = 0.35
# The laboratory's camera turns on for half a second; half a second of reports shows that it does not get slower.
TOLD_WITHIN = 1.4
# The guard looks at its pipe, and the peer at its socket.
RENEWED_WITHIN = 0.2
LINK_UP_WITHIN = 15.0
PASSPHRASE = "a passphrase of the test"
# The boat leaves the region after seven seconds, and stays in the picture for ten more: in WORLD it has left the picture by then.
LASTING_WORLD = "sim:arena2?seed=2&size=640x360"


class Run(ConsoleRun):
    """A run against a gimbal manager."""

    def __init__(self, args, folder, manager, name, *more, video=WORLD):
        self.manager = manager
        url = getattr(manager, "url", manager)
        super().__init__(args, folder, name, "--profile", "mavlink-gimbal", "--link", url, *more, video=video)

    def wait_until_it_moves(self):
        try:
            common.wait_until(self.manager.is_turning, MOVES_WITHIN, "the first motion")
            time.sleep(0.3)
            common.wait_until(self.manager.is_turning, MOVES_WITHIN, "the next motion")
        except TimeoutError as error:
            raise TimeoutError(f"{error}; the run's last lines: {self.err.text()[-600:]!r}") from error

    def wait_for_control(self, is_ours):
        return common.wait_until(lambda: self.link().get("in_control") is is_ours, LINK_UP_WITHIN, f"control {is_ours}")

    def guards(self):
        return [pid for pid, name in children(self.child.pid).items() if name.startswith("barrelman-guard")]

    def guard(self):
        return next(iter(self.guards()))


def rest_after(manager, at):
    """Seconds from `at` until zeros were in force for good."""
    common.wait_until(lambda: not manager.is_turning(), 6, "rest")
    time.sleep(0.6)
    sent = manager.rates_since(at)
    moving = [index for index, (_, rates) in enumerate(sent) if any(rates)]
    first = moving[-1] + 1 if moving else 0
    return sent[first][0] - at if first < len(sent) else math.inf


def rests(rows, name, manager, at):
    rest = rest_after(manager, at)
    rows.require(f"{name}: zeros in force", rest <= REST_LIMIT, f"after {rest * 1e3:.0f} ms", f"at most {REST_LIMIT * 1e3:.0f} ms")


def follow(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "follow") as run:
        run.wait_until_it_moves()
        began = time.monotonic()
        time.sleep(4)
        sent = manager.rates_since(began)
        gaps = [later[0] - earlier[0] for earlier, later in itertools.pairwise(sent) if any(earlier[1]) and any(later[1])]
        rows.require("follow: rates are sent steadily while moving", gaps and max(gaps) <= RENEWED_WITHIN, f"at most {max(gaps, default=0) * 1e3:.0f} ms apart", f"{RENEWED_WITHIN * 1e3:.0f} ms")
        moving = [when for when, rates in sent if any(rates)]
        rows.require("follow: and no faster than 21 times a second", len(moving) <= 21 * 4, f"{len(moving)} in 4 s")
        at = time.monotonic()
        run.request("stop")
        rests(rows, "Stop", manager, at)
        time.sleep(1.5)
        zeros = [when for when, rates in manager.rates_since(at) if not any(rates)]
        gaps = [later - earlier for earlier, later in itertools.pairwise(zeros)]
        rows.require("Stop: zeros are explicit, and repeated at rest", len(zeros) >= 5 and max(gaps) <= 0.35, f"{len(zeros)} of them, at most {max(gaps, default=0) * 1e3:.0f} ms apart")
        link = run.link()
        rows.require("follow: the tilt of the gimbal is on the console", link.get("tilt_deg") is not None, f"{link.get('tilt_deg')}")
        interval = [message.param2 for _, message in manager.commands(511) if int(message.param1) == 285]
        rows.require("follow: the attitude is asked for at 20 Hz", interval and set(interval) == {50_000.0})
    rows.require("end of the run: exit code 0, the control is released", run.child.returncode == 0 and manager.primary == NOBODY, f"code {run.child.returncode}, primary {manager.primary}")
    return manager


def deaf(rows, args, folder):
    """A Stop that does not arrive, while the gimbal's reports do."""
    manager = GimbalManager()
    with Run(args, folder, manager, "deaf") as run:
        run.wait_until_it_moves()
        common.wait_until(lambda: max(map(abs, manager.rates)) >= 0.1, MOVES_WITHIN, "a fast motion")
        manager.is_deaf = True
        at = time.monotonic()
        run.request("stop")
        common.wait_until(lambda: "camera-turns" in run.ask("status")["alarms"], 5, "the alarm")
        told = time.monotonic() - at
        rows.require("commands lost one way: the alarm is raised", told <= TOLD_WITHIN, f"after {told * 1e3:.0f} ms at {max(map(abs, manager.rates)):.2f} rad/s", f"at most {TOLD_WITHIN * 1e3:.0f} ms")
        time.sleep(3)
        rows.require("commands lost one way: the alarm lasts as long as the motion", "camera-turns" in run.ask("status")["alarms"])
        manager.is_deaf = False
        at = time.monotonic()
        rests(rows, "commands arrive again", manager, at)
        common.wait_until(lambda: "camera-turns" not in run.ask("status")["alarms"], 3, "the end of the alarm")
        rows.require("commands arrive again: the alarm ends", True, f"after {(time.monotonic() - at) * 1e3:.0f} ms")
    return manager


def ended(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "ended") as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.terminate()
        rests(rows, "SIGTERM", manager, at)
        run.child.wait(timeout=8)
        zeros = [rates for _, rates in manager.rates_since(at) if not any(rates)]
        rows.require("SIGTERM: zeros several times, then the release", len(zeros) >= 10 and manager.primary == NOBODY, f"{len(zeros)} zeros, primary {manager.primary}")
    return manager


def killed(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "killed") as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.kill()
        rests(rows, "SIGKILL of the program", manager, at)
        common.wait_until(lambda: manager.primary == NOBODY, 8, "the release")
        rows.require("SIGKILL of the program: the guard releases the control", True, f"after {time.monotonic() - at:.1f} s")
    return manager


def stopped(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "stopped") as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.child.send_signal(signal.SIGSTOP)
        rests(rows, "SIGSTOP of the program", manager, at)
        time.sleep(3)
        rows.require("SIGSTOP of the program: the gimbal stays at rest", not any(any(rates) for _, rates in manager.rates_since(at + REST_LIMIT)))
        # The guard has released the control, and the next one may come with zeros.
        manager.may_be_turning = True
    return manager


def guard_killed(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "guard") as run:
        run.wait_until_it_moves()
        manager.may_be_turning = True
        at = time.monotonic()
        os.kill(run.guard(), signal.SIGKILL)
        common.wait_until(lambda: any(not any(rates) for _, rates in manager.rates_since(at)), 6, "zeros")
        first = next(when for when, rates in manager.rates_since(at) if not any(rates)) - at
        rows.require("SIGKILL of the guard: zeros of the next one", first <= REST_LIMIT, f"after {first * 1e3:.0f} ms", f"at most {REST_LIMIT * 1e3:.0f} ms")
        run.wait_until_it_moves()
        rows.require("SIGKILL of the guard: the next one goes on", True, f"moves again after {time.monotonic() - at:.1f} s")
    return manager


def stolen(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "stolen") as run:
        run.wait_until_it_moves()
        at = manager.take()
        run.wait_for_control(False)
        told = time.monotonic() - at
        time.sleep(3)
        late = [when - at for when, _ in manager.rates_since(at)]
        rows.require("control stolen in mid-motion: told, and nothing more is sent", not late or max(late) <= UNDER_WAY, f"told after {told * 1e3:.0f} ms, {len(late)} rates, the last after {max(late, default=0) * 1e3:.0f} ms")
        mode = run.ask("status")["mode"]
        rows.require("control stolen: the engagement has ended, the control stays away", mode["cause"] == "control-lost" and manager.primary == OTHER, str(mode)[:70])
        manager.may_be_claimed = True
        run.request("engage")
        run.wait_for_control(True)
        rows.require("Engage takes the control back", manager.primary == OWN)
    return manager


def guard_killed_after_a_loss(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "guard-lost-control") as run:
        run.wait_until_it_moves()
        manager.take()
        run.wait_for_control(False)
        manager.give_back()
        claims, before, at = len(manager.commands(1001)), run.guard(), time.monotonic()
        os.kill(before, signal.SIGKILL)
        common.wait_until(lambda: run.guards() not in ([], [before]), 6, "the next guard")
        time.sleep(4)
        rows.require("SIGKILL of the guard after another took the control: the next one does not claim it", len(manager.commands(1001)) == claims and not manager.rates_since(at), f"{len(manager.rates_since(at))} rates")
        run.request("engage")
        run.wait_until_it_moves()
        rows.require("SIGKILL of the guard after another took the control: Engage claims it", manager.primary == OWN)
    return manager


def held(rows, args, folder):
    manager = GimbalManager(held=True)
    with Run(args, folder, manager, "held") as run:
        run.wait_for_control(False)
        time.sleep(3)
        rows.require("another's control at the start: no rate, no claim", not manager.rates_since(0) and not manager.commands(1001), f"{len(manager.messages)} messages")
        manager.may_be_claimed = True
        run.request("engage")
        run.wait_until_it_moves()
        rows.require("another's control: Engage takes it, and the gimbal moves", manager.primary == OWN)
    return manager


def silent(rows, args, folder):
    manager = GimbalManager()
    with Run(args, folder, manager, "silent", video=LASTING_WORLD) as run:
        run.wait_until_it_moves()
        manager.is_silent = manager.may_be_turning = True
        at = time.monotonic()
        run.err.wait_for("does not answer", 6)
        told = time.monotonic() - at
        rest = rest_after(manager, at)
        rows.require("gimbal silent: told, and zeros", told <= 4.5 and rest < 5, f"told after {told:.1f} s, zeros after {rest:.1f} s", "3 s of silence")
        manager.is_silent = False
        run.wait_for_control(True)
        time.sleep(1)
        rows.require("gimbal heard again: zeros until the next Engage", not manager.is_turning())
        run.request("engage")
        run.wait_until_it_moves()
        rows.require("gimbal heard again: Engage moves it", True)
    return manager


def lossy(rows, args, folder):
    manager = GimbalManager(loss=0.3)
    with Run(args, folder, manager, "lossy", video=LASTING_WORLD) as run:
        run.wait_until_it_moves()
        time.sleep(2)
        at = time.monotonic()
        run.child.terminate()
        rest = rest_after(manager, at)
        rows.require("3 of 10 packets lost: moves, and zeros are in force", rest <= 0.6, f"after {rest * 1e3:.0f} ms", "two zeros may get lost")
        run.child.wait(timeout=12)
    return manager


def reluctant(rows, args, folder):
    manager = GimbalManager(withholds=True, drops=2)
    with Run(args, folder, manager, "reluctant") as run:
        run.wait_until_it_moves()
        rows.require("information withheld, two claims lost: found by its status, and moved", manager.primary == OWN, f"{len(manager.commands(1001))} claims")
    return manager


def denied(rows, args, folder):
    manager = GimbalManager(denies=True)
    with Run(args, folder, manager, "denied") as run:
        run.wait_for_control(False)
        common.wait_until(lambda: manager.denied_at, LINK_UP_WITHIN, "the first denial")
        time.sleep(3)
        # A claim may be repeated until its answer is there.
        late = [when - manager.denied_at for when, _ in manager.commands(1001) if when > manager.denied_at + UNDER_WAY]
        rows.require("claim denied: told, not asked again, no rate", not late and not manager.rates_since(0), f"asked {', '.join(f'{after:.1f} s' for after in late) or 'never'} later")
    return manager


def signed(rows, args, folder):
    key = folder / "signing-key"
    key.write_text(f"{PASSPHRASE}\n")
    key.chmod(0o600)
    manager = GimbalManager(passphrase=PASSPHRASE)
    with Run(args, folder, manager, "signed", "--link-signing-key-file", key) as run:
        run.wait_until_it_moves()
        unsigned = [message for _, message in manager.messages if not message.get_signed()]
        rows.require("signed packets: the gimbal moves, and every packet is signed", not unsigned, f"{len(manager.messages)} messages")
        rows.require("signed packets: no log line holds the key", PASSPHRASE not in run.err.text())
    return manager


def signed_wrong(rows, args, folder):
    key = folder / "another-key"
    key.write_text("another passphrase\n")
    key.chmod(0o600)
    manager = GimbalManager(passphrase=PASSPHRASE)
    with Run(args, folder, manager, "signed-wrong", "--link-signing-key-file", key) as run:
        run.err.wait_for("signing key", 16)
        rows.require("another key: nothing is read, and the remedy is told", manager.primary == NOBODY)
    manager.faults.clear()
    return manager


def check_says(table, args, folder):
    """What `check` says of a gimbal, of nobody, of one that another client has, and of one that describes nothing."""

    def check(name, manager, *patterns, code=None):
        done = common.run([args.barrelman, "check", "--profile", "mavlink-gimbal", "--video", "sim:arena1", "--link", getattr(manager, "url", manager)])
        found = all(pattern in done.stdout for pattern in patterns) and code in (None, done.returncode)
        table.require(f"check: {name}", found, f"code {done.returncode}", "" if found else done.stdout[-400:])

    manager = GimbalManager()
    check("axes and end stops, nobody has the control", manager, "pitch from -90 to 20 degrees", "nobody has the control", code=0)
    manager.primary = OTHER
    check("the control is another's", manager, "255/190 has the control")
    table.require("check: moves and claims nothing", not manager.rates_since(0) and not manager.commands(1001))
    manager.is_silent = True
    check("no heartbeat", manager, "no heartbeat", code=1)
    manager.close()
    withheld = GimbalManager(withholds=True)
    check("information withheld", withheld, "does not say which axes", code=0)
    withheld.close()
    check("nobody is there", f"udp://127.0.0.1:{live.free_port()}", "nobody takes packets there", code=1)
    emulator = common.spawn([args.barrelman, "emulate", "gimbal", "--listen", "udp://127.0.0.1:0", "--withhold-information", "--withhold-status"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    _, line = Lines(emulator.stdout).wait_for("answers at", 10)
    check("no gimbal", line.split("answers at ")[1].strip(), "no gimbal manager answers", code=1)
    emulator.terminate()


def closed_loop(table, args, folder):
    """The emulated gimbal moves the camera of the world that the run sees, on a line that loses one packet of ten."""
    video, log = live.free_port(), folder / "emulated.jsonl"
    command = [args.barrelman, "emulate", "gimbal", "--listen", "udp://127.0.0.1:0", "--world", WORLD, "--video-listen", f"127.0.0.1:{video}", "--loss", "10", "--log", log, "--force"]
    emulator = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    _, line = Lines(emulator.stdout).wait_for("answers at", 15)
    clip, truth = folder / "first.mp4", folder / "first.csv"
    common.run([args.barrelman, "render", "arena1", "--seed", "3", "--seconds", "0.2", "--size", "640x360", "--output", clip, "--truth", truth])
    box = next(csv.DictReader(open(truth)))
    select = ",".join(f"{float(box[key]):.0f}" for key in "xywh")
    with Run(args, folder, line.split("answers at ")[1].strip(), "closed", "--select", select, video=f"rtsp://127.0.0.1:{video}/world") as run:
        run.wait_for_control(True)
        common.wait_until(lambda: run.ask("status")["video"]["captured_ns"], 15, "the first video frame")
        seen = []
        for _ in range(150):
            seen.append(run.ask("status"))
            time.sleep(0.1)
        followed = [state for state in seen if state["percept"] and state["track"]["state"] == "tracking"]
        inside = sum(state["percept"]["p"] <= 1 for state in followed) / max(len(followed), 1)
        table.require("closed loop: the boat is tracked", len(followed) >= 0.9 * len(seen), f"{len(followed)} of {len(seen)} states")
        table.require("closed loop: the boat stays in the region", inside >= 0.7, f"{inside:.0%} of the time")
        code = run.end()
        table.require("closed loop: exit code 0", code == 0, f"code {code}")
    emulator.terminate()
    emulator.wait(timeout=5)
    rows = [json.loads(row) for row in log.read_text().splitlines()]
    turned = sum(1 for row in rows if row["state"]["yaw_rate"] or row["state"]["pitch_rate"])
    last = rows[-1]["state"]
    table.require("closed loop: the camera was turned, and rests at the end", turned > 20 and not last["yaw_rate"] and not last["pitch_rate"], f"{turned} rows in motion of {len(rows)}")


def main():
    args = common.arguments(__doc__, at_once={"type": int, "default": 2, "help": "number of cases at the same time"}, only={"help": "names of the cases to run, with commas"})
    folder = common.temporary_folder()
    table = Table("A run against a MAVLink gimbal")
    wanted = args.only.split(",") if args.only else None

    def attempt(case):
        def safely(rows):
            manager = None
            try:
                manager = case(rows, args, folder)
                faults = "; ".join(sorted(set(manager.faults)))
                rows.require(f"{case.__name__}: every message keeps the rules", not faults, f"{len(manager.messages)} messages", faults[:200])
            except (TimeoutError, OSError, StopIteration, subprocess.TimeoutExpired) as error:
                rows.require(f"{case.__name__}: the case came to its end", False, f"{error}")
            finally:
                if manager:
                    manager.close()

        return table.try_again_through_standstills(safely)

    cases = [follow, deaf, ended, killed, stopped, guard_killed, stolen, guard_killed_after_a_loss, held, silent, lossy, reluctant, denied, signed, signed_wrong]
    with concurrent.futures.ThreadPoolExecutor(args.at_once) as pool:
        list(pool.map(attempt, [case for case in cases if wanted is None or case.__name__ in wanted]))
    if wanted is None or "check_says" in wanted:
        check_says(table, args, folder)
    if wanted is None or "closed_loop" in wanted:
        # It decodes, tracks and renders, and runs alone.
        table.try_again_through_standstills(lambda rows: closed_loop(rows, args, folder))
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
