"""The first hour of a new user: every command that README, `--help` and the first screens of the documents
print.

The commands are taken from the texts and run as printed, in order, each text in an empty folder of its own.
Files that a text takes for granted (a clip, a log of the laboratory, a recording) are put there when a
command names them. A command must end with its exit code, must not panic, and must leave the files that it
names; what serves (`demo`, `run`, `emulate`) must print its address and end quietly on SIGINT; what asks for
a vehicle that is not there must fail and name it; what takes minutes must show its progress and stop on
SIGINT.
"""

import dataclasses
import functools
import itertools
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from typing import ClassVar

import pytest

from conftest import Check, program
from machine import wait_until
from process import ENDS_WITHIN, ROOT, SHARED, Child, Lines, environment, run, spawn

pytestmark = pytest.mark.apart

# The first screen of a document: what is read before anything is tried.
FIRST_SCREEN = 60
DOCUMENTS = ("console", "report", "simulation", "api", "law", "optimal-law", "tracking")
# Devices, addresses and consents that the tests do not have, and the words by which the program must name
# them.
ABSENT = {
    "camera.example": "camera.example",
    "sigma.example": "sigma.example",
    "/dev/ttyACM0": "/dev/ttyACM0",
    "--turn-the-camera": "not confirmed",
    "barrelman links": "/run/barrelman/links",
    "--link udp://127.0.0.1:14550": "nobody takes packets there",
}
# Options whose value is a file or a folder that the command writes.
WRITES = ("--output", "--truth", "--masks", "--overlay", "--svg", "--store", "--log", "--record")
# Commands that are not run: the set-up of the machine, and these tests.
LEFT_OUT = ("scripts/setup.sh", "scripts/test.sh", "scripts/package.sh")
# Commands that read the laboratory's logs, which a user's machine may not have.
READS_LOGS = re.compile(r"arena([12]_|\*)")
# Words that the standard output of a command must hold.
PROMISES = {
    "compare ": "trials in both",
    "trials ": "mean sensitivity",
    "metrics ": "mean sensitivity",
    "merge ": "mean sensitivity",
    "replay ": "bit for bit",
    "demo --replay": "bit for bit",
    "snapshot ": "--select",
    "render ": "frames",
    "config schema": "$schema",
    "config api": "openapi",
    "report ": ".html: ",
    "check ": "configuration",
    "track ": "mean confidence",
}
# Trials that would take longer than this are stopped once they have shown their progress, seconds.
PATIENCE = 300


def commands_of(text: str) -> list[str]:
    """The commands of a text: lines that begin with `barrelman` or a script, joined where a line ends with a
    backslash."""
    found: list[str] = []
    open_line: str | None = None
    for line in text.splitlines():
        line = line.strip()
        if open_line is not None:
            open_line = f"{open_line} {line}"
        elif re.match(r"(barrelman|scripts/)\b", line) and not re.match(
            r"barrelman \S+ (is|prints|writes|runs)\b", line
        ):
            open_line = line
        else:
            continue
        if open_line.endswith("\\"):
            open_line = open_line[:-1].rstrip()
        else:
            found.append(re.sub(r"\s+#.*", "", open_line).strip())
            open_line = None
    return found


def fenced(text: str) -> str:
    """The shell blocks of a document, and its indented blocks."""
    blocks = re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
    plain = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    return (
        "\n".join(blocks)
        + "\n"
        + "\n".join(line for line in plain.splitlines() if line.startswith("    barrelman"))
    )


def inline(text: str) -> list[str]:
    """The commands in the running text of a list, whole and without a placeholder."""
    bullets = "\n".join(line for line in text.splitlines() if line.startswith("- `barrelman"))
    found = re.findall(r"`(barrelman [^`]+)`", bullets)
    return [command for command in found if not re.search(r"\b[A-Z]{2,}\b", command)]


def kind_of(command: str) -> str:
    """How a command ends: `absent`, `serves`, `long`, or `ends`."""
    words = command.split()
    # A run waits for a serial vehicle, as it does for its video.
    waits = command.startswith("barrelman run") and "serial:" in command
    if any(name in command for name in ABSENT) and not waits:
        return "absent"
    if words == ["barrelman"] or (
        words[1] == "demo" and not {"--replay", "--clip", "--seconds"} & set(words)
    ):
        return "serves"
    if words[1] == "emulate" or (words[1] == "run" and "file:" not in command and ".toml" not in command):
        return "serves"
    trials = re.search(r"--trials (\d+)", command)
    in_pixels = words[1] == "trials" and "--perception truth" not in command and "--drive" not in command
    return "long" if in_pixels and (not trials or int(trials[1]) > 1) else "ends"


def files_of(command: str) -> list[str]:
    """The files that a command promises by its options."""
    paths = [value for option in WRITES for value in re.findall(rf"{option} (\S+)", command)]
    return paths + re.findall(r" > (\S+)$", command)


