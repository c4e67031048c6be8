"""Each command that an error recommends is run: it must exist, and give what the error promises."""

import pathlib
import re
import shlex
import shutil
from collections.abc import Iterator

import pytest

from conftest import Check, Clip
from process import run

ROOT = pathlib.Path(__file__).parents[2]
FFMPEG = re.compile(r"ffmpeg [^;`]*?\bOUT\.\w+")
OWN = re.compile(r"`barrelman ([^`]*)`")
# What the built-in engine refuses: the file, how it is made of the clip, and which printed command it needs.
REFUSED = [
    ("h264.mkv", "-c:v libx264", 0),
    ("h265.mkv", "-c:v libx265 -x265-params log-level=error", 1),
    ("h264.ts", "-c:v libx264", 0),
    ("h264.flv", "-c:v libx264", 0),
    ("mpeg4.avi", "-c:v mpeg4", 0),
    ("mpeg4.mp4", "-c:v mpeg4", 0),
    ("interlaced.mp4", "-c:v libx264 -flags +ildct+ilme -x264opts tff=1", 0),
    ("422.mp4", "-c:v libx264 -pix_fmt yuv422p", 0),
    ("10-bit.mp4", "-c:v libx264 -pix_fmt yuv420p10le", 0),
    ("raw.h264", "-c:v libx264", 0),
    ("interlaced.y4m", "-pix_fmt yuv420p -vf interlace", 0),
    ("16-bit.y4m", "-pix_fmt yuv420p16 -strict -1", 0),
    ("vp9.webm", "-c:v libvpx-vp9 -deadline realtime", 0),
    ("short.gif", "-r 5", 0),
]


@pytest.fixture(scope="module")
def alone(barrelman: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """The program without the one of the second engine beside it."""
    return pathlib.Path(shutil.copy(barrelman, tmp_path_factory.mktemp("alone") / "barrelman"))


@pytest.mark.parametrize(("name", "options", "index"), REFUSED, ids=[name for name, *_ in REFUSED])
def test_recommended_conversion_gives_a_video_that_is_read(
    alone: pathlib.Path,
    clip: Clip,
    tmp_path: pathlib.Path,
    check: Check,
    name: str,
    options: str,
    index: int,
) -> None:
    source = tmp_path / name
    made = run(["ffmpeg", "-v", "error", "-t", "1", "-i", clip.video, "-an", *shlex.split(options), source])
    assert made.returncode == 0, made.stderr
    refused = run([alone, "snapshot", source, "--output", tmp_path / "x.png"])
    commands = FFMPEG.findall(refused.stderr)
    check("it is refused with a command", refused.returncode == 1 and len(commands) > index, refused.stderr)
    command = commands[index]
    to = tmp_path / command.rsplit(" ", 1)[1]
    words = [str(source) if word == "IN" else word for word in shlex.split(command)[:-1]]
    converted = run([words[0], "-v", "error", *words[1:], to], timeout=120)
    check("the command runs", converted.returncode == 0, converted.stderr)
    read = run([alone, "snapshot", to, "--output", tmp_path / "y.png"])
    check("what it makes is read", read.returncode == 0, read.stderr)


def recommended() -> Iterator[tuple[str, str]]:
    """The program's own commands in the texts of the source, without comments, each with its file."""
    for path in sorted((ROOT / "crates").glob("*/src/**/*.rs")):
        lines = [line.strip() for line in path.read_text().splitlines()]
        # A text goes on after a backslash at the end of its line.
        text = "\n".join(line for line in lines if not line.startswith("//")).replace("\\\n", "")
        for command in OWN.findall(text):
            yield str(path.relative_to(ROOT)), command


def test_each_command_of_the_program_that_a_text_names_exists(barrelman: pathlib.Path, check: Check) -> None:
    helps: dict[str, str | None] = {}

    def help_of(command: str) -> str | None:
        if command not in helps:
            done = run([barrelman, *command.split(), "--help"])
            helps[command] = done.stdout if done.returncode == 0 else None
        return helps[command]

    named = list(recommended())
    check("texts name commands", len(named) >= 20, len(named))
    for path, command in named:
        words = command.split()
        name = words[0]
        # `config print`, `calibrate axes`: a command of two words.
        if len(words) > 1 and words[1].isalpha() and words[1].islower() and help_of(f"{name} {words[1]}"):
            name = f"{name} {words[1]}"
        text = help_of(name)
        check(f"{path}: {command}", text is not None)
        for option in re.findall(r"--[a-z][a-z-]*", command):
            check(f"{path}: {command}: {option}", option in (text or ""))
