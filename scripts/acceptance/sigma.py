"""Tests a run against a Fotokite Sigma of another's writing (independent_sigma.py), which judges every request.

The video is a simulated world's, whose camera nothing moves: the boat leaves the region, and the camera law asks for motion.
A last case closes the loop: the emulated Sigma moves the camera of the world that the run sees.
"""
import concurrent.futures
import csv
import json
import signal
import subprocess
import sys
import time

import common
import live
from common import Lines, Table
from console_run import WORLD, ConsoleRun
from independent_sigma import COMMAND, TOKEN, Sigma

MOVES_WITHIN = 20.0
# The duration of a command, and the time of a request on a busy machine.
DURATION_LIMIT = 0.5
STOP_LIMIT = 0.15


class Run(ConsoleRun):
    """A run against a Sigma."""

    def __init__(self, args, folder, sigma, name, *more, token=TOKEN, video=WORLD):
        self.sigma = sigma
        token_file = folder / f"{name}.token"
        token_file.write_text(f"{token}\n")
        token_file.chmod(0o600)
        link = ["--profile", "fotokite-sigma", "--link", getattr(sigma, "url", sigma), "--link-token-file", token_file]
        super().__init__(args, folder, name, *link, *more, video=video)

    def wait_for_link(self, acceptance, seconds=10):
        return common.wait_until(lambda: self.link().get("acceptance") == acceptance, seconds, f"acceptance {acceptance}")

    def wait_until_it_moves(self):
        common.wait_until(self.sigma.is_turning, MOVES_WITHIN, "the first motion")
        time.sleep(0.3)
        common.wait_until(self.sigma.is_turning, MOVES_WITHIN, "the next motion")


def rest_after(sigma, at, seconds=3.0):
    """Seconds from `at` until nothing turns the camera any more, as the vehicle has it."""
    end = at + seconds
    last = at
    while time.monotonic() < end:
        if sigma.is_turning():
            last = time.monotonic()
        time.sleep(0.002)
    return last - at


def judged(table, name, sigma):
    table.require(f"{name}: every request keeps the rules", not sigma.violations, f"{len(sigma.requests)} requests", "; ".join(sorted(set(sigma.violations)))[:200])


def follow(table, args, folder):
    sigma = Sigma()
    with Run(args, folder, sigma, "follow") as run:
        run.wait_until_it_moves()
        at = time.monotonic()
        run.request("stop")
        rest = rest_after(sigma, at)
        table.require("Stop while the camera turns: rest", rest <= STOP_LIMIT, f"{rest * 1e3:.0f} ms", f"at most {STOP_LIMIT * 1e3:.0f} ms")
        # Motion that was commanded before the program read the request; `rest` is its limit.
        after = [json.loads(body) for _, body in sigma.commands_since(at)]
        is_motion = [bool(command["pan_speed"] or command["tilt_speed"]) for command in after]
        zeros = is_motion[is_motion.index(False):] if False in is_motion else []
        told = ", ".join("turn" if motion else "zero" for motion in is_motion)
        table.require("Stop: explicit zeros, then nothing", 3 <= len(zeros) <= 14 and not any(zeros), told)
        time.sleep(4)
        moving = [(at, speeds, was) for at, speeds, was in sigma.motions if any(speeds)]
        gaps = [later[0] - earlier[0] for earlier, later in zip(sigma.motions, sigma.motions[1:]) if any(earlier[1]) and any(later[1])]
        table.require("follow: the first command is a zero", not any(sigma.motions[0][1]), f"{len(moving)} commands to turn")
        table.show("follow: longest time between commands of a motion", f"{max(gaps, default=0) * 1e3:.0f} ms", "a command lasts 450 ms")
        asked = [at for at, _, path, _ in sigma.requests if path.endswith("control/request")]
        table.require("follow: the control is asked for again well before 10 s", max((b - a for a, b in zip(asked, asked[1:])), default=0) < 5, f"{len(asked)} times")
        table.require("follow: one WebSocket tells the camera's state", sigma.sockets == 1, f"{sigma.sockets} opened")
        table.require("follow: the tablet shows a state", bool(sigma.shown), sigma.shown)
        link = run.link()
        table.require("follow: tilt and control reach the console", link.get("in_control") is True and link.get("tilt_deg") is not None, f"tilt {link.get('tilt_deg')}")
        code = run.end()
        table.require("end of the run: exit code 0, control released", code == 0 and sigma.ours_until == 0.0, f"code {code}")
        table.require("no log line holds the token", TOKEN not in run.err.text())
    judged(table, "follow", sigma)
    sigma.close()


