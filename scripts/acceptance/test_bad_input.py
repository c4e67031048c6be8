"""A new user's mistakes with videos, selections, logs and outputs: refused with the cause and the remedy."""

import pathlib
from collections.abc import Iterator

import pytest

from conftest import Clip
from refusals import CASE, NEEDS_ROOT, NOBODY, Bench, case, prepared, refused

HEADER = "x_val,y_val,pitch,yaw,val,time"
LOGGED = "-78,17,0,0,0.185109,0.000000,1493598415"
NO_VIDEO = "not a video\n" * 20
PRECIOUS = "precious\n"


VIDEOS = [
    case(
        "a missing file", "track nowhere.mp4 --select {selection}", "nowhere.mp4", "check the path|is there"
    ),
    case("a missing file, in run", "run --video file:nowhere.mp4", "nowhere.mp4", "check the path|is there"),
    case("a text file", "track notes.txt --select {selection}", "notes.txt", r"MP4|mp4", notes__txt=NO_VIDEO),
    case(
        "a text file that is called .mp4",
        "track notes.mp4 --select {selection}",
        "notes.mp4",
        r"MP4|mp4|ffmpeg",
        notes__mp4=NO_VIDEO,
    ),
    case(
        "an empty file", "track empty.mp4 --select {selection}", "empty.mp4", "empty|ends|no ", empty__mp4=""
    ),
    case("a folder without pictures", "track no-pictures --select {selection}", "no-pictures", "PNG|JPEG"),
    case("no source at all", "run", "--video", code=2),
    case("an unknown scheme", "run --video gopher://127.0.0.1/live", "gopher", "rtsp"),
]
SELECTIONS = [
    case("outside the picture", "track orange --select 900,10,40,40", "900,10,40,40", "320x240"),
    case(
        "outside the picture, in run",
        "run --video file:orange?fps=30 --select 900,10,40,40 --engage",
        "900,10,40,40",
        "320x240",
    ),
    case("of zero size", "track orange --select 10,10,0,20", "10,10,0,20", "width", code=2),
    case(
        "of zero size, in run", "run --video file:orange --select 10,10,20,0", "10,10,20,0", "height", code=2
    ),
    case("three numbers", "track orange --select 10,10,20", "10,10,20", "X,Y,W,H|four", code=2),
    case("words", "track orange --select left,top,w,h", "left", code=2),
    case("not a number", "track orange --select NaN,10,20,20", "NaN", code=2),
    # CamShift goes by hue alone; the fused tracker takes what is grey, too.
    case(
        "no saturated pixel",
        "track grey --select 10,10,40,40 --tracker camshift",
        "10,10,40,40",
        "satur|colour",
    ),
    case(
        "no saturated pixel, in run",
        "run --video file:grey?fps=30 --select 10,10,40,40 --engage --tracker camshift",
        "10,10,40,40",
        "satur|colour",
    ),
    case("start frame behind the end", "track orange --select 10,10,40,40 --start-frame 99", "99", "10"),
]
LOGS = [
    case("a missing file", "law nowhere.csv", "nowhere.csv", "check|path"),
    case(
        "a text file",
        "law letter.csv",
        "letter.csv",
        "x_val|laboratory|header",
        letter__csv="Dear Sir,\nI write to you\n",
    ),
    case("an empty file", "metrics empty.csv", "empty.csv", empty__csv=""),
    case(
        "a word for a number",
        "law word.csv",
        "word.csv",
        "line 3",
        word__csv=HEADER + "\n".join([LOGGED, LOGGED, "left,17,0,0,0.1,0,1493598415", LOGGED, LOGGED]) + "\n",
    ),
    case(
        "recording: a text file",
        "replay notes.mcap",
        "notes.mcap",
        "recording|MCAP",
        notes__mcap="not a recording\n",
    ),
    case(
        "recording: an empty file", "export nothing.mcap --output nothing", "nothing.mcap", nothing__mcap=""
    ),
    case("recording: a missing file", "replay nowhere.mcap", "nowhere.mcap", "check|path"),
]


