"""What the acceptance tests share: the program, the practice clip, the machine's standstills, and checks
within a test."""

import csv
import dataclasses
import fcntl
import os
import pathlib
import re
import shutil
import time
from collections.abc import Callable, Generator, Iterator
from typing import Any

import pytest

import machine
import process

# When each test, or its module, began, and which tests failed.
_began: dict[str, float] = {}
_failed: set[str] = set()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("barrelman")
    group.addoption(
        "--barrelman",
        type=pathlib.Path,
        default=process.ROOT / "target/release/barrelman",
        help="the program",
    )
    group.addoption(
        "--clip",
        type=pathlib.Path,
        metavar="DIR",
        help="where the practice clip is, or is kept for the next call",
    )
    group.addoption("--figures", action="store_true", help="print what was measured")
    group.addoption("--screenshots", type=pathlib.Path, metavar="DIR", help="keep pictures of the page here")


def program(config: pytest.Config) -> pathlib.Path:
    path: pathlib.Path = config.getoption("--barrelman").resolve()
    if not os.access(path, os.X_OK):
        raise pytest.UsageError(f"{path} is not there: cargo build --release, or give --barrelman PATH")
    return path


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A failure against the clock is not judged after a standstill that is long enough to cause it.

    A program that has ended, or that no longer listens, is a failure all the same.
    """
    report = yield
    now = time.monotonic()
    clocked = item.get_closest_marker("clocked")
    where = item.nodeid.partition("::")[0] if clocked and "module" in clocked.args else item.nodeid
    began = _began.setdefault(where, now - (time.time() - call.start))
    if not report.failed or call.excinfo is None:
        return report
    _failed.add(item.nodeid)
    longest = max(machine.standstills(began, now), default=0.0)
    may_be_excused = not isinstance(call.excinfo.value, ConnectionError | process.HasEndedError)
    if clocked and may_be_excused and longest >= machine.FREEZE_S:
        report.outcome = "skipped"
        failure = str(call.excinfo.value).partition("\n")[0][:160]
        lines = [entry.lineno + 1 for entry in call.excinfo.traceback if entry.path == item.path]
        place = f"line {lines[-1]}: " if lines else ""
        reason = f"Skipped: {machine.NOT_JUDGED} {longest * 1e3:.0f} ms ({place}{failure})"
        report.longrepr = (str(item.path), lines[-1] if lines else 0, reason)
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The tests of a module share runs and stay together. Those that are marked stand apart, or their class
    does."""
    for item in items:
        module, _, rest = item.nodeid.partition("::")
        if not item.get_closest_marker("apart"):
            item.add_marker(pytest.mark.xdist_group(module))
        elif isinstance(item.parent, pytest.Class):
            item.add_marker(pytest.mark.xdist_group(f"{module}::{rest.partition('::')[0]}"))


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    reports = [
        report
        for found in terminalreporter.stats.values()
        for report in found
        if isinstance(report, pytest.TestReport)
    ]
    passed_over = [
        report for report in reports if report.skipped and machine.NOT_JUDGED in str(report.longrepr)
    ]
    if passed_over:
        terminalreporter.section(f"{len(passed_over)} not judged")
        for report in passed_over:
            reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
            terminalreporter.line(f"{report.head_line}: {str(reason).removeprefix('Skipped: ')}")
    if config.getoption("--figures"):
        terminalreporter.section("figures")
        for report in terminalreporter.getreports("passed") + terminalreporter.getreports("failed"):
            for name, value in report.user_properties if report.when == "call" else ():
                terminalreporter.line(f"{report.nodeid.rpartition('::')[2]}: {name}: {value}")


@pytest.fixture(scope="session")
def barrelman(pytestconfig: pytest.Config) -> pathlib.Path:
    return program(pytestconfig)


@pytest.fixture(scope="session", autouse=True)
def standstills() -> Iterator[None]:
    watcher = machine.watch()
    yield
    process.end_since(0)
    watcher.kill()


@pytest.fixture(autouse=True)
def leftovers(request: pytest.FixtureRequest) -> Iterator[None]:
    """Ends what a test that failed has left running."""
    count = len(process.ends)
    yield
    if request.node.nodeid in _failed:
        process.end_since(count)


@dataclasses.dataclass
class Check:
    """Checks steps of a test, each under its own sentence; the test goes on."""

    subtests: pytest.Subtests
    record_property: Callable[[str, object], None]

    def __call__(self, sentence: str, holds: object, measured: object = "") -> None:
        if measured != "":
            self.record_property(sentence, str(measured))
        with self.subtests.test(sentence):
            assert holds, f"{sentence}: {measured}"

    def in_time(self, sentence: str, delay: machine.Delay, limit: float) -> None:
        self.record_property(sentence, f"{delay}, at most {limit:g} s")
        with self.subtests.test(sentence):
            delay.judge(limit)


@pytest.fixture
def check(subtests: pytest.Subtests, record_property: Callable[[str, object], None]) -> Check:
    return Check(subtests, record_property)


@pytest.fixture(scope="class")
def folder(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> pathlib.Path:
    """A folder for the tests that share a run."""
    return tmp_path_factory.mktemp(re.sub(r"\W+", "-", request.node.name)[:30] or "tests")


@dataclasses.dataclass
class Clip:
    """The practice clip, its truth, and a box that lies within the hull at every heading of the boat."""

    video: pathlib.Path
    truth: list[dict[str, Any]]
    selection: str


@pytest.fixture(scope="session")
def clip(
    barrelman: pathlib.Path,
    tmp_path_factory: pytest.TempPathFactory,
    worker_id: str,
    pytestconfig: pytest.Config,
) -> Clip:
    base = tmp_path_factory.getbasetemp()
    where = pytestconfig.getoption("--clip") or (base if worker_id == "master" else base.parent) / "practice"
    # The first of the workers draws it.
    with where.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not where.exists():
            # Under another name until it is whole: the next call takes what is there.
            drawn = where.with_suffix(".part")
            shutil.rmtree(drawn, ignore_errors=True)
            done = process.run([barrelman, "demo", "--clip", "--draw-only", "--output", drawn], timeout=300)
            assert done.returncode == 0, f"the practice clip could not be drawn: {done.stderr}"
            drawn.rename(where)
    with (where / "truth.csv").open(newline="") as file:
        truth = [
            {name: float(value) if value else None for name, value in row.items()}
            for row in csv.DictReader(file)
        ]
    cx, cy = truth[0]["cx"] or 0.0, truth[0]["cy"] or 0.0
    return Clip(where / "practice.mp4", truth, f"{cx - 13:.0f},{cy - 13:.0f},26,26")


def skip(reason: str) -> None:
    """Skips what lacks something of the machine; in CI that is a failure."""
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


def shared(*parts: str) -> pathlib.Path:
    """A folder of the data beside the repository."""
    path = process.SHARED.joinpath(*parts)
    if not path.exists():
        skip(f"{path} is not there")
    return path


@pytest.fixture(scope="session")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[pathlib.Path, pathlib.Path, str]:
    """A certificate that nobody has signed, its key, and its SHA-256 fingerprint with colons."""
    folder = tmp_path_factory.mktemp("certificate")
    key, path = folder / "key.pem", folder / "certificate.pem"
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    made = process.run(
        ["openssl", "req", "-x509", *curve, "-keyout", key, "-out", path, "-days", "2", "-subj", "/CN=camera"]
    )
    assert made.returncode == 0, made.stderr
    print_of = process.run(["openssl", "x509", "-in", path, "-noout", "-fingerprint", "-sha256"])
    return path, key, print_of.stdout.split("=")[1].strip()
