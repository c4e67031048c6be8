"""A run that starts before its vehicle: it says so, engages nothing, and goes on when the vehicle comes."""

import pathlib
import time

import pytest

from client import ENGAGE, WORLD, Program
from conftest import Check
from emulator import Emulator
from machine import poll
from process import free_port, guards_of, is_alive

pytestmark = pytest.mark.apart

GUARDS = [pytest.param((), id="guard"), pytest.param(("--without-guard",), id="no guard")]
PORTS = ["tcp", "serial"]


def address(folder: pathlib.Path, kind: str) -> tuple[str, str]:
    """Where the vehicle will be, and its URL."""
    host = f"127.0.0.1:{free_port()}"
    return (host, f"tcp://{host}") if kind == "tcp" else ("", f"serial:{folder / 'fotokite'}")


@pytest.mark.parametrize("guard", GUARDS)
@pytest.mark.parametrize("kind", PORTS)
def test_vehicle_that_comes_later_is_moved(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, kind: str, guard: tuple[str, ...]
) -> None:
    host, url = address(tmp_path, kind)
    with Program(barrelman, "run", "--no-record", "--video", WORLD, "--link", url, *guard) as program:
        program.errors.wait_for("the vehicle is not reached")
        program.wait_for_track()
        status = program.status()
        check("the link is being opened", status["link"]["state"] == "opening", status["link"])
        answer = program.request(ENGAGE)
        check("nothing engages", answer["answer"] == "refused" and "link not up" in answer["reason"], answer)
        with Emulator(barrelman, tmp_path, is_tcp=kind == "tcp", host=host) as emulator:
            program.wait(lambda status: status["link"]["state"] == "up", "the link")
            check("nothing engages by itself", program.status()["mode"]["name"] != "servoing")
            check("zeros came first", not any(row.moves for row in emulator.heard()))
            answer = program.request(ENGAGE)
            check("now it engages", answer["answer"] == "accepted", answer)
            emulator.wait_until_it_moves()
            check("the run ends well", program.end() == 0, program.errors.text()[-300:])
            check("at rest", not any(emulator.rows()[-1].rates))


@pytest.mark.parametrize("guard", GUARDS)
@pytest.mark.parametrize("kind", PORTS)
def test_run_ends_well_though_no_vehicle_came(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, kind: str, guard: tuple[str, ...]
) -> None:
    _, url = address(tmp_path, kind)
    with Program(barrelman, "run", "--no-record", "--video", WORLD, "--link", url, *guard) as program:
        program.errors.wait_for("the vehicle is not reached")
        guards = guards_of(program.child.pid)
        check("a guard waits, where there is one", len(guards) == (not guard), guards)
        began = time.monotonic()
        check("the run ends well", program.end() == 0, program.errors.text()[-300:])
        check("at once: there is nothing to stop", time.monotonic() - began < 5, time.monotonic() - began)
        check("no guard stays", poll(lambda: not any(map(is_alive, guards)), 5))
