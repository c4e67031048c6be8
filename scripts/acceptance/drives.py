"""A drive or a recording that is repeated."""

import pathlib

from conftest import Check
from process import run


def repeats(
    barrelman: pathlib.Path, check: Check, store: pathlib.Path | None, record: pathlib.Path | None
) -> None:
    """Checks that a stored drive runs again, and that a recording replays."""
    for name, words in (
        ("the drive runs again", ["demo", "--replay", store]),
        ("the recording replays", ["replay", record, "--compare"]),
    ):
        if None not in words:
            done = run([barrelman, *words], timeout=600)
            check(
                f"{name} bit for bit",
                done.returncode == 0 and "bit for bit" in done.stdout,
                (done.stdout or done.stderr)[:300],
            )
