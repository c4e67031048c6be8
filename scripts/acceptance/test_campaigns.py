"""Campaigns of simulated trials that are interrupted: killed, run in parts, and run on a full disk.

A campaign that is killed with SIGKILL and resumed, many times, gives the same bytes as an uninterrupted
campaign. So does a campaign that runs in three parts. A full disk ends a campaign with a message that names
the file. The finished trials are kept, and the campaign can be resumed. A limit on the size of files and
/dev/full stand for the full disk.
"""

import dataclasses
import functools
import json
import pathlib
import random
import resource
import signal
import subprocess
import time
from typing import Any

import pytest

from conftest import Check
from process import run, spawn

SCENARIO = "lab1"
KILLS = 20
PIXEL_SECONDS = 20
RECORDED = 12

Done = subprocess.CompletedProcess[str]


@dataclasses.dataclass
class Campaign:
    """A campaign of `trials` trials, and what it gives uninterrupted, in `took` seconds."""

    barrelman: pathlib.Path
    trials: int
    chance: random.Random
    expected: bytes = b""
    took: float = 0.0

    def words(self, output: pathlib.Path | str, *more: Any, trials: int = 0, threads: int = 2) -> list[Any]:
        perception = ["--perception", "truth", "--trials", trials or self.trials, "--threads", threads]
        return [self.barrelman, "trials", SCENARIO, *perception, "--output", output, *more]


def run_on(limit: int | None, words: list[Any]) -> Done:
    """Runs a command to its end. `limit`: largest size of a file in bytes; a write beyond it fails."""

    def full() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit or 0, limit or 0))

    return run(words, timeout=600, preexec_fn=full if limit is not None else None)


def is_refused(done: Done, path: Any, reason: str) -> bool:
    """Whether a command has ended with exit code 1 and one message that names the file and the reason."""
    said = done.stderr.strip()
    errors = sum(line.lstrip().startswith(("ERROR", "error:")) for line in said.splitlines())
    return (
        done.returncode == 1
        and errors == 1
        and str(path) in said
        and reason in said
        and "panicked" not in said
        and "RUST_BACKTRACE" not in said
    )


def read(path: pathlib.Path) -> bytes:
    return path.read_bytes() if path.exists() else b""


@functools.cache
def uninterrupted(barrelman: pathlib.Path, trials: int, folder: pathlib.Path) -> Campaign:
    campaign = Campaign(barrelman, trials, random.Random(1))
    whole = folder / f"through-{trials}.jsonl"
    began = time.monotonic()
    done = run(campaign.words(whole), timeout=600)
    assert done.returncode == 0, done.stderr
    campaign.took, campaign.expected = time.monotonic() - began, read(whole)
    assert campaign.expected.count(b"\n") == trials
    return campaign


