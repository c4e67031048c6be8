//! How a Fotokite Sigma is reached: whether it is there, a token for an API key, what it says of itself.

pub mod facts;
mod token;

use std::io;

use barrelman_link::port::PortError;
use barrelman_wire::fotokite_sigma::call::Call;
use barrelman_wire::http::{HttpCall, Method};

use crate::authorization::Authorization;
use crate::connection::Asked;
use crate::inquiry::{Inquiry, not_usable, reason};
use crate::settings::{Credential, HttpSettings};

/// A Sigma that was reached, with a token.
pub struct Sigma(Inquiry);

impl Sigma {
    /// Reaches the vehicle, and gets a token where the credential is an API key. The token itself is not
    /// tried.
    ///
    /// # Errors
    /// If the vehicle cannot be reached, its certificate is not accepted, or the API key is refused.
    pub fn reach(settings: &HttpSettings, credential: &Credential) -> Result<Self, PortError> {
        reach(settings, credential).map(Self)
    }
}

pub(crate) fn reach(settings: &HttpSettings, credential: &Credential) -> Result<Inquiry, PortError> {
    let fails = |reason: String| not_usable(settings, reason);
    let inquiry = Inquiry::new(settings, Authorization::None)?;
    get(&inquiry, "/v1/health").map_err(|error| fails(reason(&error)))?;
    let token = match credential {
        Credential::Token(token) => token.clone(),
        Credential::ApiKey(key) => token::token_for(&inquiry, key).map_err(fails)?,
    };
    Ok(inquiry.with(Authorization::Bearer(token.into())))
}

/// The answer to a reading request: status and body.
fn get(inquiry: &Inquiry, path: &str) -> io::Result<(u16, Vec<u8>)> {
    let (path, content_type) = (path.to_owned(), Call::CONTENT_TYPE);
    inquiry.ask(&Asked { method: Method::Get, path, content_type, body: None })
}