@pytest.fixture(scope="module")
def bench(barrelman: pathlib.Path, clip: Clip) -> Iterator[Bench]:
    with prepared(barrelman, clip) as bench:
        yield bench


@pytest.mark.parametrize(CASE, VIDEOS)
def test_video_is_refused(
    bench: Bench, command: str, named: tuple[str, ...], code: int, files: dict[str, str]
) -> None:
    refused(bench, command, named, code, files)


@pytest.mark.parametrize(CASE, SELECTIONS)
def test_selection_is_refused(
    bench: Bench, command: str, named: tuple[str, ...], code: int, files: dict[str, str]
) -> None:
    refused(bench, command, named, code, files)


def test_selection_outside_the_picture_leaves_no_half_output(bench: Bench) -> None:
    bench.refuse("track orange --select 900,10,40,40 --output outside.csv", "900,10,40,40")
    assert not (bench.folder / "outside.csv").exists()


@pytest.mark.parametrize(CASE, LOGS)
def test_log_or_recording_is_refused(
    bench: Bench, command: str, named: tuple[str, ...], code: int, files: dict[str, str]
) -> None:
    refused(bench, command, named, code, files)


@pytest.mark.parametrize("command", ["law", "metrics"])
def test_log_that_is_cut_in_the_middle_of_a_row_is_read_up_to_there(bench: Bench, command: str) -> None:
    (bench.folder / "arena1_99.csv").write_text(HEADER + "\n".join([LOGGED] * 5) + "\n-77,14,0,0,0.17")
    out = bench.refuse(f"{command} arena1_99.csv", "arena1_99.csv", "line 6")
    assert len(out.splitlines()) == 6 if command == "law" else "arena1_99" in out


@pytest.mark.parametrize(
    ("command", "remedy"),
    [
        pytest.param("run --video file:clip.mp4 --record there.mp4", "--force", id="a recording"),
        pytest.param("run --video file:clip.mp4 --overlay there.mp4", "--force", id="an annotated video"),
        pytest.param("track orange --select 10,10,40,40 --output there.mp4", "--force", id="a track"),
        pytest.param("law whole.csv --output there.mp4", "--force", id="the law's rows"),
        pytest.param("emulate fotokite-pro --pty pty --log there.mp4", "--force", id="an emulator's log"),
        # --force would be the wrong advice: what is there is not ours.
        pytest.param("emulate fotokite-pro --pty there.mp4", "there", id="an emulator's port"),
    ],
)
def test_output_that_exists_is_refused_and_left_as_it_was(bench: Bench, command: str, remedy: str) -> None:
    # The name of a film, which every output may have.
    (bench.folder / "there.mp4").write_text(PRECIOUS)
    (bench.folder / "whole.csv").write_text(HEADER + LOGGED + "\n")
    bench.refuse(command, "there", remedy)
    assert (bench.folder / "there.mp4").read_text() == PRECIOUS


def test_output_in_a_folder_that_is_not_there_is_refused(bench: Bench) -> None:
    bench.refuse(
        "track orange --select 10,10,40,40 --output nowhere/track.csv",
        "nowhere/track.csv",
        "folder|check|make",
    )


@NEEDS_ROOT
def test_output_where_an_ordinary_user_may_not_write_is_refused(bench: Bench) -> None:
    (bench.folder / "locked").mkdir(mode=0o755)
    bench.refuse(
        "track orange --select 10,10,40,40 --output locked/track.csv",
        "locked/track.csv",
        "denied|may not|rights",
        user=NOBODY,
    )


@NEEDS_ROOT
def test_video_that_an_ordinary_user_may_not_read_is_refused(bench: Bench) -> None:
    (bench.folder / "unreadable.mp4").write_text(NO_VIDEO)
    (bench.folder / "unreadable.mp4").chmod(0o600)
    bench.refuse(
        "track unreadable.mp4 --select 10,10,40,40", "unreadable", "denied|may not|rights", user=NOBODY
    )
