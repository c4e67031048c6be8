"""Tests the first hour of a new user: every command that README, `--help` and the first screens of the documents print.

The commands are taken from the texts and run as printed, in order, each text in an empty folder of its own. Files that a
text takes for granted (a clip, a log of the laboratory, a recording) are put there when a command names them. A command
must end with its exit code, must not panic, and must leave the files that it names; what serves (`demo`, `run`,
`emulate`) must print its address and end quietly on SIGINT; what asks for a vehicle that is not there must fail and name
it; what takes minutes must show its progress and stop on SIGINT.
"""
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import common
from common import Lines, Table

# The first screen of a document: what is read before anything is tried.
FIRST_SCREEN = 60
DOCUMENTS = ("console", "report", "simulation", "api", "law", "optimal-law", "tracking")
# Devices, addresses and consents that the script does not have, and the words by which the program must name them.
ABSENT = {
    "camera.example": "camera.example", "sigma.example": "sigma.example", "/dev/ttyACM0": "/dev/ttyACM0", "--turn-the-camera": "not confirmed",
    "--link udp://127.0.0.1:14550": "nobody takes packets there",
}
# Options whose value is a file or a folder that the command writes.
WRITES = ("--output", "--truth", "--masks", "--overlay", "--svg", "--store", "--log", "--record")
# Commands that are not run, each with its reason.
LEFT_OUT = {"scripts/setup.sh": "sets up the machine", "scripts/test.sh": "runs this script"}
# Commands that read the laboratory's logs, which a user's machine may not have.
READS_LOGS = re.compile(r"arena([12]_|\*)")
# Words that the standard output of a command must hold.
PROMISES = {
    "compare ": "trials in both", "trials ": "mean sensitivity", "metrics ": "mean sensitivity", "merge ": "mean sensitivity",
    "replay ": "bit for bit", "demo --replay": "bit for bit", "snapshot ": "--select", "render ": "frames",
    "config schema": "$schema", "config api": "openapi", "report ": "trials", "check ": "configuration", "track ": "mean confidence",
}
# Trials that would take longer than this are stopped once they have shown their progress, seconds.
PATIENCE = 240


def commands_of(text):
    """The commands of a text: lines that begin with `barrelman` or a script, joined where a line ends with a backslash."""
    found, open_line = [], None
    for line in text.splitlines():
        line = line.strip()
        if open_line is not None:
            open_line = f"{open_line} {line}"
        elif re.match(r"(barrelman|scripts/)\b", line) and not re.match(r"barrelman \S+ (is|prints|writes|runs)\b", line):
            open_line = line
        else:
            continue
        if open_line.endswith("\\"):
            open_line = open_line[:-1].rstrip()
        else:
            found.append(re.sub(r"\s+#.*", "", open_line).strip())
            open_line = None
    return found


def fenced(text):
    """The shell blocks of a document, and its indented blocks."""
    blocks = re.findall(r"```sh\n(.*?)```", text, re.S)
    plain = re.sub(r"```.*?```", "", text, flags=re.S)
    return "\n".join(blocks) + "\n" + "\n".join(line for line in plain.splitlines() if line.startswith("    barrelman"))


def inline(text):
    """The commands in the running text of a list, whole and without a placeholder."""
    bullets = "\n".join(line for line in text.splitlines() if line.startswith("- `barrelman"))
    found = re.findall(r"`(barrelman [^`]+)`", bullets)
    return [command for command in found if not re.search(r"\b[A-Z]{2,}\b", command)]


def examples(args, words):
    """The examples of a command's help."""
    done = common.run([args.barrelman, *words, "--help"])
    start = re.search(r"^Examples?:\n", done.stdout, re.M)
    return commands_of(done.stdout[start.end() :]) if start else []


def subcommands(args):
    listed = common.run([args.barrelman, "--help"]).stdout.split("Commands:\n")[1].split("\n\n")[0]
    return [line.split()[0] for line in listed.splitlines() if re.match(r"  [a-z]", line) and line.split()[0] != "help"]


