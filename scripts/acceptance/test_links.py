"""Links of the console: shown for other devices, renewed, and the pages that opened them signed out.

Old tokens and cookies must open nothing, the file of the tokens and `barrelman links` must have the new ones,
the page that renews must stay, and no sign-out may move or stop anything by itself.
"""

import http.client
import json
import os
import pathlib
import time
from collections.abc import Iterator
from typing import Any

import cv2
import numpy
import pytest
import zxingcpp
from selenium.webdriver.common.by import By

from client import STOP, WORLD, Program, Request, Socket
from conftest import Check
from machine import poll, wait_until
from page import Page, axe_finds
from process import run, secret

pytestmark = pytest.mark.apart

OPTIONS = ["--video", WORLD, "--no-record"]
LINKS = "/api/v1/links"
CLOSES_WITHIN_S = 5.0


class Kept(Program):
    """A run with its tokens in a file, and its links in another."""

    def __init__(
        self, barrelman: pathlib.Path, folder: pathlib.Path, *options: Any, listen: str = "127.0.0.1:0"
    ) -> None:
        self.tokens, self.links = folder / "tokens", folder / "links"
        files = ["--console-token-file", self.tokens, "--links-file", self.links]
        super().__init__(barrelman, "run", *OPTIONS, *files, *options, listen=listen)
        self.read()

    def read(self) -> list[str]:
        """The tokens in the file, which are those of the next requests."""
        self.token, self.watch_token = self.tokens.read_text().split()
        return [self.token, self.watch_token]

    def link(self, token: str) -> str:
        return f"http://{self.host}/#token={token}"


@pytest.fixture
def program(barrelman: pathlib.Path, tmp_path: pathlib.Path) -> Iterator[Kept]:
    # Not 127.0.0.1: the page shows links for other devices.
    with Kept(barrelman, tmp_path, listen="127.0.0.2:0") as program:
        yield program


def test_renewed_links_end_the_old_ones(barrelman: pathlib.Path, program: Kept, check: Check) -> None:
    old = program.read()
    code, body, headers = program.ask("GET", LINKS)
    answered = json.loads(body)
    check("the links are shown", answered == {"control": program.link(old[0]), "watch": program.link(old[1])})
    check("no cache keeps them", headers["Cache-Control"] == "no-store", headers)
    for method, path in [("GET", LINKS), ("POST", LINKS), ("DELETE", "/api/v1/pages/0")]:
        code = program.ask(method, path, token=old[1])[0]
        check(f"{method} {path} needs the token for control", code == 403, code)
        check(f"{method} {path} needs a token", program.ask(method, path, token=None)[0] == 401)
    sockets = [Socket(program.host, token) for token in old]
    for connected in sockets:
        connected.until("hello")
    code, body, _ = program.ask("POST", LINKS)
    new = program.read()
    check("both tokens are new", code == 200 and not set(old) & set(new), code)
    check("the answer has the new links", json.loads(body)["control"] == program.link(new[0]))
    printed = run([barrelman, "links", "--file", program.links]).stdout
    check("`links` prints them", program.link(new[0]) in printed and old[0] not in printed, printed)
    for connected in sockets:
        check("sockets with old tokens end", connected.closes(CLOSES_WITHIN_S))
    for token in old:
        check("old tokens open nothing", program.ask("GET", "/api/v1/status", token=token)[0] == 401)
    check("the new one may control", program.request(Request("take-control"))["answer"] == "accepted")
    check("and the new one for watching stop", program.request(STOP, new[1])["answer"] == "accepted")
    keys = [event for event in events(program) if event == "links-renewed"]
    check("the event log says so", len(keys) == 1, keys)


def events(program: Kept) -> list[str]:
    connected = Socket(program.host, program.token)
    found = [event["key"] for event in connected.until("events")["events"]]
    connected.close()
    return found


def test_new_links_that_cannot_be_kept_hold_with_a_warning(program: Kept, check: Check) -> None:
    old = program.read()
    program.tokens.unlink()
    program.tokens.mkdir()
    code, body, _ = program.ask("POST", LINKS)
    answer = json.loads(body)
    check("the warning names the file", code == 200 and str(program.tokens) in answer["warning"], answer)
    check("the old token ends", program.ask("GET", "/api/v1/status", token=old[0])[0] == 401)
    new = answer["control"].split("token=")[1]
    check("the new one holds", program.ask("GET", "/api/v1/status", token=new)[0] == 200)