def stolen(table, args, folder):
    sigma = Sigma(websocket=False)
    with Run(args, folder, sigma, "stolen") as run:
        run.wait_until_it_moves()
        sigma.take()
        at = time.monotonic()
        run.wait_for_link("other-client")
        told = time.monotonic() - at
        time.sleep(4)
        late = [when for when, _ in sigma.commands_since(at + 0.5)]
        asked = [when for when, _, path, _ in sigma.requests if when > at + 0.5 and path.endswith("control/request")]
        table.require("control stolen in mid-motion: told, no command, no request", not late and not asked, f"told after {told * 1e3:.0f} ms")
        mode = run.ask("status")["mode"]
        table.require("control stolen: the engagement has ended", mode["cause"] == "control-lost" or "control" in str(mode), str(mode)[:60])
        sigma.give_back()
        time.sleep(3)
        table.require("control that is free again is not taken unasked", sigma.ours_until == 0.0)
        run.request("engage")
        run.wait_for_link("accepted")
        table.require("Engage takes the free control", sigma.ours_until > 0.0)
        table.require("without a WebSocket the camera's state is read", sum(path == "/v1/camera/state" for _, _, path, _ in sigma.requests) > 20)
    judged(table, "control stolen", sigma)
    sigma.close()


def token_wrong(table, args, folder):
    sigma = Sigma()
    with Run(args, folder, sigma, "wrong", token="another-token") as run:
        run.wait_for_link("token-refused")
        table.require("token wrong: told on the console, no command", not sigma.commands_since(0), f"{len(sigma.requests)} requests")
        time.sleep(4)
        refused = [path for _, _, path, _ in sigma.requests if path != "/v1/health"]
        table.require("token wrong: the vehicle is not hammered", len(refused) <= 4, f"{len(refused)} requests in 4 s")
    sigma.close()


def refusals(table, args, folder):
    sigma = Sigma()
    with Run(args, folder, sigma, "refusals") as run:
        for status, expected in ((409, "flight-state"), (503, "not-ready"), (502, "fault")):
            run.wait_for_link("accepted", 15)
            run.wait_until_it_moves()
            sigma.status = status
            at = time.monotonic()
            run.wait_for_link(expected)
            rest = rest_after(sigma, at, 1.5)
            table.require(f"status {status}: told, and the motion ends", rest <= DURATION_LIMIT, f"{rest * 1e3:.0f} ms", f"at most {DURATION_LIMIT * 1e3:.0f} ms")
            sigma.status = None
    judged(table, "refusals", sigma)
    sigma.close()


def hung(table, args, folder):
    sigma = Sigma()
    with Run(args, folder, sigma, "hung") as run:
        run.wait_until_it_moves()
        sigma.hangs.set()
        at = time.monotonic()
        rest = rest_after(sigma, at)
        table.require("server hung: the motion ends by its duration", rest <= DURATION_LIMIT, f"{rest * 1e3:.0f} ms", f"at most {DURATION_LIMIT * 1e3:.0f} ms")
        time.sleep(2)
        sigma.hangs.clear()
        run.wait_for_link("accepted", 15)
        table.require("server hung: the link comes back by itself", True, f"{time.monotonic() - at:.1f} s after the hang began")
    judged(table, "server hung", sigma)
    sigma.close()


def killed(table, args, folder, number, name):
    sigma = Sigma()
    with Run(args, folder, sigma, name) as run:
        run.wait_until_it_moves()
        run.child.send_signal(number)
        at = time.monotonic()
        rest = rest_after(sigma, at)
        table.require(f"{name}: the motion ends by its duration", rest <= DURATION_LIMIT, f"{rest * 1e3:.0f} ms", f"at most {DURATION_LIMIT * 1e3:.0f} ms")
    sigma.close()


def encrypted(table, args, folder):
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    done = common.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", key, "-out", certificate, "-days", "2", "-subj", "/CN=sigma"])
    if done.returncode:
        table.show("TLS", "NOT RUN", f"openssl: {done.stderr[-100:]}")
        return
    fingerprint = common.run(["openssl", "x509", "-in", certificate, "-noout", "-fingerprint", "-sha256"]).stdout.split("=")[1].strip()
    plain = fingerprint.replace(":", "").lower()
    sigma = Sigma(certificate=(certificate, key))
    wrong = "00" * 32
    with Run(args, folder, sigma, "pin-wrong", "--link-certificate-sha256", wrong) as run:
        code = run.child.wait(timeout=15)
        run.err.join()
        text = run.err.text()
        table.require("TLS, wrong pin: refused, with both fingerprints", code == 1 and plain in text and wrong in text, f"code {code}")
    with Run(args, folder, sigma, "pin-none") as run:
        code = run.child.wait(timeout=15)
        table.require("TLS, self-signed without a pin: refused", code == 1, f"code {code}")
    table.require("TLS refused: no request was made", not sigma.requests, f"{len(sigma.requests)} requests")
    with Run(args, folder, sigma, "pin-right", "--link-certificate-sha256", fingerprint) as run:
        run.wait_until_it_moves()
        table.require("TLS, right pin: the camera is moved", True)
    judged(table, "TLS", sigma)
    sigma.close()


