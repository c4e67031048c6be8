"""A new user's mistakes in the configuration and with ports: refused with the cause and the remedy."""

import pathlib
from collections.abc import Iterator

import pytest

from conftest import Clip
from emulator import Emulator
from process import end, spawn
from refusals import CASE, NEEDS_ROOT, NOBODY, Bench, case, prepared, refused

CONFIGURATIONS = [
    case(
        "an unknown key",
        "run key.toml",
        "regoin_half_width",
        "key.toml",
        "region_half_width|expected",
        key__toml="[vehicle]\nregoin_half_width = 0.6\n",
    ),
    case(
        "an unknown table",
        "run table.toml",
        "vehicel",
        "table.toml",
        table__toml='[vehicel]\nprofile = "fotokite-pro"\n',
    ),
    case(
        "a value out of its range",
        "run range.toml",
        "region_half_width",
        "range.toml",
        "0.01|1",
        range__toml="[vehicle]\nregion_half_width = 7\n",
    ),
    case(
        "a word for a number",
        "run type.toml",
        "region_half_width|wide",
        "type.toml",
        type__toml='[vehicle]\nregion_half_width = "wide"\n',
    ),
    case(
        "not a number",
        "run nan.toml",
        "schema_pan_rad_per_s",
        "nan.toml",
        nan__toml="[vehicle]\nschema_pan_rad_per_s = nan\n",
    ),
    case(
        "an unknown word",
        "run word.toml",
        "yaw_sign|left",
        "opposite",
        "word.toml",
        word__toml='[vehicle]\nyaw_sign = "left"\n',
    ),
    case(
        "an unknown tracker",
        "run tracker.toml",
        "csrt",
        "fused",
        "camshift",
        "tracker.toml",
        tracker__toml='[tracker]\nname = "csrt"\n',
    ),
    case(
        "an unknown key of the tracker",
        "run fused.toml",
        "`coast`",
        "coast_s",
        "fused.toml",
        fused__toml="[tracker.fused]\ncoast = 0.4\n",
    ),
    case(
        "a tracker's value out of its range",
        "run coast.toml",
        r"tracker\.fused\.coast_s = 9",
        "0 to 2",
        "coast.toml",
        coast__toml="[tracker.fused]\ncoast_s = 9\n",
    ),
    case(
        "a tracker's value that is no number",
        "run padding.toml",
        r"tracker\.fused\.padding = NaN",
        "2.5 to 6",
        "padding.toml",
        padding__toml="[tracker.fused]\npadding = nan\n",
    ),
    case(
        "a tracker's count that is no count",
        "run confirm.toml",
        "1.5",
        "whole number",
        "confirm.toml",
        confirm__toml="[tracker.fused]\nconfirm = 1.5\n",
    ),
    case(
        "an unknown tracker, in track",
        "track clip.mp4 --select {selection} --tracker csrt",
        "csrt",
        "fused",
        "camshift",
        code=2,
    ),
    case(
        "an unknown tracker, in run",
        "run --video file:clip.mp4 --tracker csrt",
        "csrt",
        "fused",
        "camshift",
        code=2,
    ),
    case("an unknown tracker, in demo", "demo --tracker csrt", "csrt", "fused", "camshift", code=2),
    case("not TOML", "run broken.toml", "broken.toml", "line 1|1:", broken__toml="[vehicle\n"),
    case("a missing file", "run nowhere.toml", "nowhere.toml", "check|path|config example"),
    case(
        "an unknown profile",
        "run --video file:clip.mp4 --profile fotokite-amateur",
        "fotokite-amateur",
        "fotokite-pro",
    ),
    case(
        "an unknown profile, in law",
        "law nowhere.csv --profile fotokite-amateur",
        "fotokite-amateur",
        "fotokite-pro",
    ),
]
RUN = "run --video file:clip.mp4 --no-record --link"
PORTS = [
    case("a folder", f"{RUN} serial:{{folder}}", "barrelman-", "/dev/tty|--pty|ls "),
    case("a plain file", f"{RUN} serial:{{folder}}/plain", "plain", "/dev/tty|--pty|ls ", plain=""),
    case("a device that is no serial port", f"{RUN} serial:/dev/null", "/dev/null", "/dev/tty|--pty|ls "),
    case("an unknown scheme", f"{RUN} bluetooth:fotokite", "bluetooth", "serial:", "tcp:"),
    case("an impossible baud rate", f"{RUN} serial:/dev/ttyNOWHERE?baud=fast", "fast|baud"),
    case("an unknown option", f"{RUN} serial:/dev/ttyNOWHERE?speed=9600", "speed", "baud"),
    case("a misspelt fault", f"{RUN} serial:/dev/ttyNOWHERE?fault=explode@3", "explode", "stall"),
]


@pytest.fixture(scope="module")
def bench(barrelman: pathlib.Path, clip: Clip) -> Iterator[Bench]:
    with prepared(barrelman, clip) as bench:
        yield bench


@pytest.mark.parametrize(CASE, CONFIGURATIONS)
def test_configuration_is_refused(
    bench: Bench, command: str, named: tuple[str, ...], code: int, files: dict[str, str]
) -> None:
    refused(bench, command, named, code, files)


@pytest.mark.parametrize(CASE, PORTS)
def test_port_is_refused(
    bench: Bench, command: str, named: tuple[str, ...], code: int, files: dict[str, str]
) -> None:
    refused(bench, command, named, code, files)


@NEEDS_ROOT
def test_port_that_an_ordinary_user_may_not_open_is_refused(bench: Bench) -> None:
    with Emulator(bench.program, bench.folder, name="locked-port") as emulator:
        emulator.port.resolve().chmod(0o600)
        bench.refuse(f"{RUN} {emulator.url}", "locked-port", "dialout", user=NOBODY)


@pytest.mark.parametrize("user", [None, pytest.param(NOBODY, marks=NEEDS_ROOT)])
def test_port_that_is_taken_is_refused_and_stays_taken(bench: Bench, user: int | None) -> None:
    with Emulator(bench.program, bench.folder, name=f"taken-{user}") as emulator:
        emulator.port.resolve().chmod(0o666)
        holder = spawn([bench.program, *bench.words(f"{RUN} {emulator.url}")], cwd=bench.folder)
        emulator.wait_for(lambda row: row.is_heard, "the first line")
        bench.refuse(f"{RUN} {emulator.url}", "taken", "other|another|fuser|lsof", user=user)
        before = len(emulator.heard())
        emulator.wait_for(
            lambda row: row.is_heard and len(emulator.heard()) > before, "a further line of the holder"
        )
        assert holder.poll() is None
        end(holder)
