//! Messages: envelopes of SOAP 1.2.

use serde::Deserialize;
use serde::de::DeserializeOwned;

/// An envelope around a body, with a header where there is one.
pub fn envelope(header: &str, body: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\
         <s:Envelope xmlns:s=\"http://www.w3.org/2003/05/soap-envelope\">\
         <s:Header>{header}</s:Header><s:Body>{body}</s:Body></s:Envelope>"
    )
}

#[derive(Deserialize)]
struct Envelope<B> {
    #[serde(rename = "Body")]
    body: B,
}

/// The body of a message; `None`: it is not what was expected. Elements that are not known are ignored, and
/// so are prefixes.
pub fn read<B: DeserializeOwned>(message: &[u8]) -> Option<B> {
    let text = core::str::from_utf8(message).ok()?;
    quick_xml::de::from_str::<Envelope<B>>(text.trim_start_matches('\u{feff}')).ok().map(|read| read.body)
}