def checks(table, args, folder):
    """What `check` says of each state."""
    token = folder / "check.token"
    token.write_text(f"{TOKEN}\n")
    token.chmod(0o600)
    sigma = Sigma()

    def check(name, pattern, *more, url=sigma.url):
        done = common.run([args.barrelman, "check", "--profile", "fotokite-sigma", "--video", "sim:arena1", "--link", url, "--link-token-file", token, *more])
        found = next((line.strip() for line in done.stdout.splitlines() if pattern in line), "")
        table.require(f"check: {name}", bool(found), found[:90], "" if found else done.stdout[-300:])

    check("all is well, with the least rates", "2 to 25")
    sigma.take()
    check("the control is held by another client", "controls")
    sigma.give_back()
    token.write_text("wrong\n")
    check("the token is wrong", "token")
    check("nobody is there", "not usable", url="http://127.0.0.1:9/api")
    table.require("check asks for nothing but states", all(method == "GET" for _, method, _, _ in sigma.requests))
    sigma.close()


def closed_loop(table, args, folder):
    """The emulated Sigma moves the camera of the world that the run sees, over RTSP, at the address that the vehicle tells."""
    port, video = live.free_port(), live.free_port()
    log = folder / "emulated.jsonl"
    command = [args.barrelman, "emulate", "fotokite-sigma", "--listen", f"127.0.0.1:{port}", "--world", "sim:arena1?seed=3&size=640x360", "--video-listen", f"127.0.0.1:{video}", "--token", TOKEN, "--log", log]
    emulator = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    Lines(emulator.stdout).wait_for("answers at", 15)
    clip, truth = folder / "first.mp4", folder / "first.csv"
    done = common.run([args.barrelman, "render", "arena1", "--seed", "3", "--seconds", "0.2", "--size", "640x360", "--output", clip, "--truth", truth])
    box = next(csv.DictReader(open(truth)))
    select = ",".join(f"{float(box[key]):.0f}" for key in "xywh")
    table.require("closed loop: the first picture is drawn", done.returncode == 0, select, done.stderr[-100:])
    with Run(args, folder, f"http://127.0.0.1:{port}/api", "closed", "--select", select, video=None) as run:
        run.wait_for_link("accepted", 15)
        common.wait_until(lambda: run.ask("status")["video"]["captured_ns"], 15, "the first video frame")
        seen = []
        for _ in range(150):
            seen.append(run.ask("status"))
            time.sleep(0.1)
        status = seen[-1]
        followed = [state for state in seen if state["percept"] and state["track"]["state"] == "tracking"]
        inside = sum(state["percept"]["p"] <= 1 for state in followed) / max(len(followed), 1)
        table.require("closed loop: the boat is tracked", len(followed) >= 0.9 * len(seen), f"{len(followed)} of {len(seen)} states")
        table.require("closed loop: the boat stays in the region", inside >= 0.7, f"{inside:.0%} of the time, P up to {max((state['percept']['p'] for state in followed), default=0):.2f}")
        table.require("closed loop: video from the vehicle's own address", status["video"]["state"] == "up", str(status["video"]["size"]))
        code = run.end()
        table.require("closed loop: exit code 0", code == 0, f"code {code}")
    emulator.terminate()
    emulator.wait(timeout=5)
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    turned = [row for row in rows if row.get("pan_deg_per_s") or row.get("tilt_deg_per_s")]
    table.require("closed loop: the camera of the world was turned", len(turned) > 3, f"{len(turned)} changes of the rates")
    refused = [row for row in rows if row.get("status") in (400, 404)]
    table.require("closed loop: the emulator refuses nothing as unusable", not refused, f"{len(rows)} rows", str(refused[:2]))


def main():
    args = common.arguments(__doc__)
    folder = common.temporary_folder()
    table = Table("A run against a Fotokite Sigma")

    # Two cases at a time: most of a case is waiting. The closed loop decodes and renders, and runs alone.
    def one_after_the_other(cases):
        for case, *more in cases:
            try:
                case(table, args, folder, *more)
            except (TimeoutError, OSError, subprocess.TimeoutExpired) as error:
                table.require(f"{case.__name__}: the case came to its end", False, f"{error}")

    first = [(follow,), (hung,), (killed, signal.SIGKILL, "SIGKILL of the program"), (killed, signal.SIGSTOP, "SIGSTOP of the program"), (checks,)]
    second = [(stolen,), (refusals,), (encrypted,), (token_wrong,)]
    with concurrent.futures.ThreadPoolExecutor() as pool:
        list(pool.map(one_after_the_other, [first, second]))
    one_after_the_other([(closed_loop,)])
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
