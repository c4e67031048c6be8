"""The console over HTTPS, on loopback by `--tls-on-loopback`: independent clients (Python's ssl,
Chromium)."""

import hashlib
import http.client
import pathlib
import socket
import ssl
import subprocess
from collections.abc import Iterator

import pytest

from client import WORLD, Program, ask
from conftest import Check
from machine import wait_until
from page import Page, installed
from process import run

RUN = ("run", "--no-record", "--video", WORLD, "--link", "sim:")
FINGERPRINT = "SHA-256 of its certificate authority: "


@pytest.fixture(scope="module", autouse=True)
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[pathlib.Path]:
    """The home of the user who runs the program and the browser."""
    home = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(home))
        patch.setenv("XDG_STATE_HOME", str(home / "states"))
        yield home


@pytest.fixture(scope="module")
def program(barrelman: pathlib.Path) -> Iterator[Program]:
    with Program(barrelman, *RUN, "--tls-on-loopback") as program:
        assert program.url.startswith("https://127.0.0.1:")
        yield program


@pytest.fixture(scope="module")
def authority(program: Program, home: pathlib.Path) -> pathlib.Path:
    """The authority, as a device downloads it that does not trust it yet."""
    unverified = ssl.create_default_context()
    unverified.check_hostname, unverified.verify_mode = False, ssl.CERT_NONE
    path = home / "authority.pem"
    path.write_bytes(fetch(program, unverified, "/authority.pem")[1])
    return path


def trusting(authority: pathlib.Path) -> ssl.SSLContext:
    return ssl.create_default_context(cafile=authority)


def fetch(
    program: Program, context: ssl.SSLContext, path: str, method: str = "GET", token: str = ""
) -> tuple[int, bytes, http.client.HTTPMessage]:
    connection = http.client.HTTPSConnection(program.host, timeout=15, context=context)
    connection.request(method, path, headers={"Authorization": f"Bearer {token}"} if token else {})
    answer = connection.getresponse()
    return answer.status, answer.read(), answer.headers


def shake_hands(program: Program, context: ssl.SSLContext, name: str = "127.0.0.1") -> str | None:
    """The version of TLS of a connection to the program under this name."""
    address, port = program.host.split(":")
    with (
        socket.create_connection((address, int(port)), timeout=15) as plain,
        context.wrap_socket(plain, server_hostname=name) as encrypted,
    ):
        return encrypted.version()


def test_authority_is_that_of_the_terminal_and_is_shown_without_a_token(
    barrelman: pathlib.Path, program: Program, authority: pathlib.Path, home: pathlib.Path, check: Check
) -> None:
    printed = program.lines.wait_for(FINGERPRINT)[1].rpartition(" ")[2]
    der = ssl.PEM_cert_to_DER_cert(authority.read_text())
    computed = hashlib.sha256(der).hexdigest().upper()
    check("the fingerprint is that of the authority", printed.replace(":", "") == computed, printed)
    context = trusting(authority)
    status, page, _ = fetch(program, context, "/trust")
    check("the page shows the fingerprint", status == 200 and printed in page.decode())
    _, installable, headers = fetch(program, context, "/authority.crt")
    check("phones install the file", headers["content-type"] == "application/x-x509-ca-cert")
    check("the file is the authority", installable == der)
    kept = home / "states/barrelman/console-authority.json"
    check("only its owner reads the key", kept.stat().st_mode & 0o777 == 0o600)
    with Program(barrelman, *RUN, "--tls-on-loopback") as again:
        check("the authority lasts", again.lines.wait_for(FINGERPRINT)[1].endswith(printed))


def test_device_that_trusts_the_authority_is_served(program: Program, authority: pathlib.Path) -> None:
    context = trusting(authority)
    assert fetch(program, context, "/api/v1/status")[0] == 401
    assert fetch(program, context, "/api/v1/status", token=program.token)[0] == 200
    cookie = fetch(program, context, "/api/v1/login", "POST", program.token)[2]["set-cookie"]
    assert cookie.endswith("; Secure")
    assert shake_hands(program, context) == "TLSv1.3"
    context.maximum_version = ssl.TLSVersion.TLSv1_2
    assert shake_hands(program, context, "localhost") == "TLSv1.2"