def examples(barrelman: pathlib.Path, words: list[str]) -> list[str]:
    """The examples of a command's help."""
    done = run([barrelman, *words, "--help"])
    start = re.search(r"^Examples?:\n", done.stdout, re.MULTILINE)
    return commands_of(done.stdout[start.end() :]) if start else []


def texts(barrelman: pathlib.Path) -> Iterator[tuple[str, list[str]]]:
    """Title and commands of each text, in the order in which a new user meets them."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    yield "README", commands_of(fenced(readme)) + inline(readme)
    yield "barrelman --help", examples(barrelman, [])
    listed = run([barrelman, "--help"]).stdout.split("Commands:\n")[1].split("\n\n")[0]
    for name in re.findall(r"^  ([a-z]\S*)", listed, re.MULTILINE):
        below = {
            "emulate": [["emulate", "fotokite-pro"]],
            "config": [["config"], *(["config", kind] for kind in ("example", "schema", "api", "print"))],
        }
        for words in below.get(name, [[name]]) if name != "help" else ():
            yield f"barrelman {' '.join(words)} --help", examples(barrelman, words)
    for name in DOCUMENTS:
        text = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
        yield f"docs/{name}.md", commands_of(fenced("\n".join(text.splitlines()[:FIRST_SCREEN])))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A command that only serves, or fails, is tried once, where it is met first."""
    found, seen = [], set()
    for title, commands in texts(program(metafunc.config)):
        ours = []
        for command in commands:
            is_met = (
                command in seen
                and kind_of(command) in ("serves", "absent")
                and not files_of(command)
                and not command.startswith("barrelman emulate")
            )
            if not command.startswith(LEFT_OUT) and not is_met:
                ours.append(command)
                seen.add(command)
        found.append(pytest.param(title, bool(commands), ours, id=title))
    metafunc.parametrize(("title", "has_examples", "commands"), found)


class Pantry:
    """What the texts take for granted, made once, by the commands that other texts print for it."""

    RECIPES: ClassVar = {
        "clip.mp4": "barrelman render arena1 --seed 7 --seconds 10 --size 640x360 "
        "--output clip.mp4 --truth truth.csv",
        "barrelman.toml": "barrelman config example "
        """| sed 's|^# url = "rtsp.*|url = "file:clip.mp4"|' > barrelman.toml""",
        "lab1.jsonl": "barrelman trials lab1 --perception truth --trials 5 --output lab1.jsonl",
        "mine.toml": "barrelman scenarios lab1 > mine.toml",
        "shard-1.jsonl": "barrelman trials lab1 --perception truth --trials 6 --shard 1/2 "
        "--output shard-1.jsonl",
        "drive.jsonl": "exec barrelman demo open --size 320x180 --seconds 4 --store drive.jsonl",
        "sortie.mcap": "barrelman demo open --seconds 5 --size 320x180 --record sortie.mcap",
    }

    def __init__(self, barrelman: pathlib.Path, folder: pathlib.Path) -> None:
        self.folder, self.logs = folder, sorted((SHARED / "data/trials").glob("arena*_*.csv"))
        (folder / "bin").mkdir()
        (folder / "bin/barrelman").symlink_to(barrelman)
        own = environment()
        self.environment = {**own, "PATH": f"{folder / 'bin'}:{own['PATH']}", "HOME": str(folder)}

    def shell(self, command: str, folder: pathlib.Path) -> Child:
        return spawn(
            ["bash", "-c", command],
            cwd=folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )

    def bring(self, command: str, folder: pathlib.Path) -> None:
        """Puts the files that a command reads, and that are not there, into the folder."""
        if READS_LOGS.search(command):
            for path in self.logs:
                shutil.copy(path, folder)
        written = {value for option in WRITES for value in re.findall(rf"{option} (\S+)", command)} | set(
            re.findall(r"> (\S+)", command)
        )
        needed = [
            name
            for name in self.RECIPES
            if name in command.replace("shard-*", "shard-1") and name not in written
        ]
        for name in ["clip.mp4", *needed] if "barrelman.toml" in needed else needed:
            if not (folder / name).exists():
                shutil.copy(self.made(name), folder / name)

    @functools.cache  # noqa: B019  (there is one pantry)
    def made(self, name: str) -> pathlib.Path:
        out, errors = self.shell(self.RECIPES[name], self.folder).communicate(timeout=PATIENCE)
        assert (self.folder / name).exists(), f"{name} could not be made: {out}{errors}"
        return self.folder / name


