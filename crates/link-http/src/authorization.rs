//! What proves to a vehicle who asks.

use std::sync::Arc;

use barrelman_wire::http::Method;
use barrelman_wire::onvif::Login;
use http_auth::{DigestClient, PasswordParams};
use hyper::header::{HeaderMap, WWW_AUTHENTICATE};

/// What proves who asks.
#[derive(Clone)]
pub(crate) enum Authorization {
    /// Nothing.
    None,
    /// A token, in each request.
    Bearer(Arc<str>),
    /// A login, by digest, once the vehicle has asked for it. The password is never sent.
    Digest(Login),
}

/// The answers to a challenge (RFC 7616).
pub(crate) struct Digest {
    client: DigestClient,
    login: Login,
}

impl Digest {
    /// Reads the challenge of an answer; `None`: there is none that can be met without showing the password.
    pub(crate) fn begin(login: &Login, headers: &HeaderMap) -> Option<Self> {
        let challenges = headers.get_all(WWW_AUTHENTICATE).iter().filter_map(|value| value.to_str().ok());
        let mut parsed = challenges.flat_map(|text| http_auth::parse_challenges(text).unwrap_or_default());
        let client = parsed.find_map(|challenge| DigestClient::try_from(&challenge).ok())?;
        Some(Self { client, login: login.clone() })
    }

    /// The header of the next request.
    pub(crate) fn proof(&mut self, method: Method, path: &str) -> Option<String> {
        self.client
            .respond(&PasswordParams {
                username: self.login.user(),
                password: self.login.password(),
                uri: path,
                method: method.name(),
                body: None,
            })
            .ok()
    }
}
