"""Tests campaigns of simulated trials that are interrupted: killed, run in parts, and run on a full disk.

A campaign that is killed with SIGKILL and resumed, many times, gives the same bytes as an uninterrupted campaign. So
does a campaign that runs in three parts. A full disk ends a campaign with a message that names the file. The finished
trials are kept, and the campaign can be resumed. A limit on the size of files and /dev/full stand for the full disk.
Last come a few trials with the truth, and a trial of 20 s with rendered pictures.
"""
import json
import os
import random
import resource
import signal
import subprocess
import sys
import time

import common
from common import Table

SCENARIO = "lab1"
PIXEL_SECONDS = 20


class Bench:
    def __init__(self, args, folder, table):
        self.program, self.folder, self.table = args.barrelman, folder, table
        self.trials = args.trials

    def words(self, output, *more, trials=None, resume=False):
        words = [self.program, "trials", SCENARIO, "--perception", "truth", "--trials", trials or self.trials, "--output", output]
        return words + list(more) + (["--resume"] if resume else [])

    def run(self, *words, limit=None):
        """Runs a command to its end. `limit`: largest size of a file in bytes; a write beyond it fails."""

        def full():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        return common.run(words, timeout=600, preexec_fn=full if limit is not None else None)

    def refused(self, name, done, *named):
        """Requires exit code 1 and one message that names the file and the reason."""
        said = done.stderr.strip()
        faults = [f"nothing of {word!r} in the message" for word in named if word not in said]
        faults += [f"{word!r} in the message" for word in ("panicked", "RUST_BACKTRACE") if word in said]
        errors = sum(line.lstrip().startswith(("ERROR", "error:")) for line in said.splitlines())
        faults += [f"{errors} messages instead of one"] if errors != 1 else []
        faults += [f"exit {done.returncode} instead of 1"] if done.returncode != 1 else []
        self.table.require(name, not faults, f"exit {done.returncode}", "; ".join(faults))
        for line in said.splitlines():
            print(f"         | {line}")


def read(path):
    return path.read_bytes() if path.exists() else b""


def lines(content):
    """Number of complete lines."""
    return content.count(b"\n")


def first_difference(found, expected):
    if found == expected:
        return ""
    at = next((index for index, (a, b) in enumerate(zip(found, expected)) if a != b), min(len(found), len(expected)))
    return f"{len(found)} bytes, {len(expected)} expected; they part after {at}"


