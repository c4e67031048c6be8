"""The clock of the tests: when the machine stood still, waiting for a state, and judging a delay.

A shared machine makes processes wait for tens of milliseconds, which says nothing about the program. A delay
beyond its limit by no more than such standstills is therefore not judged: the test is skipped with the
reason. A wait for a state ends later by the standstills. Times are seconds of CLOCK_MONOTONIC.
"""

import bisect
import dataclasses
import math
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, Self

import pytest

LEAST_S = 0.005
# A process that sleeps for 2 ms is woken late while the machine stands still.
WATCH = """
import time
then = time.monotonic()
while True:
    time.sleep(0.002)
    now = time.monotonic()
    if now - then > %r:
        print(then, now, flush=True)
    then = now
"""
# The standstills of this time before and after show how long a process has to wait on this machine at
# present.
AROUND_S = 5.0
# The program takes a guard that says nothing for 180 ms for one that hangs. Where each of three processes and
# threads (the guard, the link, the pilot) has to wait so long, that happens, and whatever follows from it.
FREEZE_S = 0.06
# No state is waited for longer than this; what must come sooner is judged by its time. Work of low priority,
# a film say, takes minutes beside other tests.
PATIENCE_S = 240.0

_standstills: list[tuple[float, float]] = []


def watch() -> subprocess.Popen[str]:
    """Starts to note the standstills, until the process is killed."""
    watcher = subprocess.Popen([sys.executable, "-c", WATCH % LEAST_S], stdout=subprocess.PIPE, text=True)
    lines = watcher.stdout
    assert lines is not None

    def read() -> None:
        for line in lines:
            # The last line is cut off where the watcher is killed.
            if line.endswith("\n"):
                begin, end = map(float, line.split())
                _standstills.append((begin, end))

    threading.Thread(target=read, daemon=True).start()
    return watcher


def standstills(begin: float, end: float) -> list[float]:
    """How long the machine stood still each time between two moments."""
    first = bisect.bisect_left(_standstills, begin, key=lambda still: still[1])
    parts = [min(until, end) - max(since, begin) for since, until in _standstills[first:]]
    return [part for part in parts if part > 0]


def lost(begin: float, end: float, processes: int = 1) -> float:
    """The time between two moments for which the machine, not the program, is to blame.

    `processes`: how many processes and threads take turns from cause to effect. Each may have to wait as long
    as the watcher had to around that time.
    """
    if not math.isfinite(end):
        return 0.0
    # The watcher tells of a standstill once it is over.
    if time.monotonic() - end < LEAST_S:
        time.sleep(LEAST_S)
    return max(
        sum(standstills(begin, end)),
        processes * max(standstills(begin - AROUND_S, end + AROUND_S), default=0.0),
    )


def took(begin: float, end: float, processes: int = 1) -> float:
    """The time from a cause to its effect without the standstills of the machine."""
    return max(0.0, end - begin - lost(begin, end, processes))


NOT_JUDGED = "not judged: the machine stood still for"


@dataclasses.dataclass(frozen=True)
class Delay:
    """The time from a cause to its effect, and the part for which the machine may be to blame."""

    seconds: float
    lost: float

    @classmethod
    def between(cls, begin: float, end: float, processes: int = 1) -> Self:
        return cls(end - begin, lost(begin, end, processes))

    @classmethod
    def since(cls, begin: float, processes: int = 1) -> Self:
        return cls.between(begin, time.monotonic(), processes)

    def __str__(self) -> str:
        return f"{self.seconds:.2f} s" if self.seconds >= 1 else f"{self.seconds * 1e3:.0f} ms"

    def judge(self, limit: float) -> None:
        """Fails beyond a limit; skips where the machine may be to blame for what is beyond."""
        if self.seconds > limit >= self.seconds - self.lost:
            pytest.skip(f"{NOT_JUDGED} {self.lost * 1e3:.0f} ms ({self}, at most {limit:g} s)")
        assert self.seconds <= limit, f"{self}, at most {limit:g} s"


NEVER = Delay(math.inf, 0.0)


def poll(condition: Callable[[], Any], seconds: float, pause: float = 0.005) -> Any:
    """The value of a condition as soon as it holds, or its last one. Standstills prolong the wait."""
    begin = time.monotonic()
    while not (value := condition()):
        now = time.monotonic()
        if now - begin > seconds and now - begin - sum(standstills(begin, now)) > seconds:
            break
        time.sleep(pause)
    return value


def wait_until(
    condition: Callable[[], Any],
    what: str | Callable[[], str],
    seconds: float = PATIENCE_S,
    pause: float = 0.005,
) -> Any:
    """Waits until a condition holds, and returns its value."""
    value = poll(condition, seconds, pause)
    if not value:
        raise TimeoutError(f"{what if isinstance(what, str) else what()} did not come within {seconds:.0f} s")
    return value


def median(values: list[float]) -> float:
    return percentile(values, 0.5)


def percentile(values: list[float], share: float) -> float:
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else math.nan
