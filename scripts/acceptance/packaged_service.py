"""The installed service as its user meets it. `packages.sh` runs this file as root in a booted container.

Needs Python's own library alone. Each check prints its name; the last line is "all checks passed".
"""

import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable
from typing import Any

CONFIGURATION = pathlib.Path("/etc/barrelman/barrelman.toml")
STATE = pathlib.Path("/var/lib/barrelman")
DROP_IN = pathlib.Path("/run/systemd/system/barrelman.service.d/test.conf")
LOG = pathlib.Path("/acceptance/fotokite.jsonl")
UPGRADES = sorted(pathlib.Path("/acceptance/upgrade").glob("*.deb"))
LINK = "127.0.0.1:5760"
# Longer than the start of the program on a loaded machine.
PATIENCE_S = 60.0
# docs/safety.md: from the death of the program to zeros, and what a loaded machine adds.
ZEROS_WITHIN_S = 0.35
SLACK_S = 0.65


def run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def must(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command} ended with {done.returncode}: {done.stdout}{done.stderr}"
    return done.stdout


def wait_until(condition: Callable[[], Any], what: str, seconds: float = PATIENCE_S) -> Any:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := condition():
            return found
        time.sleep(0.05)
    raise AssertionError(f"not within {seconds} s: {what}\n{journal()[-4000:]}")


def journal() -> str:
    return run("journalctl", "-b", "-u", "barrelman", "--no-pager", "-o", "cat")


def unit(name: str) -> str:
    return must("systemctl", "show", "barrelman", "--value", "-p", name).strip()


def main_pid() -> int:
    return int(unit("MainPID"))


def processes_of(name: str) -> list[int]:
    """The processes of a program, by the first 15 bytes of its name."""
    found = run("pgrep", "-x", name[:15]).split()
    return [int(pid) for pid in found]


def links() -> dict[str, str]:
    lines = must("barrelman", "links").splitlines()
    return dict(line.split(": ", 1) for line in lines if ": http://" in line)


def ask(path: str, body: dict[str, Any] | None = None) -> Any:
    page, token = links()["control"].split("#token=")
    headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"{page}api/v1/{path}", data, headers)
    with urllib.request.urlopen(request, timeout=10) as answer:
        return json.load(answer)


def request(kind: str) -> None:
    answer = ask("requests", {"request": {"kind": kind}})
    assert answer["answer"] == "accepted", (kind, answer)


def rates() -> list[tuple[float, float, float]]:
    """Time and rates in force of each row of the vehicle's log."""
    whole = LOG.read_text().rpartition("\n")[0].splitlines()
    rows = [json.loads(line) for line in whole]
    return [(row["mono_ns"] / 1e9, row["state"]["yaw_rate"], row["state"]["pitch_rate"]) for row in rows]


def configure(video: str, link: str | None = None) -> None:
    text = CONFIGURATION.read_text()
    text = text.replace("[video]\n", f'[video]\nurl = "{video}"\n')
    if link:
        text = text.replace("[link]\n", f'[link]\nurl = "{link}"\n')
    CONFIGURATION.write_text(text)


def without_a_video_it_says_what_to_configure() -> None:
    done = subprocess.run(
        ["systemctl", "enable", "--now", "barrelman"], capture_output=True, text=True, check=False
    )
    assert done.returncode != 0, done
    wait_until(lambda: unit("ActiveState") == "failed", "the unit has failed")
    assert "video.url in /etc/barrelman/barrelman.toml" in journal(), journal()
    assert unit("NRestarts") == "0", "a mistake in the configuration is not tried again"
    error = run("barrelman", "links")
    assert "sudo systemctl start barrelman" in error, error