def kill_again_and_again(bench, expected, took, count, chance):
    path = bench.folder / "killed.jsonl"
    killed, cut, seen, faults = 0, 0, [], []
    for number in range(count):
        child = common.spawn(
            bench.words(path, "--threads", 2, resume=True), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        time.sleep(chance.uniform(0.0, 1.4 * took / count))
        child.send_signal(signal.SIGKILL)
        _, said = child.communicate()
        killed += child.returncode == -signal.SIGKILL
        if child.returncode not in (0, -signal.SIGKILL):
            faults.append(f"kill {number + 1}: exit {child.returncode}: {said[-200:]}")
        left = read(path)
        cut += bool(left) and not left.endswith(b"\n")
        seen.append(lines(left))
        if not expected.startswith(left):
            faults.append(f"kill {number + 1}: {first_difference(left, expected)}")
    bench.table.show("trials in the file after each kill", " ".join(map(str, seen)))
    bench.table.require(f"killed {killed} times of {count}: each left a beginning of the whole", not faults, f"{cut} cut lines", "; ".join(faults))
    bench.table.require("most kills came before it was done", killed >= 0.8 * count, f"{killed} of {count}")
    done = bench.run(*bench.words(path, "--threads", 2, resume=True))
    difference = first_difference(read(path), expected)
    bench.table.require("gone on with to the end: the same bytes", done.returncode == 0 and not difference, f"exit {done.returncode}", difference or done.stderr[-200:])


def in_parts(bench, expected, took, chance):
    parts = [bench.folder / f"part{part}.jsonl" for part in (1, 2, 3)]
    for number, path in enumerate(parts, 1):
        words = bench.words(path, "--threads", 2, "--shard", f"{number}/3", resume=True)
        child = common.spawn(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(0.0, took / 3))
        child.send_signal(signal.SIGKILL)
        child.wait()
        done = bench.run(*words)
        bench.table.require(f"part {number} of 3, killed and gone on with", done.returncode == 0, f"{lines(read(path))} trials", done.stderr[-200:])
    merged = bench.folder / "merged.jsonl"
    done = bench.run(bench.program, "merge", parts[2], parts[0], parts[1], "--output", merged)
    difference = first_difference(read(merged), expected)
    bench.table.require("the parts merged: the same bytes", done.returncode == 0 and not difference, f"exit {done.returncode}", difference or done.stderr[-200:])
    done = bench.run(bench.program, "merge", *parts, "--output", "/dev/full", "--force")
    bench.refused("merged onto a full disk", done, "/dev/full", "No space left")


def full_disk(bench, expected):
    path = bench.folder / "full.jsonl"
    limit = len(expected) * 2 // 5
    done = bench.run(*bench.words(path, "--threads", 2), limit=limit)
    bench.refused("a full disk under the results", done, str(path), "File too large")
    left = read(path)
    kept = lines(left)
    bench.table.require("  the finished trials are kept", expected.startswith(left) and kept == lines(expected[:limit]), f"{kept} trials", first_difference(left, expected[: len(left)]))
    done = bench.run(*bench.words(path, "--threads", 2, resume=True), limit=limit)
    bench.refused("  gone on with while it is still full", done, str(path), "File too large")
    done = bench.run(*bench.words(path, "--threads", 2, resume=True))
    difference = first_difference(read(path), expected)
    bench.table.require("  gone on with when there is room: the same bytes", done.returncode == 0 and not difference, "", difference or done.stderr[-200:])
    done = bench.run(*bench.words("/dev/full", "--threads", 2, "--force", trials=8))
    bench.refused("results to /dev/full", done, "/dev/full", "No space left")


def full_disk_under_recordings(bench, expected):
    count = 12
    folder, whole = bench.folder / "recorded", bench.folder / "whole.jsonl"
    done = bench.run(*bench.words(whole, "--threads", 1, "--record", folder, trials=count))
    bench.table.require("trials are recorded", done.returncode == 0 and len(list(folder.glob("*.mcap"))) == count, "", done.stderr[-200:])
    sizes = [os.path.getsize(folder / f"{SCENARIO}-{seed}.mcap") for seed in range(1, count + 1)]
    # A campaign that begins with the smallest recording of the first half: the limit lets that one pass, and those
    # after it until one is larger.
    begin = min(range(count // 2), key=lambda index: sizes[index])
    fails = next(index for index in range(begin + 1, count) if sizes[index] > max(sizes[begin:index]))
    name = f"{SCENARIO}-{fails + 1}.mcap"
    wanted = b"".join(read(whole).splitlines(keepends=True)[begin:])
    path, records = bench.folder / "recorded.jsonl", bench.folder / "records"
    words = bench.words(path, "--threads", 1, "--record", records, "--seed", begin + 1, trials=count - begin)
    done = bench.run(*words, limit=sizes[fails] - 1)
    bench.refused("a full disk under a recording", done, str(records / name), "File too large")
    left = read(path)
    bench.table.require("  the finished trials are kept", lines(left) == fails - begin and wanted.startswith(left), f"{lines(left)} of {fails - begin} trials")
    done = bench.run(*words, "--resume")
    same = all(read(records / f"{SCENARIO}-{seed}.mcap") == read(folder / f"{SCENARIO}-{seed}.mcap") for seed in range(begin + 1, count + 1))
    difference = first_difference(read(path), wanted)
    bench.table.require("  gone on with: the same results and recordings", done.returncode == 0 and not difference and same, "", difference or done.stderr[-200:])
    bench.table.require("  recording does not change a trial", expected.startswith(read(whole)))


def few_trials(bench):
    scenario = bench.run(bench.program, "scenarios", "arena1").stdout

    def lasting(name, seconds):
        shorter = [f"longest_s = {seconds}" if line.startswith("longest_s") else line for line in scenario.splitlines()]
        path = bench.folder / name
        path.write_text("\n".join(shorter) + "\n")
        return path

    path = lasting("short.toml", PIXEL_SECONDS)
    done = bench.run(bench.program, "trials", "arena1", "--perception", "truth", "--trials", 8, "--json")
    trials = json.loads(done.stdout)["trials"] if done.returncode == 0 else []
    bench.table.require("8 trials of arena1 with the truth", len(trials) == 8 and all(not trial["lost"] for trial in trials), f"{len(trials)} trials", done.stderr[-200:])
    began = time.monotonic()
    records = bench.folder / "pictures"
    done = bench.run(bench.program, "trials", path, "--trials", 1, "--size", "320x180", "--record", records, "--json")
    took = time.monotonic() - began
    trial = json.loads(done.stdout)["trials"][0] if done.returncode == 0 else {}
    holds = abs(trial.get("duration_s", 0) - PIXEL_SECONDS) < 1 and trial.get("lost") is False
    bench.table.require(f"one trial of {PIXEL_SECONDS} s in pictures of 320x180", holds, f"{trial.get('samples', 0)} rows in {took:.1f} s", done.stderr[-200:] if not holds else "")
    # The film is what becomes large.
    half = bench.folder / "half"
    done = bench.run(bench.program, "trials", lasting("shorter.toml", 3), "--trials", 1, "--size", "320x180", "--record", half, limit=20_000)
    bench.refused("  and on a full disk", done, str(half), "File too large")


def main():
    args = common.arguments(
        __doc__,
        trials={"type": int, "default": 400, "help": "how many trials the campaign has"},
        count={"type": int, "default": 20, "help": "how often it is killed"},
        seed={"type": int, "default": 1},
    )
    folder = common.temporary_folder()
    table = Table(f"A campaign of {args.trials} trials of {SCENARIO}")
    bench = Bench(args, folder, table)
    chance = random.Random(args.seed)
    whole = folder / "through.jsonl"
    began = time.monotonic()
    done = bench.run(*bench.words(whole, "--threads", 2))
    took = time.monotonic() - began
    expected = read(whole)
    table.require("it runs through", done.returncode == 0 and lines(expected) == args.trials, f"{took:.1f} s", done.stderr[-200:])
    kill_again_and_again(bench, expected, took, args.count, chance)
    in_parts(bench, expected, took, chance)
    full_disk(bench, expected)
    full_disk_under_recordings(bench, expected)
    few_trials(bench)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
