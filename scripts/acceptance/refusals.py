"""What the tests of a user's mistakes share: each ends with one message that names the cause and the remedy.

Root may open every file, so cases that depend on permissions run as `nobody` where root runs the tests.
"""

import contextlib
import dataclasses
import os
import pathlib
import re
import shutil
import tempfile
from collections.abc import Iterator
from typing import Any

import cv2
import numpy
import pytest

from conftest import Clip
from process import ROOT, run

NOBODY = 65534
IS_ROOT = os.geteuid() == 0
NEEDS_ROOT = pytest.mark.skipif(not IS_ROOT, reason="only root can make what an ordinary user may not open")
FIXTURES = ROOT / "fixtures/video"


@dataclasses.dataclass
class Bench:
    """A folder with what the cases use. An ordinary user can reach it."""

    program: pathlib.Path
    folder: pathlib.Path
    selection: str

    def words(self, command: str) -> list[str]:
        """The words of a command. With a console, a refused selection does not end a run: the operator can
        select again."""
        words = [
            word.format(folder=self.folder, selection=self.selection, fixtures=FIXTURES)
            for word in command.split()
        ]
        return [words[0], "--headless", *words[1:]] if words[0] == "run" else words

    def refuse(self, command: str, *named: str, code: int = 1, user: int | None = None) -> str:
        """Requires that a command is refused. `named`: patterns in the message. Returns standard output."""
        keywords: dict[str, Any] = (
            {"user": user, "group": user, "extra_groups": []} if user is not None else {}
        )
        done = run([self.program, *self.words(command)], timeout=30, cwd=self.folder, **keywords)
        said = done.stderr.strip()
        assert done.returncode == code, said
        assert sum(bool(re.match(r"(ERROR|error:)", line.strip())) for line in said.splitlines()) == 1, (
            f"not one message: {said}"
        )
        for pattern in named:
            assert re.search(pattern, said), f"nothing of {pattern!r} in {said}"
        assert "panicked" not in said, said
        assert "RUST_BACKTRACE" not in said, said
        assert not any(re.search(r"(.{60,}).*\1", line) for line in said.splitlines()), (
            f"the same is said twice: {said}"
        )
        return done.stdout


@contextlib.contextmanager
def prepared(barrelman: pathlib.Path, clip: Clip) -> Iterator[Bench]:
    with tempfile.TemporaryDirectory(prefix="barrelman-") as name:
        folder = pathlib.Path(name)
        folder.chmod(0o777)
        program = barrelman
        if IS_ROOT:
            for path in (barrelman.with_name("barrelman-guard"), barrelman):
                program = pathlib.Path(shutil.copy(path, folder))
        shutil.copy(clip.video, folder / "clip.mp4")
        for colour, value in (("grey", (128, 128, 128)), ("orange", (20, 120, 240))):
            (folder / colour).mkdir()
            for frame in range(10):
                cv2.imwrite(
                    str(folder / colour / f"{frame}.png"), numpy.full((240, 320, 3), value, numpy.uint8)
                )
        (folder / "no-pictures").mkdir()
        yield Bench(program, folder, clip.selection)


def case(name: str, command: str, *named: str, code: int = 1, **files: str) -> Any:
    """`files`: what is put into the folder before, with __ for a full stop."""
    return pytest.param(
        command, named, code, {file.replace("__", "."): text for file, text in files.items()}, id=name
    )


def refused(bench: Bench, command: str, named: tuple[str, ...], code: int, files: dict[str, str]) -> None:
    for name, text in files.items():
        (bench.folder / name).write_text(text)
    bench.refuse(command, *named, code=code)


CASE = ("command", "named", "code", "files")
