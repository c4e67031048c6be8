"""An emulated Fotokite Pro, and what it heard by its log. The log has CLOCK_MONOTONIC in `mono_ns`."""

import json
import pathlib
import re
import subprocess
import time
from collections.abc import Callable
from typing import Any, Self

from machine import PATIENCE_S, lost, poll, wait_until
from process import Child, Lines, end, is_held_by_orphan, spawn

# By how much a line may be read late, seconds: the emulator looks at its port every 10 ms at the least, and
# two cores are shared with the decoder.
LISTENING_JITTER = 0.015
# Zeros that are followed by a rate sooner are no rest.
REST_LASTS_S = 0.05


class Row:
    """A line of the log."""

    MOTION = re.compile(r"(Yaw|GimbalPitch|Gimbal) (.+)")

    def __init__(self, row: dict[str, Any]) -> None:
        self.at: float = row["mono_ns"] / 1e9
        self.is_heard = row["direction"] == "in"
        self.raw: str = row["raw"]
        self.station: str = row["state"]["station"]
        self.rates: tuple[float, float] = (row["state"]["yaw_rate"], row["state"]["pitch_rate"])
        match = self.MOTION.fullmatch(self.raw) if self.is_heard else None
        self.name = match[1] if match else None
        self.is_motion = match is not None
        self.moves = match is not None and any(float(value) for value in match[2].split(","))
        self.is_zero = self.is_motion and not self.moves


class Emulator:
    """The ground station, on a pseudo-terminal or behind TCP."""

    def __init__(
        self,
        barrelman: pathlib.Path,
        folder: pathlib.Path,
        *options: Any,
        name: str = "fotokite",
        is_tcp: bool = False,
        host: str = "127.0.0.1:0",
    ) -> None:
        self.port, self.log = folder / name, folder / f"{name}.jsonl"
        where = ["--listen", host] if is_tcp else ["--pty", self.port]
        command = [barrelman, "emulate", "fotokite-pro", *where, "--log", self.log, *options]
        self.child: Child = spawn(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.lines = Lines(self.child.stdout)
        answers_at = self.lines.wait_for("answers at")[1].split("answers at ")[1].strip()
        self.url = answers_at if is_tcp else f"serial:{self.port}"
        self._rest, self._rows, self._file = "", [], self.log.open()  # type: ignore[var-annotated]

    @property
    def video(self) -> str:
        """The address of the world's video."""
        return url_in(self.lines.wait_for("rtsp://")[1])

    def rows(self) -> list[Row]:
        """The rows of the log so far. Each look reads new text only."""
        *lines, self._rest = (self._rest + self._file.read()).split("\n")
        self._rows += [Row(json.loads(line)) for line in lines]
        return self._rows

    def heard(self) -> list[Row]:
        return [row for row in self.rows() if row.is_heard]

    def since(self, at: float) -> list[Row]:
        return [row for row in self.rows() if row.at >= at]

    def wait_for(
        self, condition: Callable[[Row], bool], what: str, since: float = 0.0, seconds: float = PATIENCE_S
    ) -> Row:
        """Waits for a row that fulfils the condition."""
        found: Row = wait_until(lambda: next(filter(condition, self.since(since)), None), what, seconds)
        return found

    def rates_at(self, at: float) -> tuple[float, float]:
        return next((row.rates for row in reversed(self.rows()) if row.at < at), (0.0, 0.0))

    def rest_at(self, at: float) -> float:
        """The time from `at` on at which both axes rest; infinite if they never do.

        A law that changes the axis rests one before it moves the other: that is no rest.
        """
        rows = self.since(at)
        moving = [row.at for row in rows if any(row.rates)]
        at_rest = (row.at for row in rows if not any(row.rates))
        return next(
            (rest for rest in at_rest if not any(rest <= move < rest + REST_LASTS_S for move in moving)),
            float("inf"),
        )

    def wait_until_it_moves(self) -> None:
        """Waits until a rate has been in force for a moment, and still is."""
        began = time.monotonic()
        while True:
            self.wait_for(lambda row: row.moves, "a rate", began)
            time.sleep(0.2)
            if any(self.rows()[-1].rates):
                return
            began = time.monotonic()

    def close(self) -> None:
        """Ends the emulator. The name of its pseudo-terminal is used again, so a guard at its end still is
        waited for."""
        device = self.port.resolve()
        poll(lambda: not is_held_by_orphan(device), PATIENCE_S)
        end(self.child)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def url_in(line: str) -> str:
    return next(word for word in line.split() if word.startswith("rtsp://")).rstrip(";")


def busiest_second(rows: list[Row]) -> int:
    """The largest number of lines with a rate other than zero that the ground station received within a
    second.

    The program sends such lines 50 ms apart, so exactly 20 in a second. The second is shortened by what may
    have made a line be read late, so that such a line does not count as the 21st.
    """
    moving = [row.at for row in rows if row.moves]
    return max(
        (
            sum(at <= other < at + 1 - LISTENING_JITTER - lost(at - 0.2, at + 1) for other in moving)
            for at in moving
        ),
        default=0,
    )