def test_old_tokens_are_renewed_and_open_pages_stay(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check
) -> None:
    # 7 seconds.
    with Kept(barrelman, tmp_path, "--token-ttl", "0.002") as program:
        old = program.read()
        connected = Socket(program.host, old[0])
        connected.until("hello")
        new = wait_until(lambda: program.read() if program.read() != old else None, "new tokens", pause=0.2)
        refused = wait_until(
            lambda: program.ask("GET", "/api/v1/status", token=old[0])[0] == 401, "a refusal"
        )
        check("old tokens open nothing", refused)
        check("new ones do", program.ask("GET", "/api/v1/status", token=new[1])[0] == 200)
        check("who is connected stays", not connected.closes(1.0))
    made_anew = program.tokens.stat().st_mtime - 3600
    os.utime(program.tokens, (made_anew, made_anew))
    with Kept(barrelman, tmp_path, "--token-ttl", "0.002") as later:
        check("tokens that got old meanwhile are not used", later.tokens.stat().st_mtime > made_anew)


def test_page_that_missed_a_renewal_is_offered_a_stop(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    # Renewed once, in 20 seconds: the cookie of before stops until the next renewal, an hour later.
    secret(tmp_path / "tokens", "control-of-an-hour-ago", "watch-of-an-hour-ago")
    nearly_too_old = time.time() - 3600 + 20
    os.utime(tmp_path / "tokens", (nearly_too_old, nearly_too_old))
    with Kept(barrelman, tmp_path, "--token-ttl", "1") as program:
        old = program.read()
        connection = http.client.HTTPConnection(program.host)
        connection.request("POST", "/api/v1/login", headers={"Authorization": f"Bearer {old[0]}"})
        name, value = (connection.getresponse().getheader("Set-Cookie") or "").split(";")[0].split("=")
        connection.close()
        with Page(f"http://{program.host}/", tmp_path) as page:
            # A page that connects with the cookie before the renewal keeps it.
            wait_until(lambda: page.element("entry").is_displayed(), "the question")
            page.driver.add_cookie({"name": name, "value": value})
            # The file has the new tokens a moment before they are in force.
            wait_until(
                lambda: program.ask("GET", "/api/v1/status", token=old[1])[0] == 401, "new tokens", pause=0.1
            )
            program.read()
            page.driver.get(f"http://{program.host}/")
            wait_until(lambda: page.element("entry-stop").is_displayed(), "the button")
            page.screenshots(pytestconfig.getoption("--screenshots"), "entry-stop")
            page.click("entry-stop")
            wait_until(lambda: page.text("entry-error") == "Stopped.", lambda: page.text("entry-error"))
        check("the program has stopped", program.status()["stops_taken"] == 1, program.status()["mode"])


def test_renewal_needs_a_file(barrelman: pathlib.Path, check: Check) -> None:
    options = ["--listen", "127.0.0.1:0", "--token-ttl", "1"]
    refused = run([barrelman, "run", *OPTIONS, *options])
    check("the run does not begin", refused.returncode == 1, refused.returncode)
    check("the error says what to give", "--console-token-file" in refused.stderr, refused.stderr)


def code_of(page: Page, name: str) -> str:
    """What a QR code of the dialog says, read from a picture of the page."""
    png = page.element(name).screenshot_as_png
    picture = cv2.imdecode(numpy.frombuffer(png, numpy.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    found = zxingcpp.read_barcodes(picture)
    return found[0].text if found else ""


def test_pages_are_signed_out(
    program: Kept, tmp_path: pathlib.Path, check: Check, pytestconfig: pytest.Config
) -> None:
    control, watch = program.read()
    with Page(program.link(control), tmp_path) as page, Page(program.link(watch), tmp_path, "other") as other:
        page.ready()
        other.ready()
        page.click("keys")
        page.click("devices")
        found = wait_until(lambda: code_of(page, "code-control"), "a QR code")
        check("the code is the link for control", found == program.link(control), found)
        check("the other is the one to watch", code_of(page, "code-watch") == program.link(watch))
        check("axe finds nothing serious", not (serious := axe_finds(page)), serious)
        page.screenshot(pytestconfig.getoption("--screenshots"), "other-devices")
        [button] = page.element("pages").find_elements(By.TAG_NAME, "button")
        button.click()
        wait_until(lambda: is_asked(other), "the form of the page that is signed out")
        check("no page is left", wait_until(lambda: page.element("no-pages").is_displayed(), "an empty list"))
        other.driver.get(program.link(watch))
        other.ready()
        page.click("new-links")
        wait_until(lambda: is_asked(other), "the form after new links")
        new = program.read()
        shown = wait_until(lambda: poll_code(page, program.link(new[0])), "the new code", pause=0.2)
        check("the new code is shown", shown)
        check("the page that renewed them stays", page.data["connected"] == "yes", page.data)
        complaints = page.complaints()
        check("the browser has nothing to complain about", not complaints, complaints)


def poll_code(page: Page, link: str) -> bool:
    return bool(poll(lambda: code_of(page, "code-control") == link, 1.0))


def is_asked(page: Page) -> bool:
    """Whether the page asks for a token."""
    return bool(page.script("return !document.getElementById('entry')?.hidden"))
