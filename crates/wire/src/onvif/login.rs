//! A user and a password, and the proof of both in a message (WS-Security, `UsernameToken` with a password
//! digest).

use core::fmt;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use quick_xml::escape::escape;
use sha1::{Digest as _, Sha1};

/// The type of the digest, as an attribute names it.
pub const PASSWORD_DIGEST: &str =
    "http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-username-token-profile-1.0#PasswordDigest";

/// A user and a password. `Debug` shows neither.
#[derive(Clone, PartialEq, Eq)]
pub struct Login {
    user: String,
    password: String,
}

impl Login {
    /// A login.
    pub const fn new(user: String, password: String) -> Self {
        Self { user, password }
    }

    /// The user.
    pub fn user(&self) -> &str {
        &self.user
    }

    /// The password.
    pub fn password(&self) -> &str {
        &self.password
    }

    /// The digest of the password: Base64 of SHA-1 over nonce, time and password.
    pub fn digest(&self, nonce: &[u8], created: &str) -> String {
        let hash = Sha1::new().chain_update(nonce).chain_update(created).chain_update(&self.password);
        STANDARD.encode(hash.finalize())
    }

    /// The header of a message, with a nonce that is used once and the camera's own time.
    pub fn security_header(&self, nonce: [u8; 16], created: &str) -> String {
        let (user, digest, nonce) =
            (escape(&self.user), self.digest(&nonce, created), STANDARD.encode(nonce));
        format!(
            "<wsse:Security s:mustUnderstand=\"1\" \
             xmlns:wsse=\"http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-wssecurity-secext-1.0.xsd\" \
             xmlns:wsu=\"http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-wssecurity-utility-1.0.xsd\">\
             <wsse:UsernameToken><wsse:Username>{user}</wsse:Username>\
             <wsse:Password Type=\"{PASSWORD_DIGEST}\">{digest}</wsse:Password>\
             <wsse:Nonce EncodingType=\"http://docs.oasis-open.org/wss/2004/01/\
             oasis-200401-wss-soap-message-security-1.0#Base64Binary\">{nonce}</wsse:Nonce>\
             <wsu:Created>{created}</wsu:Created></wsse:UsernameToken></wsse:Security>"
        )
    }
}

impl fmt::Debug for Login {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Login(***)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_specification() {
        // The example of ONVIF's Application Programmer's Guide, 6.1.1.3.
        let login = Login::new("user".to_owned(), "userpassword".to_owned());
        let nonce = STANDARD.decode("LKqI6G/AikKCQrN0zqZFlg==").unwrap();
        assert_eq!(login.digest(&nonce, "2010-09-16T07:50:45Z"), "tuOSpGlFlIXsozq4HFNeeGeFLEI=");
    }

    #[test]
    fn a_user_is_escaped_and_no_secret_is_shown() {
        let login = Login::new("a<b".to_owned(), "s3cret".to_owned());
        assert!(login.security_header([7; 16], "2026-01-01T00:00:00Z").contains("a&lt;b"));
        assert!(!format!("{login:?}").contains("s3cret"));
    }
}
