//! Single questions, outside of a link: whether the vehicle is there, a token for an API key, what `check` asks.

use std::io;
use std::time::Duration;

use barrelman_link::port::PortError;
use hyper::Method;

use crate::connection::{Asked, Connection, Connector};
use crate::runtime::LinkRuntime;
use crate::settings::{Credential, HttpSettings};

/// Longest time of a question, after the connection.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);
/// How the token is named in the vehicle's list.
const TOKEN_NAME: &str = "Barrelman";

/// A vehicle that was reached, with a token.
pub struct Inquiry {
    runtime: LinkRuntime,
    connector: Connector,
    token: String,
}

impl Inquiry {
    /// Reaches the vehicle, and gets a token where the credential is an API key. The token itself is not tried.
    ///
    /// # Errors
    /// If the vehicle cannot be reached, its certificate is not accepted, or the API key is refused.
    pub fn open(settings: &HttpSettings) -> Result<Self, PortError> {
        let fails = |reason: String| PortError::NotUsable { address: settings.address.to_string(), reason };
        let runtime = LinkRuntime::new().map_err(|error| fails(error.to_string()))?;
        let connector = Connector::new(settings).map_err(|error| fails(error.to_string()))?;
        let mut inquiry = Self { runtime, connector, token: String::new() };
        let unreachable = |error: io::Error| fails(reason(&error));
        inquiry.get("/v1/health").map_err(unreachable)?;
        inquiry.token = match &settings.credential {
            Credential::Token(token) => token.clone(),
            Credential::ApiKey(key) => inquiry.token_for(key).map_err(fails)?,
        };
        Ok(inquiry)
    }

    /// The answer to a reading request: status and body.
    ///
    /// # Errors
    /// If there is none.
    pub fn get(&self, path: &str) -> io::Result<(u16, Vec<u8>)> {
        self.ask(Asked { method: Method::GET, path: path.to_owned(), body: None })
    }

    /// The token.
    pub(crate) fn into_parts(self) -> (LinkRuntime, Connector, String) {
        (self.runtime, self.connector, self.token)
    }

    fn ask(&self, asked: Asked) -> io::Result<(u16, Vec<u8>)> {
        self.runtime.block_on(async {
            let mut connection = Connection::open(&self.connector).await?;
            let answer = connection.ask(&self.connector, &self.token, asked);
            tokio::time::timeout(ANSWER_TIMEOUT, answer)
                .await
                .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
        })
    }

    fn token_for(&self, key: &str) -> Result<String, String> {
        let body = serde_json::json!({
            "grant_type": "client_credentials", "client_secret": key, "scope": "read control",
            "token_name": TOKEN_NAME,
        });
        let path = "/v1/auth/token/request".to_owned();
        let asked = Asked { method: Method::POST, path, body: Some(body.to_string()) };
        let (status, body) = self.ask(asked).map_err(|error| reason(&error))?;
        let token = || {
            let body: serde_json::Value = serde_json::from_slice(&body).ok()?;
            let token = body.get("access_token")?.as_str()?.to_owned();
            Credential::parse(&token).is_ok().then_some(token)
        };
        match status {
            200 | 201 => token().ok_or_else(|| "the answer to the API key holds no token".to_owned()),
            401 => Err("the API key is not known (401): put the right one into the token file".to_owned()),
            403 => Err(
                "the API key gives no token for reading and control (403): permit both on the vehicle's tablet"
                    .to_owned(),
            ),
            status => Err(format!("the vehicle gives no token (status {status})")),
        }
    }
}

/// An error in words, with its causes.
fn reason(error: &io::Error) -> String {
    let mut text = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(cause) = source {
        let cause_text = cause.to_string();
        if !text.contains(&cause_text) {
            text = format!("{text}: {cause_text}");
        }
        source = cause.source();
    }
    match error.kind() {
        io::ErrorKind::TimedOut => format!("no answer in {} s: is the vehicle on?", ANSWER_TIMEOUT.as_secs()),
        io::ErrorKind::ConnectionRefused => format!("{text}: is this the vehicle's address and port?"),
        _ => text,
    }
}