class Pantry:
    """What the texts take for granted, made once, by the commands that other texts print for it."""

    def __init__(self, args, folder):
        self.args, self.folder = args, folder
        self.logs = common.shared("data", "trials")
        folder.mkdir()
        (folder / "bin").mkdir()
        (folder / "bin" / "barrelman").symlink_to(args.barrelman)
        self.environment = {**common.environment(), "PATH": f"{folder / 'bin'}:{common.environment()['PATH']}", "HOME": str(folder)}
        self.recipes = {
            "clip.mp4": "barrelman render arena1 --seed 7 --seconds 10 --size 640x360 --output clip.mp4 --truth truth.csv",
            "barrelman.toml": "barrelman config example | sed 's|^# url = \"rtsp.*|url = \"file:clip.mp4\"|' > barrelman.toml",
            "lab1.jsonl": "barrelman trials lab1 --perception truth --trials 5 --output lab1.jsonl",
            "mine.toml": "barrelman scenarios lab1 > mine.toml",
            "shard-1.jsonl": "barrelman trials lab1 --perception truth --trials 6 --shard 1/2 --output shard-1.jsonl",
            "drive.jsonl": None, "sortie.mcap": "barrelman demo open --seconds 5 --size 320x180 --record sortie.mcap",
        }

    def shell(self, command, folder, **keywords):
        return common.spawn(["bash", "-c", command], cwd=folder, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **keywords)

    def bring(self, command, folder):
        """Puts the files that a command reads, and that are not there, into the folder."""
        if READS_LOGS.search(command):
            for path in self.logs.glob("arena*_*.csv"):
                if not (folder / path.name).exists():
                    shutil.copy(path, folder)
        written = {value for option in WRITES for value in re.findall(rf"{option} (\S+)", command)} | set(re.findall(r"> (\S+)", command))
        needed = [name for name in self.recipes if name in command.replace("shard-*", "shard-1") and name not in written]
        if "barrelman.toml" in needed:
            needed.insert(0, "clip.mp4")
        for name in needed:
            if not (folder / name).exists():
                shutil.copy(self.made(name), folder / name)

    def made(self, name):
        path = self.folder / name
        if path.exists():
            return path
        if name == "drive.jsonl":
            child = self.shell("exec barrelman demo open --size 320x180 --seconds 4 --store drive.jsonl", self.folder)
        else:
            child = self.shell(self.recipes[name], self.folder)
        out, err = child.communicate(timeout=PATIENCE)
        if not path.exists():
            raise RuntimeError(f"{name} could not be made: {out}{err}")
        return path


def kind_of(command):
    """How a command ends: `absent`, `serves`, `long`, or `ends`."""
    words = command.split()
    if any(name in command for name in ABSENT):
        return "absent"
    if words == ["barrelman"] or (words[1] == "demo" and not {"--replay", "--clip", "--seconds"} & set(words)):
        return "serves"
    if words[1] == "emulate" or (words[1] == "run" and "file:" not in command and ".toml" not in command):
        return "serves"
    trials = re.search(r"--trials (\d+)", command)
    in_pixels = words[1] == "trials" and "--perception truth" not in command and "--drive" not in command
    return "long" if in_pixels and (not trials or int(trials[1]) > 1) else "ends"


def files_of(command):
    """The files that a command promises by its options."""
    paths = [value for option in WRITES for value in re.findall(rf"{option} (\S+)", command)]
    return paths + re.findall(r" > (\S+)$", command)


def interrupt(child, lines, errors):
    """Sends SIGINT to the program; the exit code."""
    pids = common.run(["pgrep", "-g", str(child.pid), "-x", "barrelman"]).stdout.split()
    for pid in pids or [child.pid]:
        subprocess.run(["kill", "-INT", str(pid)], check=False)
    code = child.wait(timeout=30)
    lines.join()
    errors.join()
    return code


