//! How a vehicle is reached: its address, what proves that it is the right one, and what proves who asks.

use std::fmt;

use barrelman_link::url::HttpAddress;
use barrelman_vocab::ZoomRate;
use barrelman_wire::onvif::OnvifSettings;
use ring::digest::{SHA256, digest};

/// What a link needs to reach a vehicle.
#[derive(Debug, Clone)]
pub struct HttpSettings {
    /// The base address.
    pub address: HttpAddress,
    /// Whose certificates are accepted, where the address is encrypted.
    pub trust: Trust,
    /// What is spoken there.
    pub protocol: HttpProtocol,
}

/// A protocol of vehicles that answer requests over HTTP.
#[derive(Debug, Clone)]
pub enum HttpProtocol {
    /// The Fotokite Sigma's web API.
    FotokiteSigma(SigmaAccess),
    /// ONVIF.
    Onvif(OnvifSettings),
}

/// What a link to a Fotokite Sigma knows from the start.
#[derive(Debug, Clone)]
pub struct SigmaAccess {
    /// Proves who asks.
    pub credential: Credential,
    /// The name of the video that is used; `None`: the main one.
    pub stream: Option<String>,
    /// The rate of its zoom at the largest speed.
    pub full_zoom: ZoomRate,
}

/// Whose certificates are accepted. There is no way to accept any.
#[derive(Debug, Clone, Default)]
pub enum Trust {
    /// Those that a well-known authority has signed (Mozilla's list), for the name of the host.
    #[default]
    WellKnown,
    /// Those that an authority of this PEM file has signed, for the name of the host.
    Authorities(Vec<u8>),
    /// The one with this SHA-256 fingerprint, whatever its signature and its name.
    Fingerprint(Fingerprint),
}

/// The own certificate for a server that asks for one. `Debug` shows nothing of the key.
#[derive(Clone)]
pub struct ClientIdentity {
    /// The certificate, with those of the authorities above it (PEM).
    pub certificate: Vec<u8>,
    /// Its key (PEM).
    pub key: Vec<u8>,
}

impl fmt::Debug for ClientIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("ClientIdentity(***)")
    }
}

/// SHA-256 of a certificate (DER).
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint([u8; 32]);

impl Fingerprint {
    /// The fingerprint of a certificate.
    pub fn of(certificate: &[u8]) -> Self {
        let mut bytes = [0; 32];
        bytes.copy_from_slice(digest(&SHA256, certificate).as_ref());
        Self(bytes)
    }

    /// Reads 64 hexadecimal digits, with or without colons, as `openssl x509 -fingerprint -sha256` prints
    /// them.
    ///
    /// # Errors
    /// [`CredentialError::Fingerprint`].
    pub fn parse(text: &str) -> Result<Self, CredentialError> {
        let digits: Vec<u8> = text.trim().bytes().filter(|byte| *byte != b':').collect();
        let value = |digit: u8| char::from(digit).to_digit(16).map(|value| value as u8);
        let byte = |pair: &[u8]| Some(value(pair[0])? << 4 | value(pair[1])?);
        let bytes: Option<Vec<u8>> =
            (digits.len() == 64).then(|| digits.chunks_exact(2).map(byte).collect()).flatten();
        let bytes = bytes.and_then(|bytes| <[u8; 32]>::try_from(bytes).ok());
        bytes.map(Self).ok_or(CredentialError::Fingerprint)
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Proves who asks. `Debug` shows nothing of the secret.
#[derive(Clone, PartialEq, Eq)]
pub enum Credential {
    /// An access token.
    Token(String),
    /// An API key, for which the vehicle gives a token at each opening of the link.
    ApiKey(String),
}

/// The word before an API key in a token file.
const API_KEY: &str = "api-key";

impl Credential {
    /// Reads the content of a token file: its first line is an access token, or `api-key ` and an API key.
    ///
    /// # Errors
    /// [`CredentialError::Token`]. The message repeats nothing of the content.
    pub fn parse(content: &str) -> Result<Self, CredentialError> {
        let line = content.lines().next().unwrap_or_default().trim();
        let (is_key, secret) = match line.strip_prefix(API_KEY) {
            Some(key) if key.is_empty() || key.starts_with(' ') => (true, key.trim()),
            Some(_) | None => (false, line),
        };
        // What may stand in a header.
        let is_usable = !secret.is_empty() && secret.bytes().all(|byte| byte.is_ascii_graphic());
        if !is_usable {
            return Err(CredentialError::Token);
        }
        let secret = secret.to_owned();
        Ok(if is_key { Self::ApiKey(secret) } else { Self::Token(secret) })
    }
}

impl fmt::Debug for Credential {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Token(_) => "Token(***)",
            Self::ApiKey(_) => "ApiKey(***)",
        })
    }
}

/// A token file, a fingerprint or a file of authorities is not usable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CredentialError {
    /// The content is no token.
    #[error(
        "its first line is no token: write the access token, or `api-key ` and the API key, in one line without spaces"
    )]
    Token,
    /// The text is no fingerprint.
    #[error(
        "it is no SHA-256 fingerprint: give 64 hexadecimal digits, as `openssl x509 -noout -fingerprint -sha256` prints them"
    )]
    Fingerprint,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_file_holds_a_token_or_an_api_key() {
        assert_eq!(Credential::parse("abc.def\nmore\n"), Ok(Credential::Token("abc.def".to_owned())));
        assert_eq!(Credential::parse("api-key k1\n"), Ok(Credential::ApiKey("k1".to_owned())));
        for unusable in ["", "\n", "two words", "api-key ", "api-key a b", "t\u{f6}ken"] {
            assert_eq!(Credential::parse(unusable), Err(CredentialError::Token), "{unusable:?}");
        }
    }

    #[test]
    fn no_secret_is_shown() {
        let shown = format!("{:?}", [Credential::parse("s3cret"), Credential::parse("api-key s3cret")]);
        assert!(!shown.contains("s3cret"), "{shown}");
    }

    #[test]
    fn a_fingerprint_is_read_in_both_forms() {
        let plain = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        assert_eq!(Fingerprint::of(b"").to_string(), plain);
        let pairs: Vec<String> =
            plain.as_bytes().chunks(2).map(|pair| String::from_utf8_lossy(pair).to_uppercase()).collect();
        assert_eq!(Fingerprint::parse(&pairs.join(":")), Fingerprint::parse(plain));
        for unusable in ["", "e3", &plain[1..], "zz"] {
            assert_eq!(Fingerprint::parse(unusable), Err(CredentialError::Fingerprint));
        }
    }
}
