"""A certificate authority of its own, by OpenSSL, for servers and clients on loopback."""

import pathlib
import ssl
from typing import Any

from process import run

CURVE = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")


def openssl(*words: Any) -> None:
    made = run(["openssl", *words])
    assert made.returncode == 0, made.stderr


class Authority:
    """An authority, which signs certificates in its folder."""

    def __init__(self, folder: pathlib.Path) -> None:
        folder.mkdir()
        self.folder, self.path, self.key = folder, folder / "authority.pem", folder / "authority.key"
        subject = ("-subj", f"/CN={folder.name}", "-days", "2")
        openssl("req", "-x509", *CURVE, *subject, "-keyout", self.key, "-out", self.path)

    def issue(self, name: str) -> tuple[pathlib.Path, pathlib.Path]:
        """A certificate for a name or an IP address, and its key."""
        certificate, key, asked = (self.folder / f"{name}.{kind}" for kind in ("pem", "key", "request"))
        kind = "IP" if name[0].isdigit() else "DNS"
        names = ("-subj", "/CN=of the test", "-addext", f"subjectAltName={kind}:{name}")
        openssl("req", "-new", *CURVE, *names, "-keyout", key, "-out", asked)
        signed = ("-CA", self.path, "-CAkey", self.key, "-CAcreateserial", "-copy_extensions", "copy")
        openssl("x509", "-req", "-in", asked, *signed, "-days", "2", "-out", certificate)
        key.chmod(0o600)
        return certificate, key

    def server(self, name: str) -> ssl.SSLContext:
        """A server of this name, which takes clients that show a certificate of this authority."""
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(*self.issue(name))
        context.verify_mode = ssl.CERT_REQUIRED
        context.load_verify_locations(self.path)
        return context