def test_certificate_is_refused_without_the_authority_and_by_a_wrong_name(
    program: Program, authority: pathlib.Path
) -> None:
    with pytest.raises(ssl.SSLCertVerificationError, match="self-signed certificate in certificate chain"):
        shake_hands(program, ssl.create_default_context())
    for name in ("evil.example", "192.0.2.7"):
        with pytest.raises(ssl.SSLCertVerificationError, match="mismatch"):
            shake_hands(program, trusting(authority), name)


# The constant is deprecated, which is what is tested.
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_tls_1_1_is_refused(program: Program, authority: pathlib.Path) -> None:
    context = trusting(authority)
    context.set_ciphers("ALL:@SECLEVEL=0")
    context.minimum_version = context.maximum_version = ssl.TLSVersion.TLSv1_1
    with pytest.raises(ssl.SSLError, match=r"alert (protocol version|handshake failure)"):
        shake_hands(program, context)


def test_request_without_tls_is_told_to_use_https(program: Program) -> None:
    status, body, headers = ask(program.host, "GET", "/", token=program.token)
    assert (status, headers["location"], headers["set-cookie"]) == (400, None, None)
    assert b"use https://" in body
    assert program.token.encode() not in body


@pytest.mark.parametrize("days", [2, -1], ids=["valid", "expired"])
def test_given_certificate_is_served_and_an_expired_one_is_refused(
    barrelman: pathlib.Path, tmp_path: pathlib.Path, days: int
) -> None:
    key, request, certificate = (tmp_path / name for name in ("key.pem", "request.pem", "certificate.pem"))
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", key]
    subject = ["-subj", "/CN=boat", "-addext", "subjectAltName=IP:127.0.0.1"]
    signed = ["-signkey", key, "-days", days, "-copy_extensions", "copy"]
    for command in (
        ["openssl", "req", "-new", *curve, *subject, "-out", request],
        ["openssl", "x509", "-req", "-in", request, *signed, "-out", certificate],
    ):
        made = run(command)
        assert made.returncode == 0, made.stderr
    with Program(barrelman, *RUN, "--tls-certificate", certificate, "--tls-key", key) as program:
        context = trusting(certificate)
        if days > 0:
            assert fetch(program, context, "/healthz")[:2] == (200, b"ok\n")
        else:
            program.errors.wait_for("has expired, or is not valid yet")
            with pytest.raises(ssl.SSLCertVerificationError, match="certificate has expired"):
                shake_hands(program, context)


class TestBrowser:
    @pytest.fixture(scope="class")
    def page(
        self, program: Program, authority: pathlib.Path, home: pathlib.Path, folder: pathlib.Path
    ) -> Iterator[Page]:
        with Page(program.url, folder, "stranger") as stranger:
            assert "ERR_CERT_AUTHORITY_INVALID" in stranger.driver.page_source
        store = home / ".pki/nssdb"
        store.mkdir(parents=True)
        certutil = [installed("certutil"), "-d", f"sql:{store}"]
        trusted = ["-A", "-n", "barrelman", "-t", "C,,", "-i", str(authority)]
        for words in (["-N", "--empty-password"], trusted):
            subprocess.run([*certutil, *words], check=True)
        with Page(program.url, folder) as page:
            page.ready()
            yield page

    def test_page_that_trusts_the_authority_has_the_rights_of_a_secure_one(self, page: Page) -> None:
        rights = page.script(
            "return [isSecureContext, typeof VideoDecoder, typeof navigator.wakeLock, location.protocol]"
        )
        assert rights == [True, "function", "object", "https:"]
        assert page.data["path"] in ("h264", "jpeg")
        assert page.complaints() == []

    def test_page_that_is_not_secure_says_that_the_screen_may_go_dark(self, page: Page) -> None:
        page.script("""
            Object.defineProperty(window, 'isSecureContext', { value: false });
            Object.defineProperty(navigator, 'wakeLock', { value: undefined })""")
        page.click_enabled("engage")
        wait_until(
            lambda: "screen may go dark: this page is not encrypted" in page.text("toast"), "the notice"
        )
        page.click("disengage")
