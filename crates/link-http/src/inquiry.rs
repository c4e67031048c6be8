//! Single questions, outside of a link: whether the vehicle is there, and what it says of itself.

use std::io;
use std::time::Duration;

use barrelman_link::port::PortError;

use crate::authorization::Authorization;
use crate::connection::{Asked, Connection, Connector};
use crate::runtime::LinkRuntime;
use crate::settings::HttpSettings;

/// Longest time of a question, after the connection.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);

/// A vehicle that questions are put to. Nothing is changed by asking.
pub(crate) struct Inquiry {
    runtime: LinkRuntime,
    connector: Connector,
}

impl Inquiry {
    pub(crate) fn new(settings: &HttpSettings, authorization: Authorization) -> Result<Self, PortError> {
        let fails = |error: io::Error| not_usable(settings, error.to_string());
        let runtime = LinkRuntime::new().map_err(fails)?;
        let connector = Connector::new(settings, authorization).map_err(fails)?;
        Ok(Self { runtime, connector })
    }

    /// The same vehicle with another proof of who asks.
    pub(crate) fn with(self, authorization: Authorization) -> Self {
        Self { connector: self.connector.with(authorization), ..self }
    }

    /// The answer's status and body.
    ///
    /// # Errors
    /// If there is none.
    pub(crate) fn ask(&self, asked: &Asked) -> io::Result<(u16, Vec<u8>)> {
        self.runtime.block_on(async {
            let mut connection = Connection::open(&self.connector).await?;
            let answer = connection.ask(&self.connector, asked);
            tokio::time::timeout(ANSWER_TIMEOUT, answer)
                .await
                .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
        })
    }

    pub(crate) fn into_parts(self) -> (LinkRuntime, Connector) {
        (self.runtime, self.connector)
    }
}

/// The vehicle at this address cannot be used, for this reason.
pub(crate) fn not_usable(settings: &HttpSettings, reason: String) -> PortError {
    PortError::NotUsable { address: settings.address.to_string(), reason }
}

/// An error in words, with its causes.
pub(crate) fn reason(error: &io::Error) -> String {
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