class Reader:
    """Runs the commands of one text in a folder of their own."""

    def __init__(self, table, pantry, title, folder):
        self.table, self.pantry, self.title, self.folder = table, pantry, title, folder
        folder.mkdir()
        self.behind = []
        print(f"\n{title}", flush=True)

    def require(self, command, problems, shown=""):
        self.table.require(command if len(command) <= 96 else f"{command[:93]}...", not problems, "; ".join(problems) or shown)

    def follow(self, command, with_next):
        self.pantry.bring(command, self.folder)
        kind = kind_of(command)
        began = time.monotonic()
        # `exec`: the program itself gets the signal. A pipe or a redirection needs the shell.
        child = self.pantry.shell(command, self.folder)
        if kind == "serves" and not with_next:
            self.serve(command, child)
        elif kind == "serves":
            lines, errors = Lines(child.stdout), Lines(child.stderr)
            common.wait_until(lambda: lines.text() or errors.text(), 20, "a line")
            self.behind.append((command, child, lines, errors))
        elif kind == "long":
            self.show_progress(command, child)
        else:
            self.end(command, child, kind, began)

    def end(self, command, child, kind, began):
        try:
            out, err = child.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            child.kill()
            return self.require(command, [f"did not end within {PATIENCE} s"])
        problems = self.faults(out + err)
        if kind == "absent":
            named = [words for address, words in ABSENT.items() if address in command]
            problems += [] if child.returncode == 1 else [f"exit {child.returncode}, 1 expected"]
            problems += [] if any(word in out + err for word in named) else [f"does not name {named}"]
        else:
            problems += [] if child.returncode == 0 else [f"exit {child.returncode}: {(err or out).strip()[-160:]}"]
            problems += [f"{path} is not there" for path in files_of(command) if not self.is_there(path)]
            promised = next((words for start, words in PROMISES.items() if command.startswith(f"barrelman {start}")), "")
            where = self.text_of(command, out) if re.search(r"[|>]", command) else out + err
            problems += [] if promised in where or "--json" in command else [f"does not print {promised!r}"]
        self.require(command, problems, f"{time.monotonic() - began:.1f} s")

    def text_of(self, command, out):
        path = re.search(r" > (\S+)$", command)
        return (self.folder / path[1]).read_text(encoding="utf-8") if path else out

    def is_there(self, path):
        path = self.folder / path if not path.startswith("/") else pathlib.Path(path)
        return path.is_dir() and any(path.iterdir()) or path.is_file() and path.stat().st_size > 0

    def faults(self, text):
        return [word for word in ("panicked at", "RUST_BACKTRACE", "Debug {") if word in text]

    def serve(self, command, child):
        lines, errors = Lines(child.stdout), Lines(child.stderr)
        problems = []
        wanted = r"http://" if "emulate" not in command else r"listens|ground station|/tmp/fotokite|pty"
        try:
            common.wait_until(lambda: re.search(wanted, lines.text() + errors.text()), 30, "the address")
            # A drive needs some ticks, and a run some pictures.
            time.sleep(3)
        except TimeoutError:
            problems.append(f"printed no address: {(lines.text() + errors.text())[-160:]}")
        code = interrupt(child, lines, errors)
        problems += self.faults(lines.text() + errors.text())
        problems += [] if code == 0 else [f"exit {code} after SIGINT: {errors.text()[-160:]}"]
        problems += [f"{path} is not there" for path in files_of(command) if not self.is_there(path)]
        self.require(command, problems, "serves, and ends on SIGINT")

    def show_progress(self, command, child):
        lines, errors = Lines(child.stdout), Lines(child.stderr)
        problems = []
        try:
            errors.wait_for(r"\d+ of \d+ trials; [\d.]+ times real time, (at most|about) .* left", 60)
            errors.wait_for("--perception truth", 1)
        except TimeoutError as error:
            problems.append(str(error))
        # Trials that run are finished: the promise is a quick end of the program, not of a trial.
        child.send_signal(signal.SIGKILL)
        for pid in common.run(["pgrep", "-g", str(child.pid), "-x", "barrelman"]).stdout.split():
            subprocess.run(["kill", "-KILL", pid], check=False)
        child.wait(timeout=30)
        self.require(command, problems + self.faults(errors.text()), "shows its speed and the time left")

    def close(self):
        for command, child, lines, errors in self.behind:
            code = interrupt(child, lines, errors)
            problems = self.faults(lines.text() + errors.text()) + ([] if code == 0 else [f"exit {code} after SIGINT"])
            self.require(command, problems, "serves the next command, and ends on SIGINT")
        self.behind.clear()


def texts(args):
    """Title and commands of each text, in the order in which a new user meets them."""
    readme = (common.ROOT / "README.md").read_text(encoding="utf-8")
    yield "README", commands_of(fenced(readme)) + inline(readme)
    yield "barrelman --help", examples(args, [])
    for name in subcommands(args):
        below = {"emulate": [["emulate", "fotokite-pro"]], "config": [["config"], *(["config", kind] for kind in ("example", "schema", "api", "print"))]}
        for words in below.get(name, [[name]]):
            yield f"barrelman {' '.join(words)} --help", examples(args, words)
    for name in DOCUMENTS:
        text = (common.ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
        yield f"docs/{name}.md", commands_of(fenced("\n".join(text.splitlines()[:FIRST_SCREEN])))


def main():
    args = common.arguments(__doc__, only={"metavar": "WORD", "help": "only the texts whose title holds this word"})
    table = Table("The first hour: what the texts print, as printed")
    folder = common.temporary_folder()
    pantry = Pantry(args, folder / "pantry")
    seen = set()
    for number, (title, commands) in enumerate(texts(args)):
        if args.only and args.only not in title:
            continue
        table.require(f"{title} has examples", bool(commands) or title.startswith("docs/"), f"{len(commands)} commands")
        reader = Reader(table, pantry, title, folder / str(number))
        for index, command in enumerate(commands):
            reason = next((reason for start, reason in LEFT_OUT.items() if command.startswith(start)), None)
            if READS_LOGS.search(command) and not pantry.logs:
                reason = "the laboratory's logs are not there"
            following = commands[index + 1] if index + 1 < len(commands) else ""
            is_emulator = command.startswith("barrelman emulate")
            if reason:
                table.show(command, f"left out: {reason}")
            elif command in seen and kind_of(command) in ("serves", "absent") and not files_of(command) and not is_emulator:
                continue
            else:
                if not is_emulator and not command.startswith("barrelman run"):
                    reader.close()
                reader.follow(command, is_emulator and following.startswith("barrelman run"))
                if command.startswith("barrelman run"):
                    reader.close()
                seen.add(command)
        reader.close()
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