def with_a_video_it_is_ready_and_its_page_answers() -> None:
    configure("sim:arena1?size=320x240", f"tcp://{LINK}")
    emulate = ["barrelman", "emulate", "fotokite-pro", "--listen", LINK, "--log", str(LOG)]
    subprocess.Popen(emulate, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_until(LOG.exists, "the emulated vehicle runs")
    must("systemctl", "restart", "barrelman")
    assert unit("ActiveState") == "active"
    with urllib.request.urlopen("http://127.0.0.1:8480/healthz", timeout=10) as answer:
        assert answer.read().strip() == b"ok"
    assert ask("access")["may_control"]


def it_runs_as_its_own_user_with_few_rights() -> None:
    status = pathlib.Path(f"/proc/{main_pid()}/status").read_text()
    user = must("id", "-u", "barrelman").strip()
    assert re.search(rf"^Uid:\s+{user}\b", status, re.MULTILINE), status
    for line in ("CapBnd:\t0000000000000000", "NoNewPrivs:\t1", "Seccomp:\t2"):
        assert line in status, status
    groups = set(must("id", "-nG", "barrelman").split())
    assert {"dialout", "video"} <= groups, groups
    must("systemd-analyze", "security", "--threshold=25", "barrelman.service")


def recordings_and_tokens_are_its_own() -> None:
    tokens = STATE / "console-tokens"
    assert tokens.stat().st_mode & 0o777 == 0o600
    assert tokens.read_text().split() == [link.split("=")[1] for link in links().values()]
    assert list((STATE / "recordings").glob("run-*.mcap"))
    refused = run("runuser", "-u", "nobody", "--", "barrelman", "links")
    assert "sudo barrelman links" in refused, refused
    assert links()["control"].split("=")[1] not in journal(), "the journal holds a token"


def it_keeps_the_machine_awake() -> None:
    wait_until(
        lambda: re.search(r"^barrelman ", run("systemd-inhibit", "--list"), re.MULTILINE), "an inhibitor"
    )
    assert "does not keep this machine awake" not in journal(), journal()


def the_guard_outlives_a_killed_program_and_stops_the_camera() -> None:
    before = links()
    wait_until(lambda: len(processes_of("barrelman-guard")) == 1, "a guard runs")
    wait_until(lambda: ask("status")["link"]["state"] == "up", "the link is up")
    request("take-control")
    wait_until(lambda: ask("status")["track"]["state"] == "tracking", "the boat is tracked")
    request("engage")
    restarts, pid, [guard] = unit("NRestarts"), main_pid(), processes_of("barrelman-guard")
    wait_until(lambda: any(rates()[-1][1:]), "the camera turns")
    killed = time.monotonic()
    os.kill(pid, signal.SIGKILL)
    assert guard in processes_of("barrelman-guard"), "the guard was killed, too"
    wait_until(lambda: guard not in processes_of("barrelman-guard"), "the guard ends")
    assert any([row for row in rates() if row[0] < killed][-1][1:]), "the camera turned when it was killed"
    after = [at for at, *of_axes in rates() if at >= killed and not any(of_axes)]
    assert after, rates()[-5:]
    assert after[0] - killed < ZEROS_WITHIN_S + SLACK_S, (killed, after[0])
    print(f"  zeros {1000 * (after[0] - killed):.0f} ms after the program was killed")
    wait_until(lambda: unit("NRestarts") != restarts and unit("ActiveState") == "active", "a new start")
    assert main_pid() != pid
    assert links() == before, "the links stay"
    wait_until(lambda: ask("status")["track"]["state"] == "tracking", "the boat is tracked again")
    time.sleep(3)
    mode = ask("status")["mode"]
    assert (mode["name"], mode["engaged"]) == ("idle", False), mode
    moving = [row for row in rates() if row[0] > after[0] and any(row[1:])]
    assert not moving, f"a new start moves the camera: {moving[:3]}"


def a_run_loop_that_hangs_is_started_again() -> None:
    DROP_IN.parent.mkdir(parents=True)
    # The other threads go on; only the loop gives no sign of life.
    start = unit("ExecStart").split("argv[]=")[1].split(" ;")[0]
    DROP_IN.write_text(f"[Service]\nExecStart=\nExecStart={start} --fault pilot:hang@5\n")
    must("systemctl", "daemon-reload")
    must("systemctl", "restart", "barrelman")
    restarts, pid = unit("NRestarts"), main_pid()
    began = time.monotonic()
    wait_until(lambda: unit("NRestarts") != restarts, "the watchdog starts it again")
    print(f"  started again {time.monotonic() - began:.0f} s after the start; it hung after 5 s")
    assert "Watchdog timeout" in journal(), journal()[-2000:]
    DROP_IN.unlink()
    must("systemctl", "daemon-reload")
    wait_until(lambda: unit("ActiveState") == "active" and main_pid() != pid, "it runs again")
    must("systemctl", "restart", "barrelman")
    restarts, pid = unit("NRestarts"), main_pid()
    time.sleep(25)
    assert (unit("NRestarts"), main_pid()) == (restarts, pid), "a loop that makes turns is left alone"


def an_upgrade_keeps_the_configuration_and_restarts_the_service() -> None:
    before, text, pid = links(), CONFIGURATION.read_text(), main_pid()
    keep = ["-o", "Dpkg::Options::=--force-confold", "-y"]
    os.environ["DEBIAN_FRONTEND"] = "noninteractive"
    must("apt-get", "install", *keep, *map(str, UPGRADES))
    assert must("dpkg-query", "-W", "-f", "${Version}", "barrelman").strip().endswith("-2")
    assert CONFIGURATION.read_text() == text
    wait_until(lambda: unit("ActiveState") == "active" and main_pid() != pid, "the new version runs")
    assert links() == before
    assert unit("UnitFileState") == "enabled"


def a_stop_is_in_order() -> None:
    must("systemctl", "stop", "barrelman")
    assert unit("Result") == "success", unit("Result")
    assert not any(rates()[-1][1:])
    assert not pathlib.Path("/run/barrelman").exists()


def removing_keeps_the_configuration_and_purging_the_recordings() -> None:
    must("systemctl", "start", "barrelman")
    must("apt-get", "remove", "-y", "barrelman", "barrelman-media")
    wait_until(lambda: not processes_of("barrelman-guard"), "the guard ends")
    assert run("pgrep", "-f", "barrelman run").strip() == ""
    assert CONFIGURATION.exists()
    assert (STATE / "console-tokens").exists()
    must("apt-get", "purge", "-y", "barrelman", "barrelman-media")
    assert not CONFIGURATION.parent.exists()
    assert not (STATE / "console-tokens").exists()
    assert list((STATE / "recordings").glob("run-*.mcap"))
    left = run("systemctl", "is-enabled", "barrelman").strip()
    assert left != "enabled", left


CHECKS = (
    without_a_video_it_says_what_to_configure,
    with_a_video_it_is_ready_and_its_page_answers,
    it_runs_as_its_own_user_with_few_rights,
    recordings_and_tokens_are_its_own,
    it_keeps_the_machine_awake,
    the_guard_outlives_a_killed_program_and_stops_the_camera,
    a_run_loop_that_hangs_is_started_again,
    an_upgrade_keeps_the_configuration_and_restarts_the_service,
    a_stop_is_in_order,
    removing_keeps_the_configuration_and_purging_the_recordings,
)


def main() -> None:
    try:
        for check in CHECKS:
            print(check.__name__, flush=True)
            check()
    finally:
        pathlib.Path("/acceptance/journal").write_text(journal())
    print("all checks passed")


if __name__ == "__main__":
    try:
        main()
    except Exception as error:
        print(f"FAILED: {type(error).__name__}: {error}", flush=True)
        sys.exit(1)
