//! The server's end of HTTP's digest (RFC 7616, MD5, `qop=auth`).

use barrelman_wire::onvif::Login;
use http_auth::ParamValue;
use md5::{Digest as _, Md5};

/// The realm of the challenge.
const REALM: &str = "emulated camera";
/// The nonce: always the same, as the emulator has no secrets.
const NONCE: &str = "8f3a5c1d9e7b2046";

/// The challenge, as the header `WWW-Authenticate` states it.
pub(crate) fn challenge() -> String {
    format!("Digest realm=\"{REALM}\", qop=\"auth\", nonce=\"{NONCE}\", algorithm=MD5")
}

/// Whether a header `Authorization` proves the login for this request.
pub(crate) fn proves(header: &str, login: &Login, method: &str, path: &str) -> bool {
    let Ok(parsed) = http_auth::parse_challenges(header) else { return false };
    let Some(digest) = parsed.first().filter(|one| one.scheme.eq_ignore_ascii_case("Digest")) else {
        return false;
    };
    let value = |name: &str| {
        let named = digest.params.iter().find(|(key, _)| key.eq_ignore_ascii_case(name));
        named.map(|(_, value)| ParamValue::to_unescaped(value)).unwrap_or_default()
    };
    let secret = hex(&[login.user(), REALM, login.password()]);
    let request = hex(&[method, path]);
    let expected = hex(&[&secret, NONCE, &value("nc"), &value("cnonce"), "auth", &request]);
    value("username") == login.user()
        && value("nonce") == NONCE
        && value("uri") == path
        && value("response") == expected
}

/// MD5 of the parts with colons between them, in hexadecimal digits.
fn hex(parts: &[&str]) -> String {
    Md5::digest(parts.join(":")).iter().map(|byte| format!("{byte:02x}")).collect()
}