@pytest.fixture(
    scope="module",
    params=[100, pytest.param(400, marks=pytest.mark.long)],
    ids=lambda trials: f"{trials} trials",
)
def campaign(
    barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> Campaign:
    return uninterrupted(barrelman, request.param, tmp_path_factory.mktemp("campaign"))


def test_campaign_that_is_killed_again_and_again_gives_the_same_bytes(
    campaign: Campaign, tmp_path: pathlib.Path, check: Check
) -> None:
    path, killed = tmp_path / "killed.jsonl", 0
    for number in range(KILLS):
        child = spawn(campaign.words(path, "--resume"))
        time.sleep(campaign.chance.uniform(0.0, 1.4 * campaign.took / KILLS))
        child.kill()
        said = child.communicate()[1]
        killed += child.returncode == -signal.SIGKILL
        assert child.returncode in (0, -signal.SIGKILL), f"kill {number + 1}: {said[-200:]}"
        assert campaign.expected.startswith(read(path)), f"kill {number + 1} left other bytes"
    check("most kills came before it was done", killed >= 0.8 * KILLS, f"{killed} of {KILLS}")
    done = run(campaign.words(path, "--resume"), timeout=600)
    check("it is resumed to the end", done.returncode == 0, done.stderr[-200:])
    check("the bytes are the same", read(path) == campaign.expected)


def test_campaign_in_three_parts_gives_the_same_bytes(
    campaign: Campaign, tmp_path: pathlib.Path, check: Check
) -> None:
    parts = [tmp_path / f"part{part}.jsonl" for part in (1, 2, 3)]
    for number, path in enumerate(parts, 1):
        words = campaign.words(path, "--shard", f"{number}/3", "--resume")
        child = spawn(words, stderr=subprocess.DEVNULL)
        time.sleep(campaign.chance.uniform(0.0, campaign.took / 3))
        child.kill()
        child.wait()
        done = run(words, timeout=600)
        check(f"part {number} is killed and resumed", done.returncode == 0, done.stderr[-200:])
    merged = tmp_path / "merged.jsonl"
    done = run([campaign.barrelman, "merge", parts[2], parts[0], parts[1], "--output", merged])
    check(
        "the parts are merged to the same bytes",
        done.returncode == 0 and read(merged) == campaign.expected,
        done.stderr[-200:],
    )
    done = run([campaign.barrelman, "merge", *parts, "--output", "/dev/full", "--force"])
    check(
        "a full disk under the merged results is named",
        is_refused(done, "/dev/full", "No space left"),
        done.stderr,
    )


def test_full_disk_under_results_ends_a_campaign_that_can_be_resumed(
    campaign: Campaign, tmp_path: pathlib.Path, check: Check
) -> None:
    path, limit = tmp_path / "full.jsonl", len(campaign.expected) * 2 // 5
    done = run_on(limit, campaign.words(path))
    check("the file is named", is_refused(done, path, "File too large"), done.stderr)
    left = read(path)
    is_kept = campaign.expected.startswith(left) and left.count(b"\n") == campaign.expected[:limit].count(
        b"\n"
    )
    check("the finished trials are kept", is_kept, f"{len(left)} bytes")
    done = run_on(limit, campaign.words(path, "--resume"))
    check(
        "and named again while the disk is still full", is_refused(done, path, "File too large"), done.stderr
    )
    done = run(campaign.words(path, "--resume"), timeout=600)
    check(
        "resumed when there is room: the same bytes",
        done.returncode == 0 and read(path) == campaign.expected,
        done.stderr[-200:],
    )


def test_full_disk_under_recordings_ends_a_campaign_that_can_be_resumed(
    campaign: Campaign, tmp_path: pathlib.Path, check: Check
) -> None:
    folder, whole = tmp_path / "recorded", tmp_path / "whole.jsonl"
    done = run(campaign.words(whole, "--record", folder, trials=RECORDED, threads=1), timeout=600)
    check(
        "trials are recorded",
        done.returncode == 0 and len(list(folder.glob("*.mcap"))) == RECORDED,
        done.stderr[-200:],
    )
    check("recording does not change a trial", campaign.expected.startswith(read(whole)))
    names = [f"{SCENARIO}-{seed}.mcap" for seed in range(1, RECORDED + 1)]
    sizes = [(folder / name).stat().st_size for name in names]
    # A campaign that begins with the smallest recording of the first half: the limit lets that one pass, and
    # those after it until one is larger.
    begin = min(range(RECORDED // 2), key=lambda index: sizes[index])
    fails = next(index for index in range(begin + 1, RECORDED) if sizes[index] > max(sizes[begin:index]))
    wanted = b"".join(read(whole).splitlines(keepends=True)[begin:])
    path, records = tmp_path / "recorded.jsonl", tmp_path / "records"
    words = campaign.words(path, "--record", records, "--seed", begin + 1, trials=RECORDED - begin, threads=1)
    done = run_on(sizes[fails] - 1, words)
    check("the recording is named", is_refused(done, records / names[fails], "File too large"), done.stderr)
    left = read(path)
    check(
        "the finished trials are kept",
        left.count(b"\n") == fails - begin and wanted.startswith(left),
        f"{len(left)} bytes",
    )
    done = run([*words, "--resume"], timeout=600)
    check("resumed: the same results", done.returncode == 0 and read(path) == wanted, done.stderr[-200:])
    check(
        "and the same recordings", all(read(records / name) == read(folder / name) for name in names[begin:])
    )


@pytest.mark.apart
def test_results_to_a_full_device_are_refused(barrelman: pathlib.Path) -> None:
    done = run(Campaign(barrelman, 8, random.Random(1)).words("/dev/full", "--force"))
    assert is_refused(done, "/dev/full", "No space left"), done.stderr


@pytest.mark.apart
def test_8_trials_with_the_truth_lose_no_boat(barrelman: pathlib.Path) -> None:
    done = run([barrelman, "trials", "arena1", "--perception", "truth", "--trials", 8, "--json"])
    assert done.returncode == 0, done.stderr
    assert [trial["lost"] for trial in json.loads(done.stdout)["trials"]] == [False] * 8


def lasting(barrelman: pathlib.Path, folder: pathlib.Path, seconds: int) -> pathlib.Path:
    """A scenario that ends after some seconds."""
    lines = run([barrelman, "scenarios", "arena1"]).stdout.splitlines()
    path = folder / "short.toml"
    path.write_text(
        "\n".join(f"longest_s = {seconds}" if line.startswith("longest_s") else line for line in lines) + "\n"
    )
    return path


@pytest.mark.apart
def test_trial_in_pictures_lasts_as_long_as_its_scenario(
    barrelman: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    path = lasting(barrelman, tmp_path, PIXEL_SECONDS)
    done = run(
        [
            barrelman,
            "trials",
            path,
            "--trials",
            1,
            "--size",
            "320x180",
            "--record",
            tmp_path / "pictures",
            "--json",
        ],
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    [trial] = json.loads(done.stdout)["trials"]
    assert trial["duration_s"] == pytest.approx(PIXEL_SECONDS, abs=1)
    assert trial["lost"] is False


@pytest.mark.apart
def test_full_disk_under_the_film_of_a_trial_is_named(
    barrelman: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    words = [
        barrelman,
        "trials",
        lasting(barrelman, tmp_path, 3),
        "--trials",
        1,
        "--size",
        "320x180",
        "--record",
        tmp_path / "half",
    ]
    assert is_refused(run_on(20_000, words), tmp_path / "half", "File too large")
