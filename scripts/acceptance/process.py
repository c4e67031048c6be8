"""Child processes: start them, read their lines, give them a terminal, end them."""

import contextlib
import functools
import os
import pathlib
import pty
import re
import select
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Callable
from typing import Any, Self

from machine import PATIENCE_S, wait_until

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared"
# What a program needs to end, at the most.
ENDS_WITHIN = 30.0

Words = list[Any] | tuple[Any, ...]
Child = subprocess.Popen[str]


class HasEndedError(Exception):
    """A program has ended that should run: no standstill of the machine excuses that."""


# What ends each program that was started, in their order.
ends: list[Callable[[], object]] = []


def end_since(count: int) -> None:
    """Ends what is left of all but the first programs that were started."""
    while len(ends) > count:
        with contextlib.suppress(Exception):
            ends.pop()()


def environment() -> dict[str, str]:
    """The environment of a child: without the variables that make the program print backtraces and more log
    lines."""
    return {name: value for name, value in os.environ.items() if name not in ("RUST_BACKTRACE", "RUST_LOG")}


def spawn(command: Words, **keywords: Any) -> Child:
    """Starts a child, which reads nothing, whose output goes nowhere and whose errors are a pipe unless told
    otherwise."""
    streams = {
        "stdin": subprocess.DEVNULL,
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.PIPE,
        "env": environment(),
    }
    child = subprocess.Popen([str(word) for word in command], text=True, **{**streams, **keywords})
    ends.append(functools.partial(clear_away, child))
    return child


def clear_away(child: Child) -> None:
    """Ends what a test has left, by SIGTERM if it obeys: the guard of a killed program holds its port."""
    if child.poll() is None:
        child.send_signal(signal.SIGCONT)
        child.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(timeout=5)
        child.kill()
        child.wait(timeout=5)


def run(command: Words, timeout: float = 120, **keywords: Any) -> subprocess.CompletedProcess[str]:
    """Runs a command to its end; the result has standard output and standard error as text."""
    keywords.setdefault("env", environment())
    words = [str(word) for word in command]
    return subprocess.run(
        words,
        timeout=timeout,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
        **keywords,
    )


def end(child: Child, number: signal.Signals = signal.SIGTERM) -> int:
    """Ends a child by a signal, and gives its exit code."""
    if child.poll() is None:
        child.send_signal(signal.SIGCONT)
        child.send_signal(number)
    try:
        return child.wait(timeout=ENDS_WITHIN)
    except subprocess.TimeoutExpired:
        child.kill()
        raise


class Lines:
    """The lines that a child prints, with their times. A thread reads each line at once, so that the child
    never blocks."""

    def __init__(self, stream: Any) -> None:
        self.lines: list[tuple[float, str]] = []
        self._thread = threading.Thread(target=self._read, args=(stream or (),), daemon=True)
        self._thread.start()

    def _read(self, stream: Any) -> None:
        for line in stream:
            self.lines.append((time.monotonic(), line.rstrip("\n")))

    def find(self, pattern: str) -> tuple[float, str] | None:
        return next(((at, line) for at, line in list(self.lines) if re.search(pattern, line)), None)

    def wait_for(self, pattern: str, seconds: float = PATIENCE_S) -> tuple[float, str]:
        found: tuple[float, str] = wait_until(
            lambda: self.find(pattern),
            lambda: f"a line with {pattern!r} after {self.text()[-400:]!r}",
            seconds,
        )
        return found

    def count(self, text: str) -> int:
        return sum(text in line for _, line in list(self.lines))

    def text(self) -> str:
        return "\n".join(line for _, line in list(self.lines))

    def join(self) -> None:
        self._thread.join(timeout=5)


class Terminal:
    """A terminal for a program, whose output is read until the terminal is hung up: a terminal without a
    reader fills up."""

    def __init__(self) -> None:
        self.outside, self.inside = pty.openpty()
        self.is_read = True
        self.reader = threading.Thread(target=self._read, daemon=True)

    def start(self) -> None:
        """The program has its end of the terminal now."""
        os.close(self.inside)
        self.reader.start()

    def _read(self) -> None:
        while self.is_read:
            if select.select([self.outside], [], [], 0.02)[0]:
                try:
                    os.read(self.outside, 65536)
                except OSError:
                    # The other end has gone, which is told at once and for ever.
                    time.sleep(0.02)

    def type(self, key: bytes) -> float:
        at = time.monotonic()
        os.write(self.outside, key)
        return at

    def hang_up(self) -> float:
        """Closes the terminal once no read is under way, and returns the time of that. A closed one stays
        so."""
        at = time.monotonic()
        if self.is_read:
            self.is_read = False
            self.reader.join()
            at = time.monotonic()
            os.close(self.outside)
        return at

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.hang_up()


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def secret(path: pathlib.Path, *lines: str) -> pathlib.Path:
    """A file for its owner alone."""
    path.write_text("".join(f"{line}\n" for line in lines))
    path.chmod(0o600)
    return path


def memory_mb(child: Child, figure: str = "VmRSS") -> float:
    """Memory of a process, MB: what is resident now, or with `VmHWM` the most that ever was. Infinite after
    its end."""
    found = re.search(rf"{figure}:\s+(\d+)", pathlib.Path(f"/proc/{child.pid}/status").read_text())
    return int(found[1]) / 1024 if found else float("inf")


def stat(path: pathlib.Path | str) -> tuple[str, list[str]] | None:
    """Name and further fields, from the state on, of a process or thread in /proc; None if it is gone."""
    try:
        text = (pathlib.Path("/proc") / path / "stat").read_text()
    except OSError:
        return None
    return text[text.index("(") + 1 : text.rindex(")")], text[text.rindex(")") + 2 :].split()


def threads_of(child: Child) -> dict[str, float]:
    """CPU time of each thread of a process, in seconds, by the thread's name."""
    ticks = os.sysconf("SC_CLK_TCK")
    times: dict[str, float] = {}
    for task in pathlib.Path(f"/proc/{child.pid}/task").iterdir():
        if found := stat(task):
            name, fields = found
            times[name] = times.get(name, 0) + (int(fields[11]) + int(fields[12])) / ticks
    return times


def guards() -> dict[int, int]:
    """The guards of this machine, and the processes that started them."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        if (
            entry.name.isdigit()
            and (process := stat(entry.name))
            and process[0].startswith("barrelman-guard")
        ):
            found[int(entry.name)] = int(process[1][1])
    return found


def guards_of(pid: int) -> list[int]:
    """The guards that a process started."""
    return [guard for guard, parent in guards().items() if parent == pid]


def is_held_by_orphan(device: pathlib.Path) -> bool:
    """Whether a guard whose program has ended holds a port."""
    for guard, parent in guards().items():
        found = stat(str(parent))
        with contextlib.suppress(OSError):
            if (not found or found[0] != "barrelman") and any(
                fd.readlink() == device for fd in pathlib.Path(f"/proc/{guard}/fd").iterdir()
            ):
                return True
    return False


def is_alive(pid: int) -> bool:
    found = stat(str(pid))
    return found is not None and found[1][0] != "Z"