@pytest.fixture(scope="session")
def pantry(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> Pantry:
    return Pantry(barrelman, tmp_path_factory.mktemp("pantry"))


def programs_of(child: Child) -> list[int]:
    """The program itself where a shell runs it: a pipe or a redirection needs the shell."""
    return [int(pid) for pid in run(["pgrep", "-g", child.pid, "-x", "barrelman"]).stdout.split()] or [
        child.pid
    ]


def signal_to(child: Child, number: int) -> int:
    """Sends a signal to the program; the exit code."""
    for pid in programs_of(child):
        os.kill(pid, number)
    return child.wait(timeout=ENDS_WITHIN)


def faults(text: str) -> list[str]:
    return [word for word in ("panicked at", "RUST_BACKTRACE", "Debug {") if word in text]


@dataclasses.dataclass
class Reader:
    """Runs the commands of one text in a folder of their own. `behind`: the emulators that serve the next
    command."""

    check: Check
    pantry: Pantry
    folder: pathlib.Path
    behind: list[tuple[str, Child, Lines, Lines]] = dataclasses.field(default_factory=list)

    def follow(self, command: str, with_next: bool) -> None:
        self.pantry.bring(command, self.folder)
        kind = kind_of(command)
        child = self.pantry.shell(command, self.folder)
        if kind in ("absent", "ends"):
            problems = self.end(command, child, kind)
        else:
            lines, errors = Lines(child.stdout), Lines(child.stderr)
            if with_next:
                wait_until(lambda: lines.text() or errors.text(), "a line")
                self.behind.append((command, child, lines, errors))
                return
            problems = (
                self.serve(command, child, lines, errors)
                if kind == "serves"
                else self.show_progress(child, errors)
            )
        self.check(command, not problems, "; ".join(problems))

    def end(self, command: str, child: Child, kind: str) -> list[str]:
        """Waits for the end of a command. What is wrong with it."""
        out, errors = child.communicate(timeout=PATIENCE)
        problems = faults(out + errors)
        if kind == "absent":
            problems += [] if child.returncode == 1 else [f"exit {child.returncode}, 1 expected"]
            return problems + self.unnamed(command, out + errors)
        problems += (
            [] if child.returncode == 0 else [f"exit {child.returncode}: {(errors or out).strip()[-160:]}"]
        )
        problems += self.absent(command)
        promised = next(
            (words for start, words in PROMISES.items() if command.startswith(f"barrelman {start}")), ""
        )
        into = re.search(r" > (\S+)$", command)
        said = (
            (self.folder / into[1]).read_text(encoding="utf-8")
            if into
            else out
            if "|" in command
            else out + errors
        )
        return problems + (
            [] if promised in said or "--json" in command else [f"does not print {promised!r}"]
        )

    @staticmethod
    def unnamed(command: str, said: str) -> list[str]:
        """What is wrong where a command does not name the device or host that is absent."""
        named = [words for address, words in ABSENT.items() if address in command]
        return [] if not named or any(words in said for words in named) else [f"does not name {named}"]

    def absent(self, command: str) -> list[str]:
        """The files that a command promises and has not written."""
        paths = {name: self.folder / name for name in files_of(command)}

        def is_there(path: pathlib.Path) -> bool:
            return any(path.iterdir()) if path.is_dir() else path.is_file() and path.stat().st_size > 0

        return [f"{name} is not there" for name, path in paths.items() if not is_there(path)]

    def serve(self, command: str, child: Child, lines: Lines, errors: Lines) -> list[str]:
        wanted = r"http://" if "emulate" not in command else r"listens|ground station|/tmp/fotokite|pty"
        wait_until(
            lambda: re.search(wanted, lines.text() + errors.text()),
            lambda: f"the address of {command}: {lines.text()}{errors.text()}",
        )
        # A drive needs some ticks, and a run some pictures.
        time.sleep(3)
        problems = self.unnamed(command, lines.text() + errors.text())
        return problems + self.interrupted(child, lines, errors) + self.absent(command)

    @staticmethod
    def interrupted(child: Child, lines: Lines, errors: Lines) -> list[str]:
        code = signal_to(child, signal.SIGINT)
        lines.join()
        errors.join()
        return faults(lines.text() + errors.text()) + (
            [] if code == 0 else [f"exit {code} after SIGINT: {errors.text()[-160:]}"]
        )

    @staticmethod
    def show_progress(child: Child, errors: Lines) -> list[str]:
        errors.wait_for(r"\d+ of \d+ trials; [\d.]+ times real time, (at most|about) .* left")
        errors.wait_for("--perception truth")
        # Trials that run are finished: the promise is a quick end of the program, not of a trial.
        signal_to(child, signal.SIGKILL)
        return faults(errors.text())

    def close(self) -> None:
        for command, child, lines, errors in self.behind:
            problems = self.interrupted(child, lines, errors)
            self.check(
                f"{command} serves the next command, and ends on SIGINT", not problems, "; ".join(problems)
            )
        self.behind.clear()


def test_commands_run_as_printed(
    check: Check, pantry: Pantry, tmp_path: pathlib.Path, title: str, has_examples: bool, commands: list[str]
) -> None:
    assert has_examples or title.startswith("docs/")
    reader = Reader(check, pantry, tmp_path)
    for command, following in itertools.zip_longest(commands, commands[1:], fillvalue=""):
        if READS_LOGS.search(command) and not pantry.logs:
            continue
        is_emulator, is_run = command.startswith("barrelman emulate"), command.startswith("barrelman run")
        if not is_emulator and not is_run:
            reader.close()
        reader.follow(command, is_emulator and following.startswith("barrelman run"))
        if is_run:
            reader.close()
    reader.close()
