"""The installed service as its user meets it. `packages.sh` runs this file as root in a booted container.

Needs Python's own library alone. Each check prints its name; the last line is "all checks passed".
"""

import gzip
import hashlib
import json
import os
import pathlib
import re
import signal
import ssl
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any

CONFIGURATION = pathlib.Path("/etc/barrelman/barrelman.toml")
STATE = pathlib.Path("/var/lib/barrelman")
DROP_IN = pathlib.Path("/run/systemd/system/barrelman.service.d/test.conf")
LOG = pathlib.Path("/acceptance/fotokite.jsonl")
AUTHORITY = pathlib.Path("/acceptance/authority.pem")
SHARE = pathlib.Path("/usr/share")
UPGRADES = sorted(pathlib.Path("/acceptance/upgrade").glob("*.deb"))
PACKAGES = ("barrelman", "barrelman-media", "barrelman-ros2")
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
    return dict(line.split(": ", 1) for line in lines if re.search(r": https?://\S+#token=", line))


def tokens(of: dict[str, str]) -> list[str]:
    return [link.split("#token=")[1] for link in of.values()]


def ask(path: str, body: dict[str, Any] | None = None, token: str | None = None) -> Any:
    """The console's answer to the control token, or to another; over HTTPS its authority alone is trusted."""
    page, own = links()["control"].split("#token=")
    headers = {"Authorization": f"Bearer {token or own}", "Content-Type": "application/json"}
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"{page}api/v1/{path}", data, headers)
    trusting = ssl.create_default_context(cafile=AUTHORITY) if page.startswith("https:") else None
    with urllib.request.urlopen(request, timeout=10, context=trusting) as answer:
        return json.load(answer)


def refused(asking: Callable[[], Any]) -> urllib.error.HTTPError:
    try:
        answer = asking()
    except urllib.error.HTTPError as error:
        return error
    raise AssertionError(f"not refused: {answer}")


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


def assert_tokens_are_kept(of: dict[str, str]) -> None:
    file = STATE / "console-tokens"
    assert (file.stat().st_mode & 0o777, file.owner()) == (0o600, "barrelman")
    assert file.read_text().split() == tokens(of)


def recordings_and_tokens_are_its_own() -> None:
    assert_tokens_are_kept(links())
    assert list((STATE / "recordings").glob("run-*.mcap"))
    denied = run("runuser", "-u", "nobody", "--", "barrelman", "links")
    assert "sudo barrelman links" in denied, denied
    assert tokens(links())[0] not in journal(), "the journal holds a token"


def renewed_links_replace_those_of_the_token_file() -> None:
    old = links()
    answer = ask("links", {})
    new = links()
    assert [answer["control"], answer["watch"]] == list(new.values()), answer
    assert not set(tokens(old)) & set(tokens(new)), "both tokens are new"
    assert_tokens_are_kept(new)
    refusal = refused(lambda: ask("status", token=tokens(old)[0]))
    assert refusal.code == 401, refusal
    must("systemctl", "restart", "barrelman")
    assert links() == new, "the new links stay"


def on_all_addresses_it_speaks_https_with_an_authority_of_its_own() -> None:
    text = CONFIGURATION.read_text()
    CONFIGURATION.write_text(text.replace("127.0.0.1:8480", "0.0.0.0:8480"))
    before = links()
    must("systemctl", "restart", "barrelman")
    assert all(link.startswith("https://") for link in links().values()), links()
    assert tokens(links()) == tokens(before)
    unverified = ssl.create_default_context()
    unverified.check_hostname, unverified.verify_mode = False, ssl.CERT_NONE
    page = links()["control"].split("#")[0]
    with urllib.request.urlopen(f"{page}authority.pem", timeout=10, context=unverified) as answer:
        AUTHORITY.write_bytes(answer.read())
    assert fingerprint() == printed_fingerprint()
    assert ask("access")["may_control"]
    refusal = refused(lambda: urllib.request.urlopen("http://127.0.0.1:8480/healthz", timeout=10).read())
    assert (refusal.code, b"use https://" in refusal.read()) == (400, True), refusal
    key = STATE / "console-authority.json"
    assert (key.stat().st_mode & 0o777, key.owner()) == (0o600, "barrelman")
    must("systemctl", "restart", "barrelman")
    assert fingerprint() == printed_fingerprint(), "the authority stays"


def fingerprint() -> str:
    return hashlib.sha256(ssl.PEM_cert_to_DER_cert(AUTHORITY.read_text())).hexdigest().upper()


def printed_fingerprint() -> str:
    found = re.search(r"certificate authority: ([0-9A-F:]+)$", must("barrelman", "links"), re.MULTILINE)
    assert found
    return found[1].replace(":", "")


def the_node_of_ros_2_explains_itself() -> None:
    needs = must("barrelman-ros2", "--help")
    manual = gzip.decompress((SHARE / "man/man1/barrelman-ros2.1.gz").read_bytes()).decode()
    for option in ("--console", "--token-file", "--ca", "--dds-address"):
        assert option in needs, needs
        assert option.replace("-", "\\-") in manual, manual
    completions = SHARE / "bash-completion/completions/barrelman-ros2"
    complete = f"""source {completions}; COMP_WORDS=(barrelman-ros2 --dds); COMP_CWORD=1
        _barrelman__ros2 barrelman-ros2 --dds barrelman-ros2; echo "${{COMPREPLY[@]}}" """
    assert must("bash", "-c", complete).split() == ["--dds-address"]
    for part in ("zsh/vendor-completions/_barrelman-ros2", "fish/vendor_completions.d/barrelman-ros2.fish"):
        assert "dds-address" in (SHARE / part).read_text(), part
    plain = run("barrelman-ros2", "--console", "http://192.0.2.1:8480")
    assert "https://" in plain, plain


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
    must("apt-get", "remove", "-y", *PACKAGES)
    wait_until(lambda: not processes_of("barrelman-guard"), "the guard ends")
    assert run("pgrep", "-f", "barrelman run").strip() == ""
    assert CONFIGURATION.exists()
    assert (STATE / "console-tokens").exists()
    must("apt-get", "purge", "-y", "barrelman", "barrelman-media")
    for package in PACKAGES:
        assert "install ok" not in run("dpkg-query", "-W", "-f", "${Status}", package), package
        assert not pathlib.Path("/usr/bin", package).exists()
        assert not list(SHARE.glob(f"*/*/{package}.*")), package
    assert not CONFIGURATION.parent.exists()
    assert not (STATE / "console-tokens").exists()
    assert not (STATE / "console-authority.json").exists()
    assert list((STATE / "recordings").glob("run-*.mcap"))
    left = run("systemctl", "is-enabled", "barrelman").strip()
    assert left != "enabled", left


CHECKS = (
    without_a_video_it_says_what_to_configure,
    with_a_video_it_is_ready_and_its_page_answers,
    it_runs_as_its_own_user_with_few_rights,
    recordings_and_tokens_are_its_own,
    renewed_links_replace_those_of_the_token_file,
    on_all_addresses_it_speaks_https_with_an_authority_of_its_own,
    the_node_of_ros_2_explains_itself,
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
